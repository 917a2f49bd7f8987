# SPDX-License-Identifier: Apache-2.0
"""The reader of data sheets: entries and their defaults, process data, units, emergencies, and what it refuses."""

import math
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "generator"))

import sheet

SMALL = """[Comments]
Lines=2
Line1=EMCY 0x2310 HIGH Current too high
Line2=Free text

[1000]
ParameterName=Device type
DataType=0x0007
DefaultValue=0x20192
AccessType=RO

[1018sub1]
DataType=7

[1800sub1]
ParameterName=COB-ID
DataType=0x0007
DefaultValue=$NODEID + 0x180
AccessType=rw
PDOMapping=1

[1a00]
ParameterName=No type

[2000]
DataType=9
DefaultValue=text
"""


def load(tmp_path, text):
    path = tmp_path / "device.eds"
    path.write_text(text, encoding="utf-8")
    return sheet.load(path)


COMPACT = "[1003]\nParameterName=errors\nObjectType=8\nDataType=0x16\nAccessType=ro\nCompactSubObj={}\nDefaultValue=5\n"


def test_members_that_compact_sub_obj_describes_are_entries(tmp_path):
    loaded = load(tmp_path, COMPACT.format(3) + "[1003Name]\nNrOfEntries=0\n")
    assert loaded.defaults(0) == {(0x1003, 0): 3, (0x1003, 1): 5, (0x1003, 2): 5, (0x1003, 3): 5}
    assert load(tmp_path, COMPACT.format(0)).entries == {}


@pytest.mark.parametrize(("text", "message"), [
    (COMPACT.format(255), "device.eds:6: [1003] CompactSubObj=255: expected a number of sub-objects from 0 to 254"),
    (COMPACT.format("x"), "device.eds:6: [1003] CompactSubObj=x: expected a number of sub-objects"),
    (COMPACT.format(3).replace("=5", "=0x1000000"), "device.eds:7: [1003] DefaultValue=0x1000000: expected an unsigned number of 24 bits"),
    (COMPACT.format(3) + "[1003Value]\n1=9\n", "device.eds:8: [1003Value]: expected the values of CompactSubObj as DefaultValue in a section for each sub-object"),
])
def test_wrong_members_of_compact_sub_obj_are_refused_with_their_line(tmp_path, text, message):
    with pytest.raises(sheet.SheetError) as refused:
        load(tmp_path, text)
    assert message in str(refused.value)


def test_entries_have_names_types_access_and_defaults(tmp_path):
    loaded = load(tmp_path, SMALL)
    assert sorted(loaded.entries) == [(0x1000, 0), (0x1018, 1), (0x1800, 1), (0x2000, 0)]
    entry = loaded.entries[0x1800, 1]
    assert (entry.name, entry.kind, entry.access, entry.is_mappable) == ("COB-ID", 7, "rw", True)
    assert loaded.entries[0x1018, 1].name == "1018sub1" and not loaded.entries[0x1000, 0].is_mappable
    assert loaded.defaults(0x11) == {(0x1000, 0): 0x20192, (0x1800, 1): 0x191}
    assert loaded.emergencies == ((0x2310, "HIGH", "Current too high"),)


@pytest.mark.parametrize("line", ["EMCY 0x0000 HIGH Zero", "EMCY 0x12345 HIGH Long", "EMCY 0x1000 LOUD Word", "EMCY 0x1000 HIGH", "EMCY 4096 LOW x"])
def test_a_wrong_emergency_is_refused(tmp_path, line):
    with pytest.raises(sheet.SheetError, match=r"device.eds:2: \[Comments\] line1=.*: expected EMCY, a code from 0x0001 to 0xFFFF"):
        load(tmp_path, f"[Comments]\nLine1={line}\n")


def test_a_code_is_described_once(tmp_path):
    with pytest.raises(sheet.SheetError, match="that no other line has"):
        load(tmp_path, "[Comments]\nLine1=EMCY 0x1000 LOW a\nLine2=EMCY 0x1000 LOW b\n")


@pytest.mark.parametrize("text, message", [
    ("[1000]\nDataType=seven\n", r":2: \[1000\] DataType=seven: expected a number"),
    ("[1000]\nDataType=7\n[1000]\nDataType=7\n", r":3: not a data sheet: \[1000\]: expected each section only once; the first is in line 1"),
    ("[1000]\nDataType=7\n; text\nDATATYPE=7\n", r":4: not a data sheet: DATATYPE=7: expected each key of \[1000\] only once"),
    ("DataType=7\n", r":1: not a data sheet: DataType=7: expected \[section\] or ; comment"),
    ("[1000]\n\nwords\n", r":3: not a data sheet: words: expected key=value, \[section\] or ; comment"),
    ("[1000]\nDataType=7\nDefaultValue=words\n", r":3: \[1000\] DefaultValue=words: expected an unsigned number of 32 bits, as DataType=7"),
    ("[1000]\nDataType=7\nDefaultValue=0x100000000\n", ":3: .* expected an unsigned number of 32 bits"),
    ("[1000]\nDataType=7\nDefaultValue=-1\n", ":3: .* expected an unsigned number of 32 bits"),
    ("[1000]\nDataType=2\nDefaultValue=128\n", ":3: .* expected a signed number of 8 bits"),
    ("[1000]\nDataType=2\nDefaultValue=0x100\n", ":3: .* expected a signed number of 8 bits"),
    ("[1000]\nDataType=1\nDefaultValue=2\n", ":3: .* expected an unsigned number of 1 bit, as"),
])
def test_a_file_that_is_not_a_data_sheet_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(sheet.SheetError, match="device.eds" + message):
        load(tmp_path, text)


def test_a_sheet_may_be_written_as_makers_write_it(tmp_path):
    """Latin-1, a byte order mark, names in capitals, comments with #, the node id last, octal numbers, CR LF, records with a data type."""
    text = (SMALL.replace("sub1", "SUB1").replace("[Comments]", "# a comment\n[COMMENTS]").replace("$NODEID + 0x180", "0X180+$NodeId")
            .replace("0x20192", "0400622").replace("[1a00]\n", "[1a00]\nObjectType=0x9\nDataType=0x21\n"))
    expected = load(tmp_path, SMALL)
    for octets in (text.encode("utf-8-sig"), text.replace("Free text", "Müller, 20 °C").encode("latin-1")):
        path = tmp_path / "maker.eds"
        path.write_bytes(octets.replace(b"\n", b"\r\n"))
        loaded = sheet.load(path)
        assert loaded.defaults(0x11) == expected.defaults(0x11) and loaded.emergencies == expected.emergencies
        assert sorted(loaded.entries) == sorted(expected.entries)
        path.unlink()


@pytest.mark.parametrize("kind, default, value", [(4, "0x80000000", -(2**31)), (4, "0x7FFFFFFF", 2**31 - 1), (2, "0xFF", -1), (7, "0x80000000", 2**31),
                                                (2, "-0x80", -128), (5, "0", 0), (9, "0x5 0x6", None)])
def test_a_hexadecimal_number_of_a_signed_type_may_be_a_twos_complement(tmp_path, kind, default, value):
    loaded = load(tmp_path, f"[2000]\nDataType={kind}\nDefaultValue={default}\n")
    assert loaded.entries[0x2000, 0].value(0) == value


@pytest.mark.parametrize("kind, default", [(8, "0.5"), (8, "-3.4028234663852886e38"), (8, ".5"), (8, "2"), (8, ""), (0x11, "1e300"), (0x11, "-1.5E-3")])
def test_a_real_object_has_a_finite_default(tmp_path, kind, default):
    """defaults() leaves it out, because it has integers only."""
    loaded = load(tmp_path, f"[2000]\nDataType={kind}\nDefaultValue={default}\n")
    assert loaded.entries[0x2000, 0].default == default and loaded.defaults(0) == {}


@pytest.mark.parametrize("kind, default", [(8, "half"), (8, "nan"), (8, "-inf"), (8, "0x10"), (8, "1e39"), (0x11, "1e400"), (8, "$NODEID+0.5"), (8, "1_0")])
def test_a_default_that_is_no_finite_number_of_its_type_is_refused(tmp_path, kind, default):
    with pytest.raises(sheet.SheetError) as refused:
        load(tmp_path, f"[2000]\nDataType={kind}\nDefaultValue={default}\n")
    bits = 32 if kind == 8 else 64
    assert f"device.eds:3: [2000] DefaultValue={default}: expected a finite number of {bits} bits, like 0.5 or 1e-3, as DataType={kind}" in str(refused.value)


def test_a_missing_sheet_is_refused(tmp_path):
    with pytest.raises(sheet.SheetError, match="cannot read: No such file"):
        sheet.load(tmp_path / "none.eds")


def test_sub_index_0_is_the_number_of_mapped_objects():
    values = {(0x1A00, 0): 2, (0x1A00, 1): 0x60410010, (0x1A00, 2): 0x60640020, (0x1A00, 3): 0x606C0020}
    assert sheet.mapped(values, 0x1A00) == [(0x6041, 0, 16), (0x6064, 0, 32)]
    assert sheet.mapped({}, 0x1A00) == []


@pytest.mark.parametrize("code, factor", [(0x00, 1.0), (0xFD, 1e-3), (0x03, 1e3), (0x80, 1e-128), (0x7F, 1e127)])
def test_the_prefix_is_a_power_of_ten_with_a_signed_exponent(code, factor):
    assert sheet.prefix(code << 24) == factor


def test_units_are_stated_or_follow_from_encoder_and_gear():
    position, velocity = 0xFA100000, 0xFD410300  # Millionths of a radian, thousandths of a degree per second.
    assert sheet.units({(0x60A8, 0): position, (0x60A9, 0): velocity}) == pytest.approx((1e-6, 1e-3 * math.pi / 180))
    ratios = {(0x608F, 1): 4096, (0x608F, 2): 1, (0x6091, 1): 100, (0x6091, 2): 1}
    assert sheet.units(ratios) == pytest.approx((2 * math.pi / 409600,) * 2)
    assert sheet.units({**ratios, (0x6091, 1): 0}) == (None, None)
    assert sheet.units({(0x60A8, 0): position}) == pytest.approx((1e-6, 1e-6))  # Without 0x60A9: the unit of position, per second.
    assert sheet.units({(0x60A8, 0): 0x00990000})[0] is None
    assert sheet.units({(0x60A9, 0): 0x00B44700})[1] == pytest.approx(2 * math.pi / 60)


def test_units_of_another_axis_are_at_their_own_objects():
    assert sheet.units({(0x68A8, 0): 0xFD100000}, 1) == pytest.approx((1e-3, 1e-3))
    assert sheet.units({(0x68A8, 0): 0xFD100000}, 0) == (None, None)


def test_the_objects_of_a_unit_are_named():
    ratios = [(0x608F, 1), (0x608F, 2), (0x6091, 1), (0x6091, 2)]
    assert sheet.made_of({}) == ratios
    assert sheet.made_of({(0x60A8, 0): 1}) == [(0x60A8, 0)]
    assert sheet.made_of({(0x60A9, 0): 1}) == [(0x60A9, 0), *ratios]
    assert sheet.made_of({(0x68A8, 0): 1}, 1) == [(0x68A8, 0)]
