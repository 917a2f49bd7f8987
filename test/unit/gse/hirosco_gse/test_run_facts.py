# SPDX-License-Identifier: Apache-2.0
"""A damaged run.json: each command names the file, the key, what it has found and what it expected. A flight under way, and Ctrl-C."""

import errno
import gzip
import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from hirosco_gse import cli, figures, mcap_export, recording, report
from hirosco_gse import run as runs
from hirosco_gse.cli import main
from hirosco_gse.run_directory import end_of, facts_of
from hirosco_gse.station import __main__ as station_main
from hirosco_gse.station import server

DAMAGED = [
    ('{"exit_code": "0"}', 'exit_code: found "0", expected a whole number'),
    ('{"exit_code": true}', "exit_code: found true, expected a whole number"),
    ('{"exit_code": 0, "simulated_s": NaN}', "simulated_s: found NaN, expected a finite number"),
    ('{"free_drag_nm": -Infinity}', "free_drag_nm: found -Infinity, expected a finite number"),
    ('{"processes": [{"name": "a"}, {"wall_s": 1e999}]}', "processes.1.wall_s: found Infinity, expected a finite number"),
    (f'{{"simulated_s": 1{"0" * 400}}}', f"simulated_s: found 1{'0' * 199}... (401 characters), expected a number"),
    ('{"relay": 7}', "relay: found 7, expected an object"),
    ('{"relay": {"round_trip_ms": [20]}}', "relay.round_trip_ms: found [20], expected a number"),
    ('{"cut_short": 0}', "cut_short: found 0, expected true or false"),
    ('{"versions": null}', "versions: found null, expected an object"),
    ('{"interface_hash": "12"}', 'interface_hash: found "12", expected a hash such as 0x12AB'),
    ('{"mission": ["rokviss"]}', 'mission: found ["rokviss"], expected text'),
    ('{"report_problems": "none"}', 'report_problems: found "none", expected a list'),
]


@pytest.fixture
def run(flight_directory, tmp_path):
    """Directory of a run with packets only."""
    lines = (flight_directory / "packets.log").read_text(encoding="ascii").splitlines(True)
    (tmp_path / "packets.log").write_text("".join(lines[:20]), encoding="ascii")
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "index.html").write_text("")
    return tmp_path


@pytest.mark.parametrize(("text", "words"), DAMAGED)
def test_each_command_names_the_file_and_the_key(run, dictionary_path, capsys, text, words):
    (run / "run.json").write_text(text)
    words = f"run.json: {words}"
    given = ["--run", str(run), "--dictionary", str(dictionary_path)]
    commands = ((["ping"], 3), (["record"], 2), (["decode", str(run / "packets.log")], 0), (["mcap", str(run)], 0))
    for command, code in commands:
        assert main([*given, *command]) == code
        assert words in "".join(capsys.readouterr()), command
    assert report.main([str(run), str(dictionary_path)]) == report.FIGURES_UNKNOWN
    assert words in capsys.readouterr().err and (run / "run.json").read_text() == text
    assert end_of(run) == (f"the flight of {run.name} has ended; {words}", None)
    station_main._check(station_main._parser().parse_args(["--replay", str(run), "--page", str(run / "page")]))
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(("text", "command", "words"), [
    ("{}", ["ping"], "run.json: exit_code: found none, expected a whole number"), ('{"exit_code": 0, "exit_reason": ""}', ["ping"], "run.json: simulated_s: found none"),
    ('{"exit_code": 0}', ["record"], "run.json: scenario: found none, expected text"), ("", ["record"], "run.json: "), (None, ["record"], "found no run.json"),
])
def test_a_missing_key_is_named_with_its_file(run, dictionary_path, capsys, text, command, words):
    if text is not None:
        (run / "run.json").write_text(text)
    else:
        (run / "ground.port").write_text("1\n")
    assert main(["--run", str(run), "--dictionary", str(dictionary_path), *command]) in (2, 3)
    assert words in capsys.readouterr().err


def test_a_complete_run_json_has_no_problem(flight_directory):
    assert facts_of(flight_directory)[1] is None


def test_no_report_is_made_of_a_flight_under_way(run, dictionary_path, capsys):
    """A report writes run.json, which would tell ground users that the flight has ended. To find out whether a flight is under way,
    no connection is made, because the flight would notice it."""
    with socket.create_server(("127.0.0.1", 0)) as flight:
        flight.setblocking(False)
        (run / "ground.port").write_text(f"{flight.getsockname()[1]}\n")
        assert report.main([str(run), str(dictionary_path)]) == 1
        with pytest.raises(BlockingIOError):
            flight.accept()
    said = capsys.readouterr().err
    assert "its flight is under way, expected one that has ended" in said and f"make report OUT={run}" in said
    assert not (run / "run.json").exists()
    assert report.main([str(run), str(dictionary_path)]) == 0


@pytest.mark.parametrize(("scenario", "code"), [("commissioning", 130), ("telepresence", 4)])
def test_ctrl_c_during_a_report_is_reported(run, dictionary_path, monkeypatch, capsys, scenario, code):
    """If the run has bounds, its figures are not known, so it has failed (exit code 4)."""

    def interrupted(*_):
        raise KeyboardInterrupt

    (run / "run.json").write_text(json.dumps({"mission": "rokviss", "scenario": scenario, "exit_code": 0}))
    monkeypatch.setattr(report, "page", interrupted)
    assert report.main([str(run), str(dictionary_path)]) == code
    assert capsys.readouterr().err == f"report: not written: ended by Ctrl-C. To try again: make report OUT={run}\n"
    assert json.loads((run / "run.json").read_text())["exit_code"] == (0 if code == 130 else 1)


@pytest.mark.parametrize(("module", "imported", "code"), [
    ("hirosco_gse.report", "numpy", 130), ("hirosco_gse.recording", "numpy", 1), ("hirosco_gse.station", "aiohttp", 130), ("hirosco_gse", "argparse", 130),
])
def test_ctrl_c_while_a_program_starts_prints_no_stack_trace(run, module, imported, code):
    """Ctrl-C arrives while the program imports the module `imported`."""
    program = f"""
import builtins, os, runpy, signal, sys
load = builtins.__import__
def loading(name, *rest, **named):
    if name == {imported!r}:
        os.kill(os.getpid(), signal.SIGINT)
    return load(name, *rest, **named)
builtins.__import__ = loading
sys.argv = ["program", {str(run)!r}]
runpy.run_module({module!r}, run_name="__main__")
"""
    arguments = {"hirosco_gse.station": '["program"]', "hirosco_gse": '["gse", "permissions"]'}
    program = program.replace(f'["program", {str(run)!r}]', arguments.get(module, f'["program", {str(run)!r}]'))
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env={**os.environ, "PYTHONPATH": "gse"}, capture_output=True, text=True)
    assert (done.returncode, "Traceback" in done.stderr) == (code, False), done.stderr
    assert not done.stderr or "Ctrl-C" in done.stderr


def test_a_directory_that_this_user_may_not_write_is_reported_with_the_next_step(run, dictionary_path, monkeypatch, capsys):
    (run / "run.json").write_text('{"scenario": "commissioning"}')

    def denied(path, write):
        raise OSError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(report, "write_whole", denied)
    monkeypatch.setattr("hirosco_gse.pcap.write_whole", denied)
    step = "expected a directory that this user may write: copy the run to such a directory, and name the copy"
    assert report.main([str(run), str(dictionary_path)]) == 1
    assert capsys.readouterr().err.startswith(f"report: not written: {run}/run.json: Permission denied; {step}.")
    assert main(["pcap", str(run)]) == 2
    assert capsys.readouterr().err == f"gse: {run}/packets.pcap: Permission denied; {step}\n"


def test_a_file_that_this_user_may_not_read_is_reported_with_the_next_step(run, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    problem = PermissionError(errno.EACCES, "Permission denied", str(run / "packets.log"))
    assert cli._words_of(problem) == f"{run}/packets.log: Permission denied; expected a file that this user may read: change its permissions"


def test_a_figure_that_is_no_number_is_missing(flight_directory, dictionary_path, tmp_path, monkeypatch, capsys):
    for path in flight_directory.iterdir():
        if not path.name.startswith("can-"):
            shutil.copy(path, tmp_path)
    table = (((lambda run: {"free_drag_nm": math.nan, "link_lost": 0}, ("free_drag_nm",)),), lambda facts: {"free_drag_nm": ("<=", 0.015)})
    monkeypatch.setitem(figures.TABLES, ("rokviss", "telepresence"), table)
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_FAILED
    facts = json.loads((tmp_path / "run.json").read_text(), parse_constant=pytest.fail)
    assert facts["free_drag_nm"] is None and facts["figures_missing"]["free_drag_nm"] == "the logs give no finite number" and facts["link_lost"] == 0
    assert "missing: the logs give no finite number" in capsys.readouterr().out


def test_recordings_and_exports_are_json_without_nan(run, dictionary_path):
    """A browser could not read the recording."""
    octets = recording.make(runs.load(run, dictionary_path), {"facts": {"free_drag_nm": math.nan}})
    head = gzip.decompress(octets)
    size = int.from_bytes(head[:4], "little")
    assert json.loads(head[4 : 4 + size], parse_constant=pytest.fail)["about"]["facts"] == {"free_drag_nm": None}
    file = mcap_export._File()
    file.json("/a", [(0, {"value": np.float32(math.inf), "other": [1.5, math.nan]})])
    assert json.loads(file.rows[0][2], parse_constant=pytest.fail) == {"value": None, "other": [1.5, None]}


@pytest.fixture
def signals():
    """Restores the signal handlers of this process after the test."""
    kept = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in kept.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_flight_that_the_station_has_started_ends_with_it(run, monkeypatch, capsys, signals, number):
    """It also ends if the terminal is closed (SIGHUP), and if the station ends before it serves the page: the flight begins before the
    modules of the server are loaded."""
    started, popen, load = [], subprocess.Popen, station_main._load

    def start(*arguments, **options):
        started.append(popen(*arguments, **options))
        return started[0]

    monkeypatch.setattr(station_main.subprocess, "Popen", start)
    monkeypatch.setattr(station_main, "_load", lambda: load() if started else pytest.fail("the flight waits for the modules"))
    monkeypatch.setattr(server, "Station", lambda *_: os.kill(os.getpid(), number))
    options = ["--run", str(run / "none"), "--page", str(run / "page"), "--http-port", "0"]
    assert station_main.main([*options, "--fly", sys.executable, "-c", "import time; time.sleep(600)"]) == 130
    assert started[0].poll() is not None
    assert capsys.readouterr().err.endswith("station: ended by Ctrl-C\n")
