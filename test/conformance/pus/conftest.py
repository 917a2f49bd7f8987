# SPDX-License-Identifier: Apache-2.0
"""One flight for all tests of the packet services; their results are collected for docs/pus-coverage.md."""

import json
import pathlib
import shutil
import signal
import sys
import tempfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(pathlib.Path(__file__).parent), str(ROOT / "test" / "mission"), str(ROOT / "test" / "support")]

import station as stations

NOTES = ROOT / "build" / "pus_coverage.json"


@pytest.fixture(scope="session")
def notes():
    """Messages of the packet services that tests have used successfully; written when the session ends."""
    found = stations.Notes()
    yield found
    content = {
        kind: {f"{service},{subtype}": sorted(tests) for (service, subtype), tests in sorted(table.items())}
        for kind, table in (("requests", found.requests), ("reports", found.reports))
    }
    content["hostile"] = {f"{service},{subtype}": count for (service, subtype), count in sorted(found.hostile.items())}
    NOTES.parent.mkdir(exist_ok=True)
    NOTES.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


@pytest.fixture(scope="package")
def flight():
    """A mission that flies as fast as it can until the tests of this directory have ended."""
    place = ROOT / "build" / "test"
    place.mkdir(parents=True, exist_ok=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="pus-", dir=place))
    flight = stations.launch(directory)
    yield flight
    assert flight.process.poll() is None, f"the flight ended by itself\n{flight.transcript()}"
    flight.process.send_signal(signal.SIGINT)
    flight.wait()
    shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture(scope="package")
def station(flight, notes):
    """The ground station of the flight."""
    ground = stations.Station(flight, notes)
    yield ground
    ground.close()
