# SPDX-License-Identifier: Apache-2.0
"""Run the C test programs: all with sanitizers, with LONG=1 also without them, some with a check for data races, the portable ones on an
emulated board. Then run pytest; end with `N passed, M failed, K skipped`.

Prints the closing lines of each runner (Unity, cmocka) as soon as it ends, each test of pytest as it begins and ends, all output
of what failed, and the slowest tests."""

import argparse
import concurrent.futures
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

VARIANTS = [*(["build"] if os.environ.get("LONG") else []), "build/sanitize"]
# Programs without an operating system of their own run on an emulated board. Time there follows from the number of
# instructions, 32 ns each, so that no result depends on the speed of this machine.
EMULATOR = "qemu-system-arm -display none -monitor none -serial none -icount shift=5,sleep=off"
BOARD = re.compile(r"build/(mps2-\w+)/")
# The EEPROM of a board, as two devices of 64 KiB: the second one has the upper half of the addresses (osal/freertos/eeprom.h). Each
# program has a blank one.
EEPROM = "eeprom"
EEPROM_OCTETS = 131072
EEPROM_DEVICES = (f"-blockdev driver=file,node-name=eeprom,filename={EEPROM} "
                  + " ".join(f"-blockdev driver=raw,node-name=half{half},file=eeprom,offset={half * 65536},size=65536 "
                             f"-device at24c-eeprom,address={0x50 + half},rom-size=65536,drive=half{half}" for half in range(2)))
# Test functions of the contracts of the operating system layer that have a result on a board, not IGNORE. If one is lost, because a
# port does not have a function any more or because a file is not built, the tests fail. If one is added, raise the number.
CONTRACTS = "test/contract/osal/"
CONTRACTS_ON_BOARD = 116
# Limits of processor time, which does not depend on the load of the machine, and of wall-clock time, for
# tests that wait without end.
PROCESSOR_SECONDS_ALLOWED = 300
SECONDS_ALLOWED = 1200
FLIGHT_SECONDS_ALLOWED = 1500
SLOWEST = 10
# Files and groups of files (test/conftest.py) that take more than half a minute. They begin first, in this order. The
# files of the station fly in wall-clock time with a browser; they are apart in the list, so that they do not run together.
LONGEST = ["test/mission/test_mission_artefacts.py", "test/hil/test_nodes.py", "test/hil/test_deaths.py", "test/hil/test_buses.py",
           "test/mission/test_mission_station.py", "test/mission/test_tutorial.py", "test/conformance/pus/",
           "test/mission/test_mission_station_telepresence.py", "test/hil/test_rtos.py", "test/unit/gse/hirosco_gse/test_ground_figures.py",
           "test/unit/gse/hirosco_gse/test_ground_report.py", "test/mission/test_mission_disk.py", "test/mission/test_mission_crashes.py"]
UNITY = re.compile(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", re.MULTILINE)
CMOCKA = re.compile(r"^\[ +(PASSED|FAILED|SKIPPED) +\] (\d+) test", re.MULTILINE)
CLOSING = re.compile(r"^(\d+ Tests \d+ Failures.*|OK|FAIL|\[ +(PASSED|FAILED|SKIPPED) +\] \d+ test.*)$")


class Count:
    """Test cases by outcome."""

    def __init__(self, passed=0, failed=0, skipped=0):
        self.passed, self.failed, self.skipped = passed, failed, skipped

    def add(self, other):
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped


def count_cases(output, code):
    """Count the cases from a runner's closing lines; a program that ends with an error has at least one
    failure."""
    count = Count()
    found = False
    for line in UNITY.finditer(output):
        cases, failed, ignored = map(int, line.groups())
        count.add(Count(cases - failed - ignored, failed, ignored))
        found = True
    for word, cases in CMOCKA.findall(output):
        count.add(Count(**{word.lower(): int(cases)}))
        found = True
    if code != 0 and count.failed == 0:
        count.failed = 1
    elif not found and code == 0:
        count.passed = 1
    return count


def command_of(program):
    """Words that run a test program: itself, or the emulator of its board."""
    board = BOARD.match(program)
    if not board:
        return [program]
    return [*EMULATOR.split(), "-machine", board[1], *EEPROM_DEVICES.split(), "-semihosting-config", "enable=on,target=native,arg=test",
            "-kernel", os.path.abspath(program)]


def run_program(program):
    """(program, count, output, seconds) of one test program. On a board, it runs in a directory of its own, which has the
    descriptors and the image of a blank EEPROM."""
    with tempfile.TemporaryDirectory() as directory:
        os.symlink(os.path.abspath("descriptors"), os.path.join(directory, "descriptors"))
        pathlib.Path(directory, EEPROM).write_bytes(b"\xFF" * EEPROM_OCTETS)
        return run_in(directory if BOARD.match(program) else None, program)


def run_in(directory, program):
    environment = dict(os.environ, ASAN_OPTIONS="detect_stack_use_after_return=1", UBSAN_OPTIONS="print_stacktrace=1")
    began = time.monotonic()
    if not os.access(program, os.X_OK):
        return program, Count(failed=1), "did not build", 0.0
    with subprocess.Popen(command_of(program), cwd=directory, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env=environment) as run:
        resource.prlimit(run.pid, resource.RLIMIT_CPU, (PROCESSOR_SECONDS_ALLOWED, PROCESSOR_SECONDS_ALLOWED))
        try:
            octets, _ = run.communicate(timeout=SECONDS_ALLOWED)
            code, output = run.returncode, octets.decode(errors="replace")
        except subprocess.TimeoutExpired:
            run.kill()
            octets, _ = run.communicate()
            code, output = 1, octets.decode(errors="replace") + f"\nended after {SECONDS_ALLOWED} s"
    count = count_cases(output, code)
    if code != 0:
        output += f"\nexit code {code}"
    return program, count, output, time.monotonic() - began


def program_of(source, directory):
    return str(pathlib.Path(directory, source).with_suffix(""))


def judge_contracts(counts):
    """Failures: 1 if fewer contracts than expected have a result on the board, else 0. Prints their number."""
    found = sum(count.passed for program, count in counts.items() if BOARD.match(program) and CONTRACTS in program)
    print(f"contracts with a result on the board: {found}, expected {CONTRACTS_ON_BOARD}")
    if found > CONTRACTS_ON_BOARD:
        print(f"raise CONTRACTS_ON_BOARD in test/support/run_tests.py to {found}")
    return int(found < CONTRACTS_ON_BOARD)


def run_programs(programs, jobs):
    """Run all programs. Returns the total count, (seconds, program) of each, and the count of each program. Each program is shown
    when it ends."""
    total, times, counts = Count(), [], {}
    with concurrent.futures.ThreadPoolExecutor(jobs + 1) as pool:  # Some programs wait.
        runs = [pool.submit(run_program, program) for program in programs]
        for number, run in enumerate(concurrent.futures.as_completed(runs), 1):
            program, count, output, seconds = run.result()
            total.add(count)
            counts[program] = count
            times.append((seconds, program))
            print(f"[{number}/{len(programs)}] {program}  {seconds:.2f} s")
            lines = output.splitlines()
            shown = lines if count.failed else [line for line in lines if CLOSING.match(line)]
            print("".join(f"    {line}\n" for line in shown), end="", flush=True)
    return total, times, counts


def print_slowest(kind, times):
    if times:
        print(f"slowest {kind}:")
    for seconds, name in sorted(times, reverse=True)[:SLOWEST]:
        print(f"    {seconds:8.2f} s  {name}")


def in_order(files):
    """The slow files first, so that the workers end at about the same time."""
    def place(name):
        return next((rank for rank, begin in enumerate(LONGEST) if name.startswith(begin)), len(LONGEST)), name

    return sorted(files, key=place)


def read_report(report):
    """Count of the cases in a report of pytest, and (seconds, case) of each, including its fixtures."""
    count, times = Count(), []
    for suite in xml.etree.ElementTree.parse(report).getroot().iter("testsuite"):
        failed = int(suite.get("failures", 0)) + int(suite.get("errors", 0))
        skipped = int(suite.get("skipped", 0))
        count.add(Count(int(suite.get("tests", 0)) - failed - skipped, failed, skipped))
        times += [(float(case.get("time", 0)), f"{case.get('classname')}::{case.get('name')}") for case in suite.iter("testcase")]
    return count, times


def run_pytest(directory, only, jobs):
    """Count of all cases of the files in a directory, and (seconds, case) of each."""
    files = in_order(str(path) for path in pathlib.Path(directory).rglob("test_*.py") if only in str(path))
    if not files:
        return Count(), []
    report = pathlib.Path("build/test/pytest.xml")
    report.parent.mkdir(parents=True, exist_ok=True)
    report.unlink(missing_ok=True)
    options = ["-v", "-rs", "-p", "no:cacheprovider", f"--timeout={FLIGHT_SECONDS_ALLOWED}", "--rootdir=.",
               f"--junitxml={report}"]
    # One more worker than there are processors, because tests wait for processes, emulators and browsers; with two more, flights of several
    # processes took longer. The tests of a file stay together because they share flights.
    workers = min(jobs + 1, len(files)) if jobs > 1 else 1
    if workers > 1:
        options += ["-n", str(workers), "--dist", "loadfile", "--no-loadscope-reorder"]
    code = subprocess.run([sys.executable, "-m", "pytest", *options, *files]).returncode
    count, times = read_report(report) if report.exists() else (Count(), [])
    if code != 0 and count.failed == 0:
        count.failed = 1
    return count, times


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="run only tests whose path contains this")
    parser.add_argument("--under", default="test", help="directory of the tests in Python")
    parser.add_argument("--variant", action="append", help="directory of a build to run instead of the usual ones")
    parser.add_argument("--no-pytest", action="store_true", help="C test programs only")
    parser.add_argument("--failed", default="", help="what failed before the tests ran")
    parser.add_argument("--threads", default="", help="C sources of tests to run in the build against data races too")
    parser.add_argument("--board", default="", help="board on which the portable tests run too")
    parser.add_argument("--on-board", default="", help="C sources of these tests")
    parser.add_argument("sources", nargs="*", help="C sources of the test programs")
    arguments = parser.parse_args()

    programs = [program_of(source, directory) for directory in arguments.variant or VARIANTS for source in arguments.sources
                if arguments.only in source]
    programs += [program_of(source, "build/thread") for source in arguments.threads.split() if arguments.only in source]
    programs += [program_of(source, f"build/{arguments.board}") for source in arguments.on_board.split() if arguments.only in source]
    total, program_times, counts = run_programs(programs, arguments.jobs)
    on_board = arguments.on_board or any(BOARD.match(program) and CONTRACTS in program for program in programs)
    if on_board and arguments.only in CONTRACTS:  # All contracts are selected.
        total.failed += judge_contracts(counts)
    case_times = []
    if not arguments.no_pytest:
        count, case_times = run_pytest(arguments.under, arguments.only, arguments.jobs)
        total.add(count)
    print_slowest("C tests", program_times)
    print_slowest("tests in Python", case_times)
    if arguments.failed:
        print(f"failed before the tests: {arguments.failed.strip()}")
        total.failed += 1
    if arguments.only and not (total.passed or total.failed or total.skipped):
        print(f"ONLY={arguments.only}: no test has this in its path")
    print(f"{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 1 if total.failed or not total.passed else 0


if __name__ == "__main__":
    sys.exit(main())
