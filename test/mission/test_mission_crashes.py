# SPDX-License-Identifier: Apache-2.0
"""Deaths in flight: whichever process is killed, the run ends, reports the process, keeps its logs, and
leaves nothing behind."""

import json
import os
import random
import re
import signal
import sqlite3
import time

import flying
import pytest
from hirosco_gse import run as runs

MEMBERS = {"joystick": 17, "manipulator": 16}
PROCESSES = ("simulator", "supervisor", "joystick", "manipulator", "communication", "operator", "packet-archive-sqlite")
FLIGHT_S = 20
END_S = 60  # Much longer than a process can take to die.
SAFE_WITHIN_US = 20_000


def _kill_at(flight, name, step):
    """Kill a child after this step of the operator. The simulated time of the kill is not exactly
    determined."""
    flying.wait_until(lambda: flight.steps() >= step or flight.process.poll() is not None, f"step {step} of the operator")
    assert flight.process.poll() is None, flight.transcript()
    pid = flight.children()[name]
    os.kill(pid, signal.SIGKILL)


def _lines():
    """Lines of a flight of 20 s: up to OPERATIONAL, the hand in motion, one request to each subsystem every
    second, and down."""
    lines = ["0.0 hand rest", f"2 hand circle 0.1 0.5 1 {FLIGHT_S} 1", "0.0 operator ping all", *flying.bring_up(0.1)]
    for second in range(3, FLIGHT_S):
        steps = {5: "log sqlite", 9: "log ascii", 12: "hk once MANIPULATOR 4711"}
        lines.append(f"{second} operator {steps.get(second, 'ping all')}")
    return [*lines, f"{END_S} operator shutdown"]


STEPS = [line.partition(" operator ")[2] for line in _lines() if " operator " in line]
IN_OPERATION = 1 + STEPS.index("state MANIPULATOR OPERATIONAL")


@pytest.fixture(scope="module")
def scenario(session_directory):
    """File of the flight in which a process dies."""
    return flying.write_scenario(session_directory / "death.scn", *_lines())


def _packets_in_order(flight):
    times = [time_ns for time_ns, _, _ in flight.packets]
    assert times == sorted(times)
    return flight.packets


def _assert_failed_because_of(flight, name):
    """Expect that the run has failed, that its outputs name the process that died, and that nothing is left."""
    assert flight.code not in (0, None), flight.transcript()
    assert flight.code > 0, "the launcher died by a signal"
    assert name in flight.output, f"no message says that {name} died: {flight.output}"
    facts = flight.facts
    assert facts["exit_code"] == flight.code
    assert name in facts["exit_reason"]
    assert facts["reproducible"] is False
    entry = next(entry for entry in facts["processes"] if entry["name"] == name)
    assert entry.get("signal") == 9 or entry["starts"] == 2, "expected the end by SIGKILL, or a second start"
    assert (flight.directory / "report.html").exists(), flight.transcript()
    assert name in flight.read("report.html")
    flying.assert_clean(flight)


def _assert_log_is_complete(flight):
    """Numbers 1..N without gap in both forms of the log, and each line a packet."""
    packets = _packets_in_order(flight)
    assert len(packets) > 40
    for _, _, raw in packets:
        assert int.from_bytes(raw[4:6], "big") + 7 == len(raw)
    with sqlite3.connect(f"file:{flight.directory}/packets.db?mode=ro", uri=True) as database:
        rows = database.execute("SELECT number, raw FROM packet ORDER BY number").fetchall()
    assert [number for number, _ in rows] == list(range(1, len(packets) + 1))
    assert [raw for _, raw in rows] == [raw for _, _, raw in packets]


def _enabled_at_end(flight):
    """Drives that are in operation-enabled at the end of the flight, by the truth."""
    drives = {}
    for entry in runs.load(flight.directory).truth["DRIVE"]:
        drives[entry["bus"], int(entry["node"]), int(entry["axis"])] = entry
    assert len(drives) == 4
    return [drive for drive, entry in drives.items() if flying.is_enabled(entry["statusword"])]


def _left_operation(flight):
    """Drive -> time at which it left operation-enabled for the last time."""
    left, was_enabled = {}, {}
    for entry in runs.load(flight.directory).truth["DRIVE"]:
        drive = entry["bus"], int(entry["node"]), int(entry["axis"])
        is_enabled = entry["statusword"] & 0x6F == 0x27
        if was_enabled.get(drive) and not is_enabled:
            left[drive] = entry["time_us"]
        was_enabled[drive] = is_enabled
    return left


def _states(flight, apid):
    return [raw[22] for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x81\x02" and int.from_bytes(raw[:2], "big") & 0x7FF == apid]


def _die(directory, scenario, name, step, form="processes"):
    flight = flying.start(directory, "--scenario", scenario, "--form", form, report="yes")
    try:
        _kill_at(flight, name, step)
        flight.wait()
    finally:
        flight.abandon()
    return flight


@pytest.mark.parametrize("name", [name if name in ("simulator", "supervisor") else
                                  pytest.param(name, marks=pytest.mark.long) for name in PROCESSES])
def test_a_run_whose_process_is_killed_fails_and_names_the_process(directory, scenario, name):
    """The process is killed after a step of the operator that its name determines."""
    flight = _die(directory, scenario, name, random.Random(name).randint(3, len(STEPS) - 3))
    _assert_failed_because_of(flight, name)
    _assert_log_is_complete(flight)
    if name != "simulator":
        assert not _enabled_at_end(flight)


@pytest.mark.parametrize("name", MEMBERS)
def test_all_drives_leave_operation_when_a_member_is_killed(directory, scenario, name):
    """The other member reaches ERROR_OPERATIONAL without a command; the drives of the dead member leave operation by
    their deadline."""
    flight = _die(directory, scenario, name, IN_OPERATION)
    _assert_failed_because_of(flight, name)
    other = next(apid for member, apid in MEMBERS.items() if member != name)
    assert 6 in _states(flight, other), flight.transcript()
    assert not _enabled_at_end(flight)
    left = _left_operation(flight)
    assert len(left) == 4
    assert max(left.values()) - min(left.values()) <= SAFE_WITHIN_US


@pytest.mark.parametrize("form", ["processes", "image"])
def test_members_go_to_safe_operational_after_too_many_deaths_of_the_supervisor(directory, form):
    """Without a supervisor OPERATIONAL ends in SAFE_OPERATIONAL: actuators off, brakes engaged. After its
    fourth death within a minute the supervisor is not started again."""
    directory.mkdir()
    deaths = [f"{4 + death} fault kill supervisor" for death in range(4)]
    path = flying.write_scenario(directory / "deaths.scn", "0.0 hand rest", *deaths, *flying.bring_up(0.1), f"{END_S} operator shutdown")
    flight = flying.fly(directory / "run", "--scenario", path, "--form", form)
    assert flight.code not in (0, None), flight.transcript()
    flying.assert_clean(flight)
    assert len(_left_operation(flight)) == 4
    assert not _enabled_at_end(flight)
    last = {}
    for entry in runs.load(flight.directory).truth["DRIVE"]:
        last[entry["bus"], int(entry["node"]), int(entry["axis"])] = entry
    assert all(entry["brake_engaged"] for drive, entry in last.items() if drive[0] == "robot")


@pytest.mark.parametrize("form", ["processes", "image"])
def test_a_run_whose_operator_is_killed_before_it_connects_ends(directory, scenario, form):
    """The operator is killed before it has joined the flight: no other process waits for it."""
    flight = flying.start(directory, "--scenario", scenario, "--form", form, report="yes")
    flying.wait_until(lambda: "operator" in flight.children(), "an operator")
    os.kill(flight.children()["operator"], signal.SIGKILL)
    flight.wait()
    _assert_failed_because_of(flight, "operator")


@pytest.mark.parametrize("form", ["processes", "image"])
@pytest.mark.parametrize("lines", [(), ("0.1 operator ping all", "0.2 operator end")])
def test_a_run_ends_after_an_operator_that_does_not_shut_the_mission_down(directory, form, lines):
    """A scenario that does not shut the mission down ends soon after its operator has left."""
    directory.mkdir()
    path = flying.write_scenario(directory / "short.scn", "0.0 hand rest", *lines)
    flight = flying.fly(directory / "run", "--scenario", path, "--form", form)
    assert flight.code == 0, flight.transcript()
    assert flight.facts["reproducible"] is False
    flying.assert_clean(flight)


def _fly_with_a_suspended_process(directory, name):
    flight = flying.start(directory, "--scenario", "telepresence")
    flying.wait_until(lambda: flight.steps() >= 10, "step 10")
    os.kill(flight.children()[name], signal.SIGSTOP)
    flight.wait()
    assert flight.facts["reproducible"] is False
    flying.assert_clean(flight)
    return flight


@pytest.mark.long
@pytest.mark.parametrize("name", ["simulator", "operator"])
def test_the_launcher_ends_a_flight_with_a_suspended_process(directory, name):
    """A suspended process neither ends nor continues, and none can replace it: the launcher ends the flight after
    half a minute."""
    flight = _fly_with_a_suspended_process(directory, name)
    assert flight.code != 0
    assert f"simulated time has stopped; the grant is held by {name}" in flight.facts["exit_reason"]


@pytest.mark.long
def test_a_suspended_subsystem_is_replaced_in_stepped_time(directory):
    """After five seconds of wall-clock time the launcher takes the grant from it, and the supervisor kills it and
    starts it again."""
    flight = _fly_with_a_suspended_process(directory, "joystick")
    said = r"joystick hangs: suspended after ([5-9]\d{3}|\d{5,}) ms without the end of a step, so that the others continue"
    assert re.search(said, flight.transcript() + flight.output)
    assert flight.facts["exit_reason"].startswith("joystick was ended by signal 9"), flight.transcript()
    assert next(entry for entry in flight.facts["processes"] if entry["name"] == "joystick")["starts"] == 2


def _guard_of(flight):
    """Process id of the guard of a flight; None if there is none at this moment."""
    mark = f"guard {flight.identity}".encode()
    return next((pid for pid, line in flying.command_lines() if re.search(re.escape(mark) + rb"(?![0-9])", line)), None)


@pytest.mark.parametrize("form", ["processes", "image"])
def test_the_guard_completes_the_run_of_a_killed_launcher(directory, form):
    """The launcher's children end with it, and its guard does the rest: it removes names and writes logs and
    report."""
    flight = flying.start(directory, "--scenario", "telepresence", "--form", form, report="yes")
    flying.wait_until(lambda: flight.steps() >= 10, "step 10")
    children = flight.children()
    assert len(children) >= 3
    flight.process.kill()
    flight.wait()
    flying.wait_until(lambda: not [pid for pid, _, _ in flying.processes() if pid in children.values()], "children and guard end")
    flying.assert_clean(flight)
    assert "failed: the launcher was killed" in flight.output
    assert flight.facts["exit_reason"].startswith("the launcher was killed")
    assert flight.facts["exit_code"] == 1 and flight.facts["reproducible"] is False
    assert flight.facts["simulated_s"] > 0
    assert "launcher was killed" in flight.read("report.html")
    _assert_log_is_complete(flight)


@pytest.mark.parametrize("moment_s", [0.0, 0.002, 0.005, 0.01, 0.02])
def test_nothing_is_left_of_a_launcher_that_is_killed_before_the_flight(directory, moment_s):
    """Kill the launcher as soon as there is a guard: everything that exists of the run by then is removed."""
    flight = flying.start(directory, "--scenario", "commissioning")
    flying.wait_until(lambda: _guard_of(flight) or flight.process.poll() is not None, "a guard")
    time.sleep(moment_s)
    flight.process.kill()
    flight.wait()
    flying.assert_clean(flight)
    is_over = flight.code == 0  # The flight ended before the launcher was killed.
    assert is_over or not directory.exists() or not (directory / "ground.port").exists() or flight.facts["exit_code"] == 1


def _with_another_guard(directory, scenario):
    """A flight whose guard was killed. The simulator is suspended, so that the flight does not end before the
    test detects the new guard."""
    flight = flying.start(directory, "--scenario", scenario)
    flying.wait_until(lambda: flight.steps() >= 1, "step 1")
    simulator = flight.children()["simulator"]
    os.kill(simulator, signal.SIGSTOP)
    first = _guard_of(flight)
    os.kill(first, signal.SIGKILL)
    flying.wait_until(lambda: _guard_of(flight) not in (None, first), "another guard")
    return flight, simulator


def test_another_guard_replaces_a_killed_one(directory, scenario):
    """The second guard, too, completes the run when the launcher is killed."""
    flight, _ = _with_another_guard(directory, scenario)
    flight.process.kill()
    flight.wait()
    assert "the guard of the run was killed" in flight.output
    assert flight.facts["exit_reason"].startswith("the launcher was killed")
    flying.assert_clean(flight)


def test_a_run_reports_that_its_guard_was_killed(directory, scenario):
    flight, simulator = _with_another_guard(directory, scenario)
    os.kill(simulator, signal.SIGCONT)
    flight.wait()
    assert flight.code == 0, flight.transcript()
    assert flight.facts["guards"] == 2 and flight.facts["reproducible"] is True
    flying.assert_clean(flight)


def test_a_run_whose_image_is_killed_fails_and_keeps_its_packet_log(directory, scenario):
    flight = _die(directory, scenario, "image", IN_OPERATION, form="image")
    _assert_failed_because_of(flight, "image")
    assert len(_packets_in_order(flight)) > 40


def test_logs_up_to_the_last_seconds_survive_the_death_of_the_simulator(directory, scenario):
    """Logs are flushed every simulated second: bus logs and truth end at most 2.5 s before the
    death, and only their last entry may be incomplete."""
    flight = _die(directory, scenario, "simulator", len(STEPS) - 4)
    end_s = max(int(float(json.loads(line)["end"])) for line in flight.read("operator.log").splitlines())
    run = runs.load(flight.directory)
    for log in (run.buses["robot"], run.buses["joystick"]):
        assert log.time_us[-1] / 1e6 > end_s - 2.5
    assert not [problem for problem in run.problems if "truth" in problem or "can-" in problem]


def test_an_interrupted_flight_shuts_down_in_order(directory, scenario):
    """Ctrl-C during the flight: the members go to OFFLINE, no drive is enabled, nothing is left."""
    flight = flying.start(directory, "--scenario", scenario, report="yes")
    flying.wait_until(lambda: flight.steps() >= IN_OPERATION, "operation")
    os.kill(flight.process.pid, signal.SIGINT)
    flight.wait()
    for apid in MEMBERS.values():
        assert _states(flight, apid)[-1] == 0, flight.transcript()
    assert not _enabled_at_end(flight)
    assert flight.facts["reproducible"] is False
    flying.assert_clean(flight)


def test_a_run_that_is_interrupted_three_times_ends_at_once(directory):
    flight = flying.start(directory, "--scenario", "none", "--time", "real")
    flight.port()
    time.sleep(0.5)
    for _ in range(3):
        os.kill(flight.process.pid, signal.SIGINT)
        time.sleep(0.05)
    flight.wait()
    assert flight.code != 0 or _states(flight, 16)[-1:] in ([], [0])
    flying.assert_clean(flight)


@pytest.mark.long
@pytest.mark.parametrize("number", range(40))
def test_nothing_is_left_after_the_kill_of_any_process_at_any_instant(directory, number):
    """Many deaths; the number determines the process and the instant of wall-clock time."""
    rng = random.Random(number)
    name, moment = rng.choice(PROCESSES), rng.uniform(0.05, 3.5)
    flight = flying.start(directory, "--scenario", "telepresence", report="yes")
    time.sleep(moment)
    pid = flight.children().get(name)
    if pid is not None:
        os.kill(pid, signal.SIGKILL)
    flight.wait()
    if flight.code != 0:
        assert (flight.directory / "run.json").exists()
        assert (flight.directory / "report.html").exists()
        assert re.search(r"failed: \S", flight.output), flight.output
    flying.assert_clean(flight)
