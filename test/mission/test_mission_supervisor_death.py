# SPDX-License-Identifier: Apache-2.0
"""The supervisor dies in a busy flight and is started again: only the packet log shows it.

A point is an instant of simulated time at which `fault kill supervisor` kills it between two steps. A call is a
system call within a step at which kill_point.c kills it: 2 n before system call n, 2 n + 1 when system call n returns.
To repeat a failed flight alone:

    POINTS=2.1335,2.7120 build/venv/bin/python -m pytest test/mission/test_mission_supervisor_death.py -k by_points
    CALLS=5310 build/venv/bin/python -m pytest test/mission/test_mission_supervisor_death.py -k by_calls"""

import os
import pathlib
import random
import shutil
import sqlite3
import subprocess

import flying
import pytest
from hirosco_gse import packets

STEP_S = 0.0005
BOOT_S = 0.050  # Boot time of the supervisor if its mission does not define one.
FOUND_S = 0.031  # Time until a hang is detected: the announced step (10 ms), 20 ms, and a step of a member.
BRINGING_UP_S = (0.1, 1.5)
BUSY_S = (2.0, 3.8)
END_S = 4.4
TICK_S = 0.010  # Steps of the supervisor are at most this far apart.
APART_S = 0.2  # Least time between two points of one flight.
FLIGHTS, LONG_FLIGHTS = 4, 500  # Numbers of flights, each with two points.
CALLS, LONG_CALLS = 4, 300
PARTS = 20  # Number of tests of a long campaign.
RESTARTED = bytes.fromhex("0014")
SUPERVISOR = 1
RESTARTED_CODE = 0x040B


def _lines():
    """Lines that bring both members into operation, then commands of every kind without an effect on a
    bus."""
    steps = [
        "ping MANIPULATOR",
        "nowait ping JOYSTICK",
        "nowait ping COMMUNICATION",
        "nowait ping SUPERVISOR",
        "at +0.2 ping MANIPULATOR",
        "hk once MANIPULATOR 4711",
        "nowait ping MANIPULATOR",
        "link list",
        "log sqlite",
        "at +0.15 ping JOYSTICK",
        "networks",
        "get MANIPULATOR.TORQUE_OFFSET",
        "log ascii",
        "log ring",
        "status",
        "nowait ping MANIPULATOR",
        "schedule list",
    ]
    lines = ["0.0 hand rest", "1.8 hand circle 0.1 0.5 1 3 1", *flying.bring_up(0.1)]
    schedule = ("tc SUPERVISOR 11,22 'n=[{\"group_id\":1,\"group_status\":\"enabled\"}]'", "at +0.5 ping MANIPULATOR", "tc SUPERVISOR 11,20 n=[1]", "schedule enable")
    lines += [f"1.6 operator {step}" for step in schedule]
    time_s, count = BUSY_S[0], 0
    while time_s < BUSY_S[1]:
        lines.append(f"{time_s:.4f} operator {steps[count % len(steps)]}")
        time_s, count = time_s + 0.01, count + 1
    return [*lines, f"{END_S} operator shutdown"]


def _write(directory, name, points=()):
    kills = [f"{point:.4f} fault kill supervisor" for point in points]
    return flying.write_scenario(directory / f"{name}.scn", *kills, *_lines())


@pytest.fixture(scope="module")
def undisturbed(session_directory):
    """The flight without a death of the supervisor."""
    flight = flying.fly(session_directory / "alive", "--scenario", _write(session_directory, "alive"), "--port", flying.free_port())
    assert flight.code == 0, flight.transcript()
    return flight


def _fly(directory, points, form="processes"):
    directory.mkdir(exist_ok=True)
    name = f"{round(points[0] / STEP_S)}-{form}"
    return flying.fly(directory / name, "--scenario", _write(directory, name, points), "--form", form, "--port", flying.free_port())


def _draw(count, seed, part=BUSY_S):
    """Draw pairs of instants in a part of the flight."""
    drawn, pairs = random.Random(seed), []
    first, last = (round(time_s / STEP_S) for time_s in part)
    while len(pairs) < count:
        pair = sorted(drawn.randrange(first, last) * STEP_S for _ in range(2))
        if pair[1] - pair[0] >= APART_S:
            pairs.append(pair)
    return pairs


@pytest.fixture(scope="module")
def mortal(session_directory):
    """Programs whose supervisor can be killed during a step."""
    programs = session_directory / "mortal"
    shutil.copytree(flying.BIN, programs)
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", programs / "kill.so", pathlib.Path(__file__).with_name("kill_point.c"), "-ldl"], check=True)
    (programs / "supervisor").rename(programs / "supervisor.plain")
    (programs / "supervisor").write_text(f'#!/bin/sh\nLD_PRELOAD="{programs}/kill.so" exec "{programs}/supervisor.plain" "$@"\n', encoding="utf-8")
    (programs / "supervisor").chmod(0o755)
    return programs


def _fly_to_call(directory, mortal, lines, call):
    """Fly with the death of the supervisor at a call, numbered as in CALLS (0: without a death). Returns the flight and, if there was no
    death, the number of system calls."""
    directory.mkdir(parents=True, exist_ok=True)
    mark = directory / f"{call}.mark"
    path = flying.write_scenario(directory / f"call-{call}.scn", *lines)
    environment = {"KILL_POINT": str(call), "KILL_MARK": str(mark)} if call else {"KILL_MARK": str(mark)}
    flight = flying.fly(directory / f"call-{call}", "--scenario", path, "--port", flying.free_port(), binaries=mortal, environment=environment)
    return flight, int(mark.read_text(encoding="ascii") or "0")


# ---- Invariants after each death ----


def _apid(raw):
    return int.from_bytes(raw[:2], "big") & 0x7FF


def _assert_log_is_whole(flight):
    with sqlite3.connect(f"file:{flight.directory}/packets.db?mode=ro", uri=True) as database:
        numbers = [number for (number,) in database.execute("SELECT number FROM packet ORDER BY number")]
    assert numbers == list(range(1, len(flight.packets) + 1))


def _assert_nothing_is_doubled_or_missing(flight):
    """Expect consecutive sequence counts in the reports of each application."""
    counts = {}
    for time_ns, direction, raw in flight.packets:
        if direction == "TM":
            apid, count = _apid(raw), int.from_bytes(raw[2:4], "big") & 0x3FFF
            assert count == counts.get(apid, -1) + 1, f"APID {apid} at {time_ns} ns"
            counts[apid] = count


def _assert_each_request_ends_once(flight):
    """Expect one completion or one failure of each telecommand that requests completion. Returns the number
    of those that ended because of the restart."""
    requests, ends, restarted = {}, {}, 0
    for _, direction, raw in flight.packets:
        if direction == "TC" and raw[6] & 0x08:
            identity = raw[:4] + raw[9:11]  # APID, sequence count and source of the request.
            requests[identity] = requests.get(identity, 0) + 1
        elif direction == "TM" and raw[7] == 1 and raw[8] in (2, 4, 7, 8, 10):
            identity = raw[21:25] + raw[11:13]
            ends[identity] = ends.get(identity, 0) + 1
            restarted += raw[8] == 8 and int.from_bytes(raw[25:27], "big") == RESTARTED_CODE
    assert requests
    for identity, times in requests.items():
        assert ends.get(identity, 0) == times, f"request {identity.hex()}"
    return restarted


def _assert_links_stay_fresh(flight):
    stale = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == bytes([130, 10]) and raw[24] == 4]
    assert not stale


def _returns_s(flight):
    """Times at which each next supervisor reported its restart, and the last record before."""
    times_s, found = [0.0], []
    for time_ns, direction, raw in flight.packets:
        if time_ns / 1e9 > times_s[-1]:
            times_s.append(time_ns / 1e9)
        if direction == "TM" and _apid(raw) == SUPERVISOR and raw[7:9] == bytes([5, 2]) and raw[21:23] == RESTARTED:
            found.append((times_s[-1], times_s[-2]))
    return found


def _assert_continues(flight, deaths, end_s=END_S):
    # A death makes a run of processes fail.
    assert flight.code == (0 if flight.facts["form"] == "image" else 1), flight.transcript()
    assert flight.facts["simulated_s"] >= end_s
    assert len(_returns_s(flight)) == deaths
    _assert_log_is_whole(flight)
    _assert_nothing_is_doubled_or_missing(flight)
    _assert_links_stay_fresh(flight)
    _assert_each_request_ends_once(flight)
    flying.assert_clean(flight)


def _assert_continues_after(flight, points, end_s=END_S):
    _assert_continues(flight, len(points), end_s)
    for (back_s, _), point in zip(_returns_s(flight), points):
        assert back_s - point <= BOOT_S + 3 * STEP_S + 1e-9


def _assert_continues_after_call(flight):
    _assert_continues(flight, 1)
    for back_s, last_s in _returns_s(flight):
        assert back_s - last_s <= TICK_S + BOOT_S + 3 * STEP_S + 1e-9


def _assert_only_the_packet_log_differs(flight, undisturbed):
    for name in flying.BUS_LOGS:
        assert flight.octets(name) == undisturbed.octets(name), name


def _fly_all(directory, undisturbed, pairs):
    """Fly each pair of deaths and check the flight. From BUSY_S on, no command has an effect on a bus, so
    the bus logs must equal those of the undisturbed flight."""
    for points in pairs:
        flight = _fly(directory, points)
        try:
            _assert_continues_after(flight, points)
            assert flight.facts["reproducible"] is True
            if points[0] >= BUSY_S[0]:
                _assert_only_the_packet_log_differs(flight, undisturbed)
        except AssertionError as error:
            raise AssertionError(f"POINTS={','.join(f'{point:.4f}' for point in points)}: {error}") from error
        shutil.rmtree(flight.directory)


def _fly_all_calls(directory, mortal, undisturbed, calls):
    for call in calls:
        flight, _ = _fly_to_call(directory, mortal, _lines(), call)
        try:
            _assert_continues_after_call(flight)
            _assert_only_the_packet_log_differs(flight, undisturbed)
        except AssertionError as error:
            raise AssertionError(f"CALLS={call}: {error}") from error
        shutil.rmtree(flight.directory)


# ---- Tests ----


def test_flight_without_faults_is_complete(undisturbed):
    """The checks succeed in a flight without a death."""
    _assert_log_is_whole(undisturbed)
    _assert_nothing_is_doubled_or_missing(undisturbed)
    assert _assert_each_request_ends_once(undisturbed) == 0


def test_a_death_by_points_changes_only_the_packet_log(directory, undisturbed):
    """The instants are drawn from a seed, or those of POINTS."""
    named = [[float(text) for text in pair.split(",")] for pair in os.environ.get("POINTS", "").split()]
    _fly_all(directory, undisturbed, named or _draw(FLIGHTS, "short"))


def test_a_mission_continues_after_a_death_during_bring_up(directory, undisturbed):
    """Configurations, negotiations and transitions in progress continue."""
    _fly_all(directory, undisturbed, _draw(FLIGHTS // 2, "up", BRINGING_UP_S))


@pytest.mark.long
@pytest.mark.parametrize("part", range(PARTS))
def test_a_mission_continues_after_a_death_by_many_points(directory, undisturbed, part):
    """A thousand instants, two in each flight; one in ten is during the bring-up of the members."""
    count = LONG_FLIGHTS // PARTS
    _fly_all(directory, undisturbed, _draw(count // 10, part, BRINGING_UP_S) + _draw(count - count // 10, part))


def test_a_supervisor_that_hangs_is_killed_and_started_again(directory):
    """The members detect a hang by the missing beat, at the same instant in every form; after a shorter hang
    the supervisor continues."""
    directory.mkdir()
    for name, words, ends in (("hang", ["2.5 fault hang supervisor"], 1), ("short_hang", ["2.5 fault hang supervisor", "2.52 fault resume supervisor"], 0)):
        path = flying.write_scenario(directory / f"{name}.scn", *words, *_lines())
        flights = [flying.fly(directory / f"{name}-{form}", "--scenario", path, "--form", form, "--duration", 20) for form in ("image", "processes")]
        for flight in flights:
            assert flight.facts["reproducible"] is True, flight.transcript()
            assert flight.facts["simulated_s"] < 2 * END_S
            _assert_log_is_whole(flight)
            _assert_each_request_ends_once(flight)
            assert sum(direction == "TM" and raw[7:9] == bytes([5, 2]) and raw[21:23] == RESTARTED for _, direction, raw in flight.packets) == ends
            flying.assert_clean(flight)
        if ends:
            assert _returns_s(flights[0])[0][0] - 2.5 <= FOUND_S + BOOT_S + 3 * STEP_S + 1e-9
        assert flights[0].octets("packets.log") == flights[1].octets("packets.log")


@pytest.mark.parametrize("name", ["supervisor", "manipulator", "communication"])
def test_a_life_that_hangs_before_its_first_step_is_killed(directory, name):
    """The process is killed, and suspended at the instant at which its next life begins: that life has promised
    no step yet."""
    directory.mkdir()
    faults = [f"2.5 fault kill {name}", f"{2.5 + BOOT_S} fault hang {name}"]
    pings = [f"2.8 operator ping {one}" for one in ("SUPERVISOR", "MANIPULATOR", "COMMUNICATION")]
    path = flying.write_scenario(directory / "newborn.scn", *faults, *pings, "2.9 operator shutdown")
    flights = [flying.fly(directory / form, "--scenario", path, "--form", form, "--duration", 20) for form in ("image", "processes")]
    for flight in flights:
        assert flight.facts["reproducible"] is True, flight.transcript()
        assert flight.facts["simulated_s"] < 2 * END_S
        assert "FAILED" not in flight.console, flight.transcript()
        _assert_log_is_whole(flight)
        flying.assert_clean(flight)
    assert flights[0].octets("packets.log") == flights[1].octets("packets.log")


def test_a_mission_is_ended_if_all_its_processes_hang(directory):
    """No process is left that could follow the request to shut down: the launcher ends the flight after 30
    s."""
    directory.mkdir()
    names = ("SUPERVISOR", "COMMUNICATION", "JOYSTICK", "MANIPULATOR")
    path = flying.write_scenario(directory / "all.scn", *(f"2.5 fault hang {name}" for name in names))
    flight = flying.start(directory / "flight", "--scenario", path, "--form", "processes", "--duration", 3)
    flight.wait()
    assert flight.facts["exit_code"] == 1, flight.transcript()
    assert "did not shut down" in flight.facts["exit_reason"]
    assert flight.facts["simulated_s"] < 40
    flying.wait_until(lambda: not flight.leftovers(), "the end of all processes of the flight")


def test_a_death_in_the_image_gives_the_octets_of_processes(directory, undisturbed):
    """The image, with all components in one address space, gives the octets of the processes."""
    points = _draw(1, "image")[0]
    flights = [_fly(directory, points, form) for form in ("processes", "image")]
    for flight in flights:
        _assert_continues_after(flight, points)
        _assert_only_the_packet_log_differs(flight, undisturbed)
    for name in flying.TRACED:
        assert flights[0].octets(name) == flights[1].octets(name), name


# ---- Within a step ----


@pytest.fixture(scope="module")
def busy_calls(session_directory, mortal, undisturbed):
    """Numbers, as in CALLS, of the first call while the flight is busy and of the last call."""
    lines = [line for line in _lines() if float(line.split()[0]) < BUSY_S[0]]
    _, first = _fly_to_call(session_directory / "calls", mortal, [*lines, f"{BUSY_S[0]} operator shutdown"], 0)
    flight, last = _fly_to_call(session_directory / "all-calls", mortal, _lines(), 0)
    for name in flying.TRACED:
        assert flight.octets(name) == undisturbed.octets(name), name
    return 2 * first, 2 * (last - last // 10)  # The end of the flight has few calls.


def _draw_calls(count, seed, between):
    drawn = random.Random(seed)
    return [drawn.randrange(*between) for _ in range(count)]


def test_a_death_by_calls_changes_only_the_packet_log(directory, mortal, busy_calls, undisturbed):
    """The calls are drawn from a seed, or those of CALLS."""
    named = [int(text) for text in os.environ.get("CALLS", "").split()]
    _fly_all_calls(directory, mortal, undisturbed, named or _draw_calls(CALLS, "short", busy_calls))


@pytest.mark.long
@pytest.mark.parametrize("part", range(PARTS))
def test_a_death_by_many_calls_changes_only_the_packet_log(directory, mortal, busy_calls, undisturbed, part):
    """At hundreds of calls."""
    _fly_all_calls(directory, mortal, undisturbed, _draw_calls(LONG_CALLS // PARTS, part, busy_calls))


# ---- During long work ----

WORK_S = (1.0, 1.5)
WORK_END_S = 1.8
ACTIVITIES = 750  # A report about so many activities has more packets than the supervisor sends in one step.
AT_END = 100  # Approximate number of calls of the shutdown.
DEATHS, LONG_DEATHS = 2, 20  # For each kind of work; half at instants, half at calls.


def _steps(step, each_s):
    """Lines of the operator, one after the other while the work takes place."""
    count = round((WORK_S[1] - WORK_S[0]) / each_s)
    return [f"{WORK_S[0] + number * each_s:.4f} operator {step(number)}" for number in range(count)]


def _fill_schedule():
    """Lines that insert activities far in the future, five in each request."""
    lines = []
    for first in range(0, ACTIVITIES, 5):
        requests = [packets.build_tc(17, first + number, 17, 1, source=2).hex() for number in range(5)]
        entries = ",".join(f'{{"group_id":1,"release_time":9e5,"request":"{request}"}}' for request in requests)
        lines.append(f"0.4 operator tc SUPERVISOR 11,4 sub_schedule_id=1 'n=[{entries}]'")
    return lines


SCHEDULE = [
    "0.3 operator tc SUPERVISOR 11,22 'n=[{\"group_id\":1,\"group_status\":\"enabled\"}]'",
    "0.3 operator at +0.6 ping JOYSTICK",
    "0.3 operator tc SUPERVISOR 11,20 n=[1]",
    "0.3 operator schedule enable",
]
STORM = b"for i = 1, 200 do event(16) end"
WORKS = {
    "log": _steps(lambda number: f"nowait log {('sqlite', 'ascii', 'ring')[number % 3]}", 0.005),
    "schedule": SCHEDULE + _steps(lambda number: "at +0.15 ping MANIPULATOR", 0.005),
    "report": SCHEDULE + _fill_schedule() + _steps(lambda number: "nowait tc SUPERVISOR 11,16", 0.06),
    "storm": [
        f"0.3 operator tc SUPERVISOR 18,1 obcp_id=STORM obcp_code={STORM.hex()} checksum={packets.crc16(STORM)}",
        *_steps(lambda number: ("nowait tc SUPERVISOR 18,3 obcp_id=STORM observability_level=0 n=[]" if number % 25 == 0 else "nowait ping MANIPULATOR"), 0.004),
    ],
}


def _assert_reports_are_whole(flight):
    """Expect that a completed request for a report has sent the complete report."""
    entries, asked = 0, []
    for _, direction, raw in flight.packets:
        if direction == "TC" and raw[7:9] == bytes([11, 16]):
            asked.append(raw[:4])
        elif direction == "TM" and raw[7:9] == bytes([11, 10]):
            entries += int.from_bytes(raw[21:23], "big")
        elif direction == "TM" and raw[7] == 1 and raw[8] in (3, 7, 8) and raw[21:25] in asked:
            assert raw[8] != 7 or entries >= ACTIVITIES
            entries = 0


def _fly_work(directory, mortal, work, count):
    lines = [*WORKS[work], f"{WORK_END_S} operator shutdown"]
    before = [line for line in WORKS[work] if float(line.split()[0]) < WORK_S[0]]
    first = _fly_to_call(directory / "calls", mortal, [*before, f"{WORK_S[0]} operator shutdown"], 0)[1]
    flight, last = _fly_to_call(directory / "all-calls", mortal, lines, 0)
    _assert_each_request_ends_once(flight)
    for points in _draw(count, work, WORK_S):
        kills = [f"{point:.4f} fault kill supervisor" for point in points]
        path = flying.write_scenario(directory / f"{points[0]:.4f}.scn", *kills, *lines)
        flight = flying.fly(directory / f"{points[0]:.4f}", "--scenario", path, "--port", flying.free_port())
        _assert_continues_after(flight, points, WORK_END_S)
        _assert_reports_are_whole(flight)
    for call in _draw_calls(count, work, (2 * (first - AT_END), 2 * (last - AT_END))):
        flight, _ = _fly_to_call(directory, mortal, lines, call)
        _assert_continues(flight, 1, WORK_END_S)
        _assert_reports_are_whole(flight)


@pytest.mark.parametrize("work", WORKS)
def test_requests_and_reports_are_complete_after_a_death_at_work(directory, mortal, work):
    """The supervisor dies while the packet log is switched, a schedule releases requests, a long report is
    sent, or there is a storm of events."""
    directory.mkdir(exist_ok=True)
    _fly_work(directory, mortal, work, DEATHS)


@pytest.mark.long
@pytest.mark.parametrize("work", WORKS)
def test_requests_and_reports_are_complete_after_many_deaths_at_work(directory, mortal, work):
    """The same test with more deaths."""
    directory.mkdir(exist_ok=True)
    _fly_work(directory, mortal, work, LONG_DEATHS)
