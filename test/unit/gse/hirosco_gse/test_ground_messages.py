# SPDX-License-Identifier: Apache-2.0
"""The ground's reader and writer of all messages in the catalogue."""

import json
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "support"))

from hirosco_gse import commands, packets
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.messages import MessageProblem
from hirosco_gse.session import Session
from message_values import Values
from tm_packets import build_tm

ROOT = pathlib.Path(__file__).resolve().parents[4]
GENERATED = ROOT / "build" / "generated" / "rokviss.json"


@pytest.fixture(scope="module", name="dictionary")
def _dictionary():
    return Dictionary.load(GENERATED)


def test_the_catalogue_has_318_messages_and_each_named_answer(dictionary):
    numbers = {(entry["service"], entry["subtype"]) for entry in dictionary.catalogue.all()}
    assert len(numbers) == 318 == len(dictionary.catalogue.all())
    assert len(dictionary.catalogue.all("TC")) == 240
    for entry in dictionary.catalogue.all("TC"):
        answer = entry["answer"]
        assert not answer or dictionary.catalogue.find("TM", entry["service"], answer), entry


@pytest.mark.parametrize("direction", ["TC", "TM"])
def test_an_encoded_message_is_decoded_and_one_with_an_octet_more_is_refused(dictionary, direction):
    catalogue = dictionary.catalogue
    for entry in catalogue.all(direction):
        for seed in range(6):
            given = Values(catalogue, seed).group(entry, entry["fields"])
            message = entry["service"], entry["subtype"]
            octets = catalogue.encode(direction, *message, given)
            packet = packets.Packet(direction, 16, 0, *message, 1, octets, b"")
            assert catalogue.decode(packet) == given, entry["name"]
            if any(word in json.dumps(entry) for word in ('"part"', '"values"', '"auxiliary"', "argument_id", "transaction")):
                continue  # The last field accepts all remaining octets.
            with pytest.raises(MessageProblem):
                catalogue.decode(packets.Packet(direction, 16, 0, *message, 1, octets + b"\0", b""))


def test_errors_name_the_field_and_the_expected_value(dictionary):
    encode = dictionary.catalogue.encode
    for given, words in (
        ({}, "rate_exponential_value is missing"),
        ({"rate_exponential_value": 256}, "rate_exponential_value"),
        ({"rate_exponential_value": 1, "x": 2}, "no field x here; there are: rate_exponential_value"),
    ):
        with pytest.raises(MessageProblem, match=words):
            encode("TC", 9, 1, given)
    with pytest.raises(MessageProblem, match="none of: disabled, enabled"):
        encode("TC", 11, 22, {"n": [{"group_id": 1, "group_status": "off"}]})
    with pytest.raises(MessageProblem, match="more than 8 characters"):
        encode("TC", 21, 3, {"request_sequence_id": "NINELETTE"})


def test_words_of_an_operator_become_a_scheduled_request(dictionary):
    planned = commands.plan(["at", "12.5", "cmd", "MANIPULATOR.STOP"], dictionary)
    packet = packets.parse(packets.build_tc(1, 0, 11, 4, planned.requests[0].data))
    found = dictionary.catalogue.decode(packet)
    inner = packets.parse(bytes.fromhex(found["n"][0]["request"]))
    assert (found["sub_schedule_id"], found["n"][0]["group_id"], found["n"][0]["release_time"]) == (1, 1, 12.5)
    assert (inner.apid, inner.message, inner.user, inner.data[:4]) == (16, (8, 1), 1, b"STOP")


def test_requests_within_requests_have_counts_of_their_own(dictionary):
    """The spacecraft identifies a request by its packet ID and sequence count. A request that is released later must not have
    the identity of a request that the script sends meanwhile."""
    sent = Session(dictionary, first_sequence=0)
    counts = []
    for _ in range(3):
        planned = commands.plan(["at", "12.5", "ping", "MANIPULATOR"], dictionary)
        found = dictionary.catalogue.decode(packets.parse(packets.build_tc(1, 0, 11, 4, planned.requests[0].data)))
        counts.append(packets.parse(bytes.fromhex(found["n"][0]["request"])).sequence)
    assert len(set(counts)) == 3 and min(counts) >= commands.EMBEDDED_FIRST
    assert {sent.sequence(16) for _ in range(commands.EMBEDDED_FIRST)}.isdisjoint(counts)


def test_tc_sends_a_message_of_the_catalogue_and_refuses_other_words(dictionary):
    planned = commands.plan(["tc", "MANIPULATOR", "5,5", "n=[3,4]"], dictionary)
    assert planned.requests[0].data == bytes.fromhex("0200030004")
    for words in (["tc", "MANIPULATOR", "5"], ["tc", "MANIPULATOR", "7,1"], ["tc", "MANIPULATOR", "5,5", "n"], ["at", "1"]):
        with pytest.raises(commands.UsageError):
            commands.plan(words, dictionary)


@pytest.mark.parametrize(
    ("words", "message", "data"),
    [
        ("run LOOK uint8:7 bool:true", (18, 3), b"LOOK\0\0\0\0\x02\x02\x00\x07\x0a\x01"),
        ("activate LOOK", (18, 3), b"LOOK\0\0\0\0\x02\x00"),
        ("tell LOOK int16:-2", (18, 7), b"LOOK\0\0\0\0\x01\x05\xff\xfe"),
        ("suspend LOOK", (18, 5), b"LOOK\0\0\0\0\0\0"),
        ("stop LOOK", (18, 4), b"LOOK\0\0\0\0\0\0"),
        ("resume LOOK", (18, 6), b"LOOK\0\0\0\0"),
        ("abort LOOK", (18, 12), b"LOOK\0\0\0\0"),
        ("unload LOOK", (18, 2), b"LOOK\0\0\0\0"),
        ("engine start", (18, 21), b""),
        ("engine stop", (18, 22), b""),
        ("status", (18, 8), b""),
    ],
)
def test_words_become_requests_for_procedures(dictionary, words, message, data):
    (request,) = commands.plan(["procedure", *words.split()], dictionary).requests
    assert ((request.service, request.subtype), request.apid, request.data) == (message, 1, data)


def test_procedures_are_read_from_files(dictionary, tmp_path):
    place = tmp_path / "look.lua"
    place.write_bytes(b"step(1)")
    (request,) = commands.plan(["procedure", "load", "LOOK", str(place)], dictionary).requests
    assert request.data == b"LOOK\0\0\0\0\0\x07step(1)" + packets.crc16(b"step(1)").to_bytes(2, "big")
    place.write_bytes(b"x" * 16384)
    (request,) = commands.plan(["procedure", "load", "LOOK", str(place)], dictionary).requests
    assert len(request.data) == 12 + 16384  # This is longer than a packet, so the session splits it.
    place.write_bytes(b"x" * 16385)
    with pytest.raises(commands.UsageError, match="more than 16384 octets"):
        commands.plan(["procedure", "load", "LOOK", str(place)], dictionary)


@pytest.mark.parametrize("words", ["", "run", "stop", "engine", "engine off", "tell LOOK", "run LOOK 7", "run LOOK byte:7", "status LOOK"])
def test_words_that_are_no_request_for_procedures_are_refused(dictionary, words):
    with pytest.raises(commands.UsageError):
        commands.plan(["procedure", *words.split()], dictionary)


def test_the_same_request_twice_at_once_has_two_answers(dictionary):
    """The second one is sent before the first one is answered. Each has only its own report."""
    session = Session(dictionary, first_sequence=0)
    asked = [commands.plan(["procedure", "status"], dictionary).procedure(session, 10**10) for _ in range(2)]
    for procedure in asked:
        next(procedure)
    sent = [packets.parse(raw) for raw in packets.Splitter().feed(bytes(session.outbox))]
    found = []
    for number, (packet, procedure) in enumerate(zip(sent, asked)):
        report = dictionary.catalogue.encode("TM", 18, 9, {"n": [{"obcp_id": f"P{number}", "obcp_execution_status": 0, "obcp_checksum": 0}]})
        for service, subtype, data in ((1, 1, packet.request_id), (1, 3, packet.request_id), (18, 9, report), (1, 7, packet.request_id)):
            session.feed(build_tm(packet.apid, 0, service, subtype, data, packet.user, 10**9))
        with pytest.raises(StopIteration) as end:
            for _ in range(3):
                procedure.send(None)
        found.append([entry["obcp_id"] for row in end.value.value for entry in row["n"]])
    assert found == [["P0"], ["P1"]]
