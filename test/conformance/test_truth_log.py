# SPDX-License-Identifier: Apache-2.0
"""The truth log, written by the C code of this project, and LCM's tools: types from lcm-gen, file reader from
PyPI lcm."""

import importlib
import os
import pathlib
import subprocess
import sys

import lcm
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "gse"))
from hirosco_gse import logs, truth  # noqa: E402

WRITER = "build/test/unit/sim/truth/test_truth"
TYPES = sorted((ROOT / "sim/truth").glob("*.lcm"))


@pytest.fixture(scope="module")
def types(tmp_path_factory):
    """The Python package that lcm-gen makes from the type files."""
    directory = tmp_path_factory.mktemp("lcm")
    generator = pathlib.Path(sys.executable).with_name("lcm-gen")
    subprocess.run([generator, "-p", "--ppath", directory, *TYPES], check=True)
    sys.path.insert(0, str(directory))
    yield importlib.import_module("hirosco")
    sys.path.remove(str(directory))
    sys.modules.pop("hirosco")


@pytest.fixture(scope="module")
def events(tmp_path_factory):
    """The sample log of the unit test, read by LCM."""
    path = tmp_path_factory.mktemp("truth") / "truth.lcm"
    subprocess.run(["make", "-s", WRITER], cwd=ROOT, check=True)
    subprocess.run([ROOT / WRITER], check=True, env=dict(os.environ, TRUTH_FILE=str(path)), stdout=subprocess.DEVNULL)
    return {event.channel: event for event in lcm.EventLog(str(path), "r")}


def decode(types, events, channel):
    return getattr(types, f"{channel.lower()}_t").decode(events[channel].data)


def test_each_channel_has_its_type(events):
    assert {f"{channel.lower()}_t" for channel in events} == {path.stem for path in TYPES}


@pytest.mark.parametrize("channel", ["WORLD", "JOINTS", "STICK", "CONTACT", "SPRING", "BASE", "WHEEL", "BENCH", "INSTRUMENT", "POWER", "BUS", "NAMES", "OPERATOR", "DRIVE", "VALVE", "LATCH", "FAULT",
                                     "CUT"])
def test_every_octet_belongs_to_a_member(types, events, channel):
    message = decode(types, events, channel)
    assert message.encode() == events[channel].data
    assert message.time_ns // 1000 == events[channel].timestamp


def test_the_reader_of_the_ground_has_the_fingerprints_of_lcm_gen(types):
    assert truth.types().keys() == {path.stem.removesuffix("_t").upper() for path in TYPES}
    for channel, kind in truth.types().items():
        made = getattr(types, f"{channel.lower()}_t")
        assert kind.fingerprint.to_bytes(8, "big") == made._get_packed_fingerprint(), channel


def test_the_reader_of_the_ground_finds_the_same_members(types, events):
    read = truth.decode({channel: ((), logs.Events(event.data, np.array([0]), np.array([len(event.data)]))) for channel, event in events.items()})
    for channel in events:
        message = decode(types, events, channel)
        for member in truth.types()[channel].members:
            if isinstance(read[channel], list):
                found = read[channel][0][member.name]
            elif member.name in read[channel]:
                found = read[channel][member.name][0]
            else:
                continue  # Only counts the elements of the arrays.
            assert np.array_equal(found, getattr(message, member.name)), (channel, member.name)


def test_lcm_reads_the_values_of_joints(types, events):
    joints = decode(types, events, "JOINTS")
    assert joints.time_ns == 500_000
    assert tuple(joints.position_rad) == (1.1, 1.2)
    assert tuple(joints.velocity_rad_s) == (2.1, 2.2)
    assert tuple(joints.motor_position_rad) == (3.1, 3.2)
    assert tuple(joints.motor_torque_nm) == (4.1, 4.2)
    assert tuple(joints.joint_torque_nm) == (5.1, 5.2)
    assert tuple(joints.friction_nm) == (6.1, -6.2)
    assert tuple(joints.external_torque_nm) == (7.1, 7.2)
    assert [bool(value) for value in joints.brake_engaged] == [True, False]


def test_lcm_reads_the_values_of_devices_and_buses(types, events):
    bench, instrument, power, bus = (decode(types, events, channel) for channel in ("BENCH", "INSTRUMENT", "POWER", "BUS"))
    assert (tuple(bench.position_rad), tuple(bench.velocity_rad_s), tuple(bench.output_torque_nm)) == ((1.1, 1.2), (2.1, 2.2), (3.1, 3.2))
    assert (tuple(instrument.value), [bool(one) for one in (*instrument.enabled, *instrument.plugged)]) == ((4.1, 4.2), [True, False, False, True])
    assert [bool(one) for one in power.supplied] == [True, False, True]
    assert (tuple(bus.load), tuple(bus.frames), tuple(bus.errors)) == ((5.1, 5.2), (1234567890123, 5), (7, 0))
    assert (tuple(bus.state), tuple(bus.off), [bool(one) for one in bus.plugged]) == ((3, -1), (1, 0), [True, False])


def test_lcm_reads_the_values_of_stick(types, events):
    stick = decode(types, events, "STICK")
    assert tuple(stick.position_rad) == (0.1, 0.2)
    assert tuple(stick.velocity_rad_s) == (0.3, 0.4)
    assert tuple(stick.motor_torque_nm) == (0.5, 0.6)
    assert tuple(stick.hand_torque_nm) == (0.7, -1e-300)


def test_lcm_reads_the_values_of_world(types, events):
    world = decode(types, events, "WORLD")
    assert (world.joint, world.axis) == (["arm.joint1", "arm.joint2"], ["STICK", "STICK"])
    assert (world.contact, world.spring, world.base) == (["arm.finger", "arm.tip"], ["arm.finger"], ["arm"])


def test_lcm_reads_the_values_of_contact_and_spring(types, events):
    contact = decode(types, events, "CONTACT")
    assert [tuple(place) for place in contact.place_m] == [(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)]
    assert [tuple(point) for point in contact.point_m] == [(1.1, 1.2, 1.3), (1.4, 1.5, 1.6)]
    assert [tuple(force) for force in contact.force_n] == [(2.1, 2.2, 2.3), (2.4, 2.5, 2.6)]
    assert [bool(value) for value in contact.is_touching] == [True, False]
    spring = decode(types, events, "SPRING")
    assert (tuple(spring.place_m[0]), tuple(spring.force_n[0])) == ((0.1, 0.2, 0.3), (3.1, 3.2, 3.3))
    assert [bool(value) for value in spring.is_hooked] == [True]


def test_lcm_reads_the_values_of_base_and_cut(types, events):
    base = decode(types, events, "BASE")
    assert (tuple(base.position_m[0]), tuple(base.rotation[0])) == ((1, 2, 3), (0.5, 0.5, -0.5, 0.5))
    assert (tuple(base.velocity_m_s[0]), tuple(base.rate_rad_s[0])) == ((4, 5, 6), (7, 8, 9))
    cut = decode(types, events, "CUT")
    assert cut.time_ns == 96_000_000_000 and 1500 < cut.octets < 1850


def test_lcm_reads_the_values_of_wheel_and_names(types, events):
    wheel = decode(types, events, "WHEEL")
    assert (tuple(wheel.momentum_nms), tuple(wheel.torque_nm)) == ((1.5, -2.5), (0.1, -0.2))
    names = decode(types, events, "NAMES")
    assert (names.channel, names.name) == ("WHEEL", ["arm.finger"])


def test_lcm_reads_the_values_of_operator(types, events):
    operator = decode(types, events, "OPERATOR")
    assert tuple(operator.intent_rad) == (0.1, 0.2)
    assert tuple(operator.wanted_tip_m) == (0.3, 0.4)
    assert tuple(operator.expected_torque_nm) == (0.5, 0.6)
    assert (operator.grip, operator.verb) == (0.75, "follow")


def test_lcm_reads_the_values_of_drive_valve_latch_and_fault(types, events):
    drive = decode(types, events, "DRIVE")
    assert (drive.bus, drive.node, drive.axis, drive.statusword) == ("robot", 0x12, 1, 0x8627)
    assert (drive.plugged, drive.brake_engaged) == (True, False)
    valve = decode(types, events, "VALVE")
    assert (valve.name, valve.is_open) == ("PUSH1", True)
    latch = decode(types, events, "LATCH")
    assert (latch.name, latch.is_closed) == ("DOCK", True)
    fault = decode(types, events, "FAULT")
    assert (fault.kind, fault.target, fault.active) == ("unplug", "robot 0x11", True)
