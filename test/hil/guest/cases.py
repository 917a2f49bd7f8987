# SPDX-License-Identifier: Apache-2.0
"""Runs the cases of a guest program: one process for all, because imports are slow in an emulated machine.

A guest program defines functions `case_...()` that raise an exception on failure, and ends with
`cases.run(globals())`. The outcome of each case is written as a line of $OUT/results.jsonl at once; a case
that hangs fails after its time."""

import json
import os
import pathlib
import signal
import sys
import time
import traceback

SECONDS = 900  # Ends a wait that would otherwise never end. Long, because an emulated machine on a busy host is slow.


def on_alarm(number, frame):
    raise TimeoutError("the case did not end within its time")


def run(names, seconds=SECONDS):
    """Run all cases in the order of their definition; exit code 1 if one has failed."""
    functions = {name.removeprefix("case_"): value for name, value in names.items() if name.startswith("case_")}
    failed = 0
    signal.signal(signal.SIGALRM, on_alarm)
    with open(pathlib.Path(os.environ["OUT"]) / "results.jsonl", "w") as results:
        for name, function in functions.items():
            signal.alarm(seconds)
            began = time.monotonic()
            try:
                function()
                passed, message = True, ""
            except Exception:
                passed, message = False, traceback.format_exc()
            signal.alarm(0)
            failed += not passed
            print(json.dumps({"case": name, "passed": passed, "message": message}), file=results, flush=True)
            print(f"{name}: {'passed' if passed else 'FAILED'}  {time.monotonic() - began:.1f} s", flush=True)
    sys.exit(1 if failed or not functions else 0)
