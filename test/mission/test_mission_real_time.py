# SPDX-License-Identifier: Apache-2.0
"""Wall-clock time, and a user at the command line. No test depends on the speed of the machine."""

import json
import os
import signal
import subprocess

import flying
import pytest

OPTIONS = ("--time", "real", "--scenario", "none")
SUCCESS, FAILED, USAGE, NO_LINK = 0, 1, 2, 3
SUBSYSTEMS = ("JOYSTICK", "MANIPULATOR", "SUPERVISOR", "COMMUNICATION")


@pytest.fixture
def mission(directory):
    """A mission in wall-clock time that has started and listens."""
    flight = flying.start(directory, *OPTIONS)
    flying.wait_until(lambda: flying.gse(flight, "ping", "all").returncode == SUCCESS, "all subsystems answer")
    yield flight
    flight.abandon()


def _reported(flight, *words):
    done = flying.gse(flight, *words)
    assert done.returncode == SUCCESS, (words, done)
    return done.stdout


def _status(flight):
    """Dictionary: subsystem -> state, from `gse status`."""
    return {line.split()[0]: line.split()[2] for line in _reported(flight, "status").splitlines()}


def _last_states(flight):
    """Dictionary: APID -> last state in the packet log."""
    found = {}
    for _, direction, raw in flight.packets:
        if direction == "TM" and raw[7:9] == b"\x81\x02":
            found[int.from_bytes(raw[:2], "big") & 0x7FF] = raw[22]
    return found


def test_a_person_commands_the_mission(mission):
    """Ping, show, bring up, move, a refusal, stop, shut down: each has a text and an exit code."""
    assert {line.split()[0] for line in _reported(mission, "ping", "all").splitlines()} == set(SUBSYSTEMS)
    assert _status(mission) == {"JOYSTICK": "OFFLINE", "MANIPULATOR": "OFFLINE", "SUPERVISOR": "OPERATIONAL", "COMMUNICATION": "OPERATIONAL"}

    for name in ("MANIPULATOR", "JOYSTICK"):
        assert "completed" in _reported(mission, "state", name, "PRE_OPERATIONAL")
    refused = flying.gse(mission, "cmd", "MANIPULATOR.MOVE_TO", "POSITION=0.9,-1.3", "DURATION=1")
    assert refused.returncode == FAILED
    assert "not permitted in mode NOMINAL while in state PRE_OPERATIONAL" in refused.stderr
    refused = flying.gse(mission, "state", "MANIPULATOR", "SAFE_OPERATIONAL")
    assert refused.returncode == FAILED, "expected a refusal, because no configuration is selected"
    assert "refused" in refused.stderr

    _reported(mission, "config", "MANIPULATOR", "STAND_ALONE")
    # Structure 4711 is reported four times a second; the command waits for two reports.
    flying.wait_until(lambda: _reported(mission, "hk", "MANIPULATOR").count("DES_POSITION") >= 4, "housekeeping")
    for state in ("SAFE_OPERATIONAL", "OPERATIONAL"):
        _reported(mission, "state", "MANIPULATOR", state)
    assert "completed" in _reported(mission, "cmd", "MANIPULATOR.MOVE_TO", "POSITION=0.95,-1.4", "DURATION=1")
    position = json.loads(_reported(mission, "get", "MANIPULATOR.CUR_VALUES", "--json").splitlines()[-1])
    assert "0.95" in json.dumps(position) or "0.949" in json.dumps(position)

    assert _reported(mission, "stop")
    after = _status(mission)
    assert after["MANIPULATOR"] == "ERROR_OPERATIONAL"
    assert _reported(mission, "shutdown")
    mission.wait()
    assert mission.code == 0, mission.transcript()
    assert mission.facts["time"] == "real"
    assert mission.facts["reproducible"] is False
    assert _last_states(mission)[16] == 0
    assert _last_states(mission)[17] == 0
    flying.assert_clean(mission)


class NoMission:
    """Stands for a mission that does not exist: no process listens on its port."""

    directory = flying.ROOT / "no-run"  # Without a run, the ground segment takes the dictionary of rokviss.

    @staticmethod
    def port():
        return 1


def test_usage_errors_need_no_link():
    """A usage error ends with exit code 2 and a message that contains the correct form or words."""
    for words, message in [
        (("cmd", "MANIPULATOR.FLY"), "MOVE_TO"),
        (("cmd", "MANIPULATOR.MOVE_TO", "POSITION=1"), "POSITION"),
        (("cmd", "MANIPULATOR.MOVE_TO", "POSITION=1,2", "DURATION=soon"), "soon"),
        (("state", "MOON", "OFFLINE"), "MANIPULATOR"),
        (("state", "MANIPULATOR", "FLYING"), "PRE_OPERATIONAL"),
        (("config", "MANIPULATOR", "PARTY"), "TELEPRESENCE"),
        (("link", "open", "STRING"), "HAND_POSITION"),
        (("mode", "FUN"), "NOMINAL"),
        (("log", "paper"), "sqlite"),
        (("raw", "xyz"), "xyz"),
        (("set", "MANIPULATOR.TORQUE_LIMIT", "1"), "TORQUE_LIMIT"),
        (("frobnicate",), "no command 'frobnicate'; gse --help lists them"),
    ]:
        done = flying.gse(NoMission, *words)
        assert done.returncode == USAGE, (words, done)
        assert message in done.stderr, (words, done)
        assert "Traceback" not in done.stderr


def test_no_link_has_its_own_exit_code():
    done = flying.gse(NoMission, "ping", "all")
    assert done.returncode == NO_LINK, done
    assert "127.0.0.1" in done.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_brings_every_subsystem_to_offline(mission, number):
    for name in ("MANIPULATOR", "JOYSTICK"):
        _reported(mission, "state", name, "PRE_OPERATIONAL")
        _reported(mission, "config", name, "STAND_ALONE")
        _reported(mission, "state", name, "SAFE_OPERATIONAL")
    _reported(mission, "state", "MANIPULATOR", "OPERATIONAL")
    os.kill(mission.process.pid, number)
    mission.wait()
    assert mission.code == 0, mission.transcript()
    assert "shutting the mission down" in mission.output
    assert _last_states(mission)[16] == 0
    assert _last_states(mission)[17] == 0
    assert _last_states(mission)[2] == 0
    flying.assert_clean(mission)


def test_the_end_of_the_terminal_and_ctrl_c_shut_the_mission_down_in_order(directory, tmp_path):
    """A terminal sends both signals to the whole process group, including the components and the operator, whose script is then cut."""
    # The shutdown ends the script long before its last line.
    expected = (f"{1 + i / 20:.2f} operator expect-refusal 0x0111 state MANIPULATOR SAFE_OPERATIONAL" for i in range(2000))
    scenario = flying.write_scenario(tmp_path / "long.scn", "0.1 operator state MANIPULATOR PRE_OPERATIONAL", *expected)
    flight = flying.start(directory, "--time", "real", "--scenario", scenario)
    try:
        flying.wait_until(lambda: (directory / "operator.log").exists() and "expect-refusal" in flight.read("operator.log"), "the second line of the operator")
        for number in (signal.SIGHUP, signal.SIGINT):
            os.killpg(flight.process.pid, number)
        flight.wait()
        assert flight.code == 0, flight.transcript()
        assert _last_states(flight)[16] == 0
    finally:
        flight.abandon()
    flying.assert_clean(flight)


def test_following_ends_with_an_interrupt(mission):
    """`gse hk -f` runs until Ctrl-C and then ends with success."""
    _reported(mission, "state", "MANIPULATOR", "PRE_OPERATIONAL")
    _reported(mission, "config", "MANIPULATOR", "STAND_ALONE")
    words = [*flying.gse_words(mission), "hk", "-f", "MANIPULATOR"]
    follower = subprocess.Popen(words, cwd=flying.ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    structures = 0
    while structures < 4:
        line = follower.stdout.readline()
        assert line, follower.communicate()
        structures += "CUR_VALUES" in line
    follower.send_signal(signal.SIGINT)
    _, errors = follower.communicate(timeout=flying.MOMENT_S)
    assert follower.returncode == SUCCESS, errors
    assert errors == ""
    _reported(mission, "shutdown")
    mission.wait()


def test_each_step_of_a_scenario_is_performed_in_wall_clock_time(directory):
    """The operator performs all steps of the scenario in wall-clock time too."""
    flight = flying.fly(directory, "--time", "real", "--scenario", "commissioning")
    assert flight.code == 0, flight.transcript()
    assert flight.facts["simulated_s"] >= 3.5
    assert len(flight.read("operator.log").splitlines()) == 12
    flying.assert_clean(flight)
