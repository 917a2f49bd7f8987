# SPDX-License-Identifier: Apache-2.0
"""Figures of a press and hold from synthetic signals with known results; every figure must be able to fail."""

import types

import numpy as np
import pytest
import signals
from hirosco_gse import contact_figures, figures, figures_common, packets

COUNT = 60_000
TIME = np.arange(COUNT) * 0.0005
# Press at 8 s, hold 9.6 to 22 s, presses of 8, 20 and 8 N to 28 s.
SEGMENTS = [("move", 12_000, 16_000), ("press", 16_000, 19_200), ("hold", 19_200, 44_000), ("press", 44_000, 56_000), ("move", 56_000, 58_000)]
ENABLED = np.where((TIME >= 4.5) & (TIME < 29.5), 0x1627, 0x1623)


PRESSED = np.interp(TIME, [8.5, 9.5, 22, 23, 24, 25, 26, 27, 28, 28.2], [0, 15, 15, 8, 8, 20, 20, 8, 8, 0])


@pytest.fixture
def run(dictionary):
    return signals.Signals("press", PRESSED, ENABLED, SEGMENTS, dictionary)


def test_a_hold_without_motion_is_within_all_bounds(run):
    found, reasons = figures.compute(run)
    assert not reasons
    run.facts.update(found)
    assert not figures.failures(run.facts)
    assert found["hold_force_mean_n"] == pytest.approx(15)
    assert found["hold_force_asked_n"] == pytest.approx(15)
    assert found["hold_force_peak"] == pytest.approx(1)
    assert found["joystick_count_rad"] == pytest.approx(6e-6)


def test_motion_is_split_into_oscillation_and_creep(run):
    stick = run.truth["STICK", "position_rad"]
    stick[:, 0] = 1e-4 * np.sin(2 * np.pi * 20 * TIME)
    stick[:, 1] = 2e-5 * TIME
    found = contact_figures.press_hold(run)
    assert found["press_hold_oscillation_rad"] == pytest.approx(2e-4, rel=0.02)
    assert found["press_hold_motion_rad"] == pytest.approx(2e-4, rel=0.02)
    assert not figures.holds("press_hold_motion_rad", 1.01e-4, figures.PRESS_BOUNDS)
    stick[:, 0] = 0
    found = contact_figures.press_hold(run)
    assert found["press_hold_oscillation_rad"] < 1e-8
    assert found["press_hold_motion_rad"] == pytest.approx(2e-4, rel=0.01)


def test_ripple_of_the_torque_is_seen_without_motion(run):
    run.stick_rpdo.words["1"] += np.where(np.arange(COUNT) % 2, 100, -100)
    assert contact_figures.press_hold(run)["hold_force_ripple_nm"] == pytest.approx(0.01)


def test_the_energy_is_the_work_that_the_torque_takes_from_the_hand(run):
    stick, torque = run.truth["STICK", "position_rad"], run.truth["STICK", "motor_torque_nm"]
    phase = 2 * np.pi * 10 * TIME
    stick[:, 0] = 1e-3 * np.sin(phase)
    torque[:, 0] = -0.1 * np.cos(phase)  # Damping: the torque opposes the velocity.
    work = 0.5 * 0.1 * 1e-3 * 2 * np.pi * 10 * 10  # Mean power times 10 s.
    assert contact_figures.press_hold(run)["hold_energy_j"] == pytest.approx(work, rel=0.01)
    torque[:, 0] *= -1
    assert contact_figures.press_hold(run)["hold_energy_j"] == pytest.approx(-work, rel=0.01)
    assert figures.compute(run)[0]["passivity_local_j"] < -work


def test_lost_contact_and_a_peak_are_seen(run):
    run.truth["CONTACT", "in_contact"][30_000:31_000] = 0
    run.truth["CONTACT", "contact_force_n"][18_000, 2] = 30
    found = contact_figures.press_hold(run)
    assert found["hold_contact_share"] == pytest.approx(0.95)
    assert found["hold_force_peak"] == pytest.approx(2.0)


def test_a_press_with_more_than_the_commanded_force_is_a_peak(run):
    """The largest force is compared with the force that the hand intends, and not with the mean force, which
    would grow with it."""
    run.truth["CONTACT", "contact_force_n"] *= 1.2
    found = contact_figures.press_hold(run)
    assert found["hold_force_mean_n"] == pytest.approx(18)
    assert found["hold_force_peak"] == pytest.approx(1.2)
    assert not figures.holds("hold_force_peak", found["hold_force_peak"], figures.PRESS_BOUNDS)


def test_transparency_detects_a_wrong_gain_of_changes(run):
    assert contact_figures.dynamic_transparency(run)["dynamic_transparency"] < 0.001
    part = slice(44_000, 56_000)
    felt = run.stick_rpdo.words["0"]
    felt[part] += (0.1 * (felt[part] - felt[part].mean())).astype(int)
    assert contact_figures.dynamic_transparency(run)["dynamic_transparency"] == pytest.approx(0.094, abs=0.003)


def test_energy_counts_from_the_coupling(run):
    joints, stick = run.truth["JOINTS", "position_rad"], run.truth["STICK", "position_rad"]
    run.truth["CONTACT", "external_torque_nm"][:] = 1.0
    stick[:, 0] = 0.0
    # The energy falls only before the coupling.
    joints[:, 0] = np.interp(TIME, [0, 4.4, 10, 20, 30], [0, -5, -5, 5, 4.9])
    assert contact_figures.passivity(run)["passivity_local_j"] == pytest.approx(0.0, abs=1e-9)
    joints[:, 0] = np.interp(TIME, [0, 10, 20], [0, 0, -0.5])
    assert contact_figures.passivity(run)["passivity_local_j"] == pytest.approx(-0.0075, rel=0.01)


def test_a_fast_part_of_the_torque_is_the_ripple(run):
    external = run.truth["CONTACT", "external_torque_nm"]
    external[:, 1] += 0.3 * np.sin(2 * np.pi * 100 * TIME)
    assert contact_figures.press_ripple(run)["press_ripple_nm"] == pytest.approx(0.6, rel=0.1)


@pytest.mark.parametrize(("name", "missing"), [("press_hold_motion_rad", ("STICK", "position_rad")), ("hold_contact_share", ("CONTACT", "in_contact")), ("passivity_local_j", ("JOINTS", "position_rad"))])
def test_without_truth_a_figure_is_missing(run, name, missing):
    run.truth[missing] = None
    found, reasons = figures.compute(run)
    assert found[name] is None
    assert "has no channel" in reasons[name]
    assert any(line.startswith(name) for line in figures.failures({**run.facts, **found, "figures_missing": reasons}))


def test_a_short_hold_gives_no_figure(run, monkeypatch):
    monkeypatch.setattr(run, "segments", lambda: [("press", 16_000, 19_200), ("hold", 19_200, 30_000)])
    assert "too short: 5.4 s, expected at least 12 s" in figures.compute(run)[1]["press_hold_motion_rad"]


def test_a_coarse_encoder_has_bounds_of_its_own():
    fine = figures.bounds_of({"mission": "rokviss", "scenario": "sim/scenarios/press.scn", "joystick_count_rad": 6e-6})
    coarse = figures.bounds_of({"mission": "rokviss", "scenario": "press", "joystick_count_rad": 9.5e-5})
    assert fine == figures.PRESS_BOUNDS
    assert coarse["press_hold_motion_rad"] == ("<=", 2e-4)
    assert coarse["hold_contact_share"] == fine["hold_contact_share"]
    assert figures.bounds_of({"mission": "rokviss", "scenario": "commissioning"}) == {}


def _set(run, owner, name, field, value, time_ns=10**9):
    """Add a telecommand to the run that sets one field of a parameter to a number."""
    subsystem = run.dictionary.subsystem(owner)
    parameter = subsystem.parameter(name)
    numbers = [value if item.name == field else float(word) for item in parameter.fields for word in item.init.split()]
    data = b"\1" + parameter.parameter_id.to_bytes(4, "big") + parameter.encode_text(",".join(map(str, numbers)))
    packet = packets.parse(packets.build_tc(subsystem.apid, 0, 20, 3, data))
    run.packets.append((time_ns, "TC", packet, b""))


def test_the_scales_are_those_of_the_flight(run):
    """They follow from the descriptor, then the initial values of the configuration, then telecommands."""
    run.stick_rpdo.words["0"] *= 2
    run.stick_rpdo.words["1"] *= 2
    assert contact_figures.dynamic_transparency(run)["dynamic_transparency"] > 0.5
    _set(run, "JOYSTICK", "CONTROL", "FORCE_SCALE", 0.06)
    assert contact_figures.dynamic_transparency(run)["dynamic_transparency"] < 0.001
    assert figures_common.force_scale(run) == 0.06
    assert figures_common.position_scale(run) == 2.0
    run.packets.clear()
    joystick = run.dictionary.subsystem("JOYSTICK")
    joystick.configuration("TELEPRESENCE").initial["CONTROL", "FORCE_SCALE"] = "0.02"
    assert figures_common.force_scale(run) == 0.03
    run.reports.append((0, types.SimpleNamespace(apid=joystick.apid), {"configuration_id": joystick.configuration("TELEPRESENCE").id}))
    assert figures_common.force_scale(run) == 0.02
    run.dictionary = None
    assert "no dictionary" in figures.compute(run)[1]["dynamic_transparency"]
