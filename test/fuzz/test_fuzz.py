# SPDX-License-Identifier: Apache-2.0
"""Every fuzz target passes its kept inputs in the build with sanitizers. They include each input on which a target has failed. `make fuzz`
and `make check-full` try new inputs, with an engine that follows the coverage."""

import pathlib
import subprocess

import pytest
import run_fuzz

BUILT = pathlib.Path("build/sanitize/kept-inputs")
SECONDS_ALLOWED = 600


@pytest.mark.parametrize("target", run_fuzz.targets())
def test_a_target_passes_its_kept_inputs(target):
    code, output = run_fuzz.run(BUILT / target, run_fuzz.kept_inputs(target), SECONDS_ALLOWED)
    assert code == 0, output[-4000:]


def test_an_input_that_cannot_be_read_fails():
    code, output = run_fuzz.run(BUILT / "text", ["no such file"], SECONDS_ALLOWED)
    assert (code, output) == (2, "no such file: cannot be read\n")


@pytest.mark.parametrize("target", run_fuzz.targets())
def test_a_corpus_is_kept(target):
    assert run_fuzz.kept(target), f"no inputs under test/fuzz/corpus/{target}"


def test_kept_inputs_are_small():
    for kind in ("corpus", "regression"):
        for target in (run_fuzz.HERE / kind).iterdir():
            assert sum(path.stat().st_size for path in target.iterdir()) < 32 * 1024, target


@pytest.mark.parametrize("hours, expected", [("0.5", "--seconds 1800"), ("two", "HOURS=two: expected a number of hours")])
def test_the_time_may_be_given_in_hours(hours, expected):
    done = subprocess.run(["make", "--no-print-directory", "-n", "fuzz", "ONLY=text", f"HOURS={hours}"], capture_output=True, text=True)
    assert expected in done.stdout + done.stderr
