# SPDX-License-Identifier: Apache-2.0
"""Tests marked `long` run only with LONG=1 in the environment (`make check-full`). If there are several
workers, each has a processor, to which the processes that it starts are also bound: processes of a stepped flight run in
turn, and are faster on one processor. Browsers, and the flights in wall-clock time that they show, use any processor. The
tests of a file share flights and run in one worker."""

import os
import signal

import pytest

# The files of a group share flights and run in one worker: those of a directory, and those that use the fixture shared_flights.
GROUPS = {
    "pus": ["test/conformance/pus/"],
    "telepresence": [f"test/mission/test_mission_{name}.py" for name in
                     ("artefacts", "bus", "packets", "sanitized", "station_replay", "telepresence", "third_party_ground", "udp_links")],
}
# Tests with a browser.
BROWSING = "test/mission/test_mission_station"
ALL_PROCESSORS = os.sched_getaffinity(0)


def pytest_configure(config):
    config.addinivalue_line("markers", "long: takes minutes; run with LONG=1")
    # Shells ignore the signal for commands in the background.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    config.processors = ALL_PROCESSORS
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker:
        ours = sorted(ALL_PROCESSORS)
        config.processors = {ours[int(worker.removeprefix("gw")) % len(ours)]}


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    os.sched_setaffinity(0, ALL_PROCESSORS if item.nodeid.startswith(BROWSING) else item.config.processors)


def pytest_collection_modifyitems(config, items):
    if os.environ.get("LONG"):
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if not item.get_closest_marker("long")]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        """Distribute tests by file, except for the groups."""

        def _split_scope(self, nodeid):
            file = nodeid.split("::")[0]
            return next((group for group, places in GROUPS.items() if file.startswith(tuple(places))), file)

    return Scheduling(config, log)
