# SPDX-License-Identifier: Apache-2.0
"""The XTCE database against readers of other projects: the schema of XTCE 1.2, and space_packet_parser, which
decodes the reports of the whole flight of these tests, and synthetic reports of every kind, to the same
values as our ground."""

import collections
import random
import struct

import flying
import pytest
from database_reading import check
from flat_xtce import Flattened
from hirosco_gse import packets
from hirosco_gse.dictionary import Dictionary
from message_values import Values
from space_packet_parser.xtce.validation import validate_xtce
from tm_packets import build_tm

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


def test_the_flight_reads_the_same_by_the_database(flight, station, definition, dictionary):
    station.ask("MANIPULATOR", 17, 1)
    station.do("SUPERVISOR", 3, 27, n=[{"hk_structure_id": 1}])
    station.refuse(0x0201, "MANIPULATOR", 3, 27, n=[{"hk_structure_id": 1}])
    kinds = collections.defaultdict(list)
    dictionary = station.dictionary  # The station knows what was created.
    for packet, _ in station.reports:
        if packet.apid == 0:  # Spacecraft time packets have neither service nor subtype.
            continue
        kinds[(packet.apid, packet.message, packet.data[:2] if packet.service in (3, 5) else b"")].append(packet)
    chance, compared = random.Random(1), collections.Counter()
    for packets_of_kind in kinds.values():
        chosen = packets_of_kind if len(packets_of_kind) <= OF_EACH_KIND else chance.sample(packets_of_kind, OF_EACH_KIND)
        for packet in chosen:
            compared[packet.message] += check(definition, packet, dictionary)
    assert all(compared[message] for message in ((1, 1), (1, 4), (1, 7), (3, 25), (17, 2))), compared


def test_made_up_reports_of_every_kind_read_the_same(definition, dictionary):
    for entry in dictionary.catalogue.all("TM"):
        message = entry["service"], entry["subtype"]
        if message in ((3, 25), (3, 26)) or (message[0] == 5 and message[1] <= 4):
            continue  # Below.
        for seed in range(3):
            data = dictionary.catalogue.encode("TM", *message, Values(dictionary.catalogue, seed).group(entry, entry["fields"]))
            raw = build_tm(16, seed, *message, data, 2, dictionary.epoch_ns + 10**9, seed)
            assert check(definition, packets.parse(raw), dictionary)


def test_made_up_housekeeping_and_events_of_all_subsystems_read_the_same(definition, dictionary):
    chance, severities = random.Random(2), ("INFORMATIVE", "LOW", "MEDIUM", "HIGH")
    for subsystem in dictionary.subsystems.values():
        for configuration in subsystem.configurations.values():
            for structure in configuration.structures.values():
                size = sum(p.size for p in structure.once) + sum(n * sum(p.size for p in ps) for n, ps in structure.repeated)
                data = struct.pack(">H", structure.id) + chance.randbytes(size)
                raw = build_tm(subsystem.apid, 1, 3, 25, data, 0, dictionary.epoch_ns, 0)
                assert check(definition, packets.parse(raw), dictionary)
        for event in subsystem.events.values():
            data = struct.pack(">H", event.id) + chance.randbytes(sum(p.size for p in event.parameters))
            subtype = severities.index(event.severity) + 1
            raw = build_tm(subsystem.apid, 1, 5, subtype, data, 0, dictionary.epoch_ns, 0)
            assert check(definition, packets.parse(raw), dictionary)
