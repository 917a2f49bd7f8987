# SPDX-License-Identifier: Apache-2.0
"""Enumerations, failures, loops and descriptions of a subsystem descriptor: what they give and what is refused."""

import pathlib
import sys
import types

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "generator"))

import descriptions
import loop
import names
from source import DescriptorError, Element


def container(*rows):
    top = Element("d.xml", 1, "Top", {})
    top.children = [Element("d.xml", line, "Item", attributes) for line, attributes in enumerate(rows, 2)]
    return top


def subsystem():
    return types.SimpleNamespace(enumerations=[], failures=[])


def test_names_are_numbered_from_the_first():
    found = subsystem()
    names.enumerations(found, container({"name": "MODE", "values": "OFF ON"}, {"name": "SIDE", "first": "3", "values": "LEFT RIGHT UP"}))
    assert [each.numbers for each in found.enumerations] == [{"OFF": 0, "ON": 1}, {"LEFT": 3, "RIGHT": 4, "UP": 5}]


@pytest.mark.parametrize("values", ["OFF OFF", "OFF on", "OFF  ON", "", "OFF " + "X" * 33])
def test_an_enumeration_with_invalid_names_is_refused(values):
    with pytest.raises(DescriptorError, match=r"d.xml:2: values=.* of <Item>: expected different upper-case identifiers"):
        names.enumerations(subsystem(), container({"name": "MODE", "values": values}))


def test_there_are_at_most_sixteen_enumerations():
    rows = [{"name": f"E{number}", "values": "A"} for number in range(17)]
    names.enumerations(subsystem(), container(*rows[:16]))
    with pytest.raises(DescriptorError, match="d.xml:18: too many enumerations, at most 16"):
        names.enumerations(subsystem(), container(*rows))


def test_failures_have_codes_of_their_own():
    found = subsystem()
    names.failures(found, container({"name": "JAM", "id": "1"}, {"name": "HOT", "id": "0x7FFF", "detail": "AXIS"}))
    assert [(each.name, each.code, each.detail) for each in found.failures] == [("JAM", 0x8001, ""), ("HOT", 0xFFFF, "AXIS")]
    with pytest.raises(DescriptorError, match="a number from 1 to 32767"):
        names.failures(subsystem(), container({"name": "JAM", "id": "0x8000"}))
    with pytest.raises(DescriptorError, match="is taken in line 2"):
        names.failures(subsystem(), container({"name": "JAM", "id": "1"}, {"name": "HOT", "id": "1"}))
    many = [{"name": f"F{number}", "id": str(number + 1)} for number in range(33)]
    with pytest.raises(DescriptorError, match="d.xml:34: too many failures, at most 32"):
        names.failures(subsystem(), container(*many))


def field(kind="UINT8", **bounds):
    return types.SimpleNamespace(type=kind, **{"min": None, "max": None, "enumeration": None, **bounds})


@pytest.fixture
def with_side():
    found = subsystem()
    names.enumerations(found, container({"name": "SIDE", "first": "254", "values": "LEFT RIGHT"}))
    return found


def test_a_field_has_the_bounds_of_its_enumeration(with_side):
    item = field()
    names.enumerate_field(with_side, Element("d.xml", 9, "Field", {"enumeration": "SIDE"}), item)
    assert (item.min, item.max, item.enumeration.name) == (254, 255, "SIDE")
    untouched = field()
    names.enumerate_field(with_side, Element("d.xml", 9, "Field", {}), untouched)
    assert untouched.enumeration is None


@pytest.mark.parametrize("line, name, item, says", [(9, "FOOT", field(), "an <Enumeration> defined above; there are: SIDE"),
                                                     (1, "SIDE", field(), "an <Enumeration> defined above; there are: none"),
                                                     (9, "SIDE", field(min=0), "with an enumeration there is no min and no max"),
                                                     (9, "SIDE", field("INT8"), "one whose numbers fit INT8"),
                                                     (9, "SIDE", field("BOOL"), "one whose numbers fit BOOL")])
def test_a_field_that_cannot_have_an_enumeration_is_refused(with_side, line, name, item, says):
    with pytest.raises(DescriptorError, match=f"d.xml:{line}: .*{says}"):
        names.enumerate_field(with_side, Element("d.xml", line, "Field", {"enumeration": name}), item)


def test_a_loop_performs_the_services_that_it_names():
    (element,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5", "services": "17 20"}).children
    assert loop.loop_of(element) == loop.Loop("SLOW", 4000, 5, [17, 20])
    (bare,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5"}).children
    assert loop.loop_of(bare).services == []


@pytest.mark.parametrize("services, says", [("17 8", r"service 8 cannot have a <Loop> of its own: functions act on devices"), ("17 17", "of 17 20"),
                                            ("9", "of 17 20")])
def test_services_that_cannot_have_a_loop_are_refused(services, says):
    (element,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5", "services": services}).children
    with pytest.raises(DescriptorError, match=says):
        loop.loop_of(element)


def test_a_service_has_one_loop():
    rows = [{"name": name, "samplingTime": "4ms", "priority": "5", "services": services} for name, services in (("A", "17"), ("B", "20"), ("C", "20 17"))]
    elements = container(*rows).children
    loops = [loop.loop_of(element) for element in elements]
    loop.services_once(elements, loops[:2])
    with pytest.raises(DescriptorError, match="d.xml:4: services 20 17 is taken in line 2"):
        loop.services_once(elements, loops)


def dictionary():
    leaf = {"name": "TORQUE", "unit": "Nm"}
    return {"modes": [{"id": 3, "name": "FLY"}],
            "subsystems": [{"name": "ARM", "apid": 16, "configurations": [], "events": [{"name": "HOT", "parameters": [{"name": "AXIS"}]}],
                            "functions": [{"name": "MOVE", "arguments": [{"name": "TIME"}]}],
                            "parameters": [{"name": "STATE"}, {"name": "MODE"}, {"name": "JOINTS", "fields": [leaf, {"name": "COUNT"}]}]}]}


def described(tmp_path, *lines):
    path = tmp_path / "descriptions.txt"
    path.write_text("# comment\n\n" + "".join(f"{line}\n" for line in lines), encoding="utf-8")
    return descriptions.describe(dictionary(), descriptions.load(path))["subsystems"][0]


def test_the_line_of_a_subsystem_goes_before_that_of_all(tmp_path):
    arm = described(tmp_path, "STATE | =state | any", "ARM.STATE | =state | that of the arm", "MODE | =mode | the mode")
    assert arm["parameters"][0]["description"] == "that of the arm"
    assert arm["parameters"][0]["words"]["numbers"][5] == "OPERATIONAL" and arm["parameters"][0]["words"]["name"] == "state"
    assert arm["parameters"][1]["words"] == {"name": "mode", "numbers": {3: "FLY"}}


def test_a_field_has_description_quantity_and_warning(tmp_path):
    arm = described(tmp_path, "JOINTS.TORQUE | torque | of each joint | 12.5", "JOINTS.COUNT | #packets | so many")
    torque, count = arm["parameters"][2]["fields"]
    assert (torque["description"], torque["warning"]) == ("of each joint", 12.5) and "quantity" not in torque  # It has a unit.
    assert (count["description"], count["kind"]) == ("so many", "packets") and "warning" not in count


def test_events_functions_and_their_values_have_descriptions(tmp_path):
    arm = described(tmp_path, "event HOT | - | too hot", "event ARM.HOT.AXIS | - | which one", "function *.TIME | - | how long")
    assert (arm["events"][0]["description"], arm["events"][0]["parameters"][0]["description"]) == ("too hot", "which one")
    assert arm["functions"][0]["description"] == "" and arm["functions"][0]["arguments"][0]["description"] == "how long"


@pytest.mark.parametrize("lines", [["STATE | state"], ["state | - | x"], ["STATE | - | a", "STATE | - | b"], ["STATE | - | a | high"]])
def test_a_line_that_cannot_be_read_is_refused(tmp_path, lines):
    with pytest.raises(DescriptorError, match=rf"descriptions.txt:{len(lines) + 2}: .*: expected a new `NAME"):
        described(tmp_path, *lines)
