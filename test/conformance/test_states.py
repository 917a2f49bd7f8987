# SPDX-License-Identifier: Apache-2.0
"""docs/states.md and its drawing agree with the state machine: its tables are compared with runs of the code.

UPDATE_STATES=1 writes the tables and docs/images/states.svg again."""

import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "states.md"
DRAWING = ROOT / "docs" / "images" / "states.svg"
HEADER = ROOT / "fsw" / "framework" / "subsystem" / "state_machine.h"
SOURCES = (ROOT / "test/conformance/state_probe.c", HEADER.with_suffix(".c"))
TARGETS = (0, 3, 4, 5, 6)
EVENTS = (
    "own error of HIGH severity", "failure of a member of the real-time network", "order after an error of MEDIUM severity",
    "supervisor lost", "shutdown of the mission",
)
ACTIONS = (
    "software init", "hardware init", "configure", "start control", "stop control", "engage", "disengage", "secure", "post",
    "hardware deinit", "software deinit",
)
# Place of a state in the drawing: column, row.
PLACES = {5: (0, 5), 4: (0, 4), 3: (0, 3), 2: (0, 2), 1: (0, 1), 0: (0.5, 0), 6: (1, 4), 7: (1, 3), 8: (1, 2), 9: (1, 1)}
FILLS = {0: "#f6f7f9", 4: "#fdf1dd", 5: "#e4f3ea", 6: "#fbe7e5"}


@pytest.fixture(scope="module")
def sequences(tmp_path_factory):
    """Output of the probe: a list of [words of the line, states passed after it]."""
    program = tmp_path_factory.mktemp("states") / "probe"
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-D_POSIX_C_SOURCE=200809L", f"-I{ROOT}", "-o", program, *SOURCES], check=True)
    found = []
    for line in subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines():
        words = line.split()
        if words[0] == "change":
            found[-1][1].append((int(words[1]), int(words[2])))
        else:
            found.append([words, []])
    return found


def names(prefix):
    """Dictionary: number -> name of an enumeration in the header."""
    text = HEADER.read_text(encoding="utf-8")
    return {int(number): name for name, number in re.findall(rf"\b{prefix}_(\w+)\s*= (\d+)", text) if name != "COUNT"}


def cell(answer, passed):
    """Text of a table for an answer and the states after it."""
    return " ".join(str(state) for _, state in passed) if answer == "started" else answer


def tables(sequences):
    """Dictionary: name of a table -> its lines."""
    states, phases = names("STATE"), names("PHASE")
    requests = {tuple(words[1:3]): cell(words[3], passed) for words, passed in sequences if words[0] == "request"}
    events = {tuple(words[1:3]): cell(words[3], passed) for words, passed in sequences if words[0] == "event"}
    failures = [(words, sequences[index + 1][0], passed) for index, (words, passed) in enumerate(sequences) if words[0] == "failure"]
    made = {
        "requests": ["| in \\ request for | " + " | ".join(f"{target} {states[target]}" for target in TARGETS) + " |", "|---|" + "---|" * len(TARGETS)],
        "events": ["| event \\ in | " + " | ".join(str(state) for state in states) + " |", "|---|" + "---|" * len(states)],
        "failures": ["| action | runs in | states after its failure | rests in |", "|---|---|---|---|"],
    }
    made["requests"] += [f"| {state} {name} | " + " | ".join(requests[str(state), str(target)] for target in TARGETS) + " |" for state, name in states.items()]
    made["events"] += [f"| {name} | " + " | ".join(events[str(event), str(state)] for state in states) + " |" for event, name in enumerate(EVENTS)]
    for words, rests, passed in failures:
        path = cell("started", passed) or "-"
        made["failures"].append(f"| {ACTIONS[int(words[1]) - 1]} | {words[2]} | {path} | {rests[1]} {states[int(rests[1])]}, {phases[int(rests[2])]} |")
    return made


def drawing(sequences):
    """The changes of state as a graph with fixed positions, for graphviz."""
    lines = ['digraph states{bgcolor="white";node[shape=box,style="rounded,filled",color="#9aa5b1",fillcolor="#eaf1fa",fontname="Helvetica",'
             'fontsize=11,width=2.1,height=.42,fixedsize=true];edge[arrowsize=.6]']
    for state, name in names("STATE").items():
        column, row = PLACES[state]
        lines.append(f's{state}[label="{state} {name}",pos="{column * 250:g},{row * 70}",fillcolor="{FILLS.get(state, "#eaf1fa")}"]')
    for start, end in sorted({change for _, passed in sequences for change in passed}):
        colour = "#b3261e" if end == 6 else "#2f6db3" if start < end <= 5 else "#667080"
        lines.append(f's{start}->s{end}[color="{colour}"]')
    return "\n".join([*lines, "}"])


def block(text, name):
    """The part of the page between the marks of a table."""
    return re.search(rf"<!-- table: {name} -->\n(.*?)<!-- end -->", text, re.DOTALL)


def test_tables_and_drawing_are_those_of_the_code(sequences):
    if os.environ.get("UPDATE_STATES"):
        text = PAGE.read_text(encoding="utf-8")
        for name, lines in tables(sequences).items():
            found = block(text, name)
            text = text[: found.start(1)] + "".join(f"{line}\n" for line in lines) + text[found.end(1) :]
        PAGE.write_text(text, encoding="utf-8")
        made = subprocess.run(["neato", "-n2", "-Tsvg"], input=drawing(sequences), capture_output=True, text=True, check=True).stdout
        DRAWING.write_text(made[made.index("<svg") :], encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    for name, lines in tables(sequences).items():
        assert block(text, name)[1].splitlines() == lines, name
    drawn = {(int(start), int(end)) for start, end in re.findall(r"<title>s(\d)&#45;&gt;s(\d)</title>", DRAWING.read_text(encoding="utf-8"))}
    assert drawn == {change for _, passed in sequences for change in passed}


def test_table_of_states_has_the_numbers_and_names_of_the_header():
    rows = re.findall(r"^\| (\d) \| (\w+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert {int(number): name for number, name in rows} == names("STATE")
    assert len(rows) == 10


def test_phases_and_causes_are_those_of_the_header():
    text = PAGE.read_text(encoding="utf-8")
    for prefix in ("PHASE", "CAUSE"):
        rows = re.findall(rf"^\| {prefix.lower()} (\d) \| (\w+) \|", text, re.MULTILINE)
        assert {int(number): name for number, name in rows} == names(prefix)
