# SPDX-License-Identifier: Apache-2.0
"""The XTCE database and readers of other projects: the schema of XTCE 1.2, and space_packet_parser, which
decodes the reports of the whole flight of these tests and synthetic reports of every kind to the same values
as the ground segment. The name of this file sorts it after those whose reports it reads."""

import collections
import json
import random
import struct
import sys
import xml.etree.ElementTree as ET

import flying
import named_dictionary
import pytest
from database_reading import check
from flat_xtce import Flattened
from hirosco_gse import packets, telemetry
from hirosco_gse.dictionary import Dictionary
from made_up import reports_of
from message_values import Values
from space_packet_parser.xtce.validation import validate_xtce
from tm_packets import build_tm

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201

GENERATED = flying.ROOT / "build" / "generated"
MISSION = "rokviss"
OF_EACH_KIND = 40


@pytest.fixture(scope="module")
def flat():
    return Flattened(GENERATED / f"{MISSION}.xtce.xml")


@pytest.fixture(scope="module")
def definition(flat, tmp_path_factory):
    return flat.definition(tmp_path_factory.mktemp("xtce"))


@pytest.fixture(scope="module")
def dictionary():
    return Dictionary.load(GENERATED / f"{MISSION}.json")


@pytest.mark.parametrize("mission", [path.stem for path in sorted((flying.ROOT / "descriptors" / "missions").glob("*.xml"))])
def test_databases_keep_to_the_schema(mission, tmp_path):
    path = GENERATED / f"{mission}.xtce.xml"
    found = validate_xtce(path, level="schema", print_results=False, raise_on_error=False)
    assert found.valid, [str(error) for error in found.errors[:5]]
    broken = tmp_path / "broken.xml"
    broken.write_text(path.read_text(encoding="utf-8").replace("<IntegerDataEncoding ", "<IntegerDataEncoding sizeInBit='1' ", 1))
    assert not validate_xtce(broken, level="schema", print_results=False, raise_on_error=False).valid


def test_reports_of_the_flight_read_the_same(flight, station, definition, dictionary):
    station.ask("MANIPULATOR", 17, 1)
    station.do("SUPERVISOR", 3, 27, n=[{"hk_structure_id": 1}])
    station.refuse(UNKNOWN_ID, "MANIPULATOR", 3, 27, n=[{"hk_structure_id": 1}])
    kinds = collections.defaultdict(list)
    dictionary = station.dictionary  # The station knows which structures were created.
    for packet, _ in station.reports:
        if packet.apid == 0:  # Spacecraft time packets have neither service nor subtype.
            continue
        kinds[(packet.apid, packet.message, packet.data[:2] if packet.service in (3, 5) else b"")].append(packet)
    rng, compared = random.Random(1), collections.Counter()
    for packets_of_kind in kinds.values():
        chosen = packets_of_kind if len(packets_of_kind) <= OF_EACH_KIND else rng.sample(packets_of_kind, OF_EACH_KIND)
        for packet in chosen:
            compared[packet.message] += check(definition, packet, dictionary)
    assert all(compared[message] for message in ((1, 1), (1, 4), (1, 7), (3, 25), (17, 2))), compared


def test_synthetic_reports_of_every_kind_read_the_same(definition, dictionary):
    for entry in dictionary.catalogue.all("TM"):
        message = entry["service"], entry["subtype"]
        if message in ((3, 25), (3, 26)) or (message[0] == 5 and message[1] <= 4):
            continue  # Their layouts are in descriptors: the test of housekeeping and events makes them.
        for seed in range(3):
            data = dictionary.catalogue.encode("TM", *message, Values(dictionary.catalogue, seed).group(entry, entry["fields"]))
            raw = build_tm(16, seed, *message, data, 2, dictionary.epoch_ns + 10**9, seed)
            assert check(definition, packets.parse(raw), dictionary)


def _check_synthetic_reports(definition, dictionary):
    for raw in reports_of(dictionary, random.Random(2)):
        assert check(definition, packets.parse(raw), dictionary)


def test_synthetic_housekeeping_and_events_of_all_subsystems_read_the_same(definition, dictionary):
    _check_synthetic_reports(definition, dictionary)


@pytest.mark.parametrize("mission", ["ur5e", "zoo"])
def test_reports_of_missions_with_names_for_numbers_read_the_same(mission, tmp_path):
    flattened = Flattened(GENERATED / f"{mission}.xtce.xml")
    _check_synthetic_reports(flattened.definition(tmp_path), Dictionary.load(GENERATED / f"{mission}.json"))


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """(database, dictionary) of rokviss with names for numbers in parameters, arguments, fields and values of events."""
    sys.path.insert(0, str(flying.ROOT / "gse" / "generator"))
    import common_words
    import xtce

    content = named_dictionary.named(json.loads((GENERATED / f"{MISSION}.json").read_text(encoding="utf-8")))
    path = tmp_path_factory.mktemp("names") / "names.xtce.xml"
    path.write_text(xtce.database(content, common_words.failure_names())[0], encoding="utf-8")
    return path, Dictionary(content)


def test_names_for_numbers_keep_to_the_schema_and_read_the_same(names, tmp_path):
    path, dictionary = names
    found = validate_xtce(path, level="schema", print_results=False, raise_on_error=False)
    assert found.valid, [str(error) for error in found.errors[:5]]
    _check_synthetic_reports(Flattened(path).definition(tmp_path), dictionary)


def _labels(tree, what, name):
    """Label by number of an enumerated type, and its encoding."""
    space = "{http://www.omg.org/spec/XTCE/20180204}"
    kind = next(one for one in tree.iter(f"{space}Enumerated{what}Type") if one.get("name") == name)
    encoding = kind.find(f"{space}IntegerDataEncoding")
    return {int(one.get("value")): one.get("label") for one in kind.iter(f"{space}Enumeration")}, encoding.get("sizeInBits")


def test_names_for_numbers_are_types_of_parameters_and_arguments(names):
    tree = ET.parse(names[0])
    words = {3: "SLOW", 4: "QUICK"}
    for what, name, bits in (("Parameter", "PACE_UINT16_enumeration", "16"), ("Parameter", "PACE_UINT32_enumeration", "32"),
                             ("Parameter", "PACE_INT8_enumeration", "8"), ("Argument", "PACE_UINT16_enumeration", "16")):
        assert _labels(tree, what, name) == (words, bits)
    space = "{http://www.omg.org/spec/XTCE/20180204}"
    for command, argument, kind in (("MOVE_TO", "DURATION", "PACE_UINT16_enumeration"), ("SET_CHOICE", "CHOICE", "CHOICE_array")):
        made = next(one for one in tree.iter(f"{space}MetaCommand") if one.get("name") == command)
        (typed,) = [one.get("argumentTypeRef") for one in made.iter(f"{space}Argument") if one.get("name") == argument]
        assert typed.endswith(kind), typed


def test_failure_codes_of_subsystems_are_labels(names):
    labels, _ = _labels(ET.parse(names[0]), "Parameter", "failure_code")
    assert labels[0x8001] == "MANIPULATOR.TOO_FAR" and labels[0x8002] == "MANIPULATOR.TOO_FAST" and labels[0x0203] == "OUT_OF_RANGE"
    raw = build_tm(16, 1, 1, 8, bytes(4) + struct.pack(">HHI", 0x8001, 0, 2), 0, 0, 0)
    decoded = telemetry.decode(packets.parse(raw), names[1])
    assert decoded["words"] == "failed at completion: TOO_FAR, JOINT 2 [0x8001]"
