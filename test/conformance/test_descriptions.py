# SPDX-License-Identifier: Apache-2.0
"""Each parameter of each mission has a description, and a unit or names for its numbers, in the dictionary
and in the XTCE database; each message has a name."""

import json
import pathlib
import re
import shutil
import sys
import xml.etree.ElementTree as ET

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPACE = "{http://www.omg.org/spec/XTCE/20180204}"
MISSIONS = [path.stem for path in sorted((ROOT / "descriptors" / "missions").glob("*.xml"))]
sys.path.insert(0, str(ROOT / "gse" / "generator"))

import catalogue
import descriptions
from source import DescriptorError


def _leaves(mission):
    content = json.loads((ROOT / "build" / "generated" / f"{mission}.json").read_text(encoding="utf-8"))
    for subsystem in content["subsystems"]:
        for parameter in subsystem["parameters"]:
            for leaf in parameter.get("fields", [parameter]):
                yield f"{subsystem['name']}.{parameter['name']}.{leaf['name']}", leaf


@pytest.mark.parametrize("mission", MISSIONS)
def test_each_parameter_has_a_description_and_a_unit_or_names(mission):
    leaves = dict(_leaves(mission))
    meant = ("quantity", "kind", "words", "bits", "enumeration")
    bare = [name for name, leaf in leaves.items() if leaf["type"] != "BOOL" and not leaf["unit"] and not any(key in leaf for key in meant)]
    assert len(leaves) > 60 and not bare, bare
    assert not [name for name, leaf in leaves.items() if not leaf.get("description")]
    assert sum("warning" in leaf for leaf in leaves.values()) > 15


@pytest.mark.parametrize("mission", MISSIONS)
def test_each_event_and_function_has_a_description_and_its_values_a_unit_or_names(mission):
    content = json.loads((ROOT / "build" / "generated" / f"{mission}.json").read_text(encoding="utf-8"))
    for subsystem in content["subsystems"]:
        for kind, members in (("events", "parameters"), ("functions", "arguments")):
            for one in subsystem[kind]:
                assert one["description"], (subsystem["name"], one["name"])
                for value in one[members]:
                    if isinstance(value, dict):  # Otherwise the name of a parameter.
                        assert value["description"] and (value["unit"] or {"quantity", "kind", "words", "enumeration"} & value.keys()), (one["name"], value)
                        assert value.get("kind", "") not in ("code", "flag", "type", "status", "reason", "cause"), f"{one['name']} has no names for the numbers of {value}"


class _Types:
    """Types of a database by path, and all parameters and arguments that have them."""

    def __init__(self, tree):
        self.types, self.items = {}, []
        self._collect(tree, "")

    def _collect(self, system, above):
        path = f"{above}/{system.get('name')}"
        for what, part in (("Parameter", "TelemetryMetaData"), ("Argument", "CommandMetaData")):
            for kind in system.findall(f"{SPACE}{part}/{SPACE}{what}TypeSet/*"):
                self.types[what, f"{path}/{kind.get('name')}"] = kind
        for one in system.findall(f"{SPACE}TelemetryMetaData/{SPACE}ParameterSet/{SPACE}Parameter"):
            self.items.append(("Parameter", f"{path}/{one.get('name')}", one))
        for command in system.findall(f"{SPACE}CommandMetaData/{SPACE}MetaCommandSet/{SPACE}MetaCommand"):
            for one in command.findall(f"{SPACE}ArgumentList/{SPACE}Argument"):
                self.items.append(("Argument", f"{path}/{command.get('name')}.{one.get('name')}", one))
        for child in system.findall(f"{SPACE}SpaceSystem"):
            self._collect(child, path)

    def bare(self, what, reference, name):
        """Texts about the numbers of a type that have no unit, and about its members that have no description."""
        kind = self.types[what, reference]
        form = kind.tag.removeprefix(SPACE).removesuffix("Type").removesuffix(what)
        if form == "Array":
            return self.bare(what, kind.get("arrayTypeRef"), name)
        if form == "Aggregate":
            members = [(one, f"{name}.{one.get('name')}") for one in kind.iter(f"{SPACE}Member")]
            inside = [found for one, path in members for found in self.bare(what, one.get("typeRef"), path)]
            return inside + [f"{path} is not described" for one, path in members if not one.get("shortDescription")]
        has_words = form in ("Enumerated", "Boolean", "String", "Binary", "AbsoluteTime")
        return [] if has_words or kind.find(f"{SPACE}UnitSet/{SPACE}Unit") is not None else [f"{name} has no unit"]


@pytest.mark.parametrize("mission", MISSIONS)
def test_each_parameter_and_argument_of_the_database_has_a_description_and_a_unit_or_names(mission):
    known = _Types(ET.parse(ROOT / "build" / "generated" / f"{mission}.xtce.xml").getroot())
    wrong = []
    for what, name, one in known.items:
        wrong += known.bare(what, one.get(f"{what.lower()}TypeRef"), name) + ([] if one.get("shortDescription") else [f"{name} is not described"])
    assert len(known.items) > 1500 and not wrong, wrong[:20]


@pytest.mark.parametrize("mission", MISSIONS)
def test_the_database_describes_each_parameter_of_housekeeping(mission):
    tree = ET.parse(ROOT / "build" / "generated" / f"{mission}.xtce.xml").getroot()
    assert not [one.get("name") for one in tree.iter(f"{SPACE}Parameter") if not one.get("shortDescription")]
    described, alarms = {}, 0
    for system in tree.findall(f"{SPACE}SpaceSystem"):
        for one in system.findall(f"{SPACE}TelemetryMetaData/{SPACE}ParameterSet/{SPACE}Parameter"):
            described[f"/{tree.get('name')}/{system.get('name')}/{one.get('name')}"] = one.get("shortDescription")
        alarms += len(system.findall(f"{SPACE}TelemetryMetaData/{SPACE}ParameterTypeSet/*/{SPACE}DefaultAlarm"))
    entered = {
        entry.get("parameterRef") for container in tree.iter(f"{SPACE}SequenceContainer") if container.get("name").startswith("HK_")
        for entry in container.iter(f"{SPACE}ParameterRefEntry") if "/ST03/" not in entry.get("parameterRef")
    }
    assert len(entered) > 30 and not [path for path in entered if "_samples_" not in path and not described[path]]
    assert alarms > 15


def test_each_request_and_report_has_a_name_and_its_type_as_alias():
    tree = ET.parse(ROOT / "build" / "generated" / "rokviss.xtce.xml").getroot()
    aliases = {}
    for tag in ("MetaCommand", "SequenceContainer"):
        for one in tree.iter(f"{SPACE}{tag}"):
            for alias in one.iter(f"{SPACE}Alias"):
                aliases.setdefault(alias.get("alias"), set()).add(one.get("name"))
    assert aliases["TC[15,24]"] and all(name.startswith("STORAGE_COPY_PACKETS_") for name in aliases["TC[15,24]"])
    assert aliases["TM[131,9]"] == {"SUBSYSTEMS"} and aliases["TC[129,1]"] == {"STATE_REQUEST", "REQUEST_STATE"}
    known, services = catalogue.load(ROOT / "pus" / "catalogue")
    private_kinds, private = catalogue.private(ROOT / "pus" / "catalogue")
    assert set(known) < set(private_kinds)
    messages = [one for service in (services | private).values() for one in service["messages"]]
    for one in messages:
        assert f"{one.direction}[{one.service},{one.subtype}]" in aliases
    assert len({one.identifier for one in messages}) == len(messages) > 340


@pytest.mark.parametrize("line", ["CUR_VALUES.STATE | =state", "A | 1 | a | much", "A | 1 | a\nA | 1 | b"])
def test_a_line_of_descriptions_that_cannot_be_read_is_refused(line, tmp_path):
    path = tmp_path / "descriptions.txt"
    path.write_text(line + "\n", encoding="utf-8")
    with pytest.raises(DescriptorError, match=r"descriptions.txt:\d: .*expected a new"):
        descriptions.load(path)


@pytest.mark.parametrize("line, wrong", [
    ("129,1 STATE_REQUEST critical unless goal OFFLINE", "the first field of STATE_REQUEST"),
    ("129,1 STATE_REQUEST critical unless target AWAY", "words of target"),
    ("129,1 STATE_REQUEST critical unless", "a new message and a new name"),
])
def test_words_that_make_a_request_harmless_are_those_of_its_first_field(line, wrong, tmp_path):
    directory = tmp_path / "catalogue"
    shutil.copytree(ROOT / "pus" / "catalogue", directory)
    names = directory / "names.txt"
    names.write_text(re.sub(r"129,1 .*", line, names.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(DescriptorError, match=wrong):
        catalogue.private(directory)


def test_emergency_codes_have_the_names_of_the_standards_and_of_the_data_sheets(tmp_path):
    header = (ROOT / "fsw/canopen/network.h").read_text(encoding="utf-8")
    found = re.findall(r"  NETWORK_BUS_(\w+) += (?:FLOW_CAN_\w+|\d),?", header)
    assert [name.removeprefix("BUS_") for name in descriptions.BUS_CONDITIONS] == found
    defined = {int(code, 16) for code in re.findall(r"\{(0x\w+)U, EMERGENCY_", (ROOT / "fsw/canopen/emergency.c").read_text(encoding="utf-8"))}
    assert len(defined) > 10 and defined <= set(descriptions.EMERGENCIES)
    content = json.loads((ROOT / "build" / "generated" / "rokviss.json").read_text(encoding="utf-8"))
    events = {event["name"]: event for one in content["subsystems"] if one["name"] == "MANIPULATOR" for event in one["events"]}
    codes = {name: events[name]["parameters"][1]["words"]["numbers"] for name in ("DRIVE_FAULT", "BUS_WARNING")}
    assert (codes["DRIVE_FAULT"]["65281"], codes["DRIVE_FAULT"]["29445"]) == ("TORQUE_SENSOR", "POSITION_SENSOR")
    assert codes["BUS_WARNING"][str(0x100 + 3)] == "BUS_OFF_ON_CHANNEL_B" and "259" not in codes["DRIVE_FAULT"]
    ends = [{"endnodes": [{"bus": name}]} for name in ("one", "two")]
    assert descriptions.bus_conditions({"configurations": [{"devices": ends[:1]}, {"devices": ends}]})[0x1000 + 3] == "BUS_OFF_OF_BUS_2"
    for name, text in (("a", "Torque sensor"), ("b", "Lamp, left"), ("c", "Torque sensor")):
        (tmp_path / f"{name}.eds").write_text(f"[Comments]\nLines=1\nLine1=EMCY 0xFF01 HIGH {text}\n", encoding="utf-8")

    def named(*types):
        return descriptions.emergencies({"configurations": [{"devices": [{"type": one} for one in types]}]}, tmp_path)

    assert named("a", "c")[0xFF01] == "TORQUE_SENSOR" and named("a", "b", "stream")[0xFF01] == "TORQUE_SENSOR_OR_LAMP_LEFT"
    assert named("stream") == descriptions.EMERGENCIES


def test_critical_functions_and_requests_are_critical_in_the_database():
    tree = ET.parse(ROOT / "build" / "generated" / "rokviss.xtce.xml").getroot()
    critical = {one.get("name") for one in tree.iter(f"{SPACE}MetaCommand") if one.find(f"{SPACE}DefaultSignificance") is not None}
    assert {"CHANNEL", "RAISE", "FILE_DELETE", "MONITORING_DISABLE_DEFINITIONS", "REQUEST_STATE", "RELOAD"} <= critical
    assert not {"STOP", "MOVE_TO", "PING", "PROCESS_START"} & critical
