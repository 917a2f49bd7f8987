# SPDX-License-Identifier: Apache-2.0
"""The ground link during several lives of communication: it ends and opens at instants of simulated time, and
each request ends once."""

import collections
import itertools
import json
import os

import flying
import lives
import pytest

SUPERVISOR, MEMBERS = 1, (16, 17)
OPERATOR = b"\0\1"
FORMS = {
    "processes": (),
    "again": (),
    "image": ("--form", "image"),
    "processes-udp": ("--links", "udp"),
    "image-udp": ("--form", "image", "--links", "udp"),
    "nodes-udp": ("--nodes", "2", "--links", "udp"),
}
SAME = (("processes", "again", "image"), ("processes-udp", "image-udp", "nodes-udp"))
SCHEDULE = (
    "tc SUPERVISOR 11,22 'n=[{\"group_id\":1,\"group_status\":\"enabled\"}]'",
    "at 4.5 process start COMMUNICATION",
    "tc SUPERVISOR 11,20 n=[1]",
    "schedule enable",
)
# Times at which the operator loses its connection: in the time step after the end of the life that served it,
# or when the hang of that life is detected.
LINK_LOST = (3.0, 4.0, 5.5, 6.5, 7.6)


def _asked(begin_s, count, step_s, step):
    return [f"{begin_s + i * step_s:.4f} operator {step}" for i in range(count)]


def _link_scenario(path):
    """Communication is killed, stopped, started and suspended while the operator sends requests, also before
    the new life listens."""
    lines = ["0.0 hand rest", "2.0 hand circle 0.1 0.5 1 3 1"] + flying.bring_up(0.2)
    lines += ["3.0 fault kill communication"] + _asked(2.98, 60, 0.0005, "try nowait ping MANIPULATOR") + _asked(3.05, 10, 0.01, "ping MANIPULATOR")
    lines += [f"{3.8 + i * 0.02:.3f} operator {step}" for i, step in enumerate(SCHEDULE)]
    lines += ["3.95 operator state COMMUNICATION SAFE_OPERATIONAL", "3.95 operator state COMMUNICATION OFFLINE"]
    lines += ["4.0 operator try process stop COMMUNICATION"] + _asked(3.995, 20, 0.0005, "try nowait ping JOYSTICK")
    lines += _asked(4.2, 3, 0.01, "ping SUPERVISOR") + _asked(4.7, 3, 0.01, "ping MANIPULATOR")
    lines += ["5.0 fault hang communication", "5.01 fault resume COMMUNICATION"] + _asked(5.0, 20, 0.001, "ping MANIPULATOR")
    lines += ["5.5 fault hang communication"] + _asked(5.498, 40, 0.001, "try nowait ping MANIPULATOR")
    lines += ["6.5 fault kill communication", "6.5605 fault kill communication"] + _asked(6.49, 40, 0.002, "try ping MANIPULATOR")
    lines += ["7.6 fault kill communication", "7.6 fault kill joystick"] + _asked(7.59, 30, 0.001, "try nowait ping MANIPULATOR")
    lines += ["9.5 operator ping all", "9.6 operator shutdown"]
    return flying.write_scenario(path, *sorted(lines, key=lambda line: float(line.split()[0])))


def _steps(flight):
    return [json.loads(line) for line in flight.read("operator.log").splitlines()]


def _losses(flight):
    """Entries of the operator's log that report a lost link."""
    return [step for step in _steps(flight) if step["verb"] == "link" and "lost" in step["outcome"]]


def _assert_each_request_ends_once(flight):
    """Expect that every request in the packet log ends once. Returns the number of requests."""
    asked, ended = collections.Counter(), collections.Counter()
    for _, direction, raw in flight.packets:
        if direction == "TC" and raw[9:11] == OPERATOR:
            asked[raw[:4]] += 1
        elif direction == "TM" and raw[7] == 1 and raw[8] in (2, 4, 7, 8, 10) and raw[11:13] == OPERATOR:
            ended[raw[21:25]] += 1
    assert asked == ended
    assert set(asked.values()) == {1}, "expected a different number for each request, also for one that is released later"
    assert not [step for step in _steps(flight) if step["outcome"].startswith("FAILED")]
    return sum(asked.values())


def _assert_numbers_whole(flight):
    """Only communication has a second life: the reports of all other components have consecutive numbers."""
    numbers = collections.defaultdict(list)
    for _, direction, raw in flight.packets:
        if direction == "TM":
            numbers[int.from_bytes(raw[:2], "big") & 0x7FF].append(int.from_bytes(raw[2:4], "big") & 0x3FFF)
    for apid in (SUPERVISOR, *MEMBERS):
        assert all((later - earlier) & 0x3FFF == 1 for earlier, later in itertools.pairwise(numbers[apid])), apid


def _fly(directory, path, *options):
    flight = flying.fly(directory, "--scenario", path, *options)
    assert flight.facts["reproducible"], flight.transcript()
    flying.assert_clean(flight)
    return flight


@pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces of two nodes need root")
def test_the_link_to_ground_ends_and_opens_in_simulated_time(directory):
    """The operator loses its connection with each life of communication at an instant that is the same in
    every form, and so is the instant of its next connection."""
    directory.mkdir()
    path = _link_scenario(directory / "link.scn")
    flights = {name: _fly(directory / name, path, *options) for name, options in FORMS.items()}
    for names, same in ((lives.BUS_LOGS, FORMS), *((("packets.log", "operator.log"), same) for same in SAME)):
        digests = [lives.digest(flights[form], names) for form in same]
        assert all(digest == digests[0] for digest in digests), (names, same)
    _assert_each_request_ends_once(flights["processes"])
    assert [round(step["time"], 1) for step in _losses(flights["processes"])] == list(LINK_LOST)
    assert sum("open again" in step["outcome"] for step in _steps(flights["processes"])) == len(LINK_LOST)


def _burst(at_s, count):
    """Requests to all subsystems at one instant; some have long answers, and requests to communication cannot
    end while it is dead."""
    long = ("schedule list", "ping COMMUNICATION", "hk once MANIPULATOR 4711")
    short = ("ping MANIPULATOR", "ping SUPERVISOR", "ping JOYSTICK")
    return [f"{at_s} operator try nowait {long[i // 20 % 3] if i % 20 == 0 else short[i % 3]}" for i in range(count)]


def test_a_restart_under_load_reports_each_lost_request_and_doubles_none(directory):
    """Queues are full and thousands of requests are in progress: each request ends, unless its loss was
    reported to the ground."""
    directory.mkdir()
    lines = ["0.0 hand rest", "2.0 operator " + SCHEDULE[0]] + flying.bring_up(0.2) + ["2.1 operator at 100 ping MANIPULATOR"] * 60
    lines += _burst(3.0, 1500) + ["3.004 fault kill communication"] + _burst(3.02, 600)
    lines += _burst(4.0, 600) + ["4.003 fault hang communication"] + _burst(4.01, 300)
    lines += _burst(5.0, 1500) + ["5.0035 fault kill communication"]
    lines += ["9.0 operator ping all", "9.5 operator shutdown"]
    path = flying.write_scenario(directory / "load.scn", *sorted(lines, key=lambda line: float(line.split()[0])))
    flights = [_fly(directory / form, path, "--form", form) for form in ("processes", "image")]
    for flight in flights:
        ended = _assert_each_request_ends_once(flight)
        _assert_numbers_whole(flight)
        # `ping all` sends four requests in one line, each of the two `link open` sends two, and `wait-event` sends none: 3 + 2 - 1 more than lines.
        sent = sum(line.split()[1] == "operator" for line in lines) + 4
        lost = sum(int(step["outcome"].split("; ")[1].split()[0]) for step in _losses(flight))
        assert len(_losses(flight)) == 3
        assert ended >= sent - lost > 0
    assert flights[0].octets("packets.log") == flights[1].octets("packets.log")
