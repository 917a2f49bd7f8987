# SPDX-License-Identifier: Apache-2.0
"""The test runner counts what the runners under it say, and never takes a broken program for a good one."""

import os
import pathlib
import subprocess

import pytest
import run_tests

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    "output, code, expected",
    [
        ("a.c:1:x:PASS\n\n---\n12 Tests 0 Failures 2 Ignored \nOK\n", 0, (10, 0, 2)),
        ("3 Tests 1 Failures 0 Ignored \nFAIL\n", 1, (2, 1, 0)),
        ("[==========] 4 test(s) run.\n[  PASSED  ] 4 test(s).\n", 0, (4, 0, 0)),
        ("[  PASSED  ] 2 test(s).\n[  FAILED  ] 1 test(s), listed below:\n[  FAILED  ] x\n\n 1 FAILED TEST(S)\n", 1, (2, 1, 0)),
        ("[  PASSED  ] 1 test(s).\n[  SKIPPED ] 1 test(s), listed below:\n", 0, (1, 0, 1)),
        ("[  PASSED  ] 1 test(s).\n[  PASSED  ] 2 test(s).\n", 0, (3, 0, 0)),
        ("12 Tests 0 Failures 0 Ignored \nOK\n==1==ERROR: LeakSanitizer\n", 23, (12, 1, 0)),
        ("", -11, (0, 1, 0)),
        ("", 0, (1, 0, 0)),
    ],
)
def test_count(output, code, expected):
    count = run_tests.count_cases(output, code)
    assert (count.passed, count.failed, count.skipped) == expected


def test_a_program_that_was_not_built_fails(tmp_path):
    _, count, output, _ = run_tests.run_program(str(tmp_path / "absent"))
    assert (count.passed, count.failed) == (0, 1) and "did not build" in output


def test_a_program_that_hangs_fails(tmp_path, monkeypatch):
    program = tmp_path / "hangs"
    program.write_text("#!/bin/sh\necho begun\nexec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setattr(run_tests, "SECONDS_ALLOWED", 5)
    _, count, output, _ = run_tests.run_program(str(program))
    assert count.failed == 1 and "begun" in output and "ended after" in output


def test_a_program_that_computes_for_ever_fails(tmp_path, monkeypatch):
    program = tmp_path / "computes"
    program.write_text("#!/bin/sh\necho begun\nwhile :; do :; done\n")
    program.chmod(0o755)
    monkeypatch.setattr(run_tests, "PROCESSOR_SECONDS_ALLOWED", 1)
    _, count, output, _ = run_tests.run_program(str(program))
    assert count.failed == 1 and "begun" in output and "exit code -" in output


@pytest.mark.parametrize(
    "words, said",
    [
        (("help", "ONLYX=pus"), "ONLYX=pus: there is no such option; there are: ALL "),
        (("sim-run", "SEEED=2"), "SEEED=2: there is no such option"),
        (("fuzz", "ONLY=nothing"), "ONLY=nothing: no fuzz target has this in its name; there are: "),
        (("coverage", "ONLY=nothing"), "ONLY=nothing: no C unit test has this in its path"),
        (("test-hil", "PLACE=moon"), "PLACE=moon: expected vm or kernel"),
        (("test-hil", "ONLY=nothing"), "no test in test/hil has 'nothing' in its path"),
    ],
)
def test_make_refuses_what_it_does_not_know(words, said):
    """A slip of the pen neither does what was not meant nor passes for nothing done."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    done = subprocess.run(["make", "--dry-run", *words], cwd=ROOT, env=kept, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert said in done.stderr


def test_make_knows_every_option_that_its_help_names():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    known = makefile.partition("\nOPTIONS := ")[2].partition("\nifeq")[0].split()
    helped = "\n".join(line for line in makefile.splitlines() if line.startswith("## "))
    named = {word.partition("=")[0] for word in helped.split() if word.partition("=")[1] and word.partition("=")[0].isupper()}
    assert len(named) > 20 and named <= set(known)


def test_a_measurement_that_is_not_there_does_not_pass(tmp_path):
    words = [ROOT / "build/venv/bin/python", ROOT / "test/bench/run_bench.py", "--only", "nothing", "--check", "--out", tmp_path / "bench.json"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "no measurement has this in its path" in done.stderr
