# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the hardware-in-the-loop tests: the test environment is chosen once, and named at the end."""

import pathlib
import shutil
import sys
import tempfile
import time

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import environments

KEPT_S = 3600.0
CHOSEN = pytest.StashKey()


@pytest.fixture(scope="session")
def hil_directory(request):
    """Directory for the results of this session; removed when all tests have passed, otherwise by a session an
    hour later."""
    parent = environments.ROOT / "build" / "test"
    parent.mkdir(parents=True, exist_ok=True)
    for old in parent.glob("hil-*"):
        if old.stat().st_mtime < time.time() - KEPT_S:
            shutil.rmtree(old, ignore_errors=True)
    directory = pathlib.Path(tempfile.mkdtemp(prefix="hil-", dir=parent))
    yield directory
    if request.session.testsfailed == 0:
        shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture(scope="session")
def environment(request, hil_directory):
    """The test environment of commands with buses: environment.run(command) or environment.group(name, command)."""
    chosen = environments.choose(hil_directory)
    request.config.stash[CHOSEN] = f"{chosen.name} ({chosen.why})"
    return chosen


def pytest_sessionfinish(session):
    """A worker passes the test environment to the process that writes the summary."""
    chosen = session.config.stash.get(CHOSEN, None)
    if chosen and hasattr(session.config, "workeroutput"):
        session.config.workeroutput["environment"] = chosen


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    environment = getattr(node, "workeroutput", {}).get("environment")
    if environment:
        node.config.stash[CHOSEN] = environment


def pytest_terminal_summary(terminalreporter, config):
    chosen = config.stash.get(CHOSEN, None)
    if chosen:
        terminalreporter.write_line(f"test environment of the hardware-in-the-loop tests: {chosen}", bold=True)
