# SPDX-License-Identifier: Apache-2.0
"""Files that the generator replaces, and names that a dissector refuses."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "generator"))

import dissector
import generate
from source import DescriptorError


def test_a_file_of_other_octets_is_replaced(tmp_path):
    """The earlier file may be damaged: it need not be UTF-8."""
    path = tmp_path / "made" / "names.h"
    generate.write(path, "first \u00b0C\n")
    path.write_bytes(b"\xff\xfe")
    generate.write(path, "second\n")
    assert path.read_text(encoding="utf-8") == "second\n" and list(path.parent.iterdir()) == [path]


def test_a_file_with_the_same_text_stays(tmp_path):
    """A newer time of the file would make all that depends on it again."""
    path = tmp_path / "names.h"
    generate.write(path, "text \u00b0C\n")
    before = path.stat()
    generate.write(path, "text \u00b0C\n")
    assert (path.stat().st_ino, path.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_field_of_the_dissector_has_one_type():
    tables = dissector._Tables.__new__(dissector._Tables)
    tables.fields = {}
    tables._register("st05.event_id", "UINT16", "event_id")
    tables._register("st05.event_id", "UINT16", "event_id")
    assert tables.fields == {"st05.event_id": ("UINT16", "event id", None)}
    with pytest.raises(DescriptorError, match=r"st05\.event_id is UINT16 in one message and UINT8 in another: expected one type"):
        tables._register("st05.event_id", "UINT8", "event_id")
