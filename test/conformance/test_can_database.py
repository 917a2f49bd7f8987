# SPDX-License-Identifier: Apache-2.0
"""The generated CAN databases and cantools, python-can and tshark, on all frames of a flight: no frame is
unknown, and physical values equal those of the simulator."""

import collections
import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import can
import cantools
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GENERATOR = ROOT / "gse" / "generator"
MISSION = ROOT / "descriptors" / "missions" / "rokviss.xml"
BUSES = ("robot", "joystick")
REPORT = re.compile(r" 2[0-9A-F]{7}#")  # The report of a controller is no frame of the bus.
SCENARIO = (
    "0.0 hand rest",
    "0.0 operator state MANIPULATOR PRE_OPERATIONAL",
    "0.0 operator config MANIPULATOR STAND_ALONE",
    "0.0 operator state JOYSTICK PRE_OPERATIONAL",
    "0.0 operator config JOYSTICK TELEPRESENCE",
    "0.0 operator state MANIPULATOR SAFE_OPERATIONAL",
    "0.0 operator state MANIPULATOR OPERATIONAL",
    "0.0 operator cmd MANIPULATOR.MOVE_TO POSITION=0.9472,-1.4708 DURATION=0.8",
    "2.6 fault error robot JOINT1 0x4310 on",
    "2.7 fault error robot JOINT1 0x4310 off",
    "2.7 fault unplug joystick",
    "2.8 operator state MANIPULATOR PRE_OPERATIONAL",
    "2.8 operator config MANIPULATOR TELEPRESENCE",
    "3.3 operator shutdown",
)

sys.path.insert(0, str(ROOT / "test" / "mission"))
import flying  # noqa: E402
from hirosco_gse import logs  # noqa: E402
from hirosco_gse import run as runs  # noqa: E402


def generate(mission, out):
    """Run the generator as make does."""
    command = [sys.executable, mission.parents[2] / "gse/generator/generate.py", "--mission", mission, "--out", out]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """Directory of the newly generated databases."""
    out = tmp_path_factory.mktemp("generated")
    done = generate(MISSION, out)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def databases(generated):
    """The databases as cantools loads them, with all its checks."""
    return {bus: cantools.database.load_file(generated / f"rokviss-{bus}.dbc", strict=True) for bus in BUSES}


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A flight with all kinds of frames."""
    place = tmp_path_factory.mktemp("flight")
    scenario = flying.write_scenario(place / "frames.scn", *SCENARIO)
    flown = flying.fly(place / "run", "--form", "image", "--scenario", scenario)
    assert flown.code == 0, flown.transcript()
    return flown


def frames_of(flight, bus):
    """All frames of a log as python-can reads them."""
    lines = [line for line in flight.read(f"can-{bus}.log").splitlines() if not REPORT.search(line)]
    count = 0
    for count, frame in enumerate(can.CanutilsLogReader(io.StringIO("\n".join(lines))), 1):
        yield frame
    assert count == len(lines)


def values_of(database, frame):
    """(message, values) as cantools decodes a frame."""
    message = database.get_message_by_frame_id(frame.arbitration_id)  # KeyError: unknown
    return message, message.decode(bytes(frame.data), allow_truncated=False)


@pytest.fixture(scope="module")
def decoded(flight, databases):
    """Frames of the whole log with their values, by bus and message."""
    found = {}
    for bus in BUSES:
        messages = collections.defaultdict(list)
        for frame in frames_of(flight, bus):
            message, values = values_of(databases[bus], frame)
            messages[message.name].append((frame, values))
        found[bus] = messages
    return found


def series(decoded, bus, message, signal):
    """Times [us] and values of a signal."""
    entries = decoded[bus][message]
    return np.array([round(frame.timestamp * 1e6) for frame, _ in entries]), np.array([values[signal] for _, values in entries])


def test_the_databases_of_the_flown_mission_are_in_build(generated):
    """`make` has made the same files in the directory that the README names."""
    for bus in BUSES:
        name = f"rokviss-{bus}.dbc"
        assert (ROOT / "build/generated" / name).read_text() == (generated / name).read_text()


def test_a_database_names_the_mission_it_is_made_for(generated):
    hashes = json.loads((generated / "rokviss.json").read_text())
    text = (generated / "rokviss-robot.dbc").read_text()
    for name in ("interface_hash", "configuration_hash"):
        assert hashes[name] in text, name


def test_every_frame_has_a_message_of_its_length_and_format(databases, decoded):
    assert sum(len(entries) for entries in decoded["robot"].values()) > 20_000
    for bus in BUSES:
        for name, entries in decoded[bus].items():
            message = databases[bus].get_message_by_name(name)
            assert {len(frame.data) for frame, _ in entries} == {message.length}, name
            assert {frame.is_fd for frame, _ in entries} == {message.is_fd}, name
            assert {frame.is_extended_id for frame, _ in entries} == {False}, name


def test_the_flight_contains_all_kinds_of_frames(decoded):
    axes = ("EMCY", "HEARTBEAT", "SDO_REQUEST", "SDO_RESPONSE", "RPDO1", "RPDO2", "TPDO1", "TPDO2")
    robot = {"NMT", "SYNC", "MASTER_HEARTBEAT", *(f"JOINT1_{kind}" for kind in axes)}
    robot |= {f"JOINT2_{kind}" for kind in axes if kind != "EMCY"}
    assert set(decoded["robot"]) == robot
    stick = {f"STICK_{kind}" for kind in axes if kind not in ("RPDO2", "EMCY")}
    assert set(decoded["joystick"]) - {"STICK_EMCY"} == {"NMT", "SYNC", "MASTER_HEARTBEAT", *stick}


def test_cantools_decodes_a_log_as_in_the_readme(flight, generated):
    """The command line tool needs a quarter of a millisecond for a line, so it gets only one line of each
    identifier."""
    lines = list({line.split(" ")[2].partition("#")[0]: line for line in flight.read("can-joystick.log").splitlines()}.values())
    command = [sys.executable, "-m", "cantools", "decode", "--single-line", generated / "rokviss-joystick.dbc"]
    output = subprocess.run(command, input="\n".join(lines) + "\n", check=True, capture_output=True, text=True).stdout
    assert len(output.splitlines()) == len(lines) > 10
    undecoded = [line for line in output.splitlines() if not re.search(r":: \w+\(.*\)$", line)]
    assert undecoded and all(REPORT.search(line) for line in undecoded), undecoded


@pytest.mark.parametrize("joint", [1, 2])
def test_positions_and_torques_are_those_of_the_truth(flight, decoded, joint):
    """A drive samples its published values at SYNC; the truth has the values at the end of each step of 0.5
    ms."""
    truth = runs.load(flight.directory).truth
    times, positions = series(decoded, "robot", f"JOINT{joint}_TPDO1", "PositionActualValue")
    assert np.ptp(positions) > 0.08  # The arm has moved.
    wanted = np.interp(times, truth["JOINTS"]["time_us"], truth["JOINTS"]["motor_position_rad"][:, joint - 1])
    assert np.abs(positions - wanted).max() < 0.5e-3
    _, torques = series(decoded, "robot", f"JOINT{joint}_TPDO1", "TorqueActualValue")
    felt = np.interp(times, truth["JOINTS"]["time_us"], truth["JOINTS"]["joint_torque_nm"][:, joint - 1])
    assert np.abs(torques - felt).mean() < 0.5  # Offset and noise of the sensor.


def test_telemetry_reports_the_same_positions(flight, decoded):
    """Housekeeping reports the joints as in the frames of the last cycle."""
    times, positions = series(decoded, "robot", "JOINT1_TPDO1", "PositionActualValue")
    reports = runs.load(flight.directory).reports_of("housekeeping")
    reported = [(stamp // 1000, report["values"]["CUR_VALUES"]) for stamp, packet, report in reports
                if packet.apid == 16 and "CUR_VALUES" in report["values"]]
    assert len(reported) > 8
    for time_us, values in reported:
        last = positions[np.searchsorted(times, time_us) - 1]
        # The encoder is on the motor side of the elastic gear: up to 1 mrad at 8 Nm.
        assert abs(values["POSITION"][0] - last) < 1.5e-3


def test_other_physical_values_are_plausible(decoded):
    for joint in (1, 2):
        name = f"JOINT{joint}"
        assert np.abs(series(decoded, "robot", f"{name}_TPDO2", "VelocityActualValue")[1]).max() < 1.0
        assert np.abs(series(decoded, "robot", f"{name}_TPDO2", "CurrentActualValue")[1]).max() < 20.0
        temperature = series(decoded, "robot", f"{name}_TPDO2", "DriveTemperature")[1]
        assert (temperature > 15.0).all() and (temperature < 60.0).all()
        assert np.abs(series(decoded, "robot", f"{name}_RPDO1", "TargetPosition")[1]).max() < 2.8
        assert np.abs(series(decoded, "robot", f"{name}_RPDO2", "TargetTorque")[1]).max() < 40.0
    sticks = series(decoded, "joystick", "STICK_TPDO1", "PositionActualValueAxis1")[1]
    assert np.abs(sticks).max() < 0.36


def test_states_and_codes_have_names(decoded):
    robot = decoded["robot"]
    assert str(robot["JOINT1_EMCY"][0][1]["Code"]) == "Over temperature drive"
    assert {str(values["State"]) for _, values in robot["JOINT1_HEARTBEAT"]} == {"Boot up", "Pre operational", "Operational"}
    assert {"Reset node", "Start", "Enter pre operational"} <= {str(values["Command"]) for _, values in robot["NMT"]}
    first = robot["JOINT1_SDO_RESPONSE"][0][1]
    assert (str(first["Command"]), first["Index"], first["Data"]) == ("Initiate upload", 0x1000, 0x00020192)


@pytest.mark.parametrize("bus, suffix", [("robot", "log"), ("joystick", "pcap")])
def test_wireshark_names_every_frame(flight, bus, suffix):
    assert_wireshark_names_every_frame(flight, bus, suffix)


def assert_wireshark_names_every_frame(flight, bus, suffix):
    """Each frame is CANopen and none is malformed; the remaining frames are reports of the controller."""
    arguments = ["tshark", "-r", flight.directory / f"can-{bus}.{suffix}", "-d", "can.subdissector,canopen", "-T", "fields",
                 "-e", "_ws.col.Protocol", "-e", "can.flags.err", "-e", "_ws.malformed", "-e", "_ws.col.Info"]
    output = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
    frames = [line.split("\t") for line in output.splitlines()]
    assert len(frames) == len(logs.read_bus(flight.directory / f"can-{bus}.log"))
    kinds = collections.Counter(protocol for protocol, error, _, _ in frames if error in ("0", "False", ""))
    assert set(kinds) == {"CANopen"}, kinds
    assert not [frame for frame in frames if frame[2]]
    assert not [frame for frame in frames if not frame[3].strip()]


@pytest.mark.long
def test_every_frame_of_a_flight_of_telepresence_is_known(tmp_path, databases):
    """cantools and tshark read a million frames."""
    flown = flying.fly(tmp_path / "telepresence", "--form", "image", "--scenario", "telepresence")
    assert flown.code == 0, flown.transcript()
    for bus in BUSES:
        count = 0
        for frame in frames_of(flown, bus):
            message, _ = values_of(databases[bus], frame)
            assert (len(frame.data), frame.is_fd) == (message.length, message.is_fd), frame
            count += 1
        assert count > 500_000
        assert_wireshark_names_every_frame(flown, bus, "log")


# --- refusals of the generator
# -------------------------------------------------------------------------------------


@pytest.fixture
def copied(tmp_path):
    """A copy of descriptors and generator that may be changed: edit(file, old, new), then make()."""
    for part in ("descriptors", "gse/generator", "pus/catalogue"):
        shutil.copytree(ROOT / part, tmp_path / part)
    for header in ("base/status.h", "fsw/canopen/network.h", "pus/core/tailoring.h", "pus/st18/st18_procedures.h"):
        (tmp_path / header).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / header, tmp_path / header)

    def edit(name, old, new):
        path = tmp_path / "descriptors" / name
        text = path.read_text()
        assert old in text, old
        path.write_text(text.replace(old, new, 1))

    def make():
        done = generate(tmp_path / "descriptors/missions/rokviss.xml", tmp_path / "out")
        return SimpleNamespace(code=done.returncode, message=done.stderr, out=tmp_path / "out")

    return SimpleNamespace(edit=edit, make=make)


@pytest.mark.parametrize("file, old, new, words", [
    ("subsystems/manipulator.xml", 'type="joint-drive"', 'type="windlass"', ("manipulator.xml:", "windlass", "joint-drive joint-drive-large joystick")),
    ("devices/joint-drive.eds", "DefaultValue=0x60770010", "DefaultValue=0x60760010", ("joint-drive.eds:821: 16 bits of 0x6076:00 in a PDO: expected 32",)),
    ("devices/joint-drive.eds", "DefaultValue=0x60770010", "DefaultValue=0x3FFF0010", ("0x3fff:00", "joint-drive.eds")),
    ("devices/joint-drive.eds", "[1A00sub1]\nParameterName=Mapped object 1", "[1A00sub1]\n[1A00sub1]", ("joint-drive.eds:", "not a data sheet")),
    ("subsystems/manipulator.xml", '<Setting object="0x1401:01" type="UINT32" value="0x80000311"/>',
     '<Setting object="0x1600:01" type="UINT32" value="0x60400010"/><Setting object="0x1600:02" type="UINT32" value="0x60B20010"/>'
     '<Setting object="0x1600:03" type="UINT32" value="0x607A0020"/>', ("manipulator.xml:", "0x211", "another layout")),
    # JOINT1 (node 0x11) would send with the identifier of the first TPDO of JOINT2.
    ("subsystems/manipulator.xml", '<Setting object="0x1401:01" type="UINT32" value="0x80000311"/>',
     '<Setting object="0x1800:01" type="UINT32" value="0x00000192"/>', ("manipulator.xml:", "0x192", "JOINT1_TPDO1", "JOINT2_TPDO1")),
])
def test_a_faulty_descriptor_or_sheet_is_refused_with_its_place(copied, file, old, new, words):
    copied.edit(file, old, new)
    made = copied.make()
    assert made.code == 1
    assert len(made.message.splitlines()) == 1, made.message
    for word in words:
        assert word in made.message


def test_the_database_follows_the_settings(copied):
    """If a setting of one configuration changes an identifier, the database has an additional message."""
    copied.edit("subsystems/manipulator.xml", 'object="0x1400:01" type="UINT32" value="0x00000211"',
                'object="0x1400:01" type="UINT32" value="0x00000221"')
    made = copied.make()
    assert made.code == 0, made.message
    database = cantools.database.load_file(made.out / "rokviss-robot.dbc", strict=True)
    assert database.get_message_by_frame_id(0x221).get_signal_by_name("TargetPosition").unit == "rad"


def test_the_counter_of_sync_is_described_if_a_device_uses_it(copied):
    copied.edit("subsystems/manipulator.xml", '<Setting object="0x1401:01" type="UINT32" value="0x80000311"/>',
                '<Setting object="0x1019:00" type="UINT8" value="240"/>')
    made = copied.make()
    assert made.code == 0, made.message
    database = cantools.database.load_file(made.out / "rokviss-robot.dbc", strict=True)
    assert database.decode_message("SYNC", b"\x07") == {"Counter": 7}
