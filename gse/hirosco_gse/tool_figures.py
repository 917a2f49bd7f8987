# SPDX-License-Identifier: Apache-2.0
"""Figures of a flight in which a joystick leads the tool of an arm: motion of the tool, and torques on the hand."""

import numpy as np

from .figures_common import Missing, force_scale, segment, setting
from .run import CYCLE_US

RAMP_US, STILL_US = 2_000_000, 4_000_000  # Time at both ends of the circle, and of the hold, for the figures.
LAGS = range(0, 400, 4)  # Lags that are tried [cycles].
OPERATIONAL, NO_HAND = 5, 1

BOUNDS = {
    "tool_tracking_error": ("<=", 0.15),
    "tool_tracking_lag_s": ("<=", 0.08),
    "tool_force_free_n": ("<=", 0.5),
    "tool_force_error": ("<=", 0.02),
    "tool_reflection_error": ("<=", 0.02),
    "tool_hold_motion_rad": ("<=", 0.001),
    "tool_hold_ripple_n": ("<=", 0.1),
    "tool_contact_share": (">=", 1.0),
    "tool_force_peak_n": ("<=", 20),
    "tool_drag_nm": ("<=", 0.02),
    "tool_left_alone_m": ("<=", 1e-4),
}


def _truth(run, channel, name):
    column = run.at_cycles(channel, name)
    if column is None:
        raise Missing(f"the truth log has no channel {channel}")
    return column


def _led(run, field):
    """Field of TELEPRESENCE of the arm whose tool the joystick leads. If several arms have this parameter, it is the arm that reports HAND."""
    arms = {item.apid: item.name for item in run.dictionary.subsystems.values() if "TELEPRESENCE" in item.parameters} if run.dictionary else {}
    if not arms:
        raise Missing("no subsystem with the parameter TELEPRESENCE")
    led = {packet.apid for _, packet, decoded in run.reports_of("housekeeping") if packet.apid in arms and "HAND" in decoded["values"]} or set(arms)
    if len(led) != 1:
        raise Missing(f"{len(led)} arms that a joystick may have led ({', '.join(arms[apid] for apid in sorted(led))}), expected one")
    return setting(run, arms[min(led)], "TELEPRESENCE", field)


def _along(run, vectors):
    """Components of vectors along the directions that the joystick leads."""
    return vectors @ _led(run, "DIRECTIONS").reshape(-1, 3).T


def _values(run):
    """Cycle, CUR_VALUES and HAND of each report that has both."""
    found = [(time_ns // 1000 // CYCLE_US, decoded["values"]) for time_ns, _, decoded in run.reports_of("housekeeping")]
    found = [(cycle, values["CUR_VALUES"], values["HAND"]) for cycle, values in found if "HAND" in values]
    if not found:
        raise Missing("no housekeeping with HAND")
    return found


def _forces(run, first, end):
    """Force on the tool, as the arm reports it, in a window."""
    forces = [np.ravel(values["TOOL_FORCE"]) for cycle, values, _ in _values(run) if first <= cycle < end]
    if not forces:
        raise Missing("no housekeeping in the window")
    return np.array(forces)


def _circle(run):
    first, end = segment(run, "circle", None)
    return first + RAMP_US // CYCLE_US, end - RAMP_US // CYCLE_US


def tracking(run):
    """Difference between the true motion of the tool and the scaled motion of the joystick in free space, at the lag that fits best."""
    first, end = _circle(run)
    tool = _along(run, _truth(run, "CONTACT", "tip_m"))
    stick = _truth(run, "STICK", "position_rad") * _led(run, "POSITION_SCALE")
    moved = tool[first:end] - tool[first:end].mean(axis=0)
    errors = {}
    for lag in LAGS:
        wanted = stick[first - lag : end - lag]
        wanted = wanted - wanted.mean(axis=0)
        errors[lag] = float(np.sqrt(np.mean((moved - wanted) ** 2) / np.mean(wanted**2)))
    lag = min(errors, key=errors.get)
    return {"tool_tracking_error": errors[lag], "tool_tracking_lag_s": lag * CYCLE_US / 1e6}


def free(run):
    """Force that the arm reports in free space, where there is none, and torque that the hand has to apply there."""
    first, end = _circle(run)
    torque = _truth(run, "STICK", "motor_torque_nm")[first:end]
    return {
        "tool_force_free_n": float(np.sqrt(np.mean(np.sum(_forces(run, first, end) ** 2, axis=1)))),
        "tool_drag_nm": float(np.sqrt(np.mean(torque**2, axis=0)).max()),
    }


def pressing(run):
    """Figures of the last 4 s in which the hand holds the tool on the table."""
    press, _ = segment(run, "aim", "circle")
    _, end = segment(run, "hold", "aim")
    first = end - STILL_US // CYCLE_US
    force = _truth(run, "CONTACT", "contact_force_n")
    held = force[first:end]
    true = held.mean(axis=0)
    felt = _truth(run, "STICK", "motor_torque_nm")[first:end].mean(axis=0)
    asked = force_scale(run) * _led(run, "FORCE_SCALE") * _along(run, true)
    stick = _truth(run, "STICK", "position_rad")[first:end]
    return {
        "tool_force_n": float(np.linalg.norm(true)),
        "tool_force_error": float(np.linalg.norm(_forces(run, first, end).mean(axis=0) - true) / np.linalg.norm(true)),
        "tool_reflection_error": float(np.linalg.norm(felt - asked) / np.linalg.norm(asked)),
        "tool_hold_motion_rad": float(np.ptp(stick, axis=0).max()),
        "tool_hold_ripple_n": float(np.ptp(np.linalg.norm(held, axis=1))),
        "tool_contact_share": float(np.mean(_truth(run, "CONTACT", "in_contact")[first:end] > 0)),
        "tool_force_peak_n": float(np.nanmax(np.linalg.norm(force[press:end], axis=1))),
    }


def left_alone(run):
    """True motion of the tool while the arm is in operation without the hand, beginning 0.5 s after the loss of the hand."""
    cycles = [cycle for cycle, values, hand in _values(run) if np.ravel(values["STATE"])[0] == OPERATIONAL and np.ravel(hand["STATE"])[0] == NO_HAND]
    if len(cycles) < 2:
        raise Missing("the arm was never in operation without a hand")
    tool = _truth(run, "CONTACT", "tip_m")[cycles[0] + 1000 : cycles[-1]]
    return {"tool_left_alone_m": float(np.ptp(tool, axis=0).max())}


FIGURES = (
    (tracking, ("tool_tracking_error", "tool_tracking_lag_s")),
    (free, ("tool_force_free_n", "tool_drag_nm")),
    (
        pressing,
        (
            "tool_force_error",
            "tool_reflection_error",
            "tool_hold_motion_rad",
            "tool_hold_ripple_n",
            "tool_contact_share",
            "tool_force_peak_n",
        ),
    ),
    (left_alone, ("tool_left_alone_m",)),
)
