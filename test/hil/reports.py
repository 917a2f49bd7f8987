# SPDX-License-Identifier: Apache-2.0
"""The scenario hil with all reports of a controller: during operation the reports after which the controller
continues; when all drives hold, the reports that take it off its bus."""

import pathlib

HIL = pathlib.Path(__file__).resolve().parents[2] / "sim" / "scenarios" / "hil.scn"
FAULTS = """
 1.3    fault overflow robot FLIGHT 2
 1.4    fault corruption robot 1
 1.4011 fault corruption robot 0
 1.5    fault arbitration robot FLIGHT on
 1.5    fault delay robot JOINT1 400
 1.52   fault delay robot JOINT1 0
 1.52   fault arbitration robot FLIGHT off
 2.35   fault bus-off robot FLIGHT
 2.35   fault unplug joystick
"""
# Class of the error frame, and the state of the controller in data[1].
REPORTS = {"robot": {"004#0001", "004#0020", "004#0040", "002#0000", "040#0000", "104#0040"}, "joystick": {"020#0000", "004#0020"}}


def write_scenario(folder):
    path = pathlib.Path(folder) / "reports.scn"
    path.write_text(HIL.read_text() + FAULTS)
    return path
