# SPDX-License-Identifier: Apache-2.0
"""Tests marked `long` run only with LONG=1 in the environment (`make check-full`). Of several workers each has a processor of its
own, and what it starts stays there: none slows another one down. The tests of a file share flights and go to one worker."""

import os
import signal

import pytest

ONE_FLIGHT = "test/conformance/pus/"  # All files of this folder share one, and go to one worker together.


def pytest_configure(config):
    config.addinivalue_line("markers", "long: takes minutes; run with LONG=1")
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # Shells do so for commands in the background.
        signal.signal(signal.SIGINT, signal.default_int_handler)
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker:
        ours = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {ours[int(worker.removeprefix("gw")) % len(ours)]})


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
        """By file, but for that folder."""

        def _split_scope(self, nodeid):
            return ONE_FLIGHT if nodeid.startswith(ONE_FLIGHT) else nodeid.split("::")[0]

    return Scheduling(config, log)
