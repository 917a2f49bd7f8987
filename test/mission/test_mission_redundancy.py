# SPDX-License-Identifier: Apache-2.0
"""Channels A and B of each bus: a cut of A has the effects of an unplug, and by command the mission continues
on B."""

import flying
import numpy as np
import pytest
from hirosco_gse import logs
from hirosco_gse import run as runs

REACTION_US = 5000
REPORTED_US = 10_000
TOGGLE_US = 2 * 60_000  # Ttoggle x consumer heartbeat time of the data sheets
MASTER, SYNC = 0x701, 0x080
DEVICE_REFUSED = 13
NODES = {"robot": (0x11, 0x12), "joystick": (0x21,)}
OWNER = {"robot": ("MANIPULATOR", 16), "joystick": ("JOYSTICK", 17)}
CUT_S = {"robot": 1.5, "joystick": 4.5}
UP_S = {"robot": 2.6, "joystick": 5.6}
END_S = 7.5
CHANNEL_LOGS = ("can-robot-b.log", "can-joystick-b.log")


def _scenario(path):
    """Both buses are in operation on channel A. The robot's channel A is cut while the arm moves, and the robot is
    brought up on B; then the same happens to the joystick; then both operate again."""
    lines = ["0.0 hand rest", "0.2 hand circle 0.1 0.5 1 9 1", *flying.bring_up(0.2, tare=False)]
    for bus, (owner, _) in OWNER.items():
        cut, up = CUT_S[bus], UP_S[bus]
        lines += [
            f"{cut:.6f} fault cut {bus}",
            f"{cut:.6f} operator wait-event {owner} DEVICE_LOST 0.2",
            f"{cut:.6f} operator wait-state MANIPULATOR OFFLINE 1",
            f"{cut:.6f} operator wait-state JOYSTICK OFFLINE 1",
            f"{up:.6f} operator cmd {owner}.CHANNEL CHANNEL=1",
            f"{up:.6f} operator wait-event {owner} CHANNEL_SELECTED 0.1",
            *flying.bring_up(up, tare=False),
        ]
    lines.append(f"{END_S:.6f} operator shutdown")
    return flying.write_scenario(path, *lines)


@pytest.fixture(scope="module")
def flights(session_directory):
    """The same flight in both forms."""
    return flying.fly_in_both_forms(session_directory, "channels", _scenario(session_directory / "channels.scn"))


@pytest.fixture(scope="module")
def run(flights):
    """Logs of one of these flights."""
    return runs.load(flights["image"].directory)


@pytest.fixture(scope="module")
def buses(flights):
    """Frames of all channels."""
    directory = flights["image"].directory
    return {name: logs.read_bus(directory / f"can-{name}.log") for bus in NODES for name in (bus, f"{bus}-b")}


def _cuts(run):
    return {fault["target"]: fault["time_us"] for fault in run.truth["FAULT"] if fault["kind"] == "cut"}


def _transitions(flight, apid):
    """(time_us, state) of each change of state of a subsystem."""
    packets = [(t // 1000, raw) for t, direction, raw in flight.packets if direction == "TM"]
    mine = [(t, raw) for t, raw in packets if int.from_bytes(raw[:2], "big") & 0x7FF == apid and raw[7:9] == b"\x81\x02"]
    return [(t, raw[22]) for t, raw in mine if raw[21] != raw[22]]


def test_both_forms_give_identical_logs(flights):
    for name in (*flying.TRACED, *CHANNEL_LOGS):
        assert flights["image"].octets(name) == flights["processes"].octets(name), name


def test_cut_has_the_same_reaction_as_an_unplug(flights, run):
    """All four axes leave operation within 5 ms, both subsystems report within 10 ms, and then the plan takes
    them to OFFLINE."""
    entries = {}
    for entry in run.truth["DRIVE"]:
        entries.setdefault((entry["bus"], int(entry["node"]), int(entry["axis"])), []).append(entry)
    cuts = _cuts(run)
    assert list(cuts) == ["robot", "joystick"]
    for bus, cut in cuts.items():
        for drive, history in entries.items():
            before = [entry for entry in history if entry["time_us"] < cut][-1]
            assert flying.is_enabled(before["statusword"]), f"{drive} was not in operation when {bus} was cut"
            left = next(e["time_us"] for e in history if e["time_us"] >= cut and not flying.is_enabled(e["statusword"]))
            assert left - cut <= REACTION_US, f"{drive}: {left - cut} us after the cut of {bus}"
        for apid in (16, 17):
            states = [(t - cut, state) for t, state in _transitions(flights["image"], apid) if cut <= t < cut + 1_000_000]
            assert states[0][0] <= REPORTED_US
            assert [state for _, state in states] == flying.ERROR_TO_OFFLINE


def test_arm_was_moving_and_stops(run):
    at = _cuts(run)["robot"] // runs.CYCLE_US
    speed, link = run.at_cycles("JOINTS", "velocity_rad_s"), run.at_cycles("JOINTS", "position_rad")
    assert np.abs(speed[at]).max() > 0.1
    assert np.ptp(link[at + 40 : at + 1000], axis=0).max() < 0.001


@pytest.mark.parametrize("bus", NODES)
def test_all_nodes_answer_on_channel_b_in_time(buses, run, bus):
    """The time from the master's first heartbeat on B to the first frame of each node on B is within Ttoggle
    x heartbeat time."""
    b = buses[f"{bus}-b"]
    first = b.time_us[b.frames(MASTER)][0]
    assert first > UP_S[bus] * 1e6, "the master sent on channel B before the command to select it"
    for node in NODES[bus]:
        times = b.time_us[b.frames(0x700 + node)]
        answer = times[times >= first][0]
        assert answer - first <= TOGGLE_US, f"node {node:#x}: {answer - first} us"
        searching = times[(times > _cuts(run)[bus]) & (times < first)]
        assert len(searching), f"node {node:#x} has not searched its master on channel B"


@pytest.mark.parametrize("bus", NODES)
def test_the_master_sends_on_one_channel_at_a_time(buses, bus):
    """Before the command the flight software sends no frame on B, after it none on A."""
    selected_us = UP_S[bus] * 1e6
    mine = [0x000, SYNC, MASTER, *(base + node for base in (0x200, 0x300, 0x600) for node in NODES[bus])]
    a, b = buses[bus], buses[f"{bus}-b"]
    assert not (np.isin(b.id, mine) & (b.time_us < selected_us)).any()
    assert (np.isin(b.id, mine) & (b.time_us > selected_us)).any()
    assert not (np.isin(a.id, mine) & (a.time_us > selected_us)).any()


@pytest.mark.parametrize("bus", NODES)
def test_mission_continues_over_b(flights, buses, run, bus):
    """On B, SYNC and the answer of each node occur in every cycle; the subsystems are in operation, and the
    arm moves."""
    b = buses[f"{bus}-b"]
    start, end = (END_S - 0.5) * 1e6, (END_S - 0.1) * 1e6
    for identifier in (SYNC, *(0x180 + node for node in NODES[bus])):
        times = b.time_us[b.frames(identifier)]
        inside = times[(times >= start) & (times < end)]
        assert len(inside) == pytest.approx((end - start) / 500, abs=1), f"{identifier:#x}"
    for _, apid in OWNER.values():
        assert [state for t, state in _transitions(flights["image"], apid) if t < end][-1] == flying.OPERATIONAL
    speed = run.at_cycles("JOINTS", "velocity_rad_s")[int(start) // runs.CYCLE_US : int(end) // runs.CYCLE_US]
    assert np.abs(speed).max() > 0.1


def _arm(at):
    """Bring the arm alone into operation, in position mode."""
    steps = ("state MANIPULATOR PRE_OPERATIONAL", "config MANIPULATOR STAND_ALONE", "state MANIPULATOR SAFE_OPERATIONAL", "state MANIPULATOR OPERATIONAL")
    return [f"{at:.6f} operator {step}" for step in steps]


def _lost(at):
    return [f"{at:.6f} operator wait-event MANIPULATOR DEVICE_LOST 0.05", f"{at:.6f} operator wait-state MANIPULATOR OFFLINE 0.7"]


NO_ANSWER = "expect-refusal 0x0301 state MANIPULATOR PRE_OPERATIONAL"  # The time-out of HARDWARE_INIT.
DIFFICULT = {
    "selected_in_error_operational": [
        "1.2 fault cut robot",
        "1.3 operator expect-state MANIPULATOR ERROR_OPERATIONAL",
        "1.3 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        "1.3 operator wait-state MANIPULATOR OFFLINE 1",
        *_arm(2.0),
    ],
    "cut_while_offline": [
        "1.2 operator state MANIPULATOR OFFLINE",
        "1.5 fault cut robot",
        f"2.0 operator {NO_ANSWER}",
        "4.5 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(4.6),
    ],
    "both_cut_and_b_mended": [
        "1.2 fault cut robot",
        "1.25 fault cut robot-b",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        f"2.0 operator {NO_ANSWER}",
        "4.5 fault mend robot-b",
        *_arm(4.6),
    ],
    "b_cut_during_the_change": [
        "1.2 fault cut robot",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        "2.03 fault cut robot-b",
        "2.03 fault mend robot",
        f"2.0 operator {NO_ANSWER}",
        "4.5 operator cmd MANIPULATOR.CHANNEL CHANNEL=0",
        *_arm(4.6),
    ],
    "one_device_cut_and_back_to_a": [
        "1.2 fault cut robot JOINT2",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(2.0),
        "3.0 fault mend robot JOINT2",
        "3.1 operator state MANIPULATOR OFFLINE",
        "3.2 operator cmd MANIPULATOR.CHANNEL CHANNEL=0",
        *_arm(3.3),
    ],
    "power_cycle_while_the_master_is_on_b": [
        "1.2 fault cut robot",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(2.0),
        "3.0 fault unplug robot JOINT1",
        *_lost(3.0),
        "3.7 fault plug robot JOINT1",
        *_arm(3.8),
    ],
    "restart_on_a_while_the_devices_are_on_b": [
        "1.2 fault cut robot",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(2.0),
        "3.0 fault mend robot",
        "3.1 fault kill manipulator",
        *_arm(3.5),
    ],
    "restart_while_a_is_cut": [
        "1.2 fault cut robot",
        *_lost(1.2),
        "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(2.0),
        "3.1 fault kill manipulator",
        f"3.5 operator {NO_ANSWER}",
        "6.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(6.1),
    ],
    # Devices without a configuration end their search on B, where it began; the restarted process begins on A.
    "restart_after_the_search": [
        "1.2 operator state MANIPULATOR OFFLINE",
        "1.5 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        "1.5 operator state MANIPULATOR PRE_OPERATIONAL",
        "2.0 fault kill manipulator",
        f"36.0 operator {NO_ANSWER}",
        "38.5 operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
        *_arm(38.6),
    ],
    "only_where_nothing_moves": [
        "1.2 operator expect-refusal 0x0110 cmd MANIPULATOR.CHANNEL CHANNEL=1",  # PUS_FAILURE_PERMISSION.
        "1.3 operator state MANIPULATOR OFFLINE",
        "1.4 operator expect-refusal 0x0203 cmd MANIPULATOR.CHANNEL CHANNEL=2",  # PUS_FAILURE_OUT_OF_RANGE.
        *_arm(1.5),
    ],
}


@pytest.mark.parametrize("name", DIFFICULT)
def test_the_arm_can_be_commanded_into_operation_after_cuts(directory, name):
    """Cuts during a transition, of both channels, or of one device: by command the arm is in operation again
    and moves."""
    lines = ["0.0 hand rest", *_arm(0.3), *DIFFICULT[name]]
    end = max(float(line.split()[0]) for line in lines) + 1.0
    lines += [
        f"{end:.6f} operator expect-state MANIPULATOR OPERATIONAL",
        f"{end:.6f} operator cmd MANIPULATOR.MOVE_TO POSITION=1.0,-1.5 DURATION=0.5",
        f"{end + 0.6:.6f} operator shutdown",
    ]
    scenario = flying.write_scenario(directory.with_suffix(".scn"), *lines)
    flight = flying.fly(directory, "--scenario", scenario, "--form", "image")
    assert flight.code == 0, flight.transcript()


SLOW, SLOW_TOGGLE_US = 0x12, 2 * 200_000  # Of the data sheets of wheels, gyros, star trackers and cameras
SEARCH_US, RETRY_US = 160_000, 300_000  # Longest wait of HARDWARE_INIT for the devices; time between two resets.
CYCLE_US = 500


def _with_slow_joint(root):
    """The descriptors, with a world in which JOINT2 has the consumer heartbeat time of wheels and sensors."""
    flying.descriptors_copied(root)
    devices = root / "descriptors" / "devices"
    (devices / "slow-drive.eds").write_text((devices / "joint-drive.eds").read_text(encoding="utf-8"), encoding="utf-8")
    flying.replace(devices / "slow-drive.eds", ("DefaultValue=0x0001003C", "DefaultValue=0x000100C8"))
    flying.replace(root / "descriptors" / "worlds" / "rokviss.xml", (f'node="{SLOW:#x}" eds="joint-drive.eds"', f'node="{SLOW:#x}" eds="slow-drive.eds"'))
    return root


def _resets(flight, bus, from_us):
    """Nodes of the NMT resets on a channel within one second."""
    frames = logs.read_bus(flight.directory / f"can-{bus}.log")
    times, commands = frames.time_us[frames.frames(0)], frames.data[frames.frames(0)]
    return [int(data[1]) for t, data in zip(times, commands, strict=True) if data[0] == 0x81 and from_us <= t < from_us + 1e6]


def test_a_restarted_process_resets_devices_that_were_on_channel_b_once(directory, tmp_path):
    """The process dies while it is the master on B, and A is mended. JOINT1 arrives on A and has heard no heartbeat there yet: without one
    before the reset, it would return to B."""
    up = 3.7
    lines = ["0.0 hand rest", *_arm(0.3), "1.2 fault cut robot", *_lost(1.2), "2.0 operator cmd MANIPULATOR.CHANNEL CHANNEL=1", *_arm(2.0),
             "3.2 fault mend robot", "3.4 fault kill manipulator", *_arm(up), f"{up + 1.1} operator expect-state MANIPULATOR OPERATIONAL",
             f"{up + 1.1} operator shutdown"]
    scenario = flying.write_scenario(directory.with_suffix(".scn"), *lines)
    flight = flying.fly(directory, "--scenario", scenario, "--form", "image", root=_with_slow_joint(tmp_path / "root"))
    assert flight.code == 0, flight.transcript()
    assert _resets(flight, "robot", up * 1e6) == [0]


@pytest.mark.long
@pytest.mark.parametrize(("selected_s", "resets"), [(1.75, [0]), (2.0, [0, SLOW])])
def test_a_node_with_a_heartbeat_time_of_200_ms_is_found_on_channel_b(directory, tmp_path, selected_s, resets):
    """In the world, JOINT2 has the consumer heartbeat time of wheels and sensors. When the channel is selected, this joint is either on B, or it
    has just changed to A. In the first case one reset suffices, although JOINT1 has just arrived on B. In the second case JOINT2 arrives after
    the wait for the devices, and only it is reset again."""
    root = _with_slow_joint(tmp_path / "root")
    end = selected_s + 1.5
    lines = ["0.0 hand rest", *_arm(0.3), "1.2 fault cut robot", *_lost(1.2), f"{selected_s} operator cmd MANIPULATOR.CHANNEL CHANNEL=1",
             *_arm(selected_s), f"{end} operator expect-state MANIPULATOR OPERATIONAL", f"{end} operator shutdown"]
    scenario = flying.write_scenario(directory.with_suffix(".scn"), *lines)
    flight = flying.fly(directory, "--scenario", scenario, "--form", "image", root=root)
    assert flight.code == 0, flight.transcript()

    b = logs.read_bus(directory / "can-robot-b.log")
    found = b.time_us[b.frames(MASTER)][0]
    heard = {node: b.time_us[b.frames(0x700 + node)] for node in NODES["robot"]}
    searching = heard[SLOW][heard[SLOW] < found]
    last_on_a = logs.read_bus(directory / "can-robot.log")
    last_us = [t for t in last_on_a.time_us[last_on_a.frames(MASTER)] if t <= 1.2e6][-1]
    assert 0 <= searching[0] - last_us - SLOW_TOGGLE_US < 1000
    delay = heard[SLOW][heard[SLOW] >= found][0] - found
    assert delay <= 20_000 if resets == [0] else SEARCH_US < delay <= SLOW_TOGGLE_US, delay

    nmt = [(t, data[1]) for t, data in zip(b.time_us[b.frames(0)], b.data[b.frames(0)], strict=True) if data[0] == 0x81 and t < found + 1e6]
    assert [node for _, node in nmt] == resets
    assert nmt[0][0] - found <= SEARCH_US + 3 * CYCLE_US
    assert all(abs(later - earlier - RETRY_US) <= CYCLE_US for (earlier, _), (later, _) in zip(nmt, nmt[1:], strict=False))
    for node, times in heard.items():
        boots = [t for t, data in zip(times, b.data[b.frames(0x700 + node)], strict=True) if data[0] == 0 and t < found + 1e6]
        assert len(boots) == 1, f"node {node:#x} has booted on B at {boots}"
    refused = [raw[23:25] for _, _, raw in flight.packets if raw[7:9] == b"\x05\x02" and raw[22] == DEVICE_REFUSED]
    assert refused == [bytes([node, 1]) for node in resets[1:]]
