#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Soak: hours of simulated time with random traffic of an operator; nothing grows, drifts or stalls.

A seed determines the traffic: the mission rests, flies telepresence, moves the arm alone, loses and regains a
process, and gets requests of every kind in between. Buses and truth are not logged. To repeat a flight:

    test/mission/soak.py SEED --hours 24 [--form image|processes] [--out DIRECTORY]

The samples of every process are in DIRECTORY/soak.jsonl: one line for each second of wall-clock time."""

import argparse
import collections
import json
import os
import pathlib
import random
import shutil
import statistics
import sys
import tempfile
import time

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "support")]

import flying
from hirosco_gse import packets

NS_PER_S = 1_000_000_000
HOUR_S = 3600
MEMBERS = ("JOYSTICK", "MANIPULATOR")
TARGETS = (*MEMBERS, "SUPERVISOR", "COMMUNICATION")
STATES = ("OFFLINE", "PRE_OPERATIONAL", "SAFE_OPERATIONAL", "OPERATIONAL", "ERROR_OPERATIONAL")
UNLOGGED = ("truth.lcm", *(f"can-{bus}.{kind}" for bus in ("robot", "joystick", "robot-b", "joystick-b") for kind in ("log", "pcap")))
HANDS = 200  # Movements of the hand, distributed over the flight.
SAMPLE_S = 1.0
# Permitted growth from the second quarter of the flight to the last: the pages of a static buffer count only
# after their first use.
GROWTH_KIB = 1024
# Permitted growth of the numbers of names, descriptors and sockets, which vary, for example while a bus or a
# process starts.
GROWTH_OPEN = 4
REPORTS = {(129, 5): 1, (3, 25): 5}  # Periodic reports and their period [s]: TM[129,5] in state 5 (OPERATIONAL), TM[3,25] of structure 1.
PERIODIC = {1, 2}  # APIDs of the components that run all the time.
ON_BOARD = 0x8000
SEQUENCE = 0x4000
LATE_NS = 100_000_000  # Permitted delay of a periodic report behind others on a busy connection.


def _wrong(rng):
    """A request of an unknown service, or one with a wrong checksum."""
    data, apid, count = rng.randbytes(rng.randrange(0, 30)), rng.choice((1, 2, 16, 17, 99)), rng.randrange(SEQUENCE)
    raw = packets.build_tc(apid, count, rng.randrange(50, 128), rng.randrange(1, 256), data)
    return raw if rng.random() < 0.5 else raw[:-2] + bytes((raw[-2] ^ 1, raw[-1]))


def _light(rng):
    """A request that changes little and may be refused."""
    target, member = rng.choice(TARGETS), rng.choice(MEMBERS)
    return rng.choice((
        f"ping {target}", "ping all", f"hk once {member} 1", f"hk once {member} 4711", "status", "networks", "link list",
        f"state {member} {rng.choice(STATES)}", f"config {member} {rng.choice(('TELEPRESENCE', 'STAND_ALONE'))}",
        f"event {rng.choice(('enable', 'disable'))} {member} OPERATOR_NOTE", f"cmd {member}.RAISE EVENT=9", f"reload {member}",
        f"hk {rng.choice(('enable', 'disable'))} {member} 4711", f"hk report {target} 1", f"tc {target} 20,1", f"tc {target} 5,7",
        f"at +{rng.randrange(1, 300)} ping {member}", "schedule list", f"monitor list {member}", "action list", "store list",
        f"action add MANIPULATOR OPERATOR_NOTE ping {target}", "action delete MANIPULATOR OPERATOR_NOTE", "file list", "procedure status",
        f"link {rng.choice(('open', 'close'))} {rng.choice(('HAND_POSITION', 'ROBOT_STATE'))}", f"mode {rng.choice(('NOMINAL', 'NOMINAL', 'SAFE'))}",
        f"raw {_wrong(rng).hex()}",
    ))


def _telepresence(rng, at):
    lines = [(at, f"try {line.split(' operator ')[1]}") for line in flying.bring_up(0.0) if "wait-event" not in line]
    lines.insert(-2, (at + 2.0, "try ping all"))
    end = at + rng.uniform(20, 240)
    return [*lines, *((end, f"try state {name} SAFE_OPERATIONAL") for name in MEMBERS)], end


def _stand_alone(rng, at):
    orders = ("state MANIPULATOR PRE_OPERATIONAL", "config MANIPULATOR STAND_ALONE", "state MANIPULATOR SAFE_OPERATIONAL",
              "state MANIPULATOR OPERATIONAL")
    end = at + rng.uniform(20, 120)
    moves = [(at + 2 + i * 9.0, f"try cmd MANIPULATOR.MOVE_TO POSITION={rng.uniform(0.6, 1.2):.3f},{rng.uniform(-1.8, -1.2):.3f} DURATION=5")
             for i in range(int((end - at - 5) / 9))]
    return [*((at, f"try {order}") for order in orders), *moves], end


def _life(rng, at):
    name, away = rng.choice(MEMBERS), rng.uniform(0.001, 60)
    return [(at, f"try process stop {name}"), (at + away, f"try process start {name}")], at + away + 1


def _rest(rng, at):
    return [(at, "try state JOYSTICK OFFLINE"), (at, "try state MANIPULATOR OFFLINE")], at + rng.uniform(30, 600)


def scenario(seed, hours, every_s=5.0):
    """Lines of the scenario of a seed for this many hours; `every_s` is the mean interval of light
    requests."""
    rng, end_s, at, steps = random.Random(f"soak/{seed}"), hours * HOUR_S, 1.0, []
    while at < end_s - 10:
        steps.append((at, "try mode NOMINAL"))
        block, until = rng.choice((_telepresence, _telepresence, _stand_alone, _life, _rest))(rng, at)
        lights = int((until - at) / every_s * rng.uniform(0, 2))
        steps += block + [(rng.uniform(at, until), f"try {_light(rng)}") for _ in range(lights)]
        down = until + 1
        steps += [(down, f"try state {name} OFFLINE") for name in MEMBERS]
        at = down + rng.uniform(1, 30)
    lines = [f"{at:.6f} operator {words}" for at, words in sorted(steps, key=lambda step: step[0]) if at < end_s - 10]
    hands = ["0.0 hand rest"] + [f"{1 + i * end_s / HANDS:.6f} hand circle 0.05 0.5 1 {max(1.0, min(900.0, end_s / HANDS - 5)):.0f} 1"
                                 for i in range(HANDS) if end_s > HANDS * 10]
    return hands + lines + [f"{end_s:.6f} operator shutdown"]


def _kib(pid, words):
    text = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    values = dict(line.split(":", 1) for line in text.splitlines())
    return {word: int(values[word].split()[0]) for word in words}


def _simulated_s(flight):
    """Simulated time that the operator has reached."""
    path = flight.directory / "operator.log"
    try:
        with path.open("rb") as log:
            log.seek(max(0, path.stat().st_size - 20000))
            return json.loads(log.read().splitlines()[-1])["end"]
    except (OSError, IndexError, ValueError, KeyError):
        return 0.0


def _sample(flight, began):
    """Resources of every process of the flight, its names in shared memory, and the size of its packet logs."""
    found = {"wall_s": round(time.monotonic() - began, 2), "simulated_s": _simulated_s(flight), "processes": {}}
    for name, pid in {**flight.children(), "launcher": flight.process.pid}.items():
        try:
            entry = _kib(pid, ("VmRSS", "VmData", "RssAnon"))
            kept = [os.readlink(path) for path in pathlib.Path(f"/proc/{pid}/fd").iterdir()]
            entry["descriptors"], entry["sockets"] = len(kept), sum(name.startswith("socket:") for name in kept)
        except (OSError, KeyError):
            continue  # The process is just ending.
        found["processes"][name] = entry
    found["names"] = len([path for path in pathlib.Path("/dev/shm").iterdir() if flight.identity in path.name])
    found["octets"] = sum(path.stat().st_size for path in flight.directory.glob("packets.*"))
    return found


def _usual(samples, name, word):
    """Median of a resource of a process in these samples; 0 if the process is in none of them."""
    values = [sample["processes"][name][word] for sample in samples if name in sample["processes"]]
    return statistics.median_low(values) if values else 0


def judge_samples(samples, form="image"):
    """Yield a message for each resource that has grown from the second quarter, when the start-up is over, to the last quarter."""
    there = {"image"} if form == "image" else {"supervisor", "communication", "simulator"}
    # Ignore the end of the flight, when logs are merged.
    samples = [sample for sample in samples if there <= sample["processes"].keys()]
    # Quarters of simulated time, not of the samples: a machine that is slow at first takes more samples of the start-up.
    end = samples[-1]["simulated_s"] if samples else 0
    warm = [sample for sample in samples if end / 4 <= sample["simulated_s"] < end / 2]
    last = [sample for sample in samples if sample["simulated_s"] >= 3 * end / 4]
    if min(len(warm), len(last)) < 2:
        yield f"{len(samples)} samples, expected at least two in the second and in the last quarter of the flight: fly longer"
        return
    # The ground segment is not part of the spacecraft.
    names = {name for sample in samples for name in sample["processes"]} - {"operator"}
    for name in sorted(names):
        for word, may in (("VmRSS", GROWTH_KIB), ("VmData", GROWTH_KIB), ("RssAnon", GROWTH_KIB), ("descriptors", GROWTH_OPEN), ("sockets", GROWTH_OPEN)):
            before, after = _usual(warm, name, word), _usual(last, name, word)
            if after > before + may:
                yield f"{name}: {word} grew from {before} to {after}"
    before, after = (statistics.median_low(sample["names"] for sample in part) for part in (warm, last))
    if after > before + GROWTH_OPEN:
        yield f"names in /dev/shm grew from {before} to {after}"


class Judge:
    """Reads packets.log once, line by line, because the log of a day is large."""

    def __init__(self):
        self.problems, self.counts, self.lines = [], collections.Counter(), 0
        self._sequence, self._report, self._open = {}, {}, collections.Counter()
        self.hours = collections.Counter()
        self.late_ns = 0

    def take(self, time_ns, direction, raw):
        """Check one record."""
        apid, message = int.from_bytes(raw[:2], "big") & 0x7FF, (raw[7], raw[8])
        self.lines += 1
        self.counts[direction, apid, *message] += 1
        self.hours[time_ns // (HOUR_S * NS_PER_S)] += 1
        if direction == "TC":
            if int.from_bytes(raw[9:11], "big") < ON_BOARD:
                self._open[raw[:4].hex(), "TC"] += 1
            return
        self._numbered(time_ns, apid, int.from_bytes(raw[2:4], "big") & 0x3FFF)
        if raw[7] == 1 and raw[8] in (2, 4, 7, 8, 10) and int.from_bytes(raw[11:13], "big") < ON_BOARD:
            self._open[raw[21:25].hex(), "TM"] += 1
        if message in REPORTS and apid in PERIODIC and (message != (3, 25) or raw[21:23] == b"\0\1") and (message != (129, 5) or raw[21] == 5):
            self._periodic(time_ns, (apid, message), REPORTS[message] * NS_PER_S)

    def _numbered(self, time_ns, apid, count):
        if apid in PERIODIC and apid in self._sequence and count != (self._sequence[apid] + 1) % SEQUENCE:
            self.problems.append(f"{time_ns / NS_PER_S} s: sequence count {count} of APID {apid} follows {self._sequence[apid]}")
        self._sequence[apid] = count

    def _periodic(self, time_ns, key, period_ns):
        first = self._report.setdefault(key, [time_ns, time_ns])
        gap, phase = time_ns - first[1], (time_ns - first[0]) % period_ns
        self.late_ns = max(self.late_ns, min(phase, period_ns - phase))
        if gap > period_ns + LATE_NS:
            self.problems.append(f"{time_ns / NS_PER_S} s: no report {key} for {gap / NS_PER_S} s")
        first[1] = time_ns

    def end(self):
        """All findings."""
        for request in sorted({name for name, _ in self._open}):
            asked = self._open[request, "TC"]
            if self._open[request, "TM"] != asked:
                self.problems.append(f"request {request}: {asked} sent, {self._open[request, 'TM']} ended")
        if self.late_ns > LATE_NS:
            self.problems.append(f"periodic reports drift by {self.late_ns / 1e6} ms")
        return self.problems


def judge_packets(directory):
    """Returns a Judge that has read the log."""
    judge = Judge()
    with (directory / "packets.log").open(encoding="ascii") as log:
        for line in log:
            stamp, direction, text = line.split()
            judge.take(int(stamp.replace(".", "")), direction, bytes.fromhex(text))
    return judge


def _numbers_are_whole(directory):
    expected = 0
    with (directory / "packets.ascii").open(encoding="ascii") as log:
        for line in log:
            expected += 1
            if int(line.split(" ", 1)[0]) != expected:
                return f"packets.ascii: found record {line.split(' ', 1)[0]}, expected {expected}"
    return None


def watch(flight, sample_s=SAMPLE_S):
    """Take samples of a flight until it ends. Returns them and writes them to its directory."""
    began, samples = time.monotonic(), []
    with (flight.directory / "soak.jsonl").open("w", encoding="ascii") as log:
        while flight.process.poll() is None:
            samples.append(_sample(flight, began))
            print(json.dumps(samples[-1]), file=log, flush=True)
            time.sleep(sample_s)
    flight.wait()
    return samples


def fly(directory, seed, hours, form="image", sample_s=SAMPLE_S):
    """Fly once. Returns (flight, samples, judge, problems)."""
    directory.mkdir(parents=True)
    for name in UNLOGGED:
        (directory / name).symlink_to("/dev/null")
    path = flying.write_scenario(directory / "soak.scn", *scenario(seed, hours))
    flight = flying.start(directory, "--scenario", path, "--form", form)
    samples = watch(flight, sample_s)
    judge = judge_packets(directory)
    problems = [f"the launcher ended with {flight.code}: {flight.output[-500:]}"] if flight.code != 0 else []
    if not flight.facts["reproducible"]:
        problems.append("the flight is not reproducible")
    if flight.facts["simulated_s"] < hours * HOUR_S:
        problems.append(f"the flight ended at {flight.facts['simulated_s']} s, expected {hours * HOUR_S} s or later")
    problems += judge.end() + list(judge_samples([s for s in samples if s["simulated_s"] > 0], form))
    problems += [what for what in (_numbers_are_whole(directory),) if what]
    return flight, samples, judge, problems + flight.leftovers()


def main():
    """Fly one seed by hand."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int)
    parser.add_argument("--hours", type=float, default=24.0, help="simulated hours (default 24)")
    parser.add_argument("--form", choices=("image", "processes"), default="image")
    parser.add_argument("--out", type=pathlib.Path, help="a directory that does not exist yet (default: a temporary one, removed if there is no problem)")
    arguments = parser.parse_args()
    directory = arguments.out or pathlib.Path(tempfile.mkdtemp(prefix="soak-")) / "run"
    flight, samples, judge, problems = fly(directory, arguments.seed, arguments.hours, arguments.form)
    facts = flight.facts
    print(f"{facts['simulated_s']} s flown in {flight.seconds:.0f} s, {facts['real_time_factor']} x real time, {judge.lines} packets, "
          f"{sum(count for key, count in judge.counts.items() if key[0] == 'TC')} requests, reports late by {judge.late_ns / 1e6} ms at most")
    for name in sorted({name for sample in samples for name in sample["processes"]}):
        entries = [sample["processes"][name] for sample in samples if name in sample["processes"]]
        print(f"    {name}: {', '.join(f'{word} {entries[len(entries) // 4][word]} -> {entries[-1][word]}' for word in entries[-1])}")
    for what in problems:
        print(f"    {what}")
    if not problems and not arguments.out:
        shutil.rmtree(directory.parent)
    print("nothing grew, drifted or stalled" if not problems else f"{len(problems)} problems, see {directory}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
