# SPDX-License-Identifier: Apache-2.0
"""The simulated devices and an independent master: PyPI canopen over the simulator's socketcand port, for the
cases that test/hil/test_canopen.py does not cover. The simulator waits until the master sends, so the results
do not depend on the speed of the machine."""

import re
import subprocess
import time

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from simulated import ROOT, SHEETS, SIMULATOR, WORLD, Simulator, pass_time, patient, until


@pytest.fixture
def simulator(tmp_path):
    opened = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    yield opened
    opened.close()


@pytest.fixture
def drive(simulator):
    network = simulator.connect("robot")
    node = patient(BaseNode402(0x11, str(SHEETS / "joint-drive.eds")))
    network.add_node(node)
    pass_time(network, 10)
    return node


def test_boot_up_and_heartbeat(simulator):
    network = simulator.connect("robot")
    seen = []
    network.subscribe(0x711, lambda identifier, data, stamp: seen.append((bytes(data), stamp)))
    pass_time(network, 200)
    until(lambda: len(seen) >= 9, "boot-up and eight heartbeats")
    assert seen[0][0] == b"\x00"
    assert {data for data, _ in seen[1:]} == {b"\x7f"}
    stamps = [stamp for _, stamp in seen[1:]]
    assert all(abs(later - sooner - 0.020) < 0.0005 for sooner, later in zip(stamps, stamps[1:]))


def test_block_transfer_is_refused(drive):
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        drive.sdo[0x1008].open("rb", block_transfer=True).read()
    assert aborted.value.code == 0x05040001  # CiA 301: command specifier not valid or unknown.


def test_the_master_remaps_a_pdo(drive):
    drive.tpdo.read()
    pdo = drive.tpdo[2]
    pdo.clear()
    pdo.add_variable(0x6062)
    pdo.add_variable(0x60F4)
    pdo.trans_type = 1
    pdo.enabled = True
    pdo.save()
    drive.tpdo.read()
    assert [variable.index for variable in drive.tpdo[2]] == [0x6062, 0x60F4]
    drive.nmt.state = "OPERATIONAL"
    pass_time(drive.network, 4)
    until(lambda: abs(drive.tpdo[2][0x6062].raw - 1047198) < 5, "the remapped PDO")  # The joint starts at 60 degrees [1e-6 rad].


def enable(drive, mode):
    """Bring a drive to OPERATION ENABLED with the profile code of canopen."""
    drive.sdo[0x1400][5].raw = 0  # RPDO deadline off: this master does not run in real time.
    drive.sdo[0x6060].raw = mode
    drive.setup_402_state_machine()
    drive.rpdo[1]["Controlword"].raw = 0
    drive.nmt.state = "OPERATIONAL"
    drive.network.sync.start(0.005)
    drive.rpdo[1].start(0.005)
    until(lambda: drive.tpdo[1].is_received, "TPDO1")
    drive.state = "READY TO SWITCH ON"
    drive.state = "SWITCHED ON"
    drive.rpdo[1]["Target position"].raw = drive.tpdo[1]["Position actual value"].raw
    drive.rpdo[1]["Torque offset"].raw = 590
    drive.state = "OPERATION ENABLED"


def stop_cycle(drive):
    drive.rpdo[1].stop()
    drive.network.sync.stop()


def test_quick_stop_ends_in_switch_on_disabled(drive):
    enable(drive, 8)
    drive.controlword = 0x0002
    until(lambda: drive.state == "SWITCH ON DISABLED", "the end of the quick stop")
    stop_cycle(drive)


def test_homing_ends_at_the_stop_and_moves_the_zero(drive):
    drive.sdo[0x6098].raw = -1
    drive.sdo[0x6099][1].raw = 500000
    drive.sdo[0x607C].raw = -1234
    enable(drive, 6)
    bits = []
    # Bits 10, 12 and 13 of the statusword: target reached, homing attained, homing error (CiA 402).
    drive.tpdo[1].add_callback(lambda pdo: bits.append(pdo["Statusword"].raw & 0x3400))
    until(lambda: bits and bits[-1] == 0x0400, "a search that was not started")
    drive.controlword = 0x001F
    until(lambda: bits[-1] == 0x1400, "the end of the search")
    assert 0x0000 in bits
    assert sorted(set(bits)) == [0x0000, 0x0400, 0x1400]
    assert drive.is_homed()
    # The drive deviates from its target by the torque of gravity divided by the gain of its controller.
    assert abs(drive.tpdo[1]["Position actual value"].raw - 1234) < 15000
    stop_cycle(drive)


def tshark(path, *options):
    """(protocol, info) of every frame, which tshark decodes as CANopen on CAN."""
    arguments = ["tshark", "-r", str(path), "-d", "can.subdissector,canopen", "-T", "fields",
                 "-e", "_ws.col.Protocol", "-e", "_ws.col.Info", *options]
    output = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return [tuple(line.split("\t")) for line in output.stdout.splitlines()]


@pytest.mark.parametrize("suffix", ["log", "pcap"])
def test_wireshark_names_every_frame_of_the_log(tmp_path, suffix):
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    node = patient(BaseNode402(0x11, str(SHEETS / "joint-drive.eds")))
    simulator.connect("robot").add_node(node)
    pass_time(node.network, 400)
    assert node.sdo[0x1008].raw
    node.sdo[0x2300].raw = "a tag of several segments"
    with pytest.raises(canopen.SdoAbortedError):
        node.sdo.upload(0x5000, 0)
    enable(node, 8)
    node.state = "SWITCH ON DISABLED"
    stop_cycle(node)
    node.sdo[0x1400][5].raw = 3
    node.rpdo[1].transmit()
    pass_time(node.network, 60)
    until(lambda: node.emcy.log, "the emergency of a drive whose master falls silent")
    simulator.close()

    path = tmp_path / f"can-robot.{suffix}"
    frames = tshark(path)
    lines = (tmp_path / "can-robot.log").read_text().splitlines()
    assert len(frames) == len(lines) > 200
    assert {protocol for protocol, _ in frames} == {"CANopen"}
    assert tshark(path, "-Y", "_ws.malformed || _ws.expert.severity >= 6291456") == []  # Severity "warning" or worse.
    text = "\n".join(info for _, info in frames)
    for name in ("SYNC", "PDO1 (tx)", "PDO1 (rx)", "PDO2 (tx)", "Boot-up", "Operational", "Pre-operational",
                 "Start remote node", "EMCY", "Abort transfer", "Initiate download", "Upload segment"):
        assert name in text, name
    # Both logs have the same frames.
    assert [info.split("]")[0] for _, info in frames] == [
        info.split("]")[0] for _, info in tshark(tmp_path / "can-robot.pcap")]


def test_log_lines_are_those_of_candump(tmp_path):
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    network = simulator.connect("robot")
    seen = []
    network.subscribe(0x711, lambda identifier, data, stamp: seen.append(data))
    pass_time(network, 100)
    until(lambda: len(seen) >= 4, "heartbeats")
    simulator.close()
    pattern = re.compile(r"\(\d{10}\.\d{6}\) robot [0-9A-F]{3}(#([0-9A-F]{2}){0,8}|##[0-3]([0-9A-F]{2}){0,64})")
    lines = (tmp_path / "can-robot.log").read_text().splitlines()
    assert lines and all(pattern.fullmatch(line) for line in lines)
    converted = subprocess.run(["log2asc", "-I", str(tmp_path / "can-robot.log"), "robot"], check=True,
                               stdout=subprocess.PIPE, text=True).stdout
    assert len([line for line in converted.splitlines() if " Rx " in line]) == len(lines)


def test_the_free_run_keeps_pace_with_the_clock_and_ends_by_itself(tmp_path):
    began = time.monotonic()
    ended = subprocess.run([SIMULATOR, "--world", WORLD, "--free-run", "1", "--time", "real", "--out", tmp_path], cwd=ROOT)
    assert ended.returncode == 0
    assert time.monotonic() - began > 0.95
    stamps = [float(line[1:18]) for line in (tmp_path / "can-robot.log").read_text().splitlines()]
    assert 0.97 < stamps[-1] < 1.0


@pytest.mark.parametrize("options, words", [
    (["--bogus"], "--help"),
    ([], "--scheduler NAME"),
    (["--free-run", "x"], "a time in seconds"),
    (["--free-run", "1", "--bus", "wheel"], "NAME=ADDRESS"),
    (["--free-run", "1", "--bus", "robot=shm:nobody"], "no controller"),
    (["--free-run", "1", "--in-step"], "--socketcand"),
    (["--free-run", "1", "--scenario", "/nowhere.scn"], "/nowhere.scn"),
    (["--free-run", "1", "--out", "/nowhere"], "/nowhere"),
    (["--scheduler", "/hirosco-nobody"], "running launcher"),
])
def test_an_error_is_reported_in_one_line(options, words):
    ended = subprocess.run([SIMULATOR, *options, "--world", WORLD], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    assert ended.returncode in (1, 2)
    assert len(ended.stderr.splitlines()) == 1
    assert words in ended.stderr


@pytest.mark.parametrize("options, words", [
    ([], "give --world FILE"),
    (["--world", "/nowhere.xml"], "/nowhere.xml: "),
    (["--world", "descriptors/worlds/rokviss.urdf"], "rokviss.urdf:6: found 'robot', expected World"),
])
def test_a_missing_or_wrong_world_is_reported_in_one_line(options, words):
    ended = subprocess.run([SIMULATOR, "--free-run", "1", *options], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    assert ended.returncode in (1, 2)
    assert len(ended.stderr.splitlines()) == 1
    assert words in ended.stderr


def test_a_world_that_diverges_ends_the_run_with_its_reason(tmp_path):
    (tmp_path / "rokviss.urdf").write_text(WORLD.with_suffix(".urdf").read_text())
    (tmp_path / "w.xml").write_text(WORLD.read_text().replace('damping="8"', 'damping="80000"'))
    done = subprocess.run([SIMULATOR, "--world", tmp_path / "w.xml", "--free-run", "1"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert re.search(r"w\.xml:\d+: link arm\.\w+ gets a .*: the world diverges; check the DriveType of its joint", done.stderr)
