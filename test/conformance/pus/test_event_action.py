# SPDX-License-Identifier: Apache-2.0
"""ST[19] in flight: a request that an event releases."""

import pytest
from hirosco_gse import packets

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
OUT_OF_RANGE = 0x0203
STATE = 0x0204
EMBEDDED = 0x020A

SUPERVISOR, JOYSTICK = 1, 17
UNDEFINED_EVENT = 999


@pytest.fixture(autouse=True)
def _nothing_defined(station):
    station.do("SUPERVISOR", 19, 3)
    yield
    station.do("SUPERVISOR", 19, 3)
    assert station.ask("SUPERVISOR", 19, 6)["n"] == []


def _ping(sequence=7):
    return packets.build_tc(JOYSTICK, sequence, 17, 1, source=2).hex()


def _change_mode(station):
    """Raise MODE_CHANGED twice."""
    for mode in (0, 1):
        station.settle(station.send_data(SUPERVISOR, 131, 1, bytes([mode])))


def _pings(station, since):
    return [p for p, _ in station.reports[since:] if p.message == (17, 2) and p.apid == JOYSTICK]


def test_an_event_releases_its_request(station):
    key = {"apid": SUPERVISOR, "event_definition_id": station.dictionary.subsystem("SUPERVISOR").event("MODE_CHANGED").id}
    station.do("SUPERVISOR", 19, 1, n=[{**key, "request": _ping()}, {"apid": JOYSTICK, "event_definition_id": UNDEFINED_EVENT, "request": _ping(8)}])
    status = {entry["event_definition_id"]: entry["event_action_status"] for entry in station.ask("SUPERVISOR", 19, 6)["n"]}
    assert status == {key["event_definition_id"]: "disabled", UNDEFINED_EVENT: "disabled"}
    assert station.ask("SUPERVISOR", 19, 10, n=[key])["n"][0]["request"] == _ping()
    assert len(station.ask("SUPERVISOR", 19, 10, n=[])["n"]) == 2
    since = len(station.reports)
    _change_mode(station)
    station.fence(JOYSTICK)
    assert len(_pings(station, since)) == 1, "more than the ping of the fence was answered, although nothing is enabled"
    station.do("SUPERVISOR", 19, 4, n=[key])
    station.do("SUPERVISOR", 19, 8)
    since = len(station.reports)
    _change_mode(station)
    station.wait(lambda: len(_pings(station, since)) >= 2, "answers to released requests")
    station.do("SUPERVISOR", 19, 9)
    station.do("SUPERVISOR", 19, 5, n=[])
    since = len(station.reports)
    _change_mode(station)
    station.fence(JOYSTICK)
    assert len(_pings(station, since)) == 1
    station.do("SUPERVISOR", 19, 2, n=[key])
    assert [entry["event_definition_id"] for entry in station.ask("SUPERVISOR", 19, 6)["n"]] == [UNDEFINED_EVENT]


def test_an_event_whose_report_is_disabled_releases_its_request(station):
    """TC[5,6] suppresses the report to the ground, not the reaction on board."""
    event = station.dictionary.subsystem("SUPERVISOR").event("MODE_CHANGED").id
    key = {"apid": SUPERVISOR, "event_definition_id": event}
    station.do("SUPERVISOR", 19, 1, n=[{**key, "request": _ping()}])
    station.do("SUPERVISOR", 19, 4, n=[key])
    station.do("SUPERVISOR", 19, 8)
    station.do("SUPERVISOR", 5, 6, n=[event])
    since = len(station.reports)
    _change_mode(station)
    station.wait(lambda: len(_pings(station, since)) >= 2, "answers to released requests")

    def is_reported():
        return [p for p, _ in station.reports[since:] if p.service == 5 and p.data[:2] == event.to_bytes(2, "big")]

    assert not is_reported()
    station.do("SUPERVISOR", 5, 5, n=[event])
    _change_mode(station)
    station.wait(is_reported, "the report of the event")


def test_faulty_event_action_requests_are_refused(station):
    key = {"apid": JOYSTICK, "event_definition_id": UNDEFINED_EVENT}
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 19, 4, n=[key])
    station.refuse(EMBEDDED, "SUPERVISOR", 19, 1, n=[{**key, "request": _ping()[:-2] + "00"}])
    order = packets.build_tc(JOYSTICK, 1, 129, 8, bytes((3, 0)), source=0x8001).hex()
    station.refuse(EMBEDDED, "SUPERVISOR", 19, 1, n=[{**key, "request": order}])
    station.do("SUPERVISOR", 19, 1, n=[{**key, "request": _ping()}])
    station.do("SUPERVISOR", 19, 4, n=[key])
    station.refuse(STATE, "SUPERVISOR", 19, 2, n=[key])
    station.refuse(STATE, "SUPERVISOR", 19, 1, n=[{**key, "request": _ping()}])
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 19, 1, n=[{"apid": JOYSTICK, "event_definition_id": 0, "request": _ping()}])
