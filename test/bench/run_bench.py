# SPDX-License-Identifier: Apache-2.0
"""Run the measuring programs, print one table, write it as JSON.

A measuring program is test/bench/bench_*.py, or test/bench/bench_*.c, which `make bench` builds as build/bench/bench_*.
It prints lines `BENCH name value unit baseline`; the baseline is what the value is compared with, in the same unit and measured in the same run, `-` if there is
nothing to compare with. Three more words are the median of the ratios within a round, and their low and high end.
`SKIPPED name reason` says why there is no measurement, for example no peer to compare with. The JSON is a list of {name, value, unit, baseline,
ratio}, ratio = value / baseline, with `range` or `skipped` where there is one.

With --check the ratios (with the relation `>=` the values) are compared with the bounds of test/bench/bounds.txt; a skipped row counts as
not within its bound. With --only as well, only the bounds of measured rows are checked."""

import argparse
import json
import pathlib
import subprocess
import sys

BOUNDS = pathlib.Path("test/bench/bounds.txt")


def programs(only):
    """Commands of the measuring programs whose source has `only` in its path."""
    sources = [path for end in ("c", "py") for path in sorted(pathlib.Path("test/bench").glob(f"bench_*.{end}")) if only in str(path)]
    return [[f"build/bench/{path.stem}"] if path.suffix == ".c" else [sys.executable, str(path)] for path in sources]


def row_of(words):
    baseline = None if words[4] == "-" else float(words[4])
    value = float(words[2])
    row = {"name": words[1], "value": value, "unit": words[3], "baseline": baseline,
           "ratio": value / baseline if baseline else None}
    if len(words) == 8:
        row.update(ratio=float(words[5]), range=[float(words[6]), float(words[7])])
    return row


def rows(command):
    """The measurements of one program; raises FileNotFoundError if it is missing, CalledProcessError if it fails."""
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    for line in output.splitlines():
        words = line.split()
        if words[:1] == ["BENCH"] and len(words) in (5, 8):
            yield row_of(words)
        elif words[:1] == ["SKIPPED"] and len(words) > 2:
            yield {"name": words[1], "value": None, "unit": "-", "baseline": None, "ratio": None,
                   "skipped": " ".join(words[2:])}
        else:
            print(line)


def table(measured):
    print(f"{'name':40} {'value':>12} {'unit':10} {'baseline':>12} {'ratio':>8}  range")
    for row in measured:
        if "skipped" in row:
            print(f"{row['name']:40} skipped: {row['skipped']}")
            continue
        baseline = "-" if row["baseline"] is None else f"{row['baseline']:.4g}"
        ratio = "-" if row["ratio"] is None else f"{row['ratio']:.2f}"
        spread = "{:.2f} .. {:.2f}".format(*row["range"]) if "range" in row else ""
        print(f"{row['name']:40} {row['value']:12.4g} {row['unit']:10} {baseline:>12} {ratio:>8}  {spread}")


def verdict(row, relation, limit):
    """(result, text): True or False, or None if there is nothing to compare."""
    if row is None:
        return None, "not measured"
    if "skipped" in row:
        return None, f"skipped: {row['skipped']}"
    if relation == ">=":
        return row["value"] >= limit, f"{row['value']:.4g} {row['unit']}, at least {limit:g}"
    if relation == "faster":
        return row["ratio"] * limit <= 1.0, f"{1.0 / row['ratio']:.2f} times faster, at least {limit:g}"
    return row["ratio"] <= limit, f"{row['ratio']:.2f}, at most {limit:g}"


def check(measured, is_part=False):
    """Print which bounds are kept. Returns True if all are. is_part: check only the rows that were
    measured."""
    by_name = {row["name"]: row for row in measured}
    lines = [line.split() for line in BOUNDS.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
    lines = [line for line in lines if not is_part or line[0] in by_name]
    answers = []
    for name, relation, limit in lines:
        holds, words = verdict(by_name.get(name), relation, float(limit))
        answers.append(holds)
        print(f"{ {True: 'holds', False: 'MISSED', None: '-'}[holds]:7} {name:40} {words}")
    print(f"{answers.count(True)} of {len(answers)} bounds hold, {answers.count(False)} missed, "
          f"{answers.count(None)} without a measurement")
    return all(answers)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="run only programs whose path contains this")
    parser.add_argument("--out", default="build/bench.json")
    parser.add_argument("--check", action="store_true", help="compare the ratios with the bounds")
    parser.add_argument("--reuse", action="store_true", help="measure nothing, take the rows of --out")
    arguments = parser.parse_args()
    if arguments.reuse:
        try:
            measured = json.loads(pathlib.Path(arguments.out).read_text(encoding="utf-8"))
        except FileNotFoundError:
            parser.error(f"{arguments.out} does not exist: run `make bench` first")
        table(measured)
        return 0 if not arguments.check or check(measured) else 1
    measured, failed = [], []
    commands = list(programs(arguments.only))
    if not commands:
        parser.error(f"ONLY={arguments.only}: no measurement has this in its path; see test/bench")
    for command in commands:
        print(f"measuring {command[-1]}", flush=True)
        try:
            measured.extend(rows(command))
        except FileNotFoundError:
            failed.append(f"{command[-1]} does not exist: `make bench` builds it")
        except subprocess.CalledProcessError as failure:
            failed.append(f"{command[-1]} ended with exit code {failure.returncode}")
    table(measured)
    pathlib.Path(arguments.out).write_text(json.dumps(measured, indent=1) + "\n")
    print("\n".join(failed) if failed else f"written to {arguments.out}")
    holds = not arguments.check or check(measured, bool(arguments.only))
    return 1 if failed or not holds else 0


if __name__ == "__main__":
    sys.exit(main())
