# SPDX-License-Identifier: Apache-2.0
"""The ground's packet codec, compared with spacepackets and tested with malformed packets."""

import random
import struct

import pytest
from hirosco_gse import packets, values
from spacepackets.ecss import PusTc
from tm_packets import build_tm


def test_a_telecommand_equals_that_of_an_independent_encoder():
    random_source = random.Random(1)
    for _ in range(300):
        apid, sequence = random_source.randrange(1, 2047), random_source.randrange(0x4000)
        service, subtype = random_source.randrange(1, 256), random_source.randrange(1, 256)
        data = random_source.randbytes(random_source.randrange(0, 200))
        ours = packets.build_tc(apid, sequence, service, subtype, data, source=7)
        theirs = PusTc(
            service=service, subservice=subtype, apid=apid, seq_count=sequence, source_id=7, app_data=data
        ).pack()
        assert ours == bytes(theirs)
        parsed = packets.parse(ours)
        assert (parsed.apid, parsed.sequence, parsed.message, parsed.user, parsed.data, parsed.ack) == (
            apid, sequence, (service, subtype), 7, data, 15,
        )
        assert PusTc.unpack(ours).app_data == data


def test_a_known_packet_is_made_and_one_with_another_time_code_is_refused():
    """The packets are worked examples of other implementations."""
    assert packets.build_tc(100, 25, 17, 1).hex() == "1864c01900062f11010001ebe6"
    # CUC 4+3 with another P-field (agency epoch): the error contains the P-field.
    with pytest.raises(packets.PacketError, match="P-field"):
        packets.parse(bytes.fromhex("0864c0020010201102000200012f0000002a800000e29d"))


@pytest.mark.parametrize(
    ("text", "crc"), [("", 0xFFFF), ("0000", 0x1D0F), ("000000", 0xCC9C), ("ABCDEF01", 0x04A2), ("1456F89A0001", 0x7FD5)]
)
def test_the_checksum_of_known_texts_is_computed(text, crc):
    assert packets.crc16(bytes.fromhex(text)) == crc
    assert packets.crc16(b"123456789") == 0x29B1


def test_a_written_time_is_read_back():
    assert packets.encode_time(42_500_000_000).hex() == "1f0000002a800000"
    for time_ns in (0, 1, 59, 60, 500_000, 10**9 - 1, 2_159_006_400 * 10**9 + 123_456_789):
        assert abs(packets.decode_time(packets.encode_time(time_ns)) - time_ns) <= 60


def _tm():
    return bytearray(build_tm(16, 5, 17, 2, b"", 1, 10**18))


def _refit(raw):
    return bytes(raw[:-2]) + struct.pack(">H", packets.crc16(raw[:-2]))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda raw: bytes(raw[:4]), "packet has 4 octets, too short for a primary header: expected at least 6"),
        (lambda raw: _refit(raw[:4] + b"\0\5" + raw[6:12]), "packet has 12 octets, too short for a TM: expected at least 23"),
        (lambda raw: bytes(raw) + b"\0", "length field says 23 octets, the packet has 24"),
        (lambda raw: bytes(raw[:-1]), "length field"),
        (lambda raw: bytes([raw[0] | 0x20]) + bytes(raw[1:]), "packet version"),
        (lambda raw: bytes(raw[:2]) + bytes([raw[2] & 0x3F]) + bytes(raw[3:]), "sequence flags"),
        (lambda raw: bytes([raw[0] & ~0x08]) + bytes(raw[1:]), "secondary header flag is 0, expected 1"),
        (lambda raw: bytes(raw[:20]) + bytes([raw[20] ^ 1]) + bytes(raw[21:]), "CRC"),
        (lambda raw: _refit(raw[:6] + bytes([0x10]) + raw[7:]), "PUS version"),
    ],
)
def test_each_error_of_a_packet_is_reported(change, reason):
    with pytest.raises(packets.PacketError, match=reason):
        packets.parse(change(_tm()))


def test_every_flipped_bit_is_detected():
    raw = _tm()
    for bit in range(8 * len(raw)):
        broken = bytearray(raw)
        broken[bit // 8] ^= 0x80 >> bit % 8
        with pytest.raises(packets.PacketError):
            packets.parse(broken)


def test_splitter_accepts_any_division_of_the_stream():
    wanted = [build_tm(16, n, 17, 2, bytes(n % 50), 1, 0) for n in range(60)]
    stream = b"".join(wanted)
    random_source = random.Random(2)
    for _ in range(20):
        splitter, found, at = packets.Splitter(), [], 0
        while at < len(stream):
            size = random_source.randrange(1, 90)
            found += splitter.feed(stream[at : at + size])
            at += size
        assert found == wanted


def test_a_packet_that_is_too_large_is_refused():
    with pytest.raises(packets.PacketError, match="65542"):
        packets.build_tc(1, 0, 6, 2, bytes(65542))
    with pytest.raises(packets.PacketError, match="APID is 2048, expected 0 to 2047"):
        packets.build_tc(2048, 0, 17, 1)


@pytest.mark.parametrize(
    ("kind", "text", "expected"),
    [("UINT16", "0x1F", [31]), ("DOUBLE", "-0.5", [-0.5]), ("BOOL", "true", [True]), ("INT8", "-128", [-128])],
)
def test_words_become_values(kind, text, expected):
    assert values.from_text(kind, 1, text) == expected
    assert values.decode(kind, 1, values.encode(kind, expected), 0)[0] == expected


@pytest.mark.parametrize(("kind", "text"), [("UINT8", "256"), ("UINT8", "-1"), ("INT16", "40000"), ("FLOAT", "1e99")])
def test_values_that_do_not_fit_are_refused(kind, text):
    with pytest.raises(values.ValueProblem):
        values.encode(kind, values.from_text(kind, 1, text))


@pytest.mark.parametrize(("kind", "count", "text"), [("DOUBLE", 2, "1"), ("DOUBLE", 1, "x"), ("UINT8", 1, "1.5"), ("BOOL", 1, "2")])
def test_words_that_are_no_values_are_refused(kind, count, text):
    with pytest.raises(values.ValueProblem):
        values.from_text(kind, count, text)
