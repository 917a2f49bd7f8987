# SPDX-License-Identifier: Apache-2.0
"""The live port and other users: hand, faults and the pace of simulated time during a flight paced by the
wall clock, and the recording of the flight."""

import contextlib
import json
import random
import re
import select
import signal
import socket
import subprocess
import time

import flying
import pytest
import test_mission_stations as stations
from hirosco_gse import packets
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.link import LinkLost
from hirosco_gse.live import LiveRefused, LiveWorld
from hirosco_gse.session import Rejected
from hirosco_gse.spacecraft import Spacecraft

LOGS = ("packets.log", "can-robot.log", "can-joystick.log", "can-robot-b.log", "can-joystick-b.log", "truth.lcm")
PAUSE_S = 33.0
STOPPED_S = 5.0
SCENARIO = """
0.0 hand rest
0.1 operator state JOYSTICK PRE_OPERATIONAL
0.1 operator state MANIPULATOR PRE_OPERATIONAL
0.2 operator config JOYSTICK TELEPRESENCE
0.2 operator config MANIPULATOR TELEPRESENCE
0.3 operator link open HAND_POSITION
0.3 operator link open ROBOT_STATE
0.4 operator state JOYSTICK SAFE_OPERATIONAL
0.4 operator state MANIPULATOR SAFE_OPERATIONAL
0.5 operator cmd MANIPULATOR.TARE
0.5 operator wait-event MANIPULATOR TARE_DONE 1
1.1 operator state JOYSTICK OPERATIONAL
1.1 operator state MANIPULATOR OPERATIONAL
5.0 hand home 1
60.0 operator state JOYSTICK SAFE_OPERATIONAL
60.0 operator state MANIPULATOR SAFE_OPERATIONAL
60.1 operator shutdown
"""


def _world(flight):
    flying.wait_until(lambda: (flight.directory / "live.port").exists() and (flight.directory / "live.port").read_text(), "a live port")
    return LiveWorld(flight.directory, "test")


def _sleeper(flight):
    """A client that requests all frames and the truth, and does not read."""
    sleeper = socket.create_connection(("127.0.0.1", int((flight.directory / "live.port").read_text(encoding="ascii"))))
    sleeper.sendall(b"frames robot on\nframes joystick on\ntruth 1000\n")
    return sleeper


def _until(world, seconds):
    while world.ask("time")[0] < seconds:
        time.sleep(0.01)


def _advance(world, seconds):
    """Let this much simulated time pass, however fast the machine is."""
    world.ask(f"step {seconds:.4f}")
    world.stand_still()


def _visit(flight, world):
    """A page sends commands; then its station is suspended for STOPPED_S of simulated time and killed. Returns
    the messages that the page received."""
    subprocess.run(["make", "-s", "build/station/page/index.html"], cwd=flying.ROOT, check=True)
    with contextlib.closing(stations.Station(flight)) as station:
        messages = stations.ask(station.address, ["ping JOYSTICK", "cmd MANIPULATOR.RAISE EVENT=9"])
        station.process.send_signal(signal.SIGSTOP)
        world.ask("speed 0")
        _until(world, world.ask("time")[0] + STOPPED_S)
    return messages


def _dropped(sleeper, world):
    """Read until the simulator reports how many lines this client has lost: it does so as soon as it can send
    to the client again."""
    while True:
        while select.select([sleeper], [], [], 0.1)[0]:
            octets = sleeper.recv(1 << 20)
            assert octets, "the flight has ended"
            found = re.search(rb"^dropped (\d+)$", octets, re.MULTILINE)
            if found:
                return int(found[1])
        world.ask("step 0.001")


@pytest.fixture(scope="module")
def flight(session_directory):
    """A flight in which an operator aims the hand 150 times, presses, causes faults, pauses, steps and changes the speed."""
    scenario = session_directory / "live.scn"
    scenario.write_text(SCENARIO, encoding="utf-8")
    flight = flying.start(session_directory / "live", "--time", "real", "--scenario", scenario)
    draw, flight.answers = random.Random(1), []
    with _world(flight) as world, _world(flight) as listener, _sleeper(flight) as sleeper:
        world.ask("speed 0")
        began, _ = world.ask("pause")
        _advance(world, 1.5 - began)
        listener.ask("frames robot on")
        listener.ask("truth 100")
        for _ in range(150):
            world.ask(f"hand aim {draw.uniform(-0.1, 0.1):.4f} {draw.uniform(-0.1, 0.1):.4f} {draw.uniform(0.005, 0.04):.4f}")
            _advance(world, draw.uniform(0.0005, 0.02))
            listener.ask("time")
        listener.ask("frames robot off")
        listener.ask("truth 0")
        flight.lines_received = list(listener.reports)
        world.ask("fault loss robot 0.01")
        _advance(world, 0.5)
        world.ask("fault loss robot 0")
        world.ask("hand move 0.30 0.02 0.5")
        _advance(world, 2)
        world.ask("hand press 10 0.05")
        _advance(world, 2)
        flight.missed = _dropped(sleeper, world)
        world.ask("resume")
        with Spacecraft(flight.directory, user=3) as web, Spacecraft(flight.directory) as craft:
            craft.speed(1)
            web.do("ping JOYSTICK")
            craft.do("ping all")
            web.do("ping MANIPULATOR")
            craft.do("status")
            flight.answers += [craft.get("MANIPULATOR.TORQUE_OFFSET"), craft.state("JOYSTICK")]
            with pytest.raises(Rejected) as refusal:
                craft.do("state JOYSTICK PRE_OPERATIONAL")
            flight.answers.append(str(refusal.value))
            craft.wait_value("MANIPULATOR.CUR_VALUES.STATE")
        flight.page = _visit(flight, world)
    yield flight.wait()
    flight.abandon()


def test_the_flight_ends_without_a_failure(flight):
    assert flight.code == 0, flight.transcript()
    assert len([line for line in flight.read("live.scn").splitlines() if " hand aim " in line]) == 150
    assert flight.facts["live_lines"] == len(flight.read("live.scn").splitlines())


def test_every_line_is_recorded_with_its_time_and_its_client(flight):
    lines = flight.read("live.scn").splitlines()
    assert all(line.endswith("# test") for line in lines if " aim " in line or " press " in line)
    times = [float(line.split()[0]) for line in lines]
    assert times == sorted(times)


def test_lines_of_persons_are_marked_in_the_log_of_the_operator(flight):
    """A mark has the time and the name of the client; of many lines that aim the hand, only the first one is marked."""
    marks = [step for step in map(json.loads, flight.read("operator.log").splitlines()) if step["verb"] == "live"]
    assert [mark["time"] for mark in marks] == sorted(mark["time"] for mark in marks)
    recorded, aimer = [], None
    for line in flight.read("live.scn").splitlines():
        text, who = line.split(" # ")
        words, before = text.split()[1:], aimer
        if words[0] == "hand":
            aimer = who if words[1] == "aim" else None
        if words[:2] != ["hand", "aim"] or before != who:
            recorded.append((float(text.split()[0]), words, who))
    ours = [(mark["time"], mark["words"], mark["outcome"].removeprefix("by ")) for mark in marks if mark["words"][0] in ("hand", "fault")]
    assert ours == recorded and ["hand", "aim"] in [words[:2] for _, words, _ in recorded]
    paces = [mark["words"] for mark in marks if mark["words"][0] not in ("hand", "fault")]
    assert paces[:2] == [["speed", "0"], ["pause"]] and paces[-3:] == [["resume"], ["speed", "1"], ["speed", "0"]]
    assert marks[0]["text"] == f"[{marks[0]['time']:9.4f} s] live speed 0 (test)"


def test_a_page_commands_the_flight(flight):
    """The event of the command is in the packet log; the test of the recording below compares this log."""
    _, _, done, _, raised = flight.page
    assert done["lights"][-1] == raised["lights"][-1] == "done"
    dictionary = Dictionary.load(flying.ROOT / "build" / "generated" / "rokviss.json")
    note = dictionary.subsystem("MANIPULATOR").event("OPERATOR_NOTE").id
    assert [packet for packet in map(packets.parse, (raw for _, direction, raw in flight.packets if direction == "TM"))
            if packet.message == (5, 2) and packet.data[:2] == note.to_bytes(2, "big")]


def test_another_user_commands_the_flight(flight):
    """The last request, joystick to PRE_OPERATIONAL, is refused: the manipulator, in the same real-time network, is OPERATIONAL."""
    offset, state, refusal = flight.answers
    assert len(offset) == 2 and any(offset)
    assert state == "OPERATIONAL"
    assert "another member of the real-time network is operational: MANIPULATOR" in refusal


def test_a_client_listens_to_the_frames_of_a_bus(flight):
    """The client receives all frames of the log in their order. The comparison with the recording shows that
    listening changes nothing."""
    frames = [line.removeprefix("frame ") for line in flight.lines_received if line.startswith("frame ")]
    logged = flight.read("can-robot.log").splitlines()
    first = logged.index(frames[0])
    assert len(frames) > 1000
    assert frames == logged[first : first + len(frames)]


def test_a_client_sees_the_true_state(flight):
    columns = next(line for line in flight.lines_received if line.startswith("columns ")).split()[1:]
    rows = [[float(word) for word in line.split()[1:]] for line in flight.lines_received if line.startswith("truth ")]
    assert {"time", "arm.joint1.position", "arm.joint2.torque", "STICK.1.hand", "arm.finger.contact-z"} <= set(columns)
    assert all(len(row) == len(columns) for row in rows)
    times = [row[0] for row in rows[1:]]  # The first sample is sent at once.
    assert all(abs(late - early - 0.01) < 1e-6 for early, late in zip(times, times[1:], strict=False))
    assert 0.9 < rows[0][columns.index("arm.joint1.position")] < 1.2


def test_a_client_that_does_not_read_loses_lines_and_gets_their_number(flight):
    assert flight.missed > 100


@pytest.mark.parametrize("form", ["processes", "image"])
def test_the_recording_repeats_the_flight_octet_for_octet(flight, session_directory, form):
    """The recording contains the telecommands of the page, too. The repetition has no station, so the octets
    also show that a suspended or killed station changes nothing."""
    recorded = flying.gse(flight, "record", flight.directory)
    assert recorded.returncode == 0, recorded
    path = session_directory / f"recorded-{form}.scn"
    path.write_text(recorded.stdout, encoding="utf-8")
    again = flying.fly(session_directory / f"again-{form}", "--scenario", path, "--form", form)
    assert again.code == 0, again.transcript()
    for name in LOGS:
        assert again.octets(name) == flight.octets(name), name


def test_gse_moves_the_hand_and_reports_why_a_fault_is_refused(directory):
    """A fault of a device that the bus does not have is refused. A hand without input holds its place after 0.5 s and lets go
    after 5 s. In a flight without an operator the console shows the marks."""
    flight = flying.start(directory, "--time", "real", "--scenario", "none")
    try:
        with _world(flight) as world:
            world.ask("speed 0")
        refused = flying.gse(flight, "--run", directory, "fault", "unplug", "robot", "JOINT9")
        assert refused.returncode == 1
        assert refused.stderr == "gse: refused: found 'JOINT9', expected a device of this bus, or its id: JOINT1 JOINT2 SUPPLY FLIGHT\n"
        assert flying.gse(flight, "--run", directory, "hand", "aim", "0.1", "-0.1", "0.2").returncode == 0
        flying.wait_until(lambda: "hand let_go" in flight.read("live.scn"), "the hand lets go")
        took, held, left = [line.split() for line in flight.read("live.scn").splitlines()]
        assert (held[1:3], left[1:3]) == (["hand", "hold"], ["hand", "let_go"])
        assert -1e-6 < float(held[0]) - float(took[0]) - 0.5 < 0.002
        assert -1e-6 < float(left[0]) - float(took[0]) - 5.0 < 0.002
        assert "paused" in flying.gse(flight, "--run", directory, "pause").stdout
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    assert flight.code == 0, flight.transcript()  # A paused mission shuts down, too.
    for words in ("speed 0 (test)", "hand aim 0.1 -0.1 0.2 (gse)", "hand let_go (no line for 5 s)", "pause (gse)"):
        assert f" s] live {words}" in flight.console
    assert not (directory / "operator.log").exists()


@pytest.mark.long
def test_the_recording_of_a_flight_without_an_operator_repeats_it_octet_for_octet(directory):
    """Two users command, and one of them ends the mission. No operator connects, neither in the flight nor in the repetition."""
    flight = flying.start(directory / "first", "--time", "real", "--scenario", "none")
    with _world(flight) as world:
        world.ask("hand aim 0.1 -0.1 0.2")
        with Spacecraft(flight.directory, user=3) as web, Spacecraft(flight.directory) as craft:
            craft.do("ping all")
            web.do("state JOYSTICK PRE_OPERATIONAL")
            craft.do("state MANIPULATOR PRE_OPERATIONAL")
            world.ask("fault unplug robot JOINT1")
            craft.wait_event("MANIPULATOR", "DEVICE_LOST")
            craft.do("shutdown")
    flight.wait()
    assert flight.code == 0, flight.transcript()
    recorded = flying.gse(flight, "record", flight.directory)
    assert recorded.returncode == 0 and "operator" not in recorded.stdout, recorded
    path = directory / "recorded.scn"
    path.write_text(recorded.stdout, encoding="utf-8")
    for form in ("processes", "image"):
        again = flying.fly(directory / form, "--scenario", path, "--form", form)
        assert again.code == 0, again.transcript()
        for name in LOGS:
            assert again.octets(name) == flight.octets(name), (form, name)


def test_a_refused_or_endless_line_changes_nothing(directory):
    """The lines are malformed, there are too many clients, and clients disconnect in the middle of a line."""
    flight = flying.start(directory, "--time", "real", "--scenario", "none")
    try:
        with _world(flight) as world:
            for line in ("", "time\ntime", "dance", "hand", "hand aim 9 0 1", "speed 0.01", "speed -1", "step 0", "pause now", "fault kill", "name " + "x" * 24, 'name a"b', "name a\x01", "name é", " ".join(["time"] * 13)):
                with pytest.raises(LiveRefused):
                    world.ask(line)
            others = [_world(flight) for _ in range(7)]
            with pytest.raises(LiveRefused, match="at most 8"):
                _world(flight)
            others[0]._socket.sendall(b"hand aim 0.1")
            for other in others:
                other.close()
            world.ask("time")
            with _world(flight) as endless, pytest.raises(LinkLost):
                endless._socket.sendall(b"x" * 600)
                endless.ask("time")
            world.ask("time")
        assert flight.read("live.scn") == ""
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    assert flight.code == 0, flight.transcript()


@pytest.mark.long
def test_a_pause_may_be_longer_than_the_launcher_waits_for_simulated_time(directory):
    """The launcher ends a run whose simulated time has stopped for 30 s, except in a pause."""
    flight = flying.start(directory, "--time", "real", "--scenario", "none")
    try:
        with _world(flight) as world:
            began = world.ask("pause")[0]
            time.sleep(PAUSE_S)
            assert world.ask("resume")[0] - began < 0.01
            _until(world, began + 0.1)
    finally:
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    assert flight.code == 0, flight.transcript()


def test_stepped_flights_have_no_live_port(session_directory, flight):
    assert not list((session_directory / "again-image").glob("live.*"))
