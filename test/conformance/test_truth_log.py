# SPDX-License-Identifier: Apache-2.0
"""The truth log written by our own C code against LCM's tools: types from lcm-gen, file reader from PyPI lcm."""

import importlib
import os
import pathlib
import subprocess
import sys

import lcm
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
WRITER = ROOT / "build/test/unit/sim/truth/test_truth"
TYPES = sorted((ROOT / "sim/truth").glob("*.lcm"))


@pytest.fixture(scope="module")
def types(tmp_path_factory):
    """The Python package that lcm-gen makes of the type files."""
    folder = tmp_path_factory.mktemp("lcm")
    generator = pathlib.Path(sys.executable).with_name("lcm-gen")
    subprocess.run([generator, "-p", "--ppath", folder, *TYPES], check=True)
    sys.path.insert(0, str(folder))
    yield importlib.import_module("hirosco")
    sys.path.remove(str(folder))
    sys.modules.pop("hirosco")


@pytest.fixture(scope="module")
def events(tmp_path_factory):
    """The sample log of the unit test, read by LCM."""
    path = tmp_path_factory.mktemp("truth") / "truth.lcm"
    subprocess.run([WRITER], check=True, env=dict(os.environ, TRUTH_FILE=str(path)), stdout=subprocess.DEVNULL)
    return {event.channel: event for event in lcm.EventLog(str(path), "r")}


def decode(types, events, channel):
    return getattr(types, f"{channel.lower()}_t").decode(events[channel].data)


def test_each_channel_has_its_type(events):
    assert {f"{channel.lower()}_t" for channel in events} == {path.stem for path in TYPES}


@pytest.mark.parametrize("channel", ["JOINTS", "STICK", "CONTACT", "OPERATOR", "DRIVE", "FAULT"])
def test_every_octet_belongs_to_a_member(types, events, channel):
    message = decode(types, events, channel)
    assert message.encode() == events[channel].data
    assert message.time_ns // 1000 == events[channel].timestamp


def test_joints(types, events):
    joints = decode(types, events, "JOINTS")
    assert joints.time_ns == 500_000
    assert tuple(joints.position_rad) == (1.1, 1.2)
    assert tuple(joints.velocity_rad_s) == (2.1, 2.2)
    assert tuple(joints.motor_position_rad) == (3.1, 3.2)
    assert tuple(joints.motor_torque_nm) == (4.1, 4.2)
    assert tuple(joints.joint_torque_nm) == (5.1, 5.2)
    assert tuple(joints.friction_nm) == (6.1, -6.2)
    assert [bool(value) for value in joints.brake_engaged] == [True, False]


def test_stick(types, events):
    stick = decode(types, events, "STICK")
    assert tuple(stick.position_rad) == (0.1, 0.2)
    assert tuple(stick.velocity_rad_s) == (0.3, 0.4)
    assert tuple(stick.motor_torque_nm) == (0.5, 0.6)
    assert tuple(stick.hand_torque_nm) == (0.7, -1e-300)


def test_contact(types, events):
    contact = decode(types, events, "CONTACT")
    assert tuple(contact.tip_m) == (0.1, 0.2, 0.3)
    assert (contact.in_contact, contact.spring_hooked) == (True, False)
    assert tuple(contact.contact_point_m) == (1.1, 1.2, 1.3)
    assert tuple(contact.contact_force_n) == (2.1, 2.2, 2.3)
    assert tuple(contact.spring_force_n) == (3.1, 3.2, 3.3)
    assert tuple(contact.external_torque_nm) == (4.1, 4.2)


def test_operator(types, events):
    operator = decode(types, events, "OPERATOR")
    assert tuple(operator.intent_rad) == (0.1, 0.2)
    assert tuple(operator.wanted_tip_m) == (0.3, 0.4)
    assert tuple(operator.expected_torque_nm) == (0.5, 0.6)
    assert (operator.grip, operator.verb) == (0.75, "follow")


def test_drive_and_fault(types, events):
    drive = decode(types, events, "DRIVE")
    assert (drive.bus, drive.node, drive.axis, drive.statusword) == ("robot", 0x12, 1, 0x8627)
    assert (drive.plugged, drive.brake_engaged) == (True, False)
    fault = decode(types, events, "FAULT")
    assert (fault.kind, fault.target, fault.active) == ("unplug", "robot 0x11", True)
