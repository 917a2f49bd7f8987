# SPDX-License-Identifier: Apache-2.0
"""Check that the simulator's sources name nothing of a world: no mission, robot, joint, bus, device, data sheet or node id.

Names are those of all descriptors/worlds/*.xml and of the robots there. Mission names are refused anywhere in a source, the
others as text constants, node ids as numbers. Prints each breach and each exemption that nothing needs any more; exit code 1."""

import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
TEXT = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
# Words of a format or of the command line that are also names; entries are only removed.
EXEMPT = {
    ("sim/world/urdf.c", "robot"): "element of URDF",
    ("sim/world/world.c", "joystick"): "attribute of Hand",
    ("sim/devices/axis.c", "0x21"): "bits of a statusword",
    ("sim/app/simulator_main.c", "classic"): "option: bit rate of classic CAN",
    ("sim/app/usage.c", "classic"): "option: bit rate of classic CAN",
    ("sim/truth/truth.c", "STICK"): "channel of the log",
}
COMMON = {"classic"}  # Names of missions that are also words of the sources: refused only as text constants.

WORDS = {"base", "lower", "upper"}  # Names of links that are also words of the formats.


def names_of(directory):
    """Names of missions, text constants and node ids of the worlds in a directory."""
    missions, texts, nodes = set(), set(), set()
    for path in sorted(directory.glob("*.xml")):
        missions.add(path.stem)
        for element in ElementTree.parse(path).getroot().iter():
            texts |= {element.get(key) for key in ("bus", "eds", "urdf", "name") if element.get(key)}
            nodes |= {int(element.get("node"), 0)} if element.get("node") else set()
            if element.tag == "Robot":
                parts = ElementTree.parse(directory / element.get("urdf")).getroot()
                texts |= {part.get("name") for tag in ("joint", "link") for part in parts.iter(tag) if part.get("name")} - WORDS
    return missions, texts | missions, nodes


def findings(source, missions, texts, nodes):
    """(line, name) of each name of a world in a source."""
    for mission in missions - COMMON:
        yield from ((found.start(), mission) for found in re.finditer(rf"(?<![A-Za-z]){mission}(?![A-Za-z])", source))
    code = COMMENT.sub(lambda found: " " * len(found[0]), source)
    for found in TEXT.finditer(code):
        parts = re.split(r"[/=: ]", found[1])
        yield from ((found.start(), name) for name in texts if name in parts and (name == found[1] or "/" in found[1] or "=" in found[1]))
    for found in re.finditer(r"\b0[xX][0-9A-Fa-f]{1,2}(?=[uUlL]*\b)", code):  # Numbers of CiA 301 have four digits.
        if int(found[0], 16) in nodes:
            yield found.start(), found[0]


def breaches(root, exempt):
    """Breaches of all sources, then exemptions that no source uses."""
    missions, texts, nodes = names_of(root / "descriptors" / "worlds")
    used = set()
    for path in sorted([*(root / "sim").rglob("*.c"), *(root / "sim").rglob("*.h")]):
        name, source = path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")
        for place, word in sorted(set(findings(source, missions, texts, nodes))):
            if (name, word) in exempt:
                used.add((name, word))
            else:
                yield f"{name}:{source.count(chr(10), 0, place) + 1}: '{word}' is a name of a world: take it from there"
    yield from (f"{name}: exemption '{word}' of check_worlds.py is not needed: remove it" for name, word in sorted(set(exempt) - used))


def main():
    found = list(breaches(ROOT, EXEMPT))
    print("\n".join(found) or "check: the simulator names nothing of a world")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
