# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests that fly. Flights are shared: each (form, seed, ...) flies once in a session."""

import pathlib
import shutil
import sys
import tempfile
import time
import zlib

import pytest

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1] / "support")]

import flying
from hirosco_gse import figures
from hirosco_gse import run as runs

KEPT_S = 3600.0
KEPT_RUNS = 2  # Kept in memory: one run has hundreds of megabytes.


@pytest.fixture(scope="session")
def session_directory(request):
    """Directory for the runs of this session; removed when all tests have passed, otherwise by a session an hour
    later."""
    place = flying.ROOT / "build" / "test"
    place.mkdir(parents=True, exist_ok=True)
    for old in place.glob("mission-*"):
        if old.stat().st_mtime < time.time() - KEPT_S:
            shutil.rmtree(old, ignore_errors=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="mission-", dir=place))
    yield directory
    if request.session.testsfailed == 0:
        shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture
def directory(session_directory, request):
    """Directory for the run of one test; removed when the test has passed."""
    name = "".join(letter if letter.isalnum() else "-" for letter in request.node.name)
    # the length of a run's path is limited
    path = session_directory / f"{name[:40]}-{zlib.crc32(request.node.nodeid.encode()):08x}"
    failed = request.session.testsfailed
    yield path
    if request.session.testsfailed == failed:
        shutil.rmtree(path, ignore_errors=True)


class SharedFlights:
    """Telepresence flights by their options; each is flown when it is first requested."""

    def __init__(self, session_directory):
        self.session_directory = session_directory
        self.flights, self.runs, self.figures = {}, {}, {}

    def flight(self, form="processes", seed=1, again=0, links="shm", report="no"):
        """The finished flight."""
        key = (form, seed, again, links, report)
        if key not in self.flights:
            name = "-".join(map(str, key))
            options = ("--scenario", "telepresence", "--form", form, "--seed", seed, "--links", links)
            self.flights[key] = flying.fly(self.session_directory / name, *options, report=report)
        return self.flights[key]

    def run(self, **key):
        """The logs of a flight as arrays."""
        flight = self.flight(**key)
        if flight.directory not in self.runs:
            for oldest in list(self.runs)[: max(0, len(self.runs) - KEPT_RUNS + 1)]:
                del self.runs[oldest]
            self.runs[flight.directory] = runs.load(flight.directory)
        return self.runs[flight.directory]

    def computed(self, **key):
        """Figures from the raw logs, and the reason for each missing figure."""
        directory = self.flight(**key).directory
        if directory not in self.figures:
            self.figures[directory] = figures.compute(self.run(**key))
        return self.figures[directory]


@pytest.fixture(scope="session")
def shared_flights(session_directory):
    """All telepresence flights of the session."""
    return SharedFlights(session_directory)
