# SPDX-License-Identifier: Apache-2.0
"""Hardware that is changed by XML only, without a build: node, bus, period, channel, bit rate, profile,
number of axes. test_mission_makers.py flies drives of other manufacturers, test_mission_zoo.py other end
nodes, test_mission_arm.py arms with other numbers of joints."""

import json
import re
import statistics
import struct
import sys

import cantools
import flying
import numpy as np
import pytest
from hirosco_gse import run as runs

sys.path.insert(0, str(flying.ROOT / "gse" / "generator"))

import dbc
import mission as missions

SUBSYSTEM, WORLD, MISSION = (f"descriptors/{kind}/actuators.xml" for kind in ("subsystems", "worlds", "missions"))
BUS = '<Bus name="platform" bitRate="1000000" dataBitRate="5000000"/>'
REST = ",0" * 6
LINES = (
    "0.2 operator state ACTUATORS PRE_OPERATIONAL",
    "0.8 operator config ACTUATORS NOMINAL",
    "1.0 operator state ACTUATORS SAFE_OPERATIONAL",
    "1.2 operator state ACTUATORS OPERATIONAL",
    f"1.5 operator set ACTUATORS.TARGET 0.1,-0.15{REST}",
    f"1.5 operator set ACTUATORS.OUTPUT 0,3,0{REST},0,0,0,0,0,0,0",
    f"2.0 operator set ACTUATORS.OUTPUT 0,0,0{REST},0,0,0,0,0,0,0",
    "3.0 operator hk once ACTUATORS 1",
    "3.2 operator shutdown",
)


@pytest.fixture
def tree(tmp_path):
    """A copy of the descriptors; programs and scenarios are those of the project."""
    return flying.descriptors_copied(tmp_path / "tree")


def _fly(root, directory, lines=LINES):
    scenario = flying.write_scenario(directory.with_suffix(".scn"), *lines)
    flight = flying.fly(directory, "--mission", "actuators", "--scenario", scenario, "--form", "image", root=root)
    assert flight.code == 0, flight.transcript()
    return flight


@pytest.fixture(scope="module")
def unchanged(session_directory):
    """The flight before any change."""
    return _fly(flying.ROOT, session_directory / "unchanged")


def _reported(flight, name):
    """An array of the last housekeeping report."""
    steps = [json.loads(line) for line in flight.read("operator.log").splitlines()]
    report = next(step["outcome"] for step in reversed(steps) if step["verb"] == "hk")
    return [float(number) for number in re.search(rf"{name}: \[([-+0-9.e, ]+)\]", report)[1].split(", ")]


def _frames(flight, bus, identifier):
    """Times [s] of the frames of an identifier."""
    return [float(time) for time in re.findall(rf"\((\d+\.\d+)\) {bus} {identifier:03X}#", flight.read(f"can-{bus}.log"))]


def _answer_s(flight):
    """Shortest time from SYNC to the statusword of the boom."""
    syncs, answers = (iter(_frames(flight, "platform", identifier)) for identifier in (0x080, 0x1A5))
    found, answer = [], 0.0
    for sync in syncs:
        while answer <= sync:
            answer = next(answers, None)
            if answer is None:
                return min(found)
        found.append(answer - sync)
    return min(found)


def _assert_boom_and_satellite_moved(flight):
    """Expect that the boom is at its target, and that the thrusters have turned the satellite: 1 Nm for 0.5
    s, 60 kgm2."""
    assert abs(_reported(flight, "POSITION")[0] - 0.1) < 1e-3
    assert abs(_reported(flight, "INPUT")[4] - 0.5 / 60.0) < 3e-4


def test_the_unchanged_mission_flies(unchanged):
    _assert_boom_and_satellite_moved(unchanged)
    assert _reported(unchanged, "POSITION")[1] == 0
    dictionary = json.loads((flying.ROOT / "build/generated/actuators.json").read_text(encoding="utf-8"))
    assert int(unchanged.facts["device_classes_hash"], 0) == int(dictionary["device_classes_hash"], 0)


@pytest.mark.parametrize(("rates", "least", "most"), [
    ('bitRate="500000" dataBitRate="2000000"', 1.8, 2.6),
    ('bitRate="1000000"', 1.5, 3.0),
    ('bitRate="800000"', 2.0, 4.0),
], ids=["slower", "classic", "slow-classic"])
def test_a_bus_with_another_bit_rate_flies(tree, tmp_path, unchanged, rates, least, most):
    """Answers to SYNC take longer in proportion to the bit rates; FD frames occur only if the bus has a data rate."""
    flying.replace(tree / MISSION, (BUS, f'<Bus name="platform" {rates}/>'))
    flight = _fly(tree, tmp_path / "run")
    _assert_boom_and_satellite_moved(flight)
    assert least < _answer_s(flight) / _answer_s(unchanged) < most
    assert ("##" in flight.read("can-platform.log")) == ("dataBitRate" in rates)


def test_devices_with_another_node_bus_and_period_fly(tree, tmp_path):
    """The boom is node 0x05, the valves are on a separate bus, and a cycle lasts 2 ms."""
    flying.replace(tree / MISSION, (BUS, BUS + BUS.replace("platform", "thrusters")))
    flying.replace(tree / SUBSYSTEM, ('node="0x25"', 'node="0x05"'), ("25\"/>", "05\"/>"), ('bus="platform" node="0x3A"', 'bus="thrusters" node="0x3A"'),
                   ('priority="60" samplingTime="1ms"', 'priority="60" samplingTime="2ms"'), ('0x60C2:01" type="UINT8" value="10"', '0x60C2:01" type="UINT8" value="20"'),
                   ('1400:05" type="UINT16" value="4"', '1400:05" type="UINT16" value="8"'))
    flying.replace(tree / WORLD, ('node="0x25"', 'node="0x05"'), ('bus="platform" node="0x3A"', 'bus="thrusters" node="0x3A"'))
    flight = _fly(tree, tmp_path / "run")
    _assert_boom_and_satellite_moved(flight)
    for bus, identifier in (("platform", 0x185), ("thrusters", 0x1BA)):
        syncs = _frames(flight, bus, 0x080)
        assert {round(after - before, 3) for before, after in zip(syncs, syncs[1:])} == {0.002}
        assert len(_frames(flight, bus, identifier)) > 900
    assert not _frames(flight, "platform", 0x1A5) and not _frames(flight, "platform", 0x1BA)


def test_devices_with_a_second_channel_fly(tree, tmp_path):
    """Every device gets a second channel, on which the master begins: the devices change to it, and the first
    channel has no frames."""
    flying.replace(tree / MISSION, (BUS, BUS.replace("platform", "platform-b") + BUS.replace("/>", ' redundantTo="platform-b"/>')))
    flying.replace(tree / SUBSYSTEM, ('bus="platform"', 'bus="platform-b" redundantBus="platform"'))
    flying.replace(tree / WORLD, ('bus="platform"', 'bus="platform-b"'))
    flight = _fly(tree, tmp_path / "run")
    _assert_boom_and_satellite_moved(flight)
    assert len(_frames(flight, "platform-b", 0x1A5)) > 1900
    assert not _frames(flight, "platform", 0x1A5)


def test_a_device_of_another_profile_flies(tree, tmp_path):
    """A star tracker, which has no CiA profile, replaces the gyro of CiA 404: an attitude instead of
    rates."""
    flying.replace(tree / SUBSYSTEM, ('<Device name="GYRO" type="gyro">', '<Device name="TRACKER" type="star-tracker">'))
    flying.replace(tree / WORLD, ('<Gyro name="GYRO" on="satellite.body" noise="1e-5" bias="2e-6"',
                                   '<StarTracker name="TRACKER" on="satellite.body" rate="20" noise="1e-5 1e-5 1e-5"'), ("gyro.eds", "star-tracker.eds"))
    flight = _fly(tree, tmp_path / "run")
    attitude = [value * 1e-9 for value in _reported(flight, "INPUT")[2:6]]
    turned = 0.5 / 60.0 * (0.25 + 1.0)  # rad: during half of the thrust time and after it
    assert abs(attitude[0] - 1.0) < 1e-3 and abs(2.0 * attitude[3] - turned) < 1e-3
    assert max(map(abs, attitude[1:3])) < 1e-4
    assert abs(_reported(flight, "POSITION")[0] - 0.1) < 1e-3


def test_a_gyro_of_another_maker_with_real_numbers_flies(tree, tmp_path):
    """The rates are REAL32 (0x6130 of CiA 404): the same numbers are in the frames, in the housekeeping report and, with the noise of the gyro,
    in the truth."""
    flying.replace(tree / SUBSYSTEM, ('<Device name="GYRO" type="gyro">', '<Device name="GYRO" type="rate-sensor">'))
    flying.replace(tree / WORLD, ('eds="gyro.eds"', 'eds="rate-sensor.eds"'))
    flight = _fly(tree, tmp_path / "run")
    _assert_boom_and_satellite_moved(flight)
    *rates, counter, status = _reported(flight, "INPUT")[2:7]
    text = dbc.databases(missions.load(tree / MISSION))["platform"]
    database = cantools.database.load_string(text, "dbc")
    sent = {number: [(float(time), bytes.fromhex(octets)) for time, octets in re.findall(rf"\((\d+\.\d+)\) platform {number:03X}##1([0-9A-F]+)",
                                                                                      flight.read("can-platform.log"))] for number in (0x1AB, 0x2AB)}
    frame = next(i for i, (_, octets) in enumerate(sent[0x2AB]) if struct.unpack_from("<H", octets, 4)[0] == counter)
    octets = [sent[number][frame][1] for number in sent]
    in_frames = struct.unpack("<3f", octets[0][:8] + octets[1][:4])
    decoded = [value for number, each in zip(sent, octets) for value in database.decode_message(number, each).values()]
    assert decoded == pytest.approx([*in_frames, counter, status])
    assert rates == pytest.approx(in_frames, rel=1e-6) and status == 0
    sampled_s = sent[0x1AB][frame][0]
    base = runs.load(flight.directory).truth["BASE"]
    true = base["rate_rad_s"][np.searchsorted(base["time_us"], sampled_s * 1e6)].ravel()
    assert true[2] > 8e-3 and rates == pytest.approx(true, abs=6e-5)


def test_a_valve_box_of_another_maker_with_a_real_output_flies(tree, tmp_path):
    """The longest time of the valves is REAL32 in the RPDO: the frames, the database of the bus and the reported parameter have the same number.
    The unplugged box closes its valves 2.55 ms after its last command, before its RPDO deadline; an integer of 10 ms could not say this."""
    flying.replace(tree / SUBSYSTEM, ('type="valve-box"', 'type="valve-timer"'))
    flying.replace(tree / WORLD, ("valve-box.eds", "valve-timer.eds"))
    longest, unplugged_s = 0.255, 1.8  # In 10 ms.
    flight = _fly(tree, tmp_path / "run", (*LINES[:4], f"1.5 operator set ACTUATORS.OUTPUT 0,3,{longest}{REST},0,0,0,0,0,0,0",
                                           "1.7 operator get ACTUATORS.OUTPUT", f"{unplugged_s} fault unplug platform 0x3A", "2.0 operator shutdown"))
    assert "ACTUATORS: OUTPUT=[0, 3, 0.255, 0" in flight.console
    last_s, octets = [(float(time), bytes.fromhex(octets)) for time, octets in
                      re.findall(r"\((\d+\.\d+)\) platform 23A##1([0-9A-F]+)", flight.read("can-platform.log")) if float(time) < unplugged_s][-1]
    assert struct.unpack("<BBf", octets) == (0, 3, pytest.approx(longest, rel=1e-7))
    text = dbc.databases(missions.load(tree / MISSION))["platform"]
    decoded = cantools.database.load_string(text, "dbc").decode_message(0x23A, octets)
    assert list(decoded.values()) == pytest.approx([0, 3, longest], rel=1e-7)
    moves = [(valve["name"], bool(valve["is_open"])) for valve in runs.load(flight.directory).truth["VALVE"]]
    assert moves == [("TURN1", True), ("TURN2", True), ("TURN1", False), ("TURN2", False)]
    open_s = runs.load(flight.directory).truth["VALVE"][-1]["time_us"] * 1e-6 - last_s
    assert 10e-3 * longest - 2e-6 < open_s < 10e-3 * longest + 0.6e-3  # Closes at the end of a step of 0.5 ms.


def test_another_number_of_axes_flies(tree, tmp_path):
    """A second drive of another manufacturer is added; the target of the second axis is its own."""
    text = (tree / SUBSYSTEM).read_text(encoding="utf-8")
    settings = ('<Setting object="0x1401:05" type="UINT16" value="4"/><Setting object="0x60C2:01" type="UINT8" value="10"/>'
                '<Setting object="0x6060:00" type="INT8" value="8"/>')
    second = f'<Device name="BOOM2" type="servo-drive">{settings}<Endnode type="CAN" bus="platform" node="0x26"/></Device>'
    start = text.index('<Configuration name="NOMINAL"')
    place = text.index("    </Devices>", start)
    (tree / SUBSYSTEM).write_text(text[:place] + second + text[place:], encoding="utf-8")
    bench = re.search(r"<Bench .*?/>", (tree / WORLD).read_text(encoding="utf-8"))[0]
    other = bench.replace('"BOOM"', '"BOOM2"').replace("0x25", "0x26").replace("joint-drive", "servo-drive")
    flying.replace(tree / WORLD, (bench, bench + other))
    flight = _fly(tree, tmp_path / "run")
    _assert_boom_and_satellite_moved(flight)
    assert abs(_reported(flight, "POSITION")[1] + 0.15) < 1e-3
    targets = [struct.unpack("<i", bytes.fromhex(octets)[2:6])[0] for octets in
               re.findall(r" 326##1([0-9A-F]+)", flight.read("can-platform.log"))]
    assert statistics.mode(targets) == pytest.approx(-0.15 / 2.9960562e-7, abs=2)  # Increments of 2 pi / (131072 x 160) rad.


def test_a_bus_that_only_the_world_has_is_named(tree, tmp_path):
    """The devices of a misspelled bus are on no bus of the mission: no program reaches them."""
    path = tree / WORLD
    path.write_text(path.read_text(encoding="utf-8").replace('bus="platform"', 'bus="platform-2"'), encoding="utf-8")
    scenario = flying.write_scenario(tmp_path / "short.scn", "0.1 operator shutdown")
    flight = flying.fly(tmp_path / "run", "--mission", "actuators", "--scenario", scenario, "--form", "image", root=tree)
    said = [line for line in flight.read("console.log").splitlines() if "no program of this run is on bus" in line]
    assert len(said) == 1 and "descriptors/worlds/actuators.xml: no program of this run is on bus platform-2" in said[0], flight.transcript()
