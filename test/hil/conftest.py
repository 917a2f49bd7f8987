# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the hardware-in-the-loop tests: the place where they run is chosen once, and named at the end."""

import pathlib
import shutil
import sys
import tempfile
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import place as places

KEPT_S = 3600.0
CHOSEN = pytest.StashKey()


@pytest.fixture(scope="session")
def hil_directory(request):
    """Directory for the results of this session; removed when all tests have passed, otherwise by a session an
    hour later."""
    parent = places.ROOT / "build" / "test"
    parent.mkdir(parents=True, exist_ok=True)
    for old in parent.glob("hil-*"):
        if old.stat().st_mtime < time.time() - KEPT_S:
            shutil.rmtree(old, ignore_errors=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="hil-", dir=parent))
    yield directory
    if request.session.testsfailed == 0:
        shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture(scope="session")
def place(request, hil_directory):
    """The place where commands with buses run: place.run(command) or place.group(name, command)."""
    chosen = places.choose(hil_directory)
    request.config.stash[CHOSEN] = f"{chosen.name} ({chosen.why})"
    return chosen


def pytest_sessionfinish(session):
    """A worker passes the place to the process that writes the summary."""
    chosen = session.config.stash.get(CHOSEN, None)
    if chosen and hasattr(session.config, "workeroutput"):
        session.config.workeroutput["place"] = chosen


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    place = getattr(node, "workeroutput", {}).get("place")
    if place:
        node.config.stash[CHOSEN] = place


def pytest_terminal_summary(terminalreporter, config):
    chosen = config.stash.get(CHOSEN, None)
    if chosen:
        terminalreporter.write_line(f"hardware-in-the-loop tests ran in this place: {chosen}", bold=True)
