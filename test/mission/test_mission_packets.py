# SPDX-License-Identifier: Apache-2.0
"""Every packet of a flight, checked by independent decoders and by the rules of verification and states."""

import collections
import itertools
import json
import struct
import subprocess

import dissection
import flying
import pytest
from database_reading import check
from flat_xtce import Flattened
from hirosco_gse import packets as packet_format
from hirosco_gse.dictionary import Dictionary
from spacepackets import ecss
from spacepackets.ccsds import PacketType, SpacePacketHeader
from spacepackets.ecss import check_pus_crc
from spacepackets.ecss.pus_1_verification import Service1Tm, Subservice, UnpackParams

TIME_OCTETS = 8
EPOCH_NS = 2_159_006_400_000_000_000  # 2026-06-01T12:00:00 TAI since 1958
ACK_ACCEPTANCE, ACK_START, ACK_COMPLETION = 0x1, 0x2, 0x8
SUPERVISOR, COMMUNICATION, MANIPULATOR, JOYSTICK = 1, 2, 16, 17
SUBSYSTEMS = {"SUPERVISOR": 1, "COMMUNICATION": 2, "MANIPULATOR": 16, "JOYSTICK": 17}
CYCLE_NS = 500_000
# The table of states: state -> states that may follow it in TM[129,2].
NEXT = {
    0: {1},
    1: {2, 9, 0},
    2: {3, 8},
    3: {3, 4, 6, 7},
    4: {4, 5, 3, 6, 7},
    5: {5, 4, 6},
    6: {6, 7},
    7: {3, 8},
    8: {9},
    9: {0},
}

Seen = collections.namedtuple("Seen", "time_ns direction apid sequence service subtype user ack data raw")


def _independent(time_ns, direction, raw):
    """The packet as PyPI spacepackets decodes it; raises an exception if it is malformed."""
    header = SpacePacketHeader.unpack(raw)
    assert check_pus_crc(raw), "CRC"
    assert header.packet_type == (PacketType.TC if direction == "TC" else PacketType.TM)
    assert header.packet_len == len(raw)
    if direction == "TC":
        packet = ecss.PusTc.unpack(raw)
        secondary = packet.pus_tc_sec_header
        return Seen(
            time_ns, direction, packet.apid, packet.seq_count, packet.service, packet.subservice,
            secondary.source_id, int(secondary.ack_flags), bytes(packet.app_data), raw,
        )  # fmt: skip
    packet = ecss.PusTm.unpack(raw, timestamp_len=TIME_OCTETS)
    secondary = packet.pus_tm_sec_header
    return Seen(
        time_ns, direction, packet.apid, packet.seq_count, packet.service, packet.subservice,
        secondary.dest_id, 0, bytes(packet.tm_data), raw,
    )  # fmt: skip


@pytest.fixture(scope="module")
def flight(shared_flights):
    """The flight whose packets are checked."""
    return shared_flights.flight()


@pytest.fixture(scope="module")
def packets(flight):
    """All packets, read by the independent decoder."""
    return [_independent(*packet) for packet in flight.packets]


def test_wireshark_dissects_every_packet_to_the_values_of_the_ground(flight, tmp_path):
    dictionary = Dictionary.load(flying.ROOT / "build/generated/rokviss.json")
    script = flying.ROOT / "build/generated/rokviss.lua"
    compared = dissection.compare(script, tmp_path / "packets.pcap", [raw for _, _, raw in flight.packets], dictionary)
    assert all(compared[title] for title in ("TC[8,1]", "TM[1,7]", "TM[3,25]", "TM[5,1]", "TM[129,2]", "TM[130,9]")), compared


def _reports(packets, service, subtype, apid=None):
    return [p for p in packets if p.direction == "TM" and (p.service, p.subtype) == (service, subtype) and apid in (None, p.apid)]


def _requests(packets, service, subtype, apid=None):
    return [p for p in packets if p.direction == "TC" and (p.service, p.subtype) == (service, subtype) and apid in (None, p.apid)]


def test_all_packets_decode_independently(packets):
    assert len(packets) > 1000
    assert {packet.apid for packet in packets} == set(SUBSYSTEMS.values())


def test_verification_reports_decode_as_service_1(packets):
    count = 0
    for packet in packets:
        if packet.direction == "TM" and packet.service == 1 and packet.subtype != 10:
            report = Service1Tm.unpack(packet.raw, UnpackParams(TIME_OCTETS, 2, 2))
            assert report.pus_tm.subservice == Subservice(packet.subtype)
            assert report.tc_req_id.pack() == packet.data[:4]
            count += 1
    assert count > 200


def test_all_reports_read_the_same_by_the_database(packets, tmp_path):
    """The generated XTCE file and space_packet_parser give the same values as the project's ground
    segment."""
    generated = flying.ROOT / "build" / "generated"
    dictionary = Dictionary.load(generated / "rokviss.json")
    definition = Flattened(generated / "rokviss.xtce.xml").definition(tmp_path)
    compared = collections.Counter()
    for packet in packets:
        if packet.direction == "TM":
            compared[packet.service] += check(definition, packet_format.parse(packet.raw), dictionary)
    assert compared[1] > 200 and compared[3] > 200 and compared[5] > 3 and compared[129] > 200 and compared[130] > 10, compared


def test_pusdump_reads_all_and_agrees(flight, packets):
    plain = subprocess.run([flying.PUSDUMP, flight.directory / "packets.log"], capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert plain.returncode == 0, plain.stderr
    assert len(plain.stdout.splitlines()) == len(packets)
    dumped = subprocess.run([flying.PUSDUMP, "--json", flight.directory / "packets.log"], capture_output=True, text=True, timeout=flying.MOMENT_S)
    assert dumped.returncode == 0, dumped.stderr
    for line, packet in zip(dumped.stdout.splitlines(), packets, strict=True):
        row = json.loads(line)
        assert row["crc_ok"] is True
        assert row["error"] is None
        user = row["source" if packet.direction == "TC" else "destination"]
        found = (row["direction"], row["apid"], row["service"], row["subtype"], row["seq"], user)
        assert found == (packet.direction, packet.apid, packet.service, packet.subtype, packet.sequence, packet.user)


def test_packet_time_is_epoch_and_simulated_time(packets):
    """A report has the time at which it was made, at most a few time steps before it was logged."""
    for packet in packets:
        if packet.direction == "TM":
            seconds, fraction = int.from_bytes(packet.raw[14:18], "big"), int.from_bytes(packet.raw[18:21], "big")
            assert packet.raw[13] == 0x1F, "explicit P-field"
            made_ns = seconds * 10**9 + fraction * 10**9 // 2**24 - EPOCH_NS
            assert -1000 <= packet.time_ns - made_ns <= 4 * CYCLE_NS, packet


def test_sequence_counts_have_no_gaps(packets):
    """Counts are per APID and direction; for telecommands also per source, because each source has its own
    count."""
    expected = collections.defaultdict(int)
    for packet in packets:
        key = (packet.direction, packet.apid, packet.user if packet.direction == "TC" else None)
        assert packet.sequence == expected[key], f"{key}: {packet}"
        expected[key] = (packet.sequence + 1) & 0x3FFF
    assert len(expected) >= 12


def test_message_counters_have_no_gaps(packets):
    """The message type counter is per APID, type and destination."""
    expected = collections.defaultdict(int)
    for packet in packets:
        if packet.direction == "TM":
            key = (packet.apid, packet.service, packet.subtype, packet.user)
            counter = int.from_bytes(packet.raw[9:11], "big")
            assert counter == expected[key], f"{key}: {counter}"
            expected[key] = (counter + 1) & 0xFFFF


def _chains(packets):
    """[(request, [its verification reports])]; a request id occurs again after 16384 requests at the
    earliest."""
    chains, open_chains = [], {}
    for packet in packets:
        if packet.direction == "TC":
            chain = (packet, [])
            chains.append(chain)
            open_chains[packet.raw[:4], packet.user] = chain
        elif packet.service == 1:
            open_chains[packet.data[:4], packet.user][1].append(packet)
    return chains


def test_every_request_is_verified_to_its_end(packets):
    """Each request has acceptance, start and completion as requested, once and in this order; or a failure
    and no report after it."""
    chains = _chains(packets)
    assert len(chains) > 100
    for request, reports in chains:
        stages = [report.subtype for report in reports]
        failures = [stage for stage in stages if stage in (2, 4, 6, 8, 10)]
        if failures:
            assert len(failures) == 1, (request, stages)
            assert stages[-1] == failures[0], (request, stages)
        else:
            wanted = [1] * bool(request.ack & ACK_ACCEPTANCE) + [3] * bool(request.ack & ACK_START) + [7] * bool(request.ack & ACK_COMPLETION)
            assert [stage for stage in stages if stage != 5] == wanted, (request, stages)
            if 5 in stages:
                assert stages.index(5) > stages.index(3)
                assert stages[-1] == 7
        assert [report.time_ns for report in reports] == sorted(report.time_ns for report in reports)
        assert all(report.time_ns >= request.time_ns for report in reports)


def test_the_addressee_sends_the_verification_and_the_supervisor_sends_the_refusal(packets):
    for request, reports in _chains(packets):
        for report in reports:
            if report.subtype in (2, 10):
                assert report.apid in (SUPERVISOR, request.apid)
            else:
                assert report.apid == request.apid, (request, report)


def test_progress_steps_are_the_states_passed(packets):
    """TM[1,5] has the number of the state that was just entered."""
    states = {}
    for packet in packets:
        if packet.direction != "TM":
            continue
        if (packet.service, packet.subtype) == (129, 2):
            states[packet.apid] = packet.data[1]
        if (packet.service, packet.subtype) == (1, 5):
            assert int.from_bytes(packet.data[4:6], "big") == states[packet.apid], packet


@pytest.mark.parametrize("name", SUBSYSTEMS)
def test_transitions_follow_the_table(packets, name):
    state = 0
    transition_reports = _reports(packets, 129, 2, SUBSYSTEMS[name])
    assert transition_reports
    for report in transition_reports:
        previous, now = report.data[0], report.data[1]
        assert previous == state, report
        assert now in NEXT[previous] or now == previous, f"{previous} -> {now} at {report.time_ns / 1e9} s"
        state = now
    if name != "SUPERVISOR":  # The last report of the supervisor is the last packet of the log.
        assert state == 0


@pytest.mark.parametrize("name", ["MANIPULATOR", "JOYSTICK"])
def test_status_reports_the_state_of_the_last_transition(packets, name):
    """TM[129,5] comes every second and never contradicts the reported transitions."""
    apid, state, times = SUBSYSTEMS[name], 0, []
    for packet in packets:
        if packet.direction == "TM" and packet.apid == apid and packet.service == 129:
            if packet.subtype == 2:
                state = packet.data[1]
            elif packet.subtype == 5:
                assert packet.data[0] == state, packet
                times.append(packet.time_ns)
    assert 90 <= len(times) <= 98
    assert max(b - a for a, b in itertools.pairwise(times)) <= 1_050_000_000


def test_operation_is_refused_before_the_links(packets):
    """TM[1,2] with code 0x0111 from APID 1 contains consumer and port: MANIPULATOR, HAND_POSITION (2)."""
    found = [r for r in _reports(packets, 1, 2, SUPERVISOR) if r.data[4:6] == b"\x01\x11"]
    assert len(found) == 1
    request = next(q for q, reports in _chains(packets) if found[0] in reports)
    assert (request.apid, request.service, request.subtype, request.data) == (MANIPULATOR, 129, 1, b"\x04")  # State 4: SAFE_OPERATIONAL.
    _, detail = struct.unpack(">HI", found[0].data[6:12])
    assert detail == MANIPULATOR << 16 | 2
    opened = [p.time_ns for p in _requests(packets, 130, 3)]
    assert found[0].time_ns < min(opened)


def test_refusals_are_those_of_the_scenario(packets):
    codes = [report.data[4:6].hex() for report in _reports(packets, 1, 2)]
    assert sorted(codes) == ["0110", "0111", "0113"]  # PUS_FAILURE_PERMISSION, _LINK_MISSING, _MEMBER_ACTIVE.


def _events(packets, subtype, apid=None):
    return [(p.time_ns, p.apid, int.from_bytes(p.data[:2], "big")) for p in _reports(packets, 5, subtype, apid)]


def test_every_high_event_takes_both_members_to_error_operational(packets):
    high = _events(packets, 4)
    assert [(apid, event) for _, apid, event in high] == [(JOYSTICK, 1), (MANIPULATOR, 1)]
    for time_ns, _, _ in high:
        for apid in (MANIPULATOR, JOYSTICK):
            delays_ns = [p.time_ns - time_ns for p in _reports(packets, 129, 2, apid) if p.data[1] == 6 and p.time_ns >= time_ns]
            assert delays_ns, apid
            assert delays_ns[0] <= 5_000_000
            secured = [p for p in _reports(packets, 129, 2, apid) if p.time_ns >= time_ns and p.data[1] == 6][1]
            assert secured.data[2] == 7, "expected phase SECURED"  # The phase of the transition.
            offline = [p.time_ns for p in _reports(packets, 129, 2, apid) if p.data[1] == 0 and p.time_ns > time_ns]
            assert offline[0] - time_ns <= 1_000_000_000, "expected OFFLINE by the plan within 1 s"


def test_the_subsystem_in_error_goes_first(packets):
    """TM[129,2] to ERROR_OPERATIONAL comes before the HIGH event of the same subsystem, in the same cycle."""
    for event in _reports(packets, 5, 4):
        own = [p for p in _reports(packets, 129, 2, event.apid) if p.data[1] == 6 and p.data[0] != 6 and abs(p.time_ns - event.time_ns) <= CYCLE_NS]
        assert len(own) == 1
        assert own[0].sequence < event.sequence
        assert own[0].raw[13:21] == event.raw[13:21], "expected both reports in the same cycle"


def test_medium_event_leads_to_safe_operational(packets):
    medium = _events(packets, 3)
    assert [(apid, event) for _, apid, event in medium] == [(MANIPULATOR, 3)]
    time_ns = medium[0][0]
    after = [p for p in _reports(packets, 129, 2, MANIPULATOR) if p.time_ns >= time_ns]
    assert (after[0].data[0], after[0].data[1]) == (5, 4)
    assert after[0].time_ns - time_ns <= 4 * CYCLE_NS
    joystick = [p for p in _reports(packets, 129, 2, JOYSTICK) if time_ns <= p.time_ns <= time_ns + 10**9]
    assert not joystick, "expected no transition of the other member"


def test_low_event_changes_nothing(packets):
    low = [(time_ns, apid) for time_ns, apid, event in _events(packets, 2, MANIPULATOR) if event == 9]
    assert len(low) == 1
    time_ns, apid = low[0]
    later = [p for p in packets if p.direction == "TM" and time_ns <= p.time_ns <= time_ns + 200_000_000]
    assert not [p for p in later if (p.service, p.subtype) in ((129, 2), (131, 2), (130, 10))]
    assert not [p for p in packets if p.direction == "TC" and p.user & 0x8000 and time_ns <= p.time_ns <= time_ns + 200_000_000]
    assert apid == MANIPULATOR


HK_4711_OCTETS = 2 + 4 + 5 * 16 + 2 * 2 + 4 + 5 * 16  # structure, STATE, five pairs, STATUSWORD, LINK_AGE, samples


def test_housekeeping_has_five_samples_and_is_sent_every_500_cycles(packets):
    """Structure 4711 of the arm in telepresence: CUR_VALUES and LINK_AGE once, DES_POSITION five times, every
    250 ms."""
    reports = [p for p in _reports(packets, 3, 25, MANIPULATOR) if p.data[:2] == struct.pack(">H", 4711)]
    flown = [p for p in reports if 6.5e9 < p.time_ns < 63.9e9]
    assert len(flown) == pytest.approx(57.4 / 0.25, abs=1)
    for report in flown:
        assert len(report.data) == HK_4711_OCTETS
    gaps = {b.time_ns - a.time_ns for a, b in itertools.pairwise(flown)}
    assert gaps == {500 * CYCLE_NS}


def test_housekeeping_samples_move_with_the_hand(packets):
    """The five samples are taken 100 cycles apart: during the circle all differ, and the last sample is the
    newest."""
    moving = [p for p in _reports(packets, 3, 25, MANIPULATOR) if p.data[:2] == struct.pack(">H", 4711) and 9.5e9 < p.time_ns < 17e9]
    steps = []
    for report in moving:
        samples = [struct.unpack(">dd", report.data[-80 + 16 * n :][:16]) for n in range(5)]
        assert len(set(samples)) == 5
        steps += [abs(a[0] - b[0]) + abs(a[1] - b[1]) for a, b in itertools.pairwise(samples)]
    assert len(steps) > 100
    # Each joint moves by 0.19 rad at 0.5 Hz, so at up to 0.6 rad/s: 30 mrad from one sample to the next (50 ms). The sum of both joints changes
    # by 0.03 to 0.043 rad.
    assert 0.02 < sum(steps) / len(steps) < 0.05


def test_links_open_at_both_ends_and_in_order(packets):
    """TM[130,10] contains link, previous and new state: requested, accepted, then open (3) at producer and
    consumer."""
    for link in (1, 2):
        for apid in (MANIPULATOR, JOYSTICK):
            states = [p.data[3] for p in _reports(packets, 130, 10, apid) if p.data[:2] == struct.pack(">H", link)]
            assert states.count(3) == 3, "expected three openings in this flight"
            assert states[-1] == 0
            assert [b for a, b in itertools.pairwise(states) if a == 3] == [0, 0, 0]


LINK_ROW = struct.Struct(">HBHHHH IIBIHBBI IIIII".replace(" ", ""))
COUNTS = ("sent", "received", "lost", "late", "last_sequence")


def _link_rows(report):
    """{link: (state, producer, consumer, {counter: value})} of a TM[130,9]."""
    rows = {}
    for fields in LINK_ROW.iter_unpack(report.data[2:]):
        rows[fields[0]] = fields[1], fields[2], fields[4], dict(zip(COUNTS, fields[-5:], strict=True))
    return rows


def test_links_lose_nothing_by_the_counts_of_both_ends(packets):
    """The consumer has received all samples that the producer had sent when they reported, within 12 samples."""
    at = [p for p in _reports(packets, 130, 9) if 63.4e9 < p.time_ns < 63.6e9]
    rows = {p.apid: _link_rows(p) for p in at}
    assert {MANIPULATOR, JOYSTICK} <= rows.keys()
    for link, (state, producer, consumer, _) in rows[MANIPULATOR].items():
        sent, received = rows[producer][link][3], rows[consumer][link][3]
        assert state == 3
        assert sent["sent"] == pytest.approx((63.5 - 2.5) * 2000, abs=40)
        assert abs(sent["sent"] - received["received"]) <= 12, (link, sent, received)
        assert received["lost"] == 0
    assert set(rows[MANIPULATOR]) == {1, 2}


def test_processes_report_their_interface(flight, packets):
    """The hash in TM[129,5] of each subsystem equals the hash of the ground's dictionary."""
    dictionary = json.loads((flying.ROOT / "build" / "generated" / "rokviss.json").read_text(encoding="utf-8"))
    wanted = {item["apid"]: int(str(item["interface_hash"]), 0) for item in dictionary["subsystems"]}
    for apid, interface in wanted.items():
        reports = _reports(packets, 129, 5, apid)
        assert reports
        assert {int.from_bytes(p.data[5:13], "big") for p in reports} == {interface}


def test_all_packets_have_a_known_type(packets):
    known = {
        (1, 1), (1, 2), (1, 3), (1, 4), (1, 5), (1, 7), (1, 8), (3, 10), (3, 25), (5, 1), (5, 2), (5, 3), (5, 4), (17, 2), (20, 2),
        (129, 2), (129, 5), (130, 2), (130, 4), (130, 9), (130, 10), (131, 2), (131, 4), (131, 9), (131, 11),
    }  # fmt: skip
    assert {(p.service, p.subtype) for p in packets if p.direction == "TM"} <= known
