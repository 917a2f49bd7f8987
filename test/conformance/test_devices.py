# SPDX-License-Identifier: Apache-2.0
"""The simulated devices against an independent master: PyPI canopen over the simulator's socketcand port.

The simulator stands still until the master sends, so what is seen does not depend on the speed of the machine."""

import re
import subprocess
import time

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from simulated import ROOT, SHEETS, SIMULATOR, Simulator, pass_time

@pytest.fixture
def simulator(tmp_path):
    opened = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    yield opened
    opened.close()


@pytest.fixture
def drive(simulator):
    network = simulator.connect("robot")
    node = BaseNode402(0x11, str(SHEETS / "joint-drive.eds"))
    network.add_node(node)
    pass_time(network, 10)
    return node


def test_scan_finds_the_nodes_of_each_bus(simulator):
    for bus, nodes in (("robot", [0x11, 0x12]), ("joystick", [0x21])):
        network = simulator.connect(bus)
        pass_time(network, 10)
        network.scanner.reset()
        network.scanner.search()
        time.sleep(0.3)
        assert sorted(network.scanner.nodes) == nodes
        network.disconnect()
        simulator.networks.remove(network)
        time.sleep(0.1)


def test_boot_up_and_heartbeat(simulator):
    network = simulator.connect("robot")
    seen = []
    network.subscribe(0x711, lambda identifier, data, stamp: seen.append((bytes(data), stamp)))
    pass_time(network, 200)
    assert seen[0][0] == b"\x00"
    assert {data for data, _ in seen[1:]} == {b"\x7f"}
    stamps = [stamp for _, stamp in seen[1:]]
    assert len(stamps) >= 8
    assert all(abs(later - sooner - 0.020) < 0.0005 for sooner, later in zip(stamps, stamps[1:]))


def test_identity_and_strings(drive):
    assert drive.sdo[0x1000].raw == 0x00020192
    assert drive.sdo[0x1008].raw == "hirosco joint drive JD-40"
    assert drive.sdo[0x1018][4].raw == 0x11
    for text in ("x", "seven77", "a tag longer than one segment of seven", "y" * 64):
        drive.sdo[0x2300].raw = text
        assert drive.sdo[0x2300].raw == text
    drive.sdo[0x2310].raw = 0x0123456789ABCDEF
    assert drive.sdo[0x2310].raw == 0x0123456789ABCDEF


@pytest.mark.parametrize("index, subindex, data, code", [
    (0x5000, 0, None, 0x06020000),
    (0x1018, 9, None, 0x06090011),
    (0x1000, 0, b"\0\0\0\0", 0x06010002),
    (0x6060, 0, b"\x01", 0x06090030),
    (0x1017, 0, b"\0", 0x06070013),
    (0x1017, 0, b"\0\0\0\0", 0x06070012),
    (0x2300, 0, b"z" * 65, 0x06070012),
    (0x1A00, 1, b"\x20\0\x64\x60", 0x08000022),
])
def test_aborts(drive, index, subindex, data, code):
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        if data is None:
            drive.sdo.upload(index, subindex)
        else:
            drive.sdo.download(index, subindex, data)
    assert aborted.value.code == code
    assert drive.sdo[0x1017].raw == 20  # It goes on serving.


def test_block_transfer_is_refused(drive):
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        drive.sdo[0x1008].open("rb", block_transfer=True).read()
    assert aborted.value.code == 0x05040001


def test_mappings_read_from_the_drive_are_those_of_the_readme(drive):
    drive.pdo.read()
    mapped = {pdo.cob_id: ([f"{variable.index:04X}" for variable in pdo], pdo.trans_type, pdo.enabled)
              for pdo in (*drive.rpdo.values(), *drive.tpdo.values())}
    assert mapped == {
        0x211: (["6040", "607A", "60B2"], 1, True),
        0x311: (["6040", "6071", "60FF"], 1, False),
        0x191: (["6041", "6064", "6077"], 1, True),
        0x291: (["606C", "6078", "2210"], 20, True),
    }


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
    assert abs(drive.tpdo[2][0x6062].raw - 1047198) < 5


def test_nmt_states(drive):
    seen = []
    drive.nmt.add_heartbeat_callback(seen.append)
    for state, number in (("OPERATIONAL", 5), ("STOPPED", 4), ("PRE-OPERATIONAL", 127)):
        drive.nmt.state = state
        pass_time(drive.network, 50)
        assert seen[-1] == number
    drive.nmt.state = "RESET"
    pass_time(drive.network, 50)
    assert 0 in seen
    assert seen[-1] == 127


def enable(drive, mode):
    """To OPERATION ENABLED as the profile's own code walks there."""
    drive.sdo[0x1400][5].raw = 0  # This master is no real-time master: no deadline.
    drive.sdo[0x6060].raw = mode
    drive.setup_402_state_machine()
    drive.rpdo[1]["Controlword"].raw = 0
    drive.nmt.state = "OPERATIONAL"
    drive.network.sync.start(0.005)
    drive.rpdo[1].start(0.005)
    time.sleep(0.1)
    drive.state = "READY TO SWITCH ON"
    drive.state = "SWITCHED ON"
    drive.rpdo[1]["Target position"].raw = drive.tpdo[1]["Position actual value"].raw
    drive.rpdo[1]["Torque offset"].raw = 590
    drive.state = "OPERATION ENABLED"


def stop_cycle(drive):
    drive.rpdo[1].stop()
    drive.network.sync.stop()


def test_the_profile_walks_the_drive_to_operation_enabled_and_back(drive):
    enable(drive, 8)
    assert drive.state == "OPERATION ENABLED"
    assert drive.sdo[0x2220].raw == 0
    start = drive.tpdo[1]["Position actual value"].raw
    for step in range(1, 21):
        drive.rpdo[1]["Target position"].raw = start + 1000 * step
        time.sleep(0.01)
    time.sleep(0.2)
    assert abs(drive.tpdo[1]["Position actual value"].raw - (start + 20000)) < 1500
    drive.state = "SWITCHED ON"
    assert drive.sdo[0x2220].raw == 1
    drive.state = "SWITCH ON DISABLED"
    stop_cycle(drive)


def test_quick_stop_ends_in_switch_on_disabled(drive):
    enable(drive, 8)
    drive.controlword = 0x0002
    deadline = time.monotonic() + 2.0
    while drive.state != "SWITCH ON DISABLED" and time.monotonic() < deadline:
        drive.check_statusword()
    assert drive.state == "SWITCH ON DISABLED"
    stop_cycle(drive)


def test_a_silent_master_is_answered_by_an_emergency(drive):
    drive.sdo[0x1400][5].raw = 5
    drive.tpdo.read()
    drive.rpdo.read()
    drive.nmt.state = "OPERATIONAL"
    drive.rpdo[1].transmit()
    pass_time(drive.network, 20)
    emergency = drive.emcy.wait(timeout=1) if not drive.emcy.log else drive.emcy.log[-1]
    assert emergency.code == 0x8250
    assert emergency.register == 0x11
    assert drive.sdo[0x1003][1].raw & 0xFFFF == 0x8250


def test_joystick_has_two_axes_in_one_node(simulator):
    network = simulator.connect("joystick")
    node = canopen.RemoteNode(0x21, str(SHEETS / "joystick.eds"))
    network.add_node(node)
    pass_time(network, 10)
    node.pdo.read()
    assert [variable.index for variable in node.rpdo[1]] == [0x6071, 0x6871, 0x6040, 0x6840]
    assert [variable.index for variable in node.tpdo[1]] == [0x6064, 0x6864]
    assert [variable.index for variable in node.tpdo[2]] == [0x6041, 0x6841, 0x60FD]
    node.sdo[0x1400][5].raw = 0
    node.nmt.state = "OPERATIONAL"
    for first, second in ((0x06, 0x06), (0x07, 0x07), (0x0F, 0x07)):
        node.rpdo[1][0x6040].raw = first
        node.rpdo[1][0x6840].raw = second
        node.rpdo[1].transmit()
        pass_time(network, 2)
    assert node.tpdo[2][0x6041].raw & 0x6F == 0x27
    assert node.tpdo[2][0x6841].raw & 0x6F == 0x23


def tshark(path, *options):
    """(protocol, info) of every frame, with CANopen on top of CAN."""
    arguments = ["tshark", "-r", str(path), "-d", "can.subdissector,canopen", "-T", "fields",
                 "-e", "_ws.col.Protocol", "-e", "_ws.col.Info", *options]
    output = subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return [tuple(line.split("\t")) for line in output.stdout.splitlines()]


@pytest.mark.parametrize("suffix", ["log", "pcap"])
def test_wireshark_names_every_frame_of_the_log(tmp_path, suffix):
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    node = BaseNode402(0x11, str(SHEETS / "joint-drive.eds"))
    simulator.connect("robot").add_node(node)
    pass_time(node.network, 30)
    assert node.sdo[0x1008].raw
    node.sdo[0x2300].raw = "a tag of some length"
    with pytest.raises(canopen.SdoAbortedError):
        node.sdo.upload(0x5000, 0)
    enable(node, 8)
    node.state = "SWITCH ON DISABLED"
    stop_cycle(node)
    node.sdo[0x1400][5].raw = 3
    node.rpdo[1].transmit()
    pass_time(node.network, 60)
    simulator.close()

    path = tmp_path / f"can-robot.{suffix}"
    frames = tshark(path)
    lines = (tmp_path / "can-robot.log").read_text().splitlines()
    assert len(frames) == len(lines) > 200
    assert {protocol for protocol, _ in frames} == {"CANopen"}
    assert tshark(path, "-Y", "_ws.malformed || _ws.expert.severity >= 6291456") == []
    text = "\n".join(info for _, info in frames)
    for name in ("SYNC", "PDO1 (tx)", "PDO1 (rx)", "PDO2 (tx)", "Boot-up", "Operational", "Pre-operational",
                 "Start remote node", "EMCY", "Abort transfer", "Initiate download", "Upload segment"):
        assert name in text, name
    # Both logs hold the same frames.
    assert [info.split("]")[0] for _, info in frames] == [
        info.split("]")[0] for _, info in tshark(tmp_path / "can-robot.pcap")]


def test_log_lines_are_those_of_candump(tmp_path):
    simulator = Simulator(tmp_path, "--in-step", "--quantum", "2000")
    network = simulator.connect("robot")
    pass_time(network, 100)
    simulator.close()
    pattern = re.compile(r"\(\d{10}\.\d{6}\) robot [0-9A-F]{3}(#([0-9A-F]{2}){0,8}|##[0-3]([0-9A-F]{2}){0,64})")
    lines = (tmp_path / "can-robot.log").read_text().splitlines()
    assert lines and all(pattern.fullmatch(line) for line in lines)
    converted = subprocess.run(["log2asc", "-I", str(tmp_path / "can-robot.log"), "robot"], check=True,
                               stdout=subprocess.PIPE, text=True).stdout
    assert len([line for line in converted.splitlines() if " Rx " in line]) == len(lines)


def test_the_free_run_keeps_pace_with_the_clock_and_ends_by_itself(tmp_path):
    began = time.monotonic()
    ended = subprocess.run([SIMULATOR, "--free-run", "1", "--time", "real", "--out", tmp_path], cwd=ROOT)
    assert ended.returncode == 0
    assert 0.95 < time.monotonic() - began < 5.0
    stamps = [float(line[1:18]) for line in (tmp_path / "can-robot.log").read_text().splitlines()]
    assert 0.97 < stamps[-1] < 1.0


@pytest.mark.parametrize("options, words", [
    (["--bogus"], "--help"),
    ([], "--calendar NAME"),
    (["--free-run", "x"], "a time in seconds"),
    (["--free-run", "1", "--bus", "wheel"], "NAME=ADDRESS"),
    (["--free-run", "1", "--bus", "robot=shm:nobody"], "no controller"),
    (["--free-run", "1", "--in-step"], "--socketcand"),
    (["--free-run", "1", "--scenario", "/nowhere.scn"], "/nowhere.scn"),
    (["--free-run", "1", "--out", "/nowhere"], "/nowhere"),
    (["--calendar", "/hirosco-nobody"], "running launcher"),
])
def test_what_is_wrong_is_said_in_one_line(options, words):
    ended = subprocess.run([SIMULATOR, *options], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    assert ended.returncode in (1, 2)
    assert len(ended.stderr.splitlines()) == 1
    assert words in ended.stderr
