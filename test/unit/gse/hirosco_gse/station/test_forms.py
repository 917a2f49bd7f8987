# SPDX-License-Identifier: Apache-2.0
"""Forms of the light station: every entry of the dictionaries of four missions has a form, and a form sends the same
octets as the command line."""

import json
import re
import shlex

import pytest
from conftest import ROOT
from hirosco_gse import commands, critical, packets
from hirosco_gse.command import Command, UsageError
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.session import Request
from hirosco_gse.station import interfaces
from hirosco_gse.station.forms import Forms

PING = packets.build_tc(1, 7, 17, 1).hex()
TYPED = {"f64": "1.5", "time": "12.25", "reltime": "0.5", "cds": "3", "position": "0.25", "name": "12", "text": "12", "packet": PING, "rest": "12", "id": str(16 << 21 | 2 << 16 | 900)}


@pytest.fixture(scope="module", params=["rokviss", "classic", "zoo", "ur5e"])
def mission(request):
    return Dictionary.load(ROOT / "build" / "generated" / f"{request.param}.json")


def entries(dictionary):
    """Ids of the forms that a dictionary must have."""
    for item in dictionary.content["subsystems"]:
        name = item["name"]
        yield from (f"cmd {name}.{one['name']}" for one in item["functions"])
        yield from (f"set {name}.{one['name']}" for one in item["parameters"] if one["settable"])
        yield from (f"get {name}.{one['name']}" for one in item["parameters"])
        yield f"config {name}"
    yield from (f"state {item.name}" for item in dictionary.members)
    yield from (f"link {verb} {link.name}" for link in dictionary.links for verb in ("open", "close"))
    flown = {service for item in dictionary.content["subsystems"] for service in item["services"]}
    yield from (f"tc {entry['service']},{entry['subtype']}" for entry in dictionary.catalogue.all("TC") if entry["service"] in flown)
    yield "mode"


def test_every_verb_of_hand_and_fault_has_a_form(mission):
    """The verbs are those of the documentation, which another test compares with the simulator."""
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    forms = Forms(mission).by_id
    for actor in ("fault", "hand"):
        table = text.split(f"## `{actor}`")[1].split("\n## ")[0]
        verbs = set(re.findall(r"`(\S+?)`", " ".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)).replace(",", "")))
        assert verbs and {f"{actor} {verb}" for verb in verbs} == {name for name in forms if name.startswith(f"{actor} ")}
        assert all(forms[name].kind == "simulated world" for name in forms if name.startswith(f"{actor} "))


@pytest.mark.parametrize(("form", "values", "line"), [
    ("fault unplug", {"bus or instrument": "robot", "device": "JOINT1"}, "fault unplug robot JOINT1"),
    ("fault unplug", {"bus or instrument": "robot", "device": ""}, "fault unplug robot"),
    ("fault restart", {"bus": "robot", "device": "0x11", "auto or order or now": "order"}, "fault restart robot 0x11 order"),
    ("fault silent", {"instrument": "FORCE", "on or off": "on"}, "fault silent FORCE on"),
    ("fault kill", {"process": "joystick"}, "fault kill joystick"),
    ("hand rest", {}, "hand rest"),
    ("hand aim", {"radians 1": "0.1", "radians 2": "-0.2", "seconds": "1"}, "hand aim 0.1 -0.2 1"),
])
def test_values_of_a_form_become_a_line_of_the_live_port(form, values, line):
    forms = Forms(Dictionary.load(ROOT / "build" / "generated" / "rokviss.json"))
    assert forms.text(form, values) == line


@pytest.mark.parametrize(("values", "message"), [({"bus": "robot"}, "probability is missing"), ({"bus": "robot 1", "probability": "1"}, "bus: found 'robot 1', expected one word")])
def test_a_line_with_a_missing_or_invalid_value_is_refused(values, message):
    forms = Forms(Dictionary.load(ROOT / "build" / "generated" / "rokviss.json"))
    with pytest.raises(UsageError, match=message):
        forms.text("fault loss", values)


def test_every_entry_of_the_dictionary_has_a_form(mission):
    assert set(entries(mission)) - set(Forms(mission).by_id) == set()
    json.dumps(Forms(mission).message())


@pytest.mark.parametrize(("form", "subsystems"), [
    ("cmd MANIPULATOR.TARE", ("MANIPULATOR",)), ("config JOYSTICK", ("JOYSTICK",)), ("get MANIPULATOR.LINK_AGE", ("MANIPULATOR",)),
    ("link open HAND_POSITION", ("JOYSTICK", "MANIPULATOR")), ("link close HAND_POSITION", ()), ("state MANIPULATOR", ()), ("ping MANIPULATOR", ()), ("mode", ()),
])
def test_a_form_names_the_subsystems_whose_interface_it_uses(form, subsystems):
    """The page disables the form if one of them flies another interface. Requests that are the same for every interface are always possible."""
    forms = Forms(Dictionary.load(ROOT / "build" / "generated" / "rokviss.json")).by_id
    assert forms[form].message()["subsystems"] == subsystems


@pytest.mark.parametrize(("text", "subsystems"), [
    ("cmd MANIPULATOR.TARE", ["MANIPULATOR"]), ("state MANIPULATOR OFFLINE", []), ("ping all", []), ("tc MANIPULATOR 5,7", ["MANIPULATOR"]),
    ("at 5 1.1 cmd MANIPULATOR.TARE", ["SUPERVISOR", "MANIPULATOR"]), ("at 5 1.1 ping MANIPULATOR", ["SUPERVISOR"]),
    ("at +5 cmd MANIPULATOR.TARE", ["SUPERVISOR", "MANIPULATOR"]), ("set MANIPULATOR.CONTROL.FADE_TIME 1", ["MANIPULATOR"]),
    ("link open HAND_POSITION", ["SUPERVISOR", "JOYSTICK", "MANIPULATOR"]), ("link close HAND_POSITION", []), ("process start MANIPULATOR", []), ("stop", []),
])
def test_a_command_names_the_subsystems_whose_interface_it_uses(text, subsystems):
    dictionary = Dictionary.load(ROOT / "build" / "generated" / "rokviss.json")
    assert interfaces.subsystems_of(commands.plan(shlex.split(text), dictionary), dictionary) == subsystems


def octets(requests):
    return [packets.build_tc(one.apid, 0, one.service, one.subtype, one.data) for one in requests]


def sample(field):
    """A text that fits a field that is not a group."""
    if field.get("options"):
        return field["options"][-1]["value"]
    if "coding" in field:
        if field["coding"] == "octets":
            return "12345678" if "CANopen" in field["hint"] or "width" in field["hint"] else "12"
        return TYPED.get(field["coding"]) or str(field.get("max", 1))
    number = field.get("max", 1)
    return ",".join([f"{number:g}" if field["type"] in ("FLOAT", "DOUBLE") else str(int(number))] * field.get("count", 1))


def test_a_form_sends_the_octets_of_the_command_line(mission):
    made = Forms(mission)
    for identity, form in made.by_id.items():
        if identity.startswith("tc ") or form.kind == "simulated world":
            continue
        typed = [sample(field) for field in form.fields]
        words = shlex.split(identity)
        if words[0] == "cmd":
            words += [f"{field['name']}={text}" for field, text in zip(form.fields, typed)]
        elif words[0] == "set":
            words.append(",".join(typed))
        else:
            words += typed
        text = made.text(identity, {field["name"]: value for field, value in zip(form.fields, typed)})
        assert octets(commands.plan(shlex.split(text), mission).requests) == octets(commands.plan(words, mission).requests), identity


def filled(fields, case):
    """(typed values, values for the encoder) of the fields of a message; `case` selects the choices."""
    typed, given = {}, {}
    for field in fields:
        if "repeat" in field:
            groups = [filled(field["fields"], case) for _ in range(2)]
            typed[field["name"]], given[field["name"]] = [group[0] for group in groups], [group[1] for group in groups]
        elif "choice" in field:
            inner = filled(field["cases"].get(typed[field["choice"]], []), case)
            typed |= inner[0]
            given |= inner[1]
        else:
            text = sample(field)
            if field.get("options"):
                text = field["options"][case % len(field["options"])]["value"]
            if field["name"] in ("parameter_value", "argument_value") or field.get("hint", "").startswith("in the type"):
                text = "10"
            typed[field["name"]] = text
            is_number = field.get("coding", "")[:1] in ("u", "i", "b") and field["coding"] != "id" and text.isdigit()
            given[field["name"]] = int(text) if is_number else text
    return typed, given


@pytest.mark.parametrize("case", range(3))
def test_a_request_of_the_catalogue_has_the_octets_of_its_encoder(mission, case):
    made = Forms(mission)
    for entry in mission.catalogue.all("TC"):
        message = entry["service"], entry["subtype"]
        form = made.by_id.get("tc {},{}".format(*message))
        if form is None:  # No subsystem of the mission offers this service.
            continue
        typed, given = filled(form.fields[1:], case)
        try:
            expected = mission.catalogue.encode("TC", *message, json.loads(json.dumps(given)))
        except ValueError as refusal:
            with pytest.raises(UsageError, match=str(refusal)[:20].replace("[", ".")):
                commands.plan(shlex.split(made.text(form.id, {"Subsystem": "SUPERVISOR", **typed})), mission)
            continue
        request, = commands.plan(shlex.split(made.text(form.id, {"Subsystem": "SUPERVISOR", **typed})), mission).requests
        assert (request.apid, request.service, request.subtype, request.data) == (1, *message, expected), form.id


@pytest.mark.parametrize(
    "identity, values, words",
    [
        ("cmd MANIPULATOR.MOVE_TO", {"POSITION": "9,0", "DURATION": "1"}, "POSITION, rad: 9 rad is above 2.8 rad"),
        ("cmd MANIPULATOR.MOVE_TO", {"POSITION": "0,0", "DURATION": "0.05"}, "DURATION, s: 0.05 s is below 0.1 s"),
        ("cmd MANIPULATOR.MOVE_TO", {"POSITION": "0,0", "DURATION": " "}, "DURATION is missing"),
        ("tc 8,1", {"Subsystem": "MANIPULATOR"}, "function_id is missing"),
        ("tc 17,3", {"Subsystem": "SUPERVISOR", "apid": "2048"}, "apid: 2048 is above 2047"),
        ("tc 3,5", {"Subsystem": "MANIPULATOR", "n": []}, "n: found 0 groups, expected at least 1"),
        ("tc 3,5", {"Subsystem": "MANIPULATOR", "n": ["4711"]}, "expected values by name"),
        ("tc 200,1", {}, "no form"),
    ],
)
def test_values_that_are_missing_or_out_of_range_are_reported(dictionary, identity, values, words):
    with pytest.raises(UsageError, match=words):
        Forms(dictionary).text(identity, values)


@pytest.mark.parametrize(
    "text, wanted",
    [("state MANIPULATOR OPERATIONAL", True), ("state MANIPULATOR OFFLINE", False), ("state MANIPULATOR ERROR_OPERATIONAL", False), ("state all SAFE_OPERATIONAL", True),
     ("link open HAND_POSITION", True), ("link close HAND_POSITION", True), ("link list", False), ("mode SAFE", True), ("process stop MANIPULATOR", True),
     ("process start MANIPULATOR", False), ("raw 180100000000", True), ("shutdown", True), ("stop", False), ("ping", False), ("reload MANIPULATOR", True),
     ("file delete /a", True), ("file list /", False), ("store delete A", True), ("schedule reset", True), ("schedule list", False),
     ("tc MANIPULATOR 12,2 n=[1]", True), ("tc SUPERVISOR 23,2 repository_path=/ file_name=a", True), ("tc SUPERVISOR 11,1", False),
     ("cmd MANIPULATOR.TARE", False), ("cmd MANIPULATOR.CHANNEL CHANNEL=1", True), ("get MANIPULATOR.DES_POSITION", False),
     ("at 10 ping MANIPULATOR", False), ("at 10 mode SAFE", True), ("at +1 file delete /a", True), ("at 10 cmd MANIPULATOR.CHANNEL CHANNEL=1", True)],
)
def test_the_requests_decide_whether_a_form_must_be_armed(dictionary, text, wanted):
    assert critical.is_critical(commands.plan(shlex.split(text), dictionary), dictionary) == wanted


def test_the_catalogue_decides_which_requests_are_critical(dictionary):
    flags = {(entry["service"], entry["subtype"]): entry["is_critical"] for entry in dictionary.catalogue.all("TC")}
    assert sum(flags.values()) > 25
    for (service, subtype), flag in flags.items():
        planned = Command("x", None, (Request(16, service, subtype),))
        assert critical.is_critical(planned, dictionary) == flag or (service, subtype) == (8, 1)
    assert critical.is_critical(Command("x", None, (Request(16, 77, 1),)), dictionary)


def test_a_request_is_offered_to_the_subsystems_that_have_its_service(dictionary):
    def offered(message):
        fields = Forms(dictionary).by_id[f"tc {message}"].fields
        return {option["value"] for option in fields[0]["options"]}

    assert offered("11,3") == offered("23,2") == offered("15,1") == {"SUPERVISOR"}
    assert offered("2,1") == offered("4,3") == {"MANIPULATOR"} and offered("12,15") == offered("6,2") == {"SUPERVISOR", "MANIPULATOR"}
    assert offered("17,1") == offered("8,1") == set(dictionary.subsystems)


def test_a_service_that_no_subsystem_has_is_not_offered():
    forms = Forms(Dictionary.load(ROOT / "build" / "generated" / "zoo.json")).by_id
    assert "tc 11,3" in forms and not [name for name in forms if name.startswith("tc 2,")]
