# SPDX-License-Identifier: Apache-2.0
"""The descriptors and their schemas; the generator's output; and two readers of one file, in C and Python,
which must agree on every verdict, line and hash, for the mission as it is and for hundreds of damaged
copies."""

import json
import pathlib
import random
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GENERATOR = ROOT / "gse" / "generator"
DESCRIPTORS = ROOT / "descriptors"
MISSION = DESCRIPTORS / "missions" / "rokviss.xml"
SUBSYSTEMS = sorted((DESCRIPTORS / "subsystems").glob("*.xml"))
FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Werror"
SOURCES = (
    "base/*.c",
    "fsw/framework/xml/*.c",
    "fsw/framework/descriptor/*.c",
    "fsw/framework/parameter/*.c",
    "osal/posix/file.c",
    "osal/posix/mutex.c",
)

sys.path.insert(0, str(GENERATOR))
import c_header  # noqa: E402
import device as device_descriptor  # noqa: E402
import mission as mission_descriptor  # noqa: E402
import source  # noqa: E402
import subsystem as subsystem_descriptor  # noqa: E402


def generate(mission, out):
    """Run the generator as make does."""
    command = [sys.executable, GENERATOR / "generate.py", "--mission", mission, "--out", out]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """Directory that contains generated/."""
    directory = tmp_path_factory.mktemp("generator")
    done = generate(MISSION, directory / "generated")
    assert done.returncode == 0, done.stderr
    return directory


@pytest.fixture(scope="module")
def probe(generated):
    """A program with the flight software's reader of descriptors."""
    program = generated / "probe"
    files = [str(path) for pattern in SOURCES for path in sorted(ROOT.glob(pattern))]
    command = ["gcc", *FLAGS.split(), "-O1", f"-I{ROOT}", f"-I{generated}", "-o", str(program)]
    subprocess.run([*command, str(ROOT / "test/conformance/descriptor_probe.c"), *files, "-lexpat", "-lpthread"], check=True)
    return program


def read_in_c(probe, kind, paths):
    """[(accepted, interface hash, configuration hash, error)] of files."""
    done = subprocess.run([probe, kind, *paths], capture_output=True, text=True, check=True)
    rows = [line.split(" ", 3) for line in done.stdout.splitlines()]
    assert len(rows) == len(paths)
    return [(row[0] == "0", int(row[1], 16), int(row[2], 16), row[3]) for row in rows]


def read_in_python(kind, path):
    """(accepted, interface hash, configuration hash, error) of a file."""
    module = subsystem_descriptor if kind == "subsystem" else mission_descriptor
    try:
        model = module.load(pathlib.Path(path))
    except source.DescriptorError as error:
        return False, 0, 0, str(error)
    return True, model.interface_hash, model.configuration_hash, ""


@pytest.mark.parametrize("path", [MISSION, *SUBSYSTEMS], ids=lambda path: path.name)
def test_descriptor_is_valid_against_its_schema(path):
    assert_valid("mission" if path == MISSION else "subsystem", [path])


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_generated_headers_compile_without_a_warning(generated, tmp_path, compiler):
    for header in sorted((generated / "generated").glob("*.h")):
        unit = tmp_path / "unit.c"
        unit.write_text(f'#include "generated/{header.name}"\n#include "generated/{header.name}"\nint unit(void);\n'
                        "int unit(void)\n{\n    return 0;\n}\n")
        subprocess.run([compiler, *FLAGS.split(), f"-I{ROOT}", f"-I{generated}", "-c", unit, "-o", tmp_path / "unit.o"], check=True)


def test_compiled_interface_agrees_with_the_descriptors(probe):
    done = subprocess.run([probe, "compiled", DESCRIPTORS / "subsystems"], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == ["agree"]


def test_changed_interface_is_reported_with_file_and_both_hashes(probe, tmp_path):
    for path in SUBSYSTEMS:
        shutil.copy(path, tmp_path)
    changed = tmp_path / "joystick.xml"
    changed.write_text(changed.read_text().replace('name="FELT_TORQUE"', 'name="HAND_TORQUE"'))
    done = subprocess.run([probe, "compiled", tmp_path], capture_output=True, text=True, check=False)
    assert re.search(r"joystick\.xml:1: interface hash: expected 0x[0-9A-F]{16} as compiled, found 0x[0-9A-F]{16}: run make", done.stdout)


def test_both_readers_give_the_same_hashes(probe):
    for kind, paths in (("subsystem", SUBSYSTEMS), ("mission", [MISSION])):
        for path, row in zip(paths, read_in_c(probe, kind, paths)):
            assert row == read_in_python(kind, path)


def test_the_dictionary_has_the_hashes_that_the_flight_software_computes(generated, probe):
    content = json.loads((generated / "generated" / "rokviss.json").read_text())
    entries = {item["name"]: item for item in content["subsystems"]}
    paths = [path for path in SUBSYSTEMS if path.stem.upper() in entries]
    assert len(paths) == len(entries)
    for path, (_, interface, configuration, _) in zip(paths, read_in_c(probe, "subsystem", paths)):
        entry = entries[path.stem.upper()]
        assert (int(entry["interface_hash"], 16), int(entry["configuration_hash"], 16)) == (interface, configuration)
    (_, interface, configuration, _), = read_in_c(probe, "mission", [MISSION])
    assert (int(content["interface_hash"], 16), int(content["configuration_hash"], 16)) == (interface, configuration)


# --- damage ------------------------------------------------------------------------------------------------------

VALUES = (
    "", "0", "1", "-1", "2", "17", "255", "256", "65535", "65536", "4294967296", "18446744073709551616", "0x10", "0xZZ",
    "1.5", "-2.5 3", "1 2", "1  2", " 1", "1 ", "1e22", "1e23", "nan", "0.1234567890123456", "true", "false", "yes",
    "NAME", "name", "A-B", "A_B", "CUR_VALUES", "COUNTERS", "POSITION", "HIGH", "LOW", "SEVERE", "OPERATIONAL",
    "OFFLINE PRE_OPERATIONAL", "OPERATIONAL OPERATIONAL", "*", "500us", "2ms", "1s", "1", "99us", "DOUBLE", "INT32",
    "BOOL", "UINT8", "STRUCT", "SHARED_MEMORY", "UDP SHARED_MEMORY", "robot", "MANIPULATOR", "MANIPULATOR.ROBOT_STATE",
    "MODE", "OFF", "OFF FORCE", "OFF  FORCE", "FORCE OFF POSITION", "32767", "8,1", "129,3", "\u00e4", "&lt;", "ABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFGH",
)


def damage(text, rng):
    """A copy of a descriptor with one mistake or, by chance, with none."""
    kind = rng.randrange(6)
    attributes = list(re.finditer(r' (\w+)="([^"]*)"', text))
    lines = text.split("\n")
    if kind <= 2:
        found = rng.choice(attributes)
        return f'{text[: found.start(2)]}{rng.choice(VALUES)}{text[found.end(2) :]}'
    if kind == 3:
        found = rng.choice(attributes)
        return text[: found.start()] + text[found.end() :]
    if kind == 4:
        first, second = rng.choice(attributes), rng.choice(attributes)
        return f"{text[: first.start(2)]}{second[2]}{text[first.end(2) :]}"
    number = rng.choice([n for n, line in enumerate(lines) if line.strip().endswith("/>")])
    change = rng.choice(([], [lines[number], lines[number]]))
    return "\n".join(lines[:number] + change + lines[number + 1 :])


def line_of(error):
    """Line number in an error message."""
    return re.match(r".*?:(\d+): ", error)[1]


@pytest.mark.parametrize("seed", range(4))
def test_both_readers_agree_on_damaged_subsystems(probe, tmp_path, seed):
    rng = random.Random(seed)
    paths = []
    for number in range(250):
        path = tmp_path / f"{number}.xml"
        path.write_text(damage(rng.choice(SUBSYSTEMS).read_text(), rng), encoding="utf-8")
        paths.append(path)
    compare(probe, "subsystem", paths)


def test_both_readers_and_the_schema_agree_on_end_nodes(probe, tmp_path):
    """Every type of end node with each of the attributes framing, order, direction and baud, where it is allowed and where not."""
    text = (DESCRIPTORS / "subsystems" / "joystick.xml").read_text()
    before = re.search(r"<Endnode [^>]*/>", text)[0]
    named = 'name="x"'
    needs = {"CAN": 'bus="robot" node="1"', "UDP": 'address="127.0.0.1" port="1"', "TCP": 'address="127.0.0.1" port="1"'}
    formats = ["", *(f'{name}="{word}"' for name, words in device_descriptor.FLOW_FORMAT.items() for word in (*words, "x"))]
    paths = []
    for kind in device_descriptor.ENDNODES:
        for number, flow in enumerate(formats):
            path = tmp_path / f"{kind}-{number}.xml"
            path.write_text(text.replace(before, f'<Endnode type="{kind}" {needs.get(kind, named)} {flow}/>'))
            paths.append(path)
    compare(probe, "subsystem", paths)
    accepted = [path.stem for path in paths if read_in_python("subsystem", path)[0]]
    # All 7 types without an attribute; 3 with each of 4 framings; 6 with each of 2 orders; 1 with 3 directions; 1 with 8 baud rates.
    assert len(accepted) == 7 + 3 * 4 + 6 * 2 + 3 + 8


def test_both_readers_and_the_schema_agree_on_the_place_of_sync(probe, tmp_path):
    text = (DESCRIPTORS / "subsystems" / "joystick.xml").read_text()
    hashes = set()
    for number, word in enumerate(("AFTER_COMMANDS", "BEFORE_COMMANDS", "BEFORE", "", "AFTER_COMMANDS BEFORE_COMMANDS")):
        path = tmp_path / f"{number}.xml"
        path.write_text(text.replace("<Subsystem ", f'<Subsystem sync="{word}" ', 1))
        hashes.add(read_in_python("subsystem", path)[2])
    paths = sorted(tmp_path.glob("*.xml"))
    compare(probe, "subsystem", paths)
    assert [path.stem for path in paths if read_in_python("subsystem", path)[0]] == ["0", "1"]
    assert len(hashes) == 3  # Each order has a configuration hash of its own; refused files have 0.


@pytest.mark.parametrize("seed", range(2))
def test_both_readers_agree_on_damaged_missions(probe, tmp_path, seed):
    rng = random.Random(100 + seed)
    shutil.copytree(DESCRIPTORS / "subsystems", tmp_path / "subsystems")
    (tmp_path / "missions").mkdir()
    paths = []
    for number in range(200):
        path = tmp_path / "missions" / f"{number}.xml"
        path.write_text(damage(MISSION.read_text(), rng), encoding="utf-8")
        paths.append(path)
    compare(probe, "mission", paths)


def test_both_readers_agree_on_the_readers_of_a_port_and_the_schema_on_its_writers(probe, tmp_path):
    """A port of a mission with up to six readers, two writers for one port, and a subsystem that reads its
    own port."""
    shutil.copytree(DESCRIPTORS / "subsystems", tmp_path / "subsystems")
    (tmp_path / "missions").mkdir()
    stick = re.sub(r"<Devices>.*?</Devices>", "", (tmp_path / "subsystems" / "joystick.xml").read_text(), flags=re.DOTALL)  # A bus has one master.
    text, listed, links, paths = MISSION.read_text(), "", "", []
    for number in range(1, 7):
        (tmp_path / "subsystems" / f"s{number}.xml").write_text(stick.replace('name="JOYSTICK" id="17"', f'name="S{number}" id="{100 + number}"', 1))
        listed += f'<Subsystem name="S{number}" id="{100 + number}" executable="joystick" descriptor="../subsystems/s{number}.xml"/>'
    text = text.replace("</Subsystems>", listed + "</Subsystems>")

    def write(name, more):
        path = tmp_path / "missions" / f"{name}.xml"
        path.write_text(text.replace("</Links>", more + "</Links>"))
        paths.append(path)

    for number in range(1, 7):
        links += f'\n<Link name="L{number}" from="MANIPULATOR.ROBOT_STATE" to="S{number}.ROBOT_STATE"/>'
        write(f"readers{number}", links)
    write("writers", '<Link name="L" from="S1.HAND_POSITION" to="MANIPULATOR.HAND_POSITION"/>')
    write("twice", links[: links.index("/>") + 2] * 2)
    compare(probe, "mission", paths)
    found = {path.stem: read_in_python("mission", path)[3] for path in paths}
    assert [name for name, error in found.items() if not error] == ["readers1", "readers2", "readers3"]
    assert 'from="MANIPULATOR.ROBOT_STATE" of <Link>: expected a port with at most 4 links' in found["readers4"]
    assert 'to="MANIPULATOR.HAND_POSITION" of <Link>: expected a port that no other link leads to' in found["writers"]
    command = ["xmllint", "--noout", "--nonet", "--schema", DESCRIPTORS / "schema" / "mission.xsd", tmp_path / "missions" / "writers.xml"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode != 0 and "OneWriter" in result.stderr


NESTED = """<?xml version="1.0" encoding="UTF-8"?>
<Subsystem name="ARM" id="16">
  <Parameters>
    <StructRef name="ALL" id="7" type="STRUCT" settable="true">
      <ParamRef name="FIRST" type="UINT8"/>
      <StructRef name="JOINT" id="1" type="STRUCT">
        <ParamRef name="FLAG" type="BOOL"/>
        <StructRef name="MOTOR" type="STRUCT">
          <ParamRef name="CURRENT" type="DOUBLE" count="2" unit="A" init="1.5 -1.5"/>
          <StructRef name="COIL" type="STRUCT">
            <ParamRef name="WARM" type="BOOL"/>
          </StructRef>
        </StructRef>
        <ParamRef name="LAST" type="UINT16" max="100"/>
      </StructRef>
      <StructRef name="TOOL" type="STRUCT">
        <ParamRef name="FLAG" type="UINT16"/>
      </StructRef>
      <ParamRef name="POSITION" type="INT8"/>
    </StructRef>
  </Parameters>
  <Services>
    <Service type="6" capacity="2"/>
  </Services>
  <Configuration name="ONE" id="1" priority="1" samplingTime="1ms">
    <Initial parameter="ALL" field="JOINT.LAST" value="99"/>
    <Initial parameter="ALL" field="POSITION" value="1"/>
    <Loop name="SLOW" samplingTime="10ms" priority="20" services="20 17"/>
    <Loop name="SLOWER" samplingTime="1s" priority="10"/>
    <HKService id="1" interval="10" loop="SLOWER">
      <SampledOnce>
        <ParamRef name="ALL"/>
      </SampledOnce>
    </HKService>
  </Configuration>
</Subsystem>
"""


@pytest.mark.parametrize("seed", range(2))
def test_both_readers_agree_on_damaged_structures_within_structures_and_loops(probe, tmp_path, seed):
    compare_damaged(probe, tmp_path, NESTED, seed)


def compare_damaged(probe, tmp_path, document, seed):
    """Compare the readers on a document and on many damaged copies of it."""
    rng = random.Random(200 + seed)
    paths = []
    for number in range(250):
        path = tmp_path / f"{number}.xml"
        path.write_text(damage(document, rng) if number else document, encoding="utf-8")
        paths.append(path)
    assert read_in_python("subsystem", paths[0])[0], read_in_python("subsystem", paths[0])
    compare(probe, "subsystem", paths)


def test_structures_within_structures_are_nested_in_c(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(NESTED)
    schema = DESCRIPTORS / "schema" / "subsystem.xsd"
    subprocess.run(["xmllint", "--noout", "--nonet", "--schema", schema, path], capture_output=True, check=True)
    (tmp_path / "generated").mkdir()
    (tmp_path / "generated" / "arm_descriptor.h").write_text(c_header.header(subsystem_descriptor.load(path), "arm.xml"))
    unit = tmp_path / "unit.c"
    unit.write_text("""#include "generated/arm_descriptor.h"
int main(void)
{
    arm_parameters_t parameters = {0};
    parameters.all.joint.motor.current[1] = 2.0;
    parameters.all.joint.motor.coil.warm = true;
    parameters.all.tool.flag = 5;
    const uint8_t* const memory = (const uint8_t*)&parameters + arm_offsets[0];
    const double* const current = (const double*)(const void*)(memory + arm_fields[2].offset);
    return ((ARM_FIELD_COUNT == 7U) && (arm_definitions[0].wire_size == 24U) && (current[1] > 1.9) &&
            (memory[arm_fields[3].offset] == 1U) && (arm_fields[5].offset == offsetof(arm_all_t, tool))) ? 0 : 1;
}
""")
    for compiler in ("gcc", "clang"):
        subprocess.run([compiler, *FLAGS.split(), f"-I{ROOT}", f"-I{tmp_path}", unit, "-o", tmp_path / "unit"], check=True)
        subprocess.run([tmp_path / "unit"], check=True)


def compare(probe, kind, paths):
    """Expect the same verdict of both readers, with the same hashes or the same line; an accepted file must
    also be valid against the schema."""
    verdicts = {True: 0, False: 0}
    accepted = []
    for path, in_c in zip(paths, read_in_c(probe, kind, paths)):
        in_python = read_in_python(kind, path)
        assert in_c[0] == in_python[0], f"{path}: C: {in_c[3] or 'accepted'}; Python: {in_python[3] or 'accepted'}"
        verdicts[in_c[0]] += 1
        if in_c[0]:
            assert in_c == in_python
            accepted.append(path)
        else:
            assert line_of(in_c[3]) == line_of(in_python[3]), f"{path}: C: {in_c[3]}; Python: {in_python[3]}"
    assert min(verdicts.values()) > len(paths) // 20, verdicts
    assert_valid(kind, accepted)


def assert_valid(kind, paths):
    command = ["xmllint", "--noout", "--nonet", "--schema", DESCRIPTORS / "schema" / f"{kind}.xsd", *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, "\n".join(line for line in done.stderr.splitlines() if not line.endswith(" validates"))


# --- generator ---------------------------------------------------------------------------------------------------


@pytest.fixture
def copy(tmp_path):
    """A copy of the descriptors that may be changed: (mission, function that replaces text in a file)."""
    shutil.copytree(DESCRIPTORS, tmp_path / "descriptors")

    def spoil(name, old, new):
        path = tmp_path / "descriptors" / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return text[: text.index(old)].count("\n") + 1

    return tmp_path / "descriptors" / "missions" / "rokviss.xml", spoil


@pytest.mark.parametrize("mission", [path.name for path in sorted((DESCRIPTORS / "missions").glob("*.xml"))])
def test_every_mission_has_a_world(mission):
    assert (DESCRIPTORS / "worlds" / mission).exists()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("<Hand ", "<Foot ", "'Foot': This element is not expected"),
        (' travel="0.002"', "", "The attribute 'travel' is required but missing"),
        ('gravity="0 0 -9.81"', 'gravity="0 -9.81"', "attribute 'gravity'"),
        ('bus="joystick"', 'bus="Joystick"', "attribute 'bus'"),
        (' axes="2"', ' axes="2" colour="red"', "The attribute 'colour' is not allowed"),
        ('name="rokviss"', 'name="lab"', 'name="lab" of <World>: expected rokviss, as the file is named'),
        ("</World>", "</Worlds>", "mismatch"),
    ],
)
def test_the_build_checks_worlds_against_their_schema(copy, tmp_path, old, new, expected):
    mission, spoil = copy
    line = spoil("worlds/rokviss.xml", old, new)
    done = generate(mission, tmp_path / "out")
    assert done.returncode != 0
    found = re.search(r"worlds/rokviss\.xml:(\d+): ", done.stderr)
    assert found and line <= int(found[1]) <= line + 2, done.stderr  # xmllint counts to the end of the tag.
    assert expected in done.stderr


def test_the_build_checks_worlds_whose_name_no_mission_has(copy, tmp_path):
    mission, spoil = copy
    line = spoil("worlds/rokviss-20bit.xml", ' travel="0.002"', "")
    done = generate(mission, tmp_path / "out")
    assert done.returncode != 0
    found = re.search(r"worlds/rokviss-20bit\.xml:(\d+): ", done.stderr)
    assert found and line <= int(found[1]) <= line + 2, done.stderr


def test_the_build_refuses_more_buses_than_the_simulator_has(copy, tmp_path):
    """The mission lists two buses of the world and two other ones; the world has up to five more."""
    mission, spoil = copy
    benches = [f'<Bench name="B{index}" type="light" bus="more-{index}" node="2" eds="e" contact="0" stiffness="0" range="1"/>\n'
               for index in range(5)]
    spoil("worlds/rokviss.xml", "</World>", "".join(benches[:4]) + "</World>")
    assert generate(mission, tmp_path / "out").returncode == 0
    spoil("worlds/rokviss.xml", "</World>", benches[4] + "</World>")
    line = spoil("missions/rokviss.xml", 'name="joystick-b"', 'name="joystick-b"')
    done = generate(mission, tmp_path / "out")
    assert done.returncode != 0
    assert f"missions/rokviss.xml:{line}: " in done.stderr and "joystick-b" in done.stderr, done.stderr
    assert "at most 8 buses together with those of" in done.stderr


def test_generator_writes_only_changed_files(copy, tmp_path):
    mission, spoil = copy
    out = tmp_path / "out"
    assert generate(mission, out).returncode == 0
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    assert generate(mission, out).returncode == 0
    assert {path.name: path.stat().st_mtime_ns for path in out.iterdir()} == before
    # A part of the configuration, so no header changes.
    spoil("subsystems/joystick.xml", 'init="0.85"', 'init="0.9"')
    assert generate(mission, out).returncode == 0
    after = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    changed = {name for name in after if after[name] != before.get(name)}
    buses = {f"rokviss-{bus}.dbc" for bus in ("robot", "robot-b", "joystick", "joystick-b")}
    assert changed == {"rokviss.json", "rokviss.lua"} | buses  # These contain the name of the configuration.


@pytest.mark.parametrize(
    ("name", "old", "new", "expected"),
    [
        ("subsystems/joystick.xml", 'id="17"', 'id="2047"', 'id="2047" of <Subsystem>: expected a number from 1 to 2046'),
        ("subsystems/manipulator.xml", 'nrep="5"', 'nrep="7"', 'nrep="7" of <SampledNREPTimes>: expected a divisor of the interval 500'),
        ("missions/rokviss.xml", 'select="MOVE_TO"', 'select="FLY_TO"', 'select="FLY_TO" of <Allow>: expected a function of MANIPULATOR'),
        ("missions/rokviss.xml", "joystick.xml", "nothing.xml", 'nothing.xml" of <Subsystem>: expected a file, found none'),
        ("subsystems/joystick.xml", "</Events>", "</Event>", "not well-formed: mismatched tag"),
        (
            "subsystems/joystick.xml",
            'name="LINK_CLOSED" id="11" severity="LOW"',
            'name="LINK_CLOSED" id="11" severity="LOW" rate="0/s"',
            "expected a rate like 10/s, from 1/s to 1000/s",
        ),
        (
            "subsystems/joystick.xml",
            'name="STATE_TIMEOUT" id="10" severity="HIGH"',
            'name="STATE_TIMEOUT" id="10" severity="HIGH" burst="2"',
            "an <Event> of severity HIGH cannot have rate or burst",
        ),
        ("subsystems/joystick.xml", 'name="CYCLES"', 'name="SIGNED"', "keyword of C"),
        ("subsystems/manipulator.xml", 'object="0x2210:00"', 'object="0x2211:00"', 'object="0x2211:00" of <Quantity>: expected an object of joint-drive.eds'),
        ("subsystems/manipulator.xml", 'object="0x1400:05"', 'object="0x1400:07"', 'object="0x1400:07" of <Setting>: expected an object of joint-drive.eds'),
        ("subsystems/manipulator.xml", 'type="joint-drive"', 'type="compass"', "type=\"compass\" of <Device>: expected a class with a data sheet: gyro joint-drive"),
    ],
)
def test_generator_reports_each_error_with_its_line(copy, tmp_path, name, old, new, expected):
    mission, spoil = copy
    line = spoil(name, old, new)
    done = generate(mission, tmp_path / "out")
    assert done.returncode == 1
    assert expected in done.stderr and "Traceback" not in done.stderr
    assert re.match(r"\S+\.xml:\d+: ", done.stderr)
    if "well-formed" not in expected:
        assert f"{pathlib.Path(name).name}:{line}: " in done.stderr


# --- the mission itself ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def content(generated):
    """The dictionary as the ground reads it."""
    return json.loads((generated / "generated" / "rokviss.json").read_text())


def test_devices_and_objects_of_their_settings_are_in_data_sheets(content):
    sheets = {"joint-drive": "joint-drive.eds", "joystick": "joystick.eds"}
    for subsystem in content["subsystems"]:
        for configuration in subsystem["configurations"]:
            for device in configuration["devices"]:
                sheet = (DESCRIPTORS / "devices" / sheets[device["type"]]).read_text() if device["type"] in sheets else ""
                for setting in device["settings"]:
                    index, sub = setting["object"][2:].split(":")
                    section = f"[{index.upper()}]" if sub == "00" else f"[{index.upper()}sub{int(sub, 16):X}]"
                    assert section in sheet, f"{device['name']}: {setting['object']}"


def test_report_structures_of_one_id_are_distinguished_by_their_configuration(content):
    for subsystem in content["subsystems"]:
        for configuration in subsystem["configurations"]:
            ids = [structure["id"] for structure in configuration["housekeeping"]]
            assert len(ids) == len(set(ids))


def test_rate_of_telemetry_is_bounded(content):
    for mode in ("STAND_ALONE", "TELEPRESENCE"):
        rate = 0.0
        for subsystem in content["subsystems"]:
            for configuration in subsystem["configurations"]:
                if configuration["name"] in (mode, "FLIGHT"):
                    rate += sum(1e6 / structure["period_us"] for structure in configuration["housekeeping"] if structure["enabled"])
        assert rate < 12.0


def test_a_structure_counts_cycles_of_its_own_loop(content):
    manipulator = next(item for item in content["subsystems"] if item["name"] == "MANIPULATOR")
    for configuration in manipulator["configurations"]:
        assert configuration["loops"] == [{"name": "SLOW", "sampling_us": 10000, "priority": 20, "services": [20]}]
        periods = {structure["id"]: (structure["loop"], structure["period_us"]) for structure in configuration["housekeeping"]}
        assert periods == {4711: (None, 250000), 4712: ("SLOW", 2000000), 4720: (None, 50000)}


@pytest.mark.parametrize("path", [path for path in SUBSYSTEMS if path.stem not in ("supervisor", "communication")], ids=lambda path: path.stem)
def test_every_configuration_has_one_display_structure(path):
    """20 reports a second contain each parameter of the first structure once; if it is another structure, only a station enables it."""
    for configuration in subsystem_descriptor.load(path).configurations:
        first, (display,) = configuration.structures[0], [one for one in configuration.structures if one.display]
        assert display.interval * configuration.sampling_of(display) == 50000 and display.enabled == (display is first) and not display.repeated
        assert display.once == first.once + [parameter for _, parameters in first.repeated for parameter in parameters]


def test_every_function_may_be_called_somewhere_and_no_upward_step_skips_a_state(content):
    states = content["states"]
    rules = content["permissions"]
    for subsystem in content["subsystems"]:
        for function in subsystem["functions"]:
            assert any(rule["service"] == 8 and rule["select"] in ("*", function["name"]) and rule["to"] in ("*", subsystem["name"])
                       and set(rule["states"]) & set(function["states"]) for rule in rules), function["name"]
    before = {"PRE_OPERATIONAL": "OFFLINE", "SAFE_OPERATIONAL": "PRE_OPERATIONAL", "OPERATIONAL": "SAFE_OPERATIONAL"}
    upward = [rule for rule in rules if (rule["service"], rule["subtype"]) == (129, 1)]
    assert {rule["select"] for rule in upward} == set(before)
    for rule in upward:
        assert rule["states"] == [before[rule["select"]]]
        assert rule["select"] == "PRE_OPERATIONAL" or "SAFE" not in rule["modes"]
    assert states.index("ERROR_OPERATIONAL") == 6


def test_schema_and_generator_have_the_capacities_of_the_flight_software():
    header = (ROOT / "base/capacities.h").read_text(encoding="utf-8")
    capacities = {name: int(number) for name, number in re.findall(r"#define CAPACITY_(\w+) (\d+)U", header)}
    header = (ROOT / "fsw/framework/descriptor/mission_descriptor.h").read_text(encoding="utf-8")
    capacities |= {name: int(number) for name, number in re.findall(r"#define MISSION_(\w+)_MAX (\d+)U", header)}
    schema = (DESCRIPTORS / "schema" / "mission.xsd").read_text(encoding="utf-8")
    at_most = {name: int(number) for name, number in re.findall(r'<xs:element name="(\w+)"[^>]*maxOccurs="(\d+)"', schema)}
    lists = {"Subsystem": "SUBSYSTEMS", "Mode": "MODES", "User": "USERS", "Allow": "RULES", "Link": "LINKS", "Plan": "PLANS", "Bus": "BUSES"}
    assert {name: at_most[name] for name in lists} == {name: capacities[kind] for name, kind in lists.items()}
    interface = re.search(r"INTERFACE_NAME_MAX (\d+)U", (ROOT / "osal/include/osal/can_interface.h").read_text(encoding="utf-8"))
    types = (DESCRIPTORS / "schema" / "types.xsd").read_text(encoding="utf-8")
    longest = re.search(r'"BusName">\s*<xs:restriction base="xs:string"><xs:pattern value="\[a-z\]\[a-z0-9_\\-\]\{0,(\d+)\}"/>', types)
    assert source.BUS_NAME_MAX == int(longest[1]) + 1 == int(interface[1])
    assert mission_descriptor.SUBSYSTEM_LINKS == capacities["SUBSYSTEM_LINKS"]
    assert mission_descriptor.PORT_LINKS == capacities["PORT_LINKS"]
    assert mission_descriptor.RING_RECORDS == capacities["RING_RECORDS"]
