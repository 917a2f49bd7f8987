# SPDX-License-Identifier: Apache-2.0
"""Enumerations, failures, loops and descriptions of a subsystem descriptor: what they give and what is refused."""

import pathlib
import sys
import types

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "generator"))

import common_words
import descriptions
import identifiers
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


@pytest.mark.parametrize("line, name, item, message", [(9, "FOOT", field(), "an <Enumeration> defined above; there are: SIDE"),
                                                     (1, "SIDE", field(), "an <Enumeration> defined above; there are: none"),
                                                     (9, "SIDE", field(min=0), "a field with an enumeration cannot have min or max"),
                                                     (9, "SIDE", field("INT8"), "one whose numbers fit INT8"),
                                                     (9, "SIDE", field("BOOL"), "one whose numbers fit BOOL")])
def test_a_field_that_cannot_have_an_enumeration_is_refused(with_side, line, name, item, message):
    with pytest.raises(DescriptorError, match=f"d.xml:{line}: .*{message}"):
        names.enumerate_field(with_side, Element("d.xml", line, "Field", {"enumeration": name}), item)


def test_a_loop_performs_the_services_that_it_names():
    (element,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5", "services": "17 20"}).children
    assert loop.loop_of(element) == loop.Loop("SLOW", 4000, 5, [17, 20])
    (bare,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5"}).children
    assert loop.loop_of(bare).services == []


@pytest.mark.parametrize("services, message", [("17 8", r"service 8 cannot have a <Loop> of its own: functions act on devices"), ("17 17", "of 17 20"),
                                            ("9", "of 17 20")])
def test_services_that_cannot_have_a_loop_are_refused(services, message):
    (element,) = container({"name": "SLOW", "samplingTime": "4ms", "priority": "5", "services": services}).children
    with pytest.raises(DescriptorError, match=message):
        loop.loop_of(element)


def test_a_service_has_one_loop():
    rows = [{"name": name, "samplingTime": "4ms", "priority": "5", "services": services} for name, services in (("A", "17"), ("B", "20"), ("C", "20 17"))]
    elements = container(*rows).children
    loops = [loop.loop_of(element) for element in elements]
    loop.services_once(elements, loops[:2])
    with pytest.raises(DescriptorError, match='d.xml:4: services="20 17": expected no service of the <Loop> in line 2'):
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


def test_the_line_of_a_subsystem_takes_precedence_over_that_of_all(tmp_path):
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


HEADER = """typedef enum {
    // Kinds.
    WHY_NONE = 0,
    WHY_LATE,      ///< Too late: WHY_NOT, if ever.
    WHY_LOST = 0x10U, ///< Lost.
    WHY_2_BUSY,
    OTHER_WHY_WRONG = 5,
    WHY_COUNT ///< Number of values.
} why_t;
"""


def test_words_are_the_constants_of_a_header():
    assert common_words.constants(HEADER, "WHY_") == {0: "NONE", 1: "LATE", 16: "LOST", 17: "2_BUSY"}


def arm_and_eye():
    """Two subsystems with the same ids; the arm has two configurations."""
    devices = [{"name": "ELBOW", "endnodes": [{"type": "CAN", "node": "0x11"}]}, {"name": "LAMP", "endnodes": [{"type": "TCP"}]}]
    other = [{"name": "WRIST", "endnodes": [{"type": "CAN", "node": "17"}]}]
    parts = [{"name": "A", "id": 1, "devices": devices}, {"name": "B", "id": 2, "devices": other}]
    arm = {"name": "ARM", "events": [{"id": 1, "name": "LOST"}], "parameters": [], "configurations": parts, "identifiers": identifiers.devices(parts)}
    eye = {"name": "EYE", "events": [{"id": 1, "name": "DARK"}, {"id": 2, "name": "LOST"}], "parameters": [{"name": "GAIN", "parameter_id": 9}],
           "configurations": [], "identifiers": identifiers.devices([])}
    return {"subsystems": [arm, eye], "links": [], "users": []}, arm, eye


def test_devices_have_names_by_node_and_by_number():
    _, arm, eye = arm_and_eye()
    assert arm["identifiers"] == {"CANopen node": {0: "CONTROLLER", 17: "ELBOW or WRIST"}, "device": {0: "ELBOW or WRIST", 1: "LAMP"}}
    assert eye["identifiers"] == {"CANopen node": {}, "device": {}}


@pytest.mark.parametrize("kind, others, expected", [
    ("CANopen node", (), ("CANopen_node_ARM", {0: "CONTROLLER", 17: "ELBOW or WRIST"})), ("event id", (), ("event_id_ARM", {1: "LOST"})),
    ("event id", ("APID",), ("event_id_mission", {1: "LOST or DARK", 2: "LOST"})), ("configuration id", (), ("configuration_id_ARM", {1: "A", 2: "B"})),
    ("parameter id", (), ("parameter_id", {9: "EYE.GAIN"})), ("link id", (), None), ("joint", (), None),
])
def test_a_number_that_identifies_something_has_its_names_as_words(kind, others, expected):
    """An event with a value APID is about the subsystem that it names."""
    mission, arm, _ = arm_and_eye()
    item = {"name": "WHICH", "kind": kind}
    made = identifiers.Identifiers(mission, arm).worded(item, {"parameters": [item, "GAIN", *({"name": name} for name in others)]})
    assert made == item | ({"words": {"name": expected[0], "numbers": expected[1]}} if expected else {})
