# SPDX-License-Identifier: Apache-2.0
"""Descriptors that are compiled into the programs of a board, against the reader of descriptors on the same files."""

import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MISSIONS = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "descriptors/missions").glob("*.xml"))
SOURCES = ("fsw/framework/descriptor/*.c", "fsw/framework/xml/*.c", "base/*.c", "osal/posix/*.c", "osal/common/*.c")
FLAGS = "-std=c99 -D_POSIX_C_SOURCE=200809L -Wall -Wextra -Werror -O1 -I. -Ibuild"
PROGRAMS = ("actuators", "arm", "instruments", "joystick", "manipulator")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The reader, compiled once: object files."""
    folder = tmp_path_factory.mktemp("reader")
    files = [str(path) for pattern in SOURCES for path in sorted(ROOT.glob(pattern))]
    subprocess.run(["gcc", *FLAGS.split(), f"-I{ROOT}", "-c", *files, str(ROOT / "launcher/descriptor_members.c")], cwd=folder, check=True)
    return folder


def build(library, folder, source):
    """The probe of one generated source."""
    command = ["gcc", *FLAGS.split(), f'-DCOMPILED="{source}"', "-o", str(folder / "probe"), "test/conformance/compiled_probe.c"]
    subprocess.run([*command, *map(str, sorted(library.glob("*.o"))), "-lexpat", "-lpthread"], cwd=ROOT, check=True)
    return folder / "probe"


def compile_descriptors(folder, name, *missions):
    return subprocess.run([ROOT / "build/bin/descriptor-compiler", str(folder), name, name, *missions], cwd=ROOT, capture_output=True,
                          text=True, check=False)


@pytest.mark.parametrize("name", PROGRAMS)
def test_compiled_models_are_those_of_the_reader(library, tmp_path, name):
    done = compile_descriptors(tmp_path, name, *MISSIONS)
    assert done.returncode == 0, done.stderr
    expected = sum((ROOT / path).read_text().count(f'executable="{name}"') for path in MISSIONS)
    probe = build(library, tmp_path, tmp_path / f"{name}_descriptors.c")
    told = subprocess.run([probe, *MISSIONS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout
    found, entries, items = map(int, told.stdout.split())
    assert found == entries == expected > 0
    assert items > 50


def test_a_changed_constant_is_found(library, tmp_path):
    """The comparison can fail: one number of one item is another one."""
    assert compile_descriptors(tmp_path, "manipulator", *MISSIONS).returncode == 0
    source = tmp_path / "manipulator_descriptors.c"
    text, count = re.subn(r"(\.subindex = )(\d+)U", lambda match: f"{match[1]}{int(match[2]) + 1}U", source.read_text(), count=1)
    assert count == 1
    source.write_text(text)
    told = subprocess.run([build(library, tmp_path, source), *MISSIONS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert told.returncode == 1 and "differs" in told.stdout


@pytest.mark.parametrize("name, missions, told", [("gripper", MISSIONS, "no mission"), ("arm", ["missing.xml"], "missing.xml")])
def test_what_cannot_be_compiled_is_refused(tmp_path, name, missions, told):
    done = compile_descriptors(tmp_path, name, *missions)
    assert done.returncode == 1
    assert told in done.stderr
