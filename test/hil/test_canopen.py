# SPDX-License-Identifier: Apache-2.0
"""CANopen that other projects accept: PyPI canopen as master of the simulated devices, over the simulator's
port and over SocketCAN; cantools, tshark and the generated database check candump's recording."""

import collections
import os
import re
import subprocess

import can
import cantools
import pytest
from environments import PYTHON, ROOT, Group, Result, cases
from recordings import assert_wireshark_names_all

MASTER = "test/hil/guest/canopen_master.py"
SLAVES = "test/hil/guest/canopen_slaves.py"
# Each case of the master runs over the port of the simulator in every run, and over SocketCAN with LONG=1.
QUICK_MASTER = ("scan_finds_the_nodes_of_each_bus", "a_drive_reports_that_its_master_falls_silent",
                "joint_moves_in_cyclic_synchronous_position", "simulator_and_recorder_end_without_error")
SENTINEL = 0x7FF
LIMIT_S = 3000


@pytest.fixture(scope="module")
def over_port(hil_directory):
    """The cases on this kernel, whatever it supports, because frames pass through the simulator's port."""
    directory = hil_directory / "canopen-port"
    directory.mkdir()
    done = subprocess.run([PYTHON, MASTER], cwd=ROOT, env=dict(os.environ, OUT=str(directory)), capture_output=True, timeout=LIMIT_S)
    return Group("canopen over the port", Result(done.returncode, done.stdout, done.stderr, directory))


@pytest.mark.parametrize("case", cases(MASTER))
def test_a_case_of_the_master_passes_over_the_port(over_port, case):
    over_port.check(case)


@pytest.fixture(scope="module")
def both_programs(request, environment):
    """Results of both programs that run on vcan-robot and vcan-joystick, one after the other: starting a
    machine is slow."""
    def asked(program, test, quick=()):
        params = {item.callspec.params["case"] for item in request.session.items if item.name.startswith(test)}
        names = [case for case in cases(program) if case in {*params, *quick}]
        return f"{PYTHON} {program} {' '.join(names)}" if names else "true"

    slaves, master = asked(SLAVES, "test_flight_commissions_"), asked(MASTER, "test_a_case_of_the_master_passes_over_socketcan", QUICK_MASTER)
    return environment.run(f"mkdir -p $OUT/slaves $OUT/master; OUT=$OUT/slaves {slaves}; "
                     f"OUT=$OUT/master CANOPEN_INTERFACES=vcan- {master}", LIMIT_S)


def part(result, name):
    """The cases of one of the programs."""
    return Group(f"canopen {name}", Result(result.code, result.stdout.encode(), result.stderr.encode(), result.directory / name))


@pytest.fixture(scope="module")
def over_socketcan(both_programs):
    """The master's cases on SocketCAN."""
    return part(both_programs, "master")


@pytest.mark.parametrize("case", [case if case in QUICK_MASTER else pytest.param(case, marks=pytest.mark.long) for case in cases(MASTER)])
def test_a_case_of_the_master_passes_over_socketcan(over_socketcan, case):
    over_socketcan.check(case)


@pytest.fixture(scope="module")
def recorded(over_socketcan):
    """candump's log of vcan-robot, without the frames that mark its beginning and end."""
    path = over_socketcan.result.directory / "candump.log"
    lines = path.read_text().splitlines()
    assert not [line for line in lines if "DROPCOUNT" in line]
    frames = [line for line in lines if f" {SENTINEL:03X}#" not in line]
    assert len(frames) > 1000 and len(lines) - len(frames) >= 2
    path = path.with_name("frames.log")
    path.write_text("\n".join(frames) + "\n")
    return path


def test_database_knows_every_frame_that_candump_recorded(recorded):
    database = cantools.database.load_file(ROOT / "build/generated/rokviss-robot.dbc", strict=True)
    scanned = set(range(0x601, 0x680))  # The scan queries every possible node.
    seen, moved = collections.Counter(), []
    for frame in can.CanutilsLogReader(recorded):
        if frame.arbitration_id in scanned - {0x611, 0x612}:
            assert bytes(frame.data) == bytes.fromhex("4000100000000000"), "SDO upload of the device type, 0x1000:00"
            continue
        message = database.get_message_by_frame_id(frame.arbitration_id)
        values = message.decode(bytes(frame.data), allow_truncated=False)
        seen[message.name] += 1
        if message.name == "JOINT1_TPDO1":
            moved.append(values["PositionActualValue"])
            assert frame.is_fd
    assert {"NMT", "SYNC", "JOINT1_TPDO1", "JOINT1_RPDO1", "JOINT1_TPDO2", "JOINT2_EMCY", "JOINT1_HEARTBEAT",
            "JOINT1_SDO_REQUEST", "JOINT1_SDO_RESPONSE"} <= set(seen)
    assert 0.018 < max(moved) - min(moved) < 0.025  # The ramp of the master's case in CSP: 0.02 rad.


def test_wireshark_names_every_frame_that_candump_recorded(recorded):
    assert_wireshark_names_all(recorded)


def test_candump_recorded_the_frames_of_the_bus(over_socketcan, recorded):
    """The simulator's log and the recorder's have the same frames, each once. Newer kernels mark FD frames in
    their flags."""
    def frames(path):
        text = re.sub(r"##([0-9A-F])", lambda match: f"##{int(match[1], 16) & 3:X}", path.read_text())
        return collections.Counter(line.split()[2] for line in text.splitlines())
    assert frames(recorded) == frames(over_socketcan.result.directory / "can-robot.log")


@pytest.fixture(scope="module")
def commissioned(both_programs):
    """The master of the flight software with slaves of PyPI canopen on vcan-robot, some with a deviation."""
    return part(both_programs, "slaves")


# Slaves without and with each deviation fly on shared memory in every run (test/conformance/test_drive_deviations.py).
@pytest.mark.long
@pytest.mark.parametrize("case", cases(SLAVES))
def test_the_flight_software_commissions_slaves_over_socketcan(commissioned, case):
    commissioned.check(case)
