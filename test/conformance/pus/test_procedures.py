# SPDX-License-Identifier: Apache-2.0
"""ST[18] in flight: procedures are loaded, run, suspended and reported; their requests, readings and
events."""

import signal

import pytest
import station as stations
from hirosco_gse import packets

SUPERVISOR, MANIPULATOR, JOYSTICK = 1, 16, 17
NOTE, WARNING = 15, 16  # Events that procedures raise.
UNKNOWN_ID, EXISTS, OUT_OF_RANGE, STATE, TABLE_FULL, DATA_CHECKSUM = 0x0201, 0x0202, 0x0203, 0x0204, 0x0205, 0x020D
ABORTED, PROCEDURE = 0x0405, 0x040A
STARTED, ENDED, FAILED, STOPPED, HELD, RESUMED, STEP, SENT, RECEIVED = 1, 2, 3, 4, 6, 7, 8, 9, 10
SLOTS, CALLS, CYCLE_S = 8, 8, 0.01  # Most procedures at once, most calls in a cycle, cycle of the supervisor [s].
STEPS = "for number = 1, 60000 do step(number) wait(0.02) end"
ENDLESS = "while true do end"


@pytest.fixture(autouse=True)
def _nothing_loaded(station):
    yield
    station.do("SUPERVISOR", 18, 21)
    station.do("SUPERVISOR", 18, 17)
    for name in _status(station):
        station.do("SUPERVISOR", 18, 2, obcp_id=name)
    assert not _status(station)


def _status(station):
    return {entry["obcp_id"]: entry["obcp_execution_status"] for entry in station.ask("SUPERVISOR", 18, 8)["n"]}


def _code(text):
    octets = text.encode()
    return {"obcp_code": octets.hex(), "checksum": packets.crc16(octets)}


def _load(station, text, name="LOOK"):
    station.do("SUPERVISOR", 18, 1, obcp_id=name, **_code(text))


def _start(station, level="none", name="LOOK", subtype=3, **fields):
    return station.send("SUPERVISOR", 18, subtype, **{"obcp_id": name, "observability_level": level, "n": [], **fields})


def _is_running(station, name="LOOK"):
    station.wait(lambda: _status(station)[name] == "active and running", f"start of {name}")


def _ended(station, sent):
    """Outcome of an activation whose procedure ends without error."""
    outcome = station.settle(sent)
    texts = [report["TEXT"] for report in _reported(station, 0, "PROCEDURE_FAILED")]
    assert outcome.is_completed, (outcome.failure.words(station.dictionary), *texts[-1:])
    station.notes.requests[(18, sent.request.subtype)].add(station.notes.test())
    return outcome


def _failed(station, sent, code, detail=None):
    """Failure of an activation whose procedure ends with an error."""
    failure = station.settle(sent).failure
    assert (failure.stage, failure.code) == (8, code), failure.words(station.dictionary)
    assert detail in (None, failure.detail)


def _run(station, text, **fields):
    _load(station, text)
    return _ended(station, _start(station, **fields))


def _reported(station, since, event="PROCEDURE_OBSERVED"):
    """Values of an event's reports; texts and single numbers are not in a list."""
    found = [report["values"] for _, report in station.reports[since:] if report.get("event") == event]
    return [{name: value[0] if len(value) == 1 else bytes(value).rstrip(b"\0").decode() for name, value in values.items()} for values in found]


def _observed(station, since):
    """(what, step, detail) of each observation."""
    return [(report["WHAT"], report["STEP"], report["DETAIL"]) for report in _reported(station, since)]


def test_a_procedure_runs_step_by_step(station):
    text = "step(1) wait(0.1) step(2)"
    _load(station, text)
    assert station.ask("SUPERVISOR", 18, 8)["n"] == [
        {"obcp_id": "LOOK", "obcp_checksum": packets.crc16(text.encode()), "obcp_execution_status": "inactive"}
    ]
    since = len(station.reports)
    outcome = _ended(station, _start(station, "step level"))
    assert [stage for stage in outcome.stages if stage != 1] == [3, 5, 5, 7]
    assert _observed(station, since) == [(STARTED, 0, 0), (STEP, 1, 1), (STEP, 2, 2), (ENDED, 2, 0)]
    assert {reported["PROCEDURE"] for reported in _reported(station, since)} == {"LOOK"}
    assert _status(station) == {"LOOK": "inactive"}
    since = len(station.reports)
    _ended(station, _start(station))
    assert _observed(station, since) == []


def test_a_procedure_has_arguments(station):
    arguments = [("UINT8", 7), ("DOUBLE", -2.5), ("BOOL", True), ("INT64", -(2**40))]
    _run(
        station,
        "local a, b, c, d = ... assert(a == 7 and b == -2.5 and c == true and d == -1099511627776)",
        n=[{"argument_layout": layout, "argument_value": value} for layout, value in arguments],
    )


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [("step(1)\nerror('no light')", 2, "no light"), ("wait(", 1, "near"), ("local t = {}\n\nt.a.b = 1", 3, "index"), ("send(1)", 1, "")],
)
def test_an_error_is_reported_with_its_line(station, text, line, message):
    _load(station, text)
    since = len(station.reports)
    _failed(station, _start(station), PROCEDURE, line)
    (reported,) = _reported(station, since, "PROCEDURE_FAILED")
    assert (reported["PROCEDURE"], reported["WHAT"], reported["DETAIL"]) == ("LOOK", FAILED, line)
    assert message in reported["TEXT"]


def test_requests_are_routed_and_their_failures_are_returned(station):
    since = len(station.reports)
    _run(
        station,
        f"""
        local function ask(code, ...)
            local ok, found = send(...)
            assert(ok == (code == 0) and (ok or found == code), string.format("%s 0x%04X", tostring(ok), found or 0))
        end
        ask(0, {JOYSTICK}, 17, 1, "", true)
        ask(0, {SUPERVISOR}, 17, 1, "", true)
        ask(0x0001, 999, 17, 1, "", true)
        ask(0x0106, {MANIPULATOR}, 3, 99, "", true)
        ask(0x0110, {MANIPULATOR}, 8, 1, "MOVE_TO\\0", true)
        ask(0x0201, {SUPERVISOR}, 18, 12, "NOBODY\\0\\0", true)
        ask(0, {MANIPULATOR}, 17, 1)
        """,
        observability_level="detailed level",
    )
    assert [detail for what, _, detail in _observed(station, since) if what == SENT] == [4353, 4353, 4353, 867, 2049, 4620, 4353]
    assert not [p for p, _ in station.reports[since:] if p.message == (17, 2) and p.apid == JOYSTICK], "an answer to the procedure was sent to the ground"


def test_telemetry_is_read_as_it_was_reported(station):
    """Telemetry is read by name as in housekeeping; a scalar also by its id."""
    period = station.dictionary.subsystem("SUPERVISOR").parameter("ORBIT_PERIOD").parameter_id
    station.ask("SUPERVISOR", 20, 1, n=["SUPERVISOR.ORBIT_PERIOD"])
    station.report(3, 25, apid=SUPERVISOR)
    _run(
        station,
        f"""
        assert(get("SUPERVISOR.ORBIT_PERIOD") == 5550000 and get({period}) == 5550000)
        assert(get("SUPERVISOR.STATUS.SUBSYSTEMS") == 4 and get("SUPERVISOR.COUNTERS.TC_ROUTED") > 0)
        for _, name in ipairs {{"SUPERVISOR.STATUS", "SUPERVISOR.STATUS.SUBSYSTEMS[0]", "NOBODY.KNOWS", "", "[1]"}} do
            assert(get(name) == nil, name)
        end
        assert(get(0) == nil and get(4294967295) == nil)
        """,
    )


def test_procedures_raise_events_of_their_own_only(station):
    since = len(station.reports)
    _run(
        station,
        f"""
        step(3)
        assert(event({NOTE}) and event({WARNING}))
        for _, other in ipairs {{1, 4, 13, 14, 47, 65535}} do
            local ok, code, detail = event(other)
            assert(not ok and code == 0x0201 and detail == other, other)
        end
        """,
    )
    for name in ("PROCEDURE_NOTE", "PROCEDURE_WARNING"):
        (reported,) = _reported(station, since, name)
        assert (reported["PROCEDURE"], reported["STEP"]) == ("LOOK", 3)
    assert not _reported(station, since, "PROCESS_LOST")


def test_a_procedure_is_suspended_resumed_and_stopped(station):
    _load(station, STEPS)
    since = len(station.reports)
    sent = _start(station, "procedure level")
    _is_running(station)
    station.refuse(STATE, "SUPERVISOR", 18, 6, obcp_id="LOOK")
    station.refuse(STATE, "SUPERVISOR", 18, 2, obcp_id="LOOK")
    station.refuse(STATE, "SUPERVISOR", 18, 3, obcp_id="LOOK", observability_level=0, n=[])
    station.do("SUPERVISOR", 18, 5, obcp_id="LOOK", step_id=0)
    station.wait(lambda: _status(station)["LOOK"] == "active and held", "the next step")
    station.refuse(STATE, "SUPERVISOR", 18, 5, obcp_id="LOOK", step_id=0)
    station.do("SUPERVISOR", 18, 15, obcp_id="LOOK")
    station.wait(lambda: _status(station)["LOOK"] == "active and held", "the step after that")
    assert not sent.is_finished
    station.do("SUPERVISOR", 18, 6, obcp_id="LOOK")
    station.do("SUPERVISOR", 18, 4, obcp_id="LOOK", step_id=0)
    _failed(station, sent, ABORTED)
    reported = _observed(station, since)
    assert [what for what, _, _ in reported] == [STARTED, HELD, RESUMED, HELD, RESUMED, STOPPED]
    assert reported[3][1] == reported[1][1] + 1, "expected one step between the two observations"


def test_one_step_is_executed_and_a_procedure_stops_at_a_named_step(station):
    _load(station, STEPS)
    sent = _start(station, subtype=14)
    station.notes.requests[(18, 14)].add(station.notes.test())
    station.wait(lambda: _status(station)["LOOK"] == "active and held", "its first step")
    station.do("SUPERVISOR", 18, 6, obcp_id="LOOK")
    station.do("SUPERVISOR", 18, 16, n=[{"obcp_id": "LOOK", "observability_level": "step level"}])
    since = len(station.reports)
    station.report(5, 1, apid=SUPERVISOR, since=since, where=lambda report: report.get("event") == "PROCEDURE_OBSERVED")
    (step,) = {_observed(station, since)[0][1]}
    station.do("SUPERVISOR", 18, 4, obcp_id="LOOK", step_id=step + 200)
    _failed(station, sent, ABORTED)
    assert _observed(station, since)[-1] == (STOPPED, step + 200, 0)


def test_a_procedure_receives_parameters(station):
    values = {"n": [{"argument_layout": "UINT16", "argument_value": 42}, {"argument_layout": "DOUBLE", "argument_value": 0.5}]}
    _run(station, "assert(parameters(0) == nil and parameters(0.05) == nil)")
    station.do("SUPERVISOR", 18, 2, obcp_id="LOOK")
    _load(station, "local found repeat found = parameters(1) until found assert(found[1] == 42 and found[2] == 0.5)")
    since = len(station.reports)
    sent = _start(station, "detailed level")
    _is_running(station)
    station.do("SUPERVISOR", 18, 7, obcp_id="LOOK", **values)
    _ended(station, sent)
    assert (RECEIVED, 0, 0) in _observed(station, since)
    _load(station, ENDLESS, "SPIN")
    _start(station, name="SPIN")
    _is_running(station, "SPIN")
    station.do("SUPERVISOR", 18, 7, obcp_id="SPIN", **values)
    station.refuse(STATE, "SUPERVISOR", 18, 7, obcp_id="SPIN", **values)


def test_procedures_are_aborted(station):
    started = []
    for name in ("ONE", "TWO", "THREE"):
        _load(station, ENDLESS, name)
        started.append(_start(station, name=name))
        _is_running(station, name)
    station.do("SUPERVISOR", 18, 12, obcp_id="TWO")
    station.refuse(STATE, "SUPERVISOR", 18, 12, obcp_id="TWO")
    assert station.ask("SUPERVISOR", 18, 17)["n"] == [{"obcp_id": "ONE"}, {"obcp_id": "THREE"}]
    assert station.ask("SUPERVISOR", 18, 17)["n"] == []
    for sent in started:
        _failed(station, sent, ABORTED)


def test_a_procedure_is_loaded_from_a_file(station, flight):
    file = {"repository_path": "/", "file_name": "look.lua"}
    place = flight.directory / "storage" / "files" / "look.lua"
    for subtype, extra in ((13, {}), (19, {"observability_level": 0, "n": []})):
        station.refuse(UNKNOWN_ID, "SUPERVISOR", 18, subtype, obcp_id="LOOK", **file, **extra)
        station.refuse(OUT_OF_RANGE, "SUPERVISOR", 18, subtype, obcp_id="LOOK", repository_path="/..", file_name="a", **extra)
    place.write_text("step(1)", encoding="utf-8")
    try:
        station.do("SUPERVISOR", 18, 13, obcp_id="LOOK", **file)
        _ended(station, _start(station))
        _ended(station, _start(station, name="OTHER", subtype=19, **file))
        station.refuse(EXISTS, "SUPERVISOR", 18, 13, obcp_id="LOOK", **file)
        place.write_text("x" * 20000, encoding="utf-8")
        station.refuse(TABLE_FULL, "SUPERVISOR", 18, 13, obcp_id="LARGE", **file)
    finally:
        station.do("SUPERVISOR", 23, 2, **file)


def test_a_stopped_procedure_is_unloaded(station):
    _load(station, STEPS)
    sent = _start(station)
    _is_running(station)
    station.do("SUPERVISOR", 18, 20, obcp_id="LOOK", step_id=0)
    _failed(station, sent, ABORTED)
    assert _status(station) == {}


def test_the_engine_is_stopped_and_started(station):
    _load(station, ENDLESS)
    sent = _start(station)
    _is_running(station)
    station.do("SUPERVISOR", 18, 22)
    _failed(station, sent, ABORTED)
    station.refuse(STATE, "SUPERVISOR", 18, 3, obcp_id="LOOK", observability_level=0, n=[])
    station.refuse(STATE, "SUPERVISOR", 18, 1, obcp_id="OTHER", **_code("step(1)"))
    station.do("SUPERVISOR", 18, 21)
    _load(station, "step(1)", "OTHER")
    _ended(station, _start(station, name="OTHER"))


def test_procedures_without_an_end_take_their_share_only(station):
    """The maximum number of procedures runs, and the last one raises events: the supervisor still routes,
    reports, and keeps its period."""
    for number in range(SLOTS - 1):
        _load(station, ENDLESS, f"SPIN{number}")
        _start(station, name=f"SPIN{number}")
    _load(station, f"while true do event({NOTE}) end", "LOUD")
    _start(station, name="LOUD")
    _is_running(station, "LOUD")
    _load(station, "step(1)")
    station.refuse(TABLE_FULL, "SUPERVISOR", 18, 3, obcp_id="LOOK", observability_level=0, n=[])
    since, begin = len(station.reports), station.now()
    station.wait_until(begin + 2.0)
    station.fence(MANIPULATOR)
    notes = [p.time_ns for p, report in station.reports[since:] if report.get("event") == "PROCEDURE_NOTE"]
    most = CALLS * (round((notes[-1] - notes[0]) / 1e9 / CYCLE_S) + 1)
    assert most / 2 < len(notes) <= most
    reported = [p.time_ns for p, _ in station.reports[since:] if p.message == (129, 5) and p.apid == SUPERVISOR]
    assert reported and all(abs(later - sooner - 1e9) < 1e6 for sooner, later in zip(reported, reported[1:])), "its state is not reported each second"
    assert len(station.ask("SUPERVISOR", 18, 17)["n"]) == SLOTS


def test_faulty_procedure_requests_are_refused(station):
    name = {"obcp_id": "LOOK"}
    fields = {3: {"observability_level": 0, "n": []}, 4: {"step_id": 0}, 5: {"step_id": 0}, 7: {"n": []}, 14: {"observability_level": 0, "n": []}, 20: {"step_id": 0}}
    for subtype in (2, 3, 4, 5, 6, 7, 12, 14, 15, 20):
        station.refuse(UNKNOWN_ID, "SUPERVISOR", 18, subtype, **name, **fields.get(subtype, {}))
    _load(station, "step(1)")
    for subtype in (4, 5, 6, 7, 12, 15, 20):
        station.refuse(STATE, "SUPERVISOR", 18, subtype, **name, **fields.get(subtype, {}))
    station.refuse(EXISTS, "SUPERVISOR", 18, 1, **name, **_code("step(2)"))
    station.refuse(DATA_CHECKSUM, "SUPERVISOR", 18, 1, obcp_id="OTHER", obcp_code="00", checksum=1)
    station.refuse(TABLE_FULL, "SUPERVISOR", 18, 1, obcp_id="OTHER", **_code(""))
    for subtype in (3, 14):
        station.refuse(OUT_OF_RANGE, "SUPERVISOR", 18, subtype, **name, observability_level=4, n=[])
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 18, 16, n=[{"obcp_id": "OTHER", "observability_level": 1}])
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 18, 16, n=[{**name, "observability_level": 4}, {**name, "observability_level": 1}])
    assert _status(station) == {"LOOK": "inactive"}


def test_loaded_procedures_are_kept_for_the_next_flight(notes, tmp_path):
    """The next flight uses the same storage."""
    for number in (1, 2):
        flight = stations.launch(tmp_path / str(number), "--storage", tmp_path / "storage")
        ground = stations.Station(flight, notes)
        try:
            if number == 1:
                _load(ground, "local text = [[" + "x" * 3000 + "]] step(1)")
                _load(ground, ENDLESS, "SPIN")
                _start(ground, name="SPIN")
                _is_running(ground, "SPIN")
            else:
                assert _status(ground) == {"LOOK": "inactive", "SPIN": "inactive"}
                _ended(ground, _start(ground))
        finally:
            ground.close()
            flight.process.send_signal(signal.SIGINT)
            flight.wait()
