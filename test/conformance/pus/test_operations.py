# SPDX-License-Identifier: Apache-2.0
"""Executes the commands of docs/operations.md in a flight in real time, and compares their output with the page."""

import re
import shlex
import signal

import flying
import pytest
import station as stations

PAGE = flying.ROOT / "docs" / "operations.md"
BLOCK = re.compile(r"^```(sh|text|lua)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def _pattern(expected):
    """Pattern of a block of text: `...` matches any text, and on a line of its own any lines."""
    return re.compile(".*".join(re.escape(part) for part in re.split(r"\.\.\.", expected.strip())), re.DOTALL)


def _steps():
    """(commands, expected output or None) of the page, in order; its files are written."""
    steps = []
    for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        if kind == "sh":
            steps.append([text, None])
        elif kind == "lua":
            (flying.ROOT / text.splitlines()[0].removeprefix("-- ")).write_text(text, encoding="utf-8")
        else:
            steps[-1][1] = text
    return steps


@pytest.fixture
def real_time(notes, tmp_path):
    """A flight in real time, as on the page, and a station that receives its reports."""
    flight = flying.start(tmp_path / "run", "--scenario", "none", "--time", "real")
    ground = stations.Station(flight, notes)
    yield ground
    ground.close()
    flight.process.send_signal(signal.SIGINT)
    flight.wait()


def test_every_example_works_as_it_stands(real_time, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    real_time.report(129, 5, apid=16)
    for commands, expected in _steps():
        output = ""
        for line in commands.splitlines():
            words = shlex.split(line)
            assert words[0] == "gse/gse", line
            done = flying.gse(real_time.flight, "--timeout", "600", *words[1:])  # The machine may be slow.
            assert done.returncode == 0, f"{line}: {done.stdout}{done.stderr}"
            output += done.stdout
        if expected is not None:
            assert _pattern(expected).search(output), f"{commands}\noutput:\n{output}\nexpected:\n{expected}"
