# SPDX-License-Identifier: Apache-2.0
"""Figures of the contact between hand, loop and environment: press and hold, transparency, energy.

In the scenario `press` the hand holds its force without motion along the contour. A control loop with little
stability margin then oscillates within the friction cone, although its mean values are correct. The figures use the
torque as well as the motion, because a torque oscillation of 0.2 Nm can move the joystick by less than one encoder
count.
"""

import numpy as np

from . import run as runs
from .figures_common import HOLD_US, SETTLED_US, Missing, filled, force_of, force_scale, position_scale, segment
from .run import CYCLE_US, OPERATION_ENABLED, STATE_MASK

# Window lengths of the moving means [cycles]: 0.2 s passes changes below 2.5 Hz, 0.05 s below 10 Hz.
SLOW, FAST = 400, 100


def _mean(signal, width):
    """Moving mean over `width` cycles about each cycle, along the first axis; shorter at the ends."""
    total = np.cumsum(np.concatenate((np.zeros((1, signal.shape[1])), signal)), axis=0)
    count = len(signal)
    low = np.maximum(np.arange(count) - width // 2, 0)
    high = np.minimum(np.arange(count) + width // 2 + 1, count)
    return (total[high] - total[low]) / (high - low)[:, None]


def _felt(run, start, end):
    """Torque command of both joystick axes [Nm]."""
    return np.stack([filled(run.stick_rpdo, str(axis), start, end) for axis in range(2)], axis=1) * runs.STICK_TORQUE_NM


def _true(run, channel, name):
    signal = run.at_cycles(channel, name)
    if signal is None:
        raise Missing(f"the truth log has no channel {channel}")
    return signal


def _press_window(run):
    """Window of 10 s in the hold after the press, from 2 s after the hold began."""
    first, end = segment(run, "hold", "press")
    start = first + SETTLED_US // CYCLE_US
    if end - start < HOLD_US // CYCLE_US:
        raise Missing(f"the hold after 'press' is too short: {(end - first) * CYCLE_US / 1e6:.1f} s, expected at least {(SETTLED_US + HOLD_US) / 1e6:g} s")
    return start, start + HOLD_US // CYCLE_US


def press_hold(run):
    """Motion, torque, contact and energy while the finger presses without following the contour."""
    start, end = _press_window(run)
    press, _ = segment(run, "press", None)
    stick = _true(run, "STICK", "position_rad")
    fast = (stick[start - SLOW : end + SLOW] - _mean(stick[start - SLOW : end + SLOW], SLOW))[SLOW:-SLOW]
    step = np.diff(stick[start - 1 : end], axis=0)
    acted = _true(run, "STICK", "motor_torque_nm")[start:end]
    force = np.linalg.norm(_true(run, "CONTACT", "contact_force_n")[press:end], axis=1)
    asked = float(np.linalg.norm(force_of(run, _true(run, "JOINTS", "position_rad")[end - 1], _true(run, "OPERATOR", "expected_torque_nm")[end - 1])))
    return {
        "press_hold_oscillation_rad": float(np.ptp(fast, axis=0).max()),
        "press_hold_motion_rad": float(np.ptp(stick[start:end], axis=0).max()),
        "hold_force_ripple_nm": float(_felt(run, start, end).std(axis=0).max()),
        "hold_contact_share": float(np.mean(_true(run, "CONTACT", "in_contact")[start:end] > 0)),
        "hold_force_peak": float(force.max() / asked),
        "hold_force_asked_n": asked,
        "hold_force_mean_n": float(force[start - press :].mean()),
        "hold_energy_j": float(-np.sum(acted * step)),
    }


def dynamic_transparency(run):
    """Error of the reflected torque below 10 Hz while the force changes in steps, relative to the changes of the external torque."""
    first, _ = segment(run, "press", "hold")
    end = max(end for verb, _, end in run.segments() if verb == "press")  # segment() has found at least one.
    external = _true(run, "CONTACT", "external_torque_nm")[first:end] * force_scale(run)
    error = _mean(_felt(run, first, end) - external, FAST)
    change = _mean(external - external.mean(axis=0), FAST)
    return {"dynamic_transparency": float(np.sqrt(np.sum(error**2) / np.sum(change**2)))}


def press_ripple(run):
    """Peak-to-peak value of the fast part of joint 2's external torque, from the first contact to the segment `follow`."""
    press, end = segment(run, "press", None)
    touch = np.flatnonzero(_true(run, "CONTACT", "in_contact")[press:end] > 0)
    if not len(touch):
        raise Missing("the finger did not touch the contour")
    start = press + int(touch[0])
    external = _true(run, "CONTACT", "external_torque_nm")
    fast = (external[start : end + FAST] - _mean(external[start : end + FAST], FAST))[FAST:-FAST, 1]
    return {"press_ripple_nm": float(np.ptp(fast))}


def follow_transparency(run):
    """Error of the reflected torque while the finger slides, caused by the damping in contact; it has no bound."""
    start, end = segment(run, "follow", "press")
    external = _true(run, "CONTACT", "external_torque_nm")[start:end] * force_scale(run)
    error = _felt(run, start, end) - external
    return {"follow_transparency": float(np.sqrt(np.sum(error**2) / np.sum(external**2)))}


def passivity(run):
    """Minimum of the energy that hand and environment have put into the loop, counted from the beginning of each coupling."""
    coupled = np.ones(run.count, bool)
    for words in (run.stick_status["0"], run.joint_tpdo[0]["status"], run.joint_tpdo[1]["status"]):
        coupled &= words & STATE_MASK == OPERATION_ENABLED
    if not coupled.any():
        raise Missing("joystick and arm were never coupled")
    stick, joints = _true(run, "STICK", "position_rad"), _true(run, "JOINTS", "position_rad")
    hand = -_true(run, "STICK", "motor_torque_nm")[1:] * np.diff(stick, axis=0)
    arm = force_scale(run) / position_scale(run) * _true(run, "CONTACT", "external_torque_nm")[1:] * np.diff(joints, axis=0)
    power = np.where(coupled[1:], np.nan_to_num(hand + arm).sum(axis=1), 0.0)
    energy = np.concatenate(([0.0], np.cumsum(power)))
    starts = np.maximum.accumulate(np.where(coupled & ~np.concatenate(([False], coupled[:-1])), np.arange(run.count), 0))
    return {"passivity_local_j": float(np.min((energy - energy[starts])[coupled]))}
