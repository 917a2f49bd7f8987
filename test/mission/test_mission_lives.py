# SPDX-License-Identifier: Apache-2.0
"""Lives of processes: stop, start, kill, hang and restart take place in simulated time and are the same in
every form."""

import collections
import itertools
import os
import shutil
import signal

import pytest

import campaign_rules
import flying
import lives

FORMS = {
    "processes": (),
    "image": ("--form", "image"),
    "processes-udp": ("--links", "udp"),
    "image-udp": ("--form", "image", "--links", "udp"),
    "nodes-udp": ("--nodes", "2", "--links", "udp"),
}


SAME = (("processes", "image"), ("processes-udp", "image-udp", "nodes-udp"))
REPEATS = 20
needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces of two nodes need root")


@needs_root
def test_lives_are_the_same_in_every_form_and_repeat(directory):
    directory.mkdir()
    path = lives.scenario(directory / "lives.scn")
    flights = {name: lives.fly(directory / name, path, *options) for name, options in FORMS.items()}
    flights["again"] = lives.fly(directory / "again", path)
    buses = [lives.digest(flight) for flight in flights.values()]
    assert all(bus == buses[0] for bus in buses), list(flights)
    for same in ((*SAME[0], "again"), SAME[1]):
        for one, other in itertools.pairwise(same):
            assert flights[one].octets("packets.log") == flights[other].octets("packets.log"), (one, other)


@needs_root
@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("forms", SAME, ids=["shm", "udp"])
def test_twenty_repeats_give_one_checksum(directory, forms):
    """Stops, kills, hangs and restarts, twenty times in each form: each log has the same checksum every time."""
    directory.mkdir()
    path, sums = lives.scenario(directory / "lives.scn"), set()
    for name in forms:
        for number in range(REPEATS):
            flight = lives.fly(directory / f"{name}-{number}", path, *FORMS[name])
            sums.add(tuple(lives.digest(flight, ("packets.log", *lives.BUS_LOGS)).values()))
            shutil.rmtree(flight.directory)
            assert len(sums) == 1, (name, number)


def _stops_under_way(path):
    """Write a scenario in which the arm is stopped and started ten times, while three pings are sent to it in
    each time step."""
    lines = ["0.0 hand rest"]
    for stop_s in (1.0 + number * 0.1005 for number in range(10)):
        lines += [f"{stop_s + step * 0.0005:.4f} operator try nowait ping MANIPULATOR" for step in range(-8, 8) for _ in range(3)]
        lines += [f"{stop_s:.4f} operator process stop MANIPULATOR", f"{stop_s + 0.02:.4f} operator process start MANIPULATOR"]
    lines += ["3.0 operator ping all", "3.1 operator shutdown"]
    return flying.write_scenario(path, *sorted(lines, key=lambda line: float(line.split()[0])))


@pytest.mark.parametrize("time", ["stepped", "free"])
def test_a_request_ends_once_although_its_addressee_is_stopped(directory, time):
    directory.mkdir()
    flight = flying.fly(directory / "run", "--scenario", _stops_under_way(directory / "stops.scn"), "--time", time)
    assert "FAILED" not in flight.console and "MANIPULATOR is alive" in flight.console, flight.transcript()
    asked = collections.Counter(raw[:4] for _, direction, raw in flight.packets if direction == "TC" and raw[9:11] == b"\0\1")
    reports = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7] == 1 and raw[11:13] == b"\0\1"]
    ended = collections.Counter(raw[21:25] for raw in reports if raw[8] in campaign_rules.TERMINAL)
    assert sum(asked.values()) > 500
    assert asked == ended
    # Completed or refused.
    assert {raw[8] for raw in reports if raw[8] in campaign_rules.TERMINAL} >= {7, 10}
    flying.assert_clean(flight)


HUNG = (30).to_bytes(2, "big")
HIGH_EVENT = b"\x05\x04"


def _hung(flight):
    """APIDs of the processes whose hang the supervisor has reported."""
    return {
        int.from_bytes(raw[23:25], "big")
        for _, direction, raw in flight.packets
        if direction == "TM" and raw[7:9] == HIGH_EVENT and raw[21:23] == HUNG
    }


@pytest.mark.parametrize(("name", "apid"), [
    pytest.param("joystick", 17, marks=pytest.mark.long), ("manipulator", 16), pytest.param("communication", 2, marks=pytest.mark.long)])
def test_a_process_that_hangs_does_not_stop_the_others(directory, name, apid):
    """In wall-clock time the supervisor detects the hang by the missing beat and has the process killed and
    started again; simulated time does not wait for the process."""
    flight = flying.start(directory, "--time", "real", "--scenario", "none")
    try:
        flight.port()
        flying.wait_until(lambda: "alive" in flying.gse(flight, "ping", "SUPERVISOR").stdout, "an answer of the supervisor")
        stopped = flight.children()[name]
        os.kill(stopped, signal.SIGSTOP)
        flying.wait_until(lambda: flight.children().get(name, stopped) != stopped, f"another life of {name}")
        flying.wait_until(lambda: "COMMUNICATION is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems after the restart")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert apid in _hung(flight), flight.transcript()
    assert not flight.facts["reproducible"]
    assert "hangs: suspended after" in flight.transcript() + flight.output
    flying.assert_clean(flight)


def test_free_running_processes_fly_and_one_that_hangs_is_replaced(directory):
    """Every process has its own clock, also the simulator: the run is reported as not reproducible, and late
    steps are reported."""
    flight = flying.start(directory, "--time", "free", "--scenario", "none")
    try:
        flight.port()
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems")
        for name in ("JOYSTICK", "MANIPULATOR"):
            # The devices of the simulator answer on the bus.
            assert "completed" in flying.gse(flight, "state", name, "PRE_OPERATIONAL").stdout
        # A subsystem that drives devices has the priority of its descriptor, 80, as the simulator has, if the
        # system permits it.
        assert len({os.sched_getparam(flight.children()[name]).sched_priority for name in ("joystick", "manipulator", "simulator")}) == 1
        stopped = flight.children()["joystick"]
        os.kill(stopped, signal.SIGSTOP)
        flying.wait_until(lambda: flight.children().get("joystick", stopped) != stopped, "another life of the joystick")
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems after the restart")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert 17 in _hung(flight), flight.transcript()
    facts = flight.facts
    assert facts["time"] == "free"
    assert not facts["reproducible"]
    steps = {child["name"]: child["late_steps"] for child in facts["processes"] if "late_steps" in child}
    assert set(steps) == {"joystick", "manipulator", "supervisor", "communication"}
    assert all(len(classes) == 5 and sum(classes) > 0 for classes in steps.values())
    flying.assert_clean(flight)


@pytest.mark.parametrize("kind", ["real", "free"])
def test_a_supervisor_that_hangs_is_replaced(directory, kind):
    """In wall-clock time the next life of the supervisor forwards requests again."""
    flight = flying.start(directory, "--time", kind, "--scenario", "none")
    try:
        flight.port()
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems")
        stopped = flight.children()["supervisor"]
        os.kill(stopped, signal.SIGSTOP)
        flying.wait_until(lambda: flight.children().get("supervisor", stopped) != stopped, "another life of the supervisor")
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems after the restart")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert "supervisor was ended by signal 9 and was restarted" in flight.transcript(), flight.transcript()
    flying.assert_clean(flight)


SLEEP = "sleep 4711.5"


def _assert_gone(flight):
    flying.assert_clean(flight)
    assert not [line for _, line in flying.command_lines() if line == SLEEP.encode()]


def _programs(directory):
    """Copy the programs; the second life of the joystick starts, but never joins the run."""
    programs, count = directory / "programs", directory / "starts"
    directory.mkdir()
    shutil.copytree(flying.BIN, programs)
    (programs / "joystick").rename(programs / "joystick.plain")
    script = programs / "joystick"
    script.write_text(
        f'#!/bin/sh\necho >>"{count}"\n[ "$(wc -l <"{count}")" -eq 2 ] && exec {SLEEP}\nexec "{programs}/joystick.plain" "$@"\n', encoding="utf-8"
    )
    script.chmod(0o755)
    return programs


def test_a_start_that_does_not_join_is_ended_and_time_continues(directory):
    """In stepped time, simulated time stands still for ten seconds of wall-clock time; then the launcher kills
    the life that has not joined, and the next life joins."""
    programs = _programs(directory)
    lines = ["0.0 hand rest", "0.5 fault kill joystick", "0.52 operator ping MANIPULATOR", "3.0 operator ping all", "3.1 operator shutdown"]
    flight = flying.fly(directory / "run", "--scenario", flying.write_scenario(directory / "join.scn", *lines), binaries=programs)
    assert "has not joined the run within 10 s: killed" in flight.transcript(), flight.transcript()
    assert "FAILED" not in flight.console and "JOYSTICK is alive" in flight.console, flight.transcript()
    assert (directory / "starts").read_text().count("\n") == 3
    assert not flight.facts["reproducible"]
    _assert_gone(flight)


@pytest.mark.parametrize("kind", ["real", pytest.param("free", marks=pytest.mark.long)])  # Ten seconds of wall-clock time.
def test_no_process_waits_for_a_start_in_real_time(directory, kind):
    """The other processes answer while a life of the joystick makes no step; the launcher kills this life, and the next life answers."""
    flight = flying.start(directory / "run", "--time", kind, "--scenario", "none", binaries=_programs(directory))
    try:
        flight.port()
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems")
        os.kill(next(pid for name, pid in flight.children().items() if name.startswith("joystick")), signal.SIGKILL)
        flying.wait_until(lambda: (directory / "starts").read_text().count("\n") == 2, "a second start of the joystick")
        for _ in range(3):
            assert "MANIPULATOR is alive" in flying.gse(flight, "ping", "MANIPULATOR").stdout
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems after the restart")
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    assert "has not made a step within 10 s: killed" in flight.transcript(), flight.transcript()
    _assert_gone(flight)
