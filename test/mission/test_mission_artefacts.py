# SPDX-License-Identifier: Apache-2.0
"""Files that a run leaves in its directory, read by other programs than the project's readers where possible."""

import hashlib
import re
import shutil
import sqlite3
import struct

import flying
import lcm
import pytest

REQUIRED_FACTS = {
    "mission",
    "scenario",
    "seed",
    "form",
    "time",
    "bus",
    "transport",
    "links",
    "interface_hash",
    "configuration_hash",
    "sha256",
    "versions",
    "real_time_factor",
    "reproducible",
    "exit_code",
    "exit_reason",
    "latency_forward_cycles",
    "latency_back_cycles",
    "tracking_error",
    "reflection_error",
    "reflection_error_contour",
    "hold_motion_rad",
    "contact_share",
    "contact_force_max_n",
    "brake_drop_rad",
    "engagement_step_rad",
    "link_lost",
    "unplug_reaction_s",
    "torque_limit_reaction_cycles",
}
CANDUMP_LINE = re.compile(rb"\((\d{10}\.\d{6})\) (robot|joystick) (?:([0-9A-F]{3}|[0-9A-F]{8})(#|##[0-9A-F])((?:[0-9A-F]{2})*))\n")
LINKTYPE_CAN_SOCKETCAN = 227
PCAP_NANOSECONDS, PCAP_MICROSECONDS = 0xA1B23C4D, 0xA1B2C3D4
STEP_US = 500


@pytest.fixture(scope="module", params=["processes", "image"])
def flight(request, shared_flights):
    """A flight of each form, with its report."""
    return shared_flights.flight(form=request.param, again=1, report="yes")


@pytest.fixture(scope="module")
def image(shared_flights):
    """The flight of the image. Its logs are those of the other form."""
    return shared_flights.flight(form="image", again=1, report="yes")


def test_both_forms_leave_the_same_logs(image, shared_flights):
    processes = shared_flights.flight(form="processes", again=1, report="yes")
    assert {path.name for path in processes.directory.iterdir()} == {path.name for path in image.directory.iterdir()}
    for name in ("packets.log", "packets.ascii", "truth.lcm", *(f"can-{bus}.{kind}" for bus in ("robot", "joystick") for kind in ("log", "pcap"))):
        assert processes.octets(name) == image.octets(name), name


def test_summary_has_every_fact(flight):
    facts = flight.facts
    assert not REQUIRED_FACTS - facts.keys()
    assert (facts["mission"], facts["seed"], facts["time"]) == ("rokviss", 1, "stepped")
    assert facts["form"] in flight.directory.name
    assert facts["exit_code"] == 0
    assert facts["reproducible"] is True
    assert facts["figures_hold"] is True, facts
    assert facts["figures_missing"] == {}
    assert facts["report_problems"] == []
    assert facts["real_time_factor"] > 0
    for name in ("interface_hash", "configuration_hash"):
        assert re.fullmatch(r"0x[0-9A-Fa-f]{16}", facts[name])


def test_summary_reports_the_true_hashes_of_the_logs(flight):
    hashes = flight.facts["sha256"]
    assert set(hashes) >= {"packets.log", "can-robot.log", "can-joystick.log", "truth.lcm"}
    for name, wanted in hashes.items():
        assert hashlib.sha256(flight.octets(name)).hexdigest() == wanted, name


def test_summary_has_the_figures_of_the_raw_logs(image, shared_flights):
    computed, _ = shared_flights.computed(form=image.facts["form"], again=1, report="yes")
    for name, value in computed.items():
        assert image.facts[name] == pytest.approx(value), name


def test_packet_lines_are_well_formed_and_in_order(image):
    last = -1
    for line in image.read("packets.log").splitlines():
        assert re.fullmatch(r"\d+\.\d{9} (TC|TM) ([0-9a-f]{2}){9,4096}", line), line
        seconds, fraction = line.split(" ")[0].split(".")
        time_ns = int(seconds) * 10**9 + int(fraction)
        assert time_ns >= last
        last = time_ns
    assert last > 93 * 10**9


def test_database_equals_the_packet_log_row_by_row(flight):
    with sqlite3.connect(f"file:{flight.directory}/packets.db?mode=ro", uri=True) as database:
        columns = [row[1] for row in database.execute("PRAGMA table_info(packet)")]
        assert columns == ["number", "time_ns", "direction", "apid", "service", "subtype", "seq", "user", "raw"]
        rows = database.execute("SELECT * FROM packet ORDER BY number").fetchall()
    packets = flight.packets
    assert len(rows) == len(packets)
    for number, (row, (time_ns, direction, raw)) in enumerate(zip(rows, packets), 1):
        word, sequence = struct.unpack(">HH", raw[:4])
        user = struct.unpack(">H", raw[9:11] if direction == "TC" else raw[11:13])[0]
        assert row == (number, time_ns, direction, word & 0x7FF, raw[7], raw[8], sequence & 0x3FFF, user, raw)


def test_log_was_switched_in_flight_and_back(image):
    """TM[131,4]: previous u8, strategy u8, first record u64, code u16."""
    found = [struct.unpack(">BBQH", raw[21:-2]) for _, direction, raw in image.packets if direction == "TM" and raw[7:9] == b"\x83\x04"]
    assert [(previous, strategy, code) for previous, strategy, _, code in found] == [(0, 1, 0), (1, 0, 0)]
    first, second = found[0][2], found[1][2]
    assert 1 < first < second < len(image.packets)
    ascii_numbers = {int(line.split()[0]) for line in image.read("packets.ascii").splitlines()}
    assert not ascii_numbers & set(range(first, second)), "packets.ascii contains records of the time in which the log was in packets.db"
    assert ascii_numbers >= set(range(1, first)) | set(range(second, len(image.packets) + 1))


@pytest.mark.parametrize("bus", ["robot", "joystick"])
def test_bus_log_is_candump_text(image, bus):
    text = image.octets(f"can-{bus}.log")
    at, last, count, fd = 0, b"", 0, 0
    for match in CANDUMP_LINE.finditer(text):
        assert match.start() == at, f"not a frame: {text[at : at + 80]!r}"
        assert match[1] >= last, "time decreases"
        assert match[2] == bus.encode()
        at, last, count = match.end(), match[1], count + 1
        fd += match[4] != b"#"
    assert at == len(text)
    assert count > 500_000
    assert fd > count // 2, "expected process data in FD frames"


def _pcap_frames(octets):
    """(nanoseconds, identifier word, is_fd, data) of each packet."""
    order = "<" if octets[:4] in (b"\x4d\x3c\xb2\xa1", b"\xd4\xc3\xb2\xa1") else ">"
    magic, major, minor, _, _, _, link = struct.unpack_from(order + "IHHiIII", octets)
    assert magic in (PCAP_NANOSECONDS, PCAP_MICROSECONDS)
    assert (major, minor) == (2, 4)
    assert link == LINKTYPE_CAN_SOCKETCAN
    scale = 1 if magic == PCAP_NANOSECONDS else 1000
    at = 24
    while at < len(octets):
        seconds, part, captured, original = struct.unpack_from(order + "IIII", octets, at)
        assert captured == original
        frame = octets[at + 16 : at + 16 + captured]
        identifier, length, flags = struct.unpack_from(">IBB", frame)
        assert captured == 8 + length
        yield seconds * 10**9 + part * scale, identifier, bool(flags & 0x04), frame[8:]
        at += 16 + captured
    assert at == len(octets)


@pytest.mark.parametrize("bus", ["robot", "joystick"])
def test_pcap_holds_the_same_frames(image, bus):
    frames = _pcap_frames(image.octets(f"can-{bus}.pcap"))
    count = 0
    for match, (time_ns, identifier, is_fd, data) in zip(CANDUMP_LINE.finditer(image.octets(f"can-{bus}.log")), frames, strict=True):
        count += 1
        assert time_ns // 1000 == int(match[1].replace(b".", b""))
        assert identifier == int(match[3], 16)
        assert is_fd == (match[4] != b"#")
        assert data == bytes.fromhex(match[5].decode())
    assert count > 500_000


def test_truth_is_read_by_lcm_itself(image):
    log = lcm.EventLog(str(image.directory / "truth.lcm"), "r")
    channels, last = {}, 0
    for event in log:
        assert event.timestamp >= last - STEP_US, "expected each event at most one step late"
        last = max(last, event.timestamp)
        channels[event.channel] = channels.get(event.channel, 0) + 1
    assert {"JOINTS", "STICK", "CONTACT", "OPERATOR", "DRIVE", "FAULT"} <= channels.keys()
    assert 100_000 < channels["JOINTS"] < 180_000, "expected one sample for each step in which the arm moves"
    assert 93e6 < last < 95e6, "expected simulated time in microseconds"


def test_the_report_contains_what_was_flown(flight):
    """test_mission_station_replay.py tests the page in a browser."""
    page = flight.read("report.html")
    for name in ("16 of 16 figures hold", "unplug_reaction_s", "seed 1"):
        assert name in page, name
    assert not list(flight.directory.glob("*.png"))


def test_a_figure_out_of_its_bound_fails_the_run(directory):
    """Exit code, run.json and report show the violation. The test changes the bound and not the flight."""
    root = directory / "root"
    root.mkdir(parents=True)
    for name in ("base", "build", "sim", "descriptors"):
        (root / name).symlink_to(flying.ROOT / name)
    shutil.copytree(flying.ROOT / "gse", root / "gse")
    path = root / "gse" / "hirosco_gse" / "figures.py"
    source, count = re.subn(r'("tracking_error": )\(.*?\)', r'\1("<", 0.0)', path.read_text(encoding="utf-8"), count=1)
    assert count == 1
    path.write_text(source, encoding="utf-8")
    flight = flying.fly(directory / "out", "--scenario", "telepresence", "--form", "image", root=root, report="yes")
    assert flight.code == 1
    assert "figures missing or out of their bounds" in flight.output, flight.transcript()
    assert f"figure tracking_error < 0: {flight.facts['tracking_error']:.4g}" in flight.output.splitlines()
    assert flight.facts["exit_code"] == 1
    assert flight.facts["exit_reason"] == "figures missing or out of their bounds: tracking_error"
