# SPDX-License-Identifier: Apache-2.0
"""The live view in the terminal, with a simulated spacecraft: by textual's pilot, and on a pseudo-terminal."""

import asyncio
import json
import os
import struct
import sys
import time

import pytest
from conftest import ROOT
from hirosco_gse import monitor as monitor_module
from hirosco_gse.cli import main
from hirosco_gse.monitor import Monitor
from spacecraft import Spacecraft as Simulated
from spacecraft import failure, success
from terminal import converse
from textual.widgets import DataTable, Input, RichLog, Static

MANIPULATOR, TIMEOUT_S = 16, 600.0


@pytest.fixture
def reached(dictionary, dictionary_path, tmp_path):
    """What Monitor needs to reach a spacecraft that reports a state, housekeeping and two events after
    TC[131,8]."""
    manipulator = dictionary.subsystem("MANIPULATOR")
    event = manipulator.event("TORQUE_LIMIT")
    reports = [
        (MANIPULATOR, 129, 5, struct.pack(">BBBHQQII", 5, 0, 5, 1, manipulator.interface_hash, 0, 0, 0), 0),
        (MANIPULATOR, 3, 25, struct.pack(">H", 4712) + bytes(manipulator.parameter("COUNTERS").size) + struct.pack(">4d", 38, 99, 0, 0.5), 0),
        (MANIPULATOR, 5, 3, struct.pack(">HBdd", event.id, 1, 39.5, 38.0), 0),
        (MANIPULATOR, 5, 4, struct.pack(">HB", manipulator.event("DEVICE_LOST").id, 0x11), 0),
    ]

    def answer(packet):
        if packet.message == (131, 8):
            return success(packet, (131, 9, struct.pack(">HHBBBHB", 1, 17, 1, 0, 0, 0, 0))) + reports
        if packet.message == (129, 1):
            return failure(packet, 4, 0x0204, 0x0305)  # PUS_FAILURE_STATE.
        return success(packet)

    simulated = Simulated(answer, dictionary.epoch_ns)
    yield {"port": simulated.port, "dictionary": dictionary_path}, tmp_path, simulated
    simulated.close()


def _text(table):
    return [" | ".join(str(cell) for cell in table.get_row(key)) for key in table.rows]


async def _until(pilot, condition, what):
    end = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < end, what
        await pilot.pause(0.05)


def test_the_flight_is_shown_and_commanded(reached):
    """States, values with units, a value beyond its limit, an event; a refused and a completed command with
    their lights."""
    given, run, simulated = reached

    async def look():
        app = Monitor(run, **given)
        async with app.run_test(size=(160, 50)) as pilot:
            tables = {name: app.query_one(f"#{name}", DataTable) for name in ("states", "housekeeping", "commands")}
            await _until(pilot, lambda: tables["housekeeping"].row_count and len(app.query_one("#events", RichLog).lines) > 1, "no telemetry")
            await _until(pilot, lambda: any("MANIPULATOR | OPERATIONAL" in row for row in _text(tables["states"])), "no state")
            assert any(row.startswith("JOYSTICK | OFFLINE") for row in _text(tables["states"]))
            values = _text(tables["housekeeping"])
            assert any(row.startswith("MANIPULATOR.TORQUE_LIMIT | [38, 99] | Nm | 0.0") for row in values)
            assert tables["housekeeping"].get_row("MANIPULATOR.TORQUE_LIMIT")[1].style == "bold red"
            assert tables["housekeeping"].get_row("MANIPULATOR.TORQUE_OFFSET")[1].style == ""
            line = app.query_one("#events", RichLog).lines[0].text
            assert "MEDIUM" in line and "MANIPULATOR.TORQUE_LIMIT" in line and "torque 39.5 Nm" in line
            assert "node JOINT1 (0x11)" in app.query_one("#events", RichLog).lines[1].text
            head = str(app.query_one("#head", Static).render())
            assert "rokviss" in head and f"127.0.0.1:{given['port']}" in head and "1000.0 s" in head
            entry = app.query_one("#command", Input)
            for text in ("state manipulator pre_operational", "cmd MANIPULATOR.TARE"):
                entry.value = text
                await pilot.press("enter")
            await _until(pilot, lambda: all(call.is_over for call in app.hub.commands) and tables["commands"].row_count == 2, "no end")
            await pilot.pause(0.5)
            tare, state = _text(tables["commands"])
            assert "+ accepted | + started |  | + completed" in tare.replace("- step", "")
            assert "x started" in state and "not allowed in the present state" in state
            for wrong, words in (("dance", "no command 'dance'"), ("'", "No closing quotation"), ("pause", "refused")):
                entry.value = wrong
                await pilot.press("enter")
                await _until(pilot, lambda words=words: words in str(entry.border_subtitle), words)
            assert await entry.suggester.get_suggestion("state MANI") == "state MANIPULATOR "
            assert await entry.suggester.get_suggestion("dance ") is None
            simulated.close()
        # The monitor creates no housekeeping structure.
        assert [packet.message for packet in simulated.received if packet.message[0] == 3] == [(3, 27)]

    asyncio.run(look())


# Size of a terminal -> texts that it shows. Consoles without a size are drawn as 25 lines of 80 columns; a small one only changes to the second screen.
TERMINALS = {(50, 160): ("TORQUE_LIMIT", "OPERATIONAL"), (0, 0): ("TORQUE_LIMIT",), (5, 20): ("\x1b[?1049h",)}


@pytest.mark.parametrize("size", TERMINALS)
def test_the_monitor_runs_in_a_terminal(reached, monkeypatch, size):
    given, run, _ = reached
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("LINES", "24")
    command = [sys.executable, "-m", "hirosco_gse", "--run", str(run), "--port", str(given["port"]), "--dictionary", str(given["dictionary"]), "monitor"]
    environment = {**os.environ, "TERM": "xterm-256color", "PYTHONPATH": str(ROOT / "gse")}
    assert converse(command, environment, [(TERMINALS[size], "\x11")], size=size)[1] == 0


@pytest.mark.parametrize(("facts", "end"), [
    ({"exit_code": 0, "exit_reason": "", "simulated_s": 93.62}, ("flight ended at 93.62 s, code 0", 0)),
    ({"exit_code": 1, "exit_reason": "the launcher was killed", "simulated_s": 7}, ("flight failed at 7.00 s, code 1: the launcher was killed", 1)),
    (None, ("the flight is gone: for 0 s there was no link, and it has left no run.json", None)),
])
def test_the_monitor_ends_with_the_flight(reached, monkeypatch, facts, end):
    """A flight whose launcher and guard were killed leaves no run.json."""
    given, run, simulated = reached

    async def look():
        app = Monitor(run, **given)
        async with app.run_test() as pilot:
            await _until(pilot, lambda: app._linked_at is not None, "no link")
            simulated.close()
            if facts is None:
                monkeypatch.setattr(monitor_module, "GONE_S", 0.0)
            else:
                (run / "run.json").write_text(json.dumps(facts))
            app.hub._connection.abort()
            await _until(pilot, lambda: app.return_value is not None, "no end")
        return app.return_value

    words, code = asyncio.run(look())
    assert end[0] in words and code == end[1]


@pytest.mark.parametrize(("end", "code"), [(None, 0), (("flight ended", 0), 0), (("flight failed", 1), 1), (("the flight is gone", None), 3)])
def test_the_monitor_prints_why_it_ended_and_has_an_exit_code_for_it(tmp_path, monkeypatch, capsys, end, code):
    monkeypatch.setattr(Monitor, "run", lambda self: end)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    assert main(["--run", str(tmp_path), "monitor"]) == code
    assert capsys.readouterr().err == (f"gse: {end[0]}\n" if end else "")


def test_without_a_terminal_the_command_prints_the_alternatives(capsys):
    assert main(["monitor"]) == 2
    assert "found no terminal, expected one; `hk -f`" in capsys.readouterr().err
