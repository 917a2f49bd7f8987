# SPDX-License-Identifier: Apache-2.0
"""What the page is told about the subsystems."""

import pathlib

from hirosco_gse.dictionary import Dictionary
from hirosco_gse.station import about

ROOT = pathlib.Path(__file__).resolve().parents[5]


def endnodes(mission, subsystem):
    dictionary = Dictionary.load(ROOT / "build" / "generated" / f"{mission}.json")
    item = next(item for item in dictionary.content["subsystems"] if item["name"] == subsystem)
    return about.about(item)["configurations"][0]["endnodes"]


def test_a_device_has_its_buses_or_the_type_of_its_end_node():
    assert endnodes("rokviss", "MANIPULATOR") == {"JOINT1": "robot, robot-b", "JOINT2": "robot, robot-b"}
    found = endnodes("zoo", "INSTRUMENTS")
    assert (found["MIRROR"], found["SHUTTER"], found["ANTENNA"]) == ("SHM", "UDP", "SERIAL")
