# SPDX-License-Identifier: Apache-2.0
"""The mission of a new arm that flies with the subsystems of an existing mission: copies of its mission, world, scenario and bounds, with the lines
of the new arm."""

import pathlib
import re
from dataclasses import dataclass

from new_subsystem import BUSES_MAX, ROOT, SUBSYSTEMS_MAX, Refusal, expect, fill, insert_before, relative
from source import BUS_NAME_MAX

TEMPLATES = pathlib.Path(__file__).resolve().parent / "robot"
BUS = '    <Bus name="{}" bitRate="1000000" dataBitRate="5000000"/>'
STEP = re.compile(r" *([0-9]+(?:\.[0-9]*)?)\s+(\S.*)")
# The figures of docs/arm.md. In a mission with several arms their names begin with the name of the arm.
FIGURE = re.compile(r"(?m)^(?=(?:joint[0-9]+_error_(?:rad|m)|tool_error_m|goal_error_rad|goal_error_m|goal_tool_error_m|joint_(?:range_margin|speed_share|"
                    r"torque_share))\s)")


@dataclass(frozen=True)
class Place:
    """Names of an arm in its world: of the robot, of its buses (without their numbers), and what the names of its drives and of their types begin
    with. `state`: element of the world with the place of the robot."""

    robot: str = "arm"
    bus: str = "arm"
    prefix: str = ""
    state: str = ""


ALONE = Place()


@dataclass(frozen=True)
class Existing:
    """Texts of the files of an existing mission; the scenario and its bounds may be missing."""

    name: str
    mission: str
    world: str
    scenario: str
    bounds: str


def _text(path):
    return path.read_text(encoding="utf-8") if path.exists() else ""


def read(name, gravity):
    """The mission `name`. Its world must have this gravity, with which start pose and descriptor of the new arm are computed."""
    missions = ROOT / "descriptors" / "missions"
    there = ", ".join(sorted(path.stem for path in missions.glob("*.xml")))
    expect((missions / f"{name}.xml").exists(), "WITH", name, f"an existing mission: {there}")
    places = [missions / f"{name}.xml", ROOT / f"descriptors/worlds/{name}.xml", *(ROOT / f"sim/scenarios/{name}{end}" for end in (".scn", ".bounds"))]
    found = Existing(name, *map(_text, places))
    gravities = re.findall(r'<World [^>]*gravity="([^"]*)"', found.world)
    expect(len(gravities) == 1 and list(map(float, gravities[0].split())) == list(gravity), "WITH", name,
           f"a mission whose world has the gravity {' '.join(f'{value:g}' for value in gravity)}, as for this BASE, not {''.join(gravities) or 'none'}")
    if found.mission.count("<Subsystem ") >= SUBSYSTEMS_MAX:
        raise Refusal(f"{relative(places[0])}: has {SUBSYSTEMS_MAX} subsystems, expected fewer: name another mission with WITH=")
    return found


def place_in(existing, file, apid, reach):
    """Names of the arm `file` in the world of a mission, and its place: beside the robots that are there, along y."""
    bus = file if len(file) + 2 <= BUS_NAME_MAX else f"arm{apid}"
    y = round(2.0 * reach, 1) * existing.world.count("<Robot ")
    return Place(file, bus, f"{file.upper().replace('-', '_')}_", f'\n    <State at="0 {y:g} 0"/>')


def _elements(template, pattern):
    """The parts of a template that match."""
    return "".join(found[0] for found in re.finditer(pattern, (TEMPLATES / template).read_text(encoding="utf-8")))


def mission(existing, names, buses):
    """Text of the mission with the arm as one more subsystem."""
    source = ROOT / f"descriptors/missions/{existing.name}.xml"
    if existing.mission.count("<Bus ") + len(buses) > BUSES_MAX:
        raise Refusal(f"{relative(source)}: has {existing.mission.count('<Bus ')} buses, and the arm needs {len(buses)}, expected at most {BUSES_MAX} together")
    text = re.sub(r'(<Mission name=")[^"]*"', rf'\g<1>{names["file"]}"', existing.mission, count=1)
    text = re.sub(r"(?m)^<!-- A mission that flies the arm (\w+) alone. -->\n", rf"<!-- A mission that flies the arms \1 and {names['NAME']}. -->\n", text)
    entry = fill(_elements("mission.xml", r'(?s) *<Subsystem name="@NAME@".*?/>\n'), names)
    permissions = fill(_elements("mission.xml", r'(?m)^ *<Allow .*to="@NAME@".*\n'), names)
    lines = "".join(f"{BUS.format(bus)}\n" for bus in buses)
    text = insert_before(text, r'^ *<Subsystem name="\w+" id="1"', 'a line <Subsystem name=".." id="1"', entry, source)
    text = insert_before(text, r"^ *</Permissions>", "a line </Permissions>", permissions, source)
    if "</Buses>" in text:
        return insert_before(text, r"^ *</Buses>", "a line </Buses>", lines, source)
    return insert_before(text, r"^ *<Transports ", "a line <Transports ..", f"  <Buses>\n{lines}  </Buses>\n", source)


def world(existing, words):
    """Text of the world with the arm as one more robot."""
    source = ROOT / f"descriptors/worlds/{existing.name}.xml"
    text = re.sub(r'(<World name=")[^"]*"', rf'\g<1>{words["file"]}"', existing.world, count=1)
    arm = fill(_elements("world.xml", r"(?s) *<Robot .*(?=</World>)"), words)
    return insert_before(text, r"^</World>", "a line </World>", f"  <!-- The arm {words['NAME']} of {words['urdf']}. -->\n{arm}", source)


def steps(existing, own):
    """The steps of both scenarios in the order of their times, each with its time in its own scenario; one shutdown at the end."""
    lines = [line for text in (existing.scenario, own) for line in text.splitlines() if STEP.fullmatch(line)]
    timed = [(float(STEP.fullmatch(line)[1]), line) for line in lines]
    ends = max((time for time, line in timed if line.split()[1:] == ["operator", "shutdown"]), default=0.0)
    kept = [line for _, line in sorted(timed, key=lambda step: step[0]) if line.split()[1:] not in (["operator", "shutdown"], ["operator", "ping", "all"])]
    return "\n".join([*kept, f"{ends:4.1f}  operator shutdown"])


def bounds(existing, own, file):
    """The bounds of both scenarios, each figure of an arm with the name of its arm."""
    arms = re.findall(r'<Subsystem name="(\w+)"[^>]*executable="arm"', existing.mission)
    lines = "".join(f"{line}\n" for line in existing.bounds.splitlines() if line.partition("#")[0].strip())
    there = FIGURE.sub(f"{arms[0].lower()}.", lines) if len(arms) == 1 else lines
    return there + FIGURE.sub(f"{file.replace('-', '_')}.", own)
