# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/misra.md as check_misra.py reads them."""

import re

import check_misra

TEXT = check_misra.TABLE.read_text(encoding="utf-8")


def test_each_row_of_the_tables_is_read_with_its_paths():
    rows = [number for number, line in enumerate(TEXT.splitlines(), 1) if re.match(r"\|\s*[DF]-", line)]
    read = check_misra.read_deviations(TEXT)
    assert len(rows) > 50 and [number for number, _, _, _ in read] == rows
    assert [number for number, _, patterns, _ in read if not patterns] == [], "a scope is `everywhere` or paths in backticks"
