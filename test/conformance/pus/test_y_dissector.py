# SPDX-License-Identifier: Apache-2.0
"""The generated dissector, in tshark, reads the packets of the whole flight of these tests and synthetic
packets of every kind in the same way as the ground segment. The name of this file sorts it after those whose
packets it reads."""

import collections
import random
import struct

import dissection
import flying
import pytest
from hirosco_gse import packets
from hirosco_gse.dictionary import Dictionary
from made_up import reports_of
from message_values import Values
from tm_packets import build_tm

GENERATED = flying.ROOT / "build" / "generated"
SCRIPT = GENERATED / "rokviss.lua"
OF_EACH_KIND = 20


@pytest.fixture(scope="module")
def dictionary():
    return Dictionary.load(GENERATED / "rokviss.json")


def test_reports_of_the_flight_are_dissected_to_the_same_values(station, tmp_path):
    station.ask("MANIPULATOR", 17, 1)
    kinds = collections.defaultdict(list)
    for packet, _ in station.reports:
        kinds[packet.apid, packet.message, packet.data[:2] if packet.service in (3, 5) else b""].append(packet.raw)
    rng = random.Random(1)
    chosen = [found if len(found) <= OF_EACH_KIND else rng.sample(found, OF_EACH_KIND) for found in kinds.values()]
    compared = dissection.compare(SCRIPT, tmp_path / "chosen.pcap", [raw for found in chosen for raw in found], station.dictionary)
    assert all(compared[title] for title in ("TM[1,1]", "TM[1,7]", "TM[17,2]")), compared


def test_synthetic_messages_of_every_kind_are_dissected_to_the_same_values(dictionary, tmp_path):
    raws = []
    for entry in dictionary.catalogue.all():
        service, subtype = entry["service"], entry["subtype"]
        if (service, subtype) in ((3, 25), (3, 26), (8, 1)) or service == 5 and subtype <= 4:
            continue  # The descriptors define their layouts.
        for seed in range(2):
            data = dictionary.catalogue.encode(entry["direction"], service, subtype, Values(dictionary.catalogue, seed).group(entry, entry["fields"]))
            made = packets.build_tc(16, seed, service, subtype, data)
            raws.append(made if entry["direction"] == "TC" else build_tm(16, seed, service, subtype, data, 2, dictionary.epoch_ns + 10**9))
    compared = dissection.compare(SCRIPT, tmp_path / "made-up.pcap", raws, dictionary)
    assert len(compared) > 300


@pytest.mark.parametrize("mission", ["rokviss", "ur5e"])
def test_housekeeping_events_and_functions_of_all_subsystems_are_dissected_to_the_same_values(mission, tmp_path):
    known = Dictionary.load(GENERATED / f"{mission}.json")
    raws, rng = list(reports_of(known, random.Random(2))), random.Random(3)
    for subsystem in known.subsystems.values():
        for function in subsystem.functions.values():
            data = function.name.encode().ljust(8, b"\0") + bytes([len(function.arguments)])
            for item in function.arguments:
                data += struct.pack(">H", item.id) + (struct.pack(">" + "B" * item.size, *bytes(item.size)) if item.words else rng.randbytes(item.size))
            raws.append(packets.build_tc(subsystem.apid, 1, 8, 1, data))
    compared = dissection.compare(GENERATED / f"{mission}.lua", tmp_path / "reports.pcap", raws, known)
    assert compared["TM[3,25]"] > 100 and compared["TC[8,1]"] > 10, compared


def _stream(octets, port, cut):
    """A capture (link type IPv4) of a TCP stream from this port, in two segments."""
    parts = []
    for start, part in ((0, octets[:cut]), (cut, octets[cut:])):
        tcp = struct.pack(">HHIIBBHHH", port, 40000, 1 + start, 1, 5 << 4, 0x18, 8192, 0, 0) + part
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0, b"\x7f\0\0\1", b"\x7f\0\0\1")
        parts.append(struct.pack("<IIII", 0, 0, len(ip + tcp), len(ip + tcp)) + ip + tcp)
    return struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65542, 228) + b"".join(parts)


def test_packets_in_a_tcp_stream_are_found_across_segments(dictionary, tmp_path):
    raws = [build_tm(apid, 7, 17, 2, b"", 0, dictionary.epoch_ns) for apid in (16, 17, 1)]
    path = tmp_path / "stream.pcap"
    path.write_bytes(_stream(b"".join(raws), dictionary.content["ground"]["port"], 30))
    shown = dissection.tshark(SCRIPT, path, "-T", "fields", "-E", "aggregator= ", "-e", "pus.apid").split()
    assert shown == ["16", "17", "1"]


def test_damage_and_another_interface_are_reported(dictionary, tmp_path):
    status = bytearray(3 + 2 + 8 + 8 + 4 + 4)
    good = build_tm(16, 0, 129, 5, bytes(status[:5]) + struct.pack(">Q", dictionary.subsystem_of_apid(16).interface_hash) + bytes(16), 0, dictionary.epoch_ns)
    other = build_tm(16, 0, 129, 5, bytes(status), 0, dictionary.epoch_ns)
    flipped = good[:-1] + bytes([good[-1] ^ 1])
    long_text = build_tm(16, 0, 17, 2, b"\1\2", 0, dictionary.epoch_ns)
    path = dissection.capture(tmp_path / "damaged.pcap", [good, other, flipped, long_text, good[:-3], good[:4], good[:14]])
    names = ("pus.interface.differs", "pus.crc.wrong", "pus.malformed", "_ws.lua.error")
    lines = dissection.tshark(SCRIPT, path, "-T", "fields", *(word for name in names for word in ("-e", name))).splitlines()
    reported = [[name for name, text in zip(names, line.split("\t")) if text] for line in lines]
    assert reported == [[], [names[0]], [names[1]], *([[names[2]]] * 4)]


def test_the_dissector_names_the_interface_that_it_is_made_for(dictionary):
    head = SCRIPT.read_text(encoding="utf-8")[:400]
    assert dictionary.interface_hash in head and dictionary.configuration_hash in head
