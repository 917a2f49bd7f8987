# SPDX-License-Identifier: Apache-2.0
"""The flight software as master of unknown slaves: LocalNode of PyPI canopen, in lock-step with the flight.

All tests share one flight of the manipulator, whose simulated drives are unplugged. In each case one of two
slaves has a deviation; the result is an event with node and reason, and a defined state. The first and the last
test use two slaves without deviations."""

import pytest
import slaves
from drive_deviations import (
    ABORTED, FORMAT, NOT_BOOTED, REBOOTED, SILENT, TIMEOUT, VALUE, SlaveFlight, closed, flying, fly_without_deviations, late,
    mute, no_torque, other_maker, other_mapping, other_product, other_type, reboots_repeatedly, short_value, stop_beating,
    stop_publishing, without_mapping,
)


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """The one flight of this file."""
    opened = SlaveFlight(tmp_path_factory.mktemp("deviation"))
    yield opened
    try:
        opened.close()
    finally:
        opened.flight.abandon()
    assert opened.flight.code == 0, opened.flight.transcript()
    flying.assert_clean(opened.flight)


@pytest.fixture
def down(flight):
    """End each case as an operator would: bring the subsystem to OFFLINE and wait until it is there."""
    yield
    if flight.ground.state != "OFFLINE":
        assert flight.ground.request("OFFLINE")
    flight.ground.await_state("OFFLINE")


def test_good_devices_are_commissioned_and_flown(flight, down):
    fly_without_deviations(flight)


@pytest.mark.parametrize("deviation, message", [
    (late, (0x12, TIMEOUT, 0x100000, 0)),
    (mute, (0x12, TIMEOUT, 0x100000, 0)),
    (other_type, (0x12, VALUE, 0x100000, 0x00010192)),
    (other_maker, (0x12, VALUE, 0x101801, 0x29C)),
    (other_product, (0x12, VALUE, 0x101802, 0x2015)),
    (short_value, (0x12, FORMAT, 0x607600, 0)),
    (no_torque, (0x12, VALUE, 0x607600, 0)),
    (without_mapping, (0x12, ABORTED, 0x1A0100, 0x06020000)),
    (other_mapping, (0x12, VALUE, 0x1A0003, 0x60780010)),
    (closed, (0x12, ABORTED, 0x607200, 0x08000022)),
    (reboots_repeatedly, (0x12, REBOOTED, 0, 0)),
])
def test_a_deviating_device_is_not_commissioned(flight, down, deviation, message):
    flight.replace_drives(deviation)
    assert not flight.ground.request("PRE_OPERATIONAL")
    assert flight.refusals() == [message]
    flight.ground.await_state("OFFLINE")


def test_a_device_that_does_not_boot_is_reported_and_commissioning_fails(flight, down):
    def without_boot_up(drive):
        drive.boots = drive.beats = False
    flight.replace_drives(without_boot_up)
    assert not flight.ground.request("PRE_OPERATIONAL")
    assert flight.refusals() == [(0x12, NOT_BOOTED, 0, 0)]
    flight.ground.await_state("OFFLINE")


@pytest.mark.parametrize("index, code", [(0x6060, 0x06090030), (0x1400, 0x08000022)])
def test_a_refused_setting_leaves_the_drive_unconfigured(flight, down, index, code):
    flight.replace_drives()
    assert flight.ground.request("PRE_OPERATIONAL")
    subindex = 0 if index == 0x6060 else 1
    flight.slaves.call(lambda: flight.drive(0x11).refusals.update({(index, subindex): code}))
    assert not flight.ground.configure()
    assert flight.refusals() == [(0x11, ABORTED, index << 8 | subindex, code)]
    assert flight.ground.state == "PRE_OPERATIONAL"
    assert not flight.ground.request("SAFE_OPERATIONAL")


def test_a_drive_that_sends_no_process_data_is_reported_and_commissioning_fails(flight, down):
    def without_process_data(drive):
        drive.publishes = False
    flight.replace_drives(without_process_data)
    assert flight.ground.request("PRE_OPERATIONAL")
    assert not flight.ground.configure()
    assert flight.refusals() == [(0x12, SILENT, 0, 0)]
    assert flight.ground.state == "PRE_OPERATIONAL"
    flight.ground.wait(lambda: flight.drive(0x11).state == slaves.PRE_OPERATIONAL, "the drive without deviation stops its process data")


@pytest.mark.parametrize("reached, change", [
    ("PRE_OPERATIONAL", stop_beating),
    ("PRE_OPERATIONAL", reboots_repeatedly),
    ("SAFE_OPERATIONAL", stop_publishing),
    ("SAFE_OPERATIONAL", reboots_repeatedly),
    ("OPERATIONAL", stop_publishing),
    ("OPERATIONAL", stop_beating),
])
def test_a_device_that_is_lost_later_is_reported_and_all_devices_become_safe(flight, down, reached, change):
    flight.replace_drives()
    assert flight.ground.request("PRE_OPERATIONAL")
    if reached != "PRE_OPERATIONAL":
        assert flight.ground.configure()
        assert flight.ground.request("SAFE_OPERATIONAL")
    if reached == "OPERATIONAL":
        assert flight.ground.request("OPERATIONAL")
    seen = []
    flight.ground.session.listeners.append(lambda packet, reported: seen.append(flight.ground.state))
    flight.slaves.call(lambda: change(flight.drive(0x12)))
    flight.ground.await_state("OFFLINE")  # By the recovery plan.
    flight.ground.session.listeners.pop()
    assert "ERROR_OPERATIONAL" in seen
    assert [event for event in flight.events() if event[0] == "DEVICE_LOST"] == [("DEVICE_LOST", {"NODE": 0x12})]
    assert {drive.statusword for drive in flight.slaves.drives.values()} == {slaves.SWITCH_ON_DISABLED}


def test_a_device_without_deviation_is_commissioned_afterwards(flight, down):
    fly_without_deviations(flight)
