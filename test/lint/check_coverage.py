# SPDX-License-Identifier: Apache-2.0
"""Compare branch and line coverage of the flight software by the C tests, per library, with the marks in coverage.txt.

Reads the results of `make coverage` under build/coverage/ with gcovr. Programs (fsw/programs, launcher, pus/tool) are
not included: the Python tests fly and call them. Branches of FSW_ASSERT do not count: only coding errors take them.
Branches that no input can take are in coverage_exclusions.txt with their reason; an exclusion that matches no branch
any more is a finding. A library below its mark is a finding, and so is an open branch in a library whose mark says
`complete`. Prints a table, the open branches (those that no test takes) of the libraries that are marked `complete`,
and findings; exit code 1. --update raises the marks to what was measured, and never lowers one."""

import argparse
import fnmatch
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MARKS = ROOT / "test/lint/coverage.txt"
EXCLUSIONS = ROOT / "test/lint/coverage_exclusions.txt"
REPORT = ROOT / "build/coverage/coverage.json"
GCOVR = ["gcovr", "--root", ".", "--object-directory", "build/coverage/obj", "--filter", r"(base|osal/posix|osal/common|pus|fsw)/.*\.[ch]$",
         "--exclude", "pus/tool/", "--exclude", "fsw/programs/", "--exclude-branches-by-pattern", r".*FSW_ASSERT\(.*"]


class Exclusion:
    """One row: path | text of the source line | branches that no input takes | reason."""

    def __init__(self, number, line):
        fields = [field.strip() for field in line.split(" | ")]
        if len(fields) != 4 or not fields[2].isdigit() or not fields[3]:
            raise SystemExit(f"{EXCLUSIONS.relative_to(ROOT)}:{number}: expected path | source line | count | reason")
        self.number, self.path, self.text, self.count, self.reason = number, fields[0], fields[1], int(fields[2]), fields[3]
        self.is_used, self.matches = False, 0


class Library:
    """Counts of one library, and the places of its open branches."""

    def __init__(self):
        self.branches = self.taken = self.lines = self.run = 0
        self.open = []

    def add_line(self, where, line, exclusion):
        if not line.get("gcovr/noncode"):
            self.lines += 1
            self.run += line["count"] > 0
        counts = [branch["count"] for branch in line.get("branches", [])]
        missing = counts.count(0)
        if exclusion is not None and missing > 0:
            exclusion.is_used = missing == exclusion.count
            counts = counts[: len(counts) - min(missing, exclusion.count)] if exclusion.is_used else counts
            missing = 0 if exclusion.is_used else missing
        self.branches += len(counts)
        self.taken += len(counts) - missing
        if missing:
            self.open.append((where, missing))

    def figures(self):
        """Branch and line coverage [percent], rounded down, so that 100.0 means that no branch is open."""
        return (percent(self.taken, self.branches), percent(self.run, self.lines))


def percent(part, whole):
    return 100.0 if part == whole else (1000 * part // whole) / 10


def library_of(path, names):
    """Name of the library of a file: the row of coverage.txt that contains it, or its directory."""
    directory = path.rpartition("/")[0]
    return next((name for name in names if f"{directory}/".startswith(f"{name}/")), directory)


def measure(report, sources, exclusions, names=()):
    """Libraries by name from a report of gcovr; `sources` returns the lines of a file."""
    libraries = {}
    for file in report["files"]:
        path = file["file"]
        library = libraries.setdefault(library_of(path, names), Library())
        rows = [row for row in exclusions if row.path == path]
        texts = sources(path)
        for row in rows:
            row.matches = sum(text.strip() == row.text for text in texts)
        for line in file["lines"]:
            number = line["line_number"]
            text = texts[number - 1].strip() if number <= len(texts) else ""
            row = next((row for row in rows if row.text == text), None)
            library.add_line(f"{path}:{number}", line, row)
    return libraries


def read_rows(path):
    return [(number, line) for number, line in enumerate(path.read_text().splitlines(), 1)
            if line.strip() and not line.startswith("#")]


def read_marks(path):
    """{library: [branch mark, line mark, is complete]}"""
    marks = {}
    for _, line in read_rows(path):
        name, branch, lines, *rest = line.split()
        marks[name] = [float(branch), float(lines), "complete" in rest]
    return marks


def compare(libraries, marks):
    """Findings, as texts."""
    for name in sorted(set(libraries) - set(marks)):
        yield f"test/lint/coverage.txt: {name} has no marks, expected a row; make coverage UPDATE=1 adds it"
    for name, (branch, line, is_complete) in sorted(marks.items()):
        if name not in libraries:
            yield f"test/lint/coverage.txt: no tests ran for {name}"
            continue
        found = libraries[name].figures()
        for what, now, mark in (("branches", found[0], branch), ("lines", found[1], line)):
            if now < mark:
                yield f"test/lint/coverage.txt: {name}: {now:.1f} % of the {what}, the mark is {mark:.1f} %"
        if is_complete:
            yield from (f"{where}: {missing} branches are never taken" for where, missing in libraries[name].open)


def write_marks(path, libraries, marks):
    # Marks are whole numbers, half a percent below what was measured, because races in stress tests decide whether
    # some branches are taken.
    head = [line for line in path.read_text().splitlines() if line.startswith("#")] if path.exists() else []
    rows = []
    for name, library in sorted(libraries.items()):
        branch, line = (100 if figure == 100.0 else max(0, int(figure - 0.5)) for figure in library.figures())
        old = marks.get(name, [0.0, 0.0, False])
        rows.append(f"{name:<28} {max(branch, int(old[0])):3} {max(line, int(old[1])):3}{'  complete' if old[2] else ''}")
    path.write_text("\n".join([*head, "", *rows]) + "\n")


def print_table(libraries, marks):
    print(f"{'library':<28} {'branches':>15} {'':>6} {'lines':>13}")
    for name, library in sorted(libraries.items()):
        branch, line = library.figures()
        print(f"{name:<28} {library.taken:>7}/{library.branches:<7} {branch:>5.1f}% {library.run:>6}/{library.lines:<6} "
              f"{line:>5.1f}%{'  complete' if marks.get(name, [0, 0, False])[2] else ''}")


def report_of_gcovr(jobs):
    run = subprocess.run([*GCOVR, "-j", str(jobs), "--json", str(REPORT), "--html-details", "build/coverage/index.html",
                          "build/coverage/obj"], cwd=ROOT, capture_output=True, text=True)
    if run.returncode != 0:
        raise SystemExit(f"gcovr ended with code {run.returncode}\n{run.stderr}")
    return json.loads(REPORT.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--update", action="store_true", help="raise the marks to what was measured")
    parser.add_argument("--no-marks", action="store_true", help="part of the tests ran: print, compare nothing")
    parser.add_argument("--open", default="", help="print open branches of the libraries that match this pattern")
    arguments = parser.parse_args()
    exclusions = [Exclusion(*row) for row in read_rows(EXCLUSIONS)]
    marks = read_marks(MARKS) if MARKS.exists() else {}
    libraries = measure(report_of_gcovr(arguments.jobs), lambda path: (ROOT / path).read_text().splitlines(), exclusions, marks)
    if arguments.update:
        write_marks(MARKS, libraries, marks)
        marks = read_marks(MARKS)
    print_table(libraries, marks)
    for name, library in sorted(libraries.items()):
        if arguments.open and fnmatch.fnmatch(name, arguments.open):
            print("".join(f"open: {where}: {missing}\n" for where, missing in library.open), end="")
    if arguments.no_marks:
        return 0
    failures = [f"{EXCLUSIONS.relative_to(ROOT)}:{row.number}: matches no source line on which exactly "
                f"{row.count} branches are never taken"
                for row in exclusions if not row.is_used]
    failures += [f"{EXCLUSIONS.relative_to(ROOT)}:{row.number}: matches {row.matches} source lines, expected one"
                 for row in exclusions if row.matches > 1]
    failures += compare(libraries, marks)
    print("\n".join(failures) if failures else "check: coverage is not below its marks")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
