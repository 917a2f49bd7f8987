# SPDX-License-Identifier: Apache-2.0
"""Figures of a flight whose links have delay: motion and contact in the two holds, reflected torque, largest force, error at
the end, torque of the joystick in free space.
"""

import numpy as np

from . import contact_figures
from .contact_figures import FAST, SLOW, _felt, _mean, _true
from .figures_common import SETTLED_US, Missing, force_scale, position_scale, segment, tip
from .run import CYCLE_US

HOLD_CYCLES = 7_000_000 // CYCLE_US
END_CYCLES = 500_000 // CYCLE_US

# Bounds by the longest round-trip time [ms] for which they are valid.
BOUNDS = {
    100: {
        "delay_hold_oscillation_rad": ("<=", 2e-4),
        "delay_after_follow_rad": ("<=", 2e-4),
        "delay_reflection_error": ("<=", 0.002),
        "delay_contact_share": (">=", 0.99),
        "delay_force_peak_n": ("<=", 25),
        "delay_end_error_m": ("<=", 1.5e-3),
        "delay_free_drag_nm": ("<=", 0.015),
        "passivity_local_j": (">=", -1e-4),
    },
    300: {
        "delay_hold_oscillation_rad": ("<=", 3e-4),
        "delay_after_follow_rad": ("<=", 1e-3),
        "delay_reflection_error": ("<=", 0.005),
        "delay_contact_share": (">=", 0.99),
        "delay_force_peak_n": ("<=", 30),
        "delay_free_drag_nm": ("<=", 0.015),
        "passivity_local_j": (">=", -0.03),
    },
}


def bounds_of(facts):
    """Bounds of a run, selected by its round-trip time. Empty if there is no delay, if there are no bounds for so long a delay, and for a
    network that delays by wall-clock time."""
    relay = facts.get("relay", {})
    delay_ms = None if relay.get("network") else relay.get("round_trip_ms")
    return next((BOUNDS[limit] for limit in sorted(BOUNDS) if delay_ms is not None and delay_ms <= limit), {})


def _hold(run, before):
    """Last 7 s of the hold after a verb; the hold must last at least 9 s."""
    first, end = segment(run, "hold", before)
    if end - first < HOLD_CYCLES + SETTLED_US // CYCLE_US:
        least_s = (HOLD_CYCLES * CYCLE_US + SETTLED_US) / 1e6
        raise Missing(f"the hold after '{before}' is too short: {(end - first) * CYCLE_US / 1e6:.1f} s, expected at least {least_s:g} s")
    return end - HOLD_CYCLES, end


def _oscillation(run, start, end):
    """Largest peak-to-peak motion of a joystick axis relative to its moving mean. Reads SLOW more cycles before `start` and after `end`."""
    stick = _true(run, "STICK", "position_rad")[start - SLOW : end + SLOW]
    return float(np.ptp((stick - _mean(stick, SLOW))[SLOW : SLOW + end - start], axis=0).max())


def held(run, start, end):
    """Figures of a hold in these cycles: oscillation of the joystick, error of the reflected torque, share of contact."""
    external = _true(run, "CONTACT", "external_torque_nm")[start:end].mean(axis=0) * force_scale(run)
    error = _felt(run, start, end).mean(axis=0) - external
    return {
        "delay_hold_oscillation_rad": _oscillation(run, start, end),
        "delay_reflection_error": float(np.linalg.norm(error) / np.linalg.norm(external)),
        "delay_contact_share": float((_true(run, "CONTACT", "in_contact")[start:end] > 0).mean()),
    }


def force_peak(run, first, end):
    """Largest contact force in these cycles [N]."""
    return float(np.nanmax(np.linalg.norm(_true(run, "CONTACT", "contact_force_n")[first:end], axis=1)))


def holds(run):
    """Figures of both holds: oscillation of the joystick, share of contact, error of the reflected torque, largest force."""
    (start, end), (after, last) = _hold(run, "press"), _hold(run, "follow")
    press, _ = segment(run, "press", None)
    found = held(run, start, end)
    touched = _true(run, "CONTACT", "in_contact")[after:last] > 0
    return found | {
        "delay_after_follow_rad": _oscillation(run, after, last - SLOW - FAST),
        "delay_contact_share": min(found["delay_contact_share"], float(touched.mean())),
        "delay_force_peak_n": force_peak(run, press, last),
    }


def end_error(run):
    """Distance at the end between the tip and its commanded position, which is the scaled motion of the joystick since the first move."""
    first, _ = segment(run, "move", None)
    end = max((end for verb, _, end in run.segments() if verb == "home"), default=None)
    if end is None:
        raise Missing("the hand never did 'home'")
    stick, joints = _true(run, "STICK", "position_rad"), _true(run, "JOINTS", "position_rad")
    late = slice(end, end + END_CYCLES)
    asked = joints[first] + position_scale(run) * (stick[late].mean(axis=0) - stick[first])
    return {"delay_end_error_m": float(np.linalg.norm(tip(run, joints[late].mean(axis=0)) - tip(run, asked)))}


def free_drag(run):
    """Rms of the torque that the hand has to overcome in the circle without its first and last 2 s; the larger value of both axes."""
    first, end = segment(run, "circle", None)
    window = slice(first + SETTLED_US // CYCLE_US, end - SETTLED_US // CYCLE_US)
    torque = _felt(run, window.start, window.stop)
    return {"delay_free_drag_nm": float(np.sqrt(np.mean(torque**2, axis=0)).max())}


FIGURES = (
    (
        holds,
        (
            "delay_hold_oscillation_rad",
            "delay_after_follow_rad",
            "delay_reflection_error",
            "delay_contact_share",
            "delay_force_peak_n",
        ),
    ),
    (end_error, ("delay_end_error_m",)),
    (free_drag, ("delay_free_drag_nm",)),
    (contact_figures.passivity, ("passivity_local_j",)),
)
