# SPDX-License-Identifier: Apache-2.0
"""Every device is disconnected at 20 phases of the cycle while the hand moves: all drives leave operation,
and all members report it."""

import flying
import numpy as np
import pytest
from hirosco_gse import figures
from hirosco_gse import run as runs

OFFLINE, ERROR_OPERATIONAL = 0, 6
PHASES = 20
CYCLE_S = 500e-6
PERIOD_S = 2.5
FIRST_S = 0.5
BRING_UP_S = 1.2  # Devices may first have to change to the active channel.
REACTION_US = 5000  # Largest time in which a drive leaves operation.
STOPPING_S = 0.015  # Time to stop a moving joint: reaction, brake, spring of the joint.
DRIVES = {("robot", 0x11, 0), ("robot", 0x12, 0), ("joystick", 0x21, 0), ("joystick", 0x21, 1)}
DEVICES = {"STICK": ("joystick", "JOYSTICK"), "JOINT1": ("robot", "MANIPULATOR"), "JOINT2": ("robot", "MANIPULATOR")}


def _scenario(path, device):
    """Bring up, unplug at the next phase, wait until the recovery plan has led to OFFLINE, plug in, and repeat."""
    bus, owner = DEVICES[device]
    lines = ["0.0 hand rest", f"0.2 hand circle 0.1 0.5 1 {PHASES * PERIOD_S:.0f} 1"]
    for phase in range(PHASES):
        start = FIRST_S + phase * PERIOD_S
        cut = start + BRING_UP_S + phase * CYCLE_S / PHASES
        lines += flying.bring_up(start, tare=False)
        lines += [
            f"{cut:.6f} fault unplug {bus} {device}",
            f"{cut:.6f} operator wait-event {owner} DEVICE_LOST 0.2",
            f"{cut:.6f} operator wait-state MANIPULATOR OFFLINE 1",
            f"{cut:.6f} operator wait-state JOYSTICK OFFLINE 1",
            f"{cut + 0.8:.6f} fault plug {bus} {device}",
        ]
    lines.append(f"{FIRST_S + PHASES * PERIOD_S:.6f} operator shutdown")
    return flying.write_scenario(path, *lines)


@pytest.fixture(scope="module", params=DEVICES)
def unplugged(request, session_directory):
    """(device, flight, its logs) for each device, cut at every phase."""
    device = request.param
    path = _scenario(session_directory / f"unplug-{device}.scn", device)
    flight = flying.fly(session_directory / f"unplug-{device}", "--scenario", path, "--form", "image")
    assert flight.code == 0, flight.transcript()
    return device, flight, runs.load(flight.directory)


def _cuts(run):
    return [fault["time_us"] for fault in run.truth["FAULT"] if fault["kind"] == "unplug"]


def test_devices_are_unplugged_at_20_phases_of_the_cycle(unplugged):
    """The instants are 25 us apart over the whole cycle."""
    _, _, run = unplugged
    assert sorted(cut % 500 for cut in _cuts(run)) == list(range(0, 500, 25))


def test_all_drives_leave_operation_within_5_ms(unplugged):
    """By the truth of the drives, each drive that was enabled at the cut is disabled at most 5 ms later and
    stays disabled."""
    device, _, run = unplugged
    entries = {}
    for entry in run.truth["DRIVE"]:
        entries.setdefault((entry["bus"], int(entry["node"]), int(entry["axis"])), []).append(entry)
    assert set(entries) == DRIVES
    for cut in _cuts(run):
        for drive, history in entries.items():
            before = [entry for entry in history if entry["time_us"] < cut][-1]
            assert flying.is_enabled(before["statusword"]), f"{drive} was not in operation when {device} was cut at {cut} us"
            left = next(e["time_us"] for e in history if e["time_us"] >= cut and not flying.is_enabled(e["statusword"]))
            assert left - cut <= REACTION_US, f"{drive} took {left - cut} us when {device} was cut at phase {cut % 500} us"
            # The device is plugged in again 800 ms after the cut.
            later = [e for e in history if left <= e["time_us"] < cut + 700_000]
            assert not any(flying.is_enabled(e["statusword"]) for e in later)


def test_all_members_report_error_operational_and_reach_offline(unplugged):
    """Both members report ERROR_OPERATIONAL by TM[129,2] within 10 ms, and the owner of the device a HIGH event; then the
    recovery plan leads both to OFFLINE."""
    device, flight, run = unplugged
    owner = {"JOYSTICK": 17, "MANIPULATOR": 16}[DEVICES[device][1]]
    packets = [(t // 1000, int.from_bytes(raw[:2], "big") & 0x7FF, raw) for t, direction, raw in flight.packets if direction == "TM"]
    for cut in _cuts(run):
        after = [(t - cut, apid, raw) for t, apid, raw in packets if cut <= t <= cut + 1_000_000]
        for apid in (16, 17):
            # Octets 21 and 22 of TM[129,2]: previous and new state.
            states = [(t, raw[22]) for t, source, raw in after if source == apid and raw[7:9] == b"\x81\x02" and raw[21] != raw[22]]
            assert states[0][1] == ERROR_OPERATIONAL, f"APID {apid}, cut of {device} at {cut} us: {states}"
            assert states[0][0] <= 10_000
            # Through POST_OPERATIONAL, HARDWARE_DEINIT and SOFTWARE_DEINIT.
            assert [state for _, state in states] == [ERROR_OPERATIONAL, 7, 8, 9, OFFLINE]
        high = [(t, apid) for t, apid, raw in after if raw[7:9] == b"\x05\x04"]
        assert high[0][1] == owner
        assert high[0][0] <= 10_000


def test_arm_stops_and_is_held(unplugged):
    """A moving arm stops within STOPPING_S times its largest speed, then it is held. The largest speed may be later than the
    cut: until the drives react, the control can still accelerate the arm."""
    _, _, run = unplugged
    link, speed = run.at_cycles("JOINTS", "position_rad"), run.at_cycles("JOINTS", "velocity_rad_s")
    fastest = 0.0
    for cut in _cuts(run):
        at = cut // runs.CYCLE_US
        moved = np.abs(link[at : at + 1000] - link[at]).max(axis=0)
        allowed = 0.001 + np.abs(speed[at : at + REACTION_US // runs.CYCLE_US]).max(axis=0) * STOPPING_S
        assert (moved < allowed).all(), f"cut at {cut} us: {moved} rad, allowed {allowed}"
        held = link[at + 60 : at + 1000]  # From 30 ms to 500 ms after the cut.
        assert np.ptp(held, axis=0).max() < 0.001
        fastest = max(fastest, float(np.abs(speed[at]).max()))
    assert fastest > 0.2, "expected the arm in motion at one of the cuts"


def test_every_engagement_is_without_a_jerk(unplugged):
    _, _, run = unplugged
    found = figures.engagement_step(run)
    assert found["engagements"] == 2 * PHASES
    assert figures.holds("engagement_step_rad", found["engagement_step_rad"]), found


def test_run_json_has_the_figures_that_this_test_computes(unplugged):
    _, _, run = unplugged
    found = figures.unplug(run)
    assert found["unplugs"] == PHASES
    assert found["unplug_members_reported"]
    assert figures.holds("unplug_reaction_s", found["unplug_reaction_s"])
