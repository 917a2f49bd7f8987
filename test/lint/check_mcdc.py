# SPDX-License-Identifier: Apache-2.0
"""MC/DC of the sources in mcdc.txt by their unit tests: `make mcdc`.

A condition acts alone if the tests show that it changes the result of its decision while the others stay. mcdc.txt has
a line for each source, and one for each condition of it that no test can show to act alone, with the reason. Runs the
tests, which were linked with these sources compiled by clang 19, merges their profiles, and compares: each condition of
each decision with two conditions or more must act alone, except those in the list; an entry of the list that matches
nothing is a finding. FSW_ASSERT does not count: only coding errors make it fail. Prints a table and findings; exit
code 1."""

import argparse
import concurrent.futures
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIST = ROOT / "test/lint/mcdc.txt"
OUT = ROOT / "build/mcdc"
PROFILES = OUT / "profiles"


class Exclusion:
    """One row: path | text of the source line of the decision | number of the condition in it | reason."""

    def __init__(self, number, fields):
        if len(fields) != 4 or not fields[2].isdigit() or not fields[3]:
            raise SystemExit(f"{LIST.relative_to(ROOT)}:{number}: expected path | source line | condition | reason")
        self.number, self.path, self.text, self.condition = number, fields[0], fields[1], int(fields[2])
        self.is_used = False


def read_list(lines):
    """Paths and exclusions."""
    rows = [(number, [field.strip() for field in line.split(" | ")])
            for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    return ([fields[0] for _, fields in rows if len(fields) == 1],
            [Exclusion(number, fields) for number, fields in rows if len(fields) > 1])


def run_test(test):
    """Run one test; its output if it failed."""
    name = test.removesuffix(".c")
    environment = {**os.environ, "LLVM_PROFILE_FILE": f"{PROFILES}/{name.replace('/', '_')}.%p.profraw"}
    done = subprocess.run([str(OUT / name)], cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else f"{test}: failed\n{done.stdout[-2000:]}{done.stderr[-2000:]}"


def export(tests):
    """Coverage of all tests as llvm-cov exports it."""
    raw = sorted(str(path) for path in PROFILES.glob("*.profraw"))
    merged = PROFILES / "all.profdata"
    (PROFILES / "list").write_text("\n".join(raw) + "\n")
    subprocess.run(["llvm-profdata-19", "merge", "--sparse", f"--input-files={PROFILES / 'list'}", "-o", str(merged)], check=True)
    programs = [str(OUT / test.removesuffix(".c")) for test in tests]
    objects = [part for program in programs[1:] for part in ("--object", program)]
    done = subprocess.run(["llvm-cov-19", "export", "--format=text", f"--instr-profile={merged}", programs[0], *objects],
                          cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)["data"][0]["files"]


def decisions_of(file):
    """{(line, column): [condition acted alone]}: a decision of which any copy shows a condition counts once."""
    found = {}
    for record in file.get("mcdc_records", []):
        place, shown = (record[0], record[1]), record[-1]
        old = found.get(place, [False] * len(shown))
        found[place] = [one or other for one, other in zip(old, shown)]
    return found


def compare(path, decisions, lines, exclusions):
    """(number of conditions that are shown, number of conditions, findings) of one source."""
    shown = total = 0
    findings = []
    for (line, _), conditions in sorted(decisions.items()):
        text = lines[line - 1].strip()
        if text.startswith("FSW_ASSERT("):
            continue
        for index, is_shown in enumerate(conditions, 1):
            row = next((row for row in exclusions if (row.path, row.text, row.condition) == (path, text, index)), None)
            if row is not None and not is_shown:
                row.is_used = True
                continue
            total += 1
            shown += is_shown
            if not is_shown:
                findings.append(f"{path}:{line}: no test shows that condition {index} of {len(conditions)} acts alone: {text}")
    return shown, total, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("tests", nargs="+")
    arguments = parser.parse_args()
    paths, exclusions = read_list(LIST.read_text().splitlines())
    shutil.rmtree(PROFILES, ignore_errors=True)
    PROFILES.mkdir(parents=True)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        failures = [text for text in pool.map(run_test, arguments.tests) if text]
    if failures:
        print("\n".join(failures))
        return 1
    try:
        exported = export(arguments.tests)
    except subprocess.CalledProcessError as failure:
        raise SystemExit(f"{failure.cmd[0]} ended with exit code {failure.returncode}: {failure.stderr or 'see above'}") from None
    files = {str(pathlib.Path(file["filename"]).relative_to(ROOT)) if file["filename"].startswith("/") else file["filename"]: file
             for file in exported}
    print(f"{'source':<48} {'conditions':>12} {'excluded':>9}")
    for path in paths:
        if path not in files:
            failures.append(f"{LIST.relative_to(ROOT)}: no test ran {path}")
            continue
        shown, total, findings = compare(path, decisions_of(files[path]), (ROOT / path).read_text().splitlines(), exclusions)
        if total == 0:
            failures.append(f"{LIST.relative_to(ROOT)}: of {path} no decision was recorded, expected at least one with two conditions")
        excluded = sum(row.is_used for row in exclusions if row.path == path)
        print(f"{path:<48} {shown:>5} of {total:<4} {excluded:>8}")
        failures += findings
    failures += [f"{LIST.relative_to(ROOT)}:{row.number}: matches no condition that no test shows" for row in exclusions if not row.is_used]
    print("\n".join(failures) if failures else "check: each condition is shown to act alone (MC/DC)")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
