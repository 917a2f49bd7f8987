# SPDX-License-Identifier: Apache-2.0
"""The table of coverage in the documents contains what this session has seen. This is the last file of the
directory, because it uses the results of all others."""

import os
import pathlib
import re

import coverage as table
import pytest

PAGE = pathlib.Path(__file__).resolve().parents[3] / "docs" / "pus-coverage.md"
LONG = re.compile(r"^pytestmark = .*\bmark\.long\b", re.MULTILINE)  # Whole files marked `long`.
FILES = pathlib.Path(__file__).parent.glob("test_*.py")
MODULES = {path.name for path in FILES if not LONG.search(path.read_text(encoding="utf-8"))}


def test_table_of_coverage_is_true(request, station, notes):
    flown = {item.path.name for item in request.session.items}
    if not MODULES <= flown:
        pytest.fail("only part of the conformance suite was run; the table needs all of it: make pus-coverage")
    page = table.render(station.catalogue, notes)
    if os.environ.get("UPDATE_COVERAGE"):
        PAGE.write_text(page, encoding="utf-8")
    assert PAGE.exists() and PAGE.read_text(encoding="utf-8") == page, "docs/pus-coverage.md is out of date: make pus-coverage"
