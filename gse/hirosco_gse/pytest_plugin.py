# SPDX-License-Identifier: Apache-2.0
"""Fixture `spacecraft` for pytest: the client of spacecraft.py, connected to a flight.

    pytest -p hirosco_gse.pytest_plugin --spacecraft-run runs/latest

    def test_the_arm_refuses_to_move_while_it_is_off(spacecraft):
        with pytest.raises(Rejected, match="PRE_OPERATIONAL"):
            spacecraft.cmd("MANIPULATOR.MOVE_TO", position=[0, 0], duration=1)

The tests of a module share one connection. A module that starts its own flight redefines the fixture `spacecraft_run`,
which returns the run directory; a conftest.py may import both fixtures instead of loading the plug-in.
"""

import pytest

from .run_directory import LATEST
from .spacecraft import Spacecraft

CONNECT_TIMEOUT_S = 10.0  # a test may be started together with the mission


def pytest_addoption(parser):
    parser.addoption("--spacecraft-run", metavar="DIRECTORY", help="run directory of the flight for the fixture spacecraft (default runs/latest)")


@pytest.fixture(scope="module")
def spacecraft_run(pytestconfig):
    """Run directory of the flight."""
    return pytestconfig.getoption("--spacecraft-run", default=None) or LATEST


@pytest.fixture(scope="module")
def spacecraft(spacecraft_run):
    """A connected Spacecraft."""
    with Spacecraft(spacecraft_run).connect(CONNECT_TIMEOUT_S) as craft:
        yield craft
