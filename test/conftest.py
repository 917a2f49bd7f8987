# SPDX-License-Identifier: Apache-2.0
"""Tests marked `long` run only with LONG=1 in the environment (`make check-full`)."""

import os


def pytest_configure(config):
    config.addinivalue_line("markers", "long: takes minutes; run with LONG=1")


def pytest_collection_modifyitems(config, items):
    if os.environ.get("LONG"):
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if not item.get_closest_marker("long")]
