# SPDX-License-Identifier: Apache-2.0
"""Scales, windows of time and gap-free words, for the modules that compute figures."""

import numpy as np

from .run import CYCLE_US

POSITION_SCALE = 2.0  # joint angle per joystick angle
FORCE_SCALE = 0.03  # joystick torque per external joint torque
HOLD_US, SETTLED_US, HOLD_LEAST_US = 10_000_000, 2_000_000, 5_000_000


class Missing(Exception):
    """The logs do not contain the data for a figure."""


def segment(run, verb, before):
    """(first, end) cycle of the first segment `verb` that comes later than a segment of one of `before`."""
    seen = before is None
    for name, first, end in run.segments():
        if name == verb and seen:
            return first, end
        seen = seen or (before is not None and name == before)
    raise Missing(f"the hand never did '{verb}'" + (f" after '{before}'" if before else ""))


def filled(cycles, name, start, end):
    """Words of a PDO in a window, a missing word replaced by the one before; Missing if there are gaps."""
    seen = cycles.seen[start:end]
    if not len(seen) or seen.mean() < 0.999:
        raise Missing(f"PDOs are missing between {start * CYCLE_US / 1e6:.1f} and {end * CYCLE_US / 1e6:.1f} s")
    index = np.maximum.accumulate(np.where(seen, np.arange(len(seen)), 0))
    return cycles[name][start:end][index]
