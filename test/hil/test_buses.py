# SPDX-License-Identifier: Apache-2.0
"""The buses over SocketCAN: the same flight as on shared memory, frame by frame, as tools of other projects
record it."""

import functools
import os
import subprocess

import cantools
import pytest

import environments
import short_flights
from hirosco_gse import dictionary, logs, packet_log
from hirosco_gse import run as runs
from recordings import assert_database_knows_all, assert_wireshark_names_all, frames, of_interface

PROGRAM = "test/hil/guest/socketcan.py"
SECONDS = 2400
# Cases with LONG=1 only, because the micro-VM needs a minute and more of processor time for each of these flights.
LONG_CASES = {"frames_of_tools_enter_the_bus", "interfaces_that_are_lost_and_made_again_are_used_again",
              "emulated_controllers_carry_the_classic_mission", "a_flood_on_the_wire_ends_in_a_safe_state"}
CASES = [pytest.param(case, marks=pytest.mark.long) if case in LONG_CASES else case for case in environments.cases(PROGRAM)]
TELEPRESENCE, TELEPRESENCE_S, TELEPRESENCE_MB = "test/hil/guest/telepresence.py", 8000, 2048
ENABLED, ENABLED_MASK = 0x27, 0x6F
COUNTERS = 4712  # Housekeeping structure.


@pytest.fixture(scope="module")
def group(request, environment):
    """The cases that this session will test, and the flight over vcan, whose files other tests read."""
    asked = {item.callspec.params["case"] for item in request.session.items if item.name.startswith("test_a_case_passes[")}
    names = " ".join(case for case in environments.cases(PROGRAM) if case in {*asked, "vcan_flight_is_seen_by_candump"})
    return environment.group("socketcan", f"{environments.PYTHON} {PROGRAM} {names}", seconds=SECONDS, cans=2)


@pytest.fixture(scope="module")
def shared_memory_flight(tmp_path_factory):
    """flight(name) -> directory of the same flight on shared memory, on this machine."""
    directory = tmp_path_factory.mktemp("buses")

    @functools.cache
    def flight(name):
        mission, scenario = {"vcan": ("rokviss", "reports"), "controllers": ("classic", "classic")}[name]
        return fly_here(directory / name, mission, short_flights.write_scenario(directory, scenario))

    return flight


def fly_here(directory, mission, scenario):
    """Fly on shared memory, with the floating-point instructions that the micro-VM has."""
    ended = subprocess.run([environments.ROOT / "build" / "bin" / "hirosco", "run", "--mission", mission, "--scenario", scenario,
                            "--report", "no", "--out", directory], cwd=environments.ROOT, stdin=subprocess.DEVNULL, capture_output=True,
                           text=True, env=os.environ | environments.ARITHMETIC, timeout=environments.SECONDS)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return directory


@pytest.mark.parametrize("case", CASES)
def test_a_case_passes(group, case):
    group.check(case)


@pytest.mark.parametrize("name", ["vcan", pytest.param("controllers", marks=pytest.mark.long)])
def test_logs_are_those_of_shared_memory(group, shared_memory_flight, name):
    group.check({"vcan": "vcan_flight_is_seen_by_candump",
                 "controllers": "emulated_controllers_carry_the_classic_mission"}[name])
    for log in ("can-robot.log", "can-robot-b.log", "can-joystick.log", "packets.log"):
        assert (group.result.directory / name / log).read_bytes() == (shared_memory_flight(name) / log).read_bytes(), log


@pytest.mark.parametrize("bus, least", [("robot", 5000), ("robot-b", 10), ("joystick", 5000)])
def test_candump_recorded_the_same_frames(group, shared_memory_flight, bus, least):
    """The unused channel B carries the frames that devices send after they are switched on."""
    group.check("vcan_flight_is_seen_by_candump")
    expected = frames(shared_memory_flight("vcan") / f"can-{bus}.log", bus)
    recorded = frames(group.result.directory / "vcan" / "candump.log", f"vcan-{bus}")
    assert len(expected) > least
    assert recorded == expected


@pytest.mark.parametrize("bus", short_flights.REPORTS)
def test_the_controller_of_a_vcan_flight_has_reported_each_condition(group, bus):
    """Bus-off and recovery, error passive, lost arbitration, no acknowledge, overflow: the flight software reacts as on shared memory."""
    group.check("vcan_flight_is_seen_by_candump")
    seen = frames(group.result.directory / "vcan" / "candump.log", f"vcan-{bus}")
    assert short_flights.REPORTS[bus] <= {frame[5:13] for frame in seen if frame.startswith("20000") and "##" not in frame}


@pytest.mark.long
def test_a_flood_leaves_no_drive_in_operation(group):
    """The truth of the drives is checked, because their own reports wait for a SYNC that does not get
    through."""
    group.check("a_flood_on_the_wire_ends_in_a_safe_state")
    channels = logs.parse_lcm((group.result.directory / "flood" / "truth.lcm").read_bytes())
    histories = {}
    for entry in runs.decode_truth({"DRIVE": channels["DRIVE"]})["DRIVE"]:
        histories.setdefault((int(entry["node"]), int(entry["axis"])), []).append(entry["statusword"] & ENABLED_MASK == ENABLED)
    assert len([history for history in histories.values() if any(history)]) == 2, "the arm was not in operation"
    assert not any(history[-1] for history in histories.values())


@pytest.mark.long
def test_a_flood_is_counted(group):
    """Frames that the flight software could not send, receive or interpret, by its housekeeping reports before and during
    the flood."""
    group.check("a_flood_on_the_wire_ends_in_a_safe_state")
    arm = dictionary.Dictionary.load(environments.ROOT / "build" / "generated" / "classic.json").subsystem("MANIPULATOR")
    structure = arm.configuration("CLASSIC").structures[COUNTERS]
    reported = [raw[23:-2] for _, direction, _, raw in packet_log.read_packets(group.result.directory / "flood" / "packets.log")
                  if direction == "TM" and raw[7:9] == b"\x03\x19" and int.from_bytes(raw[21:23], "big") == COUNTERS]
    counters = [structure.decode(octets)["COUNTERS"] for octets in reported]
    before, after = ([entry[name][0] for name in ("TRANSMIT_FULL", "RECEIVE_OVERRUNS", "FRAMES_REFUSED")]
                     for entry in (counters[0], counters[-1]))
    assert before == [0, 0, 0] and any(after), f"{before} before, {after} during the flood"


@pytest.mark.long
@pytest.mark.timeout(TELEPRESENCE_S + 600)
def test_whole_telepresence_is_that_of_shared_memory(environment, tmp_path):
    """Contact, spring, unplugged devices and the return to operation: the logs are equal, and cantools and
    Wireshark can read the recording of candump."""
    flight = fly_here(tmp_path / "telepresence", "rokviss", "telepresence")
    group = environment.group("telepresence", f"{environments.PYTHON} {TELEPRESENCE}", seconds=TELEPRESENCE_S,
                        memory=TELEPRESENCE_MB)
    group.check("telepresence_is_flown_over_vcan")
    for log in ("can-robot.log", "can-robot-b.log", "can-joystick.log", "packets.log"):
        assert (group.result.directory / "telepresence" / log).read_bytes() == (flight / log).read_bytes(), log
    dump = group.result.directory / "candump.log"
    assert "DROPCOUNT" not in dump.read_text()
    for bus in ("robot", "joystick"):
        expected = frames(flight / f"can-{bus}.log", bus)
        assert len(expected) > 500_000
        assert frames(dump, f"vcan-{bus}") == expected, bus
        own = of_interface(dump, f"vcan-{bus}")
        assert_database_knows_all(own, cantools.database.load_file(environments.ROOT / f"build/generated/rokviss-{bus}.dbc", strict=True))
        assert_wireshark_names_all(own)
