# SPDX-License-Identifier: Apache-2.0
"""The Python example of gse/README.md, run as by a user: a separate program beside a flight that is paced by
the wall clock."""

import re
import signal
import subprocess
import sys

import flying
import pytest
from hirosco_gse import decode
from hirosco_gse.dictionary import Dictionary
from hirosco_gse.run_directory import default_dictionary

README = flying.ROOT / "gse" / "README.md"
# The example uses the flight in runs/latest, which belongs to the user of this tree; the prelude selects
# another directory.
PRELUDE = "import pathlib, sys\nfrom hirosco_gse import run_directory\nrun_directory.LATEST = pathlib.Path(sys.argv[1])\n"


def example():
    section = README.read_text(encoding="utf-8").partition("## Scripts and tests in Python\n")[2]
    return re.search(r"```python\n(.*?)```", section, re.DOTALL)[1]


@pytest.fixture
def flight(session_directory):
    flight = flying.start(session_directory / "client", "--scenario", "none", "--duration", 1_000_000, "--time", "real")
    flight.port()
    yield flight
    flight.abandon()


def test_the_example_of_the_readme_commands_a_flight(flight):
    text = PRELUDE + example()
    done = subprocess.run([sys.executable, "-c", text, flight.directory], cwd=flying.ROOT, capture_output=True, text=True, timeout=flying.FLIGHT_LIMIT_S)
    assert done.returncode == 0, done.stderr + flight.console
    flight.process.send_signal(signal.SIGINT)
    flight.wait()
    dictionary = Dictionary.load(default_dictionary(flight.directory))
    reports = [row["text"] for row in decode.rows([str(flight.directory / "packets.log")], dictionary, flying.ROOT, 0)]
    wanted = ["SAFE_OPERATIONAL -> OPERATIONAL", "MOVE_TO POSITION=[0.9, -1.3] rad  DURATION=2 s", "DEVICE_LOST"]
    places = [next((number for number, text in enumerate(reports) if words in text), None) for words in wanted]
    assert None not in places and places == sorted(places), (wanted, places)
