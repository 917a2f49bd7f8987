# SPDX-License-Identifier: Apache-2.0
"""Check the flight software with cppcheck and its MISRA C:2012 add-on against the deviations of docs/misra.md.

A finding is accepted when a deviation of its rule covers its file; nothing is suppressed elsewhere. By default it
checks only sources that differ from the main branch (on the main branch: from twenty commits ago), without the code of
test builds. For a changed header it checks one source that includes it. If these are more than MOST, it checks those
that changed last. --all checks the whole flight software at once, with the rules that need all of it, and reports
unused deviations. Prints each finding; exit code 1. Rule texts are not in the project, so a finding shows the rule's
number only."""

import argparse
import fnmatch
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / "docs/misra.md"
FLIGHT = ("base/", "osal/", "pus/", "fsw/", "launcher/", "build/generated/")
ROW = re.compile(r"^\| (?P<id>(?:D-[\d.]+|F-[\w.-]+)) \| (?P<scope>[^|]+) \|")
FINDING = re.compile(r"^(?P<file>[^:]+):(?P<line>\d+): (?P<id>\S+)")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
MOST = 40  # Sources; more take more than a minute.
# Rules that cppcheck decides over all sources together; on a part of the sources it would give wrong answers.
WHOLE_PROGRAM = {f"misra-c2012-{rule}" for rule in "2.3 2.4 2.5 5.6 5.7 5.8 5.9 8.5 8.6 8.7".split()}
CPPCHECK = ["cppcheck", "--quiet", "--std=c99", "--addon=misra", "--enable=warning,portability,performance",
            "--suppress=missingIncludeSystem", "--suppress=unusedFunction", "--inline-suppr", "-I.", "-Ibuild",
            "--template={file}:{line}: {id} {message}"]


def read_deviations(text):
    """(number of the line, id as cppcheck names it, list of file patterns, whether it is found by hand) of each row of the two tables."""
    deviations = []
    for number, line in enumerate(text.splitlines(), 1):
        row = ROW.match(line)
        if row:
            name = row["id"].replace("D-", "misra-c2012-") if row["id"].startswith("D-") else row["id"][2:]
            scope = row["scope"].strip()
            patterns = ["*"] if scope == "everywhere" else re.findall(r"`([^`]+)`", scope)
            deviations.append((number, name, patterns, "by hand" in scope))
    return deviations


def covers(pattern, path):
    return pattern == "*" or fnmatch.fnmatchcase(path, pattern) or path.startswith(pattern.rstrip("/") + "/")


def judge(findings, deviations, is_whole=True):
    """(findings that no deviation covers, numbers of the lines of deviations that covered none)."""
    open_findings, used = [], set()
    for text in findings:
        finding = FINDING.match(text)
        if not finding or not finding["file"].startswith(FLIGHT):
            continue
        if not is_whole and finding["id"] in WHOLE_PROGRAM:
            continue
        rows = [row for row, name, patterns, _ in deviations
                if name == finding["id"] and any(covers(pattern, finding["file"]) for pattern in patterns)]
        used.update(rows)
        if not rows:
            open_findings.append(text)
    unused = [row for row, _, _, by_hand in deviations if row not in used and not by_hand]
    return open_findings, unused


def git_lines(*arguments):
    run = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return run.stdout.splitlines() if run.returncode == 0 else None


def changed_files():
    """Paths that differ from the main branch, or on the main branch from twenty commits ago, those that changed last
    first; None if this is unknown."""
    head = git_lines("rev-parse", "HEAD")
    for branch in ("origin/main", "main"):
        base = git_lines("merge-base", "HEAD", branch)
        if base and base != head:
            break
    else:
        base = git_lines("rev-parse", "--verify", "HEAD~20")
    if not base:
        return None
    uncommitted = git_lines("diff", "--name-only", "HEAD") + git_lines("ls-files", "--others", "--exclude-standard")
    committed = git_lines("log", "--format=", "--name-only", f"{base[0]}..HEAD")
    return list(dict.fromkeys(uncommitted + committed))


def affected(sources, changed, text_of=lambda path: (ROOT / path).read_text()):
    """The sources that have changed, in the order of `changed`, and after them for each changed header the source of the
    same name or a source that includes it."""
    chosen = dict.fromkeys(path for path in changed if path in sources)
    includes = {path: set(INCLUDE.findall(text_of(path))) for path in sources}
    for header in (path for path in sorted(changed) if path.endswith(".h")):
        users = [path for path in sources if header in includes[path]]
        own = header.removesuffix(".h") + ".c"
        if users and not chosen.keys() & set(users):
            chosen[own if own in users else users[0]] = None
    return list(chosen)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true", help="the whole flight software")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("sources", nargs="+", help="C sources of the flight software")
    arguments = parser.parse_args()
    changed = None if arguments.all else changed_files()
    due = arguments.sources if changed is None else affected(arguments.sources, changed)
    sources = due if changed is None else due[:MOST]
    findings = []
    if sources:
        # With --all and without it, cppcheck has different build directories, in which it stores its results for the whole program.
        memory = f"build/lint/cppcheck/{'all' if changed is None else 'changed'}"
        (ROOT / memory).mkdir(parents=True, exist_ok=True)
        command = [*CPPCHECK, f"--cppcheck-build-dir={memory}", f"-j{arguments.jobs}",
                   *([] if changed is None else ["--max-configs=1"]), *sources]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        lines = (line.split(" misra violation")[0] for line in run.stderr.splitlines())
        findings = list(dict.fromkeys(lines))
        if run.returncode != 0:
            findings.append(f"cppcheck ended with code {run.returncode}")
    failures, unused = judge(findings, read_deviations(TABLE.read_text()), changed is None)
    failures += [text for text in findings if text.startswith("cppcheck ended")]
    if changed is None:
        failures += [f"docs/misra.md:{row}: no finding needs this deviation" for row in unused]
    what = "all" if changed is None else "changed"
    rest = f"; {len(due) - MOST} more, which changed earlier: make check-misra-all" if len(due) > len(sources) else ""
    print("\n".join(failures) if failures
          else f"check: MISRA kept but for numbered deviations in {len(sources)} {what} sources{rest}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
