# SPDX-License-Identifier: Apache-2.0
"""Requests made by spacepackets and puslib are performed in flight, and both libraries read the answers of
the flight, including their times.

These two agree with this project on the order of the flags that request verification, but other libraries do
not; therefore the tests request no verification or all of it."""

import struct

import pytest
from hirosco_gse import packets
from hirosco_gse.session import Request
from puslib import CucTime, PusTcPacket, PusTmPacket
from spacepackets.ecss import PusTc, PusTm

USER, TIME_SIZE, ALL, NONE = 2, 8, 0xF, 0x0
SUPERVISOR, JOYSTICK = 1, 17
STATUS = SUPERVISOR << 21 | 24 << 16  # The first parameter of the supervisor, a structure.


def by_spacepackets(apid, sequence, service, subtype, data, ack):
    tc = PusTc(service, subtype, apid=apid, app_data=data, seq_count=sequence, source_id=USER, ack_flags=ack)
    return bytes(tc.pack())


def by_puslib(apid, sequence, service, subtype, data, ack):
    tc = PusTcPacket.create(
        apid=apid, name=sequence, ack_flags=ack, service_type=service, service_subtype=subtype, source=USER, data=data or None
    )
    return tc.serialize()


MAKERS = {"spacepackets": by_spacepackets, "puslib": by_puslib}


@pytest.fixture(params=sorted(MAKERS))
def maker(request):
    return MAKERS[request.param]


def carry_out(station, maker, apid, service, subtype, data=b""):
    """Send a third-party request, which must equal that of the ground segment octet by octet, and wait for its completion.
    Returns its outcome."""
    sequence = station.session.sequence(apid)
    raw = maker(apid, sequence, service, subtype, data, ALL)
    assert raw == packets.build_tc(apid, sequence, service, subtype, data, USER)
    verification = station.session.send_raw(raw, Request(apid, service, subtype, data, f"third-party TC[{service},{subtype}]"))
    outcome = station.settle(verification)
    assert outcome.is_completed, outcome.failure.words(station.dictionary)
    return outcome


def test_third_party_requests_are_performed(station, maker):
    answers = {
        (17, 1): (carry_out(station, maker, SUPERVISOR, 17, 1), (17, 2)),
        (20, 1): (carry_out(station, maker, SUPERVISOR, 20, 1, struct.pack(">BI", 1, STATUS)), (20, 2)),
        (3, 27): (carry_out(station, maker, SUPERVISOR, 3, 27, struct.pack(">BH", 1, 1)), (3, 25)),
    }
    for outcome, message in answers.values():  # TM[3,25] is a bulk report, which may arrive after the completion of its request.
        assert message in [packet.message for packet, _ in outcome.replies] or message == (3, 25)


def test_a_third_party_schedule_with_a_third_party_request_is_released(station, maker):
    station.ask("SUPERVISOR", 17, 1)
    station.do("SUPERVISOR", 11, 3)
    station.do("SUPERVISOR", 11, 23, n=[])
    station.do("SUPERVISOR", 11, 22, n=[{"group_id": 1, "group_status": "enabled"}])
    due_ns = station.dictionary.epoch_ns + round((station.now() + 60.0) * 10**9)
    inner = maker(JOYSTICK, 77, 17, 1, b"", NONE)
    data = struct.pack(">BBB", 1, 1, 1) + packets.encode_time(due_ns) + inner  # Sub-schedule, number of activities, group.
    since = len(station.reports)
    carry_out(station, maker, SUPERVISOR, 11, 4, data)
    station.do("SUPERVISOR", 11, 20, n=[1])
    station.do("SUPERVISOR", 11, 1)
    packet, _ = station.report(17, 2, apid=JOYSTICK, since=since)
    assert packet.time_ns >= due_ns - 10**6
    station.do("SUPERVISOR", 11, 2)
    station.do("SUPERVISOR", 11, 3)
    station.do("SUPERVISOR", 11, 23, n=[])


def test_a_request_without_acknowledgement_flags_gets_only_its_answer(station, maker):
    raw = maker(SUPERVISOR, station.session.sequence(SUPERVISOR), 17, 1, b"", NONE)
    since = len(station.reports)
    station.session.send_raw(raw, Request(SUPERVISOR, 17, 1, b"", "third-party TC[17,1]"))
    station.report(17, 2, apid=SUPERVISOR, since=since)
    station.fence(SUPERVISOR)
    reported = [packet for packet, _ in station.reports[since:] if packet.service == 1 and packet.data[:4] == raw[:4]]
    assert not reported


def test_reports_are_read_with_their_times(station):
    station.ask("SUPERVISOR", 17, 1)
    station.do("SUPERVISOR", 3, 27, n=[1])
    has_secondary_header = 0x08  # In the first octet. Time packets have none.
    reports = [packet for packet, _ in station.reports if packet.raw[0] & has_secondary_header]
    for packet in reports[-200:]:
        ours = (packet.apid, packet.sequence, packet.service, packet.subtype, packet.counter, packet.user, packet.data)
        peer = PusTm.unpack(packet.raw, TIME_SIZE)
        header = peer.pus_tm_sec_header
        theirs = (peer.apid, peer.seq_count, peer.service, peer.subservice, header.message_counter, header.dest_id, bytes(peer.tm_data))
        assert theirs == ours
        other = PusTmPacket.deserialize(packet.raw, cuc_time=CucTime(0, 0, 4, 3))
        theirs = (other.apid, other.seq_count, other.service, other.subservice, other.counter, other.destination, other.source_data or b"")
        assert theirs == ours
        seconds, fraction = other.time.time_field
        assert bytes(other.time) == packet.raw[13:21]
        assert abs(seconds * 10**9 + fraction * 10**9 / 2**24 - packet.time_ns) <= 1
