# SPDX-License-Identifier: Apache-2.0
"""Compares every file that the generator makes of the mission `actuators` with test/conformance/golden.

From a long file the golden contains only the part of the subsystem ACTUATORS, and from an XTCE database also an outline of the rest. Hashes of the mission
and of its other subsystems are words in it, so that it does not change with every descriptor. UPDATE_GOLDEN=1 writes the files again:

    UPDATE_GOLDEN=1 build/venv/bin/python -m pytest -p no:cacheprovider --rootdir=. test/conformance/test_golden.py
"""

import difflib
import json
import os
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GOLDEN = pathlib.Path(__file__).parent / "golden"
MISSION, SUBSYSTEM, APID, BUS = "actuators", "ACTUATORS", 41, "platform"
XTCE = "{http://www.omg.org/spec/XTCE/20180204}"
OUTLINED = ("ParameterType", "Parameter", "SequenceContainer", "MetaCommand")

SECTION = """import json, sys
import icd
content = json.load(sys.stdin)
sizes = {name: item["size"] for name, item in content["types"].items()}
print(icd.subsystem_section(next(one for one in content["subsystems"] if one["name"] == sys.argv[1]), sizes), end="")
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Content of each file of the mission by name."""
    out = tmp_path_factory.mktemp("made")
    mission = ROOT / "descriptors" / "missions" / f"{MISSION}.xml"
    subprocess.run([sys.executable, ROOT / "gse/generator/generate.py", "--mission", mission, "--out", out], check=True)
    found = {path.relative_to(out).as_posix(): path.read_text(encoding="utf-8") for path in out.rglob("*") if path.is_file()}
    content = json.loads(found[f"{MISSION}.json"])
    names = ("interface_hash", "configuration_hash", "device_classes_hash")
    hashes = {content[name][2:]: name for name in names}
    for subsystem in content["subsystems"]:
        if subsystem["name"] != SUBSYSTEM:
            hashes |= {subsystem[name][2:]: f"{subsystem['name']}.{name}" for name in names if name in subsystem}
    for number, name in hashes.items():
        found = {file: text.replace(number, name) for file, text in found.items()}
    return found


def pretty(content):
    return json.dumps(content, indent=1) + "\n"


def own(rows, key):
    return [row for row in rows if row[key] == SUBSYSTEM]


def of_dictionary(text):
    """All but the catalogue of messages and the other subsystems."""
    content = json.loads(text)
    del content["catalogue"]
    return pretty(content | {"subsystems": own(content["subsystems"], "name")})


def of_database(text):
    """The space system of the subsystem, and the number of elements of each kind in each space system."""
    tree = ET.fromstring(text)
    lines = [f"<!-- {tree.get('shortDescription')} -->"]
    for system in tree.iter(f"{XTCE}SpaceSystem"):
        counts = [sum(part.tag.endswith(tag) if tag == "ParameterType" else part.tag == XTCE + tag
                      for each in system if each.tag != f"{XTCE}SpaceSystem" for part in each.iter()) for tag in OUTLINED]
        lines.append(f"<!-- {system.get('name')}: " + ", ".join(f"{count} {tag}" for tag, count in zip(OUTLINED, counts)) + " -->")
    found = next(system for system in tree.iter(f"{XTCE}SpaceSystem") if system.get("name") == SUBSYSTEM)
    for part in found.iter():
        part.tag = part.tag.removeprefix(XTCE)
    return "\n".join([*lines, ET.tostring(found, encoding="unicode").strip()]) + "\n"


def of_events(text):
    return pretty([row for row in json.loads(text) if row["eventId"].endswith(f"-{APID}")])


def of_dissector(text):
    """The head, the values with words, the fields of the subsystem, and the layouts of its messages."""
    fields = text.index("local FIELDS = {")
    own_parts = [line for line in text[fields:].splitlines() if MISSION in line.lower() or line.startswith(f"  [{APID}] = ")]
    return text[: text.index("local WORDS = {")] + "\n".join(own_parts) + "\n"


def of_pages(text):
    """The section of the subsystem in the interface control document, a row of a table in each line."""
    paths = os.pathsep.join(str(ROOT / "gse" / part) for part in ("docs", "generator"))
    command = ["/usr/bin/python3", "-c", SECTION, SUBSYSTEM]  # This Python has the packages for documents.
    section = subprocess.run(command, input=text, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=True).stdout
    return re.sub(r"(</tr>|</h[1-6]>|</table>|</p>)", r"\1\n", section)


# Golden -> file of the generator, and the function that extracts the compared part.
KEPT = {
    "dictionary.json": (f"{MISSION}.json", of_dictionary),
    "database.xtce.xml": (f"{MISSION}.xtce.xml", of_database),
    "events.json": (f"{MISSION}.events.json", of_events),
    "dissector.lua": (f"{MISSION}.lua", of_dissector),
    "bus.dbc": (f"{MISSION}-{BUS}.dbc", str),
    "descriptor.h": (f"{MISSION}_descriptor.h", str),
    "services.h": (f"{MISSION}_services.h", str),
    "display.par": (f"yamcs/{MISSION}/displays/{SUBSYSTEM}.par", str),
    "stack.ycs": (f"yamcs/{MISSION}/stacks/{SUBSYSTEM}-NOMINAL.ycs", str),
    "icd.html": (f"{MISSION}.json", of_pages),
}


@pytest.mark.parametrize("golden", KEPT)
def test_a_generated_file_is_as_before(made, golden):
    name, kept = KEPT[golden]
    text = kept(made[name])
    path = GOLDEN / f"{golden}.golden"
    if os.environ.get("UPDATE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    before = path.read_text(encoding="utf-8")
    changes = list(difflib.unified_diff(before.splitlines(), text.splitlines(), golden, name, lineterm="", n=1))
    assert not changes, "\n".join([*changes[:40], "if this is intended: see the head of this file"])


def test_every_kind_of_generated_file_has_a_golden(made):
    """Except the tables of device classes and of the catalogue, which belong to no mission, and other subsystems' files of these kinds."""
    kind = re.compile(r"(\.xtce\.xml|\.events\.json|_descriptor\.h|_services\.h|\.\w+)$")
    kinds = {kind.search(name)[1] for name in made if not name.startswith("pus/") and name != "device_classes.h"}
    assert kinds == {kind.search(name)[1] for name, _ in KEPT.values()}
