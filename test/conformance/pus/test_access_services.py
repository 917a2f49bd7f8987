# SPDX-License-Identifier: Apache-2.0
"""Services 2 and 6 of a subsystem in flight: the manipulator's memory, and the objects of its drives."""

import binascii
import struct

import pytest

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
OUT_OF_RANGE = 0x0203
ACCESS = 0x0206
ADDRESS = 0x0207
PROTECTED = 0x0208
DATA_CHECKSUM = 0x020D
DEVICE = 0x0403

SUBSYSTEM = "MANIPULATOR"
JOINT = 0x11  # CAN node.
PARAMETERS, COMPONENT = 1, 2  # Memories.
TEMPERATURE, BRAKE, ERROR_WINDOW = 1, 2, 3  # Quantities of a joint.


def settle_state(station, apid, target):
    """Send TC[129,1] and wait for its end."""
    outcome = station.settle(station.send_data(apid, 129, 1, bytes([target])))
    assert outcome.is_completed, (target, outcome.failure)


@pytest.fixture(scope="module")
def arm(station):
    """The manipulator in a configuration, so that its drives are commissioned; at the end it returns to its
    former state."""
    apid = station.dictionary.subsystem(SUBSYSTEM).apid
    nominal = next(mode["id"] for mode in station.dictionary.content["modes"] if mode["name"] == "NOMINAL")
    assert station.settle(station.send_data(1, 131, 1, bytes([nominal]))).is_completed
    settle_state(station, apid, 3)
    assert station.settle(station.send_data(apid, 129, 3, struct.pack(">H", 1))).is_completed
    yield apid
    settle_state(station, apid, 0)


def crc(octets):
    """CRC-16 of the standard."""
    return binascii.crc_hqx(octets, 0xFFFF)


def protocol(index, subindex, length):
    """Protocol-specific data."""
    return struct.pack(">HBB", index, subindex, length).hex()


def acquire(station, index, subindex=0, length=0, transaction=7):
    """Data of TM[2,9]."""
    answer = station.ask(SUBSYSTEM, 2, 8, n=[{
        "transaction_id": transaction, "physical_device_id": JOINT, "protocol_specific_data": protocol(index, subindex, length)}])
    assert (answer["transaction_id"], answer["data_acquisition_return_code"]) == (transaction, 0)
    return bytes.fromhex(answer["data_block"])


def command(index, octets, device=JOINT, length=None):
    """Fields of one instruction of TC[2,7]."""
    specific = protocol(index, 0, len(octets) if length is None else length)
    return {"physical_device_id": device, "protocol_specific_data": specific, "command_data": octets.hex()}


def test_objects_of_a_drive_are_read_and_written(station, arm):
    assert acquire(station, 0x1000, length=4)[:2] == struct.pack("<H", 402)  # Device type: CiA 402.
    before = acquire(station, 0x6065)  # Following error window.
    changed = struct.pack("<I", struct.unpack("<I", before)[0] - 1)
    station.do(SUBSYSTEM, 2, 7, n=[command(0x6065, changed)])
    assert acquire(station, 0x6065) == changed
    station.do(SUBSYSTEM, 2, 7, n=[command(0x6065, before)])


def test_one_faulty_command_refuses_the_whole_request(station, arm):
    before = acquire(station, 0x6065)
    outcome = station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 7, n=[command(0x6065, b"\0\0\0\0"), command(0x6065, before, device=0x44)])
    assert outcome.failure.instruction == 2
    station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 7, n=[command(0x6065, before, length=2)])
    assert acquire(station, 0x6065) == before


def test_a_command_that_a_drive_refuses_is_reported(station, arm):
    since = len(station.reports)
    outcome = station.refuse(DEVICE, SUBSYSTEM, 2, 8, n=[{
        "transaction_id": 1, "physical_device_id": JOINT, "protocol_specific_data": protocol(0x5FFF, 0, 0)}])
    assert outcome.failure.detail == 0x06020000, "expected the abort code of an object that does not exist"
    _, report = station.report(2, 9, where=lambda fields: fields["transaction_id"] == 1)
    assert (report["data_acquisition_return_code"], report["data_block"]) == (0x0602, "")
    station.report(1, 6, since=since)
    assert [(failure.stage, failure.step, failure.code) for failure in outcome.failures] == [(6, 1, DEVICE), (8, None, DEVICE)]


def test_registers_are_objects_of_32_bits(station, arm):
    register = JOINT << 24 | 0x6065 << 8
    value = station.ask(SUBSYSTEM, 2, 5, n=[{"register_address": register}])["n"][0]["register_data"]
    assert value == struct.unpack("<I", acquire(station, 0x6065))[0]
    station.do(SUBSYSTEM, 2, 2, n=[{"register_address": register, "register_data": value - 5}])
    assert struct.unpack("<I", acquire(station, 0x6065))[0] == value - 5
    station.do(SUBSYSTEM, 2, 2, n=[{"register_address": register, "register_data": value}])


def test_unknown_devices_are_refused(station, arm):
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 1, n=[{"on_off_device_address": 1}])
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 4, n1=[
        {"cpdu_id": 1, "n2": [{"output_line_id": 5, "reserved": 0, "duration_exponential_value": 2}]}])
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 10, n=[{"logical_device_id": 1, "command_id": 1, "command_arguments": ""}])
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 2, 11, n=[{"transaction_id": 1, "logical_device_id": 1, "parameter_id": TEMPERATURE}])


def quantity(station, identity, transaction=3):
    """Value of a quantity of the first joint by TM[2,12]."""
    answer = station.ask(SUBSYSTEM, 2, 11, n=[{"transaction_id": transaction, "logical_device_id": JOINT, "parameter_id": identity}])
    assert (answer["transaction_id"], answer["data_acquisition_return_code"]) == (transaction, 0)
    return struct.unpack(">d", bytes.fromhex(answer["parameter_value"]))[0]


def order(identity, value):
    """Fields of one instruction of TC[2,10]."""
    return {"logical_device_id": JOINT, "command_id": identity, "command_arguments": struct.pack(">d", value).hex()}


def test_quantities_of_a_drive_are_in_engineering_units(station, arm):
    assert 0 < quantity(station, TEMPERATURE) < 60
    assert quantity(station, BRAKE) == 1, "the brake is not engaged while the arm rests"
    before = struct.unpack("<I", acquire(station, 0x6065))[0]
    assert quantity(station, ERROR_WINDOW) == pytest.approx(before * 1e-6)
    station.do(SUBSYSTEM, 2, 10, n=[order(ERROR_WINDOW, 0.04)])
    assert struct.unpack("<I", acquire(station, 0x6065))[0] == 40000
    station.do(SUBSYSTEM, 2, 10, n=[order(ERROR_WINDOW, before * 1e-6)])
    assert struct.unpack("<I", acquire(station, 0x6065))[0] == before


def test_an_unknown_or_unsettable_quantity_of_a_drive_is_refused(station, arm):
    station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 11, n=[{"transaction_id": 1, "logical_device_id": JOINT, "parameter_id": 99}])
    station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 10, n=[order(TEMPERATURE, 20.0)])
    station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 10, n=[order(ERROR_WINDOW, -1.0)])
    station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 10, n=[order(ERROR_WINDOW, float("nan"))])
    outcome = station.refuse(OUT_OF_RANGE, SUBSYSTEM, 2, 10, n=[order(ERROR_WINDOW, 0.03), order(ERROR_WINDOW, 1e9)])
    assert outcome.failure.instruction == 2
    assert quantity(station, ERROR_WINDOW) != pytest.approx(0.03)


# --- memory ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def settable(station, arm):
    """A parameter of two DOUBLE that does not change while the arm rests."""
    return station.dictionary.subsystem(SUBSYSTEM).parameter("TORQUE_LIMIT")


def dump_object(station, base, offset, length):
    """Octets of an object of the parameters."""
    areas = station.ask(SUBSYSTEM, 6, 3, memory_id=PARAMETERS, base_id=base, n=[{"offset": offset, "length": length}])["n"]
    data = b"".join(bytes.fromhex(area["data"]) for area in areas)
    assert all(area["checksum"] == crc(bytes.fromhex(area["data"])) for area in areas)
    return data


def load(station, base, octets, checksum=None):
    """Fields of TC[6,1]."""
    area = {"offset": 0, "data": octets.hex(), "checksum": crc(octets) if checksum is None else checksum}
    return {"memory_id": PARAMETERS, "base_id": base, "n": [area]}


def test_parameters_are_loaded_and_dumped_in_place(station, settable):
    base = settable.parameter_id
    before = dump_object(station, base, 0, 8)
    second = dump_object(station, base, 8, 8)
    station.do(SUBSYSTEM, 6, 1, **load(station, base, struct.pack("=d", 0.125)))
    assert dump_object(station, base, 0, 16) == struct.pack("=d", 0.125) + second
    whole = station.ask(SUBSYSTEM, 6, 17, memory_id=PARAMETERS, base_id=base)
    assert (whole["length"], whole["checksum"]) == (16, crc(struct.pack("=d", 0.125) + second))
    part = station.ask(SUBSYSTEM, 6, 7, memory_id=PARAMETERS, base_id=base, n=[{"offset": 4, "length": 4}])["n"][0]
    assert part["checksum"] == crc(struct.pack("=d", 0.125)[4:])
    station.refuse(DATA_CHECKSUM, SUBSYSTEM, 6, 1, **load(station, base, before, checksum=crc(before) ^ 1))
    station.do(SUBSYSTEM, 6, 1, **load(station, base, before))
    assert dump_object(station, base, 0, 8) == before


def test_a_large_dump_is_sent_in_many_reports(station, arm):
    length = 5000
    answer = station.ask(SUBSYSTEM, 6, 5, memory_id=COMPONENT, n=[{"start_address": 0, "length": length}])
    assert len(answer["n"]) >= 2
    assert sum(len(area["data"]) // 2 for area in answer["n"]) == length
    following = [area["start_address"] for area in answer["n"]]
    assert following == sorted(following)


def test_a_check_of_raw_areas_reports_their_data_and_refuses_a_wrong_address_or_memory(station, arm):
    areas = station.ask(SUBSYSTEM, 6, 9, memory_id=COMPONENT, n=[{"start_address": 64, "length": 4096}])["n"]
    assert (areas[0]["start_address"], areas[0]["length"]) == (64, 4096)
    station.refuse(ADDRESS, SUBSYSTEM, 6, 9, memory_id=COMPONENT, n=[{"start_address": 0xFFFFFFFF, "length": 2}])
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 6, 9, memory_id=77, n=[{"start_address": 0, "length": 1}])


def test_a_memory_is_protected_and_scrubbed(station, settable):
    base = settable.parameter_id
    before = dump_object(station, base, 0, 8)
    station.do(SUBSYSTEM, 6, 15, memory_id=PARAMETERS)
    station.refuse(PROTECTED, SUBSYSTEM, 6, 1, **load(station, base, before))
    station.do(SUBSYSTEM, 6, 16, memory_id=PARAMETERS)
    station.do(SUBSYSTEM, 6, 1, **load(station, base, before))
    station.do(SUBSYSTEM, 6, 13, memory_id=COMPONENT)
    station.do(SUBSYSTEM, 6, 14, memory_id=COMPONENT)
    station.refuse(PROTECTED, SUBSYSTEM, 6, 2, memory_id=COMPONENT, n=[{"start_address": 0, "data": "00", "checksum": crc(b"\0")}])
    station.do(SUBSYSTEM, 6, 12)


def define_double(station, base, number, offset):
    """Define a parameter by its address, in an object of the parameters. Returns (id, what TC[20,6] reports of it)."""
    defined = station.dictionary.subsystem(SUBSYSTEM).apid << 21 | 9 << 16 | number  # A DOUBLE.
    place = {"parameter_id": defined, "memory_id": PARAMETERS, "base_id": base, "offset": offset, "ptc": 5, "pfc": 2}
    station.do(SUBSYSTEM, 20, 5, n=[place])
    return defined, station.ask(SUBSYSTEM, 20, 6, n=[{"parameter_id": defined}])["n"][0]


def test_raw_memory_is_loaded_in_areas_and_bits(station, settable):
    base, pattern = settable.parameter_id, struct.pack("=d", 0.1)  # No octet is 0.
    before = dump_object(station, base, 0, 8)
    start = define_double(station, base, 901, 0)[1]["start_address"]
    place = station.ask(SUBSYSTEM, 6, 5, memory_id=PARAMETERS, n=[{"start_address": start, "length": 8}])["n"][0]
    assert bytes.fromhex(place["data"]) == before
    station.do(SUBSYSTEM, 6, 2, memory_id=PARAMETERS, n=[{"start_address": start, "data": pattern.hex(), "checksum": crc(pattern)}])
    assert dump_object(station, base, 0, 8) == pattern
    station.do(SUBSYSTEM, 6, 11, memory_id=PARAMETERS, start_address=start, bit_mask="0f00f0ff", data="00000000")
    masked = bytes(octet & ~mask for octet, mask in zip(pattern, bytes.fromhex("0f00f0ff00000000")))
    assert dump_object(station, base, 0, 8) == masked
    station.do(SUBSYSTEM, 6, 2, memory_id=PARAMETERS, n=[{"start_address": start, "data": before.hex(), "checksum": crc(before)}])
    assert dump_object(station, base, 0, 8) == before


def test_a_load_by_reference_without_files_is_refused(station, settable):
    area = {"start_address": 0, "offset_in_file": 0, "length": 1, "checksum": 0}
    names = {"repository_path": "/", "file_name": "x"}
    station.refuse(UNKNOWN_ID, SUBSYSTEM, 6, 19, memory_id=PARAMETERS, n=[area], **names)


def test_parameters_are_defined_by_their_address_in_memory(station, settable):
    base = settable.parameter_id
    defined, found = define_double(station, base, 900, 8)
    assert (found["memory_id"], found["ptc"], found["pfc"]) == (PARAMETERS, 5, 2)
    value = struct.unpack("=d", dump_object(station, base, 8, 8))[0]
    outcome = station.do(SUBSYSTEM, 20, 1, n=[{"parameter_id": defined}])
    raw = next(packet.data for packet, _ in outcome.replies if packet.message == (20, 2))
    assert struct.unpack(">d", raw[6:14])[0] == value
    raw_place = {"parameter_id": defined, "memory_id": PARAMETERS, "start_address": found["start_address"], "ptc": 5, "pfc": 2}
    station.do(SUBSYSTEM, 20, 4, n=[raw_place])
    station.refuse(ACCESS, SUBSYSTEM, 20, 4, n=[{**raw_place, "parameter_id": base}])
