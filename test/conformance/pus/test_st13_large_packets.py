# SPDX-License-Identifier: Apache-2.0
"""ST[13] in flight: packets longer than 4096 octets, sent in parts in both directions. spacepackets makes and
reads the packets, and this file assembles them; other tests show that the ground segment can do both."""

import random
import struct

import pytest
from hirosco_gse import packets
from hirosco_gse.session import Request
from spacepackets.ecss import PusTc, PusTm

USER, TIME_SIZE, ALL = 2, 8, 0xF
SUPERVISOR, MANIPULATOR, JOYSTICK = 1, 16, 17
LARGE, UPLINKS, PART = 65542, 4, 512
OUT_OF_RANGE, UNKNOWN_ID, TABLE_FULL, EMBEDDED = 0x0203, 0x0201, 0x0205, 0x020A
TIMEOUT, DISCONTINUITY, NOT_ACCEPTED = "reception timeout", "sequence discontinuity", "request not accepted"


def _request(apid, service, subtype, data=b"", sequence=99, source=USER):
    tc = PusTc(service, subtype, apid=apid, app_data=data, seq_count=sequence, source_id=source, ack_flags=ALL)
    return bytes(tc.pack())


def _fields(transaction, number, octets):
    return {"large_message_transaction_id": transaction, "part_sequence_number": number, "part": octets.hex()}


def _pieces(raw, size):
    """(subtype, number, octets) of the parts of a request."""
    cut = [raw[at : at + size] for at in range(0, len(raw), size)]
    return [(9 if n == 1 else 11 if n == len(cut) else 10, n, octets) for n, octets in enumerate(cut, 1)]


def _uplink(station, raw, transaction, size):
    """Send all parts of a request, each of which must complete. Returns the stages of the request itself,
    with the code of its failure."""
    since = len(station.reports)
    for subtype, number, octets in _pieces(raw, size):
        station.do("SUPERVISOR", 13, subtype, **_fields(transaction, number, octets))
    return _verified(station, raw, since)


def _verified(station, raw, since):
    def is_reported():
        found = [packet for packet, _ in station.reports[since:] if packet.service == 1 and packet.data[:4] == raw[:4]]
        return found if any(packet.subtype in (2, 4, 7, 8, 10) for packet in found) else None

    found = station.wait(is_reported, "verification of what came in parts")
    codes = [struct.unpack_from(">H", packet.data, 4)[0] for packet in found if packet.subtype in (2, 4, 8, 10)]
    return [packet.subtype for packet in found], codes


def _aborted(station, transaction, reason, since):
    packet, decoded = station.report(13, 16, apid=SUPERVISOR, since=since)
    assert (decoded["large_message_transaction_id"], decoded["failure_reason"]) == (transaction, reason)
    theirs = PusTm.unpack(packet.raw, TIME_SIZE)
    number = {TIMEOUT: 1, DISCONTINUITY: 2, NOT_ACCEPTED: 3}[reason]
    assert (theirs.service, theirs.subservice, bytes(theirs.tm_data)) == (13, 16, struct.pack(">HB", transaction, number))


def _downlink(station, since):
    """Octets of the report whose parts have arrived since this index, decoded by spacepackets."""
    for subtype in (1, 2, 3):
        station.report(13, subtype, apid=SUPERVISOR, since=since)
    reported = [PusTm.unpack(packet.raw, TIME_SIZE) for packet, _ in station.reports[since:] if packet.message in ((13, 1), (13, 2), (13, 3))]
    heads = [struct.unpack_from(">HH", bytes(part.tm_data)) for part in reported]
    assert [number for _, number in heads] == list(range(1, len(reported) + 1)) and len({transaction for transaction, _ in heads}) == 1
    assert [part.subservice for part in reported] == [1] + [2] * (len(reported) - 2) + [3]
    assert all(len(part.tm_data) == 4 + PART for part in reported[:-1])
    return b"".join(bytes(part.tm_data)[4:] for part in reported)


@pytest.mark.parametrize("parameter", ["STATUS", "COUNTERS"])
def test_a_long_report_arrives_in_parts(station, parameter):
    since = len(station.reports)
    name = f"SUPERVISOR.{parameter}"
    answer = station.ask("SUPERVISOR", 20, 1, n=[name] * 255)
    whole = PusTm.unpack(_downlink(station, since), TIME_SIZE)
    size = station.dictionary.subsystem("SUPERVISOR").parameter(parameter).size
    assert (whole.apid, whole.service, whole.subservice, len(whole.tm_data)) == (SUPERVISOR, 20, 2, 2 + 255 * (4 + size))
    data = bytes(whole.tm_data)
    entries = {data[at : at + 4 + size] for at in range(2, len(data), 4 + size)}
    assert data[:2] == b"\0\xff" and len(entries) == 1  # All values are of one instant.
    assert answer["values"].keys() == station.ask("SUPERVISOR", 20, 1, n=[name])["values"].keys() == {parameter}


def test_a_long_schedule_is_loaded(station):
    station.do("SUPERVISOR", 11, 3)
    due = station.now() + 1e6
    activities = [{"group_id": 1, "release_time": due, "request": _request(JOYSTICK, 17, 1, sequence=n).hex()} for n in range(250)]
    station.do("SUPERVISOR", 11, 22, n=[{"group_id": 1, "group_status": "enabled"}])
    data = station.catalogue.encode("TC", 11, 4, {"sub_schedule_id": 1, "n": activities})
    raw = _request(SUPERVISOR, 11, 4, data)
    assert len(raw) > packets.PACKET_MAX
    assert _uplink(station, raw, 1, 2000) == ([1, 3, 7], [])
    assert len(station.ask("SUPERVISOR", 11, 17)["n"]) == 250
    station.do("SUPERVISOR", 11, 3)
    station.do("SUPERVISOR", 11, 4, sub_schedule_id=1, n=activities)  # The ground segment splits the request.
    assert len(station.ask("SUPERVISOR", 11, 17)["n"]) == 250
    station.do("SUPERVISOR", 11, 3)
    station.do("SUPERVISOR", 11, 23, n=[])


def test_a_long_procedure_and_a_long_sequence_are_loaded(station, tmp_path):
    code = b"-- long\n" * 1500
    name = {"obcp_id": "LONG"}
    station.do("SUPERVISOR", 18, 1, **name, obcp_code=code.hex(), checksum=packets.crc16(code))
    assert name in [{"obcp_id": entry["obcp_id"]} for entry in station.ask("SUPERVISOR", 18, 8)["n"]]
    station.do("SUPERVISOR", 18, 2, **name)
    (tmp_path / "long.lua").write_bytes(code)
    assert "completed" in station.command("procedure", "load", "LONG", tmp_path / "long.lua")
    station.command("procedure", "unload", "LONG")
    entries = [{"request": _request(JOYSTICK, 17, 1, sequence=n).hex(), "delay": 0.5} for n in range(255)]
    station.do("SUPERVISOR", 21, 1, request_sequence_id="LONG", n=entries)
    assert station.ask("SUPERVISOR", 21, 11, request_sequence_id="LONG")["n"] == entries
    station.do("SUPERVISOR", 21, 3, request_sequence_id="LONG")


def test_the_longest_request_is_received_completely(station):
    raw = _request(SUPERVISOR, 17, 1, bytes(LARGE - 13))
    # TC[17,1] has no data, but all parts have arrived.
    assert _uplink(station, raw, 2, 4079) == ([2], [0x0108])


def test_parts_are_routed_and_permitted_like_any_request(station):
    assert _uplink(station, _request(MANIPULATOR, 17, 1), 3, 7) == ([1, 3, 7], [])
    assert _uplink(station, _request(MANIPULATOR, 8, 1, b"MOVE_TO\0"), 4, 7) == ([2], [0x0110])
    assert _uplink(station, _request(99, 17, 1), 5, 7) == ([10], [0x0001])


def test_parts_of_several_transactions_may_be_interleaved(station):
    raws = [_request(JOYSTICK, 17, 1, sequence=number) for number in range(UPLINKS)]
    rows = zip(*(_pieces(raw, 5) for raw in raws))
    since = len(station.reports)
    for row in rows:
        for transaction, (subtype, number, octets) in enumerate(row):
            station.do("SUPERVISOR", 13, subtype, **_fields(transaction, number, octets))
    assert all(_verified(station, raw, since) == ([1, 3, 7], []) for raw in raws)


def test_a_request_for_another_subsystem_has_at_most_one_packet(station):
    raw, since = _request(MANIPULATOR, 17, 1, bytes(packets.PACKET_MAX - 12)), len(station.reports)
    station.refuse(TABLE_FULL, "SUPERVISOR", 13, 9, **_fields(6, 1, raw[:600]))
    _aborted(station, 6, NOT_ACCEPTED, since)
    # The ground segment splits the request.
    whole = station.settle(station.send_data(MANIPULATOR, 20, 1, bytes(5000)))
    assert [failure.code for failure in whole.failures] == [TABLE_FULL]
    assert whole.failure.detail == packets.PACKET_MAX


@pytest.mark.parametrize("wrong", [0, 1, 2, 4, 65535])
def test_a_part_out_of_sequence_ends_its_transaction(station, wrong):
    station.do("SUPERVISOR", 13, 9, **_fields(7, 1, b"ab"))
    station.do("SUPERVISOR", 13, 10, **_fields(7, 2, b"cd"))
    since = len(station.reports)
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 13, 11 if wrong == 4 else 10, **_fields(7, wrong, b"ef"))
    _aborted(station, 7, DISCONTINUITY, since)
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 13, 10, **_fields(7, 3, b"ef"))


def test_a_first_part_begins_its_transaction_again(station):
    raw = _request(JOYSTICK, 17, 1)
    station.do("SUPERVISOR", 13, 9, **_fields(8, 1, b"other"))
    since = len(station.reports)
    assert _uplink(station, raw, 8, 7) == ([1, 3, 7], [])
    _aborted(station, 8, DISCONTINUITY, since)


def test_faulty_parts_of_a_large_packet_are_refused(station):
    refuse = lambda code, subtype, *part: station.refuse(code, "SUPERVISOR", 13, subtype, **_fields(*part))
    refuse(OUT_OF_RANGE, 9, 9, 0, b"ab")
    refuse(OUT_OF_RANGE, 9, 9, 2, b"ab")
    refuse(OUT_OF_RANGE, 9, 9, 1, b"")
    refuse(UNKNOWN_ID, 10, 9, 2, b"ab")
    refuse(UNKNOWN_ID, 11, 9, 2, b"ab")
    station.do("SUPERVISOR", 13, 9, **_fields(9, 1, b"ab"))
    since = len(station.reports)
    refuse(OUT_OF_RANGE, 10, 9, 2, b"")
    _aborted(station, 9, NOT_ACCEPTED, since)


def test_a_large_packet_must_be_a_request_of_its_sender(station):
    good = _request(SUPERVISOR, 17, 1)
    torn, other_source, nested = good[:-1], _request(SUPERVISOR, 17, 1, source=1), _request(SUPERVISOR, 13, 9, b"\0\1\0\1x")
    report = bytes(PusTm(17, 2, bytes(8), apid=SUPERVISOR).pack())
    for raw in (torn, good[:-1] + bytes([good[-1] ^ 1]), other_source, nested, report, b"0123456789", b"01234567890123"):
        (_, _, first), (_, _, last) = _pieces(raw, len(raw) - 1)
        # Octets that are not a length field give too large a length.
        if int.from_bytes(first[4:6], "big") + 7 > packets.PACKET_MAX:
            station.refuse(TABLE_FULL, "SUPERVISOR", 13, 9, **_fields(10, 1, first))
            continue
        station.do("SUPERVISOR", 13, 9, **_fields(10, 1, first))
        since = len(station.reports)
        station.refuse(EMBEDDED, "SUPERVISOR", 13, 11, **_fields(10, 2, last))
        _aborted(station, 10, NOT_ACCEPTED, since)


def test_the_number_of_large_packets_in_reception_is_limited(station):
    for transaction in range(UPLINKS):
        station.do("SUPERVISOR", 13, 9, **_fields(100 + transaction, 1, b"ab"))
    outcome = station.refuse(TABLE_FULL, "SUPERVISOR", 13, 9, **_fields(200, 1, b"ab"))
    assert outcome.failure.detail == UPLINKS
    since = len(station.reports)
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 13, 10, **_fields(100, 9, b"ab"))
    _aborted(station, 100, DISCONTINUITY, since)
    since = len(station.reports)
    for transaction in range(1, UPLINKS):  # The other uploads are aborted when no further part arrives.
        found = lambda decoded, wanted=100 + transaction: decoded["large_message_transaction_id"] == wanted
        _, decoded = station.report(13, 16, since=since, where=found)
        assert decoded["failure_reason"] == TIMEOUT
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 13, 10, **_fields(101, 2, b"ab"))


def test_a_large_packet_is_received_after_random_parts(station):
    rng = random.Random(13)
    sent = []
    for _ in range(200):
        subtype, transaction, number = rng.choice((9, 10, 11)), rng.randrange(6), rng.choice((0, 1, 1, 2, 2, 3, 0xFFFF))
        data = struct.pack(">HH", transaction, number) + rng.randbytes(rng.choice((0, 1, 6, 13, 400, 4000)))
        request = Request(SUPERVISOR, 13, subtype, data, "a part at random")
        sent.append(station.session.send(request))
    for verification in sent:
        station.settle(verification)
    for transaction in range(6):  # End the transfers that are left over.
        station.settle(station.send("SUPERVISOR", 13, 10, **_fields(transaction, 0xFFFF, b"x")))
    assert not station.session.malformed
    assert _uplink(station, _request(JOYSTICK, 17, 1), 1, 7) == ([1, 3, 7], [])
