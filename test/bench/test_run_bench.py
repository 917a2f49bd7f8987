# SPDX-License-Identifier: Apache-2.0
"""`make bench` builds what it runs. A measuring program that is missing or fails gives a message, never a stack trace."""

import os
import pathlib
import subprocess
import sys

import failures
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(script, directory, *options):
    """Run a script of test/bench in a directory; it must fail. Returns what it prints."""
    done = subprocess.run([sys.executable, ROOT / "test/bench" / script, *options], cwd=directory, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "Traceback" not in done.stderr, done.stderr
    return done.stdout + done.stderr


def program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def test_make_builds_the_programs_that_a_selected_script_runs():
    kept = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    words = ["make", "--print-data-base", "--dry-run", "help", "ONLY=mission"]
    known = subprocess.run(words, cwd=ROOT, env=kept, capture_output=True, text=True, check=True).stdout
    built = next(line for line in known.splitlines() if line.startswith("benches:")).split()
    assert {"build/bench/bench_plant", "build/bench/bench_futex_ring"} <= set(built)
    assert "build/bench/bench_codec" not in built


def test_a_missing_measurement_does_not_pass(tmp_path):
    assert "no measurement has this in its path" in run("run_bench.py", ROOT, "--only", "nothing", "--check", "--out", tmp_path / "bench.json")


def test_a_measuring_program_that_is_not_built_is_reported(tmp_path):
    (tmp_path / "test/bench").mkdir(parents=True)
    (tmp_path / "test/bench/bench_absent.c").touch()
    (tmp_path / "test/bench/bench_failing.c").touch()
    program(tmp_path / "build/bench/bench_failing", "exit 3")
    printed = run("run_bench.py", tmp_path)
    assert "build/bench/bench_absent does not exist: `make bench` builds it" in printed
    assert "build/bench/bench_failing ended with exit code 3" in printed


def test_rows_of_a_run_that_was_not_made_are_reported(tmp_path):
    assert "bench.json does not exist: run `make bench` first" in run("run_bench.py", tmp_path, "--reuse")


@pytest.mark.parametrize("script, missing", [("bench_mission.py", "build/bench/bench_plant"), ("bench_report.py", "build/bin/hirosco"),
                                             ("bench_size.py", "fsw/framework")])
def test_a_script_without_the_files_that_it_needs_names_the_missing_one(tmp_path, script, missing):
    assert f"{missing} does not exist: `make bench` builds" in run(script, tmp_path)


@pytest.mark.parametrize("plant, flight, said", [
    ("exit 3", "", "build/bench/bench_plant ended with exit code 3, expected 0"),
    ("echo measured nothing", "", "build/bench/bench_plant has printed no line BENCH plant_step_us"),
    ("echo BENCH plant_step_us 5.0 us -", "exit 4", "--form image --report no --out runs/bench-rokviss-image-0 ended with exit code 4, expected 0")])
def test_a_script_whose_program_fails_names_the_command(tmp_path, plant, flight, said):
    program(tmp_path / "build/bench/bench_plant", plant)
    program(tmp_path / "build/bin/hirosco", flight)
    assert said in run("bench_mission.py", tmp_path)


def test_a_false_assertion_without_a_message_is_shown_as_its_source_line():
    def measure():
        raise AssertionError

    with pytest.raises(SystemExit, match=r"test_run_bench.py:\d+: raise AssertionError"):
        failures.run(measure)
