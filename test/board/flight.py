# SPDX-License-Identifier: Apache-2.0
"""Flights, and runs in real time, in which the manipulator's program on the board contains a part of test/board."""

import pathlib
import re
import subprocess
import sys
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "test" / part) for part in ("mission", "support")]

import flying
import run_tests

BOARD = "mps2-an500"
STEP = re.compile(r"^STEP (\d+) (\d+) (\d+) (\d+) (\d+) (\d+)$", re.MULTILINE)
STACK = re.compile(r"^STACK (\S+) (\d+) (\d+)$", re.MULTILINE)
LOOP = re.compile(r"^LOOP (\d+) (\d+) (\d+) (\d+) (\d+) (\d+)$", re.MULTILINE)
COMMIT = re.compile(r"^COMMIT (\d+) (\d+) (\d+) (\d+) (\d+) (\d+)$", re.MULTILINE)
COMPACTIONS = ("none", "a part", "at once")
PAGE_MS, OCTET_MS = 5, 0.009  # AT24CM01: longest write of a page; an octet needs nine clocks at 1 MHz.
# An instruction takes 8 ns, so that 0.5 ms have 62500 instructions: fewer than the 108000 cycles of 216 MHz.
REAL_TIME = "qemu-system-arm -display none -monitor none -serial none -icount shift=3,sleep=off -no-reboot -machine " + BOARD
STATES = ("OFFLINE", "SOFTWARE_INIT", "HARDWARE_INIT", "PRE_OPERATIONAL", "SAFE_OPERATIONAL", "OPERATIONAL", "ERROR_OPERATIONAL",
          "POST_OPERATIONAL", "HARDWARE_DEINIT", "SOFTWARE_DEINIT")


@dataclass(frozen=True)
class Row:
    """Instructions of the steps that begin in the state `before` and end in the state `after`."""

    before: str
    after: str
    count: int
    median: int
    p99: int
    longest: int

    @property
    def name(self):
        return self.before if self.before == self.after else f"{self.before} to {self.after}"


@dataclass(frozen=True)
class Stack:
    """Octets of the stack of a task, reserved and used."""

    task: str
    octets: int
    used: int


@dataclass(frozen=True)
class Waits:
    """Waits of the loop in one state, in real time."""

    state: str
    steps: int
    lasted_us: int
    missed: int
    early: int
    latest: int  # Counts of 40 ns.


@dataclass(frozen=True)
class Commit:
    """The longest request that keeps records, of those with the same compaction of the journal."""

    size: int  # Octets of a record.
    records: int
    compaction: str
    instructions: int
    pages: int
    octets: int  # On the bus.

    @property
    def ms(self):
        """Time of the bus and of the writes with a real EEPROM."""
        return PAGE_MS * self.pages + OCTET_MS * self.octets


def build():
    subprocess.run(["make", "-s", "board-programs", f"BOARD={BOARD}"], cwd=ROOT, check=True)


def start(directory, part, *options):
    """Start a flight in which the manipulator is build/<board>/<part>/manipulator."""
    build()
    root = directory / "root"
    (root / "build" / BOARD).mkdir(parents=True)
    (root / "build" / BOARD / "bin").symlink_to(ROOT / "build" / BOARD / part)
    for name in ("descriptors", "gse"):
        (root / name).symlink_to(ROOT / name)
    for name in ("bin", "generated", "venv"):
        if (ROOT / "build" / name).exists():
            (root / "build" / name).symlink_to(ROOT / "build" / name)
    return flying.start(directory / "run", "--rtos", "MANIPULATOR", *options, root=root)


# A drive is lost in SAFE_OPERATIONAL and in PRE_OPERATIONAL, and recovered each time. These losses make the flight 3.7 s longer.
LOSSES = ["6.3 operator config MANIPULATOR STAND_ALONE", "6.4 operator state MANIPULATOR SAFE_OPERATIONAL",
          "6.7 fault unplug robot JOINT1", "7.1 fault plug robot JOINT1",
          "8.3 operator state MANIPULATOR PRE_OPERATIONAL", "8.6 fault unplug robot JOINT1", "9.0 fault plug robot JOINT1",
          "9.8 operator state MANIPULATOR PRE_OPERATIONAL"]


def lines(losses=()):
    """Lines of a scenario with every state of the manipulator, and its transitions except the deinitialization of hardware that is not
    initialized, a death, and, without LOSSES, errors below OPERATIONAL."""
    return ["0.0 hand rest", "0.0 operator ping all", "1.5 hand circle 0.1 0.5 1 3 1",
            *flying.bring_up(0.2),
            "2.5 operator hk once MANIPULATOR 4711",
            "3.5 operator state MANIPULATOR SAFE_OPERATIONAL", "3.6 operator state MANIPULATOR OPERATIONAL",
            "4.2 fault unplug robot JOINT1", "4.6 fault plug robot JOINT1",
            "5.5 operator state MANIPULATOR PRE_OPERATIONAL", "5.6 operator config MANIPULATOR STAND_ALONE",
            "5.7 operator state MANIPULATOR SAFE_OPERATIONAL", "6.2 operator state MANIPULATOR PRE_OPERATIONAL",
            *losses, f"{10.1 if losses else 6.4} operator shutdown"]


def steps(directory, losses=()):
    """Fly the scenario of lines(losses). Returns the rows of instructions and the stacks that the program has printed."""
    scenario = flying.write_scenario(directory / "steps.scn", *lines(losses))
    flight = start(directory, "steps", "--scenario", scenario).wait()
    assert flight.code == 0, flight.transcript()
    rows = [Row(STATES[int(before)], STATES[int(after)], *map(int, numbers)) for before, after, *numbers in STEP.findall(flight.console)]
    stacks = stacks_of(flight.console)
    assert rows and stacks, flight.transcript()
    return rows, stacks


def stacks_of(text):
    return [Stack(task, int(octets), int(used)) for task, octets, used in STACK.findall(text)]


def real_time(directory, *words):
    """Run build/<board>/real_time/manipulator, with arguments. Returns its exit code and what it printed."""
    build()
    arguments = "".join(f",arg={word}" for word in ("manipulator", *words))
    done = subprocess.run([*REAL_TIME.split(), "-semihosting-config", f"enable=on,target=native{arguments}",
                           "-kernel", ROOT / "build" / BOARD / "real_time" / "manipulator"],
                          cwd=directory, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=flying.MOMENT_S)
    return done.returncode, done.stdout + done.stderr


def loop_in_real_time(directory):
    """Run the program in real time. Returns the waits of its loop by state, and the stacks."""
    code, text = real_time(directory)
    assert code == 0, text
    waits = [Waits(STATES[int(state)], *map(int, numbers)) for state, *numbers in LOOP.findall(text)]
    return {row.state: row for row in waits}, stacks_of(text)


def commits(directory):
    """Keep records on a blank EEPROM with build/<board>/commits/manipulator. Returns the longest requests."""
    build()
    (directory / run_tests.EEPROM).write_bytes(b"\xFF" * run_tests.EEPROM_OCTETS)
    devices = run_tests.EEPROM_DEVICES.replace("driver=file", "driver=file,cache.no-flush=on")  # The image need not be on the disk.
    done = subprocess.run([*run_tests.EMULATOR.split(), "-machine", BOARD, *devices.split(),
                           "-semihosting-config", "enable=on,target=native,arg=manipulator",
                           "-kernel", ROOT / "build" / BOARD / "commits" / "manipulator"],
                          cwd=directory, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=flying.MOMENT_S)
    assert done.returncode == 0, done.stdout + done.stderr
    return [Commit(int(size), int(records), COMPACTIONS[int(compaction)], *map(int, numbers))
            for size, records, compaction, *numbers in COMMIT.findall(done.stdout + done.stderr)]
