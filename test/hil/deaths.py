# SPDX-License-Identifier: Apache-2.0
"""Kills of processes and unplugged devices at instants of simulated time that are drawn from a number: the
case, its flight, and what the flight leaves behind.

As a program it flies the given numbers on SocketCAN and leaves a directory for each in $OUT: logs and
end.json."""

import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test" / "mission"))

import flying
from environments import ARITHMETIC

HIL = ROOT / "sim" / "scenarios" / "hil.scn"
PROGRAM = "test/hil/deaths.py"
KEPT = ("can-robot.log", "can-joystick.log", "packets.log", "packets.db", "truth.lcm", "operator.log", "console.log", "run.json")
PROCESSES = ("simulator", "supervisor", "joystick", "manipulator", "communication", "operator", "packet-archive-sqlite", "launcher")
IN_IMAGE = ("image", "operator", "packet-archive-sqlite")
UNPLUGS = ("unplug robot", "unplug joystick", "unplug robot JOINT1", "unplug robot JOINT2", "unplug joystick STICK",
           "unplug robot FLIGHT", "unplug joystick FLIGHT", "cut robot", "cut joystick", "cut robot JOINT2", "cut joystick STICK",
           "cut robot FLIGHT", "cut robot-b")
CARRIERS = (("--bus", "vcan"), ("--bus", "vcan", "--transport", "tipc"), ("--transport", "tipc", "--links", "tipc"),
            ("--transport", "tipc", "--nodes", "2"), ("--nodes", "2"))  # CAN interfaces belong to one node.
FIRST_US, LAST_US = 20_000, 2_400_000  # From before the first command until the shutdown.
ENABLED_US = (1_120_000, 2_290_000)  # Interval in which the scenario holds all drives in operation.
DURATION_S = 5  # Ends the flight of an operator that waits for an answer of a dead process.
LIMIT_S = 600.0


@dataclass(frozen=True)
class Case:
    """One kill or one unplugged device, its time, and the options of its flight."""

    number: int
    fault: str
    time_us: int
    options: tuple

    @property
    def victim(self):
        """Name of the process that is killed; None if a device is unplugged."""
        verb, _, name = self.fault.partition(" ")
        return name if verb == "kill" else None

    def __str__(self):
        return f"{self.number}: {self.fault} at {self.time_us} us, {' '.join(self.options)}"


def drawn(number, on_real_buses=False):
    """Draw the case of a number: three of five cases are kills, and more than half occur while all drives are
    in operation."""
    rng = random.Random(number)
    form = "processes" if on_real_buses else rng.choice(("processes", "processes", "processes", "image"))
    if rng.random() < 0.6:
        fault = f"kill {rng.choice(IN_IMAGE if form == 'image' else PROCESSES)}"
    else:
        fault = rng.choice(UNPLUGS)
    time_us = rng.randint(*(ENABLED_US if rng.random() < 0.5 else (FIRST_US, LAST_US)))
    carrier = CARRIERS[number % len(CARRIERS)] if on_real_buses else ()
    return Case(number, fault, time_us, ("--form", form, *carrier))


def interfaces():
    """Names of the existing network interfaces and namespaces."""
    words = (["ip", "-o", "link", "show"], ["ip", "netns", "list"])
    texts = [subprocess.run(word, stdin=subprocess.DEVNULL, capture_output=True, text=True).stdout for word in words]
    return sorted(line.split(":")[1].strip() for line in texts[0].splitlines()) + texts[1].split()


def fly(case, directory, scenario_directory):
    """Fly the case of a number. Returns the flight and what it left behind."""
    scenario = scenario_directory / f"death-{case.number}.scn"
    scenario.write_text(f"{HIL.read_text()} {case.time_us / 1e6:.6f} fault {case.fault}\n")
    flight = flying.start(directory, "--scenario", scenario, "--duration", DURATION_S, *case.options,
                          environment=ARITHMETIC)
    try:
        flight.wait(LIMIT_S)
    finally:
        flight.abandon()
    return flight, left_of(flight)


def left_of(flight):
    """Names and processes that a run must not leave."""
    try:
        flying.wait_until(lambda: not flight.leftovers(), "the end of all processes and names of the run")
    except AssertionError:
        return flight.leftovers()
    return []


def main(numbers):
    """Fly one number after the other. results.jsonl has a line for each: whether the flight ended, and what
    it left behind."""
    out, work = pathlib.Path(os.environ["OUT"]), pathlib.Path("/dev/shm/deaths")
    work.mkdir()
    before = interfaces()
    with open(out / "results.jsonl", "w") as results:
        for case in (drawn(number, True) for number in numbers):
            directory, message = work / str(case.number), ""
            try:
                flight, left = fly(case, directory, work)
                left += [f"interface {name}" for name in interfaces() if name not in before]
                (out / str(case.number)).mkdir()
                for name in KEPT:
                    if (directory / name).exists():
                        shutil.copy(directory / name, out / str(case.number) / name)
                end = {"code": flight.code, "output": flight.output, "left": left}
                (out / str(case.number) / "end.json").write_text(json.dumps(end))
            except (AssertionError, OSError) as problem:
                message = str(problem)
            shutil.rmtree(directory, ignore_errors=True)
            print(json.dumps({"case": str(case.number), "passed": not message, "message": message}), file=results, flush=True)
            print(f"{case}: {message or 'flown'}", flush=True)


if __name__ == "__main__":
    main(map(int, sys.argv[1:]))
