# SPDX-License-Identifier: Apache-2.0
"""The ground link over the lives of communication: it ends and opens in simulated time, and each request ends once."""

import collections
import json
import os

import flying
import lives
import pytest

OPERATOR = b"\0\1"
START_PROCESS = b"\x83\x06"
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
LINK_LOST = (3.0, 4.0, 5.5, 6.5, 7.6)  # In the slot behind the end of each life that served the operator, or as soon as its hang is found.


def _asked(begin_s, count, step_s, step):
    return [f"{begin_s + i * step_s:.4f} operator {step}" for i in range(count)]


def _link_scenario(path):
    """Communication is killed, stopped, started and hung while the operator asks, also before its new life listens."""
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


def _assert_each_request_ends_once(flight):
    """Every request in the packet log has one completion there; the operator was answered, or told that the link was lost."""
    asked, ended, scheduled = collections.Counter(), collections.Counter(), set()
    for _, direction, raw in flight.packets:
        if direction == "TC" and raw[9:11] == OPERATOR:
            asked[raw[:4]] += 1
            scheduled |= {raw[:4]} if raw[7:9] == START_PROCESS else set()
        elif direction == "TM" and raw[7] == 1 and raw[8] in (2, 4, 7, 8, 10) and raw[11:13] == OPERATOR:
            ended[raw[21:25]] += 1
    assert asked == ended
    assert {request for request, count in asked.items() if count > 1} == scheduled, "it has the number of another one"
    steps = _steps(flight)
    assert not [step for step in steps if step["outcome"].startswith("FAILED")]
    lost = [step for step in steps if step["verb"] == "link" and "lost" in step["outcome"]]
    assert [round(step["time"], 1) for step in lost] == list(LINK_LOST), lost
    assert sum(step["verb"] == "link" and "open again" in step["outcome"] for step in steps) == len(LINK_LOST)


def _fly(folder, path, *options):
    flight = flying.fly(folder, "--scenario", path, *options)
    assert flight.facts["reproducible"], flight.told()
    flying.assert_clean(flight)
    return flight


@pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces of two nodes need root")
def test_the_link_to_ground_ends_and_opens_in_simulated_time(folder):
    """The operator loses its connection with each life of communication, at one instant, and gets the next in the same way in every form."""
    folder.mkdir()
    path = _link_scenario(folder / "link.scn")
    flights = {name: _fly(folder / name, path, *options) for name, options in FORMS.items()}
    for names, same in ((lives.BUS_LOGS, FORMS), *((("packets.log", "operator.log"), same) for same in SAME)):
        digests = [lives.digest(flights[form], names) for form in same]
        assert all(digest == digests[0] for digest in digests), (names, same)
    _assert_each_request_ends_once(flights["processes"])
