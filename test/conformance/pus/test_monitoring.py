# SPDX-License-Identifier: Apache-2.0
"""ST[12] and ST[04] in flight: MANIPULATOR and SUPERVISOR check limits of the parameter LINK_AGE of MANIPULATOR, which is 0 while
no link is open; MANIPULATOR computes statistics of it."""

import pytest

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
EXISTS = 0x0202
STATE = 0x0204
PROTECTED = 0x0208

MANIPULATOR = 16
AGE = "MANIPULATOR.LINK_AGE"


@pytest.fixture(scope="module", autouse=True)
def _published(station):
    """Take MANIPULATOR to PRE_OPERATIONAL, because its parameters exist from SOFTWARE_INIT on; at the end, back to OFFLINE."""
    station.command("state", "MANIPULATOR", "PRE_OPERATIONAL")
    yield
    station.command("state", "MANIPULATOR", "OFFLINE")


@pytest.fixture
def functions(station):
    """Before and after the test, delete all definitions and disable parameter monitoring and functional monitoring."""

    def clear(subsystem):
        station.do(subsystem, 12, 18)
        station.do(subsystem, 12, 16)
        fmons = [entry["fmon_id"] for entry in station.ask(subsystem, 12, 27)["n"]]
        if fmons:
            station.do(subsystem, 12, 22, n=fmons)
            station.do(subsystem, 12, 20, n=fmons)
            station.do(subsystem, 12, 24, n=fmons)
        station.do(subsystem, 12, 4)
        assert station.ask(subsystem, 12, 13)["n"] == [] and station.ask(subsystem, 12, 27)["n"] == []

    for subsystem in ("MANIPULATOR", "SUPERVISOR"):
        clear(subsystem)
    yield
    for subsystem in ("MANIPULATOR", "SUPERVISOR"):
        clear(subsystem)


def _limit(number, low, high, event=0, **fields):
    definition = {
        "pmon_id": number, "monitored_parameter_id": AGE, "validity_parameter_id": 0, "validity_mask": 0,
        "validity_expected_value": 0, "monitoring_interval": 1, "repetition_number": 1, "check_type": "limit",
        "low_limit": low, "low_limit_event_definition_id": event, "high_limit": high, "high_limit_event_definition_id": event,
    }
    return definition | fields


def _status(station):
    return {entry["pmon_id"]: entry["pmon_status"] for entry in station.ask("MANIPULATOR", 12, 13)["n"]}


def test_definitions_are_added_modified_and_deleted(station, functions):
    station.do("MANIPULATOR", 12, 5, n=[_limit(1, 0, 10), _limit(2, 0, 20)])
    station.refuse(EXISTS, "MANIPULATOR", 12, 5, n=[_limit(1, 0, 10)])
    station.refuse(UNKNOWN_ID, "MANIPULATOR", 12, 5, n=[_limit(3, 0, 10, monitored_parameter_id=f"0x{MANIPULATOR << 21 | 0x2FFFF:08X}")])
    assert _status(station) == {1: "disabled", 2: "disabled"}
    station.do("MANIPULATOR", 12, 1, n=[1])
    assert _status(station) == {1: "enabled", 2: "disabled"}
    station.refuse(STATE, "MANIPULATOR", 12, 6, n=[1])
    changed = {"pmon_id": 2, "monitored_parameter_id": AGE, "repetition_number": 3, "check_type": "limit", "low_limit": 1,
               "low_limit_event_definition_id": 0, "high_limit": 30, "high_limit_event_definition_id": 0}
    station.do("MANIPULATOR", 12, 7, n=[changed])
    report = station.ask("MANIPULATOR", 12, 8, n=[2])
    assert [(entry["pmon_id"], entry["repetition_number"], entry["high_limit"]) for entry in report["n"]] == [(2, 3, 30)]
    assert len(station.ask("MANIPULATOR", 12, 8, n=[])["n"]) == 2
    station.do("MANIPULATOR", 12, 2, n=[1])
    station.do("MANIPULATOR", 12, 6, n=[1, 2])
    assert _status(station) == {}
    station.refuse(UNKNOWN_ID, "MANIPULATOR", 12, 1, n=[9])


def test_a_violation_is_reported_and_raises_its_event(station, functions):
    event = station.dictionary.subsystem("MANIPULATOR").events["OPERATOR_NOTE"].id
    station.do("MANIPULATOR", 12, 3, max_transition_reporting_delay=1)
    station.do("MANIPULATOR", 12, 5, n=[_limit(1, 5, 10, event)])
    station.do("MANIPULATOR", 12, 1, n=[1])
    since = len(station.reports)
    station.do("MANIPULATOR", 12, 15)
    _, report = station.report(12, 12, apid=MANIPULATOR, since=since)
    transition = report["n"][0]
    assert (transition["pmon_id"], transition["parameter_value"], transition["limit_crossed"]) == (1, 0, 5)
    assert transition["current_pmon_checking_status"].startswith("unexpected or below")
    station.wait(lambda: any(p.service == 5 and p.apid == MANIPULATOR and p.data[:2] == event.to_bytes(2, "big") for p, _ in station.reports[since:]), "the event of the violation")
    assert station.ask("MANIPULATOR", 12, 10)["n"][0]["pmon_id"] == 1


def test_the_supervisor_monitors_parameters_that_subsystems_report(station, functions):
    event = station.dictionary.subsystem("SUPERVISOR").events["VALUE_OUT_OF_LIMITS"].id
    unknown = f"0x{MANIPULATOR << 21 | 0x2FFFF:08X}"
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 12, 5, n=[_limit(1, 5, 10, monitored_parameter_id=unknown)])
    station.do("SUPERVISOR", 12, 3, max_transition_reporting_delay=1)
    station.do("SUPERVISOR", 12, 5, n=[_limit(1, 5, 10, event)])
    station.do("SUPERVISOR", 12, 1, n=[1])
    station.do("SUPERVISOR", 12, 15)
    since = len(station.reports)
    station.ask("MANIPULATOR", 20, 1, n=[AGE])

    def violations(decoded):
        return [(entry["pmon_id"], entry["parameter_value"], entry["limit_crossed"]) for entry in decoded["n"]
                if entry["current_pmon_checking_status"].startswith("unexpected or below")]

    _, report = station.report(12, 12, apid=1, since=since, where=violations)
    assert violations(report) == [(1, 0, 5)]
    packet, _ = station.report(5, 2, apid=1, since=since)
    # The auxiliary data of the event begin with the id of the definition.
    assert packet.data[:4] == event.to_bytes(2, "big") + bytes([0, 1])


def test_functional_monitoring_fails_when_one_of_its_parameters_violates_a_limit(station, functions):
    station.do("MANIPULATOR", 12, 5, n=[_limit(1, 5, 10), _limit(2, 0, 10)])
    group = {"fmon_id": 7, "validity_parameter_id": 0, "validity_mask": 0, "validity_expected_value": 0, "event_definition_id": 0,
             "min_pmon_failing_number": 1, "n2": [1, 2]}
    station.do("MANIPULATOR", 12, 23, n1=[group])
    assert station.ask("MANIPULATOR", 12, 25, n=[7])["n1"][0]["n2"] == [{"pmon_id": 1}, {"pmon_id": 2}]
    station.do("MANIPULATOR", 12, 1, n=[1, 2])
    station.do("MANIPULATOR", 12, 15)
    station.do("MANIPULATOR", 12, 17)
    station.do("MANIPULATOR", 12, 19, n=[7])
    station.do("MANIPULATOR", 12, 21, n=[7])
    station.refuse(PROTECTED, "MANIPULATOR", 12, 20, n=[7])

    def failed():
        entry = station.ask("MANIPULATOR", 12, 27)["n"][0]
        return entry["fmon_checking_status"] == "failed"

    station.wait(failed, "the functional definition to fail")


def test_statistics_of_a_parameter_are_reported_on_request_and_periodically(station):
    age = {"parameter_id": AGE, "sampling_interval": 0.5}
    station.do("MANIPULATOR", 4, 6, n=[age])
    definitions = station.ask("MANIPULATOR", 4, 8)
    assert [(entry["parameter_id"], entry["sampling_interval"]) for entry in definitions["n"]] == [(AGE, 0.5)]
    station.do("MANIPULATOR", 4, 3)

    def sampled():
        found = station.ask("MANIPULATOR", 4, 1, reset_flag=0)["n"]
        return found and found[0]["number_of_samples"] >= 3 and found

    found = station.wait(sampled, "three samples")[0]
    assert (found["max_value"], found["min_value"], found["mean_value"], found["standard_deviation"]) == (0, 0, 0.0, 0.0)
    since = len(station.reports)
    station.do("MANIPULATOR", 4, 4, reporting_interval=2.0)
    station.report(4, 2, apid=MANIPULATOR, since=since)
    station.do("MANIPULATOR", 4, 5)
    since = len(station.reports)
    station.wait_until(station.now() + 5.0)
    assert not [p for p, _ in station.reports[since:] if p.message == (4, 2) and p.apid == MANIPULATOR]
    station.do("MANIPULATOR", 4, 7, n=[AGE])
    station.refuse(UNKNOWN_ID, "MANIPULATOR", 4, 7, n=[AGE])
