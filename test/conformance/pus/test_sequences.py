# SPDX-License-Identifier: Apache-2.0
"""ST[21] in flight: requests one after the other, with delays between them."""

import pytest
from hirosco_gse import packets

JOYSTICK = 17  # APID; this subsystem gets connection tests.
NAME = {"request_sequence_id": "LOOK"}
UNKNOWN_ID, EXISTS, OUT_OF_RANGE, STATE, EMBEDDED = 0x0201, 0x0202, 0x0203, 0x0204, 0x020A


def _ping(sequence):
    return packets.build_tc(JOYSTICK, sequence, 17, 1, source=2).hex()


def _entries(*delays):
    return [{"request": _ping(number), "delay": delay} for number, delay in enumerate(delays, 7)]


def _status(station):
    return {entry["request_sequence_id"]: entry["execution_status"] for entry in station.ask("SUPERVISOR", 21, 6)["n"]}


@pytest.fixture(autouse=True)
def _nothing_loaded(station):
    yield
    station.do("SUPERVISOR", 21, 13)
    for name in _status(station):
        station.do("SUPERVISOR", 21, 3, request_sequence_id=name)
    assert not _status(station)


def test_a_sequence_releases_its_requests(station):
    station.do("SUPERVISOR", 21, 1, **NAME, n=_entries(0.25, 0.5))
    assert _status(station) == {"LOOK": "inactive"}
    assert station.ask("SUPERVISOR", 21, 11, **NAME)["n"] == _entries(0.25, 0.5)
    assert station.ask("SUPERVISOR", 21, 9, **NAME)["checksum"] != 0
    since = len(station.reports)
    station.do("SUPERVISOR", 21, 4, **NAME)

    def answers():
        return [p for p, _ in station.reports[since:] if p.message == (17, 2) and p.apid == JOYSTICK]

    station.wait(lambda: len(answers()) >= 2, "answers to both requests")
    station.wait(lambda: station.ask("SUPERVISOR", 21, 6)["n"][0]["execution_status"] == "inactive", "the end of the sequence")
    first, second = answers()
    assert second.time_ns - first.time_ns == pytest.approx(0.25e9, abs=1e6), "expected the delay of the first request between both answers"


def test_a_sequence_is_aborted(station):
    station.do("SUPERVISOR", 21, 1, **NAME, n=_entries(1000.0, 0.0))
    station.do("SUPERVISOR", 21, 4, **NAME)
    assert _status(station) == {"LOOK": "under execution"}
    station.refuse(STATE, "SUPERVISOR", 21, 3, **NAME)
    station.refuse(STATE, "SUPERVISOR", 21, 4, **NAME)
    station.do("SUPERVISOR", 21, 5, **NAME)
    station.refuse(STATE, "SUPERVISOR", 21, 5, **NAME)
    station.do("SUPERVISOR", 21, 4, **NAME)
    assert station.ask("SUPERVISOR", 21, 13)["n"] == [NAME]
    assert station.ask("SUPERVISOR", 21, 13)["n"] == []


def test_faulty_sequence_requests_are_refused(station):
    for subtype in (3, 4, 5, 9, 11):
        station.refuse(UNKNOWN_ID, "SUPERVISOR", 21, subtype, **NAME)
    station.refuse(EMBEDDED, "SUPERVISOR", 21, 1, **NAME, n=[{"request": _ping(7)[:-2] + "00", "delay": 0.0}])
    order = packets.build_tc(JOYSTICK, 1, 129, 8, bytes((3, 0)), source=0x8001).hex()
    station.refuse(EMBEDDED, "SUPERVISOR", 21, 1, **NAME, n=[{"request": order, "delay": 0.0}])
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 21, 1, **NAME, n=_entries(-0.5))
    station.do("SUPERVISOR", 21, 1, **NAME, n=_entries(0.0))
    station.refuse(EXISTS, "SUPERVISOR", 21, 1, **NAME, n=_entries(0.0))
    for subtype in (2, 8):
        station.refuse(UNKNOWN_ID, "SUPERVISOR", 21, subtype, request_sequence_id="OTHER", repository_path="/missing", file_name="missing")
