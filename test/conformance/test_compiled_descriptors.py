# SPDX-License-Identifier: Apache-2.0
"""Compares the descriptors that are compiled into the programs of a board with the results of the reader of descriptors for the same files."""

import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MISSIONS = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "descriptors/missions").glob("*.xml"))
SOURCES = ("fsw/framework/descriptor/*.c", "fsw/framework/xml/*.c", "base/*.c", "osal/posix/*.c", "osal/common/*.c",
           "launcher/descriptor_members.c")
FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -Wall -Wextra -Werror -O1 -I. -Ibuild"
HEADERS = ("fsw/framework/descriptor/mission_descriptor.h", "fsw/framework/descriptor/subsystem_descriptor.h", "base/flow_format.h")
# Members that are not written: storage of the reader, and parts of the mission that a subsystem does not need.
NOT_WRITTEN = {
    "subsystem_descriptor_t": {"text_used", "storage"},
    "mission_descriptor_t": {"text_used", "storage", "modes", "mode_count", "rules", "rule_count", "plans", "plan_count", "actions", "action_count",
                             "users", "user_count"},
    "mission_subsystem_t": {"ports", "port_count", "configurations", "configuration_count"},
}
PROGRAMS = ("actuators", "arm", "instruments", "joystick", "manipulator")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The reader, compiled once: object files, those of each directory of sources in a directory of their own."""
    directory = tmp_path_factory.mktemp("reader")
    for number, pattern in enumerate(SOURCES):
        (directory / str(number)).mkdir()
        subprocess.run(["gcc", *FLAGS.split(), f"-I{ROOT}", "-c", *sorted(ROOT.glob(pattern))], cwd=directory / str(number), check=True)
    return directory


def build(library, directory, source):
    """The probe of one generated source."""
    command = ["gcc", *FLAGS.split(), f'-DCOMPILED="{source}"', "-o", str(directory / "probe"), "test/conformance/compiled_probe.c"]
    subprocess.run([*command, *map(str, sorted(library.glob("*/*.o"))), "-lexpat", "-lpthread"], cwd=ROOT, check=True)
    return directory / "probe"


def compile_descriptors(directory, name, *missions):
    return subprocess.run([ROOT / "build/bin/descriptor-compiler", str(directory), name, name, *missions], cwd=ROOT, capture_output=True,
                          text=True, check=False)


@pytest.mark.parametrize("name", PROGRAMS)
def test_compiled_models_are_those_of_the_reader(library, tmp_path, name):
    done = compile_descriptors(tmp_path, name, *MISSIONS)
    assert done.returncode == 0, done.stderr
    expected = sum((ROOT / path).read_text().count(f'executable="{name}"') for path in MISSIONS)
    probe = build(library, tmp_path, tmp_path / f"{name}_descriptors.c")
    result = subprocess.run([probe, *MISSIONS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    found, entries, items = map(int, result.stdout.split())
    assert found == entries == expected > 0
    assert items > 50


@pytest.mark.parametrize("name", PROGRAMS)
def test_device_classes_are_those_of_the_descriptors(tmp_path, name):
    assert compile_descriptors(tmp_path, name, *MISSIONS).returncode == 0
    texts = [(ROOT / path).read_text() for path in MISSIONS]
    files = {file for text in texts for file in re.findall(rf'executable="{name}" descriptor="([^"]+)"', text)}
    types = {kind for file in files for kind in re.findall(r'<Device [^>]*type="([^"]+)"', (ROOT / "descriptors/missions" / file).read_text())}
    listed = re.findall(r"DEVICE_CLASS_\d+, /\* (\S+) \*/", (tmp_path / f"{name}_descriptors.c").read_text())
    assert listed == sorted(types - {"stream"})
    assert (listed == []) == (name == "instruments"), "expected no class for stream devices"


def test_a_changed_constant_is_found(library, tmp_path):
    """Shows that the comparison can fail: one number of one item is changed."""
    assert compile_descriptors(tmp_path, "manipulator", *MISSIONS).returncode == 0
    source = tmp_path / "manipulator_descriptors.c"
    text, count = re.subn(r"(\.subindex = )(\d+)U", lambda match: f"{match[1]}{int(match[2]) + 1}U", source.read_text(), count=1)
    assert count == 1
    source.write_text(text)
    result = subprocess.run([build(library, tmp_path, source), *MISSIONS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 1 and re.search(r": octet \d+ is 0x..", result.stdout), result.stdout


@pytest.mark.parametrize("name, missions, message", [("gripper", MISSIONS, "no mission"), ("arm", ["missing.xml"], "missing.xml")])
def test_a_mission_that_cannot_be_compiled_is_refused(tmp_path, name, missions, message):
    done = compile_descriptors(tmp_path, name, *missions)
    assert done.returncode == 1
    assert message in done.stderr


def test_a_directory_that_is_missing_is_refused_with_the_file_and_the_reason(tmp_path):
    done = compile_descriptors(tmp_path / "missing", "arm", *MISSIONS)
    assert done.returncode == 1
    assert done.stderr.strip().endswith(f"cannot write {tmp_path}/missing/arm_descriptors.c: not found")


def members_of_headers():
    """{structure: {member: its type}} of the models."""
    found = {}
    for header in HEADERS:
        text = re.sub(r"//.*", "", (ROOT / header).read_text())
        for body, structure in re.findall(r"typedef struct \{([^{}]*)\} (\w+);", text):
            members = (re.fullmatch(r"(.*?)[\s*]+(\w+)(?:\[.*\])?", one.strip(), re.DOTALL) for one in body.split(";") if one.strip())
            found[structure] = {member[2]: member[1].removeprefix("const ") for member in members}
    return found


def members_written(text):
    """{structure: names of members} in the tables of the writer."""
    found = {}
    for structure, member in re.findall(r"\b(?:NUMBERS?|REAL|TEXT|NAMES|offsetof)\((\w+_t), ([\w.]+)\)", text):
        found.setdefault(structure, set()).add(member)
    for structure, items in re.findall(r"\bLIST\((\w+_t), \w+, (\w+), \w+\)", text):
        found[structure].add(items)
    return found


def differences(text):
    """Members that the tables of the writer lack or have in excess, as `structure.member`."""
    known, written = members_of_headers(), members_written(text)
    found = set()
    for structure, names in written.items():
        expected = set()
        for member, kind in known[structure].items():
            is_apart = any(name.startswith(f"{member}.") for name in names)
            expected |= {f"{member}.{inner}" for inner in known[kind]} if is_apart else {member}
        expected -= NOT_WRITTEN.get(structure, set())
        found |= {f"{structure}.{member}" for member in expected ^ names}
    return found


def test_each_member_of_a_model_is_written():
    """A member that the writer does not write would be zero on every board; the comparison of items finds it only if a descriptor uses it."""
    text = (ROOT / "launcher/descriptor_members.c").read_text()
    assert len(members_written(text)) > 20
    assert differences(text) == set()
    for line, member in (
        ("    NUMBER(descriptor_event_t, burst),\n", "descriptor_event_t.burst"),
        ("NUMBER(descriptor_endnode_t, format.order),", "descriptor_endnode_t.format.order"),
        ("    LIST(mission_descriptor_t, mission_link_t, links, link_count),\n", "mission_descriptor_t.links"),
    ):
        assert line in text
        assert differences(text.replace(line, "")) == {member}
