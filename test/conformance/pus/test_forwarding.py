# SPDX-License-Identifier: Apache-2.0
"""ST[14] in flight: reports that are forwarded to the ground at once."""

import pytest

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
EXISTS = 0x0202
OUT_OF_RANGE = 0x0203

MANIPULATOR, JOYSTICK = 16, 17


@pytest.fixture(autouse=True)
def _everything_forwarded(station):
    """All reports are forwarded at the beginning and again at the end."""
    before = station.ask("SUPERVISOR", 14, 3)
    yield
    station.do("SUPERVISOR", 14, 13, n1=[])
    # From here until the next request, verification reports are not forwarded, either.
    station.send("SUPERVISOR", 14, 2, n1=[])
    station.send("SUPERVISOR", 14, 1, n1=before["n1"])
    station.fence(1)


def _seen(station, service, apid, seconds=3.0):
    """Reports of a service and process within some mission time."""
    since = len(station.reports)
    station.ask("SUPERVISOR", 17, 1)
    station.wait_until(station.now() + seconds)
    return [packet for packet, _ in station.reports[since:] if packet.service == service and packet.apid == apid]


def test_everything_is_forwarded_at_first(station):
    content = station.ask("SUPERVISOR", 14, 3)
    assert sorted(entry["apid"] for entry in content["n1"]) == [1, 2, MANIPULATOR, JOYSTICK]
    assert all(entry["n2"] == [] for entry in content["n1"])
    assert len(_seen(station, 129, JOYSTICK)) >= 2


def test_reports_of_a_process_deleted_from_the_configuration_are_not_forwarded(station):
    station.do("SUPERVISOR", 14, 2, n1=[{"apid": JOYSTICK, "n2": []}])
    assert _seen(station, 129, JOYSTICK) == []
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 14, 2, n1=[{"apid": JOYSTICK, "n2": []}])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 14, 1, n1=[{"apid": 99, "n2": []}])
    station.do("SUPERVISOR", 14, 1, n1=[{"apid": JOYSTICK, "n2": [{"service_type": 129, "n3": [5]}]}])
    assert len(_seen(station, 129, JOYSTICK)) >= 2
    entry = next(entry for entry in station.ask("SUPERVISOR", 14, 3)["n1"] if entry["apid"] == JOYSTICK)
    assert entry["n2"] == [{"service_type": 129, "n3": [{"message_subtype": 5}]}]
    station.do("SUPERVISOR", 14, 2, n1=[{"apid": JOYSTICK, "n2": [{"service_type": 129, "n3": []}]}])


@pytest.mark.parametrize("add, delete, report, name", [(5, 6, 7, "hk_structure_id"), (9, 10, 11, "diag_structure_id")])
def test_structures_are_forwarded_with_their_rates(station, add, delete, report, name):
    everything = [{"apid": apid, "n2": []} for apid in (1, 2, MANIPULATOR, JOYSTICK)]
    station.do("SUPERVISOR", 14, delete, n1=[])
    assert station.ask("SUPERVISOR", 14, report)["n1"] == []
    station.do("SUPERVISOR", 14, add, n1=[{"apid": MANIPULATOR, "n2": [{name: 1, "subsampling_rate": 10}]}])
    assert station.ask("SUPERVISOR", 14, report)["n1"] == [{"apid": MANIPULATOR, "n2": [{name: 1, "subsampling_rate": 10}]}]
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 14, add, n1=[{"apid": MANIPULATOR, "n2": [{name: 2, "subsampling_rate": 0}]}])
    station.do("SUPERVISOR", 14, delete, n1=[{"apid": MANIPULATOR, "n2": [1]}])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 14, delete, n1=[{"apid": MANIPULATOR, "n2": [1]}])
    station.do("SUPERVISOR", 14, add, n1=everything)


def test_blocked_events_are_not_forwarded(station):
    event = station.dictionary.subsystem("SUPERVISOR").event("MODE_CHANGED").id
    station.do("SUPERVISOR", 14, 14, n1=[{"apid": 1, "n2": [event]}])
    assert station.ask("SUPERVISOR", 14, 15)["n1"] == [{"apid": 1, "n2": [{"event_definition_id": event}]}]
    station.refuse(EXISTS, "SUPERVISOR", 14, 14, n1=[{"apid": 1, "n2": [event]}])
    since = len(station.reports)
    for mode in (0, 1):
        station.settle(station.send_data(1, 131, 1, bytes([mode])))
    station.fence(1)
    assert not [p for p, _ in station.reports[since:] if p.service == 5 and p.data[:2] == event.to_bytes(2, "big")]
    station.do("SUPERVISOR", 14, 13, n1=[{"apid": 1, "n2": [event]}])
    since = len(station.reports)
    for mode in (0, 1):
        station.settle(station.send_data(1, 131, 1, bytes([mode])))
    station.report(5, 1, apid=1, since=since, where=lambda decoded: decoded.get("event") == "MODE_CHANGED")
