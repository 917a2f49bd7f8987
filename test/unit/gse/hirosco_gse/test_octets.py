# SPDX-License-Identifier: Apache-2.0
"""The fields of a packet with their octets, as a page shows them."""

import struct
from dataclasses import asdict

import pytest
from hirosco_gse import packets
from hirosco_gse.command import UsageError
from hirosco_gse.octets import Layouts
from hirosco_gse.station.kept_packets import KEPT, KINDS_MAX, OCTETS_MAX, KeptPackets
from tm_packets import build_tm
from visiting import JOYSTICK, MANIPULATOR, TELEPRESENCE, status

FLOWN = {
    "status": lambda _: build_tm(MANIPULATOR, 0, 129, 5, status(3, TELEPRESENCE)),
    "verification": lambda _: build_tm(MANIPULATOR, 0, 1, 4, struct.pack(">HHHHI", 0x1810, 0xC001, 0x0204, 0, 0x0305)),
    "event": lambda dictionary: build_tm(JOYSTICK, 0, 5, 4, struct.pack(">HB", dictionary.subsystem("JOYSTICK").event("DEVICE_LOST").id, 0x21)),
    "time": lambda _: struct.pack(">HHHB", 0, 0xC000, 11, 0) + packets.encode_time(5_000_000_000) + b"\0\0\0",
    "function": lambda _: packets.build_tc(MANIPULATOR, 1, 8, 1, b"MOVE_TO\0\2" + struct.pack(">HddHd", 1, 0.9, -1.3, 2, 1.5)),
    "ping": lambda _: packets.build_tc(MANIPULATOR, 1, 17, 1, ack=packets.ACK_ACCEPTANCE | packets.ACK_COMPLETION),
}


def shown(dictionary, raw, configuration=None):
    """[(octets, name, text)] of the fields of a packet. Each octet is in one field."""
    packet = packets.parse(raw)
    spans = Layouts(dictionary).spans(packet, configuration)
    seen = sorted((one.at, one.size) for one in spans)
    assert all(at + size == after for (at, size), (after, _) in zip(seen, seen[1:])) and seen[0][0] == 0 and sum(seen[-1]) == len(packet.raw)
    return {one.name: (packet.raw[one.at : one.at + one.size].hex(), one.text) for one in spans}


@pytest.mark.parametrize("kind", FLOWN)
def test_each_octet_of_a_packet_is_in_one_field(dictionary, kind):
    raw = FLOWN[kind](dictionary)
    raw = raw if kind != "time" else raw[:-2] + struct.pack(">H", packets.crc16(raw[:-2]))
    found = shown(dictionary, raw)
    assert "octets" not in found and found["checksum"][1] == f"0x{raw[-2:].hex().upper()}"


def test_numbers_are_shown_with_what_they_identify(dictionary):
    """The subsystem that has sent a packet says what an event, a device and a configuration are."""
    event, state = shown(dictionary, FLOWN["event"](dictionary)), shown(dictionary, FLOWN["status"](dictionary))
    number = dictionary.subsystem("JOYSTICK").event("DEVICE_LOST").id
    assert event["event_definition_id"] == (f"{number:04x}", f"{number} DEVICE_LOST") and event["NODE"] == ("21", "STICK (0x21)")
    assert state["type and APID"] == ("0810", "TM, 16 MANIPULATOR") and state["configuration"] == ("0002", "2 TELEPRESENCE")
    assert state["state"] == ("03", "PRE_OPERATIONAL") and state["subtype"][1] == "5 status report"
    assert shown(dictionary, FLOWN["verification"](dictionary))["failure_code"][0] == "0204"
    assert shown(dictionary, FLOWN["ping"](dictionary))["PUS version, reports"] == ("29", "acceptance, completion")
    function = shown(dictionary, FLOWN["function"](dictionary))
    assert function["POSITION"] == (struct.pack(">dd", 0.9, -1.3).hex(), "[0.9, -1.3] rad") and function["DURATION"][1] == "1.5 s"


def test_a_structure_is_that_of_the_present_configuration_with_all_its_samples(dictionary):
    part = dictionary.subsystem("MANIPULATOR").configuration("TELEPRESENCE")
    structure = next(one for one in part.structures.values() if one.repeated)
    times, parameters = structure.repeated[0]
    size = sum(one.size for one in structure.once) + sum(n * sum(one.size for one in each) for n, each in structure.repeated)
    raw = build_tm(MANIPULATOR, 0, 3, 25, struct.pack(">H", structure.id) + bytes(size))
    found = shown(dictionary, raw, part.id)
    leaves = [f"{parameters[0].name}.{one.name}" for one in parameters[0].fields] or [parameters[0].name]
    assert f"{leaves[0]}, sample 1" in found and f"{leaves[0]}, sample {times}" in found and "octets" not in found


@pytest.mark.parametrize(("data", "reason"), [(b"\0\1\0", "structure"), (b"\0", "octets left")])
def test_octets_that_do_not_fit_the_dictionary_are_one_field_with_the_reason(dictionary, data, reason):
    assert reason in shown(dictionary, build_tm(MANIPULATOR, 0, 3, 25, data))["octets"][1]


def test_octets_after_the_last_field_and_unknown_messages_are_named(dictionary):
    assert shown(dictionary, build_tm(MANIPULATOR, 0, 17, 2, b"\1\2"))["octets"] == ("0102", "more octets than the message has")
    assert shown(dictionary, build_tm(MANIPULATOR, 0, 250, 1, b"\1"))["octets"] == ("01", "not in the catalogue of messages")


def test_the_newest_packets_of_each_kind_are_stored(dictionary):
    """Telecommands come first; octets that are no packet are not stored."""
    kept = KeptPackets(dictionary)
    for number in range(KEPT + 5):
        kept.take(packets.parse(build_tm(MANIPULATOR, 0, 129, 5, status(3, number))), float(number))
    kept.take(packets.parse(FLOWN["event"](dictionary)), 3.0)
    kept.take_sent(FLOWN["ping"](dictionary), None)
    kept.take_sent(b"no packet", 1.0)
    rows = kept.rows()
    assert [(row["message"], row["subsystem"], row["name"], row["time"]) for row in rows] == [
        ("TC[17,1]", "MANIPULATOR", "perform an are-you-alive connection test", None), ("TM[129,5]", "MANIPULATOR", "status report", KEPT + 4.0),
        ("TM[5,4]", "JOYSTICK", "DEVICE_LOST", 3.0)]
    shown = kept.packets(rows[1]["kind"], {MANIPULATOR: TELEPRESENCE})
    assert [one["time"] for one in shown["packets"]] == [float(number) for number in range(5, KEPT + 5)]
    oldest = shown["packets"][0]
    assert bytes.fromhex(oldest["octets"])[24:26] == b"\0\5" and shown["name"] == "status report"
    assert oldest["fields"] == [asdict(one) for one in Layouts(dictionary).spans(packets.parse(bytes.fromhex(oldest["octets"])))]
    with pytest.raises(UsageError, match="no packet of this kind"):
        kept.packets(["TM", 1, 2, 3, None], {})


def test_of_long_packets_only_the_newest_are_in_an_answer(dictionary):
    kept = KeptPackets(dictionary)
    for number in range(3):
        kept.take(packets.parse(build_tm(MANIPULATOR, 0, 250, 1, bytes(OCTETS_MAX // 2 - 50 + 100 * (number == 0)))), float(number))
    assert [one["time"] for one in kept.packets(kept.rows()[0]["kind"], {})["packets"]] == [1.0, 2.0]


def test_the_number_of_kinds_is_bounded(dictionary):
    kept = KeptPackets(dictionary)
    for number in range(KINDS_MAX + 1):
        kept.take(packets.parse(build_tm(MANIPULATOR, 0, 3, 25, struct.pack(">H", number))), 0.0)
    names = [row["name"] for row in kept.rows()]
    assert len(names) == KINDS_MAX and "structure 0" not in names and f"structure {KINDS_MAX}" in names
