# SPDX-License-Identifier: Apache-2.0
"""The dictionary of each mission and descriptors/schema/dictionary.schema.json: the dictionaries are valid,
and the schema fits what the generator can write."""

import copy
import json
import pathlib
import sys

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "descriptors" / "schema" / "dictionary.schema.json").read_text(encoding="utf-8"))
MISSIONS = sorted(path.stem for path in (ROOT / "descriptors" / "missions").glob("*.xml"))

sys.path.insert(0, str(ROOT / "gse" / "generator"))
import catalogue  # noqa: E402
import source  # noqa: E402
import subsystem  # noqa: E402
import xtce  # noqa: E402


def dictionary(mission):
    return json.loads((ROOT / "build" / "generated" / f"{mission}.json").read_text(encoding="utf-8"))


def refusals(content):
    """Places in a dictionary that the schema refuses, with the reasons."""
    found = jsonschema.Draft202012Validator(SCHEMA).iter_errors(content)
    return {"/".join(map(str, error.absolute_path)): error.message for error in found}


@pytest.mark.parametrize("mission", MISSIONS)
def test_the_dictionary_of_a_mission_is_valid(mission):
    assert refusals(dictionary(mission)) == {}


def test_the_schema_is_valid():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.fixture(scope="module")
def sound():
    return dictionary("rokviss")


def parameter(content, name):
    return next(one for each in content["subsystems"] for one in each["parameters"] if one["name"] == name)


DAMAGES = {
    "a hash in decimal": (lambda all_: all_.update(interface_hash="17"), "interface_hash"),
    "no hash": (lambda all_: all_.pop("configuration_hash"), ""),
    "another key": (lambda all_: all_.update(colour="red"), ""),
    "an unknown type": (lambda all_: parameter(all_, "TORQUE_LIMIT").update(type="FLOAT16"), "subsystems/"),
    "a limit as text": (lambda all_: parameter(all_, "TORQUE_LIMIT").update(max="9"), "subsystems/"),
    "no limit": (lambda all_: parameter(all_, "TORQUE_LIMIT").pop("min"), "subsystems/"),
    "fields of a scalar": (lambda all_: parameter(all_, "TORQUE_LIMIT").update(fields=[]), "subsystems/"),
    "a structure without fields": (lambda all_: parameter(all_, "CLIENTS").pop("fields"), "subsystems/"),
    "an unknown state": (lambda all_: all_["subsystems"][0]["power_w"].update(RESTING=5), "subsystems/0/power_w"),
    "an APID of idle packets": (lambda all_: all_["subsystems"][0].update(apid=2047), "subsystems/0/apid"),
    "an unknown coding": (lambda all_: all_["catalogue"]["kinds"]["apid"].update(coding="u24"), "catalogue/kinds/apid/coding"),
    "a choice without cases": (
        lambda all_: all_["catalogue"]["services"]["17"]["messages"][0]["fields"].append({"choice": "a"}), "catalogue/services/17/messages/0/"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_dictionary_is_refused_at_its_place(sound, damage):
    content = copy.deepcopy(sound)
    change, place = DAMAGES[damage]
    change(content)
    found = refusals(content)
    assert len(found) == 1 and next(iter(found)).startswith(place), found


def test_the_words_of_the_schema_are_those_of_the_generator():
    defined = SCHEMA["$defs"]
    assert defined["state"]["enum"] == list(source.STATES)
    assert set(defined["type"]["enum"]) == set(source.TYPES)
    assert defined["event"]["properties"]["severity"]["enum"] == list(xtce.SEVERITIES)
    assert set(defined["method"]["enum"]) == set(subsystem.METHODS)
    codings = {*catalogue.CODINGS, *catalogue.VARIABLE, "id", "layout", "bits", "octets"}
    assert set(defined["kind"]["properties"]["coding"]["enum"]) == codings
