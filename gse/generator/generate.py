#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generate C names and layouts, dictionaries and XTCE databases for the ground, and CAN databases from descriptors and catalogue.

    python3 gse/generator/generate.py --mission descriptors/missions/*.xml --out build/generated

Several missions may use the descriptor of a subsystem; one header is generated for it.

Needs only Python's standard library. If xmllint is installed, the files are also checked against their XML schemas.
A file is only written if its content changes. An error message gives file:line, the value and what is expected; the exit status is 1.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
from xml.parsers import expat

import catalogue
import common_words
import dbc
import descriptions
import device_class
import dissector
import mission as mission_descriptor
import xtce
import yamcs_displays
import services
from c_header import header
from ground_dictionary import dictionary
from sheet import SheetError
from source import DescriptorError

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMAS = ROOT / "descriptors" / "schema"
CATALOGUE = ROOT / "pus" / "catalogue"


def validate(path, schema):
    """Check a file against a schema with xmllint. No effect if xmllint is not installed."""
    if not shutil.which("xmllint"):
        return
    command = ["xmllint", "--noout", "--nonet", "--schema", str(SCHEMAS / schema), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        line = done.stderr.strip().splitlines()[0] if done.stderr.strip() else "xmllint failed"
        raise SystemExit(line if str(path) in line else f"{path}: {line}")


BUSES_MAX = 8  # Maximum in the simulator.


def check_world(path):
    """Check a world against its schema, and its name; the simulator checks the rest when it reads the file. Returns its buses."""
    validate(path, "world.xsd")
    parser = expat.ParserCreate()
    buses = set()

    def start(name, attributes):
        buses.update({attributes["bus"]} if "bus" in attributes else ())
        if name == "World" and attributes.get("name") != path.stem:
            found = attributes.get("name")
            raise DescriptorError(path, parser.CurrentLineNumber, f'name="{found}" of <World>: expected {path.stem}, as the file is named')

    parser.StartElementHandler = start
    try:
        parser.Parse(path.read_bytes(), True)
    except expat.ExpatError as error:  # If xmllint is not installed, nothing has checked the syntax before.
        raise DescriptorError(path, error.lineno, f"not well-formed: {expat.ErrorString(error.code)}") from error
    return buses


def check_buses(loaded, world, buses):
    """Refuse a mission that, together with its world, has more than BUSES_MAX buses. The error names the first bus
    beyond this number."""
    listed = loaded.element.first("Buses")
    for bus in listed.children if listed else ():
        buses = buses | {bus.attributes["name"]}
        if len(buses) > BUSES_MAX:
            bus.wrong("name", f"at most {BUSES_MAX} buses together with those of {world}")


def write(path, text):
    """Write a file if its content differs; the new file replaces the old one when it is complete."""
    if path.exists() and path.read_bytes() == text.encode("utf-8"):
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.{os.getpid()}")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def generate(path, out, described, messages, failures):
    """Generate the files of one mission. `described` keeps the path of each subsystem's descriptor; `failures` has the names of failure codes by number."""
    loaded = mission_descriptor.load(path)
    validate(path, "mission.xsd")
    world = path.parent.parent / "worlds" / path.name
    if world.exists():  # A mission without a world flies with real devices only.
        check_buses(loaded, world, check_world(world))
    if loaded.name != path.stem:
        loaded.element.wrong("name", f"{path.stem}, as the file is named")
    for listed, subsystem in loaded.subsystems:
        source = pathlib.Path(subsystem.element.path)
        known = described.setdefault(subsystem.name, source)
        if known != source:
            listed.wrong("descriptor", f"the descriptor that {subsystem.name} has in other missions, {known}")
        validate(source, "subsystem.xsd")
        write(out / f"{subsystem.name.lower()}_descriptor.h", header(subsystem, source.name))
        write(out / f"{subsystem.name.lower()}_services.h", services.header(subsystem, source.name))
    content = descriptions.describe(dictionary(loaded), descriptions.load()) | {"catalogue": messages}
    write(out / f"{loaded.name}.json", json.dumps(content, indent=1) + "\n")
    text, events = xtce.database(content, failures)
    write(out / f"{loaded.name}.xtce.xml", text)
    write(out / f"{loaded.name}.lua", dissector.script(content))
    made_for = {"interface_hash": content["interface_hash"]}  # Yamcs ignores members that it does not know.
    write(out / f"{loaded.name}.events.json", json.dumps([row | made_for for row in events], indent=1) + "\n")
    for directory, files in (("displays", yamcs_displays.displays(content)), ("stacks", yamcs_displays.stacks(content))):
        for name, one in files.items():
            write(out / "yamcs" / loaded.name / directory / name, json.dumps(one | made_for, indent=1) + "\n")
    for bus, text in dbc.databases(loaded).items():
        write(out / f"{loaded.name}-{bus}.dbc", text)


def generate_messages(out, failures):
    """Generate the formats of all requests, the words of all failures and the titles of all messages. Returns the catalogue of messages for the ground."""
    known, services = catalogue.load(CATALOGUE)
    words = catalogue.failures(CATALOGUE / "failures.txt", failures)
    write(out / "pus/failure_words.h", catalogue.failures_header(words))
    for number, service in services.items():
        write(out / f"pus/st{number:02}_request_formats.h", catalogue.formats_header(number, service, known))
    own_kinds, own_services = catalogue.private(CATALOGUE)
    write(out / "pus/message_titles.h", catalogue.titles_header(services, own_services))
    ground = catalogue.ground(known, services) | {"private": catalogue.ground(own_kinds, own_services)}
    return ground | {"failures": {number: [what, detail] for number, _, what, detail in words}}


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mission", required=True, nargs="+", type=pathlib.Path, help="mission descriptors")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="directory to write into")
    options = parser.parse_args(arguments)
    described = {}
    try:
        failures = common_words.failure_names()
        messages = generate_messages(options.out, failures)
        write(options.out / "device_classes.h", device_class.header())
        for path in options.mission:
            generate(path, options.out, described, messages, failures)
        for world in sorted({found for path in options.mission for found in path.parent.parent.glob("worlds/*.xml")}):
            check_world(world)  # Includes worlds that do not have the name of a mission.
    except (DescriptorError, SheetError) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
