# SPDX-License-Identifier: Apache-2.0
"""Each fuzz target passes its kept inputs, which include every input that has ever failed, and then new inputs
for about 2 s. The number of new inputs is fixed, not the time: it is a tenth of the number in runs.txt, which
`run_fuzz.py --calibrate` counts in 20 s. The new inputs are made from the kept ones with a fixed seed, so every
machine tries the same inputs, and a defect is found with the change that causes it. A slow machine stops after
3 s, before it has tried all of them. `make fuzz` and `make check-full` try other inputs, for a given time."""

import concurrent.futures
import os
import subprocess

import pytest
import run_fuzz

# All targets, two at a time, take about 20 s; `make check-full` gives each target five minutes.
SECONDS = int(os.environ.get("FUZZ_SECONDS", "2"))
SEED = 1


@pytest.fixture(scope="session")
def outcomes():
    with concurrent.futures.ThreadPoolExecutor(min(2, len(os.sched_getaffinity(0)))) as pool:
        runs = {name: pool.submit(run_fuzz.judge, name, SECONDS, SEED) for name in run_fuzz.targets()}
        yield runs


@pytest.mark.parametrize("target", run_fuzz.targets())
def test_a_target_passes_its_inputs(outcomes, target):
    _, code, output = outcomes[target].result()
    print(run_fuzz.line_of(target, code, output))
    assert code == 0, run_fuzz.explain(target, output)


@pytest.mark.parametrize("target", run_fuzz.targets())
def test_a_corpus_is_kept(target):
    assert run_fuzz.kept(target), f"no inputs under test/fuzz/corpus/{target}"


@pytest.mark.parametrize("target", run_fuzz.targets())
def test_the_runs_of_each_target_are_counted(target):
    assert run_fuzz.fixed_runs(target, SECONDS), f"{target} is not in {run_fuzz.RUNS}: run_fuzz.py --calibrate"


def test_kept_inputs_are_small():
    for kind in ("corpus", "regression"):
        for target in (run_fuzz.HERE / kind).iterdir():
            assert sum(path.stat().st_size for path in target.iterdir()) < 32 * 1024, target


@pytest.mark.parametrize("hours, said", [("0.5", "--seconds 1800"), ("two", "HOURS=two: expected a number of hours")])
def test_the_time_may_be_given_in_hours(hours, said):
    done = subprocess.run(["make", "--no-print-directory", "-n", "fuzz", "ONLY=text", f"HOURS={hours}"], capture_output=True, text=True)
    assert said in done.stdout + done.stderr
