# SPDX-License-Identifier: Apache-2.0
"""The table of device classes that the flight software gets from data sheets: modules of CiA 401 and 404,
manufacturer objects, units of drives; and data sheets that are refused."""

import functools
import math
import pathlib
import re
import struct
import subprocess
import sys

import cantools
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "gse" / "generator"), str(ROOT / "gse")]

import dbc
import device_class
import mission as missions
import sheet
from hirosco_gse import frames, mcap_export
from sheet import SheetError

PRINTER = r"""
#include "base/assertion.h"
#include "fsw/canopen/device_profile.h"
#include <stdio.h>
#include <stdlib.h>
void fsw_assertion_failed(const char* file, int line) { printf("%s:%d", file, line); exit(1); }
int main(int count, char** names)
{
    for (int n = 1; n < count; n++) {
        const canopen_device_profile_t* p = canopen_device_profile_find(names[n]);
        printf("%s %u %x %x %u", p->type, p->profile, p->vendor_id, p->product_code, p->axis_count);
        for (int i = 0; i < p->axis_count; i++) { printf(" axis %.9g %.9g %d", p->axes[i].position_rad, p->axes[i].velocity_rad_s, p->axes[i].has_torque); }
        for (int i = 0; i < p->value_count; i++) { printf(" value %x:%x %u %s %g", p->values[i].index, p->values[i].subindex, p->values[i].octets, p->values[i].is_real ? "real" : p->values[i].is_signed ? "1" : "0", p->values[i].scale); }
        for (int i = 0; i < p->transmit_count; i++) { printf(" T%x %u %u", p->transmit[i].cob_base, canopen_device_profile_pdo_octets(&p->transmit[i]), p->transmit[i].is_each_sync); }
        for (int i = 0; i < p->axis_count; i++) { printf(" within %.4g %.4g %.4g", p->axes[i].low_rad, p->axes[i].high_rad, p->axes[i].speed_rad_s); }
        for (int i = 0; i < p->axis_count; i++) { for (int k = 0; k < p->axes[i].unit_count; k++) { printf(" unit %x:%x %u %x", p->axes[i].units[k].index, p->axes[i].units[k].subindex, p->axes[i].units[k].octets, p->axes[i].units[k].value); } }
        for (int i = 0; i < p->emergency_count; i++) { printf(" emcy %x %d", p->emergencies[i].code, p->emergencies[i].severity); }
        for (int i = 0; i < p->receive_count; i++) { printf(" R%x %u %u", p->receive[i].cob_base, canopen_device_profile_pdo_octets(&p->receive[i]), p->receive[i].is_valid); }
        printf("\n");
    }
    return 0;
}
"""


def _sheet(objects, pdos=()):
    """Text of an EDS: {(index, sub): (data type, default)}, and PDOs as (parameter index, COB-ID, type, mapped objects)."""
    objects = {(0x1018, 1): (7, "0x3E7"), (0x1018, 2): (7, "0x15"), **objects}
    for parameter, identifier, kind, mapped in pdos:
        objects |= {(parameter, 1): (7, identifier), (parameter, 2): (5, str(kind)), (parameter + 0x200, 0): (5, str(len(mapped)))}
        objects |= {(parameter + 0x200, number): (7, f"0x{entry:08X}") for number, entry in enumerate(mapped, 1)}
    return "".join(f"[{index:04X}{f'sub{sub:x}' if sub else ''}]\nParameterName=x\nObjectType=0x7\nDataType={kind:#06x}\nDefaultValue={value}\n"
                   for (index, sub), (kind, value) in objects.items())


VALVES = _sheet({(0x1000, 0): (7, "0x00020191"), (0x6000, 1): (5, "0"), (0x6200, 1): (5, "0"), (0x2100, 0): (6, "0")},
                [(0x1800, "$NODEID+0x180", 1, [0x60000108]), (0x1400, "$NODEID+0x200", 1, [0x62000108, 0x00050008, 0x21000010])])
GYRO = _sheet({(0x1000, 0): (7, "0x00020194"), **{(0x9130, n): (4, "0") for n in (1, 2, 3)}, **{(0x6132, n): (5, "6") for n in (1, 2)}},
              [(0x1800, "$NODEID+0x180", 1, [0x91300120, 0x91300220]), (0x1801, "$NODEID + 0x280", 240, [0x91300320])])
# CiA 404 with REAL32, one in a PDO and one that a setting may map, and a REAL64, which only SDO transfers.
PRESSURE = _sheet({(0x1000, 0): (7, "0x00020194"), (0x6130, 1): (8, "0.5"), (0x6130, 2): (8, ""), (0x6132, 1): (5, "3"), (0x2300, 0): (0x11, "1e-3")},
                  [(0x1800, "$NODEID+0x180", 1, [0x61300120])])
PRESSURE = re.sub(r"(DataType=0x00(?:08|11)\n)", r"\1AccessType=ro\nPDOMapping=1\n", PRESSURE)
TRACKER = _sheet({(0x1000, 0): (7, "0"), (0x2000, 1): (0x10, "0"), (0x2000, 2): (4, "0")}, [(0x1800, "$NODEID+0x80000180", 255, [0x20000118, 0x20000220])])
DRIVE = {(0x1000, 0): (7, "0x00420192"), (0x6040, 0): (6, "0"), (0x6041, 0): (6, "0"), (0x6064, 0): (4, "0"), (0x6071, 0): (3, "0")}
LIMITS = {(0x607D, 1): (4, "-45000"), (0x607D, 2): (4, "90000"), (0x6080, 0): (7, "3000"), (0x6091, 1): (7, "100"), (0x6091, 2): (7, "1")}
CODES = "[Comments]\nLines=3\nLine1=EMCY 0xFF01 HIGH Torque sensor\nLine2=Any text\nLine3=EMCY 0x4310 LOW A fan would do\n"
TURNS = {(0x608F, 1): (7, "4000"), (0x608F, 2): (7, "1"), (0x6091, 1): (7, "50"), (0x6091, 2): (7, "2")}
RPM = {(0x60A8, 0): (7, "0xFD410000"), (0x60A9, 0): (7, "0x00B44700")}


def _table(tmp_path, **sheets):
    for name, text in sheets.items():
        (tmp_path / f"{name}.eds").write_text(text, encoding="utf-8")
    return device_class.header(tmp_path)


def test_flight_software_finds_the_content_of_the_sheets(tmp_path):
    counts = _sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x60410010, 0x60640020])])
    degrees = CODES + _sheet(DRIVE | RPM | LIMITS | {(0x6076, 0): (7, "1000")}, [(0x1400, "$NODEID+0x200", 1, [0x60400010, 0x60710010])])
    text = _table(tmp_path, valves=VALVES, gyro=GYRO, tracker=TRACKER, counts=counts, degrees=degrees, pressure=PRESSURE)
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "device_classes.h").write_text(text, encoding="utf-8")
    (tmp_path / "print.c").write_text(PRINTER, encoding="utf-8")
    command = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{tmp_path}", f"-I{ROOT}",
               "-o", tmp_path / "print", tmp_path / "print.c", ROOT / "fsw/canopen/device_profile.c",
               ROOT / "fsw/canopen/device_classes.c"]
    subprocess.run(command, check=True)
    printed = subprocess.run([tmp_path / "print", "valves", "gyro", "tracker", "counts", "degrees", "pressure"], stdout=subprocess.PIPE, text=True, check=True)
    assert printed.stdout.splitlines() == [
        "valves 401 3e7 15 0 value 6000:1 1 0 1 value 6200:1 1 0 1 value 2100:0 2 0 1 T180 1 1 R200 4 1",
        "gyro 404 3e7 15 0 value 9130:1 4 1 1e-06 value 9130:2 4 1 1e-06 value 9130:3 4 1 1 T180 8 1 T280 4 0",
        "tracker 0 3e7 15 0 value 2000:1 3 1 1 value 2000:2 4 1 1 T180 7 0",
        "counts 402 3e7 15 1 axis 6.28318531e-05 6.28318531e-05 0 T180 6 1 within 0 0 0"
        " unit 608f:1 4 fa0 unit 608f:2 4 1 unit 6091:1 4 32 unit 6091:2 4 2",
        "degrees 402 3e7 15 1 axis 1.74532925e-05 0.104719755 1 within -0.7854 1.571 3.142 unit 60a8:0 4 fd410000 unit 60a9:0 4 b44700"
        " emcy ff01 3 emcy 4310 1 R200 4 1",
        "pressure 404 3e7 15 0 value 6130:1 4 real 1 T180 4 1",
    ]
    assert "{0x6130U, 2U, 4U, PROFILE_VALUE, PROFILE_PADDING, 0U, true, true, 1.0}" in text and "0x2300" not in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (_sheet({}), "0x1000:00: expected a default, which identifies the class"),
        (_sheet({(0x1000, 0): (7, "0x192")}), "0x1000 states CiA 402: expected a controlword, 0x6040"),
        *((_sheet({(0x1000, 0): (kind, value)}), "wrong.eds:15: 0x1000:00: expected an unsigned number of at most 32 bits")
          for kind, value in ((0x1B, "0x100000192"), (4, "-1"), (9, "402"))),
        (_sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [])]).replace("DataType=0x0007\nDefaultValue=$NODEID+0x180", "DataType=0x1B\nDefaultValue=$NODEID+0x100000180"),
         "0x1800:01: expected an unsigned number of at most 32 bits"),
        # Units of the user; the limit of speed is that of the motor.
        *((_sheet(DRIVE | RPM | LIMITS | {(0x6091, sub): (4, value)}), f"wrong.eds:{line}: 0x6091: expected revolutions of more than 0, because the limit 0x6080")
          for sub, line in ((1, 65), (2, 70)) for value in ("0", "-1")),
        (_sheet(DRIVE), "units of axis 1: expected angles in 0x60A8 and 0x60A9, or 0x608F and 0x6091"),
        (_sheet(DRIVE | {(0x60A8, 0): (7, "0xFA010000")}), "units of axis 1"),  # The unit is metres.
        (_sheet(DRIVE | TURNS, [(0x1400, "$NODEID+0x200", 1, [0x60710010])]), "torque 0x6071 in a PDO: expected the rated torque"),
        (_sheet(DRIVE | TURNS, [(0x1400, "0x211", 1, [0x60400010])]), "0x1400:01: expected $NODEID"),
        (_sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x60410010, 0x60640020, 0x60640020])]), "0x1a00: expected at most 8 octets"),
        (_sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x60410004])]), "4 bits of 0x6041:00 in a PDO"),
        (_sheet(DRIVE | TURNS, [(0x1400, "$NODEID+0x20000200", 1, [0x60400010])]), "0x1400:01: expected an identifier of 11 bits"),
        (_sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x60640010])]), "16 bits of 0x6064:00 in a PDO: expected 32, as its DataType=0x0004"),
        (_sheet(DRIVE | TURNS | {(0x2000, 0): (9, "a")}, [(0x1800, "$NODEID+0x180", 1, [0x20000020])]),
         "0x2000:00 in a PDO has DataType=0x0009: expected an integer or REAL32"),
        (_sheet(DRIVE | TURNS | {(0x2000, 0): (8, "0.5")}, [(0x1800, "$NODEID+0x180", 1, [0x20000010])]),
         "16 bits of 0x2000:00 in a PDO: expected 32, as its DataType=0x0008"),
        (_sheet(DRIVE | TURNS | {(0x2000, 0): (0x11, "0.5")}, [(0x1800, "$NODEID+0x180", 1, [0x20000040])]),
         "64 bits of 0x2000:00 in a PDO: expected 8, 16, 24 or 32"),
        (_sheet(DRIVE | TURNS | {(0x6064, 0): (8, "0.5")}, [(0x1800, "$NODEID+0x180", 1, [0x60640020])]),
         "0x6064:00 in a PDO has DataType=0x0008: expected an integer, as CiA 402 has it"),
        (_sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x606C0020])]), "0x606c:00 in a PDO: expected an object of the sheet"),
        (_sheet(DRIVE | TURNS, [(0x1800 + n, f"$NODEID+{0x180 + 0x100 * n:#x}", 1, [0x60410010]) for n in range(5)]), "5 PDOs from 0x1800: expected at most 4"),
        (_sheet({(0x1000, 0): (7, "0")} | {(0x2000, n): (5, "0") for n in range(1, 18)},
                [(0x1800 + n, f"$NODEID+{0x180 + 0x100 * n:#x}", 1, [0x20000008 + (8 * n + k << 8) for k in range(1, 9) if 8 * n + k < 18]) for n in range(3)]),
         "too many values in PDOs, at most 16"),
        (VALVES + "[Comments]\nLines=1\nLine1=EMCY 0xFF01 SEVERE Torque sensor\n", "line1=EMCY 0xFF01 SEVERE Torque sensor: expected EMCY, a code from 0x0001"),
        (VALVES + "[Comments]\nLines=1\nLine1=EMCY 0x0000 HIGH None\n", "line1=EMCY 0x0000 HIGH None: expected EMCY"),
        (VALVES + "[Comments]\nLines=2\nLine1=EMCY 0xFF01 HIGH One\nLine2=EMCY 0xff01 LOW Two\n", "line2=EMCY 0xff01 LOW Two: expected EMCY"),
        (VALVES + "[Comments]\nLines=1\nLine1=EMCY 0xFF01 HIGH\n", "and a text"),
    ],
)
def test_a_sheet_that_the_flight_software_cannot_use_is_refused_with_its_file(tmp_path, text, message):
    with pytest.raises(SheetError) as refused:
        _table(tmp_path, wrong=text)
    assert "wrong.eds" in str(refused.value) and message in str(refused.value)


def test_a_refusal_names_the_line_of_the_object(tmp_path):
    text = _sheet(DRIVE | TURNS, [(0x1800, "$NODEID+0x180", 1, [0x60410010, 0x60640010])])
    line = text.splitlines().index("[1A00sub2]") + 1
    with pytest.raises(SheetError, match=f"wrong.eds:{text[:text.index('0x60640010')].count(chr(10)) + 1}: ") as refused:
        _table(tmp_path, wrong=text)
    assert int(str(refused.value).split(":")[1]) > line


def test_a_class_keeps_the_hash_of_its_sheet(tmp_path):
    """FNV-1a of the octets, computed here by another implementation; all sheets together have a hash, too."""
    def fnv(octets):
        return functools.reduce(lambda value, octet: ((value ^ octet) * 0x100000001B3) % 2**64, octets, 0xCBF29CE484222325)

    text = _table(tmp_path, valves=VALVES, gyro=GYRO)
    hashes = {name: fnv(sheet_text.encode()) for name, sheet_text in (("gyro", GYRO), ("valves", VALVES))}
    for name, value in hashes.items():
        assert f'.type = "{name}", .sheet_hash = {value:#018x}ULL' in text
    whole = fnv("".join(f"{name} {value:016x}\n" for name, value in hashes.items()).encode())
    assert f"#define DEVICE_CLASSES_HASH {whole:#018x}ULL" in text
    assert device_class.sheets_hash(tmp_path) == whole


@pytest.mark.parametrize("index, unit", [(0x6064, "rad"), (0x606C, "rad/s")])
def test_the_database_has_si_units_of_a_drive_with_increments(index, unit):
    values = sheet.load(sheet.DIRECTORY / "servo-drive.eds").defaults(0)
    turns = values[0x608F, 2] * values[0x6091, 2] / (values[0x608F, 1] * values[0x6091, 1])
    assert dbc._scale(values, index) == (pytest.approx(2.0 * math.pi * turns), unit)


def test_the_database_is_valid_with_the_names_of_any_maker(tmp_path, monkeypatch):
    """Names and texts with other letters, a digit first, quotes, or the same twice. cantools reads the database."""
    for path in sheet.DIRECTORY.glob("*.eds"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / "joint-drive.eds").read_text(encoding="utf-8")
    for section, name in (("6041", "2nd word"), ("6064", "日本"), ("6077", "Größe der Kraft"), ("6078", "12 V"), ("2210", "12 V"),
                          ("606C", "x" * 40), ("6040", "Target"), ("607A", "Target"), ("60B2", "x" * 40)):
        text, count = re.subn(rf"(?m)^(\[{section}\]\nParameterName=).*$", rf"\g<1>{name}", text)
        assert count == 1
    text, count = re.subn(r"(EMCY (0x\w+) HIGH ).*", '\\1Für "Prüfung" \\\\ 日', text, count=1)
    assert count == 1
    (tmp_path / "joint-drive.eds").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sheet, "DIRECTORY", tmp_path)
    made = dbc.databases(missions.load(ROOT / "descriptors/missions/rokviss.xml"))
    database = cantools.database.load_string(made["robot"], "dbc")
    names = {pdo: [signal.name for signal in database.get_message_by_name(f"JOINT1_{pdo}").signals] for pdo in ("TPDO1", "TPDO2", "RPDO1")}
    assert names == {"TPDO1": ["Object2ndWord", "Object6064Sub0", "GroeDerKraft"], "TPDO2": ["X" + "x" * 31, "Object12V", "Object12V2210Sub0"],
                     "RPDO1": ["Target", "Target607ASub0", "X" + "x" * 31]}
    assert "Fur 'Prufung' / " in map(str, database.get_message_by_name("JOINT1_EMCY").get_signal_by_name("Code").choices.values())


def test_ground_reads_real_numbers_bit_by_bit(tmp_path, monkeypatch):
    """A REAL32 in a PDO: cantools, the decoder of frames and the export to MCAP give the number of IEEE 754; NaN and infinite stay so."""
    for path in sheet.DIRECTORY.glob("*.eds"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / "joint-drive.eds").read_text(encoding="utf-8")
    text, count = re.subn(r"(?m)^(\[2210\]\nParameterName=)[^\n]*(\nObjectType=0x7\nDataType=)0x0003(\nAccessType=ro\nDefaultValue=)250$",
                          r"\g<1>Pressure\g<2>0x0008\g<3>0.5", text)
    # TPDO2 then has 0x6078 with 16 bits, the real number, and 16 bits of padding.
    for old, new in (("0x22100010", "0x00060010"), ("0x60780010", "0x22100020"), ("0x606C0020", "0x60780010")):
        text, changed = re.subn(f"(?m)^DefaultValue={old}$", f"DefaultValue={new}", text)
        count += changed
    assert count == 4
    (tmp_path / "joint-drive.eds").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sheet, "DIRECTORY", tmp_path)
    made = dbc.databases(missions.load(ROOT / "descriptors/missions/rokviss.xml"))["robot"]
    (tmp_path / "robot.dbc").write_text(made, encoding="utf-8")
    assert len(re.findall(r"(?m)^SIG_VALTYPE_ \d+ Pressure : 1;$", made)) == made.count("SIG_VALTYPE_") == 2  # Of both joints.
    message = cantools.database.load_string(made, "dbc").get_message_by_name("JOINT1_TPDO2")
    own = frames.Database(tmp_path / "robot.dbc").signals[message.frame_id]["Pressure"]
    assert message.get_signal_by_name("Pressure").is_float and (own.is_real, own.start, own.bits, own.factor, own.unit) == (True, 16, 32, 1.0, "")
    for number in (0.1, -2.5e-38, 3.4028234663852886e38, math.inf, -math.inf, math.nan):
        bits = struct.pack("<f", number)
        octets = b"\xff\xff" + bits + b"\xff\xff"
        expected = pytest.approx(struct.unpack("<f", bits)[0], rel=0, abs=0, nan_ok=True)
        assert message.decode(octets[: message.length], decode_choices=False)["Pressure"] == expected
        assert own.value(octets) == expected
        assert mcap_export._values(np.frombuffer(octets, "<u8"), own)[0] == expected
