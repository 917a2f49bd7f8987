#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fault campaign: flights with faults drawn from a seed, judged by invariants only.

A seed gives one scenario: the mission is brought up, pinged and flown, and one or two faults (or as many as asked)
happen at any moment. What may be said of every flight is judged, not what the faults lead to. Again, by hand:

    test/mission/campaign.py SEED [--faults 1|2] [--form processes|image]
"""

import argparse
import pathlib
import random
import shutil
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "support")]

import flying
from hirosco_gse import run as runs

NS_PER_S = 1_000_000_000
END_S = 8.0
MEMBERS = ("JOYSTICK", "MANIPULATOR")
APIDS = {"JOYSTICK": 17, "MANIPULATOR": 16}
DEVICES = (("robot", "JOINT1"), ("robot", "JOINT2"), ("joystick", "STICK"))
SERVICE_1 = 1
TERMINAL = {2, 4, 7, 8, 10}  # Subtypes of ST[01] after which nothing more is told of a request.
ON_BOARD = 0x8000  # Users from here on are on board.
CUT_S = 0.2  # Before the end: the mission may go down before what was sent last is answered.
MOVING = (0x27, 0x07)  # Statuswords of CiA 402: operation enabled, quick stop active.
REACTION_NS = 10_000_000  # Stale link, its cycle and the report of it.


def _moment(rng):
    """Any grant of the calendar between the bring-up and the end."""
    return rng.randrange(int(0.3e6), int((END_S - 1.5) * 1e6), 500) / 1e6


def _process_fault(rng):
    at, name = _moment(rng), rng.choice(MEMBERS)
    kind = rng.choice(("kill", "hang", "stop", "blink"))
    if kind == "kill":
        return [f"{at:.6f} fault kill {name}"]
    if kind == "hang":
        return [f"{at:.6f} fault hang {name}"]
    if kind == "blink":
        return [f"{at:.6f} fault hang {name}", f"{at + rng.choice((0.0005, 0.004, 0.015, 0.05, 0.6)):.6f} fault resume {name}"]
    again = at + rng.choice((0.0, 0.001, 0.03, 0.5))
    return [f"{at:.6f} operator try process stop {name}", f"{again:.6f} operator try process start {name}"]


def _plug_fault(rng):
    at, (bus, node) = _moment(rng), rng.choice(DEVICES)
    verb, back = rng.choice((("unplug", "plug"), ("cut", "mend")))
    return [f"{at:.6f} fault {verb} {bus} {node}", f"{at + rng.choice((0.001, 0.05, 0.9)):.6f} fault {back} {bus} {node}"]


def _wire_fault(rng):
    at, bus = _moment(rng), rng.choice(("robot", "joystick", "robot-b", "joystick-b"))
    kind = rng.choice(("loss", "corruption", "duplication", "stuck"))
    until = at + rng.choice((0.002, 0.05, 0.4))
    if kind == "stuck":
        return [f"{at:.6f} fault stuck {bus} on", f"{until:.6f} fault stuck {bus} off"]
    return [f"{at:.6f} fault {kind} {bus} {rng.choice((0.01, 0.2, 0.9))}", f"{until:.6f} fault {kind} {bus} 0"]


def _device_fault(rng):
    at, (bus, node) = _moment(rng), rng.choice(DEVICES)
    if rng.random() < 0.5:
        return [f"{at:.6f} fault reset {bus} {node}"]
    return [f"{at:.6f} fault error {bus} {node} 0x4310 on", f"{at + 0.3:.6f} fault error {bus} {node} 0x4310 off"]


def _storm(rng):
    at = _moment(rng)
    target = rng.choice((*MEMBERS, "SUPERVISOR", "all"))
    return [f"{at:.6f} operator try nowait ping {target}" for _ in range(rng.choice((20, 100)))]


FAULTS = (_process_fault, _process_fault, _process_fault, _plug_fault, _wire_fault, _device_fault, _storm)


def scenario(seed, count):
    """Lines of the scenario of a seed with so many faults."""
    rng = random.Random(f"{seed}/{count}")
    lines = ["0.0 hand rest", "2.0 hand circle 0.1 0.5 1 4 1"]
    lines += [line.replace("operator ", "operator try ", 1) for line in flying.bring_up(0.2) if "wait-event" not in line]
    lines += [f"{at / 10:.1f} operator try ping {rng.choice((*MEMBERS, 'SUPERVISOR'))}" for at in range(15, int(END_S * 10), 5)]
    for _ in range(count):
        lines += rng.choice(FAULTS)(rng)
    lines += [f"{END_S} operator try shutdown"]
    return sorted(lines, key=lambda line: float(line.split()[0]))


def _requests(flight):
    """Requests of the ground, by (APID, sequence count): time of each, in order."""
    found = {}
    for time_ns, direction, raw in flight.packets:
        if direction == "TC" and int.from_bytes(raw[9:11], "big") < ON_BOARD:
            key = int.from_bytes(raw[:2], "big") & 0x7FF, int.from_bytes(raw[2:4], "big") & 0x3FFF
            found.setdefault(key, []).append(time_ns)
    return found


def _endings(flight):
    """(APID, sequence count) of requests -> subtypes of ST[01] that ended them."""
    found = {}
    for _, direction, raw in flight.packets:
        if direction == "TM" and raw[7] == SERVICE_1 and raw[8] in TERMINAL:
            key = int.from_bytes(raw[21:23], "big") & 0x7FF, int.from_bytes(raw[23:25], "big") & 0x3FFF
            destination = int.from_bytes(raw[11:13], "big")
            if destination < ON_BOARD:
                found.setdefault(key, []).append(raw[8])
    return found


def _every_request_ends_once(flight):
    requests, endings, last_ns = _requests(flight), _endings(flight), int((END_S - CUT_S) * NS_PER_S)
    for key in endings.keys() - requests.keys():
        yield f"{key} ended by {endings[key]} and was never asked"
    for key, times in requests.items():
        found = endings.get(key, [])
        due = sum(time_ns < last_ns for time_ns in times)
        if not due <= len(found) <= len(times):
            yield f"request {key} of {[time_ns / NS_PER_S for time_ns in times]} s ended by {found}"


def _log_is_whole(flight):
    """Each number of the packet log once, and all of them in packets.log."""
    numbers = sorted(int(line.split(" ", 1)[0]) for line in flight.read("packets.ascii").splitlines())
    if numbers != list(range(1, len(numbers) + 1)):
        yield "the numbers of packets.ascii are not whole"
    if len(flight.packets) != len(numbers):
        yield f"packets.log has {len(flight.packets)} records of {len(numbers)}"


def _brakes_hold(drives):
    """A joint that neither operates nor comes to rest under control is braked; drives as the truth tells them."""
    for entry in drives:
        if entry["bus"] == "robot" and entry["statusword"] & 0x6F not in MOVING and not entry["brake_engaged"]:
            yield f"joint {entry['node']} at {entry['time_us'] / 1e6} s without its brake in {entry['statusword']:#06x}"


def _states(flight):
    """(time, APID, state) of every TM[129,2]."""
    for time_ns, direction, raw in flight.packets:
        if direction == "TM" and raw[7:9] == b"\x81\x02":
            yield time_ns, int.from_bytes(raw[:2], "big") & 0x7FF, raw[22]


def _state_at(flight, apid, at_ns):
    state = 0
    for time_ns, of, found in _states(flight):
        if of == apid and time_ns <= at_ns:
            state = found
    return state


def _partner_secures_itself(flight, lines):
    """The member whose partner in an open network is killed in operation reaches ERROR_OPERATIONAL by itself."""
    for line in lines:
        words = line.split()
        if words[1:3] != ["fault", "kill"]:
            continue
        at_ns = round(float(words[0]) * NS_PER_S)
        partner = APIDS[MEMBERS[1 - MEMBERS.index(words[3])]]
        if all(_state_at(flight, apid, at_ns) == 5 for apid in APIDS.values()) and not any(
            other is not line and abs(float(other.split()[0]) * NS_PER_S - at_ns) < NS_PER_S and other.split()[1] == "fault" for other in lines
        ):
            came = [time_ns for time_ns, apid, state in _states(flight) if apid == partner and state == 6 and time_ns >= at_ns]
            if not came or came[0] > at_ns + REACTION_NS:
                yield f"{line}: its partner did not reach ERROR_OPERATIONAL within {REACTION_NS / 1e6} ms"


def violations(flight, lines, drives=()):
    """What of the invariants does not hold, in words; drives as the truth of the flight tells them."""
    found = []
    if flight.code is None or flight.code < 0:
        found.append(f"the launcher ended with {flight.code}")
    facts = flight.facts
    if facts["simulated_s"] < END_S:
        found.append(f"the flight ended at {facts['simulated_s']} s: {facts['exit_reason']}")
    if not facts["reproducible"]:
        found.append("the flight is not reproducible")
    for word in ("assertion", "missing", "doubled", "runtime error", "sanitizer"):
        if word in flight.console.lower() or word in flight.output.lower():
            found.append(f"somebody said '{word}'")
    found += _every_request_ends_once(flight)
    found += _log_is_whole(flight)
    found += _brakes_hold(drives)
    found += _partner_secures_itself(flight, lines)
    found += [f"left: {entry}" for entry in flight.leftovers()]
    return found


def fly(folder, seed, count, form="image"):
    """One flight of a seed; the flight and what was violated."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = scenario(seed, count)
    path = flying.write_scenario(folder / f"{seed}-{count}.scn", *lines)
    flight = flying.fly(folder / f"{seed}-{count}-{form}", "--scenario", path, "--form", form)
    return flight, violations(flight, lines, runs.load(flight.folder).truth["DRIVE"])


def main():
    """One seed by hand, or a range of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int, help="first seed")
    parser.add_argument("--count", type=int, default=1, help="number of seeds")
    parser.add_argument("--faults", type=int, default=1, help="faults in each flight")
    parser.add_argument("--form", choices=("image", "processes"), default="image")
    arguments = parser.parse_args()
    place = pathlib.Path(tempfile.mkdtemp(prefix="campaign-"))
    failed = 0
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        _, found = fly(place, seed, arguments.faults, arguments.form)
        folder = place / f"{seed}-{arguments.faults}-{arguments.form}"
        if found:
            failed += 1
            print(f"seed {seed}: {folder}")
            for what in found:
                print(f"    {what}")
        else:
            shutil.rmtree(folder)
    print(f"{arguments.count} flights, {failed} with a violated invariant")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
