# SPDX-License-Identifier: Apache-2.0
"""More reports than the connection to ground takes at once: long lists arrive complete, and storms of events
are fully counted."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys

import flying
import pytest
from hirosco_gse import packets

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "conformance" / "pus"))
import station as stations

ACTIVITIES, AT_ONCE = 12_000, 50
JOYSTICK = 17
WARNING, SUPPRESSED = 16, 41  # Events of the supervisor: PROCEDURE_WARNING, EVENTS_SUPPRESSED.
RAISED = 3000
PINGS = 30


@pytest.fixture(scope="module")
def station(session_directory):
    """Ground station of a flight, which ends with the tests."""
    flight = stations.launch(session_directory / f"storms-{os.getpid()}")
    try:
        ground = stations.Station(flight, stations.Notes())
        yield ground
        ground.close()
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()


@pytest.fixture(scope="module")
def full_schedule(station):
    """The time-based schedule with as many activities as it can hold."""
    due = station.now() + 1e7
    station.do("SUPERVISOR", 11, 22, n=[{"group_id": 1, "group_status": "enabled"}])
    for first in range(0, ACTIVITIES, AT_ONCE):
        ping = [packets.build_tc(JOYSTICK, (first + number) & 0x3FFF, 17, 1, source=2).hex() for number in range(AT_ONCE)]
        station.do("SUPERVISOR", 11, 4, sub_schedule_id=1, n=[{"group_id": 1, "release_time": due, "request": request} for request in ping])


@pytest.mark.usefixtures("full_schedule")
@pytest.mark.parametrize("request_type, report", [pytest.param(17, 13, marks=pytest.mark.long), (16, 10)])
def test_all_parts_of_a_long_list_arrive(station, request_type, report):
    """48 and 68 packets; the request completes after the last one."""
    since = len(station.reports)
    assert station.do("SUPERVISOR", 11, request_type).is_completed
    entries = sum(int.from_bytes(p.data[:2], "big") for p, _ in station.reports[since:] if p.message == (11, report))
    assert entries == ACTIVITIES


def _raised(reports):
    """Number of times that the event of the storm was raised, by its reports and the reports of its limiter."""
    seen, reported = 0, 0
    for packet, _ in reports:
        if packet.service == 5 and packet.data[:2] == WARNING.to_bytes(2, "big"):
            seen += 1
        if packet.service == 5 and packet.data[:4] == SUPPRESSED.to_bytes(2, "big") + WARNING.to_bytes(2, "big"):
            reported += int.from_bytes(packet.data[4:8], "big")
    return seen, reported


def test_each_event_of_a_storm_is_counted_and_each_ping_is_answered(station):
    """A procedure raises one event as fast as its cost limit allows; meanwhile each ping is answered."""
    code = f"for i = 1, {RAISED} do event({WARNING}) end".encode()
    station.do("SUPERVISOR", 18, 1, obcp_id="STORM", obcp_code=code.hex(), checksum=packets.crc16(code))
    since = len(station.reports)
    storm = station.send("SUPERVISOR", 18, 3, obcp_id="STORM", observability_level=0, n=[])
    for _ in range(PINGS):
        assert station.do("JOYSTICK", 17, 1).is_completed
    station.settle(storm)
    station.wait(lambda: sum(_raised(station.reports[since:])) == RAISED, "all occurrences, reported or counted")
    seen, reports_found = _raised(station.reports[since:])
    assert 255 <= seen < RAISED  # PROCEDURE_WARNING has a burst of 255.
    assert reports_found == RAISED - seen


# ---- A subsystem that raises 100 000 events of LOW severity per second (storm.c) ----

STEP_NS = 500_000
EACH, CYCLES_PER_S = 50, 2000
MANIPULATOR, ERROR_OPERATIONAL = 16, 6
OPERATOR_NOTE, LINK_STALE = b"\x00\x09", b"\x00\x06"  # Event ids of each subsystem.
PLAN_STARTED, SUPERVISOR_RESTARTED = b"\x00\x06", b"\x00\x14"  # Event ids of the supervisor.
BEGIN_S = 1.5


@pytest.fixture(scope="module")
def stormy(session_directory):
    """The programs of a mission whose joystick raises a storm of events."""
    programs = session_directory / "stormy"
    shutil.copytree(flying.BIN, programs)
    libraries = [str(path) for path in (flying.ROOT / "build" / "lib").glob("lib*.a") if not path.name.startswith(("libsim", "libtest"))]
    words = ["gcc", "-std=gnu99", "-O2", "-I.", "-Ibuild", "-Ibuild/generated", "-o", programs / "joystick", "test/mission/storm.c"]
    words += ["build/obj/fsw/programs/joystick_main.o", "-Wl,--wrap=joystick_control", "-Wl,--start-group", *libraries, "-Wl,--end-group"]
    subprocess.run([*words, "-Wl,--as-needed", "-lexpat", "-llua5.4", "-lnettle", "-lpthread", "-lm"], cwd=flying.ROOT, check=True)
    return programs


def _fly_storm(directory, programs, seconds, *more):
    """A storm of this many seconds with a HIGH event half a second before its end, and a ping every 0.1 s."""
    directory.mkdir()
    lines = ["0 hand rest", *flying.bring_up(0.1), *more]
    lines += [f"{BEGIN_S + tenth / 10:.1f} operator nowait ping JOYSTICK" for tenth in range(seconds * 10)]
    path = flying.write_scenario(directory / "storm.scn", *lines, f"{BEGIN_S + seconds + 3} operator shutdown")
    cycles = seconds * CYCLES_PER_S
    environment = {"STORM_EACH": str(EACH), "STORM_CYCLES": str(cycles), "STORM_HIGH": str(cycles - 990)}
    flight = flying.fly(directory / "out", "--scenario", path, binaries=programs, environment=environment)
    flight.parsed = [(time_ns, packets.parse(raw)) for time_ns, _, raw in flight.packets]
    return flight


def _events(flight, apid, identity):
    return [(at, p) for at, p in flight.parsed if p.apid == apid and p.service == 5 and p.subtype <= 4 and p.data[:2] == identity]


def _made(flight):
    """All occurrences of the storm's event: reported, or counted as suppressed."""
    reports = sum(int.from_bytes(p.data[4:8], "big") for _, p in _events(flight, JOYSTICK, SUPPRESSED.to_bytes(2, "big")) if p.data[2:4] == OPERATOR_NOTE)
    return len(_events(flight, JOYSTICK, OPERATOR_NOTE)) + reports


def _pings(flight):
    """Time [ns] from each ping of the joystick to its answer, both in the packet log. Expects that each ping
    completes once."""
    sent = [(at, p) for at, p in flight.parsed if p.direction == "TC" and p.message == (17, 1) and p.apid == JOYSTICK]
    answered = [at for at, p in flight.parsed if p.direction == "TM" and p.message == (17, 2) and p.apid == JOYSTICK]
    completed = [(p.data[:4], p.user) for _, p in flight.parsed if p.direction == "TM" and p.message == (1, 7) and p.apid == JOYSTICK]
    counts = [completed.count((p.raw[:4], p.user)) for _, p in sent]
    assert counts == [1] * len(sent), f"completions of each ping: {counts}, expected 1 each"
    assert len(answered) == len(sent)
    return [after - before for (before, _), after in zip(sent, answered, strict=True)]


def _assert_storm_hides_nothing(flight, seconds):
    assert _made(flight) == seconds * CYCLES_PER_S * EACH
    waits = _pings(flight)
    assert len(waits) == seconds * 10
    assert max(waits) <= 3 * STEP_NS, max(waits)
    ((high_ns, high),) = _events(flight, JOYSTICK, LINK_STALE)
    ((plan_ns, _),) = _events(flight, 1, PLAN_STARTED)
    assert high.subtype == 4
    assert plan_ns - high_ns <= 2 * STEP_NS
    commands = [at for at, p in flight.parsed if p.direction == "TC" and p.apid == MANIPULATOR and p.service == 129 and p.data[:1] == bytes([ERROR_OPERATIONAL])]
    assert commands and commands[0] - high_ns <= 2 * STEP_NS


def test_a_storm_of_a_subsystem_delays_neither_its_answers_nor_its_high_event(directory, stormy):
    flight = _fly_storm(directory, stormy, 3)
    assert flight.code == 0, flight.transcript()
    _assert_storm_hides_nothing(flight, 3)


@pytest.mark.long
def test_a_storm_of_a_minute_delays_neither_answers_nor_the_high_event(directory, stormy):
    """The storm has six million events."""
    flight = _fly_storm(directory, stormy, 60)
    assert flight.code == 0, flight.transcript()
    _assert_storm_hides_nothing(flight, 60)


FAULTS = {
    "death": ("2.65 fault kill supervisor",),
    "hang": ("2.65 fault hang supervisor",),  # The members detect the hang of the supervisor and kill it.
    "short-hang": ("2.65 fault hang supervisor", "2.67 fault resume supervisor"),
    "ground": ("2.65 fault hang communication", "2.66 fault resume communication"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_within_a_storm_loses_no_report(directory, stormy, fault):
    """The supervisor is killed or suspended, or communication is suspended: no FIRM report of the joystick is lost,
    duplicated or out of order."""
    flight = _fly_storm(directory, stormy, 3, *FAULTS[fault])
    ends = fault in ("death", "hang")
    assert flight.code == (1 if ends else 0), flight.transcript()
    assert _made(flight) == 3 * CYCLES_PER_S * EACH
    assert len(_pings(flight)) == 30
    ((high_ns, _),) = _events(flight, JOYSTICK, LINK_STALE)
    ((plan_ns, _),) = _events(flight, 1, PLAN_STARTED)
    assert plan_ns - high_ns <= 2 * STEP_NS
    assert len(_events(flight, 1, SUPERVISOR_RESTARTED)) == (1 if ends else 0)
    counts = [p.sequence for _, p in flight.parsed if p.direction == "TM" and p.apid == JOYSTICK]
    assert counts == list(range(len(counts)))


def test_a_process_that_dies_in_its_storm_loses_at_most_the_counts_of_a_second(directory, stormy):
    """A suppressed event whose count is not reported yet is lost with the process: at most the events of the
    second between two reports of counts. Each ping ends once, and the partner goes to ERROR_OPERATIONAL."""
    flight = _fly_storm(directory, stormy, 3, "3.05 fault kill joystick")
    first_ns = _events(flight, JOYSTICK, OPERATOR_NOTE)[0][0]
    raised = round((3_050_000_000 - first_ns) / STEP_NS) * EACH
    assert 0 <= raised - _made(flight) <= CYCLES_PER_S * EACH
    sent = [p.raw[:4] for _, p in flight.parsed if p.direction == "TC" and p.message == (17, 1) and p.apid == JOYSTICK]
    ended = [p.data[:4] for _, p in flight.parsed if p.direction == "TM" and p.message in ((1, 7), (1, 8), (1, 10)) and p.user == 1]
    ends = [ended.count(identity) for identity in sent]
    assert ends == [1] * len(sent), f"reports that a ping has ended: {ends}, expected 1 of each"
    states = [p.data[1] for _, p in flight.parsed if p.apid == MANIPULATOR and p.message == (129, 2)]
    assert ERROR_OPERATIONAL in states
