# SPDX-License-Identifier: Apache-2.0
"""Run fuzz targets on their kept corpus: first every kept input, then new ones for a time, two targets at
once.

New inputs are drawn for a number of seconds, or, with a seed, follow from it: then their number is fixed
(runs.txt has that of 20 s of each target), the time only bounds the run on a slow machine, and two runs do the
same.

Prints one line for each target (runs, runs a second, features, new units) and `N passed, M failed`. Failing
inputs are kept under build/fuzz/found/<target>/, with the command that repeats the failure."""

import argparse
import concurrent.futures
import functools
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path("test/fuzz")
BUILT = pathlib.Path("build/fuzz/target")
FOUND = pathlib.Path("build/fuzz/found")
# Files that are inputs without change.
VECTORS = {"subsystem_descriptor": "descriptors/subsystems", "mission_descriptor": "descriptors/missions",
           "eds": "descriptors/devices", "scenario": "sim/scenarios", "world": "descriptors/worlds", "xml": "descriptors/missions"}
RUNS = HERE / "runs.txt"  # `target runs`, counted by --calibrate.
CALIBRATED_SECONDS = 20
INPUT_SECONDS = 25
ENGINE = [f"-timeout={INPUT_SECONDS}", "-rss_limit_mb=2048", "-print_final_stats=1", "-verbosity=1"]
ENVIRONMENT = {"ASAN_OPTIONS": "detect_stack_use_after_return=1:allocator_may_return_null=1",
               "UBSAN_OPTIONS": "print_stacktrace=1"}


def targets():
    return sorted(path.stem.removeprefix("fuzz_") for path in HERE.glob("fuzz_*.c"))


def kept(target):
    """Folders of a target's kept inputs: inputs with coverage, and inputs that once failed."""
    folders = [HERE / "corpus" / target, HERE / "regression" / target]
    return [str(folder) for folder in folders if folder.is_dir()]


def vectors(target):
    return [VECTORS[target]] if target in VECTORS else []


def run(target, arguments, seconds_allowed, before=()):
    """(exit code, output) of one call of a target, with the words `before` before the command."""
    command = [*before, str(BUILT / target), *arguments]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=seconds_allowed, env=dict(os.environ, **ENVIRONMENT))
        return done.returncode, done.stdout.decode(errors="replace")
    except FileNotFoundError:
        return 1, f"{BUILT / target} did not build"
    except subprocess.TimeoutExpired as late:
        return 1, (late.stdout or b"").decode(errors="replace") + f"\nended after {seconds_allowed} s"


@functools.cache
def fixed_places():
    """Words before a command that fix its addresses, because the engine learns from compared values, which
    include addresses. None if the machine does not permit it."""
    words = ["setarch", "--addr-no-randomize"]
    try:
        return words if subprocess.run([*words, "true"], stderr=subprocess.DEVNULL).returncode == 0 else []
    except FileNotFoundError:
        return []


def files_of(folders):
    return sorted(str(path) for folder in folders for path in pathlib.Path(folder).iterdir())


def replay(target):
    """Run all kept inputs once. Returns (exit code, output)."""
    return run(target, [*ENGINE, *files_of(kept(target) + vectors(target))], 300)


def fuzz(target, seconds, seed, runs=None):
    """(exit code, output) of new inputs. The kept corpus is read, never written; `seed` 0 is a new one each time.

    With a number of runs everything starts from the same files in the same order, without the findings of earlier
    runs. After one and a half times the time the run ends: that is no failure."""
    found = FOUND / target
    fresh = pathlib.Path("build/fuzz", "fixed" if runs else "corpus", target)
    if runs:
        shutil.rmtree(fresh, ignore_errors=True)
    found.mkdir(parents=True, exist_ok=True)
    fresh.mkdir(parents=True, exist_ok=True)
    arguments = [*ENGINE, f"-seed={seed}", f"-artifact_prefix={found}/"]
    if runs:
        listed = fresh.with_suffix(".txt")
        listed.write_text(",".join(files_of(kept(target) + vectors(target))))
        arguments += [f"-runs={runs}", f"-max_total_time={seconds * 3 // 2}", "-reload=0", f"-seed_inputs=@{listed}",
                      str(fresh)]
    else:
        arguments += [f"-max_total_time={seconds}", str(fresh), *kept(target), *vectors(target)]
    return run(target, arguments, seconds * 3 // 2 + 120, fixed_places() if runs else ())


def number(pattern, output):
    found = re.findall(pattern, output)
    return int(found[-1]) if found else 0


def line_of(target, code, output):
    features = number(r"\bft: (\d+)", output)
    word = "passed" if code == 0 else "FAILED"
    return (f"{target:22} {word}  {number(r'number_of_executed_units: *([0-9]+)', output):9} runs "
            f"{number(r'average_exec_per_sec: *([0-9]+)', output):7} a second {features:6} features "
            f"{number(r'new_units_added: *([0-9]+)', output):5} new units")


def explain(target, output):
    """The end of a failing target's output, and the command that repeats the failure."""
    text = "\n".join("    " + line for line in output.splitlines()[-40:])
    artifact = re.search(r"Test unit written to (\S+)", output)
    if artifact:
        text += (f"\n  to see it again:      build/fuzz/target/{target} {artifact[1]}"
                 f"\n  keep it with its fix: cp {artifact[1]} test/fuzz/regression/{target}/")
    return text


def judge(target, seconds, seed):
    code, output = replay(target)
    if code == 0 and seconds > 0:
        code, output = fuzz(target, seconds, seed, fixed_runs(target, seconds) if seed else None)
    return target, code, output


def counted_runs():
    lines = [line.split() for line in RUNS.read_text().splitlines() if line and line[0] != "#"] if RUNS.exists() else []
    return {name: int(runs) for name, runs in lines}


def fixed_runs(target, seconds):
    """Number of inputs that take about this many seconds; None if it was not counted."""
    runs = counted_runs().get(target)
    return max(1, runs * seconds // CALIBRATED_SECONDS) if runs else None


def calibrate(names):
    """Count the runs of each target in its processor time, independent of other load, and write the number in
    two digits."""
    counted = counted_runs()
    for name in names:
        before = sum(os.times()[2:4])
        _, output = fuzz(name, CALIBRATED_SECONDS // 2, 1, sys.maxsize)
        rate = number(r"number_of_executed_units: *([0-9]+)", output) / (sum(os.times()[2:4]) - before)
        counted[name] = max(1, int(float(f"{rate * CALIBRATED_SECONDS:.1e}")))
        print(name, counted[name], flush=True)
    RUNS.write_text("# Inputs of each target in 20 s of processor time, kept ones included, as run_fuzz.py --calibrate counted them.\n"
                    + "".join(f"{name} {runs}\n" for name, runs in sorted(counted.items())))


def judge_all(names, seconds, seed, jobs):
    """Yields (target, exit code, output) as they end."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = [pool.submit(judge, name, seconds, seed) for name in names]
        for done in concurrent.futures.as_completed(runs):
            yield done.result()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=20, help="new inputs for each target; 0: kept inputs only")
    parser.add_argument("--seed", type=int, default=0, help="of the new inputs; 0: another each time")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--calibrate", action="store_true", help="count runs anew and write runs.txt")
    parser.add_argument("targets", nargs="*", default=targets())
    arguments = parser.parse_args()
    if arguments.calibrate:
        calibrate(arguments.targets)
        return 0
    failed = 0
    for target, code, output in judge_all(arguments.targets, arguments.seconds, arguments.seed, arguments.jobs):
        print(line_of(target, code, output), flush=True)
        if code != 0:
            failed += 1
            print(explain(target, output), flush=True)
    print(f"{len(arguments.targets) - failed} passed, {failed} failed")
    return 1 if failed or not arguments.targets else 0


if __name__ == "__main__":
    sys.exit(main())
