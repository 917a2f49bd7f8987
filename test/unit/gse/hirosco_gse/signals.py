# SPDX-License-Identifier: Apache-2.0
"""The part of a run that the figures of a contact read, as signals that a test may change."""

import pathlib

import numpy as np
from hirosco_gse import run as runs
from hirosco_gse import world as worlds

ROOT = pathlib.Path(__file__).resolve().parents[4]
STRETCHED_M = (0.47, 0.25)  # Torque of both joints per newton at the tip of the stretched arm of rokviss.


class Signals:
    """An arm at rest that presses with `pressed` [N] in each cycle; the joystick displays the force without
    error."""

    def __init__(self, scenario, pressed, enabled, segments, dictionary):
        count = len(pressed)
        self.count, self.facts, self.found = count, {"mission": "rokviss", "scenario": scenario}, segments
        self.dictionary, self.reports, self.packets = dictionary, [], []
        self.world = worlds.read(ROOT / "descriptors" / "worlds" / "rokviss.xml")
        force = np.zeros((count, 3))
        force[:, 2] = pressed
        external = np.stack([0.28 * pressed, 0.1 * pressed], axis=1)
        self.truth = {
            ("STICK", "position_rad"): np.zeros((count, 2)),
            ("STICK", "motor_torque_nm"): 0.03 * external,
            ("JOINTS", "position_rad"): np.zeros((count, 2)),
            ("CONTACT", "contact_force_n"): force,
            ("CONTACT", "in_contact"): (pressed > 0).astype(float),
            ("CONTACT", "external_torque_nm"): external,
            ("OPERATOR", "expected_torque_nm"): np.outer(pressed, STRETCHED_M),
        }
        seen = np.ones(count, bool)
        felt = np.round(0.03 * external / 1e-4).astype(int)
        self.stick_rpdo = runs.Cycles(seen, {"0": felt[:, 0], "1": felt[:, 1]})
        self.stick_tpdo = runs.Cycles(seen, {"0": np.round(6.0 * np.arange(count)).astype(int), "1": np.zeros(count, int)})
        self.stick_status = runs.Cycles(seen, {"0": enabled})
        self.joint_tpdo = [runs.Cycles(seen, {"status": enabled}) for _ in range(2)]

    def segments(self):
        return self.found

    def at_cycles(self, channel, name):
        return self.truth.get((channel, name))
