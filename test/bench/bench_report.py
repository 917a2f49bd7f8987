# SPDX-License-Identifier: Apache-2.0
"""The report of a flight of the scenario telepresence: the time to make it, including the start of Python,
and its size.

The baselines are the required limits: 3 s and 1.2 MB."""

import json
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

import failures

ROUNDS = 5
DIRECTORY = pathlib.Path("runs") / "bench-report"
FLIGHT = ("build/bin/hirosco", "run", "--scenario", "telepresence", "--form", "image", "--report", "no", "--out", str(DIRECTORY))
REPORT = ("/usr/bin/env", "PYTHONPATH=gse", sys.executable, "-m", "hirosco_gse.report", str(DIRECTORY))


def main():
    """Fly once, make the report in rounds and print the BENCH lines."""
    shutil.rmtree(DIRECTORY, ignore_errors=True)
    subprocess.run(FLIGHT, stdout=subprocess.DEVNULL, check=True)
    taken = []
    for _ in range(ROUNDS):
        start = time.monotonic()
        subprocess.run(REPORT, stdout=subprocess.DEVNULL, check=True)
        taken.append(time.monotonic() - start)
    octets = json.loads((DIRECTORY / "run.json").read_text(encoding="utf-8"))["report"]["octets"]
    shutil.rmtree(DIRECTORY)
    print(f"BENCH report_made {statistics.median(taken):.2f} s 3.0")
    print(f"BENCH report_size {octets / 1e6:.3f} MB 1.2")


if __name__ == "__main__":
    failures.run(main)
