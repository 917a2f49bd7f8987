# SPDX-License-Identifier: Apache-2.0
"""Figures of a flight with delay from synthetic signals with known results; every figure must be able to fail."""

import numpy as np
import pytest
import signals
from hirosco_gse import delay_figures, figures

COUNT = 100_000
TIME = np.arange(COUNT) * 0.0005
SEGMENTS = [("rest", 0, 8_000), ("move", 8_000, 12_000), ("press", 12_000, 16_000), ("hold", 16_000, 40_000), ("follow", 40_000, 50_000),
            ("hold", 50_000, 70_000), ("move", 70_000, 72_000), ("home", 72_000, 76_000), ("circle", 76_000, 92_000), ("home", 92_000, 96_000),
            ("rest", 96_000, COUNT)]
PRESSED = np.interp(TIME, [6.5, 7.5, 35, 35.5], [0, 15, 15, 0])
ENABLED = np.where((TIME >= 3) & (TIME < 49), 0x1627, 0x1623)
FIRST, SECOND = slice(26_000, 40_000), slice(56_000, 69_500)


@pytest.fixture
def run(dictionary):
    found = signals.Signals("relay", PRESSED, ENABLED, SEGMENTS, dictionary)
    found.facts["relay"] = {"round_trip_ms": 100}
    return found


def value(run, name):
    return figures.compute(run)[0][name]


def fails(run, name):
    found, reasons = figures.compute(run)
    lines = figures.failures({**run.facts, **found, "figures_missing": reasons})
    return any(line.split()[0] == name for line in lines)


def test_a_flight_without_oscillation_is_within_all_bounds(run):
    found, reasons = figures.compute(run)
    assert not reasons
    assert figures.failures({**run.facts, **found}) == []
    assert found["delay_hold_oscillation_rad"] == found["delay_after_follow_rad"] == 0
    assert found["delay_reflection_error"] < 1e-3  # The resolution of the process data.
    assert found["delay_contact_share"] == 1
    assert found["delay_force_peak_n"] == pytest.approx(15)
    assert found["delay_end_error_m"] == 0
    assert found["delay_free_drag_nm"] == 0


@pytest.mark.parametrize(("name", "window", "other"), [("delay_hold_oscillation_rad", FIRST, "delay_after_follow_rad"),
                                                       ("delay_after_follow_rad", SECOND, "delay_hold_oscillation_rad")])
def test_an_oscillation_is_seen_in_its_hold_and_creep_is_not(run, name, window, other):
    stick = run.truth["STICK", "position_rad"]
    stick[window, 1] = 1.1e-4 * np.sin(2 * np.pi * 20 * TIME[window])
    assert value(run, name) == pytest.approx(2.2e-4, rel=0.05)
    assert fails(run, name) and not fails(run, other)
    stick[:] = 2e-5 * TIME[:, None]
    assert value(run, name) < 1e-8


def test_a_wrong_torque_in_the_first_hold_is_seen(run):
    run.stick_rpdo.words["0"][26_000:40_000] += 3
    run.stick_rpdo.words["1"][26_000:40_000] += 1
    assert fails(run, "delay_reflection_error")
    assert value(run, "delay_reflection_error") == pytest.approx(np.hypot(3, 1) * 1e-4 / (0.03 * 15 * np.hypot(0.28, 0.1)), abs=5e-4)


@pytest.mark.parametrize("window", [FIRST, SECOND])
def test_contact_lost_in_either_hold_is_seen(run, window):
    run.truth["CONTACT", "in_contact"][window.start + 100 : window.start + 400] = 0
    assert fails(run, "delay_contact_share")
    assert value(run, "delay_contact_share") == pytest.approx(1 - 300 / 14_000)


@pytest.mark.parametrize(("cycle", "counts"), [(13_000, True), (45_000, True), (69_999, True), (71_000, False)])
def test_the_largest_force_from_the_press_to_the_end_of_the_second_hold_is_seen(run, cycle, counts):
    run.truth["CONTACT", "contact_force_n"][cycle] = (0, 0, 26)
    assert fails(run, "delay_force_peak_n") is counts
    run.facts["relay"]["round_trip_ms"] = 300
    assert not fails(run, "delay_force_peak_n")


def test_an_arm_that_does_not_end_at_its_commanded_position_is_seen(run):
    run.truth["JOINTS", "position_rad"][80_000:, 0] = 0.004
    assert value(run, "delay_end_error_m") == pytest.approx(0.004 * 0.47, rel=1e-3)
    assert fails(run, "delay_end_error_m")
    run.truth["STICK", "position_rad"][80_000:, 0] = 0.002
    assert value(run, "delay_end_error_m") < 1e-9


def test_the_drag_is_measured_in_the_circle_except_its_first_and_last_2_s(run):
    felt = run.stick_rpdo.words["1"]
    felt[76_000:79_900] = felt[88_100:92_000] = 1000
    assert value(run, "delay_free_drag_nm") == 0
    felt[80_000:88_000] = 160
    assert value(run, "delay_free_drag_nm") == pytest.approx(0.016)
    assert fails(run, "delay_free_drag_nm")


@pytest.mark.parametrize(("name", "verb"), [("delay_hold_oscillation_rad", "hold"), ("delay_end_error_m", "home"), ("delay_free_drag_nm", "circle")])
def test_without_its_segment_a_figure_is_missing_and_fails(run, name, verb):
    run.found = [segment for segment in SEGMENTS if segment[0] != verb]
    found, reasons = figures.compute(run)
    assert found[name] is None and reasons[name]
    assert fails(run, name)


def test_a_short_hold_gives_no_figure(run):
    run.found = [*SEGMENTS[:3], ("hold", 16_000, 33_000), *SEGMENTS[4:]]
    assert "too short: 8.5 s, expected at least 9 s" in figures.compute(run)[1]["delay_hold_oscillation_rad"]


def test_without_a_world_the_error_at_the_end_is_missing(run):
    run.world = None
    assert "no world" in figures.compute(run)[1]["delay_end_error_m"]


@pytest.mark.parametrize("name", ("delay_hold_oscillation_rad", "delay_force_peak_n"))
def test_the_bound_depends_on_the_round_trip_time(name):
    def bound(delay_ms):
        found = delay_figures.bounds_of({"relay": {"round_trip_ms": delay_ms}})
        return found.get(name, (None, None))[1]

    assert bound(1) == bound(20) == bound(100) < bound(101) == bound(300)
    assert bound(301) is None
    assert delay_figures.bounds_of({"relay": {"round_trip_ms": 20, "network": True}}) == {}
    assert figures.bounds_of({"mission": "rokviss", "scenario": "relay"}) == {}
