# SPDX-License-Identifier: Apache-2.0
"""Packets in parts on the ground: splitting, assembly, and the outcome of a request that was sent in
parts."""

import random
import struct

import pytest
from hirosco_gse import large, packet_log, packets
from hirosco_gse.session import Request, Session
from tm_packets import build_tm

USER, SUPERVISOR = 2, 1


def _parts(raw, transaction=5, size=512):
    """Reports with the parts of a long report."""
    pieces = [raw[at : at + size] for at in range(0, len(raw), size)]
    for number, piece in enumerate(pieces, 1):
        subtype = 1 if number == 1 else 3 if number == len(pieces) else 2
        yield packets.parse(build_tm(SUPERVISOR, 0, 13, subtype, struct.pack(">HH", transaction, number) + piece, USER))


@pytest.mark.parametrize("size", [4097, 8158, 8159, 65542])
def test_a_packet_cut_into_parts_is_reassembled(size):
    raw = packets.build_tc(SUPERVISOR, 9, 18, 1, random.Random(1).randbytes(size - 13), USER)
    parts = [packets.build_tc(SUPERVISOR, 0, 13, subtype, data, USER) for subtype, data in large.cut(raw, 7)]
    assert all(len(part) <= packets.PACKET_MAX for part in parts)
    assembler = large.Assembler()
    found = [assembler.take(packets.parse(part)) for part in parts]
    assert found[:-1] == [None] * (len(parts) - 1) and found[-1].raw == raw
    assert not assembler.problems


def test_cutting_a_short_packet_is_refused():
    with pytest.raises(packets.PacketError):
        large.cut(packets.build_tc(1, 0, 17, 1), 7)


def test_parts_of_several_reports_may_be_mixed_but_not_missing():
    whole = [build_tm(SUPERVISOR, 1, 20, 2, bytes([number]) * 5000, USER) for number in range(3)]
    parts = [list(_parts(raw, number)) for number, raw in enumerate(whole)]
    assembler, found = large.Assembler(), []
    for row in zip(*parts):
        found += [assembler.take(part) for part in row]
    assert [packet.raw for packet in found if packet] == whole
    lost, doubled, late = [*parts[0][:2], *parts[0][3:]], [parts[1][0], parts[1][1], *parts[1][1:]], parts[2][1:]
    assert not any(assembler.take(part) for part in lost + doubled + late)
    assert len(assembler.problems) > 3
    torn = [*parts[0][:-1], packets.parse(build_tm(SUPERVISOR, 0, 13, 3, parts[0][-1].data[:-1], USER))]
    assert not any(assembler.take(part) for part in torn)
    assert assembler.take(packets.parse(build_tm(SUPERVISOR, 0, 13, 1, b"", USER))) is None


def test_a_log_shows_packets_behind_their_parts():
    raw = build_tm(SUPERVISOR, 1, 20, 2, bytes(5000), USER)
    lines = [f"{number}.000000000 TM {part.raw.hex()}\n" for number, part in enumerate(_parts(raw))]
    rows = packet_log.with_whole(packet_log.parse_packets([*lines, "99.000000000 TC 00\n"]))
    assert rows[-2][1:] == ("TM", packets.parse(raw), raw) and rows[-2][0] == rows[-3][0]
    assert len(rows) == len(lines) + 2


def _verify(session, raw, subtype, failure=b""):
    session.feed(build_tm(SUPERVISOR, 0, 1, subtype, raw[:4] + failure, USER))


def test_a_long_request_is_sent_in_parts_and_ends_with_its_own_verification(dictionary):
    session = Session(dictionary, first_sequence=3, source=USER)
    verification = session.send(Request(SUPERVISOR, 18, 1, bytes(9000), "long"))
    sent = packets.Splitter().feed(session.outbox)
    assert [packets.parse(raw).message for raw in sent] == [(13, 9), (13, 10), (13, 11)]
    for raw in sent:
        _verify(session, raw, 7)
    assert not verification.is_finished
    _verify(session, verification.request_id, 7)
    assert verification.is_finished and verification.failure is None


def test_a_part_that_is_refused_ends_the_long_request(dictionary):
    session = Session(dictionary, first_sequence=3, source=USER)
    verification = session.send(Request(SUPERVISOR, 18, 1, bytes(9000), "long"))
    sent = packets.Splitter().feed(session.outbox)
    for raw in sent:
        _verify(session, raw, 4, struct.pack(">HHI", 0x0205, 0, 4096))
    assert verification.is_finished and verification.failure.code == 0x0205  # PUS_FAILURE_TABLE_FULL.
    assert len(verification.failures) == 1


def test_a_long_report_answers_a_request_that_has_ended(dictionary):
    session = Session(dictionary, first_sequence=3, source=USER)
    verification = session.send(Request(SUPERVISOR, 20, 1, b"", "ask"))
    _verify(session, verification.request_id, 7)
    raw = build_tm(SUPERVISOR, 1, 20, 2, bytes(5000), USER)
    for part in [*_parts(raw, 1), *_parts(raw, 2)]:
        session.feed(part.raw)
    assert [packet.raw for packet, _ in verification.replies] == [raw]
    session.feed(build_tm(SUPERVISOR, 0, 13, 2, struct.pack(">HH", 9, 2), USER))
    assert session.malformed
