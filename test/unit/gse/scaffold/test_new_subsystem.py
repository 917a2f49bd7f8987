# SPDX-License-Identifier: Apache-2.0
"""Lines that a new subsystem inserts into missions and worlds of any kind."""

import pathlib
import re
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "gse" / "scaffold"))

import new_subsystem

NAMES = {"name": "sled", "NAME": "SLED", "apid": "99", "executable": "sled", "file": "sled", "bus": "sled"}
MISSIONS = sorted(path.stem for path in (ROOT / "descriptors" / "missions").glob("*.xml"))


@pytest.mark.parametrize("mission", MISSIONS)
def test_every_mission_and_world_takes_the_devices(mission):
    path, text, name, is_new = new_subsystem.plan_mission(NAMES, mission)
    assert (name, is_new) == (mission, False)
    (buses,) = re.findall(r"<Buses>.*?</Buses>", text, re.DOTALL)
    assert buses.count('<Bus name="sled" ') == 1
    assert text.count('select="MOVE" to="SLED"') == 1
    world_path, world = new_subsystem.plan_world(NAMES, path, False)
    assert world_path.name == path.name
    assert world.count('<DriveType name="light" ') == 1, "once, whether the world had it or not"
    assert world.index('<DriveType name="light" ') < world.index('<Bench name="SLED_MOTOR" ')
    assert world.count('<Instrument name="SLED_PROBE" ') == 1


def test_a_new_mission_has_the_world_of_the_base_mission_under_its_name():
    path, text, name, is_new = new_subsystem.plan_mission(NAMES, None)
    assert (name, is_new) == ("sled", True)
    assert text.count('<Mission name="sled"') == 1
    _, world = new_subsystem.plan_world(NAMES, path, True)
    assert world.count('<World name="sled"') == 1 and "SLED_MOTOR" in world


def test_a_mission_that_already_has_eight_buses_is_refused():
    _, text, _, _ = new_subsystem.plan_mission(NAMES, "rokviss")
    source = ROOT / "descriptors" / "missions" / "rokviss.xml"
    for number in range(3):
        text = new_subsystem.with_bus(text, NAMES | {"bus": f"bus{number}"}, source)
    assert text.count("<Bus ") == 8
    with pytest.raises(new_subsystem.Refusal, match=r"rokviss\.xml: has 8 buses, expected fewer, .*: name another mission with MISSION="):
        new_subsystem.with_bus(text, NAMES, source)


def test_the_limits_of_a_mission_are_those_of_the_flight_software():
    header = (ROOT / "base" / "capacities.h").read_text(encoding="utf-8")
    capacities = {name: int(number) for name, number in re.findall(r"#define CAPACITY_(\w+) (\d+)U", header)}
    assert (new_subsystem.SUBSYSTEMS_MAX, new_subsystem.BUSES_MAX) == (capacities["SUBSYSTEMS"], capacities["BUSES"])


def test_a_mission_without_a_world_is_refused(tmp_path):
    with pytest.raises(new_subsystem.Refusal, match="expected the world of the mission"):
        new_subsystem.plan_world(NAMES, ROOT / "descriptors" / "missions" / "nowhere.xml", False)


def test_an_error_restores_every_file(tmp_path):
    old, new = tmp_path / "old.xml", tmp_path / "new.xml"
    old.write_text("before", encoding="utf-8")
    bad = tmp_path / "mission.xml"
    with pytest.raises(new_subsystem.Refusal, match="nothing was changed"):
        new_subsystem.write_all({old: "after", new: "made", bad: "<Mission"}, bad)
    assert old.read_text(encoding="utf-8") == "before"
    assert not new.exists() and not bad.exists()

    def check():
        raise new_subsystem.Refusal("arm.urdf:4: mass")

    with pytest.raises(new_subsystem.Refusal, match="^arm.urdf:4: mass; nothing was changed"):
        new_subsystem.write_all({old: "after", bad: "<Mission"}, bad, check)
    assert old.read_text(encoding="utf-8") == "before" and not bad.exists()
