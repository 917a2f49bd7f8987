# SPDX-License-Identifier: Apache-2.0
"""ST[11] and ST[22] in flight: the same requests with times and with positions."""

import pytest
from hirosco_gse import packets

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
EXISTS = 0x0202
OUT_OF_RANGE = 0x0203
STATE = 0x0204
PAST = 0x0209
EMBEDDED = 0x020A

JOYSTICK = 17  # APID; this subsystem gets connection tests.
FAR = 1_000_000.0  # Seconds of mission time that no flight of these tests reaches.


class Kind:
    """Differences between the two schedules."""

    def __init__(self, service, far):
        self.service, self._far = service, far

    def tag(self, value):
        """Fields of a release tag."""
        return {"release_time": value} if self.service == 11 else _position("release_position", value)

    def between(self, low, high):
        """Fields of a window."""
        if self.service == 11:
            return {"time_window_type": "from tag to tag", "from_tag": low, "to_tag": high}
        return {"position_window_type": "from tag to tag", **_position("from_tag", low), **_position("to_tag", high)}

    def shift(self, value):
        """Fields of a shift."""
        return {("time" if self.service == 11 else "position") + "_offset": value}

    def far(self, number):
        """A tag far in the future; it increases with the number."""
        return self._far + number


def _position(name, value):
    return {f"{name}_orbit_number": int(value), f"{name}_orbit_angle": round(value % 1 * 65536)}


KINDS = {"time": Kind(11, FAR), "position": Kind(22, 1000.0)}


@pytest.fixture(params=KINDS.values(), ids=KINDS)
def kind(request, station):
    """A schedule that is empty, without groups."""
    station.do("SUPERVISOR", request.param.service, 3)
    yield request.param
    station.do("SUPERVISOR", request.param.service, 3)
    assert station.ask("SUPERVISOR", request.param.service, 17)["n"] == []
    station.do("SUPERVISOR", request.param.service, 23, n=[])


def _ping(sequence):
    return packets.build_tc(JOYSTICK, sequence, 17, 1, source=2).hex()


def _identity(sequence):
    return {"source_id": 2, "apid": JOYSTICK, "sequence_count": sequence}


def _insert(station, kind, *numbers, sub_schedule=1, group=1):
    activities = [{"group_id": group, **kind.tag(kind.far(n)), "request": _ping(n)} for n in numbers]
    station.do("SUPERVISOR", kind.service, 4, sub_schedule_id=sub_schedule, n=activities)


def _group(station, kind, number=1):
    station.do("SUPERVISOR", kind.service, 22, n=[{"group_id": number, "group_status": "enabled"}])


def _numbers(answer):
    return [entry["sequence_count"] for entry in answer["n"]]


def _tags(answer):
    """Release tags of a summary [s, orbits]."""
    return [entry["release_time"] if "release_time" in entry
            else entry["release_position_orbit_number"] + entry["release_position_orbit_angle"] / 65536 for entry in answer["n"]]


def _all(station, kind):
    return station.ask("SUPERVISOR", kind.service, 17)


def test_activities_are_inserted_reported_and_deleted(station, kind):
    service = kind.service
    _group(station, kind)
    _insert(station, kind, 3, 1, 2)
    assert _numbers(_all(station, kind)) == [1, 2, 3], "expected the order of the release tags"
    detail = station.ask("SUPERVISOR", service, 16)
    assert [entry["request"] for entry in detail["n"]] == [_ping(n) for n in (1, 2, 3)]
    assert _numbers(station.ask("SUPERVISOR", service, 12, n=[_identity(2)])) == [2]
    assert len(station.ask("SUPERVISOR", service, 9, n=[_identity(2), _identity(3)])["n"]) == 2
    window = kind.between(kind.far(1.5), kind.far(2.5))
    assert _numbers(station.ask("SUPERVISOR", service, 14, **window, n1=[], n2=[])) == [2]
    assert len(station.ask("SUPERVISOR", service, 11, **window, n1=[1], n2=[1])["n"]) == 1
    station.refuse(UNKNOWN_ID, "SUPERVISOR", service, 5, n=[_identity(99)])
    station.do("SUPERVISOR", service, 5, n=[_identity(1)])
    station.do("SUPERVISOR", service, 6, **window, n1=[], n2=[])
    assert _numbers(_all(station, kind)) == [3]


def test_shifts_change_the_release_tags(station, kind):
    service = kind.service
    _group(station, kind)
    _insert(station, kind, 1, 2)
    station.do("SUPERVISOR", service, 7, **kind.shift(5), n=[_identity(1)])
    assert _numbers(_all(station, kind)) == [2, 1]
    station.do("SUPERVISOR", service, 8, **kind.shift(10), **kind.between(kind.far(0), kind.far(3)), n1=[], n2=[])
    assert _numbers(_all(station, kind)) == [1, 2]
    before = _tags(_all(station, kind))
    station.do("SUPERVISOR", service, 15, **kind.shift(-0.5))
    after = _tags(_all(station, kind))
    assert [late - early for late, early in zip(before, after)] == pytest.approx([0.5, 0.5], abs=1e-4)
    to_before_all = PAST if service == 11 else OUT_OF_RANGE  # No position is negative.
    station.refuse(to_before_all, "SUPERVISOR", service, 15, **kind.shift(-2 * kind.far(0)))
    assert _numbers(_all(station, kind)) == [1, 2]


def test_groups_and_sub_schedules_are_enabled_disabled_and_deleted(station, kind):
    service = kind.service
    _group(station, kind, 1)
    _group(station, kind, 2)
    station.refuse(EXISTS, "SUPERVISOR", service, 22, n=[{"group_id": 2, "group_status": "enabled"}])
    _insert(station, kind, 1, sub_schedule=7, group=2)
    station.do("SUPERVISOR", service, 20, n=[7])
    assert station.ask("SUPERVISOR", service, 18)["n"] == [{"sub_schedule_id": 7, "sub_schedule_status": "enabled"}]
    station.do("SUPERVISOR", service, 21, n=[])
    assert station.ask("SUPERVISOR", service, 18)["n"][0]["sub_schedule_status"] == "disabled"
    station.refuse(UNKNOWN_ID, "SUPERVISOR", service, 20, n=[8])
    station.do("SUPERVISOR", service, 25, n=[2])
    status = {entry["group_id"]: entry["group_status"] for entry in station.ask("SUPERVISOR", service, 26)["n"]}
    assert status == {1: "enabled", 2: "disabled"}
    station.do("SUPERVISOR", service, 24, n=[])
    station.refuse(STATE, "SUPERVISOR", service, 23, n=[2])
    station.do("SUPERVISOR", service, 23, n=[1])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", service, 4, sub_schedule_id=1, n=[{"group_id": 1, **kind.tag(kind.far(1)), "request": _ping(5)}])


def test_faulty_schedule_requests_are_refused(station, kind):
    service = kind.service
    _group(station, kind)
    past = kind.tag(0.0)
    station.wait_until(1.0)
    station.refuse(PAST, "SUPERVISOR", service, 4, sub_schedule_id=1, n=[{"group_id": 1, **past, "request": _ping(1)}])
    spoilt = _ping(1)[:-1] + ("0" if _ping(1)[-1] != "0" else "1")
    station.refuse(EMBEDDED, "SUPERVISOR", service, 4, sub_schedule_id=1, n=[{"group_id": 1, **kind.tag(kind.far(1)), "request": spoilt}])
    order = packets.build_tc(JOYSTICK, 1, 129, 8, bytes((3, 0)), source=0x8001).hex()
    station.refuse(EMBEDDED, "SUPERVISOR", service, 4, sub_schedule_id=1, n=[{"group_id": 1, **kind.tag(kind.far(1)), "request": order}])
    outcome = station.refuse(
        EMBEDDED, "SUPERVISOR", service, 4, sub_schedule_id=1,
        n=[{"group_id": 1, **kind.tag(kind.far(n)), "request": spoilt if n == 2 else _ping(n)} for n in (1, 2, 3)],
    )
    assert [failure.instruction for failure in outcome.failures if failure.code == EMBEDDED] == [2]
    assert _numbers(_all(station, kind)) == [1, 3], "expected the other activities unchanged"


# The flight runs as fast as it can, so this time is about a second for the station, which has to send requests before it.
SOON_S = 60.0
PERIOD_S = 10.0  # Of the orbit of these tests.


def _answers(station, since):
    """Times [s] of the answers to scheduled pings."""
    epoch_ns = station.dictionary.epoch_ns
    return [(p.time_ns - epoch_ns) / 1e9 for p, d in station.reports[since:] if p.message == (17, 2) and p.apid == JOYSTICK]


@pytest.mark.parametrize("kind", [KINDS["time"]], ids=["time"], indirect=True)
def test_a_request_is_released_at_its_time(station, kind):
    _group(station, kind)
    station.ask("SUPERVISOR", 17, 1)
    due = round(station.now() + SOON_S, 3) + 0.0005
    since = len(station.reports)
    late = {"group_id": 1, "release_time": due, "request": _ping(1)}
    station.do("SUPERVISOR", 11, 4, sub_schedule_id=1, n=[late, {**late, "release_time": due + 1.0, "request": _ping(2)}])
    station.do("SUPERVISOR", 11, 4, sub_schedule_id=2, n=[{**late, "request": _ping(3)}])
    station.do("SUPERVISOR", 11, 20, n=[1])
    station.do("SUPERVISOR", 11, 1)
    station.wait_until(due + 3.0)
    times = _answers(station, since)
    assert len(times) == 2, "expected no release from the disabled sub-schedule"
    assert all(abs(time - planned) <= 0.001 for time, planned in zip(times, (due, due + 1.0))), (times, due)
    station.do("SUPERVISOR", 11, 2)
    assert _all(station, kind)["n"] == []
    due = round(station.now() + SOON_S, 3)
    station.do("SUPERVISOR", 11, 4, sub_schedule_id=1, n=[{**late, "release_time": due, "request": _ping(4)}])
    since = len(station.reports)
    station.wait_until(due + 2.0)
    assert not _answers(station, since), "expected no release from the disabled schedule"


@pytest.mark.parametrize("kind", [KINDS["position"]], ids=["position"], indirect=True)
def test_a_request_is_released_at_its_position(station, kind):
    period = station.dictionary.subsystem("SUPERVISOR").parameter("ORBIT_PERIOD").parameter_id
    station.do("SUPERVISOR", 20, 3, n=[{"parameter_id": period, "parameter_value": round(1000 * PERIOD_S)}])
    _group(station, kind)
    outcome = station.do("SUPERVISOR", 20, 1, n=["SUPERVISOR.ORBIT"])
    packet, answer = next(reply for reply in outcome.replies if reply[0].message == (20, 2))
    orbit = answer["values"]["ORBIT"]
    due = orbit["NUMBER"][0] + orbit["ANGLE"][0] / 65536 + SOON_S / PERIOD_S + 0.25
    due_s = (packet.time_ns - station.dictionary.epoch_ns) / 1e9 + SOON_S + 0.25 * PERIOD_S
    since = len(station.reports)
    station.do("SUPERVISOR", 22, 4, sub_schedule_id=1, n=[{"group_id": 1, **_position("release_position", due), "request": _ping(1)}])
    station.do("SUPERVISOR", 22, 20, n=[1])
    station.do("SUPERVISOR", 22, 1)
    station.wait(lambda: _answers(station, since), "the answer to what was scheduled")
    assert _answers(station, since) == [pytest.approx(due_s, abs=0.001)]
    before = station.now()
    station.do("SUPERVISOR", 22, 28, orbit_number=500)
    station.wait_until(before + 15.0)
    orbit = station.ask("SUPERVISOR", 20, 1, n=["SUPERVISOR.ORBIT"])["values"]["ORBIT"]
    assert 500 <= orbit["NUMBER"][0] <= 501 + (station.now() - before) / PERIOD_S
    station.do("SUPERVISOR", 22, 2)
    station.do("SUPERVISOR", 20, 3, n=[{"parameter_id": period, "parameter_value": 5_550_000}])
