# SPDX-License-Identifier: Apache-2.0
"""Homing and valves in flight: a boom searches its end stop, thrusters push and turn a satellite, valves
close when no commands arrive, and wrong descriptors are refused."""

import json
import re
import struct

import cantools
import flying
import pytest

ACTUATORS = "descriptors/subsystems/actuators.xml"
UP = (
    "0.2 operator state ACTUATORS PRE_OPERATIONAL",
    "0.8 operator config ACTUATORS {configuration}",
    "1.0 operator state ACTUATORS SAFE_OPERATIONAL",
    "1.2 operator state ACTUATORS OPERATIONAL",
)
REST = ",0" * 13  # Outputs 4 to 16 of OUTPUT. Outputs 1 and 2 are bits of valves: 3,0 opens both PUSH valves, 0,3 both TURN valves.


def _truth(flight, channel):
    """Messages of a channel of truth.lcm, without their fingerprints."""
    octets, at, found = flight.octets("truth.lcm"), 0, []
    while at < len(octets):
        _, _, _, name, size = struct.unpack(">IqqII", octets[at:at + 28])
        at += 28
        if octets[at:at + name] == channel:
            found.append(octets[at + name + 8:at + name + size])
        at += name + size
    return found


def _valves(flight):
    """(time s, name, is open) of every change."""
    found = []
    for message in _truth(flight, b"VALVE"):
        time_ns, length = struct.unpack(">qI", message[:12])
        found.append((time_ns * 1e-9, message[12:11 + length].decode(), message[12 + length] != 0))
    return found


def _bodies(flight):
    """(time s, velocity, rate) of the satellite after every step."""
    for message in _truth(flight, b"BASE"):
        time_ns, _, *numbers = struct.unpack(">qi13d", message)
        yield time_ns * 1e-9, numbers[7:10], numbers[10:13]


def _frames(flight, identifier):
    """(time s, octets) of the frames of an identifier on the bus."""
    found = re.findall(rf"\((\d+\.\d+)\) platform {identifier:03X}##?1?([0-9A-F]*)$", flight.read("can-platform.log"), re.MULTILINE)
    return [(float(time), bytes.fromhex(octets)) for time, octets in found]


@pytest.fixture(scope="module")
def flights(session_directory):
    """The scenario as processes and as an image."""
    found = [flying.fly(session_directory / f"actuators-{form}", "--mission", "actuators", "--scenario", "actuators", "--form", form)
             for form in ("processes", "image")]
    for flight in found:
        assert flight.code == 0, flight.transcript()
    return found


def test_both_forms_fly_the_same_octets(flights):
    for log in ("packets.log", "can-platform.log", "truth.lcm"):
        assert flights[0].octets(log) == flights[1].octets(log), log
    for flight in flights:
        flying.assert_clean(flight)


def test_homing_finds_the_end_stop_of_the_boom_and_counts_from_there(flights):
    """The stop is at -0.4 rad, where the encoder of the drive starts with 0. The descriptor defines it as
    -0.4 rad, so that afterwards the telemetry equals the truth."""
    steps = [json.loads(line) for line in flights[0].read("operator.log").splitlines()]
    home = next(step for step in steps if step["words"] == ["ACTUATORS.HOME"])
    assert home["outcome"].endswith("completed") and 2.0 < home["end"] - home["time"] < 3.0
    reports = [step["outcome"] for step in steps if step["verb"] == "hk"]
    homed, moved = (float(re.search(r"POSITION: \[([-0-9.]+)", text)[1]) for text in reports)
    assert abs(homed + 0.4) < 2e-3
    assert abs(moved - 0.1) < 1e-3


def test_valves_open_and_close_as_commanded(flights):
    changes = _valves(flights[0])
    assert [(name, is_open) for _, name, is_open in changes] == [
        ("PUSH1", True), ("PUSH2", True), ("PUSH1", False), ("PUSH2", False), ("TURN1", True), ("TURN2", True),
        ("TURN1", False), ("TURN2", False), ("PUSH1", True), ("PUSH1", False)]
    for (time, _, _), expected in zip(changes, (9.0, 9.0, 11.0, 11.0, 11.0, 11.0, 12.0, 12.0, 13.2, 14.0)):
        assert expected < time < expected + 0.01


def test_thrust_moves_the_satellite(flights):
    """2 N push 300 kg for 2 s; then a torque of 1 Nm turns 60 kgm2 for 1 s; then 1 N pushes beside the centre."""
    changes = [time for time, _, _ in _valves(flights[0])]
    bodies = {round(time, 4): (velocity, rate) for time, velocity, rate in _bodies(flights[0])}
    velocity, rate = bodies[10.9995]
    assert abs(velocity[0] - 2.0 * (10.9995 - changes[0]) / 300.0) < 1e-5 and max(map(abs, rate)) < 1e-9
    velocity, rate = bodies[13.0]
    assert abs(velocity[0] - 2.0 * (changes[2] - changes[0]) / 300.0) < 1e-5
    assert abs(rate[2] - (changes[6] - changes[4]) / 60.0) < 2e-5
    velocity, rate = bodies[15.5]
    assert abs(rate[2] - (changes[6] - changes[4] - 0.5 * (changes[9] - changes[8])) / 60.0) < 3e-5


def test_cantools_reads_the_process_data_of_the_valves(flights):
    database = cantools.database.load_file(flying.ROOT / "build/generated/actuators-platform.dbc", strict=True)
    for identifier, signals in ((0x23A, 3), (0x1BA, 2)):  # RPDO and TPDO of node 0x3A, the valve box; both begin with the bits of the valves.
        message = database.get_message_by_frame_id(identifier)
        assert len(message.signals) == signals
        values = [(time, list(message.decode(octets).values())) for time, octets in _frames(flights[0], identifier)]
        assert len(values) > 10000
        at = {moment: next(value for time, value in values if time > moment) for moment in (8.5, 10.0, 11.5, 13.5, 14.2)}
        assert [at[moment][:2] for moment in sorted(at)] == [[0, 0], [3, 0], [0, 3], [1, 0], [0, 0]]


def _up(configuration):
    return [line.format(configuration=configuration) for line in UP]


@pytest.mark.parametrize("form", ["processes", "image"])
def test_valves_close_if_their_subsystem_dies(session_directory, form):
    """The valves close after the RPDO deadline of 10 ms and their shortest pulse."""
    scenario = flying.write_scenario(session_directory / f"dies-{form}.scn", *_up("NOMINAL"),
                                     f"2.0 operator set ACTUATORS.OUTPUT 3,3,0{REST}", "3.0 fault kill ACTUATORS", "4.0 operator shutdown")
    flight = flying.fly(session_directory / f"dies-{form}", "--mission", "actuators", "--scenario", scenario, "--form", form)
    changes = _valves(flight)
    assert [name for _, name, is_open in changes if is_open] == ["PUSH1", "PUSH2", "TURN1", "TURN2"]
    closed = [time for time, _, is_open in changes if not is_open]
    assert len(closed) == 4 and all(3.005 < time < 3.015 for time in closed)


def _reports(flight, pattern):
    """Numbers that match in the lines of `operator hk`, in the order of the reports."""
    steps = [json.loads(line) for line in flight.read("operator.log").splitlines()]
    return [[float(number) for number in re.search(pattern, step["outcome"])[1].split(", ")] for step in steps if step["verb"] == "hk"]


def test_the_boom_moves_with_a_velocity_and_the_gyro_measures_the_turn(session_directory):
    """CSV (CiA 402) by the second RPDO, and the rates (CiA 404) in the telemetry, are compared with the truth
    of the simulator."""
    lines = [*_up("VELOCITY"), f"1.5 operator set ACTUATORS.OUTPUT 0,3,0{REST}", "1.6 operator set ACTUATORS.VELOCITY 0.1,0,0,0,0,0,0,0",
             "2.0 operator hk once ACTUATORS 1", "2.5 operator hk once ACTUATORS 1", f"2.5 operator set ACTUATORS.OUTPUT 0,0,0{REST}",
             "3.0 operator cmd ACTUATORS.STOP", "3.3 operator hk once ACTUATORS 1", "3.5 operator hk once ACTUATORS 1", "3.6 operator shutdown"]
    scenario = flying.write_scenario(session_directory / "velocity.scn", *lines)
    flight = flying.fly(session_directory / "velocity", "--mission", "actuators", "--scenario", scenario, "--form", "image")
    assert flight.code == 0, flight.transcript()
    positions = [position[0] for position in _reports(flight, r"POSITION: \[([-0-9.e, ]+)\]")]
    assert abs(positions[1] - positions[0] - 0.05) < 0.003, "expected 0.05 rad, less what friction takes"
    assert abs(positions[3] - positions[2]) < 2e-4 and 0.04 < positions[2] - positions[1] < 0.06
    # The second RPDO of the boom: controlword, torque offset, target velocity [1e-6 rad/s]. In this configuration the first one is invalid.
    commands = {struct.unpack("<hi", octets[2:8]) for _, octets in _frames(flight, 0x325)}
    assert {velocity for _, velocity in commands} == {0, 100000}
    assert not [time for time, _ in _frames(flight, 0x225) if time > 1.0]
    rates = _reports(flight, r"INPUT: \[([-0-9.e, ]+)\]")
    truth = {round(time, 4): rate for time, _, rate in _bodies(flight)}
    assert abs(truth[3.4][2]) > 0.01
    for axis in range(3):
        assert abs(rates[3][2 + axis] - truth[3.4][axis]) < 2e-4
    assert rates[3][6] == 0 and rates[3][5] != rates[2][5], "expected a valid measurement whose counter changes"


@pytest.mark.parametrize("fault", ["error platform BOOM 0x2310 on", "unplug platform BOOM"])
def test_homing_fails_with_a_fault_and_without_its_drive(session_directory, fault):
    """HOME fails as aborted (0x0405), the axis leaves operation without a reference, and the valves close."""
    name = "homing-" + fault.split(" ")[0]
    lines = [*_up("HOMING"), f"1.5 operator set ACTUATORS.OUTPUT 1,0,0{REST}", "2.0 operator expect-refusal 0x0405 cmd ACTUATORS.HOME",
             f"2.3 fault {fault}", "4.0 operator shutdown"]
    scenario = flying.write_scenario(session_directory / f"{name}.scn", *lines)
    flight = flying.fly(session_directory / name, "--mission", "actuators", "--scenario", scenario, "--form", "image")
    assert flight.code == 0, flight.transcript()
    control = [(time, struct.unpack("<H", octets[:2])[0]) for time, octets in _frames(flight, 0x225)]
    status = [struct.unpack("<H", octets[:2])[0] for _, octets in _frames(flight, 0x1A5)]
    assert 0x0237 in status and not any(word & 0x1000 for word in status)  # Operation enabled, but never "homing attained".
    searching = [time for time, word in control if word & 0x10]  # Bit 4 of the controlword starts homing.
    assert 2.0 < min(searching) < 2.01 and 2.3 <= max(searching) < 2.31
    assert [(name, is_open) for _, name, is_open in _valves(flight)] == [("PUSH1", True), ("PUSH1", False)]
    assert 2.3 <= _valves(flight)[1][0] < 2.31


@pytest.fixture
def root(tmp_path):
    """A copy of the descriptors; programs and scenarios are those of the project."""
    return flying.descriptors_copied(tmp_path / "root")


@pytest.mark.parametrize(
    ("path", "old", "new", "words"),
    [
        (ACTUATORS, 'object="0x6060:00" type="INT8" value="6"', 'object="0x6060:00" type="INT8" value="10"', "expected a <Setting> of 0x6060:00 to 8"),
        ("descriptors/worlds/actuators.xml", 'eds="valve-box.eds"', 'eds="joint-drive.eds"', "an object that a valve box needs is missing"),
        ("descriptors/worlds/actuators.xml", 'output="10"', 'output="9"', "expected an output that no Valve above has in this ValveBox"),
    ],
)
def test_a_descriptor_or_world_that_does_not_fit_is_refused(root, tmp_path, path, old, new, words):
    text = (root / path).read_text(encoding="utf-8")
    assert old in text
    (root / path).write_text(text.replace(old, new, 1), encoding="utf-8")
    flight = flying.fly(tmp_path / "run", "--mission", "actuators", "--scenario", "actuators", "--form", "image", root=root)
    assert flight.code == 1
    assert words in flight.output + flight.console, flight.transcript()
    flying.assert_clean(flight)
