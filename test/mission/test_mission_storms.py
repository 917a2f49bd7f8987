# SPDX-License-Identifier: Apache-2.0
"""More to report than the way to ground takes at once: long lists come whole, and storms of events add up."""

import os
import pathlib
import signal
import sys

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
def station(hangar):
    """Ground station of a flight that ends with the tests."""
    flight = stations.launch(hangar / f"storms-{os.getpid()}")
    try:
        ground = stations.Station(flight, stations.Notes())
        yield ground
        ground.close()
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()


@pytest.fixture(scope="module")
def full_schedule(station):
    """The time-based schedule with as many activities as it takes."""
    due = station.now() + 1e7
    station.do("SUPERVISOR", 11, 22, n=[{"group_id": 1, "group_status": "enabled"}])
    for first in range(0, ACTIVITIES, AT_ONCE):
        ping = [packets.build_tc(JOYSTICK, (first + number) & 0x3FFF, 17, 1, source=2).hex() for number in range(AT_ONCE)]
        station.do("SUPERVISOR", 11, 4, sub_schedule_id=1, n=[{"group_id": 1, "release_time": due, "request": request} for request in ping])


@pytest.mark.usefixtures("full_schedule")
@pytest.mark.parametrize("request_type, report", [(17, 13), (16, 10)])
def test_a_long_list_comes_whole(station, request_type, report):
    """48 and 68 packets; the request completes behind the last."""
    since = len(station.reports)
    assert station.do("SUPERVISOR", 11, request_type).is_completed
    entries = sum(int.from_bytes(p.data[:2], "big") for p, _ in station.reports[since:] if p.message == (11, report))
    assert entries == ACTIVITIES


def _raised(reports):
    """How often the event of the storm was raised, as its reports and what is told of its limiter say."""
    seen, told = 0, 0
    for packet, _ in reports:
        if packet.service == 5 and packet.data[:2] == WARNING.to_bytes(2, "big"):
            seen += 1
        if packet.service == 5 and packet.data[:4] == SUPPRESSED.to_bytes(2, "big") + WARNING.to_bytes(2, "big"):
            told += int.from_bytes(packet.data[4:8], "big")
    return seen, told


def test_a_storm_of_events_adds_up_and_hides_no_answer(station):
    """A procedure raises one event as fast as it may; meanwhile each ping is answered."""
    code = f"for i = 1, {RAISED} do event({WARNING}) end".encode()
    station.do("SUPERVISOR", 18, 1, obcp_id="STORM", obcp_code=code.hex(), checksum=packets.crc16(code))
    since = len(station.reports)
    storm = station.send("SUPERVISOR", 18, 3, obcp_id="STORM", observability_level=0, n=[])
    for _ in range(PINGS):
        assert station.do("JOYSTICK", 17, 1).is_completed
    station.settle(storm)
    station.wait(lambda: sum(_raised(station.reports[since:])) == RAISED, "all occurrences, reported or told")
    seen, told = _raised(station.reports[since:])
    assert 255 <= seen < RAISED
    assert told == RAISED - seen
