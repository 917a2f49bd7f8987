#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Create a new subsystem: descriptor, C sources, test, scenario, and its entries in a mission and its world. It can fly without changes.

    make new-subsystem NAME=gripper                  a mission of that name: rokviss with the new subsystem
    make new-subsystem NAME=lamp MISSION=gripper     in an existing mission
    make new-subsystem NAME=lamp APID=40             with this APID instead of the first free one

It writes new files, and changes no existing file except by lines that it inserts into an existing mission and its world. On an error it
changes nothing.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEMPLATES = pathlib.Path(__file__).resolve().parent / "template"
sys.path.insert(0, str(ROOT / "gse" / "generator"))

import mission as mission_descriptor
from c_header import KEYWORDS
from source import BUS_NAME_MAX, DescriptorError

BASE_MISSION = "rokviss"
FIRST_APID, LAST_APID = 18, 2046
NAME_MAX = 24
SUBSYSTEMS_MAX = 16  # Subsystems of a mission (base/capacities.h).
BUSES_MAX = 8  # Buses of a mission (base/capacities.h).
RESERVED = KEYWORDS | {"operator", "simulator", "image", "hirosco", "pusdump", "packet_archive_sqlite", "self", "network"}
STANDARD_TYPES = re.compile(r"u?int(ptr|max|(_least|_fast)?(8|16|32|64))|s?size|ptrdiff|wchar")  # Followed by _t.
# Endings of the names that the new sources and the generated header derive from the name of the subsystem.
NAMED_AFTER = "t init callbacks open parameters_t program_t services_t add_services definitions fields offsets".split()
MACROS_AFTER = "NAME APID INTERFACE_HASH PARAMETER_COUNT FIELD_COUNT".split()

ENTRY = """    <Subsystem name="@NAME@" id="@apid@" executable="@executable@" descriptor="../subsystems/@file@.xml"
               memoryKiB="12288" restarts="2" node="2"/>
"""
PERMISSIONS = """    <!-- @NAME@ -->
    <Allow tc="129,3" select="NOMINAL" to="@NAME@" modes="SAFE NOMINAL" states="PRE_OPERATIONAL"/>
    <Allow tc="8,1" select="STOP" to="@NAME@" modes="SAFE NOMINAL" states="OPERATIONAL"/>
    <Allow tc="8,1" select="MOVE" to="@NAME@" modes="NOMINAL" states="OPERATIONAL"/>
    <Allow tc="20,3" to="@NAME@" modes="NOMINAL" states="PRE_OPERATIONAL SAFE_OPERATIONAL OPERATIONAL"/>
"""


BUS = """    <Bus name="@bus@" bitRate="1000000" dataBitRate="5000000"/>
"""
DEVICES = """  <!-- The motor and the probe of @NAME@. -->
  <Bench name="@NAME@_MOTOR" type="light" bus="@bus@" node="0x31" eds="joint-drive.eds" contact="1.5" stiffness="400" range="1.5708"/>
  <Instrument name="@NAME@_PROBE" type="SERIAL" channel="/dev/tty-@file@" framing="SLIP" checksum="true" period="5ms" value="INT32" scale="1e-6"
              speed="2"/>
"""


class Refusal(Exception):
    """An impossible request of the user: value found, value expected."""


def expect(condition, option, value, expected):
    """Refuse unless the condition holds."""
    if not condition:
        raise Refusal(f"{option}={value}: expected {expected}")


def relative(path):
    """Path relative to the project's directory, for messages."""
    return str(path.relative_to(ROOT))


def taken_apids():
    """Dict APID -> "NAME in file:line" of all subsystem descriptors."""
    taken = {}
    for path in sorted((ROOT / "descriptors" / "subsystems").glob("*.xml")):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = re.search(r'<Subsystem name="(\w+)" id="(\w+)"', line)
            if found:
                taken[int(found[2], 0)] = f"{found[1]} in {relative(path)}:{number}"
    return taken


def choose_apid(wanted):
    """The requested APID, or the first free one."""
    taken = taken_apids()
    free = next((apid for apid in range(FIRST_APID, LAST_APID + 1) if apid not in taken), None)
    if wanted is None:
        expect(free, "APID", "", "a free APID, but all are taken")
        return free
    expect(re.fullmatch(r"[0-9]{1,4}", wanted) and 1 <= int(wanted) <= LAST_APID, "APID", wanted, f"a number from 1 to {LAST_APID}")
    expect(int(wanted) not in taken, "APID", wanted, f"one that is free, like {free}; this is {taken.get(int(wanted))}")
    return int(wanted)


def check_name(name):
    """Refuse a name that is not valid in C, in XML or for a program."""
    expect(
        re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name) and 2 <= len(name) <= NAME_MAX,
        "NAME",
        name,
        f"2 to {NAME_MAX} lower-case letters, digits and single _, a letter first, like gripper or star_tracker",
    )
    expect(name not in RESERVED, "NAME", name, "a name that is neither a keyword of C nor a program of the project")


def check_names_of_c(name):
    """Refuse a name whose types and functions exist in the project: the new ones would clash, or the wrong ones would be used without a warning."""
    expect(not STANDARD_TYPES.fullmatch(name), "NAME", name, f"a name that is not a type of C: {name}_t is one")
    clash = re.compile(rf"\b({name}_({'|'.join(NAMED_AFTER)})|{name.upper()}_({'|'.join(MACROS_AFTER)}))\b")
    sources = [path for layer in ("base", "osal", "pus", "fsw", "launcher") for path in (ROOT / layer).rglob("*.[ch]")]
    for path in sorted(sources, key=lambda path: (path.suffix != ".h", path)):  # Headers first: they contain the declaration.
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = clash.search(line)
            expect(not found, "NAME", name, f"another name: {found and found[0]} is declared already, in {relative(path)}:{number}")


def plan_files(names):
    """Dict path -> text of the new files."""
    name = names["name"]
    directory = f"fsw/subsystems/{name}"
    templates = {
        f"descriptors/subsystems/{names['file']}.xml": "descriptor.xml",
        f"{directory}/{name}.h": "subsystem.h",
        f"{directory}/{name}.c": "subsystem.c",
        f"fsw/programs/{name}_program.c": "program.c",
        f"fsw/programs/{name}_main.c": "main.c",
        f"test/unit/{directory}/test_{name}.c": "test_subsystem.c",
        f"test/unit/{directory}/subsystem_double.c": "subsystem_double.c",
        f"sim/scenarios/{names['file']}.scn": "scenario.scn",
    }
    return {ROOT / path: fill((TEMPLATES / template).read_text(encoding="utf-8"), names) for path, template in templates.items()}


def fill(text, names):
    """A template with its words replaced."""
    return re.sub(r"@(\w+)@", lambda found: names[found[1]], text)


def insert_before(text, pattern, what, addition, path):
    """The text with `addition` inserted before the first line that matches."""
    found = re.search(pattern, text, re.MULTILINE)
    if not found:
        raise Refusal(f"{relative(path)}: expected {what}, to insert the new lines before it")
    return text[: found.start()] + addition + text[found.start() :]


def with_bus(text, names, source):
    """The mission with a bus for the motor; a mission without buses gets the list."""
    if text.count("<Bus ") >= BUSES_MAX:
        raise Refusal(f"{relative(source)}: has {BUSES_MAX} buses, expected fewer, because the new subsystem needs one of its own: name another "
                      "mission with MISSION=")
    bus = fill(BUS, names)
    if "</Buses>" in text:
        return insert_before(text, r"^ *</Buses>", "a line </Buses>", bus, source)
    return insert_before(text, r"^ *<Transports ", "a line <Transports ..", f"  <Buses>\n{bus}  </Buses>\n", source)


def plan_world(names, mission_path, is_new):
    """(path, text) of the mission's world with the devices of the new subsystem. A new mission has the world of the base mission."""
    worlds = ROOT / "descriptors" / "worlds"
    path = worlds / mission_path.name
    source = worlds / f"{BASE_MISSION}.xml" if is_new else path
    if not source.exists():
        raise Refusal(f"{relative(source)}: expected the world of the mission, for the devices of the new subsystem")
    text = source.read_text(encoding="utf-8")
    if is_new:
        text = re.sub(r'(<World name=")[^"]*"', rf'\g<1>{mission_path.stem}"', text, count=1)
    devices = fill(DEVICES, names)
    if '<DriveType name="light"' not in text:
        base = (worlds / f"{BASE_MISSION}.xml").read_text(encoding="utf-8")
        devices = re.search(r'^ *<DriveType name="light".*?</DriveType>\n', base, re.MULTILINE | re.DOTALL)[0] + devices
    return path, insert_before(text, r"^</World>", "a line </World>", devices, source)


def plan_mission(names, wanted):
    """(path, text, mission's name, whether it is new) of the mission with the new subsystem."""
    missions = ROOT / "descriptors" / "missions"
    there = sorted(path.stem for path in missions.glob("*.xml"))
    name = wanted or names["file"]
    source = missions / f"{wanted or BASE_MISSION}.xml"
    expect(source.exists(), "MISSION", wanted, f"an existing mission: {', '.join(there)}")
    text = source.read_text(encoding="utf-8")
    if text.count("<Subsystem ") >= SUBSYSTEMS_MAX:
        raise Refusal(f"{relative(source)}: has {SUBSYSTEMS_MAX} subsystems, expected fewer: name another mission with MISSION=")
    if not wanted:
        text = re.sub(r'(<Mission name=")[^"]*"', rf'\g<1>{name}"', text, count=1)
    supervisor = r'^ *<Subsystem name="\w+" id="1"'
    text = insert_before(text, supervisor, 'a line <Subsystem name=".." id="1"', fill(ENTRY, names), source)
    text = insert_before(text, r"^ *</Permissions>", "a line </Permissions>", fill(PERMISSIONS, names), source)
    text = with_bus(text, names, source)
    return missions / f"{name}.xml", text, name, not wanted


def write_all(files, mission_path, check=None):
    """Write the files, call `check`, which may raise a Refusal, and read the mission as the build does; on any error restore the earlier
    state. `check` is first, because its refusal names a file of the user, and not one that is removed."""
    old = {path: path.read_text(encoding="utf-8") for path in files if path.exists()}
    made = []
    try:
        for path, text in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            made.append(path)
            path.write_text(text, encoding="utf-8")
        if check:
            check()
        mission_descriptor.load(mission_path)
    except (OSError, DescriptorError, Refusal) as error:
        for path in made:
            if path in old:
                path.write_text(old[path], encoding="utf-8")
            else:
                path.unlink(missing_ok=True)
        raise Refusal(f"{error}; nothing was changed") from error


def format_sources(files):
    """Format the sources with clang-format, if it is installed, because the format depends on the length of the name."""
    sources = [str(path) for path in files if path.suffix in (".c", ".h")]
    if shutil.which("clang-format"):
        subprocess.run(["clang-format", "-i", *sources], check=True)


def begin(name, apid, mission):
    """Create a new subsystem; returns the lines for the user."""
    check_name(name)
    file = name.replace("_", "-")
    number = choose_apid(apid)
    names = {"name": name, "NAME": name.upper(), "apid": str(number), "executable": file, "file": file}
    names["bus"] = file if len(file) <= BUS_NAME_MAX else f"can-{number}"
    files = plan_files(names)
    mission_path, text, mission_name, is_new = plan_mission(names, mission)
    there = [relative(path) for path in (*files, *([mission_path] if is_new else [])) if path.exists()]
    more = f" and {len(there) - 1} more" if len(there) > 1 else ""
    expect(not there, "NAME", name, f"a name that is new; there is already {''.join(there[:1])}{more}")
    check_names_of_c(name)
    world_path, world = plan_world(names, mission_path, is_new)
    files |= {mission_path: text, world_path: world}
    inserted = set() if is_new else {mission_path, world_path}
    write_all(files, mission_path)
    format_sources(files)
    made = "\n".join(f"  {relative(path)}" + ("  (lines inserted)" if path in inserted else "") for path in files)
    return (
        f"{name.upper()}, APID {number}, in mission {mission_name}:\n{made}\n"
        f"Next:\n  make sim-run MISSION={mission_name} SCENARIO={file}\n  make test ONLY={name}\n"
        "  docs/tutorial.md shows the next steps"
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="make new-subsystem", description=__doc__.splitlines()[0])
    parser.add_argument("--name")
    parser.add_argument("--apid")
    parser.add_argument("--mission")
    options = parser.parse_args(arguments)
    try:
        expect(options.name, "NAME", "", "a name: make new-subsystem NAME=gripper")
        print(begin(options.name, options.apid, options.mission))
    except Refusal as refusal:
        print(f"new-subsystem: {refusal}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
