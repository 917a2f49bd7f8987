# SPDX-License-Identifier: Apache-2.0
"""Costs of the manipulator on the emulated board.

Steps: the longest, the 99th percentile and the median of each state and each transition, in instructions. They follow
from program and scenario, and do not depend on the speed of the machine; repeated flights differ by up to 50
instructions. The baseline of the longest is the number of clock cycles in a period of 0.5 ms at 216 MHz.
Stacks: the octets used; the baseline is the octets reserved. The use by the tasks for the loops of services is from a
run in real time (test/board/real_time.c).
Wall time and processor time of all programs, in the scenario hil: the least of two flights on the board; the baseline
is the least of two native flights. Other load changes the processor time less than the wall time.
Requests that store a record on the EEPROM (test/board/commits.c): instructions, and the time that a real EEPROM
needs.

With UPDATE=1 the tables of docs/porting.md are written again."""

import os
import pathlib
import resource
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test" / "board"))

import failures
import flight

flying = flight.flying
PAGE = ROOT / "docs" / "porting.md"
BUDGET = 108000  # Cycles of 0.5 ms at 216 MHz.
FLIGHTS = 2


def table_of(head, rows):
    lines = [head, "|" + "|".join("---" for _ in head.strip("|").split("|")) + "|"]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def tables(rows, stacks, commits):
    """Name -> text of each table of the page."""
    kept = [(one.records, one.size, one.compaction, one.instructions, one.pages, one.octets, f"{one.ms:.0f}") for one in commits]
    ordered = sorted(rows, key=lambda row: (row.before != row.after, flight.STATES.index(row.before), flight.STATES.index(row.after)))
    steps = [(row.name, row.count, row.median, row.p99, row.longest, f"{100 * row.longest / BUDGET:.0f} %") for row in ordered]
    used = [(stack.task, stack.octets, stack.used, f"{100 * (1 - stack.used / stack.octets):.0f} %") for stack in stacks]
    return {"steps": table_of("| state, or transition | steps | median | 99th percentile | longest | of 108000 |", steps),
            "stacks": table_of("| stack of | octets | used | never used |", used),
            "commits": table_of("| records | octets of each | compaction | instructions | pages written | octets on the bus | real EEPROM [ms] |", kept)}


def with_real_time(stepped, real):
    """Stacks with the larger use of both runs. The tasks of loops of services exist only in real time; they have no names."""
    used = {}
    for stack in (*stepped, *real):
        task = "loop_of_services" if stack.task == "task" else stack.task
        used[task] = max(used.get(task, stack), flight.Stack(task, stack.octets, stack.used), key=lambda one: one.used)
    return list(used.values())


def update(page, rows, stacks, commits):
    """Replace the tables of the page."""
    text = page.read_text(encoding="utf-8")
    for name, table in tables(rows, stacks, commits).items():
        begin, end = f"<!-- table: {name} -->\n", "<!-- end -->"
        before, _, rest = text.partition(begin)
        assert rest, f"{page}: no line {begin.strip()}"
        text = before + begin + table + end + rest.partition(end)[2]
    page.write_text(text, encoding="utf-8")


def processor_seconds():
    """Processor time of all programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def seconds(directory, *options):
    """Least wall time and least processor time of flights of the scenario hil."""
    times = []
    for number in range(FLIGHTS):
        before = processor_seconds()
        flown = flying.fly(directory / f"{len(options)}-{number}", "--scenario", "hil", *options)
        assert flown.code == 0, flown.transcript()
        times.append((flown.seconds, processor_seconds() - before))
    return tuple(map(min, zip(*times, strict=True)))


def main():
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        rows, stacks = flight.steps(directory, flight.LOSSES)
        stacks = with_real_time(stacks, flight.loop_in_real_time(directory)[1])
        commits = flight.commits(directory)
        native, target = seconds(directory, "--links", "udp"), seconds(directory, "--rtos", "MANIPULATOR", "--seed", "1")
    for row in rows:
        name = row.name.replace(" ", "_")
        print(f"BENCH target_{name}_longest {row.longest} instr {BUDGET}")
        print(f"BENCH target_{name}_p99 {row.p99} instr -")
        print(f"BENCH target_{name}_median {row.median} instr -")
    for one in commits:
        name = f"commit_of_{one.records}_records_of_{one.size}_octets_with_compaction_{one.compaction.replace(' ', '_')}"
        print(f"BENCH target_{name} {one.instructions} instr -")
        print(f"BENCH target_{name}_on_a_real_eeprom {one.ms:.0f} ms -")
    for stack in stacks:
        print(f"BENCH target_stack_{stack.task} {stack.used} octets {stack.octets}")
    for name, on_board, baseline in zip(("wall", "processor"), target, native, strict=True):
        print(f"BENCH target_hil_{name}_time {on_board:.2f} s {baseline:.2f}")
    if os.environ.get("UPDATE"):
        update(PAGE, rows, stacks, commits)


if __name__ == "__main__":
    failures.run(main)
