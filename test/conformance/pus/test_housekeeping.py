# SPDX-License-Identifier: Apache-2.0
"""ST[03] in flight, in SUPERVISOR: structures of both kinds are created, changed, reported and deleted;
functional reporting definitions."""

from dataclasses import dataclass

import pytest
from hirosco_gse.dictionary import Structure

WHO = "SUPERVISOR"
APID = 1
PERIOD, ORBIT = "SUPERVISOR.ORBIT_PERIOD", "SUPERVISOR.ORBIT"
UNKNOWN, EXISTS, STATE, RANGE = 0x0201, 0x0202, 0x0204, 0x0203


@dataclass(frozen=True)
class Kind:
    """Housekeeping or diagnostic: the same requests with other numbers."""

    name: str
    field: str
    create: int
    delete: int
    enable: int
    disable: int
    report: int
    once: int
    append: int
    modify: int
    properties: int
    values: int
    code: int


HOUSEKEEPING = Kind("housekeeping", "hk_structure_id", 1, 3, 5, 6, 9, 27, 29, 31, 33, 25, 25)
DIAGNOSTIC = Kind("diagnostic", "diag_structure_id", 2, 4, 7, 8, 11, 28, 30, 32, 34, 26, 26)
NUMBER = 77


@pytest.fixture(params=[HOUSEKEEPING, DIAGNOSTIC], ids=lambda kind: kind.name)
def kind(request, station):
    """A kind with a structure made for the test."""
    found = request.param
    subsystem = station.dictionary.subsystem(WHO)
    station.do(WHO, 3, found.create, **{found.field: NUMBER}, collection_interval=50, n1=[PERIOD], nfa=[])
    subsystem.created[NUMBER] = Structure(NUMBER, 50, (subsystem.parameter("ORBIT_PERIOD"),), ())
    yield found
    station.settle(station.send(WHO, 3, found.disable, n=[NUMBER]))
    station.do(WHO, 3, found.delete, n=[NUMBER])
    station.refuse(UNKNOWN, WHO, 3, found.report, n=[NUMBER])
    subsystem.created.pop(NUMBER)


def _values(station, kind, since):
    """Reports with values of the structure NUMBER since this index."""
    number = NUMBER.to_bytes(2, "big")
    return [packet for packet, _ in station.reports[since:]
            if packet.message == (3, kind.values) and packet.apid == APID and packet.data[:2] == number]


def test_a_structure_is_created_and_reported_and_a_second_creation_is_refused(station, kind):
    content = station.ask(WHO, 3, kind.report, n=[NUMBER])
    assert content.get("structure", content.get(kind.field)) == NUMBER
    station.refuse(EXISTS, WHO, 3, kind.create, **{kind.field: NUMBER}, collection_interval=50, n1=[PERIOD], nfa=[])
    station.refuse(UNKNOWN, WHO, 3, kind.create, **{kind.field: NUMBER + 1}, collection_interval=50, n1=[f"0x{0x3FFFFF:08X}"], nfa=[])
    station.refuse(UNKNOWN, WHO, 3, kind.report, n=[NUMBER + 1])


def test_one_shot_and_periodic_reports(station, kind):
    since = len(station.reports)
    station.do(WHO, 3, kind.once, n=[NUMBER])
    station.report(3, kind.values, apid=APID, since=since)
    (shot,) = _values(station, kind, since)
    station.do(WHO, 3, kind.enable, n=[NUMBER])
    since = len(station.reports)
    station.wait(lambda: len(_values(station, kind, since)) >= 4, "four reports of the structure")
    periodic = _values(station, kind, since)
    assert {len(packet.data) for packet in periodic} == {len(shot.data)}
    times = [packet.time_ns for packet in periodic]
    interval = times[1] - times[0]
    assert interval > 0 and all(later - earlier == interval for earlier, later in zip(times, times[1:]))
    station.refuse(STATE, WHO, 3, kind.delete, n=[NUMBER])
    station.do(WHO, 3, kind.disable, n=[NUMBER])
    since = len(station.reports)
    station.wait_until(station.now() + 10 * interval / 1e9)
    assert not _values(station, kind, since)
    station.refuse(UNKNOWN, WHO, 3, kind.enable, n=[NUMBER + 1])


def test_structures_are_changed_while_they_are_disabled(station, kind):
    station.do(WHO, 3, kind.modify, n=[{kind.field: NUMBER, "collection_interval": 20}])
    rows = station.ask(WHO, 3, kind.properties, n=[NUMBER])
    row = (rows.get("rows") or rows["n"])[0]
    assert (row.get("interval") or row["collection_interval"]) == 20
    station.do(WHO, 3, kind.append, **{kind.field: NUMBER}, n1=[ORBIT], nfa=[])
    content = station.ask(WHO, 3, kind.report, n=[NUMBER])
    assert len(content.get("once") or content["n1"]) == 2
    subsystem = station.dictionary.subsystem(WHO)
    subsystem.created[NUMBER] = Structure(NUMBER, 20, (subsystem.parameter("ORBIT_PERIOD"), subsystem.parameter("ORBIT")), ())
    station.do(WHO, 3, kind.enable, n=[NUMBER])
    station.refuse(STATE, WHO, 3, kind.modify, n=[{kind.field: NUMBER, "collection_interval": 30}])
    station.refuse(STATE, WHO, 3, kind.append, **{kind.field: NUMBER}, n1=[PERIOD], nfa=[])
    station.do(WHO, 3, kind.disable, n=[NUMBER])


def _member(kind, status="enabled", interval=40):
    return {"report_structure_type": kind.code, "report_structure_id": NUMBER, "periodic_generation_action_status": status,
            "collection_interval": interval}


def _is_enabled(station, kind):
    rows = station.ask(WHO, 3, kind.properties, n=[NUMBER])
    row = (rows.get("rows") or rows["n"])[0]
    return bool(row["enabled"]) if "enabled" in row else row["periodic_generation_action_status"] == "enabled"


def test_functional_definitions_set_many_at_once(station, kind):
    group = {"functional_reporting_definition_id": 5}
    station.do(WHO, 3, 38, **group, n1=[{"apid": APID, "n2": [_member(kind)]}])
    station.refuse(EXISTS, WHO, 3, 38, **group, n1=[{"apid": APID, "n2": [_member(kind)]}])
    station.refuse(UNKNOWN, WHO, 3, 38, functional_reporting_definition_id=6, n1=[{"apid": 16, "n2": [_member(kind)]}])
    station.do(WHO, 3, 37, configuration_execution_flag="non-exclusive", n=[5])
    assert _is_enabled(station, kind)
    station.do(WHO, 3, 44, **group, n1=[{"apid": APID, "n2": [_member(kind, "disabled")]}])
    station.do(WHO, 3, 37, configuration_execution_flag="non-exclusive", n=[5])
    assert not _is_enabled(station, kind)
    other = {**_member(kind), "report_structure_id": 1, "report_structure_type": 25, "collection_interval": 500}
    station.do(WHO, 3, 42, **group, n1=[{"apid": APID, "n2": [other]}])
    assert len(station.ask(WHO, 3, 40, n=[5])["n1"][0]["n2"]) == 2
    entry = {"report_structure_type": 25, "report_structure_id": 1}
    station.do(WHO, 3, 43, **group, n1=[{"apid": APID, "n2": [entry]}])
    assert len(station.ask(WHO, 3, 40, n=[5])["n1"][0]["n2"]) == 1
    station.do(WHO, 3, 39, n=[5])
    station.refuse(UNKNOWN, WHO, 3, 39, n=[5])
