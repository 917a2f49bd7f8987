# SPDX-License-Identifier: Apache-2.0
"""Every fault of docs/can-faults.md in one flight: the events, the following state, the counters, and the
return to operation."""

import json
import re

import flying
import pytest

INTERVAL_S = 2.0
FIRST_S = 0.3
FAULT_S = 0.9  # Time of the fault after the start of an interval.
OFFLINE, OPERATIONAL = 0, 5
MANIPULATOR, DEVICE_LOST, DRIVE_FAULT, BUS_WARNING = 16, 1, 2, 8
BOTH = {"11", "12"}
# Data of BUS_WARNING: node (00: the controller of the flight software) and condition; conditions of channel B begin at 0x0100.
WARNING, PASSIVE, BUS_OFF, OVERRUN, TIMEOUT, RESTARTED = "000001", "000002", "000003", "000004", "000005", "000006"

# name: lines of the scenario (seconds after the time of the fault), lost devices, conditions that the
# controller of the flight software must report, counters that must increase. Without a lost device the arm
# stays in operation.
FAULTS = {
    "two_answers_missed": (["0 loss robot 1", "0.0009 loss robot 0"], set(), set(), {"PDO_MISSED"}),
    "answers_missed": (["0 loss robot 1", "0.01 loss robot 0"], BOTH, set(), {"PDO_MISSED"}),
    "error_passive": (["0 corruption robot 1", "0.0011 corruption robot 0"], set(), {PASSIVE}, {"ERROR_FRAMES"}),
    "disturbed_for_long": (["0 corruption robot 1", "0.004 corruption robot 0"], BOTH, {PASSIVE, BUS_OFF, RESTARTED}, {"BUS_OFF"}),
    "bus_off": (["0 bus-off robot FLIGHT"], BOTH, {BUS_OFF, RESTARTED}, {"BUS_OFF", "BUS_RESTARTS"}),
    "lost_arbitration": (
        ["0 arbitration robot FLIGHT on", "0 delay robot JOINT1 400", "0.1 delay robot JOINT1 0", "0.1 arbitration robot FLIGHT off"],
        set(),
        set(),
        {"ARBITRATIONS_LOST"},
    ),
    "nobody_acknowledges": (["0 unplug robot", "0.7 plug robot"], BOTH, {PASSIVE, TIMEOUT}, {"NO_ACKNOWLEDGE", "TRANSMIT_TIMEOUTS"}),
    "one_device_gone": (["0 unplug robot JOINT2", "0.7 plug robot JOINT2"], {"12"}, set(), {"PDO_MISSED"}),
    "receiver_overrun": (["0 overflow robot FLIGHT 2"], set(), {OVERRUN}, {"RECEIVE_OVERRUNS"}),
    "receiver_overrun_for_long": (["0 overflow robot FLIGHT 100"], BOTH, {OVERRUN}, {"RECEIVE_OVERRUNS"}),
    "stuck_dominant": (["0 stuck robot on", "0.02 stuck robot off"], BOTH, {PASSIVE}, {"ERROR_FRAMES"}),
    "babbling_idiot": (["0 babble robot JOINT2 on", "0.02 babble robot JOINT2 off"], BOTH, set(), {"FRAMES_REFUSED"}),
    "other_channel_dead": (["0 bus-off robot-b FLIGHT"], set(), {"000103", "000106"}, {"BUS_OFF"}),
}


def _bring_up(at):
    """Bring the arm alone into operation, in position mode."""
    steps = ("state MANIPULATOR PRE_OPERATIONAL", "config MANIPULATOR STAND_ALONE", "state MANIPULATOR SAFE_OPERATIONAL", "state MANIPULATOR OPERATIONAL")
    return [f"{at:.6f} operator {step}" for step in steps]


def _slots():
    return {name: FIRST_S + number * INTERVAL_S for number, name in enumerate(FAULTS)}


def _scenario(path):
    lines = ["0.0 hand rest"]
    for name, start in _slots().items():
        actions, lost, _, _ = FAULTS[name]
        at = start + FAULT_S
        lines += _bring_up(start)
        lines.append(f"{start + 0.8:.6f} operator hk once MANIPULATOR 4712")
        for action in actions:
            after, _, words = action.partition(" ")
            lines.append(f"{at + float(after):.6f} fault {words}")
        if lost:
            lines += [
                f"{at:.6f} operator wait-event MANIPULATOR DEVICE_LOST 0.05",
                f"{at:.6f} operator wait-state MANIPULATOR OFFLINE 0.7",
            ]
        else:
            lines += [f"{at + 0.3:.6f} operator expect-state MANIPULATOR OPERATIONAL", f"{at + 0.4:.6f} operator state MANIPULATOR OFFLINE"]
    end = FIRST_S + len(FAULTS) * INTERVAL_S
    lines += [*_bring_up(end), f"{end + 0.8:.6f} operator hk once MANIPULATOR 4712", f"{end + 0.9:.6f} operator shutdown"]
    return flying.write_scenario(path, *lines)


@pytest.fixture(scope="module")
def flights(session_directory):
    """The same flight in both forms."""
    return flying.fly_in_both_forms(session_directory, "can-faults", _scenario(session_directory / "can-faults.scn"))


@pytest.fixture(scope="module")
def manipulator_reports(flights):
    """(time_us, service, subtype, event or state, auxiliary) of each event and change of state of the manipulator."""
    found = []
    for time_ns, direction, raw in flights["image"].packets:
        if direction == "TM" and int.from_bytes(raw[:2], "big") & 0x7FF == MANIPULATOR:
            if raw[7] == 5:
                found.append((time_ns // 1000, 5, raw[8], int.from_bytes(raw[21:23], "big"), raw[23:-2].hex()))
            elif raw[7:9] == b"\x81\x02" and raw[21] != raw[22]:
                found.append((time_ns // 1000, 129, 2, raw[22], ""))
    return found


def _in_interval(manipulator_reports, name, seconds=INTERVAL_S - FAULT_S):
    at = round((_slots()[name] + FAULT_S) * 1e6)
    return [(t - at, *rest) for t, *rest in manipulator_reports if at <= t < at + round(seconds * 1e6)]


def test_both_forms_give_identical_logs(flights):
    for name in (*flying.TRACED, "can-robot-b.log"):
        assert flights["image"].octets(name) == flights["processes"].octets(name), name


@pytest.mark.parametrize("name", FAULTS)
def test_lost_devices_end_in_the_safe_state(manipulator_reports, name):
    """For each lost device: a HIGH event, ERROR_OPERATIONAL in the cycle of this event, then the planned transitions
    to OFFLINE. Without a lost device the arm keeps its state."""
    _, lost, _, _ = FAULTS[name]
    inside = _in_interval(manipulator_reports, name)
    high = [(t, event, data) for t, service, subtype, event, data in inside if (service, subtype) == (5, 4)]
    states = [(t, state) for t, service, _, state, _ in inside if service == 129]
    assert {data for _, event, data in high if event == DEVICE_LOST} == lost
    if lost:
        assert [state for _, state in states] == flying.ERROR_TO_OFFLINE
        assert states[0][0] <= high[0][0] <= 5000 + (10_000 if "missed" in name else 0)
    else:
        assert not high
        assert [state for _, state in states] == [4, 7, 8, 9, 0]  # The scenario commands this later.
        assert states[0][0] >= 400_000


@pytest.mark.parametrize("name", FAULTS)
def test_controller_conditions_are_reported_by_low_events(manipulator_reports, name):
    _, _, wanted, _ = FAULTS[name]
    low = [data for _, service, subtype, event, data in _in_interval(manipulator_reports, name) if (service, subtype, event) == (5, 2, BUS_WARNING)]
    own = [data for data in low if data.startswith("00")]
    assert wanted <= set(own), own
    assert set(own) <= wanted | {WARNING, PASSIVE, TIMEOUT}, own
    assert len(own) <= 4, "expected one report of each condition, not one in every cycle"


def _counters(flight):
    """Values of COUNTERS before each fault, and at the end."""
    found = []
    for line in flight.read("operator.log").splitlines():
        text = json.loads(line)["text"]
        if "COUNTERS={" in text:
            inside = text.split("COUNTERS={")[1].split("}")[0]
            found.append({key: sum(map(int, re.findall(r"\d+", value))) for key, value in re.findall(r"(\w+): (\[[^\]]*\]|\d+)", inside)})
    return found


def test_faults_are_counted(flights):
    counters = _counters(flights["image"])
    assert len(counters) == len(FAULTS) + 1
    for (name, (_, _, _, grown)), before, after in zip(FAULTS.items(), counters[:-1], counters[1:], strict=True):
        for counter in grown - {"PDO_MISSED"}:
            assert after[counter] > before[counter], f"{name}: {counter}"
        assert after["CHANNEL"] == 0


def test_a_controller_without_automatic_restart_works_again_after_its_restart_by_command(session_directory):
    """After bus-off without automatic restart, the bring-up reports the silent devices and ends; after the
    restart it succeeds."""
    path = flying.write_scenario(
        session_directory / "restart.scn",
        "0.0 hand rest",
        *_bring_up(0.2),
        "1.0 fault restart robot FLIGHT order",
        "1.1 fault bus-off robot FLIGHT",
        "1.1 operator wait-event MANIPULATOR DEVICE_LOST 0.05",
        "1.1 operator wait-state MANIPULATOR OFFLINE 0.7",
        "2.0 operator expect-refusal 0x0301 state MANIPULATOR PRE_OPERATIONAL",  # PUS_FAILURE_STEP.
        "2.0 operator expect-event MANIPULATOR DEVICE_REFUSED",
        "4.5 operator expect-state MANIPULATOR OFFLINE",
        "4.5 fault restart robot FLIGHT now",
        *_bring_up(4.6),
        "6.0 operator shutdown",
    )
    flight = flying.fly(session_directory / "restart", "--scenario", path, "--form", "image")
    assert flight.code == 0, flight.transcript()


SYNC_CONFLICT = 15
MANY, APART_S = 200, 0.005


@pytest.fixture(scope="module")
def sync_conflict(session_directory):
    """Another node sends SYNC: once, then 200 times within a second, and once more after two seconds without
    SYNC."""
    path = flying.write_scenario(
        session_directory / "sync-conflict.scn",
        "0.0 hand rest",
        *_bring_up(0.2),
        "0.9 operator hk once MANIPULATOR 4712",
        "1.000200 fault sync robot JOINT2 1",
        "1.1 operator expect-state MANIPULATOR SAFE_OPERATIONAL",
        *(f"{1.5 + i * APART_S:.6f} fault sync robot JOINT2 1" for i in range(MANY)),
        "1.6 operator state MANIPULATOR OPERATIONAL",
        "2.6 operator expect-state MANIPULATOR OPERATIONAL",
        "4.6 fault sync robot JOINT1 1",
        "4.7 operator expect-state MANIPULATOR SAFE_OPERATIONAL",
        "4.8 operator hk once MANIPULATOR 4712",
        "4.9 operator shutdown",
    )
    return flying.fly_in_both_forms(session_directory, "sync-conflict", path)


def test_sync_of_another_node_takes_the_arm_out_of_operation_and_is_reported_once(sync_conflict):
    """The MEDIUM event leads to SAFE_OPERATIONAL in its own cycle. While the fault lasts, it is not reported
    again, and commands to higher states are still accepted."""
    flight = sync_conflict["image"]
    warnings, states = [], []
    for time_ns, direction, raw in flight.packets:
        if direction == "TM" and int.from_bytes(raw[:2], "big") & 0x7FF == MANIPULATOR:
            if raw[7] == 5 and int.from_bytes(raw[21:23], "big") == SYNC_CONFLICT:
                warnings.append((time_ns, raw[8]))
            elif raw[7:9] == b"\x81\x02" and raw[21] != raw[22]:
                states.append((time_ns, raw[22]))
    assert [subtype for _, subtype in warnings] == [3, 3], warnings
    for (time_ns, _), at_s in zip(warnings, (1.0002, 4.6), strict=True):
        assert 0 < time_ns - at_s * 1e9 <= 2_000_000
        after = next((when, state) for when, state in states if when >= time_ns)
        assert after[1] == 4 and after[0] - time_ns <= 2_000_000
    assert [state for when, state in states if 1.5e9 < when < 4.5e9] == [OPERATIONAL]
    before, after = (counters["CONFLICTING_SYNCS"] for counters in _counters(flight))
    assert after - before == MANY + 2
    for name in flying.TRACED:
        assert flight.octets(name) == sync_conflict["processes"].octets(name), name
