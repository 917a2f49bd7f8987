# SPDX-License-Identifier: Apache-2.0
"""Recorded octets decoded to text: each form of input, and input that is damaged at each place."""

import io
import json
import struct

import cantools
import pytest
from conftest import ROOT
from hirosco_gse import decode, frames, packets
from hirosco_gse.cli import main
from tm_packets import build_tm

MANIPULATOR, PORT = 16, 10015


@pytest.fixture
def shown(dictionary_path, capsys):
    """decode(*words) -> (exit code, lines, error)."""

    def run(*words):
        code = main(["--dictionary", str(dictionary_path), "--port", str(PORT), "decode", *map(str, words)])
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return code, out.splitlines(), err

    return run


@pytest.fixture
def telemetry(dictionary):
    """Four reports of MANIPULATOR: status, housekeeping, an event, and a failed start of execution."""
    manipulator = dictionary.subsystem("MANIPULATOR")
    values = struct.pack(">H", 4711) + bytes(manipulator.parameter("CUR_VALUES").size) + struct.pack(">10d", *range(10))
    limit = manipulator.event("TORQUE_LIMIT")
    tc = packets.build_tc(MANIPULATOR, 5, 17, 1)
    data = [
        (129, 5, struct.pack(">BBBHQQII", 5, 0, 5, 1, 0, 0, 0, 0)),
        (3, 25, values),
        (5, 3, struct.pack(">HBdd", limit.id, 1, 39.5, 38.0)),
        (1, 4, tc[:4] + struct.pack(">HHI", 0x0204, 0, 0x0305)),  # PUS_FAILURE_STATE.
    ]
    return [build_tm(MANIPULATOR, number, *item, 1, dictionary.epoch_ns + 1_500_000_000) for number, item in enumerate(data)]


def test_telecommands_in_hexadecimal_are_decoded(shown):
    move = b"MOVE_TO\0" + struct.pack(">BHddHd", 2, 1, 0.5, -0.25, 2, 2.0)
    for request, words in [
        ((16, 8, 1, move), "TC[8,1]    to MANIPULATOR: MOVE_TO POSITION=[0.5, -0.25] rad  DURATION=2 s"),
        ((16, 129, 1, b"\x05"), "TC[129,1]  to MANIPULATOR: request a state  state=OPERATIONAL"),
        ((17, 129, 3, b"\0\2"), "TC[129,3]  to JOYSTICK: select a configuration  configuration=TELEPRESENCE"),
        ((16, 129, 8, b"\x06\x03"), "TC[129,8]  to MANIPULATOR: order a state  state=ERROR_OPERATIONAL  cause=plan"),
        ((1, 131, 1, b"\0"), "TC[131,1]  to SUPERVISOR: set the mode  mode=SAFE"),
        ((1, 131, 3, b"\1"), "TC[131,3]  to SUPERVISOR: switch the packet log  strategy=SQLITE"),
        ((1, 131, 6, b"\0\x11"), "TC[131,6]  to SUPERVISOR: start a process  subsystem=JOYSTICK"),
        ((1, 130, 3, struct.pack(">IHHHHH", 7, 0, 17, 1, 16, 2)), "TC[130,3]  to SUPERVISOR: request a link  transaction=7  link=HAND_POSITION"),
        ((16, 17, 1, b""), "TC[17,1]   to MANIPULATOR: perform an are-you-alive connection test"),
        ((16, 8, 1, b"DANCE\0\0\0\0"), "no function of MANIPULATOR 'DANCE'"),
        ((16, 129, 1, b""), "TC[129,1] cannot be decoded"),
        ((16, 250, 1, b""), "not in the catalogue of messages"),
        ((999, 8, 1, move), "to APID 999: TC[8,1] cannot be decoded"),
    ]:
        apid, service, subtype, data = request
        code, lines, _ = shown(packets.build_tc(apid, 5, service, subtype, data).hex())
        assert code == 0 and words in lines[0], lines


def test_telemetry_has_names_units_and_words(shown, telemetry, tmp_path):
    (tmp_path / "tm.txt").write_text("\n".join(raw.hex(" ") for raw in telemetry) + "\n\n", encoding="ascii")
    code, lines, _ = shown(tmp_path / "tm.txt")
    assert code == 0 and len(lines) == 4
    assert "    1.500000  TM[129,5]  MANIPULATOR: status  state=OPERATIONAL" in lines[0] and "configuration=STAND_ALONE" in lines[0]
    assert "POSITION: [0, 0] rad" in lines[1] and "DES_POSITION=[[0, 1], [2, 3], [4, 5], [6, 7], [8, 9]] rad" in lines[1]
    assert lines[2].endswith("MANIPULATOR: MEDIUM TORQUE_LIMIT  JOINT=1  TORQUE=39.5 Nm  LIMIT=38 Nm")
    assert "request 5 to MANIPULATOR start failed: refused at start of execution: not allowed in the present state" in lines[3]


def test_json_has_the_values(dictionary_path, telemetry, capsys):
    assert main(["--dictionary", str(dictionary_path), "--json", "decode", "".join(raw.hex() for raw in telemetry)]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert rows[1]["content"]["values"]["DES_POSITION"][0] == [0, 1] and rows[2]["content"]["values"]["LIMIT"] == [38.0]
    assert [row["packet"] for row in rows] == ["TM[129,5]", "TM[3,25]", "TM[5,3]", "TM[1,4]"]


def test_the_packet_log_of_a_run_is_decoded(shown, telemetry, tmp_path):
    """The log has a malformed telecommand as it was received; the run may have ended in the middle of a
    line."""
    wrong = bytearray(packets.build_tc(MANIPULATOR, 5, 17, 1))
    wrong[-1] ^= 1
    log = f"0.031000000 TC {wrong.hex()}\n0.032000000 TM {telemetry[0].hex()}\n0.033000000 TM 080"
    (tmp_path / "packets.log").write_text(log, encoding="ascii")
    code, lines, _ = shown(tmp_path / "packets.log")
    assert code == 0 and len(lines) == 2
    assert lines[0].startswith("    0.031000  malformed packet: CRC is wrong") and lines[1].startswith("    0.032000  TM[129,5]")


FRAMES = """(0000000025.170055) robot 191#3706414B4C00F4FF
(0000000025.170060) robot 191##1FF06404B4C00F4FF
(0000000025.170065) robot 711#05
(0000000025.170070) robot 591#4360600001000000
(0000000025.170075) robot 080#
(0000000025.170080) robot 7E5#0102
(0000000025.170085) robot 091#1023010000000000
"""


def test_a_log_of_candump_is_decoded_as_by_cantools(shown, dictionary_path, tmp_path):
    """The values equal those of cantools with the same database."""
    (tmp_path / "bus.log").write_text(FRAMES + "(0000000025.1", encoding="ascii")
    code, lines, _ = shown(tmp_path / "bus.log")
    assert code == 0 and len(lines) == 7
    statusword = "OPERATION_ENABLED+VOLTAGE_ENABLED+REMOTE+TARGET_REACHED"  # 0x0637
    assert lines[0] == f"   25.170055  robot JOINT1_TPDO1  Statusword={statusword}  PositionActualValue=5 rad  TorqueActualValue=-0.12 Nm"
    assert lines[2].endswith("JOINT1_HEARTBEAT  State=Operational") and "Initiate upload" in lines[3]
    assert lines[4].endswith("robot SYNC") and lines[5].endswith("0x7E5 (not in the database of the bus)  01 02")
    assert "Code=Over current" in lines[6]
    path = dictionary_path.parent / "rokviss-robot.dbc"
    own, reference = frames.Database(path), cantools.database.load_file(path)
    for identifier, octets in ((0x191, bytes.fromhex("3706404B4C00F4FF")), (0x091, bytes.fromhex("1023010000000000")), (0x591, bytes.fromhex("4360600001000000"))):
        expected = reference.decode_message(identifier, octets, allow_truncated=True)
        name, found = own.decode(identifier, octets)
        assert name == reference.get_message_by_frame_id(identifier).name
        assert {signal: value if isinstance(value, str) else pytest.approx(value) for signal, value, _ in found} == {
            signal: getattr(value, "name", value) for signal, value in expected.items()}


def _pcap(link_type, records, order="<", magic=0xA1B2C3D4):
    head = struct.pack(f"{order}IHHiIII", magic, 2, 4, 0, 0, 65535, link_type)
    return head + b"".join(struct.pack(f"{order}IIII", 2, 500000, len(item), len(item)) + item for item in records)


def _pcapng(link_type, records):
    def block(kind, body):
        body += bytes(-len(body) % 4)
        return struct.pack("<II", kind, len(body) + 12) + body + struct.pack("<I", len(body) + 12)

    ticks = 2_500_000_000
    found = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)) + block(1, struct.pack("<HHI", link_type, 0, 0) + struct.pack("<HHB3x", 9, 1, 9))
    for item in records:
        found += block(6, struct.pack("<IIIII", 0, ticks >> 32, ticks & 0xFFFFFFFF, len(item), len(item)) + item)
    return found + block(5, bytes(12))


def _segment(sequence, payload, ports=(PORT, 40000), version=4):
    tcp = struct.pack(">HHIIBBHHH", *ports, sequence, 0, 5 << 4, 0x18, 0, 0, 0) + payload
    if version == 6:
        return struct.pack(">IHBB", 6 << 28, len(tcp), 6, 64) + bytes(32) + tcp
    return struct.pack(">BBHHHBBH8x", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0) + tcp


@pytest.mark.parametrize(("link_type", "head", "version"), [(1, bytes(12) + b"\x08\0", 4), (0, bytes(4), 4), (101, b"", 6), (113, bytes(16), 4), (276, bytes(20), 4)])
def test_a_capture_of_the_ground_port_is_decoded(shown, telemetry, tmp_path, link_type, head, version):
    """Packets are in several segments, one of which is sent twice; another connection of the machine is
    ignored."""
    octets = b"".join(telemetry)
    parts = [(1000, octets[:30]), (1030, octets[30:90]), (1030, octets[30:90]), (1090, octets[90:])]
    segments = [head + _segment(sequence, part, version=version) for sequence, part in parts]
    segments.insert(1, head + _segment(7, b"GET / HTTP/1.1", ports=(80, 41000), version=version))
    for name, content in (("a.pcap", _pcap(link_type, segments)), ("a.pcapng", _pcapng(link_type, segments))):
        (tmp_path / name).write_bytes(content)
        code, lines, err = shown(tmp_path / name)
        assert code == 0, err
        assert [line.split()[1] for line in lines] == ["TM[129,5]", "TM[3,25]", "TM[5,3]", "TM[1,4]"] and lines[0].startswith("    2.500000")


def test_a_segment_that_the_capture_does_not_have_is_counted(shown, telemetry, tmp_path):
    lost = _segment(1000, telemetry[0][:20]), _segment(1020 + len(telemetry[0]), telemetry[2])
    (tmp_path / "a.pcap").write_bytes(_pcap(101, lost))
    code, lines, _ = shown(tmp_path / "a.pcap")
    assert code == 0 and f"{len(telemetry[0])} octets of the connection are missing" in lines[0] and "TM[5,3]" in lines[1]


def test_captures_of_packets_and_of_a_bus_are_decoded(shown, telemetry, tmp_path):
    (tmp_path / "packets.pcap").write_bytes(_pcap(147, telemetry, ">", 0xA1B23C4D))
    assert len(shown(tmp_path / "packets.pcap")[1]) == 4
    frame = struct.pack(">IB3x", 0x711, 1) + b"\x05"
    (tmp_path / "can-robot.pcap").write_bytes(_pcap(227, [frame, struct.pack(">IB3x", 0x40000711, 0), b"\0"]))
    code, lines, _ = shown(tmp_path / "can-robot.pcap")
    assert code == 0 and lines == ["    2.500000  robot JOINT1_HEARTBEAT  State=Operational"]


TM = "0.1 TM 0802c0\n"


@pytest.mark.parametrize(("name", "content", "words"), [
    ("h", b"1810\n18 1x\n", ["h:1: found 2 octets at octet 0, expected 6 of a whole packet"]),
    ("h", b"\n18 1x\n", ["h:2: found 'x' in '18 1x', expected an even number of hexadecimal digits"]),
    ("h", b"181\n", ["h:1: found 3 digits"]),
    ("h", b"1\n", ["h:1: found 1 digit, expected"]),
    ("h", b"18\n", ["h:1: found 1 octet at octet 0"]),
    ("h", b"1810c00000ff00\n", ["h:1: found 7 octets at octet 0, expected 262 of a whole packet"]),
    ("h", b"\x00\xff\x01", ["h: offset 1: found octet 0xFF, expected packets.log"]),
    ("packets.log", b"0.031000000 TC 18\n0.03 TC zz\nx\n", ["packets.log:2: not a packet line: '0.03 TC zz", "expected <seconds, 9 decimals> TC|TM", "remove the line"]),
    ("c.log", b"(1.0) robot 191#00\n(1.0) robot 191\n(2.0", ["c.log:2: found '(1.0) robot 191', expected (seconds) bus id#octets"]),
    ("c.log", b"(1.0) mars 191#00\n", ["c.log:1: found bus 'mars', expected a bus of mission rokviss: robot, joystick", "--dictionary"]),
    ("p.pcap", _pcap(1, [])[:10], ["p.pcap: offset 0: found 10 octets, expected 24; the capture was cut"]),
    ("p.pcap", _pcap(1, [bytes(60)])[:-1], ["p.pcap: offset 40: found 59 octets, expected 60"]),
    ("p.pcap", _pcap(1, [])[:] + b"123", ["p.pcap: offset 24: found 3 octets, expected 16"]),
    ("p.pcap", _pcap(9, [b"1"]), ["p.pcap: offset 24: found link type 9, expected 147 (packets), 227 (CAN) or of TCP"]),
    ("p.pcap", _pcap(147, [b"\x18\x10\xc0"]), ["p.pcap: offset 24: found 3 octets at octet 0"]),
    ("mars.pcap", _pcap(227, [bytes(8)]), ["mars.pcap: offset 24: found bus 'mars'"]),
    ("p.pcapng", _pcapng(1, [bytes(60)])[:-3], ["p.pcapng: offset", "the capture was cut"]),
    ("p.pcapng", _pcapng(1, [])[:28] + struct.pack("<IIII", 6, 16, 0, 16), ["p.pcapng: offset 36: found 4 octets, expected 20"]),
    ("p.pcapng", _pcapng(1, [])[:28] + struct.pack("<III", 1, 12, 12), ["p.pcapng: offset 36: found 0 octets, expected 8"]),
    ("p.pcapng", _pcapng(1, [])[:28] + struct.pack("<IIIIIIII", 6, 32, 3, 0, 0, 0, 0, 32), ["p.pcapng: offset 28: found interface 3"]),
])
def test_the_message_about_damaged_input_names_the_place(shown, tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    code, _, err = shown(tmp_path / name)
    assert code == 1 and all(word in err for word in words), err


def test_another_interface_than_that_of_the_recording_is_reported(shown, dictionary_path, dictionary, tmp_path):
    """run.json in the same directory contains the flown interface; a bus database contains the configuration
    hash of its descriptors."""
    (tmp_path / "can-robot.log").write_text(FRAMES, encoding="ascii")
    (tmp_path / "packets.log").write_text(f"0.031000000 TC {packets.build_tc(MANIPULATOR, 5, 17, 1).hex()}\n", encoding="ascii")
    facts = {name: dictionary.content[name].lower() for name in ("interface_hash", "configuration_hash")}
    (tmp_path / "run.json").write_text(json.dumps(facts), encoding="utf-8")
    for name, count in (("can-robot.log", 7), ("packets.log", 1)):
        assert len(shown(tmp_path / name)[1]) == count
    (tmp_path / "run.json").write_text(json.dumps({"interface_hash": "0x00000000000000aa", "configuration_hash": "0x00000000000000bb"}), encoding="utf-8")
    code, lines, _ = shown(tmp_path / "can-robot.log")
    assert code == 0 and len(lines) == 9, lines
    assert "run.json: the flight had interface 0x00000000000000aa, the dictionary has " + dictionary.interface_hash in lines[0]
    assert lines[1].startswith("warning: rokviss-robot.dbc: made from other descriptors than those that flew, configuration 0x00000000000000bb")
    assert len(shown(tmp_path / "packets.log")[1]) == 2
    (tmp_path / "run.json").unlink()
    database = (dictionary_path.parent / "rokviss-robot.dbc").read_text(encoding="utf-8")
    (tmp_path / "rokviss-robot.dbc").write_text(database.replace(dictionary.configuration_hash, "0x00000000000000CC"), encoding="utf-8")
    found = list(decode.rows([str(tmp_path / "can-robot.log")], dictionary, tmp_path, PORT))
    assert ["warning" in row for row in found] == [True] + 7 * [False]
    assert "made from other descriptors than the dictionary" in found[0]["text"]


@pytest.mark.parametrize(("content", "is_told"), [("{", True), ("[1]", True), ('{"interface_hash": null}', True), ("{}", False)])
def test_a_damaged_run_json_does_not_stop_the_decoder(shown, tmp_path, content, is_told):
    (tmp_path / "run.json").write_text(content, encoding="utf-8")
    (tmp_path / "can-robot.log").write_text(FRAMES, encoding="ascii")
    lines = shown(tmp_path / "can-robot.log")[1]
    assert len(lines) == 7 + is_told
    assert lines[0].startswith(f"warning: {tmp_path}: run.json: ") == is_told


def test_missing_files_are_reported_and_standard_input_is_decoded(shown, tmp_path, dictionary, monkeypatch):
    assert "No such file or directory, expected packets.log, a log of candump -L" in shown(tmp_path / "nothing")[2]
    assert shown()[0] == 2
    with pytest.raises(frames.DatabaseError, match="rokviss-robot.dbc: No such file or directory; run make"):
        (tmp_path / "c.log").write_text(FRAMES, encoding="ascii")
        list(decode.rows([str(tmp_path / "c.log")], dictionary, tmp_path, PORT))
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(packets.build_tc(16, 5, 17, 1).hex().encode())))
    code, lines, _ = shown("-")
    assert code == 0 and "TC[17,1]" in lines[0]


def test_a_capture_with_a_wrong_octet_is_decoded_or_refused(dictionary, dictionary_path, telemetry, tmp_path):
    """A damaged file is partly decoded or refused with a text; no other exception leaves the decoder."""
    raw = _pcapng(101, [_segment(1000, telemetry[0])])
    for at in range(0, len(raw), 3):
        for value in (0x00, 0xFF, raw[at] ^ 0x10):
            path = tmp_path / "damaged.pcapng"
            path.write_bytes(raw[:at] + bytes([value]) + raw[at + 1 :])
            try:
                list(decode.rows([str(path)], dictionary, dictionary_path.parent, PORT))
            except (decode.DecodeError, frames.DatabaseError) as problem:
                assert "damaged.pcapng: " in str(problem)


def test_the_example_of_the_readme_is_decoded(shown):
    text = (ROOT / "gse" / "README.md").read_text(encoding="utf-8")
    octets = next(line.split()[2] for line in text.splitlines() if line.startswith("gse/gse decode 1810"))
    assert shown(octets)[1] == ["TC[17,1]   to MANIPULATOR: perform an are-you-alive connection test"]


def test_a_status_of_another_interface_than_that_of_the_dictionary_is_reported(shown, dictionary):
    own = dictionary.subsystem("MANIPULATOR").interface_hash
    for flown, is_told in ((own, False), (own ^ 1, True)):
        raw = build_tm(MANIPULATOR, 0, 129, 5, struct.pack(">BBBHQQII", 5, 0, 5, 1, flown, 0, 0, 0), 1, dictionary.epoch_ns)
        _, lines, _ = shown(raw.hex())
        assert (f"MANIPULATOR flies interface 0x{flown:016x}, the dictionary has 0x{own:016x}" in lines[0]) is is_told


def test_a_device_is_not_read(shown):
    """/dev/zero would fill the memory."""
    code, _, err = shown("/dev/zero")
    assert code == 1 and "gse: /dev/zero: found a device, expected packets.log" in err
