# SPDX-License-Identifier: Apache-2.0
"""Hardware that is changed in only one of the files which name it: each such change is told, before the flight with file and line, or in
commissioning with the node or number of the device. test_mission_swaps.py and test_mission_zoo.py fly the complete changes."""

import re
import struct

import flying
import pytest

NO_ANSWER, OTHER_VALUE = 1, 4  # Reasons of a device on CAN in DEVICE_REFUSED.
CLOSED, SILENT, INVALID = 1, 2, 3  # Causes of a stream device in DEVICE_REFUSED.
BOOM = re.compile(r'      <Device name="BOOM" type="joint-drive">.*?</Device>\n', re.DOTALL)
BENCH = re.compile(r"  <Bench .*?/>\n")
INSTRUMENT = re.compile(r'  <Instrument name="MIRROR".*?/>\n')


@pytest.fixture
def tree(tmp_path):
    """A copy of the descriptors; programs and scenarios are those of the project."""
    return flying.descriptors_copied(tmp_path / "tree")


def _fly(tree, mission, subsystem):
    """Bring the subsystem up to its configuration NOMINAL."""
    scenario = flying.write_scenario(tree / "up.scn", f"0.2 operator state {subsystem} PRE_OPERATIONAL",
                                     f"0.8 operator config {subsystem} NOMINAL", "1.2 operator shutdown")
    return flying.fly(tree / "run", "--mission", mission, "--scenario", scenario, "--form", "image", root=tree)


def _edit(tree, kind, name, old, new):
    path = tree / f"descriptors/{kind}/{name}.xml"
    text, count = re.subn(old, new, path.read_text(encoding="utf-8"))
    assert count > 0, old
    path.write_text(text, encoding="utf-8")


def _first_refusal(flight, apid, octets):
    """First octets of the data of the first event DEVICE_REFUSED, an event of severity LOW."""
    return next(raw[23:23 + octets] for _, way, raw in flight.packets if way == "TM" and raw[7:9] == bytes((5, 2)) and raw[1] == apid)


def _assert_told_before_the_flight(flight, words):
    """Expect exit code 1, one line with file and line, and no stack trace."""
    said = flight.output + flight.console
    assert flight.code == 1, flight.transcript()
    assert re.search(rf"\w+\.xml:\d+: [^\n]*{re.escape(words)}", said), flight.transcript()
    assert "Traceback" not in said


@pytest.mark.parametrize(("kind", "old", "new", "words"), [
    ("subsystems", 'priority="60" samplingTime="1ms"', 'priority="60" samplingTime="2ms"', "0x60C2: expected samplingTime"),
    ("subsystems", 'priority="60" samplingTime="1ms"', 'priority="60" samplingTime="500us"', "0x60C2: expected samplingTime"),
    ("subsystems", '"0x60C2:01" type="UINT8" value="10"', '"0x60C2:01" type="UINT8" value="20"', "0x60C2: expected samplingTime"),
    ("subsystems", 'bus="platform" node="0x3A"', 'bus="thrusters" node="0x3A"', "expected a bus of the mission"),
    ("missions", '<Bus name="platform"', '<Bus name="platform-2"', "expected a bus of the mission"),
    ("worlds", 'eds="gyro.eds"', 'eds="other.eds"', "other.eds: cannot be read"),
    ("subsystems", '<Device name="GYRO" type="gyro">', '<Device name="GYRO" type="gyro-2">', "expected a class of descriptors/devices: gyro "),
    ("subsystems", '<Endnode type="CAN" bus="platform" node="0x2B"/>', '<Endnode type="UDP" address="127.0.0.1" port="9000"/>',
     "type of <Endnode>: expected CAN"),
    ("worlds", r'(  <Bench .*?/>\n)', r"\1\1", "expected a name that no device above has"),
], ids=["longer-period", "shorter-period", "period-of-set-points", "bus", "mission", "sheet", "class", "end-node", "axis"])
def test_a_half_swap_that_the_files_show_is_told_before_the_flight(tree, kind, old, new, words):
    _edit(tree, kind, "actuators", old, new)
    _assert_told_before_the_flight(_fly(tree, "actuators", "ACTUATORS"), words)


@pytest.mark.parametrize(("kind", "old", "new", "node", "reason"), [
    ("subsystems", 'node="0x25"', 'node="0x05"', 0x05, NO_ANSWER),
    ("worlds", 'node="0x25"', 'node="0x05"', 0x25, NO_ANSWER),
    ("worlds", BENCH, "", 0x25, NO_ANSWER),
    ("subsystems", 'name="BOOM" type="joint-drive"', 'name="BOOM" type="servo-drive"', 0x25, OTHER_VALUE),
    ("worlds", 'eds="joint-drive.eds"', 'eds="servo-drive.eds"', 0x25, OTHER_VALUE),
    ("subsystems", '<Device name="GYRO" type="gyro">', '<Device name="GYRO" type="rate-sensor">', 0x2B, OTHER_VALUE),
    ("worlds", 'eds="gyro.eds"', 'eds="rate-sensor.eds"', 0x2B, OTHER_VALUE),
    ("subsystems", '<Device name="GYRO" type="gyro">', '<Device name="TRACKER" type="star-tracker">', 0x2B, OTHER_VALUE),
    ("subsystems", BOOM, lambda found: found[0] + found[0].replace('"BOOM"', '"BOOM2"').replace('25"/>', '26"/>'), 0x26, NO_ANSWER),
], ids=["node-on-board", "node", "drive-missing", "maker-on-board", "maker", "gyro-on-board", "gyro", "profile-on-board", "axis-on-board"])
def test_a_half_swap_of_a_device_on_can_is_told_with_its_node(tree, kind, old, new, node, reason):
    _edit(tree, kind, "actuators", old, new)
    flight = _fly(tree, "actuators", "ACTUATORS")
    assert flight.code != 0, flight.transcript()
    assert struct.unpack("BB", _first_refusal(flight, 41, 2)) == (node, reason), flight.transcript()
    assert "Traceback" not in flight.output + flight.console


@pytest.mark.parametrize(("kind", "old", "new", "number", "cause"), [
    ("subsystems", 'type="SHM" name="mirror"', 'type="MQUEUE" name="mirror"', 0, CLOSED),
    ("worlds", 'type="SHM" channel="mirror"', 'type="MQUEUE" channel="mirror"', 0, CLOSED),
    ("worlds", 'channel="mirror"', 'channel="mirror-2"', 0, CLOSED),
    ("worlds", INSTRUMENT, "", 0, CLOSED),
    ("subsystems", 'port="15001"', 'port="15009"', 1, CLOSED),
    ("subsystems", 'port="15001" order="LITTLE"', 'port="15001"', 1, INVALID),
    ("subsystems", 'framing="LENGTH"', 'framing="SLIP"', 3, INVALID),
    ("worlds", 'checksum="true" period="4ms"', 'period="4ms"', 2, CLOSED),
    ("subsystems", 'name="filter" order="LITTLE" checksum="true"', 'name="filter" order="LITTLE"', 2, SILENT),
    ("subsystems", 'type="INT32" scale="1e-6"', 'type="INT16" scale="1e-6"', 0, CLOSED),
], ids=["type-on-board", "type", "name", "missing", "port-on-board", "order-on-board", "framing-on-board", "checksum", "checksum-on-board",
        "length-on-board"])
def test_a_half_swap_of_a_stream_device_is_told_with_its_number(tree, kind, old, new, number, cause):
    _edit(tree, kind, "instruments" if kind == "subsystems" else "zoo", old, new)
    flight = _fly(tree, "zoo", "INSTRUMENTS")
    assert struct.unpack("BB", _first_refusal(flight, 40, 2)) == (number, cause), flight.transcript()
    assert "Traceback" not in flight.output + flight.console
