# SPDX-License-Identifier: Apache-2.0
"""The prompt, on a pseudo-terminal and with lines from a list; colours; refusals that contain limits."""

import os
import struct
import sys

import pytest
from conftest import ROOT
from hirosco_gse import colours
from hirosco_gse.cli import main
from hirosco_gse.shell import Shell
from hirosco_gse.spacecraft import Spacecraft
from spacecraft import Spacecraft as Simulated
from spacecraft import failure, success
from terminal import converse

MANIPULATOR = 16


@pytest.fixture
def talk(dictionary_path, tmp_path):
    """talk(answer, *lines) -> (what is shown, the simulated spacecraft)."""
    made = []

    def run(answer, *lines):
        simulated = Simulated(answer)
        made.append(simulated)
        left, shown = list(lines), []

        def read(prompt):
            if not left:
                raise EOFError
            line = left.pop(0)
            if isinstance(line, type):
                raise line
            return line

        with Spacecraft(tmp_path, port=simulated.port, dictionary=dictionary_path, timeout_s=60) as craft:
            Shell(craft, read, lambda text: shown.append(str(text))).run()
        return shown, simulated

    yield run
    for one in made:
        one.close()


def test_commands_share_one_connection_and_errors_do_not_end_it(talk):
    shown, simulated = talk(
        success, "cmd MANIPULATOR.TARE", "", "state NOBODY OFFLINE", "dance", "'", KeyboardInterrupt, "pause", "help state", "help", "cmd MANIPULATOR.STOP", "exit", "ping")
    assert [packet.data[:4] for packet in simulated.received] == [b"TARE", b"STOP"] and simulated.connections == 1
    assert shown[0] == "cmd MANIPULATOR.TARE: completed" and shown[-1] == "cmd MANIPULATOR.STOP: completed"
    text = "\n".join(shown)
    assert "no subsystem 'NOBODY'" in text and "no command 'dance'" in text and "No closing quotation" in text and "no live port" in text
    assert "usage: gse state SUBSYSTEM|all STATE" in text and "help COMMAND: one command" in text


def test_a_lost_link_is_opened_again_by_the_next_command(talk):
    answers = iter([None, success])

    def answer(packet):
        kind = next(answers, success)
        return kind(packet) if kind else None

    shown, simulated = talk(answer, "cmd MANIPULATOR.TARE", "cmd MANIPULATOR.STOP")
    assert "closed the link" in shown[0] and shown[1] == "cmd MANIPULATOR.STOP: completed"
    assert len(simulated.received) == simulated.connections == 2


def test_the_last_20_events_since_a_prompt_are_shown_and_the_others_are_counted(talk, dictionary):
    event = dictionary.subsystem("MANIPULATOR").event("TORQUE_LIMIT")
    report = (5, 3, struct.pack(">HBdd", event.id, 1, 39.5, 38.0))
    shown, _ = talk(lambda packet: success(packet, *[report] * 25), "cmd MANIPULATOR.TARE", "cmd MANIPULATOR.STOP")
    of_prompt = "  MANIPULATOR: MEDIUM TORQUE_LIMIT  JOINT=1  TORQUE=39.5 Nm  LIMIT=38 Nm"  # After the time.
    assert sum(line.endswith(of_prompt) for line in shown) == 2 * 20
    assert shown.count("(5 events before these)") == 2


def test_the_prompt_completes_words_and_keeps_its_history(dictionary_path, tmp_path):
    """On a pseudo-terminal: Tab completes a word, a refusal (PUS_FAILURE_STATE) is red, and in the next session
    the arrow key recalls the command of the first one."""
    simulated = Simulated(lambda packet: failure(packet, 4, 0x0204, 0x0305) if packet.data[:4] == b"TARE" else success(packet))
    command = [sys.executable, str(ROOT / "gse/gse"), "--port", str(simulated.port), "--dictionary", str(dictionary_path), "shell"]
    environment = {**os.environ, "TERM": "xterm", "XDG_STATE_HOME": str(tmp_path), "INPUTRC": "/dev/null"}
    environment.pop("NO_COLOR", None)
    for steps, awaited in (
        ([("rokviss> ", "cmd manipulator.tar\t"), ("MANIPULATOR.TARE ", "\n"), ("rokviss> ", "exit\n")], "\x1b[31mgse: cmd MANIPULATOR.TARE: refused"),
        ([("rokviss> ", "\x1b[A\x1b[A"), ("cmd MANIPULATOR.TARE", "\x15cmd MANIPULATOR.STOP\n"), ("rokviss> ", "\x04")], ""),
    ):
        shown, code = converse(command, environment, steps)
        assert awaited in shown and code == 0
    simulated.close()
    assert [packet.data[:4] for packet in simulated.received] == [b"TARE", b"STOP"]


class _Terminal:
    def __init__(self, is_one):
        self.isatty = lambda: is_one


@pytest.mark.parametrize(("is_terminal", "variables", "is_red"), [
    (True, {}, True), (False, {}, False), (True, {"NO_COLOR": "1"}, False), (True, {"NO_COLOR": ""}, True), (True, {"TERM": "dumb"}, False)])
def test_only_a_terminal_gets_colours(monkeypatch, is_terminal, variables, is_red):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert (colours.coloured("x", "HIGH", _Terminal(is_terminal)) != "x") == is_red
    assert colours.coloured("x", "INFORMATIVE", _Terminal(is_terminal)) == colours.coloured("x", None, _Terminal(True)) == "x"


@pytest.mark.parametrize(("words", "limits"), [
    (["cmd", "MANIPULATOR.MOVE_TO", "POSITION=9,0", "DURATION=2"], "POSITION is [9, 0] rad, expected at least -2.8 and at most 2.8 rad"),
    (["cmd", "MANIPULATOR.MOVE_TO", "POSITION=0,nan", "DURATION=0.05"], "DURATION is 0.05 s, expected at least 0.1 and at most 600 s"),
    (["set", "MANIPULATOR.TORQUE_LIMIT", "30,41"], "TORQUE_LIMIT is [30, 41] Nm, expected at least 0.1 and at most 40 Nm"),
    (["cmd", "MANIPULATOR.TARE"], "(at octet 9) [0x0203]"),  # Without arguments there are no limits to show.
])
def test_a_value_out_of_range_is_named_with_its_limits(dictionary_path, capsys, words, limits):
    simulated = Simulated(lambda packet: failure(packet, 4, 0x0203, 9))
    code = main(["--port", str(simulated.port), "--dictionary", str(dictionary_path), *words])
    simulated.close()
    assert code == 1 and limits in capsys.readouterr().err
