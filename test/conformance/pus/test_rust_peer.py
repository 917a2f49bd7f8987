# SPDX-License-Identifier: Apache-2.0
"""The Rust crate spacepackets reads the reports of a flight (headers, checksum and time), and the flight
performs requests that the crate makes.

The library is that of the bench (test/bench/peers/spacepackets), which is built if the machine has cargo."""

import ctypes
import struct

import pytest
from flying import ROOT
from hirosco_gse import packets
from hirosco_gse.session import Request

LIBRARY = ROOT / "build/peers/spacepackets/target/release/libcodec_spacepackets.so"
pytestmark = [pytest.mark.long, pytest.mark.skipif(not LIBRARY.exists(), reason="not built: no cargo")]

USER, SUPERVISOR, JOYSTICK = 2, 1, 17
STATUS = SUPERVISOR << 21 | 24 << 16  # Id of the first parameter of the supervisor: APID, type (24: a structure), number 0.
READ, NO_PACKET, WRONG_CHECKSUM = 1, 0, -1  # Results of spacepackets_read.


class Report(ctypes.Structure):
    """`Report` of test/bench/peers/spacepackets/src/lib.rs."""

    _fields_ = [("apid", ctypes.c_uint16), ("sequence", ctypes.c_uint16), ("service", ctypes.c_uint8), ("subtype", ctypes.c_uint8),
                ("counter", ctypes.c_uint16), ("user", ctypes.c_uint16), ("time_status", ctypes.c_uint8), ("seconds", ctypes.c_uint32),
                ("fraction", ctypes.c_uint32), ("data_offset", ctypes.c_uint32), ("data_size", ctypes.c_uint32)]


class Peer:
    """The crate, called by the functions of the library."""

    def __init__(self):
        self._library = ctypes.CDLL(str(LIBRARY))
        self._library.spacepackets_read.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(Report)]
        self._library.spacepackets_make.restype = ctypes.c_size_t
        self._library.spacepackets_make.argtypes = [ctypes.c_uint16] * 3 + [ctypes.c_uint8] * 2 + [ctypes.c_char_p, ctypes.c_size_t] * 2

    def read(self, raw):
        """Read a packet. Returns the result and the content."""
        report = Report()
        return self._library.spacepackets_read(raw, len(raw), ctypes.byref(report)), report

    def make(self, apid, count, service, subtype, data):
        """Make a request that asks for all verification reports."""
        buffer = ctypes.create_string_buffer(packets.PACKET_MAX)
        size = self._library.spacepackets_make(apid, count, USER, service, subtype, data, len(data), buffer, len(buffer))
        return buffer.raw[:size]


@pytest.fixture(scope="module")
def peer():
    return Peer()


def _carry_out(station, peer, apid, service, subtype, data=b""):
    """Send a request that the peer has made, and wait for its end."""
    count = station.session.sequence(apid)
    raw = peer.make(apid, count, service, subtype, data)
    assert raw == packets.build_tc(apid, count, service, subtype, data, USER)
    verification = station.session.send_raw(raw, Request(apid, service, subtype, data, f"TC[{service},{subtype}] of the peer"))
    outcome = station.settle(verification)
    assert outcome.is_completed, outcome.failure.words(station.dictionary)
    assert outcome.stages == [1, 3, 7]
    return [packet.message for packet, _ in outcome.replies]


def test_requests_of_the_peer_are_performed(station, peer):
    assert (17, 2) in _carry_out(station, peer, SUPERVISOR, 17, 1)
    assert (17, 2) in _carry_out(station, peer, JOYSTICK, 17, 1)
    assert (20, 2) in _carry_out(station, peer, SUPERVISOR, 20, 1, struct.pack(">BI", 1, STATUS))
    _carry_out(station, peer, SUPERVISOR, 3, 27, struct.pack(">BH", 1, 1))


def test_a_request_of_the_peer_that_contains_another_is_scheduled(station, peer):
    # Reset the schedule, delete all groups, create group 1.
    for subtype, data in ((3, b""), (23, b"\0"), (22, b"\1\1\1")):
        _carry_out(station, peer, SUPERVISOR, 11, subtype, data)
    inner = peer.make(JOYSTICK, 77, 17, 1, b"")
    due = packets.encode_time(station.dictionary.epoch_ns + 10**15)
    _carry_out(station, peer, SUPERVISOR, 11, 4, struct.pack(">BBB", 1, 1, 1) + due + inner)
    (activity,) = station.ask("SUPERVISOR", 11, 16)["n"]
    assert activity["request"] == inner.hex()
    for subtype, data in ((3, b""), (23, b"\0")):
        _carry_out(station, peer, SUPERVISOR, 11, subtype, data)


def test_reports_are_read_by_the_peer(station, peer):
    station.do("SUPERVISOR", 3, 27, n=[1])
    station.ask("JOYSTICK", 17, 1)
    reports = [packet for packet, _ in station.reports[-200:] if packet.apid != 0]
    assert {packet.message for packet in reports} >= {(1, 1), (1, 7), (3, 25), (17, 2)}
    for packet in reports:
        how, fields = peer.read(packet.raw)
        assert how == READ
        theirs = (fields.apid, fields.sequence, fields.service, fields.subtype, fields.counter, fields.user)
        assert theirs == (packet.apid, packet.sequence, packet.service, packet.subtype, packet.counter, packet.user)
        assert packet.raw[fields.data_offset : fields.data_offset + fields.data_size] == packet.data
        assert abs(fields.seconds * 10**9 + fields.fraction * 10**9 / 2**24 - packet.time_ns) <= 1
        assert fields.time_status == packet.raw[6] & 0xF


def test_a_report_that_was_damaged_is_not_read(station, peer):
    station.ask("SUPERVISOR", 17, 1)
    raw = station.report(17, 2, apid=SUPERVISOR)[0].raw
    for place in range(6, len(raw)):
        damaged = bytearray(raw)
        damaged[place] ^= 0x40
        assert peer.read(bytes(damaged))[0] in (WRONG_CHECKSUM, NO_PACKET)
    assert peer.read(raw[:-1])[0] == NO_PACKET
