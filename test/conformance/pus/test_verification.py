# SPDX-License-Identifier: Apache-2.0
"""ST[01], ST[05] and ST[08] in flight: every stage of verification, events by severity, and functions."""

import struct

import pytest

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201

MANIPULATOR, JOYSTICK, NOBODY = 16, 17, 99


@pytest.fixture(scope="module")
def joystick(station):
    """JOYSTICK in PRE_OPERATIONAL; OFFLINE at the end."""
    station.command("state", "JOYSTICK", "PRE_OPERATIONAL")
    yield
    station.command("state", "JOYSTICK", "OFFLINE")


def _function(name, *arguments):
    """Application data of TC[8,1]."""
    return name.encode().ljust(8, b"\0") + bytes([len(arguments)]) + b"".join(arguments)


def _about(verification):
    """A condition that is true for the verification reports of this request."""
    sequence = int.from_bytes(verification.request_id[2:4], "big") & 0x3FFF
    return lambda report: report["request_sequence"] == sequence and report["request_apid"] == verification.request.apid


def test_every_stage_is_reported(station, joystick):
    """Except TM[1,8], which the next test covers, and TM[1,6], which test_access_services.py covers."""
    since = len(station.reports)
    good = station.send("JOYSTICK", 17, 1)
    station.settle(good)
    for stage in (1, 3, 7):
        station.report(1, stage, since=since, where=_about(good))
    malformed = station.send_data(JOYSTICK, 17, 1, b"\0")
    station.report(1, 2, since=since, where=_about(malformed))
    unknown = station.send("JOYSTICK", 3, 27, n=[60000])
    station.report(1, 4, since=since, where=_about(unknown))
    step = station.send_data(JOYSTICK, 129, 1, bytes([0]))
    station.report(1, 5, since=since, where=_about(step))
    station.settle(step)
    nobody = station.send_data(NOBODY, 17, 1, b"")
    station.report(1, 10, since=since, where=_about(nobody))
    station.command("state", "JOYSTICK", "PRE_OPERATIONAL")


def test_a_failure_after_the_start_is_reported(station, joystick):
    """A request to report two structures, one of which does not exist."""
    since = len(station.reports)
    both = station.send("SUPERVISOR", 3, 27, n=[1, 60000])
    station.report(1, 8, since=since, where=_about(both))


def test_informative_and_low_events_are_reported_with_their_severity(station, joystick):
    since = len(station.reports)
    for mode in (0, 1):
        station.settle(station.send_data(1, 131, 1, bytes([mode])))
    station.report(5, 1, apid=1, since=since, where=lambda report: report["event"] == "MODE_CHANGED")
    note = station.dictionary.subsystem("JOYSTICK").event("OPERATOR_NOTE").id
    done = station.settle(station.send_data(JOYSTICK, 8, 1, _function("RAISE", struct.pack(">HH", 1, note))))
    assert done.is_completed, done.failure
    station.notes.requests[(8, 1)].add(station.notes.test())
    station.report(5, 2, apid=JOYSTICK, since=since, where=lambda report: report["event"] == "OPERATOR_NOTE")
    wrong = station.settle(station.send_data(JOYSTICK, 8, 1, _function("RAISE")))
    assert wrong.failure is not None


@pytest.mark.parametrize("severity, name", [(3, "VALUE_OUT_OF_LIMITS"), (4, "LINK_STALE")])
def test_medium_and_high_events_are_raised_by_a_monitor(station, severity, name):
    """While no link is open, LINK_AGE violates this limit."""
    station.command("state", "MANIPULATOR", "PRE_OPERATIONAL")
    since = len(station.reports)
    station.command("monitor", "limit", "MANIPULATOR", "9", "LINK_AGE", "5", "10", name, "0")
    station.do("MANIPULATOR", 12, 1, n=[9])
    station.do("MANIPULATOR", 12, 15)
    station.report(5, severity, apid=MANIPULATOR, since=since, where=lambda report: report["event"] == name)
    station.do("MANIPULATOR", 12, 16)
    station.do("MANIPULATOR", 12, 2, n=[9])
    station.do("MANIPULATOR", 12, 6, n=[9])
    station.command("state", "MANIPULATOR", "OFFLINE")


def test_event_reports_are_switched_off_and_on(station, joystick):
    event = station.dictionary.subsystem("SUPERVISOR").event("MODE_CHANGED").id
    station.do("SUPERVISOR", 5, 6, n=[event])
    assert station.ask("SUPERVISOR", 5, 7)["events"] == ["MODE_CHANGED"]
    since = len(station.reports)
    for mode in (0, 1):
        station.settle(station.send_data(1, 131, 1, bytes([mode])))
    station.fence(1)
    assert not [p for p, _ in station.reports[since:] if p.service == 5 and p.data[:2] == event.to_bytes(2, "big")]
    station.do("SUPERVISOR", 5, 5, n=[event])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 5, 5, n=[60000])
