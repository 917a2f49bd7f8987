# SPDX-License-Identifier: Apache-2.0
"""ST[15] in flight: reports are stored and sent again unchanged; and ST[09], the spacecraft's time."""

import pytest

JOYSTICK = 17  # APID.
MIB = 1 << 20
MS = 0.001  # Larger than the rounding of a number of seconds.
UNKNOWN_ID, EXISTS, OUT_OF_RANGE, STATE = 0x0201, 0x0202, 0x0203, 0x0204
RING, BOX = {"packet_store_id": "RING"}, {"packet_store_id": "BOX"}
EVER = {"from_time": 0.0, "to_time": 1.0e9}


def _stores(station):
    return {entry["packet_store_id"]: entry for entry in station.ask("SUPERVISOR", 15, 18)["n"]}


@pytest.fixture(autouse=True)
def _no_store(station):
    yield
    for subtype in (2, 16, 17, 21):
        station.do("SUPERVISOR", 15, subtype, n=[])
    assert not _stores(station)


@pytest.fixture
def ring(station):
    """A circular store for JOYSTICK's answers to connection tests."""
    store = {**RING, "packet_store_size": MIB, "packet_store_type": "circular", "virtual_channel": 1}
    station.do("SUPERVISOR", 15, 20, n=[store])
    station.do("SUPERVISOR", 15, 3, **RING, n1=[{"apid": JOYSTICK, "n2": [{"service_type": 17, "n3": [2]}]}])
    station.do("SUPERVISOR", 15, 1, n=[RING])


def _ping(station, count):
    """Answers of JOYSTICK to pings, as they first arrived."""
    since = len(station.reports)
    for _ in range(count):
        station.ask("JOYSTICK", 17, 1)
    return [packet.raw for packet, _ in station.reports[since:] if packet.message == (17, 2) and packet.apid == JOYSTICK]


def _again(station, since, originals):
    """Wait until each of these has arrived once more since this index, in the same order; no other report of this kind
    may arrive."""

    def copies():
        return [p.raw for p, _ in station.reports[since:] if p.message == (17, 2) and p.apid == JOYSTICK]

    station.wait(lambda: len(copies()) >= len(originals), "packets of a store")
    assert copies() == originals


def test_an_open_retrieval_sends_packets_as_they_were(station, ring):
    originals = _ping(station, 5)
    since = len(station.reports)
    station.do("SUPERVISOR", 15, 15, n=[{**RING, "retrieval_priority": 1}])
    _again(station, since, originals)
    assert _stores(station)["RING"]["open_retrieval_status"] == "in-progress"
    station.do("SUPERVISOR", 15, 16, n=[RING])
    assert _stores(station)["RING"]["open_retrieval_status"] == "suspended"
    since = len(station.reports)
    station.do("SUPERVISOR", 15, 14, open_retrieval_start_time_tag=0.0, n=[RING])
    station.do("SUPERVISOR", 15, 15, n=[{**RING, "retrieval_priority": 1}])
    _again(station, since, originals)


def test_a_range_is_sent_and_deleted(station, ring):
    originals = _ping(station, 6)
    (summary,) = station.ask("SUPERVISOR", 15, 12, n=[RING])["n"]
    assert summary["percentage_filled"] == 1 and summary["oldest_stored_packet_time"] < summary["newest_stored_packet_time"]
    since = len(station.reports)
    span = {"from_time": summary["oldest_stored_packet_time"] - MS, "to_time": summary["newest_stored_packet_time"] + MS}
    station.do("SUPERVISOR", 15, 9, n=[{**RING, "retrieval_priority": 0, **span}])
    _again(station, since, originals)
    station.wait(lambda: _stores(station)["RING"]["by_time_range_retrieval_status"] == "disabled", "the end of the range")
    station.do("SUPERVISOR", 15, 11, storage_time=span["to_time"], n=[RING])
    (summary,) = station.ask("SUPERVISOR", 15, 12, n=[RING])["n"]
    assert summary["percentage_filled"] == 0
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 15, 9, n=[{**RING, "retrieval_priority": 0, "from_time": 2.0, "to_time": 1.0}])
    station.do("SUPERVISOR", 15, 17, n=[RING])


def test_packets_are_copied(station, ring):
    originals = _ping(station, 3)
    station.do("SUPERVISOR", 15, 20, n=[{**BOX, "packet_store_size": 32768, "packet_store_type": "bounded", "virtual_channel": 0}])
    window = {"time_window_type": "select all"}
    station.do("SUPERVISOR", 15, 24, **window, from_packet_store_id="RING", to_packet_store_id="BOX")
    station.refuse(STATE, "SUPERVISOR", 15, 24, **window, from_packet_store_id="RING", to_packet_store_id="BOX")
    since = len(station.reports)
    station.do("SUPERVISOR", 15, 9, n=[{**BOX, "retrieval_priority": 0, **EVER}])
    _again(station, since, originals)


def test_stores_are_changed(station, ring):
    station.refuse(STATE, "SUPERVISOR", 15, 27, **RING)
    station.do("SUPERVISOR", 15, 2, n=[RING])
    station.do("SUPERVISOR", 15, 27, **RING)
    station.do("SUPERVISOR", 15, 28, **RING, virtual_channel=3)
    station.do("SUPERVISOR", 15, 25, n=[{**RING, "packet_store_size": 64 * MIB}])
    (entry,) = station.ask("SUPERVISOR", 15, 22)["n"]
    assert entry == {**RING, "packet_store_size": 64 * MIB, "packet_store_type": "bounded", "virtual_channel": 3}
    station.do("SUPERVISOR", 15, 26, **RING)
    (entry,) = station.ask("SUPERVISOR", 15, 22)["n"]
    assert entry["packet_store_type"] == "circular"
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 15, 25, n=[{**RING, "packet_store_size": 64 * MIB + 16384}])
    station.refuse(EXISTS, "SUPERVISOR", 15, 20, n=[{**RING, "packet_store_size": MIB, "packet_store_type": 0, "virtual_channel": 0}])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 15, 1, n=[BOX])


@pytest.mark.parametrize(
    "add, delete, report, entry",
    [
        (3, 4, 5, {"service_type": 3, "n3": [25]}),
        (29, 30, 35, {"hk_structure_id": 7, "subsampling_rate": 4}),
        (31, 32, 37, {"diag_structure_id": 8, "subsampling_rate": 1}),
        (34, 33, 39, {"event_definition_id": 9}),
    ],
)
def test_selections_of_a_store_are_added_reported_and_deleted(station, ring, add, delete, report, entry):
    station.do("SUPERVISOR", 15, 4, **RING, n1=[])
    station.do("SUPERVISOR", 15, add, **RING, n1=[{"apid": JOYSTICK, "n2": [entry]}])
    content = station.ask("SUPERVISOR", 15, report, **RING)
    assert content["packet_store_id"] == "RING"
    (process,) = content["n1"]
    assert process["apid"] == JOYSTICK and len(process["n2"]) == 1
    station.refuse(EXISTS, "SUPERVISOR", 15, add, **RING, n1=[{"apid": JOYSTICK, "n2": [entry]}])
    station.do("SUPERVISOR", 15, delete, **RING, n1=[{"apid": JOYSTICK, "n2": []}])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 15, delete, **RING, n1=[{"apid": JOYSTICK, "n2": []}])
    assert station.ask("SUPERVISOR", 15, report, **RING)["n1"] == []


def test_the_time_is_reported(station):
    station.do("SUPERVISOR", 9, 1, rate_exponential_value=0)
    since = len(station.reports)
    station.report(9, 2, apid=0, since=since)
    station.wait(lambda: sum(p.message == (9, 2) for p, _ in station.reports[since:]) >= 3, "three time reports")
    times = [packet.time_ns for packet, _ in station.reports[since:] if packet.message == (9, 2)]
    assert all(900_000_000 < later - earlier < 1_100_000_000 for earlier, later in zip(times, times[1:]))
    station.do("SUPERVISOR", 9, 1, rate_exponential_value=8)
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 9, 1, rate_exponential_value=9)
