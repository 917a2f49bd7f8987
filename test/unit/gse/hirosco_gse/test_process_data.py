# SPDX-License-Identifier: Apache-2.0
"""Positions of objects in process data, and units, from data sheets."""

import math
import pathlib

import pytest
from generator import sheet
from hirosco_gse import process_data

SHEETS = pathlib.Path(__file__).resolve().parents[4] / "descriptors" / "devices"
DRIVE = """[6041]
ParameterName=Statusword
DataType=6
[6064]
ParameterName=Position
DataType=4
[1800sub1]
DataType=7
DefaultValue=$NODEID+0x40000180
[1A00sub0]
DataType=5
DefaultValue=3
[1A00sub1]
DataType=7
DefaultValue=0x60410010
[1A00sub2]
DataType=7
DefaultValue=0x00050008
[1A00sub3]
DataType=7
DefaultValue=0x60640020
"""


@pytest.fixture
def load(tmp_path):
    """A function that reads a data sheet with this text."""
    def loaded(text):
        (tmp_path / "drive.eds").write_text(text, encoding="utf-8")
        return sheet.load(tmp_path / "drive.eds")
    return loaded


def test_padding_shifts_positions_and_signs_are_those_of_the_objects(load):
    assert process_data.layout(load(DRIVE), 0x6064, 0x6041) == (0x180, 7, [(3, "i4"), (0, "u2")])


class _Dictionary:
    """Two configurations: a device with UDP, and a drive on CAN that maps only the position."""

    content = {"subsystems": [{"configurations": [
        {"devices": [{"endnodes": [{"type": "UDP", "address": "127.0.0.1"}], "settings": [{"object": "0x1A00:00", "value": "7"}]}]},
        {"devices": [{"endnodes": [{"bus": "robot", "node": "0x11"}],
                      "settings": [{"object": "0x1800:01", "value": "0x80000191"}, {"object": "0x1A00:00", "value": "0"},
                                   {"object": "0x1A00:01", "value": "0x60640020"}, {"object": "0x1A00:00", "value": "1"}]}]}]}]}


def test_settings_of_a_descriptor_change_the_mapping_of_the_sheet(load):
    mapping = process_data.mapping_of(_Dictionary, "robot", 0x11)
    assert mapping == {(0x1A00, 0): 1, (0x1A00, 1): 0x60640020}
    assert process_data.layout(load(DRIVE), 0x6064, mapping=mapping) == (0x180, 4, [(0, "i4")])
    assert process_data.layout(load(DRIVE), 0x6041, mapping=mapping) is None
    assert process_data.mapping_of(_Dictionary, "robot", 0x12) == process_data.mapping_of(None, "robot", 0x11) == {}


def test_no_process_data_contain_all_of_the_objects(load):
    assert process_data.layout(load(DRIVE), 0x6064, 0x6077) is None


def test_units_of_a_drive_with_increments_count_the_gear():
    counts = process_data.unit(sheet.load(SHEETS / "servo-drive.eds"), "position")
    values = sheet.load(SHEETS / "servo-drive.eds").defaults(0)
    assert values.get((0x60A8, 0), 0) == 0
    turns = values[0x608F, 2] / values[0x608F, 1] * values[0x6091, 2] / values[0x6091, 1]
    assert counts == pytest.approx(2.0 * math.pi * turns)


@pytest.mark.parametrize(("kind", "needed"), [("position", "0x60A8, or 0x608F and 0x6091"), ("torque", "a rated torque in 0x6076")])
def test_a_sheet_without_a_unit_is_refused_with_its_file(load, kind, needed):
    with pytest.raises(sheet.SheetError, match=rf"drive.eds: no unit of {kind}s: expected {needed}"):
        process_data.unit(load(DRIVE), kind)


@pytest.mark.parametrize("text, line", [("6041]\n", 1), ("[6041]\nDataType=none\n", 2), ("[6041]\n[6041]\n", 2)])
def test_a_file_that_is_no_sheet_is_refused_with_its_line(load, text, line):
    with pytest.raises(sheet.SheetError, match=rf"drive.eds:{line}: "):
        load(text)
