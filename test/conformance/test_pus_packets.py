# SPDX-License-Identifier: Apache-2.0
"""Packets and the independent implementation spacepackets (the peer), in both directions: a process of this project
(pus_process.c) accepts the requests of spacepackets, whose readers accept the reports of the process; pusdump
reads packets of spacepackets, and refuses those that it must refuse."""

import json
import os
import pathlib
import random
import struct
import subprocess

import pytest
from spacepackets import SpacePacketHeader
from spacepackets.ccsds.spacepacket import PacketType
from spacepackets.ccsds.time import CdsShortTimestamp
from spacepackets.ecss import PusTc, PusTm
from spacepackets.ecss.pus_1_verification import Service1Tm, UnpackParams
from spacepackets.ecss.pus_verificator import PusVerificator, StatusField

ROOT = pathlib.Path(__file__).resolve().parents[2]
PUSDUMP = ROOT / "build/bin/pusdump"
APID, TIME_SIZE = 16, 8
NOW_NS = (2_000_000_000 * 1_000_000_000) + 42_500_000_000
TIME = bytes.fromhex("1f0000002a800000")  # 42.5 s after the epoch of 1958.
LAYOUT = UnpackParams(TIME_SIZE, 2, 2)  # Octets of the time, of the step id and of the failure code.


class Process:
    """pus_process.c as a running program."""

    def __init__(self, program):
        self.run = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def say(self, line):
        """Send one line to the process. Returns the packets of its answer."""
        self.run.stdin.write(line + "\n")
        self.run.stdin.flush()
        return [bytes.fromhex(answer) for answer in iter(lambda: self.run.stdout.readline().strip(), ".")]

    def send(self, request):
        return self.say(bytes(request.pack()).hex())

    def end(self):
        self.run.stdin.close()
        assert self.run.wait(10) == 0


def build(path, *sources):
    """Build a program with sanitizers, from sources and from the project's libraries of `make test`; builds
    the libraries if necessary."""
    pus = sorted(f"pus_{directory.name}" for directory in (ROOT / "pus").iterdir() if directory.name not in ("catalogue", "tool"))
    libraries = [f"build/sanitize/lib/lib{name}.a" for name in (*pus, "base", "osal_posix")]
    quiet = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    subprocess.run(["make", "-s", "SANITIZE=1", *libraries], cwd=ROOT, env=quiet, check=True, stdout=subprocess.DEVNULL)
    sources = [*sources, ROOT / "test/support/assertion.c"]
    options = "-std=c99 -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -D_POSIX_C_SOURCE=200809L".split()
    group = ["-Wl,--start-group", *(ROOT / library for library in libraries), "-Wl,--end-group"]
    subprocess.run(["gcc", *options, f"-I{ROOT}", f"-I{ROOT}/build", "-o", path, *sources, *group, "-lm", "-lpthread"], check=True)
    return path


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    return build(tmp_path_factory.mktemp("pus") / "pus_process", ROOT / "test/conformance/pus_process.c")


@pytest.fixture
def process(program):
    running = Process(program)
    yield running
    running.end()


def request(service, subtype, data=b"", sequence=25, ack=15, source=1, apid=APID):
    return PusTc(service, subtype, apid=apid, app_data=data, seq_count=sequence, source_id=source, ack_flags=ack)


def crc(octets):
    value = 0xFFFF
    for octet in octets:
        value ^= octet << 8
        for _ in range(8):
            value = (value << 1 ^ (0x1021 if value & 0x8000 else 0)) & 0xFFFF
    return value


def with_checksum(octets):
    """The packet with a correct checksum in its last two octets."""
    return bytes(octets[:-2]) + struct.pack(">H", crc(octets[:-2]))


def dump(data, *options):
    """(objects, exit code) of pusdump --json; a text is encoded first."""
    data = data.encode() if isinstance(data, str) else data
    run = subprocess.run([PUSDUMP, "--json", *options], input=data, capture_output=True, timeout=300)
    assert run.stderr == b""
    return [json.loads(line) for line in run.stdout.splitlines()], run.returncode


# --- requests of the peer, our reports -----------------------------------------------------------------------------


def test_our_reports_are_read_by_the_peer(process):
    answers = [PusTm.unpack(octets, TIME_SIZE) for octets in process.send(request(17, 1, sequence=77, source=0x1234))]
    assert [(tm.service, tm.subservice) for tm in answers] == [(1, 1), (1, 3), (17, 2), (1, 7)]
    for number, tm in enumerate(answers):
        assert tm.apid == APID and tm.seq_count == number
        assert tm.pus_tm_sec_header.dest_id == 0x1234
        seconds, fraction = struct.unpack(">xI3s", tm.timestamp)
        assert seconds * 10**9 + int.from_bytes(fraction, "big") * 10**9 // 2**24 == NOW_NS


def check_time_packet(octets):
    """Check a spacecraft time packet with the peer's header: APID 0, no secondary header. Returns its time
    field."""
    header = SpacePacketHeader.unpack(octets)
    assert header.packet_type == PacketType.TM and header.apid == 0 and not header.sec_header_flag
    assert header.seq_count == 0 and len(octets) == header.data_len + 7 == 18 and crc(octets) == 0
    assert octets[6] == 2 and octets[15] == 1
    return octets[7:15]


def test_the_time_as_cuc_is_that_of_a_report(process):
    (packet,) = process.say("cuc")
    reference = PusTm.unpack(process.send(request(17, 1))[0], TIME_SIZE)
    assert check_time_packet(packet) == bytes(reference.timestamp)


def test_the_time_as_cds_is_read_by_the_peer(process):
    (packet,) = process.say("cds")
    field = check_time_packet(packet)
    stamp = CdsShortTimestamp.unpack(bytes([CdsShortTimestamp.empty().pfield[0]]) + field[:6])
    assert stamp.pack()[1:] == field[:6]
    ns = stamp.ccsds_days * 86400 * 10**9 + stamp.ms_of_day * 10**6 + int.from_bytes(field[6:], "big") * 1000
    assert ns == NOW_NS
    assert CdsShortTimestamp(stamp.ccsds_days, stamp.ms_of_day) == stamp


def test_the_peers_verificator_follows_a_request_to_its_end(process):
    verificator, tc = PusVerificator(), request(8, 1, b"SLOW\0\0\0\0\0", sequence=1234)
    assert verificator.add_tc(tc)
    results = [verificator.add_tm(Service1Tm.unpack(octets, LAYOUT)) for octets in process.send(tc)]
    assert not results[-1].completed and results[-1].status.started == StatusField.SUCCESS
    results = [verificator.add_tm(Service1Tm.unpack(octets, LAYOUT)) for octets in process.say("complete")]
    status = results[-1].status
    assert results[-1].completed and status.all_verifs_recvd
    assert (status.accepted, status.started, status.step, status.completed) == (StatusField.SUCCESS,) * 4
    assert status.step_list == [7]


@pytest.mark.parametrize(
    "tc, stage, code, instruction, detail",
    [
        # Failure codes: pus/core/tailoring.h.
        (request(99, 1), 2, 0x0105, 0, 99),  # PUS_FAILURE_SERVICE.
        (request(17, 9), 2, 0x0106, 0, 17 << 8 | 9),  # _SUBTYPE.
        (request(17, 1, b"\0"), 2, 0x0108, 0, 0),  # _DATA.
        (request(17, 1, apid=17), 2, 0x0104, 0, 17),  # _APID.
        (request(5, 6, b"\2\0\3"), 2, 0x0108, 0, 3),  # _DATA.
        (request(8, 1, b"SLOWLY\0\0\0"), 4, 0x0201, 0, int.from_bytes(b"SLOW", "big")),  # _UNKNOWN_ID.
        (request(5, 6, b"\1\0\4"), 4, 0x0201, 1, 4),  # _UNKNOWN_ID.
        (request(8, 1, b"BROKEN\0\0\0"), 8, 0x0406, 0, 250),  # _TIMEOUT.
    ],
)
def test_failure_notices_are_read_by_the_peer(process, tc, stage, code, instruction, detail):
    for ack in (0, 15):
        tc.pus_tc_sec_header.ack_flags = ack
        octets = process.send(tc)[-1]
        report = Service1Tm.unpack(octets, LAYOUT)
        assert report.subservice == stage and report.has_failure_notice
        assert report.error_code.val == code
        assert struct.unpack(">HI", report.failure_notice.data) == (instruction, detail)
        assert report.tc_req_id.as_u32() == struct.unpack(">I", bytes(tc.pack())[:4])[0]


@pytest.mark.parametrize("ack", range(16))
def test_each_acknowledgement_flag_requests_the_report_of_its_stage(process, ack):
    subtypes = [PusTm.unpack(octets, TIME_SIZE).subservice for octets in process.send(request(17, 1, ack=ack))]
    expected = [1] * bool(ack & 1) + [3] * bool(ack & 2) + [2] + [7] * bool(ack & 8)
    assert subtypes == expected


def test_parameter_values_and_events_are_read_by_the_peer(process):
    value = struct.pack(">BII", 1, 0x02020001, 0xCAFE0123)
    assert len(process.send(request(20, 3, value, ack=0))) == 0
    (report,) = process.send(request(20, 1, value[:5], ack=0))
    assert PusTm.unpack(report, TIME_SIZE).tm_data == b"\0" + value
    (event,) = process.say("raise")
    event = PusTm.unpack(event, TIME_SIZE)
    assert (event.service, event.subservice, event.tm_data) == (5, 3, bytes.fromhex("0003010203"))
    assert event.pus_tm_sec_header.dest_id == 0


def test_our_requests_are_read_by_the_peer(process):
    (octets,) = process.say("ask")
    tc = PusTc.unpack(octets)
    assert (tc.service, tc.subservice, tc.apid, tc.source_id) == (17, 1, 17, 0x8000 | APID)
    assert octets == bytes(PusTc(17, 1, apid=17, seq_count=0, source_id=0x8010, ack_flags=15).pack())


def test_malformed_requests_are_reported_by_code(process):
    good = bytes(request(17, 1).pack())
    cases = {
        0x010A: with_checksum(bytes([good[0] | 0x20]) + good[1:]),  # PUS_FAILURE_PACKET_VERSION.
        0x010B: with_checksum(bytes([good[0] & ~0x10]) + good[1:]),  # _PACKET_TYPE.
        0x010C: with_checksum(bytes([good[0] & ~0x08]) + good[1:]),  # _SECONDARY_HEADER.
        0x010D: with_checksum(good[:2] + bytes([good[2] & 0x3F]) + good[3:]),  # _SEQUENCE_FLAGS.
        0x0103: with_checksum(good[:6] + b"\x1f" + good[7:]),  # _PUS_VERSION.
        0x0101: good + b"\0",  # _LENGTH.
        0x0102: good[:-1] + bytes([good[-1] ^ 1]),  # _CHECKSUM.
    }
    for code, octets in cases.items():
        (answer,) = process.say(octets.hex())
        report = Service1Tm.unpack(answer, LAYOUT)
        assert (report.subservice, report.error_code.val) == (2, code)


def test_random_octets_cause_no_crash(process):
    rng = random.Random(1)
    for _ in range(300):
        octets = bytearray(request(rng.choice((5, 8, 17, 20)), rng.choice((1, 3, 5, 6)), rng.randbytes(20)).pack())
        for _ in range(rng.randrange(4)):
            octets[rng.randrange(len(octets))] = rng.randrange(256)
        for answer in process.say((with_checksum(octets) if rng.random() < 0.7 else octets).hex()):
            assert PusTm.unpack(answer, TIME_SIZE).apid == APID


# --- packets of the peer, our pusdump ------------------------------------------------------------------------------


def test_pusdump_reads_requests_of_the_peer():
    rng = random.Random(2)
    requests = [
        request(
            rng.randrange(1, 256),
            rng.randrange(1, 256),
            rng.randbytes(rng.choice((0, 1, 4083, rng.randrange(200)))),
            rng.randrange(16384),
            rng.randrange(16),
            rng.randrange(65536),
            rng.randrange(2047),
        )
        for _ in range(60)
    ]
    octets = [bytes(tc.pack()) for tc in requests]
    binary, code = dump(b"".join(octets))
    assert code == 0 and len(binary) == len(requests)
    lines, code = dump("".join(f"{number}.5 TC {one.hex()}\n" for number, one in enumerate(octets)))
    assert code == 0
    for number, (tc, found, line) in enumerate(zip(requests, binary, lines)):
        assert found["direction"] == "TC" and found["error"] is None and found["crc_ok"] is True
        assert (found["service"], found["subtype"]) == (tc.service, tc.subservice)
        assert (found["apid"], found["seq"], found["source"]) == (tc.apid, tc.seq_count, tc.source_id)
        assert (found["ack"], bytes.fromhex(found["data"])) == (tc.pus_tc_sec_header.ack_flags, tc.app_data)
        assert found["time_ns"] is None and line["log_time"] == f"{number}.5"
        assert {**line, "log_time": None, "location": None} == {**found, "location": None}


def test_pusdump_reads_reports_of_the_peer():
    rng = random.Random(3)
    for _ in range(30):
        tm = PusTm(
            service=rng.randrange(1, 256),
            subservice=rng.randrange(1, 256),
            timestamp=TIME,
            source_data=rng.randbytes(rng.randrange(100)),
            apid=rng.randrange(1, 2047),
            seq_count=rng.randrange(16384),
            message_counter=rng.randrange(65536),
            destination_id=rng.randrange(65536),
        )
        (found,), code = dump(bytes(tm.pack()).hex())
        assert code == 0 and found["direction"] == "TM" and found["time_ns"] == 42_500_000_000
        assert (found["apid"], found["seq"], found["destination"]) == (tm.apid, tm.seq_count, tm.pus_tm_sec_header.dest_id)
        assert (found["service"], found["subtype"]) == (tm.service, tm.subservice)
        assert found["counter"] == tm.pus_tm_sec_header.message_counter
        assert bytes.fromhex(found["data"]) == tm.tm_data


# --- the same octets for both decoders ----------------------------------------------------------------------------

# Errors that only pusdump reports: the peer reads these fields, but does not check them.
STRICTER = ("packet version", "sequence flags", "PUS version", "time code", "ends within the time", "no secondary header",
            "length field says")
DRAWN = 20_000
# Offset of the time code in a report. This octet is not changed: pusdump reads several time formats, the peer only the configured one.
TIME_CODE = 13


def drawn_packet(rng):
    """Draw a packet of the peer, change up to three octets, and sometimes cut or extend it; most packets get a correct checksum."""
    if rng.random() < 0.5:
        packet = request(rng.randrange(256), rng.randrange(256), rng.randbytes(rng.randrange(40)), rng.randrange(16384),
                         rng.randrange(16), rng.randrange(65536), rng.randrange(2047)).pack()
    else:
        packet = PusTm(rng.randrange(256), rng.randrange(256), timestamp=TIME, source_data=rng.randbytes(rng.randrange(40)),
                       apid=rng.randrange(2047), seq_count=rng.randrange(16384), message_counter=rng.randrange(65536),
                       destination_id=rng.randrange(65536)).pack()
    octets = bytearray(packet)
    for _ in range(rng.choice((0, 0, 1, 1, 2, 3))):
        octets[rng.randrange(min(len(octets), TIME_CODE))] = rng.randrange(256)
    if not octets[0] & 0x10 and len(octets) > TIME_CODE:
        octets[TIME_CODE] = TIME[0]
    if rng.random() < 0.1:
        octets = octets[:rng.randrange(7, len(octets))] if rng.random() < 0.5 else octets + rng.randbytes(rng.randrange(1, 4))
    return with_checksum(octets) if rng.random() < 0.9 else bytes(octets)


def read_by_peer(octets):
    """Fields of a packet as the peer reads them; None if it refuses the packet."""
    try:
        if octets[0] & 0x10:
            tc = PusTc.unpack(octets)
            return {"direction": "TC", "apid": tc.apid, "seq": tc.seq_count, "service": tc.service, "subtype": tc.subservice,
                    "source": tc.source_id, "ack": tc.pus_tc_sec_header.ack_flags, "data": bytes(tc.app_data).hex()}
        tm = PusTm.unpack(octets, TIME_SIZE)
        return {"direction": "TM", "apid": tm.apid, "seq": tm.seq_count, "service": tm.service, "subtype": tm.subservice,
                "destination": tm.pus_tm_sec_header.dest_id, "counter": tm.pus_tm_sec_header.message_counter,
                "data": bytes(tm.tm_data).hex()}
    except Exception:  # The peer refuses by exceptions of many classes, IndexError among them.
        return None


@pytest.mark.parametrize("seed", [1])
def test_both_decoders_read_the_same_fields_of_drawn_packets(seed):
    """The peer accepts each packet that pusdump accepts, and reads the same fields. A packet that only pusdump refuses breaks a rule
    of STRICTER."""
    rng = random.Random(seed)
    packets = [drawn_packet(rng) for _ in range(DRAWN)]
    found, _ = dump("".join(f"1.0 {'TC' if octets[0] & 0x10 else 'TM'} {octets.hex()}\n" for octets in packets))
    assert len(found) == DRAWN
    accepted, refused = 0, 0
    for octets, ours in zip(packets, found):
        peer = read_by_peer(octets)
        if ours["error"] is None:
            assert peer is not None and {name: ours[name] for name in peer} == peer, octets.hex()
            accepted += 1
        elif peer is not None:
            assert any(words in ours["error"] for words in STRICTER), (octets.hex(), ours["error"])
        else:
            refused += 1
    assert accepted > DRAWN // 5 and refused > DRAWN // 50


GOLDEN = """
1864 c019 0006 | 2f 11 01 0001 | ebe6
0864 c001 000f | 20 11 02 0001 0001 | 40 6249 02b32c95 | 7bf4
0864 c002 0010 | 20 11 02 0002 0001 | 2f 0000002a 800000 | e29d
1864 c048 001d | 2f 0b 04 0001 | 01 01 2f0000002a800000 1864c01900062f11010001ebe6 | 059c
0864 c00e 0018 | 20 01 02 0000 0001 | 40 6249 02b32c95 | 1864c019 0102 c0ffee | af1c
0000 c001 000a | 02 2f0000002a800000 | 3675
"""


def test_pusdump_reads_golden_packets():
    found, code = dump(GOLDEN.replace("|", ""))
    assert code == 0
    assert [packet["time_ns"] for packet in found] == [
        None,
        2_173_955_696_789_000_000,  # 2026-11-21T12:34:56.789
        42_500_000_000,
        None,
        2_173_955_696_789_000_000,
        42_500_000_000,
    ]
    assert [(packet["service"], packet["subtype"]) for packet in found[:5]] == [(17, 1), (17, 2), (17, 2), (11, 4), (1, 2)]
    text = subprocess.run([PUSDUMP], input=GOLDEN.replace("|", "").encode(), capture_output=True).stdout.decode()
    assert "TC 100 #25 [17,1] perform an are-you-alive connection test from 1 ack ASPC" in text
    assert "2026-11-21T12:34:56.789000000 TAI" in text and "spacecraft time packet" in text


def malformed():
    good = bytes(request(17, 1).pack())
    report = bytes(PusTm(17, 2, timestamp=TIME, apid=APID).pack())
    yield with_checksum(bytes([good[0] | 0x20]) + good[1:]), "packet version 1"
    for flags in range(3):
        yield with_checksum(good[:2] + bytes([good[2] & 0x3F | flags << 6]) + good[3:]), f"sequence flags {flags}"
    yield with_checksum(good[:6] + b"\x1f" + good[7:]), "PUS version 1"
    yield with_checksum(report[:6] + b"\x10" + report[7:]), "PUS version 1"
    yield with_checksum(bytes([good[0] & ~0x08]) + good[1:]), "no secondary header"
    yield with_checksum(good[:5] + b"\x07" + good[6:]), "length field says 14 octets, the packet has 13"
    yield with_checksum(good[:5] + b"\x05" + good[6:]), "length field says 12 octets, the packet has 13"
    yield good + b"\0", "length field says 13 octets, the packet has 14"
    yield good[:-1] + bytes([good[-1] ^ 1]), "checksum"
    yield with_checksum(report[:13] + b"\x50" + report[14:]), "time code 0x50"
    for size in range(1, len(good)):
        yield good[:size], "too few for a packet" if size < 6 else "length field"


@pytest.mark.parametrize("octets, words", list(malformed()))
def test_pusdump_reports_a_faulty_packet_in_one_line(octets, words):
    good = bytes(request(17, 1).pack())
    for text in (octets.hex(), f"1.25 {'TC' if octets[0] & 0x10 else 'TM'} {octets.hex()}"):
        found, code = dump(f"{good.hex()}\n{text}\n{good.hex()}\n")
        assert code == 1 and len(found) == 3
        assert words in found[1]["error"] and found[1]["location"] == "line 2"
        assert found[0]["error"] is None and found[2]["error"] is None
    run = subprocess.run([PUSDUMP], input=octets.hex().encode(), capture_output=True)
    assert run.returncode == 1 and run.stdout.count(b"\n") == 1 and words.encode() in run.stdout


def test_pusdump_reports_the_error_of_a_faulty_line():
    good = bytes(request(17, 1).pack()).hex()
    for line, words in (
        (good[:-1], "odd number"),
        (good + "x", "not a hexadecimal digit"),
        (f"1.0 TM {good}", "the line says TM, the packet is a TC"),
        (f"one TC {good}", "found time 'one', expected seconds such as 12.5"),
        ("1.0 TC ", "too few"),
        ("00" * 70000, "longer than any packet"),
    ):
        found, code = dump(line)
        assert code == 1 and len(found) == 1 and words in found[0]["error"], line[:40]
    found, code = dump(f"# nothing\n\n   \n{good}\r\n")
    assert code == 0 and len(found) == 1
    assert dump("") == ([], 0)
    found, code = dump(f"{good}\n", "--format", "log")
    assert code == 1 and "not a line of a packet log" in found[0]["error"]


def test_pusdump_accepts_the_options_of_its_usage_and_refuses_others(tmp_path):
    tm = bytes(PusTm(17, 2, timestamp=TIME, apid=APID).pack())
    path = tmp_path / "packets"
    path.write_bytes(tm * 3)
    assert dump(tm.hex(), "--epoch", "42")[0][0]["time_ns"] == 500_000_000
    assert dump(tm.hex(), "--epoch", "43")[0][0]["time_ns"] == -500_000_000
    assert len(dump(b"", str(path))[0]) == 3
    assert len(dump(tm, str(path), "-")[0]) == 4
    for options in (["--no-such"], ["--format", "text"], ["--format"], ["--epoch", "-1"], [str(tmp_path / "none")]):
        run = subprocess.run([PUSDUMP, *options], stdin=subprocess.DEVNULL, capture_output=True)
        assert run.returncode == 2 and run.stdout == b"" and run.stderr.startswith(b"pusdump: ")
    run = subprocess.run([PUSDUMP, "--help"], capture_output=True)
    assert run.returncode == 0 and b"usage: pusdump" in run.stdout


def test_pusdump_decodes_fields_it_knows():
    (found,), _ = dump(bytes(request(129, 1, b"\5").pack()).hex())
    assert found["fields"] == {"target": 5} and found["name"] == "request a state"
    create = bytes.fromhex("0009 00000004 01 02010002 01 0002 02 02000001 02090003")
    (found,), _ = dump(bytes(request(3, 1, create).pack()).hex())
    assert found["fields"] == {
        "structure": 9,
        "interval": 4,
        "parameters": [{"id": "0x02010002"}],
        "sets": [{"repetitions": 2, "parameters": [{"id": "0x02000001"}, {"id": "0x02090003"}]}],
    }
    report = PusTm(1, 8, timestamp=TIME, source_data=bytes.fromhex("1810c019 0406 0001 000000fa"), apid=APID)
    (found,), _ = dump(bytes(report.pack()).hex())
    assert found["fields"]["request"] == {"apid": 16, "seq": 25} and found["fields"]["meaning"] == "time-out"
    networks = bytes.fromhex("0002 0001 0002 0010 0011 0000 0002 0000 0001 0007")
    (found,), _ = dump(bytes(PusTm(131, 11, timestamp=TIME, source_data=networks, apid=1).pack()).hex())
    assert found["fields"]["networks"] == [
        {"network": 1, "members": [{"apid": 16}, {"apid": 17}], "links": []},
        {"network": 2, "members": [], "links": [{"link": 7}]},
    ]
    (found,), code = dump(bytes(request(129, 1, b"\5\5").pack()).hex())
    assert code == 0 and found["fields"] is None and found["data"] == "0505"


# --- random input, our pusdump -------------------------------------------------------------------------------------


def any_packet(rng):
    """A packet of a message that pusdump knows, with random data, sometimes damaged."""
    # Service: highest subtype that is drawn.
    services = {1: 10, 3: 35, 5: 8, 8: 1, 17: 4, 20: 3, 129: 6, 130: 10, 131: 11}
    service = rng.choice(list(services))
    subtype = rng.randrange(1, services[service] + 1)
    size = rng.choice((0, 1, 2, 3, 8, 20, 52, rng.randrange(300)))
    data = bytes(rng.choice((0, 1, 2, 3, rng.randrange(256))) for _ in range(size))
    if rng.random() < 0.5:
        octets = bytes(request(service, subtype, data).pack())
    else:
        octets = bytes(PusTm(service, subtype, timestamp=TIME, source_data=data, apid=APID).pack())
    if rng.random() < 0.3:
        octets = bytearray(octets)
        octets[rng.randrange(len(octets))] = rng.randrange(256)
        octets = with_checksum(octets) if rng.random() < 0.5 else bytes(octets)
    return octets[: rng.randrange(len(octets))] if rng.random() < 0.05 else octets


def any_input(rng):
    kind = rng.randrange(5)
    if kind == 0:
        return rng.randbytes(rng.randrange(5000))
    if kind == 1:
        return b"".join(any_packet(rng) for _ in range(30))
    if kind == 2:
        words = (b"", b"1.5 TC ", b"x TM ", b"2.0 TM ")
        return b"\n".join(rng.choice(words) + any_packet(rng).hex().encode() for _ in range(60))
    if kind == 3:
        return bytes(rng.choice(b"0123456789abcdefABCDEF \t\r\n#TCM.\0zx") for _ in range(rng.randrange(5000)))
    return rng.randbytes(rng.randrange(200_000))


def test_pusdump_does_not_crash_on_any_input(tmp_path):
    sanitized = build(tmp_path / "pusdump", *sorted((ROOT / "pus/tool").glob("*.c")))
    rng = random.Random(4)
    for _ in range(120):
        options = rng.choice(([], ["--format", "hex"], ["--format", "log"], ["--format", "binary"]))
        run = subprocess.run([sanitized, "--json", *options], input=any_input(rng), capture_output=True, timeout=300)
        assert run.stderr == b"" and run.returncode in (0, 1)
        found = [json.loads(line) for line in run.stdout.splitlines()]
        assert run.returncode == any(packet["error"] is not None for packet in found)
        for packet in found:
            assert packet.keys() >= {"direction", "apid", "service", "subtype", "seq", "time_ns", "crc_ok", "error"}
            assert ("source" in packet) != ("destination" in packet)
