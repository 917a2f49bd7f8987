#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fault campaign: flights with faults drawn from a seed (campaign_faults.py), judged by invariants only
(campaign_rules.py).

To repeat a flight:

    test/mission/campaign.py SEED [--faults 1|2] [--form image|processes]"""

import argparse
import collections
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "support")]

import campaign_faults as faults
import campaign_rules as rules
import flying

SAME_IN = 10  # One in ten flights is also flown in the other form; both must have the same octets.
TRACED = (*flying.TRACED, "can-robot-b.log", "can-joystick-b.log")
# An event of an LCM log: sync word, number and time, length of the channel's name, length of the data, name. The data of DRIVE: fingerprint,
# time [ns], length and name of the bus, then 14 octets: node, axis, statusword (4 octets each), plugged, brake engaged.
DRIVE_EVENT = re.compile(rb"\xed\xa1\xda\x01.{16}\x00\x00\x00\x05.{4}DRIVE(.{16}\x00\x00\x00.[a-z-]+\x00.{14})", re.DOTALL)
# Commands of the flight whose record store the campaign uses: each of them leaves persistent records.
LASTING = (
    "0.1 operator try schedule enable",
    "0.1 operator try at 100 ping MANIPULATOR",
    "0.1 operator try action add JOYSTICK OPERATOR_NOTE ping MANIPULATOR",
    "0.1 operator try store create KEPT 65536",
    "0.1 operator try store keep KEPT MANIPULATOR",
    "0.1 operator try store enable KEPT",
    "0.2 operator try monitor limit MANIPULATOR 2 LINK_AGE 0 100000 0 OPERATOR_NOTE",
    "0.2 operator try monitor limit JOYSTICK 2 LINK_AGE 0 100000 0 OPERATOR_NOTE",
    "0.3 operator try state MANIPULATOR PRE_OPERATIONAL",
    "1.0 operator try event disable JOYSTICK OPERATOR_NOTE",
    "1.5 operator try shutdown",
)


class Ground:
    """Data shared by all flights of a campaign: the probe, an initial record store, and a mission with one
    member on each node."""

    def __init__(self, place):
        self.place = place
        place.mkdir(parents=True, exist_ok=True)

    def _made(self, name, make):
        path = self.place / name
        if not path.exists():
            make(path)
        return path

    @property
    def probe(self):
        """The library of campaign_probe.c."""
        source = pathlib.Path(__file__).with_name("campaign_probe.c")
        return self._made("probe.so", lambda path: subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", path, source, "-ldl"], check=True))

    @property
    def records(self):
        """The record store of an earlier flight."""

        def make(path):
            scenario = flying.write_scenario(self.place / "records.scn", *LASTING)
            flight = flying.fly(self.place / "records-flight", "--scenario", scenario, "--form", "image", "--storage", path, "--port", flying.free_port())
            assert flight.code == 0, flight.transcript()

        return self._made("records", make)

    @property
    def split(self):
        """A copy of the tree in which the mission places JOYSTICK on node 1, so that the links go between the
        nodes."""

        def make(tree):
            (tree / "descriptors").mkdir(parents=True)
            for name in ("build", "gse", "sim"):
                (tree / name).symlink_to(flying.ROOT / name)
            shutil.copytree(flying.ROOT / "descriptors", tree / "descriptors", dirs_exist_ok=True)
            path = tree / "descriptors" / "missions" / "rokviss.xml"
            head, tail = path.read_text(encoding="utf-8").split('<Subsystem name="JOYSTICK"')
            path.write_text(head + '<Subsystem name="JOYSTICK"' + tail.replace('node="2"', 'node="1"', 1), encoding="utf-8")

        return self._made("split", make)


def drives(path):
    """Entries of channel DRIVE in a truth log, as run.load returns them, without reading the other
    channels."""
    found = []
    for event in DRIVE_EVENT.finditer(path.read_bytes()):
        octets = event[1]
        size = int.from_bytes(octets[16:20], "big")
        rest = octets[20 + size :]
        node, axis, status = (int.from_bytes(rest[at : at + 4], "big") for at in (0, 4, 8))
        found.append({"time_us": int.from_bytes(octets[8:16], "big") // 1000, "bus": octets[20 : 19 + size].decode("ascii"), "node": node, "axis": axis,
                      "statusword": status, "plugged": rest[12], "brake_engaged": rest[13]})  # fmt: skip
    return found


def _damage(path, how, where):
    """Damage a file at a place given as a fraction of its length."""
    octets = bytearray(path.read_bytes())
    at = int(where * len(octets))
    if how == "flip" and octets:
        octets[at] ^= 1 << int(where * 1000) % 8
    elif how == "noise" and octets:
        octets[at : at + 64] = bytes(int(where * 1e6 + number * 37) % 256 for number in range(min(64, len(octets) - at)))
    elif how == "zero":
        octets[:] = bytes(len(octets))
    elif how == "cut":
        del octets[at:]
    elif how == "empty":
        octets.clear()
    path.write_bytes(octets)


def _time_of(flight):
    """Simulated time that the operator has reached."""
    path = flight.directory / "operator.log"
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    with contextlib.suppress(ValueError, IndexError, KeyError):
        return json.loads(lines[-1])["end"]
    return 0.0


def _set_connection(flight, state):
    """Cut or restore the connection between the nodes while simulated time stands still. If the simulator has
    ended already, kill() finds no process (ProcessLookupError), or its process id is None (TypeError)."""
    simulator = flight.children().get("simulator")
    with contextlib.suppress(ProcessLookupError, TypeError):
        os.kill(simulator, signal.SIGSTOP)
    subprocess.run(["ip", "-n", f"{flight.identity}.node1", "link", "set", "node1", state], check=False, capture_output=True)
    with contextlib.suppress(ProcessLookupError, TypeError):
        os.kill(simulator, signal.SIGCONT)


def _cut_connection(flight, cuts):
    """Cut the connection between the nodes in each of these intervals of simulated time."""
    for begin_s, end_s in cuts:
        for at_s, state in ((begin_s, "down"), (end_s, "up")):
            flying.wait_until(lambda at_s=at_s: flight.process.poll() is not None or _time_of(flight) >= at_s, f"{at_s} s of the flight", flying.FLIGHT_LIMIT_S)
            _set_connection(flight, state)


def _options(ground, drawn, directory):
    options = ["--form", "image" if drawn.form == "image" else "processes", "--port", flying.free_port()]
    if drawn.form == "nodes":
        options += ["--nodes", 2] + ([] if drawn.is_split else ["--links", "udp"])
    if drawn.damages:
        storage = directory / "storage"
        shutil.copytree(ground.records, storage)
        for name, how, where in drawn.damages:
            _damage(storage / name, how, where)
        options += ["--storage", storage]
    return options


def fly(ground, directory, drawn):
    """Fly a drawn flight. Returns the finished flight and the rules that it violates."""
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    (directory / "count").write_bytes(bytes(4))
    path = flying.write_scenario(directory / "flight.scn", *drawn.lines)
    environment = {"LD_PRELOAD": str(ground.probe), "CAMPAIGN_ENDS": str(directory / "ends"), "CAMPAIGN_COUNT": str(directory / "count")}
    environment |= {"CAMPAIGN_DISK": drawn.disk} if drawn.disk else {}
    how = {"root": ground.split} if drawn.is_split else {}
    flight = flying.start(directory / "run", "--scenario", path, *_options(ground, drawn, directory), environment=environment, **how)
    try:
        _cut_connection(flight, drawn.cuts)
        flight.wait()
    finally:
        flight.abandon()
    ends = directory / "ends"
    seen = rules.Seen(
        flight, drawn.lines, drawn.end_s, drives(flight.directory / "truth.lcm"), drawn.is_determined, bool(drawn.cuts),
        ends.read_text(encoding="utf-8") if ends.exists() else "",
    )  # fmt: skip
    return flight, rules.violations(seen)


def differences(one, other):
    """Logs that differ between two flights."""
    return [f"{name} is not the same in another form" for name in TRACED if one.octets(name) != other.octets(name)]


def judge(ground, directory, drawn, in_both=None):
    """Violations of the rules by a flight. in_both: also fly it in the other form; None: only if the seed is one of SAME_IN."""
    flight, found = fly(ground, directory, drawn)
    if in_both is None:
        in_both = drawn.seed % SAME_IN == 0
    if in_both and drawn.is_determined and drawn.form != "nodes":
        again = faults.draw(drawn.seed, drawn.count, "image" if drawn.form == "processes" else "processes")
        other, more = fly(ground, directory.with_name(directory.name + "-again"), again)
        found = found + more + differences(flight, other)
    if not found:
        shutil.rmtree(directory)
        shutil.rmtree(directory.with_name(directory.name + "-again"), ignore_errors=True)
    return found


def command(drawn):
    """The command that repeats the flight."""
    return f"test/mission/campaign.py {drawn.seed} --faults {drawn.count} --form {drawn.form}"


def main():
    """Fly one seed or a range of seeds by hand."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int, help="first seed")
    parser.add_argument("--count", type=int, default=1, help="number of seeds")
    parser.add_argument("--faults", type=int, default=1, help="faults in each flight")
    parser.add_argument("--form", choices=("image", "processes", "nodes"), help="form of the flights (default: as drawn from the seed)")
    parser.add_argument("--kind", help="only seeds with this kind of fault")
    arguments = parser.parse_args()
    place = pathlib.Path(tempfile.mkdtemp(prefix="campaign-"))
    ground = Ground(place / "ground")
    flown, failed = collections.Counter(), 0
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        drawn = faults.draw(seed, arguments.faults, arguments.form)
        if arguments.kind and arguments.kind not in drawn.kinds:
            continue
        directory = place / f"{seed}-{arguments.faults}"
        try:
            found = judge(ground, directory, drawn)
        except (AssertionError, OSError, ValueError, LookupError, sqlite3.Error) as problem:
            found = [f"cannot be judged: {problem!r}"]
        flown.update([*drawn.kinds, f"in {drawn.form}", "all"])
        if found:
            failed += 1
            print(f"{command(drawn)}: {' + '.join(drawn.kinds)}: {directory}", *found[:12], sep="\n    ", flush=True)
    print(f"{flown['all']} flights, {failed} with a violated invariant: {dict(flown)}", flush=True)
    if not failed:
        shutil.rmtree(place)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
