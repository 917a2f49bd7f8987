# SPDX-License-Identifier: Apache-2.0
"""The flight software commissions slaves of PyPI canopen on vcan-robot: correct ones, and some with one deviation
each. test/conformance/test_drive_deviations.py tries all deviations, on a bus in shared memory. The
arguments are the names of the cases to run."""

import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "test/conformance"), str(ROOT / "test/mission"), str(ROOT / "test/hil/guest")]

import cases
import drive_deviations


def refused(change, message):
    """Expect that the flight software does not commission a device with this deviation, and that its event gives the reason:
    `message` is (node, reason, object as index * 256 + sub-index, detail)."""
    FLIGHT.replace_drives(change)
    assert not FLIGHT.ground.request("PRE_OPERATIONAL")
    assert FLIGHT.refusals() == [message], FLIGHT.refusals()
    FLIGHT.ground.await_state("OFFLINE")


def case_good_devices_are_commissioned_and_flown():
    drive_deviations.fly_without_deviations(FLIGHT)


def case_a_late_answer_is_refused():
    refused(drive_deviations.late, (0x12, drive_deviations.TIMEOUT, 0x100000, 0))


def case_another_type_of_device_is_refused():
    refused(drive_deviations.other_type, (0x12, drive_deviations.VALUE, 0x100000, 0x00010192))


def case_a_device_with_another_product_code_is_refused():
    """The slave has the same profile and mapping, but another product code."""
    refused(drive_deviations.other_product, (0x12, drive_deviations.VALUE, 0x101802, 0x2015))


def case_a_value_of_another_size_is_refused():
    refused(drive_deviations.short_value, (0x12, drive_deviations.FORMAT, 0x607600, 0))


def case_a_missing_object_is_refused():
    refused(drive_deviations.without_mapping, (0x12, drive_deviations.ABORTED, 0x1A0100, 0x06020000))


def case_a_device_that_boots_repeatedly_is_refused():
    refused(drive_deviations.reboots_repeatedly, (0x12, drive_deviations.REBOOTED, 0, 0))


def case_the_flight_ends_without_error():
    FLIGHT.close()
    (pathlib.Path(os.environ["OUT"]) / "can-robot.log").write_bytes(FLIGHT.flight.octets("can-robot.log"))
    assert FLIGHT.flight.code == 0, FLIGHT.flight.transcript()


if __name__ == "__main__":
    sys.setswitchinterval(0.0005)  # The bus and the task that waits for it take turns.
    DIRECTORY = pathlib.Path("/tmp/deviation")
    DIRECTORY.mkdir(exist_ok=True)
    FLIGHT = drive_deviations.SlaveFlight(DIRECTORY, "vcan-robot", ("--bus", "vcan"))
    try:
        cases.run({name: what for name, what in globals().items() if name.removeprefix("case_") in sys.argv[1:]})
    finally:
        FLIGHT.flight.abandon()
