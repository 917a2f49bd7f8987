# SPDX-License-Identifier: Apache-2.0
"""Run fuzz targets on their kept corpus: first every kept input, then new ones for a time, two targets at
once.

Prints one line for each target (runs, runs a second, features, new units) and `N passed, M failed`. Failing
inputs are kept under build/fuzz/found/<target>/, with the command that repeats the failure."""

import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path("test/fuzz")
BUILT = pathlib.Path("build/fuzz/target")
FOUND = pathlib.Path("build/fuzz/found")
# Files that are inputs without change.
VECTORS = {"subsystem_descriptor": "descriptors/subsystems", "mission_descriptor": "descriptors/missions",
           "eds": "descriptors/devices", "scenario": "sim/scenarios", "world": "descriptors/worlds", "xml": "descriptors/missions"}
INPUT_SECONDS = 25
ENGINE = [f"-timeout={INPUT_SECONDS}", "-rss_limit_mb=2048", "-print_final_stats=1", "-verbosity=1"]
ENVIRONMENT = {"ASAN_OPTIONS": "detect_stack_use_after_return=1:allocator_may_return_null=1",
               "UBSAN_OPTIONS": "print_stacktrace=1"}


def targets():
    return sorted(path.stem.removeprefix("fuzz_") for path in HERE.glob("fuzz_*.c"))


def kept(target):
    """Directories of a target's kept inputs: inputs with coverage, and inputs that once failed."""
    directories = [HERE / "corpus" / target, HERE / "regression" / target]
    return [str(directory) for directory in directories if directory.is_dir()]


def vectors(target):
    return [VECTORS[target]] if target in VECTORS else []


def run(program, arguments, seconds_allowed):
    """(exit code, output) of one call of a program."""
    try:
        done = subprocess.run([str(program), *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=seconds_allowed, env=dict(os.environ, **ENVIRONMENT))
        return done.returncode, done.stdout.decode(errors="replace")
    except FileNotFoundError:
        return 1, f"{program} did not build"
    except subprocess.TimeoutExpired as late:
        return 1, (late.stdout or b"").decode(errors="replace") + f"\nended after {seconds_allowed} s"


def files_of(directories):
    return sorted(str(path) for directory in directories for path in pathlib.Path(directory).iterdir())


def kept_inputs(target):
    """Kept inputs of a target, those that once failed included, and the project's files that are inputs."""
    return files_of(kept(target) + vectors(target))


def fuzz(target, seconds):
    """(exit code, output) of the kept inputs, then of new ones. The kept corpus is read, never written. A run that takes longer
    than its time ends later: that is no failure."""
    code, output = run(BUILT / target, [*ENGINE, *kept_inputs(target)], 300)
    if code != 0 or seconds == 0:
        return code, output
    found, fresh = FOUND / target, pathlib.Path("build/fuzz/corpus", target)
    found.mkdir(parents=True, exist_ok=True)
    fresh.mkdir(parents=True, exist_ok=True)
    arguments = [*ENGINE, f"-artifact_prefix={found}/", f"-max_total_time={seconds}", str(fresh), *kept(target), *vectors(target)]
    return run(BUILT / target, arguments, seconds * 3 // 2 + 120)


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
        text += (f"\n  to repeat it:         build/fuzz/target/{target} {artifact[1]}"
                 f"\n  keep it with its fix: cp {artifact[1]} test/fuzz/regression/{target}/")
    return text


def judge_all(names, seconds, jobs):
    """Yields (target, exit code, output) as they end."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = {pool.submit(fuzz, name, seconds): name for name in names}
        for done in concurrent.futures.as_completed(runs):
            yield runs[done], *done.result()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=20, help="new inputs for each target; 0: kept inputs only")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("targets", nargs="*", default=targets())
    arguments = parser.parse_args()
    failed = 0
    for target, code, output in judge_all(arguments.targets, arguments.seconds, arguments.jobs):
        print(line_of(target, code, output), flush=True)
        if code != 0:
            failed += 1
            print(explain(target, output), flush=True)
    print(f"{len(arguments.targets) - failed} passed, {failed} failed")
    return 1 if failed or not arguments.targets else 0


if __name__ == "__main__":
    sys.exit(main())
