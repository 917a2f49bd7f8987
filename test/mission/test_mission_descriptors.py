# SPDX-License-Identifier: Apache-2.0
"""Wrong descriptors: the run does not start, and the message contains file and line."""

import json
import re
import shutil
import sys

import flying
import pytest
from hirosco_gse import sdls

sys.path.insert(0, str(flying.ROOT / "gse" / "generator"))

import subsystem

MISSION = "descriptors/missions/rokviss.xml"
MANIPULATOR = "descriptors/subsystems/manipulator.xml"
LINKED = ("build", "sim", "gse")


@pytest.fixture
def project_copy(directory):
    """A copy of the descriptors in a directory that otherwise refers to the project."""
    directory.mkdir()
    shutil.copytree(flying.ROOT / "descriptors", directory / "descriptors")
    for name in LINKED:
        (directory / name).symlink_to(flying.ROOT / name)
    return directory


def _replace(project_copy, path, old, new, count=1):
    """Change a descriptor; returns the line of the change."""
    text = (project_copy / path).read_text(encoding="utf-8")
    assert old in text
    (project_copy / path).write_text(text.replace(old, new, count), encoding="utf-8")
    return text[: text.index(old)].count("\n") + 1


def _fly(project_copy, form="processes", **how):
    return flying.fly(project_copy / "out", "--scenario", "commissioning", "--form", form, root=project_copy, **how)


def test_unchanged_copy_flies(project_copy):
    flight = _fly(project_copy)
    assert flight.code == 0, flight.transcript()


@pytest.mark.parametrize(
    ("path", "old", "new", "words"),
    [
        (MISSION, 'name="MANIPULATOR" id="16"', 'name="MANIPULATOR" id="17"', ("17",)),
        (MISSION, 'epoch="2026-06-01T12:00:00"', 'epoch="yesterday"', ("yesterday",)),
        (MISSION, '<Allow tc="8,1" select="TARE" to="MANIPULATOR"', '<Allow tc="8,1" select="TARE" to="MOON"', ("MOON",)),
        (MISSION, 'states="SAFE_OPERATIONAL"', 'states="ASLEEP"', ("ASLEEP",)),
        (MISSION, 'from="MANIPULATOR.ROBOT_STATE"', 'from="MANIPULATOR.ROBOT_MOOD"', ("ROBOT_MOOD",)),
        (MISSION, "</Modes>", "</Mode>", ()),
        (MISSION, 'severity="HIGH"', 'severity="HUGE"', ("HUGE",)),
        (MISSION, '<Ground address="127.0.0.1" port="10015"/>', '<Ground address="127.0.0.1" port="port"/>', ("port",)),
        (MANIPULATOR, 'type="DOUBLE" count="2" unit="rad/s"', 'type="QUADRUPLE" count="2" unit="rad/s"', ("QUADRUPLE",)),
        (MANIPULATOR, 'init="38 38"', 'init="38 thirtyeight"', ("thirtyeight",)),
        (MANIPULATOR, 'samplingTime="500us"', 'samplingTime="500parsec"', ("500parsec",)),
        (MANIPULATOR, '<SampledNREPTimes nrep="5">', '<SampledNREPTimes nrep="0">', ("nrep",)),
        (MANIPULATOR, '<Endnode type="CAN" bus="robot" redundantBus="robot-b" node="0x11"/>', '<Endnode type="CAN" bus="robot" redundantBus="robot-b" node="0x1111"/>', ("0x1111",)),
        (MANIPULATOR, "</Parameters>", "", ()),
    ],
)
@pytest.mark.parametrize("form", ["processes", "image"])
def test_error_is_reported_with_file_and_line(project_copy, form, path, old, new, words):
    line = _replace(project_copy, path, old, new)
    flight = _fly(project_copy, form)
    assert flight.code not in (0, None)
    printed = flight.output + flight.console
    name = path.rpartition("/")[2]
    place = re.search(re.escape(name) + r":(\d+)", printed)
    assert place, f"no {name}:line in {flight.transcript()}"
    if words:
        assert int(place[1]) == line, printed
    for word in words:
        assert word in printed
    assert "Assertion" not in printed
    flying.assert_clean(flight)


JOYSTICK = "descriptors/subsystems/joystick.xml"
STICK = '<Endnode type="CAN" bus="joystick" redundantBus="joystick-b" node="0x21"/>'
JOINT = '<Endnode type="CAN" bus="robot" redundantBus="robot-b" node="0x11"/>'


@pytest.mark.parametrize(
    ("path", "old", "new", "words"),
    [
        (JOYSTICK, 'type="joystick"', 'type="joypad"', "type of <Device>: expected a class of descriptors/devices: gyro"),
        (MANIPULATOR, 'type="joint-drive"', 'type="gyroscope"', "type of <Device>: expected a class of descriptors/devices: gyro"),
        (MANIPULATOR, 'type="joint-drive"', 'type="joystick"', "type of <Device>: expected a class of CiA 402 with one axis"),
        (JOYSTICK, STICK, '<Endnode type="UDP" address="127.0.0.1" port="9"/>', "type of <Endnode>: expected CAN"),
        (MANIPULATOR, JOINT, '<Endnode type="SHM" name="joint"/>', "type of <Endnode>: expected CAN"),
        (MANIPULATOR, JOINT, '<Endnode type="SERIAL" name="/dev/ttyS0" baud="19200"/>', "type of <Endnode>: expected CAN"),
        (MANIPULATOR, JOINT.replace("0x11", "0x12"), '<Endnode type="CAN" bus="robot" node="0x12"/>', "redundantBus of <Endnode>: expected that of the first device"),
        (JOYSTICK, STICK, '<Endnode type="CAN" bus="robot" redundantBus="robot-b" node="0x21"/>', "expected a bus of its own"),
    ],
)
@pytest.mark.parametrize("form", ["processes", "image"])
def test_devices_that_a_subsystem_cannot_drive_are_refused_before_the_flight(project_copy, form, path, old, new, words):
    """The run does not start; no step of a state transition fails during the flight."""
    line = _replace(project_copy, path, old, new)
    flight = _fly(project_copy, form)
    assert flight.code == 1
    printed = flight.output + flight.console
    place = re.search(r"(\w+\.xml):(\d+): [^\n]*" + re.escape(words), printed)
    assert place, flight.transcript()
    if "of its own" not in words:  # The message contains the line of the second subsystem that uses the bus.
        assert (place[1], int(place[2])) == (path.rpartition("/")[2], line)
    assert "0x0301" not in printed  # PUS_FAILURE_STEP.
    flying.assert_clean(flight)


def test_a_missing_descriptor_is_refused(project_copy):
    line = _replace(project_copy, MISSION, 'descriptor="../subsystems/manipulator.xml"', 'descriptor="../subsystems/nowhere.xml"')
    flight = _fly(project_copy)
    assert flight.code not in (0, None)
    assert f'rokviss.xml:{line}: descriptor="../subsystems/nowhere.xml" of <Subsystem>: expected a file, found none' in flight.output, flight.transcript()


@pytest.mark.parametrize("form", ["processes", "image"])
def test_a_missing_executable_is_refused(project_copy, form):
    line = _replace(project_copy, MISSION, 'executable="joystick"', 'executable="joyride"')
    flight = _fly(project_copy, form)
    assert flight.code == 1
    assert f'rokviss.xml:{line}: executable="joyride" of <Subsystem>: expected a program in ' in flight.output
    assert not flight.directory.exists(), "expected no directory of a run that never began"
    flying.assert_clean(flight)


def test_two_subsystems_with_one_program_are_refused_in_the_image(project_copy):
    line = _replace(project_copy, MISSION, 'executable="manipulator"', 'executable="joystick"')
    flight = _fly(project_copy, "image")
    assert flight.code == 1
    assert (f'rokviss.xml:{line}: executable="joystick" of <Subsystem>: expected another program than that of JOYSTICK, '
            "which the image contains once; use --form processes") in flight.output
    assert not flight.directory.exists()


@pytest.mark.parametrize("address", ["moon", "10.0.0.1", "127.0.0.1 "])
def test_ground_elsewhere_is_refused(project_copy, address):
    """The port is open to this machine only: an attribute that would have no effect is refused."""
    line = _replace(project_copy, MISSION, '<Ground address="127.0.0.1"', f'<Ground address="{address}"')
    flight = _fly(project_copy)
    assert flight.code == 1
    assert f'rokviss.xml:{line}: address="{address}" of <Ground>: expected one of 127.0.0.1' in flight.output
    assert not flight.directory.exists()


def test_a_mission_with_a_key_flies_with_it_only(project_copy):
    """The path of the key is relative to the mission's file. With a key the port may be open to other
    machines."""
    line = _replace(project_copy, MISSION, '<Ground address="127.0.0.1" port="10015"', '<Ground address="0.0.0.0" port="10015"')
    flight = _fly(project_copy)
    assert f"rokviss.xml:{line}: <Ground address=\"0.0.0.0\"> needs a key" in flight.output
    _replace(project_copy, MISSION, 'port="10015"', 'port="10015" key="../ground.key"')
    flight = _fly(project_copy)
    assert flight.code == 1
    assert "descriptors/missions/../ground.key: cannot read the key" in flight.output
    assert not flight.directory.exists()
    sdls.make_key(project_copy / "descriptors" / "ground.key")
    flight = _fly(project_copy)
    assert flight.code == 0, flight.transcript()
    assert "ground port 0.0.0.0:" in flight.output
    assert flight.read("ground.key-file").strip() == "descriptors/missions/../ground.key"


@pytest.mark.parametrize("form", ["processes", "image"])
def test_an_interface_that_differs_from_the_compiled_one_is_refused_with_both_hashes(project_copy, form):
    """The message contains the file, the compiled and the read hash, and the next step."""
    _replace(project_copy, MANIPULATOR, '<Event name="BUS_WARNING" id="8"', '<Event name="BUS_NOTE" id="8"')
    flight = _fly(project_copy, form)
    assert flight.code not in (0, None)
    printed = flight.output + flight.console
    assert "manipulator.xml" in printed
    assert "run make" in printed
    assert len(set(re.findall(r"0x[0-9A-Fa-f]{16}", printed))) >= 2, printed
    flying.assert_clean(flight)


def test_configuration_part_needs_no_recompilation(project_copy):
    """A different rate of housekeeping is read at run time: the mission flies and reports a different
    configuration hash."""
    _replace(project_copy, MANIPULATOR, '<HKService id="4711" interval="500">', '<HKService id="4711" interval="250">', count=2)
    flight = _fly(project_copy)
    assert flight.code == 0, flight.transcript()
    plain = flying.fly(project_copy / "plain", "--scenario", "commissioning")
    assert plain.facts["interface_hash"] == flight.facts["interface_hash"]

    def reports(flown):  # Times of TM[3,25] with structure 4711 of MANIPULATOR to destination 0.
        return [t for t, direction, raw in flown.packets if direction == "TM" and raw[7:9] == b"\x03\x19" and raw[21:23] == b"\x12\x67" and raw[1] == 16 and raw[11:13] == bytes(2)]

    gaps = {b - a for a, b in zip(reports(flight)[:4], reports(flight)[1:5])}
    assert gaps == {125_000_000}
    assert {b - a for a, b in zip(reports(plain)[:3], reports(plain)[1:4])} == {250_000_000}

    def hashes(flown):  # Configuration hashes in TM[129,5] of MANIPULATOR.
        return {raw[34:42] for _, direction, raw in flown.packets if direction == "TM" and raw[7:9] == b"\x81\x05" and raw[1] == 16}

    assert len(hashes(flight)) == 1
    assert hashes(flight) != hashes(plain)


def test_a_wrong_descriptor_is_not_reloaded_and_the_old_one_stays_in_force(project_copy):
    """TC[129,6] during a mission is refused with file, line, value and expected value; then the flight
    continues."""
    flight = flying.start(project_copy / "out", "--scenario", "none", "--duration", 36000, root=project_copy)
    try:
        assert flying.gse(flight, "state", "MANIPULATOR", "PRE_OPERATIONAL").returncode == 0
        line = _replace(project_copy, MANIPULATOR, 'samplingTime="500us"', 'samplingTime="500parsec"')
        refused = flying.gse(flight, "reload", "MANIPULATOR")
        assert refused.returncode != 0, refused.stdout
        for words in (("config", "MANIPULATOR", "STAND_ALONE"), ("state", "MANIPULATOR", "SAFE_OPERATIONAL"), ("shutdown",)):
            done = flying.gse(flight, *words)
            assert done.returncode == 0, done.stdout + done.stderr
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 0, flight.transcript()
    assert re.search(rf"manipulator\.xml:{line}: .*500parsec.*not reloaded", flight.output + flight.console), flight.transcript()


def test_a_subsystem_with_another_configuration_than_the_supervisor_has_read_is_reported_with_both_hashes(project_copy):
    """The subsystem reads its changed descriptor again; the supervisor keeps the descriptor that it has read
    at the start."""
    flight = flying.start(project_copy / "out", "--scenario", "none", "--duration", 36000, root=project_copy)
    try:
        assert flying.gse(flight, "ping", "all").returncode == 0  # All components have read their descriptors.
        _replace(project_copy, MANIPULATOR, '<HKService id="4711" interval="500">', '<HKService id="4711" interval="250">', count=2)
        script = flying.write_scenario(project_copy / "anew.scn", "0.0 operator reload MANIPULATOR",
                                       "0.0 operator wait-event SUPERVISOR CONFIGURATION_DIFFERS 10", "0.0 operator shutdown")
        done = flying.gse(flight, "script", script)
        assert done.returncode == 0, done.stdout + done.stderr
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 0, flight.transcript()
    # Auxiliary data of TM[5,2] with event 10, CONFIGURATION_DIFFERS.
    reports = [raw[23:41] for _, direction, raw in flight.packets
               if direction == "TM" and raw[7:9] == b"\x05\x02" and raw[21:23] == b"\x00\x0a"]
    known = json.loads((flying.ROOT / "build" / "generated" / "rokviss.json").read_text(encoding="utf-8"))
    manipulator = next(subsystem for subsystem in known["subsystems"] if subsystem["name"] == "MANIPULATOR")
    assert len(reports) == 1
    assert reports[0][:10] == bytes([0, 16]) + int(manipulator["configuration_hash"], 16).to_bytes(8, "big")
    assert reports[0][10:] != reports[0][2:10]


def _add_subsystems(project_copy, count):
    """Add subsystems, each with a copy of communication's descriptor and program, which need no bus, under a
    new name and id. Returns the directory of the programs and the line of the last one in the mission."""
    programs = project_copy / "programs"
    shutil.copytree(flying.BIN, programs)
    plain = (project_copy / "descriptors/subsystems/communication.xml").read_text(encoding="utf-8")
    program = (programs / "communication").read_bytes()
    compiled = subsystem.load(project_copy / "descriptors/subsystems/communication.xml").interface_hash.to_bytes(8, sys.byteorder)
    assert program.count(compiled) == 1
    listed = ""
    for number in range(1, count + 1):
        path = project_copy / f"descriptors/subsystems/copy{number}.xml"
        path.write_text(plain.replace('name="COMMUNICATION" id="2"', f'name="COPY{number}" id="{100 + number}"', 1), encoding="utf-8")
        own = subsystem.load(path).interface_hash.to_bytes(8, sys.byteorder)
        (programs / f"copy{number}").write_bytes(program.replace(compiled, own))
        (programs / f"copy{number}").chmod(0o755)
        listed += f'    <Subsystem name="COPY{number}" id="{100 + number}" executable="copy{number}" descriptor="../subsystems/copy{number}.xml" memoryKiB="65536"/>\n'
    return programs, _replace(project_copy, MISSION, "  </Subsystems>\n", listed + "  </Subsystems>\n") + count - 1


def test_mission_with_as_many_subsystems_as_there_can_be_flies(project_copy):
    """Sixteen subsystems, the simulator and the operator take part in stepped time."""
    programs, _ = _add_subsystems(project_copy, 12)
    flight = _fly(project_copy, binaries=programs)
    assert flight.code == 0, flight.transcript()
    assert flight.facts["exit_code"] == 0
    flying.assert_clean(flight)


def test_one_subsystem_more_is_refused(project_copy):
    programs, line = _add_subsystems(project_copy, 13)
    flight = _fly(project_copy, binaries=programs)
    assert flight.code == 1
    assert f"rokviss.xml:{line}: too many subsystems, at most 16" in flight.output, flight.transcript()
    assert not flight.directory.exists()
