# SPDX-License-Identifier: Apache-2.0
"""Short scenarios for a kernel with real buses, which may be emulated and then needs about a minute for a second of a flight.

`reports` causes all reports of a controller: during operation the reports after which the controller continues; when all
drives hold, the reports that take it off its bus. `classic` moves the arm of the mission classic in position mode."""

import pathlib

SCENARIOS = {"reports": """
 0.0    hand rest
 0.95   hand circle 0.1 1 0.2 0.4 0.2

 0.1    operator state JOYSTICK PRE_OPERATIONAL
 0.1    operator state MANIPULATOR PRE_OPERATIONAL
 0.2    operator config JOYSTICK TELEPRESENCE
 0.2    operator config MANIPULATOR TELEPRESENCE
 0.3    operator link open HAND_POSITION
 0.3    operator link open ROBOT_STATE
 0.3    operator state JOYSTICK SAFE_OPERATIONAL
 0.3    operator state MANIPULATOR SAFE_OPERATIONAL
 0.3    operator cmd MANIPULATOR.TARE
 0.3    operator wait-event MANIPULATOR TARE_DONE 1
 0.9    operator state JOYSTICK OPERATIONAL
 0.9    operator state MANIPULATOR OPERATIONAL
 1.3    operator state JOYSTICK SAFE_OPERATIONAL
 1.3    operator state MANIPULATOR SAFE_OPERATIONAL
 1.45   operator shutdown

 1.03   fault overflow robot FLIGHT 2
 1.05   fault corruption robot 1
 1.0511 fault corruption robot 0
 1.1    fault arbitration robot FLIGHT on
 1.1    fault delay robot JOINT1 400
 1.12   fault delay robot JOINT1 0
 1.12   fault arbitration robot FLIGHT off
 1.4    fault bus-off robot FLIGHT
 1.4    fault unplug joystick
""", "classic": """
 0.0    hand rest

 0.1    operator state MANIPULATOR PRE_OPERATIONAL
 0.2    operator config MANIPULATOR CLASSIC
 0.2    operator state MANIPULATOR SAFE_OPERATIONAL
 0.2    operator state MANIPULATOR OPERATIONAL
 0.2    operator cmd MANIPULATOR.MOVE_TO POSITION=0.98,-1.5 DURATION=0.5
 0.9    operator state MANIPULATOR SAFE_OPERATIONAL
 0.9    operator shutdown
"""}
# Class of the error frame, and the state of the controller in data[1].
REPORTS = {"robot": {"004#0001", "004#0020", "004#0040", "002#0000", "040#0000", "104#0040"}, "joystick": {"020#0000", "004#0020"}}


def write_scenario(directory, name):
    path = pathlib.Path(directory) / f"{name}.scn"
    path.write_text(SCENARIOS[name])
    return path
