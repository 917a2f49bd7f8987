# SPDX-License-Identifier: Apache-2.0
"""On/off devices and command pulses of service 2: the power unit of the arm cuts the supply of a drive and
restores it.

These tests have a flight of their own, because the loss of a drive shuts the whole network down."""

import pathlib
import shutil
import signal
import struct
import tempfile

import pytest
import station as stations

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
OUT_OF_RANGE = 0x0203

ROOT = pathlib.Path(__file__).resolve().parents[3]
SUBSYSTEM = "MANIPULATOR"
UNIT, JOINT, OTHER = 0x1F, 0x11, 0x12  # CAN nodes.
ON, OFF = 1, 2  # Output lines of the joint's supply.
OFFLINE, PRE_OPERATIONAL, SAFE_OPERATIONAL = 0, 3, 4
LATCH = 1  # Exponent of the shortest pulse that moves a relay.


@pytest.fixture(scope="module")
def station(notes):
    """A ground station over a flight whose arm loses a drive."""
    place = ROOT / "build" / "test"
    place.mkdir(parents=True, exist_ok=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="pus-supplies-", dir=place))
    flight = stations.launch(directory)
    ground = stations.Station(flight, notes)
    yield ground
    ground.close()
    assert flight.process.poll() is None, f"the flight ended by itself\n{flight.transcript()}"
    flight.process.send_signal(signal.SIGINT)
    flight.wait()
    shutil.rmtree(directory, ignore_errors=True)


def apid(station):
    return station.dictionary.subsystem(SUBSYSTEM).apid


def state_of(station):
    """State of the subsystem by the latest TM[129,2]."""
    return next((packet.data[1] for packet, _ in reversed(station.reports) if packet.message == (129, 2) and packet.apid == apid(station)), OFFLINE)


def begin_state(station, target):
    return station.send_data(apid(station), 129, 1, bytes([target]))


def nominal(station):
    identity = next(mode["id"] for mode in station.dictionary.content["modes"] if mode["name"] == "NOMINAL")
    assert station.settle(station.send_data(1, 131, 1, bytes([identity]))).is_completed


def commission(station):
    """Boot the drives and write their settings."""
    outcome = station.settle(begin_state(station, PRE_OPERATIONAL))
    assert outcome.is_completed, outcome.failure
    assert station.settle(station.send_data(apid(station), 129, 3, struct.pack(">H", 1))).is_completed


def device_type(station, node):
    """Read object 1000h of a drive: its lower half is the number of the device profile. Only a drive that has power answers."""
    # Protocol-specific data: object 1000h:00, length 4.
    answer = station.ask(SUBSYSTEM, 2, 8, n=[{"transaction_id": 1, "physical_device_id": node, "protocol_specific_data": "10000004"}])
    return struct.unpack("<H", bytes.fromhex(answer["data_block"])[:2])[0]


def switch(line, unit=UNIT):
    """Fields of TC[2,1]."""
    return {"n": [{"on_off_device_address": unit << 8 | line}]}


def pulse(line, exponent=LATCH, unit=UNIT, reserved=0):
    """Fields of TC[2,4]."""
    return {"n1": [{"cpdu_id": unit, "n2": [{"output_line_id": line, "reserved": reserved, "duration_exponential_value": exponent}]}]}


def lose(station, subtype, fields):
    """Cut the supply of the joint and wait until the network is down."""
    since = len(station.reports)
    station.do(SUBSYSTEM, 2, subtype, **fields)
    packet, _ = station.report(5, 4, apid=apid(station), since=since, where=lambda fields: fields["event"] == "DEVICE_LOST")
    assert packet.data[2] == JOINT
    station.wait(lambda: state_of(station) == OFFLINE, "the end of the network's way down")
    nominal(station)


def restore(station, subtype, fields):
    """Restore the supply while the subsystem is OFFLINE, so that the service opens the bus; then commission
    the drive, which boots."""
    station.do(SUBSYSTEM, 2, subtype, **fields)
    commission(station)
    assert [device_type(station, node) for node in (JOINT, OTHER)] == [402, 402]


def test_a_drive_is_switched_off_and_on(station):
    nominal(station)
    commission(station)
    lose(station, 1, switch(OFF))
    restore(station, 1, switch(ON))
    settled = station.settle(begin_state(station, SAFE_OPERATIONAL))
    assert settled.is_completed, settled.failure


def test_a_pulse_of_a_cpdu_moves_a_relay_if_it_is_long_enough(station):
    station.do(SUBSYSTEM, 2, 4, **pulse(OFF, exponent=LATCH - 1))
    assert device_type(station, JOINT) == 402
    lose(station, 4, pulse(OFF))
    restore(station, 4, pulse(ON))


def test_an_unknown_output_is_refused(station):
    for unit, line in ((0, 1), (UNIT, 0), (UNIT, 5), (UNIT + 1, OFF), (0xFF, 0xFF)):
        station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 1, **switch(line, unit))
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 4, **pulse(OFF, unit=UNIT + 1))
    for fields in (pulse(0), pulse(5), pulse(0x100 + OFF), pulse(0xFFF), pulse(OFF, reserved=1)):
        station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 4, **fields)
    assert device_type(station, JOINT) == 402


def test_a_faulty_pulse_among_several_is_skipped(station):
    fields = pulse(ON)
    fields["n1"][0]["n2"] += pulse(5)["n1"][0]["n2"] + pulse(ON + 2)["n1"][0]["n2"]
    outcome = station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 4, **fields)
    assert [failure.instruction for failure in outcome.failures if failure.instruction] == [2]
    assert device_type(station, JOINT) == 402
