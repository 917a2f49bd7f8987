# SPDX-License-Identifier: Apache-2.0
"""The CAN frames of a flight: commands to the drives, their answers, and the nodes that do not send."""

import itertools

import numpy as np
import pytest
from hirosco_gse import logs

SYNC, CYCLE_US = 0x080, 500
JOINTS, STICK = (0x11, 0x12), 0x21
STATE = 0x6F
SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP, FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
SYNC_JITTER_US = 65  # A SYNC waits for at most one frame more than the SYNC before it.
LEGAL = {  # CiA 402: power state -> states that may be reported after it
    0x40: {0x21, 0x40},
    0x21: {0x23, 0x40, 0x21},
    0x23: {0x27, 0x21, 0x40, 0x23},
    0x27: {0x23, 0x21, 0x40, 0x07, 0x0F, 0x27},
    0x07: {0x40, 0x27, 0x0F, 0x07},
    0x0F: {0x08, 0x0F},
    0x08: {0x40, 0x08},
    0x00: {0x40, 0x00},
}


def _state(words):
    """CiA 402 power state of statuswords; bit 5 (quick stop) counts only where it distinguishes states."""
    words = words & STATE
    return np.where(words & 0x4F == 0x40, 0x40, np.where(words & 0x4F == 0x08, 0x08, np.where(words & 0x4F == 0x0F, 0x0F, words)))


@pytest.fixture(scope="module")
def flight(shared_flights):
    """The flight whose frames are checked."""
    return shared_flights.flight()


@pytest.fixture(scope="module")
def buses(flight):
    """Frames of both buses."""
    return {name: logs.read_bus(flight.directory / f"can-{name}.log") for name in ("robot", "joystick")}


@pytest.fixture(scope="module")
def truth(shared_flights, flight):
    """Drive states and faults as the simulator knows them."""
    return shared_flights.run().truth


def _transitions(flight, apid):
    """(time_us, state) of each TM[129,2] of a subsystem that changes the state, in order."""
    found = []
    for time_ns, direction, raw in flight.packets:
        if direction == "TM" and raw[7:9] == b"\x81\x02" and int.from_bytes(raw[:2], "big") & 0x7FF == apid:
            state = raw[22]
            if not found or found[-1][1] != state:
                found.append((time_ns // 1000, state))
    return found


def _spans(flight, apid, state):
    """Intervals [start_us, end_us) in which a subsystem was in a state."""
    found = _transitions(flight, apid) + [(10**9, -1)]
    return [(start, end) for (start, now), (end, _) in itertools.pairwise(found) if now == state]


def _statuswords(buses):
    """(name, times, statuswords) of every axis."""
    for node in JOINTS:
        rows = buses["robot"].frames(0x180 + node)
        yield f"joint {node:#x}", buses["robot"].time_us[rows], buses["robot"].field(rows, 0, "u2")
    rows = buses["joystick"].frames(0x280 + STICK)
    for axis in range(2):
        yield f"stick {axis}", buses["joystick"].time_us[rows], buses["joystick"].field(rows, 2 * axis, "u2")


def _controlwords(buses):
    """(name, times, controlwords) of every axis."""
    robot, stick = buses["robot"], buses["joystick"]
    for node in JOINTS:
        rows = np.sort(np.concatenate((robot.frames(0x200 + node), robot.frames(0x300 + node))))
        yield f"joint {node:#x}", robot.time_us[rows], robot.field(rows, 0, "u2")
    rows = stick.frames(0x200 + STICK)
    for axis in range(2):
        yield f"stick {axis}", stick.time_us[rows], stick.field(rows, 4 + 2 * axis, "u2")


APIDS = {"joint": 16, "stick": 17}


def test_in_safe_operational_every_axis_is_switched_on_and_not_enabled(flight, buses):
    """While SAFE_OPERATIONAL is settled, every axis reports 0x23."""
    checked = 0
    for name, times, words in _statuswords(buses):
        for start, end in _spans(flight, APIDS[name.split()[0]], 4):
            inside = (times > start + 4 * CYCLE_US) & (times < end - 2 * CYCLE_US)
            if inside.sum() < 20:
                continue  # The state was only passed on the way down.
            checked += 1
            assert set(_state(words[inside]).tolist()) == {SWITCHED_ON}, f"{name} in {start / 1e6:.4f} to {end / 1e6:.4f} s"
    assert checked >= 4 * 4  # Four axes, with four intervals of SAFE_OPERATIONAL each.


def test_in_operational_every_axis_is_enabled(flight, buses):
    checked = 0
    for name, times, words in _statuswords(buses):
        for start, end in _spans(flight, APIDS[name.split()[0]], 5):
            inside = (times > start + 4 * CYCLE_US) & (times < end - 8 * CYCLE_US)
            checked += int(inside.sum())
            assert set(_state(words[inside]).tolist()) == {ENABLED}, f"{name} in {start / 1e6:.4f} to {end / 1e6:.4f} s"
    assert checked > 500_000


@pytest.mark.parametrize("state", [0, 3, 6])
def test_in_lower_and_error_states_no_axis_is_enabled(flight, buses, state):
    for name, times, words in _statuswords(buses):
        for start, end in _spans(flight, APIDS[name.split()[0]], state):
            inside = (times > start + 12 * CYCLE_US) & (times < end)
            assert ENABLED not in set(_state(words[inside]).tolist()), f"{name} in {start / 1e6:.4f} to {end / 1e6:.4f} s"


def test_drives_follow_the_power_states_of_cia_402(buses):
    for name, times, words in _statuswords(buses):
        power_states = [int(state) for state, _ in itertools.groupby(_state(words).tolist())]
        assert power_states[0] == SWITCH_ON_DISABLED, name
        assert ENABLED in power_states, name
        for before, after in itertools.pairwise(power_states):
            # A drive may leave SWITCH_ON_DISABLED after a quick stop before it reports its statusword again.
            assert after in LEGAL[before] or (before == QUICK_STOP and after == READY), f"{name}: {before:#x} -> {after:#x}"


def test_commands_lead_up_one_state_at_a_time(buses):
    """Each transition upwards is commanded by 0x06, 0x07, 0x0F in this order; none is skipped."""
    for name, _, words in _controlwords(buses):
        controlwords = [word for word, _ in itertools.groupby((words & 0x8F).tolist())]
        assert 0x0F in controlwords, name
        for before, after in itertools.pairwise(controlwords):
            if after == 0x0F:
                assert before == 0x07, f"{name}: {before:#04x} -> 0x0F"
            if after == 0x07:
                assert before in (0x06, 0x0F), f"{name}: {before:#04x} -> 0x07"
        assert 0x80 not in controlwords, f"{name}: a fault reset was commanded without a fault"


def test_joystick_engages_without_a_push(flight, buses):
    """In the first 50 ms of OPERATIONAL the mean torque commanded for the hand is below 0.05 Nm (one encoder
    count may cause a peak)."""
    stick = buses["joystick"]
    rows = stick.frames(0x200 + STICK)
    times = stick.time_us[rows]
    spans = _spans(flight, 17, 5)
    assert len(spans) >= 4
    for start, _ in spans:
        inside = (times > start) & (times < start + 50_000)
        for axis in range(2):
            assert abs(stick.field(rows, 2 * axis, "i2")[inside].mean()) < 500, f"at {start / 1e6:.4f} s"  # In 0.1 mNm.


@pytest.mark.parametrize("bus", ["robot", "joystick"])
def test_one_sync_every_cycle(buses, bus):
    """There is one SYNC in each cycle of 500 us, without a gap, while a component sends it."""
    times = buses[bus].time_us[buses[bus].frames(SYNC)]
    steps = np.diff(times // CYCLE_US)
    assert (steps >= 1).all(), "two SYNCs in one cycle"
    breaks = np.flatnonzero(steps > 1)
    assert len(breaks) <= 4, f"{len(breaks)} gaps: SYNC stops only while the subsystem is OFFLINE or alone on its bus"
    assert (np.diff(times)[breaks] > 400_000).all()
    for part in np.split(times, breaks + 1):
        if len(part) == 1:
            # The frame waited in the controller of a bus without nodes, and was sent when a device was
            # plugged in.
            continue
        assert len(part) > 1000
        period = (part[-1] - part[0]) / (len(part) - 1)
        assert period == pytest.approx(CYCLE_US, abs=0.1)
        assert np.abs(np.diff(part) - CYCLE_US).max() <= SYNC_JITTER_US


@pytest.mark.parametrize("bus", ["robot", "joystick"])
def test_process_data_is_sent_once_per_sync(buses, bus):
    """Between two SYNCs of an undisturbed bus each device answers exactly once."""
    log = buses[bus]
    sync = log.time_us[log.frames(SYNC)]
    inside = (sync > 10_000_000) & (sync < 60_000_000)
    edges = sync[inside]
    for identifier in (0x191, 0x192) if bus == "robot" else (0x1A1, 0x2A1):
        times = log.time_us[log.frames(identifier)]
        counts = np.histogram(times, edges)[0]
        assert (counts == 1).all(), f"{identifier:#x}"


def test_frames_are_those_of_the_identifier_plan(buses):
    allowed = {
        "robot": {0x000, 0x080, 0x701, *(base + node for base in (0x080, 0x180, 0x200, 0x280, 0x300, 0x580, 0x600, 0x700) for node in JOINTS)},
        "joystick": {0x000, 0x080, 0x701, *(base + STICK for base in (0x080, 0x180, 0x200, 0x280, 0x580, 0x600, 0x700))},
    }
    for name, log in buses.items():
        identifiers = set(log.id[log.id < 0x20000000].tolist())
        assert identifiers <= allowed[name], [hex(item) for item in identifiers - allowed[name]]
        small = np.isin(log.id, [base + node for base in (0x180, 0x200, 0x280, 0x300) for node in (*JOINTS, STICK)])
        assert log.is_fd[small].all()
        assert (log.length[small] == 8).all()


def _unplugged(truth):
    """(bus, node, start_us, end_us) of each interval in which a device was unplugged."""
    nodes = {"STICK": STICK, "JOINT1": JOINTS[0], "JOINT2": JOINTS[1]}
    open_cuts, found = {}, []
    for fault in truth["FAULT"]:
        bus, name = fault["target"].split()
        if fault["kind"] == "unplug":
            open_cuts[fault["target"]] = fault["time_us"]
        elif fault["kind"] == "plug":
            found.append((bus, nodes[name], open_cuts.pop(fault["target"]), fault["time_us"]))
    return found


def test_no_node_sends_while_unplugged(buses, truth):
    cuts = _unplugged(truth)
    assert [(bus, node) for bus, node, _, _ in cuts] == [("joystick", STICK), ("robot", JOINTS[0])]
    for bus, node, start, end in cuts:
        log = buses[bus]
        sent = np.isin(log.id, [base + node for base in (0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700)])
        inside = (log.time_us > start) & (log.time_us < end)
        assert not (sent & inside).any(), f"node {node:#x} on {bus}"
        assert (sent & (log.time_us > end)).any(), f"expected frames of node {node:#x} after it was plugged in again"


def test_brakes_hold_whenever_actuators_are_off(truth):
    """By the truth, the brake of a joint that is not enabled is engaged at most 5 ms after the joint left
    operation."""
    for node in JOINTS:
        entries = [entry for entry in truth["DRIVE"] if entry["bus"] == "robot" and entry["node"] == node]
        assert entries[0]["brake_engaged"]
        for before, after in itertools.pairwise(entries):
            if after["time_us"] - before["time_us"] > 5000 and int(_state(before["statusword"])) != ENABLED:
                assert before["brake_engaged"], f"joint {node:#x} at {before['time_us'] / 1e6:.4f} s"
            if int(_state(before["statusword"])) == ENABLED and after["time_us"] - before["time_us"] > 5000:
                assert not before["brake_engaged"], f"joint {node:#x} at {before['time_us'] / 1e6:.4f} s"


def test_remaining_drives_show_their_exit_on_the_bus(buses, truth):
    """The disconnected node sends nothing; the others report within 5 ms that they have left operation-enabled."""
    for _, cut_node, cut, _ in _unplugged(truth):
        for name, times, words in _statuswords(buses):
            if (name.startswith("stick") and cut_node == STICK) or name == f"joint {cut_node:#x}":
                continue
            inside = (times > cut) & (times < cut + 500_000)
            out = times[inside][_state(words[inside]) != ENABLED]
            assert len(out), name
            assert out[0] - cut <= 5000, f"{name}: {(out[0] - cut) / 1e3:.3f} ms"
            assert (_state(words[inside & (times >= out[0])]) != ENABLED).all()
