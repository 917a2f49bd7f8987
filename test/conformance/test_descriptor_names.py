# SPDX-License-Identifier: Apache-2.0
"""Names for numbers and for failures: the readers in C and Python agree about a descriptor; the names are
constants in C."""

import subprocess

import pytest
import test_descriptors
from test_descriptors import generated, probe  # noqa: F401  fixtures

import c_header
import subsystem
from source import DescriptorError

NAMED = """<?xml version="1.0" encoding="UTF-8"?>
<Subsystem name="ARM" id="16">
  <Enumerations>
    <Enumeration name="MODE" values="OFF POSITION FORCE"/>
    <Enumeration name="CAUSE" first="250" values="LOST SILENT OFF"/>
    <Enumeration name="WIDE" first="0xFFFF" values="FIRST SECOND"/>
  </Enumerations>
  <Failures>
    <Failure name="TOO_FAR" id="1" detail="JOINT"/>
    <Failure name="TOO_FAST" id="0x7FFF"/>
  </Failures>
  <Parameters>
    <StructRef name="ALL" id="7" type="STRUCT" settable="true">
      <ParamRef name="MODE" type="INT8" count="2" enumeration="MODE" init="FORCE OFF"/>
      <StructRef name="JOINT" type="STRUCT">
        <ParamRef name="CAUSE" type="UINT8" enumeration="CAUSE" init="SILENT"/>
      </StructRef>
    </StructRef>
    <ParamRef name="MODE" id="8" type="UINT64" unit="mode" enumeration="WIDE" init="SECOND" settable="true"/>
    <ParamRef name="OTHER" id="9" type="INT32" enumeration="WIDE"/>
  </Parameters>
  <Events>
    <Event name="LOST" id="1" severity="LOW">
      <ParamRef name="CAUSE" type="INT16" enumeration="CAUSE"/>
    </Event>
    <Event name="CHANGED" id="2" severity="LOW">
      <ParamRef name="MODE"/>
    </Event>
  </Events>
  <Functions>
    <Function name="SWITCH" id="1" states="*">
      <Argument name="TO" id="1" type="UINT16" count="2" enumeration="MODE"/>
    </Function>
  </Functions>
  <Configuration name="ONE" id="1" priority="1" samplingTime="1ms">
    <Initial parameter="ALL" field="MODE" value="POSITION FORCE"/>
    <Initial parameter="MODE" value="FIRST"/>
    <RTLinkService>
      <Provides name="OUT" id="1" methods="UDP">
        <ParamRef name="MODE" type="UINT32" enumeration="MODE"/>
      </Provides>
    </RTLinkService>
  </Configuration>
</Subsystem>
"""


@pytest.mark.parametrize("seed", range(2))
def test_both_readers_agree_on_damaged_names(probe, tmp_path, seed):  # noqa: F811
    test_descriptors.compare_damaged(probe, tmp_path, NAMED, seed)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('enumeration="MODE" init="FORCE OFF"', 'enumeration="MODES" init="FORCE OFF"', 'expected an <Enumeration> defined above; there are: MODE CAUSE WIDE'),
        ('init="FORCE OFF"', 'init="FORCE ON"', "expected 2 name(s) of MODE, one space between: OFF POSITION FORCE"),
        ('value="FIRST"', 'value="THIRD"', "expected 1 name(s) of WIDE, one space between: FIRST SECOND"),
        ('type="UINT8" enumeration', 'type="INT8" enumeration', "expected one whose numbers fit INT8"),
        ('type="UINT8" enumeration', 'type="BOOL" enumeration', "expected one whose numbers fit BOOL"),
        ('first="250"', 'first="254"', "expected one whose numbers fit UINT8"),
        ('type="UINT8" enumeration', 'type="UINT8" max="1" enumeration', "a field with an enumeration cannot have min or max"),
        ('values="OFF POSITION FORCE"', 'values="OFF FORCE OFF"', "expected different upper-case identifiers"),
        ('<ParamRef name="MODE"/>', '<ParamRef name="MODE" enumeration="MODE"/>', "cannot have count, unit or enumeration"),
        ('id="0x7FFF"', 'id="0x8000"', "expected a number from 1 to 32767"),
        ('name="TOO_FAST"', 'name="TOO_FAR"', "is taken in line"),
    ],
)
def test_the_error_of_a_wrong_name_lists_the_valid_ones(probe, tmp_path, old, new, expected):  # noqa: F811
    assert NAMED.count(old) == 1
    path = tmp_path / "arm.xml"
    path.write_text(NAMED.replace(old, new))
    accepted, _, _, error = test_descriptors.read_in_python("subsystem", path)
    assert not accepted and expected in error
    (in_c,) = test_descriptors.read_in_c(probe, "subsystem", [path])
    assert not in_c[0] and test_descriptors.line_of(in_c[3]) == test_descriptors.line_of(error)


def test_names_belong_to_the_interface_and_are_constants_in_c(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(NAMED)
    model = subsystem.load(path)
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "arm_descriptor.h").write_text(c_header.header(model, "arm.xml"))
    unit = tmp_path / "unit.c"
    unit.write_text("""#include "generated/arm_descriptor.h"
int main(void)
{
    return ((ARM_VALUE_MODE_FORCE == 2) && (ARM_VALUE_CAUSE_OFF == 252) && (ARM_VALUE_WIDE_SECOND == 65536) &&
            (ARM_FAILURE_TOO_FAR == 0x8001) && (ARM_FAILURE_TOO_FAST == 0xFFFF)) ? 0 : 1;
}
""")
    for compiler in ("gcc", "clang"):
        subprocess.run([compiler, *test_descriptors.FLAGS.split(), f"-I{test_descriptors.ROOT}", f"-I{tmp_path}", unit, "-o", tmp_path / "unit"], check=True)
        subprocess.run([tmp_path / "unit"], check=True)
    for old, new in (('first="250"', 'first="251"'), ("LOST SILENT OFF", "SILENT LOST OFF"), ('name="TOO_FAR"', 'name="TOO_NEAR"'), ('id="0x7FFF"', 'id="2"')):
        path.write_text(NAMED.replace(old, new))
        assert subsystem.load(path).interface_hash != model.interface_hash, new
    path.write_text(NAMED.replace('name="CAUSE" first="250"', 'name="CAUSE_X" first="250"').replace('enumeration="CAUSE"', 'enumeration="CAUSE_X"')
                    .replace('name="WIDE"', 'name="CAUSE"').replace('"WIDE"', '"CAUSE"')
                    .replace('values="FIRST SECOND"', 'values="X_LOST SECOND"').replace('"FIRST"', '"X_LOST"'))
    with pytest.raises(DescriptorError, match="the constant ARM_VALUE_CAUSE_X_LOST is that of <Enumeration> CAUSE_X"):
        c_header.header(subsystem.load(path), "arm.xml")
