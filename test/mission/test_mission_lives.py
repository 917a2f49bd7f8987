# SPDX-License-Identifier: Apache-2.0
"""Lives of processes: stop, start, kill, hang and restart are operations of simulated time, the same in every form."""

import hashlib
import itertools
import os
import signal

import pytest

import flying

SLOT_NS = 500_000
BUS_LOGS = ("can-robot.log", "can-joystick.log", "can-robot-b.log", "can-joystick-b.log")
PING = b"\x11\x01"
ALIVE = b"\x11\x02"
PINGS = 20  # after each change of a life


def _pings(begin_s, count=PINGS, step_s=0.01):
    return [f"{begin_s + i * step_s:.3f} operator ping MANIPULATOR" for i in range(count)]


def _scenario(path):
    """Every kind of end and start, at rest and in operation, some of them within one tick of the supervisor."""
    lines = ["0.0 hand rest"]
    lines += flying.bring_up(0.2)
    lines += ["7.0 hand circle 0.1 0.5 1 3 1"]
    lines += ["3.0 fault kill manipulator"] + _pings(3.2)
    lines += ["3.6 operator process stop MANIPULATOR", "3.601 operator process start MANIPULATOR"] + _pings(3.7)
    lines += ["4.0 operator process stop MANIPULATOR", "6.0 operator process start MANIPULATOR"] + _pings(6.1)
    lines += ["6.5 fault hang JOYSTICK", "6.51 fault resume JOYSTICK"] + _pings(6.6, 3)
    lines += ["7.0 fault hang manipulator", "7.3 fault resume manipulator"] + _pings(8.2)
    lines += ["8.6 fault kill joystick", "8.6 operator expect-refusal 0x0408 ping JOYSTICK", "9.0 operator ping all", "9.1 operator shutdown"]
    return flying.write_scenario(path, *sorted(lines, key=lambda line: float(line.split()[0])))


def _fly(folder, name, path, *options):
    flight = flying.fly(folder / name, "--scenario", path, *options)
    assert flight.facts["reproducible"], flight.told()
    flying.assert_clean(flight)
    return flight


def _digest(flight, names):
    return {name: hashlib.sha256(flight.octets(name)).hexdigest() for name in names}


def _answers(flight):
    """Nanoseconds from each ping of the arm that was answered to its answer, in order."""
    asked = []
    for time_ns, direction, raw in flight.packets:
        if int.from_bytes(raw[:2], "big") & 0x7FF != 16:
            continue
        if direction == "TC" and raw[7:9] == PING:
            asked.append(time_ns)
        elif direction == "TM" and raw[7:9] == ALIVE:
            yield time_ns - asked.pop(0)


FORMS = {
    "processes": (),
    "image": ("--form", "image"),
    "processes-udp": ("--links", "udp"),
    "image-udp": ("--form", "image", "--links", "udp"),
    "nodes-udp": ("--nodes", "2", "--links", "udp"),
}


@pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces of two nodes need root")
def test_lives_are_the_same_in_every_form_and_repeat(folder):
    folder.mkdir()
    path = _scenario(folder / "lives.scn")
    flights = {name: _fly(folder, name, path, *options) for name, options in FORMS.items()}
    flights["again"] = _fly(folder, "again", path)
    buses = [_digest(flight, BUS_LOGS) for flight in flights.values()]
    assert all(bus == buses[0] for bus in buses), list(flights)
    for same in (("processes", "image", "again"), ("processes-udp", "image-udp", "nodes-udp")):
        for one, other in itertools.pairwise(same):
            assert flights[one].octets("packets.log") == flights[other].octets("packets.log"), (one, other)
    answers = list(_answers(flights["processes"]))
    assert len(answers) >= 3 * PINGS
    assert max(answers) <= 2 * SLOT_NS


HUNG = (30).to_bytes(2, "big")
HIGH_EVENT = b"\x05\x04"


def _hung(flight):
    """APIDs of the processes that the supervisor has told to hang."""
    return {
        int.from_bytes(raw[23:25], "big")
        for _, direction, raw in flight.packets
        if direction == "TM" and raw[7:9] == HIGH_EVENT and raw[21:23] == HUNG
    }


@pytest.mark.parametrize(("name", "apid"), [("joystick", 17), ("manipulator", 16), ("communication", 2)])
def test_a_process_that_stands_still_does_not_stop_the_others(folder, name, apid):
    """By the wall clock: it is found by its beat, killed and started again; simulated time goes on without it."""
    flight = flying.start(folder, "--time", "real", "--scenario", "none")
    try:
        flight.port()
        flying.wait_until(lambda: "alive" in flying.gse(flight, "ping", "SUPERVISOR").stdout, "the supervisor does not answer")
        stopped = flight.children()[name]
        os.kill(stopped, signal.SIGSTOP)
        flying.wait_until(lambda: flight.children().get(name, stopped) != stopped, f"{name} was not started again")
        flying.wait_until(lambda: "COMMUNICATION is alive" in flying.gse(flight, "ping", "all").stdout, "not all are there again")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert apid in _hung(flight), flight.told()
    assert not flight.facts["reproducible"]
    assert "hangs: suspended" in flight.told() + flight.output
    flying.assert_clean(flight)


def test_free_running_processes_fly_and_one_that_stands_still_is_replaced(folder):
    """Every process by its own clock, the simulator as a peer: no identity is claimed, lateness is reported."""
    flight = flying.start(folder, "--time", "free", "--scenario", "none")
    try:
        flight.port()
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "not all are there")
        for name in ("JOYSTICK", "MANIPULATOR"):
            assert "completed" in flying.gse(flight, "state", name, "PRE_OPERATIONAL").stdout  # its devices answer on the bus
        stopped = flight.children()["joystick"]
        os.kill(stopped, signal.SIGSTOP)
        flying.wait_until(lambda: flight.children().get("joystick", stopped) != stopped, "it was not started again")
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "not all are there again")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert 17 in _hung(flight), flight.told()
    facts = flight.facts
    assert facts["time"] == "free"
    assert not facts["reproducible"]
    steps = {child["name"]: child["late_steps"] for child in facts["processes"] if "late_steps" in child}
    assert set(steps) == {"joystick", "manipulator", "supervisor", "communication"}
    assert all(len(classes) == 5 and sum(classes) > 0 for classes in steps.values())
    flying.assert_clean(flight)
