# SPDX-License-Identifier: Apache-2.0
"""Our XTCE databases in the part of XTCE that space_packet_parser supports: one space system, no arrays, no
aggregates.

Names become whole paths; members and elements of a fixed number become parameters of their own, PATH.MEMBER
and PATH[0]. A container ends before its first entry whose number, presence or type varies."""

import xml.etree.ElementTree as ET

from space_packet_parser.xtce.definitions import XtcePacketDefinition

SPACE = "{http://www.omg.org/spec/XTCE/20180204}"
ROOT_CONTAINER = "ccsds"
# Enumerations that may have numbers without a label, which the library refuses.
OPEN = ("application_process", "apid", "failure_code", "parameter_id")


def _tag(element):
    return element.tag.removeprefix(SPACE)


class Flattened:
    """A database in the supported form."""

    def __init__(self, path):
        tree = ET.parse(path).getroot()
        self.types, self.parameters, self.made = {}, {}, {}
        self.containers, self.whole = [], set()
        self.root = f"/{tree.get('name')}/{ROOT_CONTAINER}"
        self._collect(tree, "")
        for container, own in self.containers:
            self._cut(container, own)

    def _collect(self, system, above):
        here = f"{above}/{system.get('name')}"
        for tag, table in (("ParameterTypeSet", self.types), ("ParameterSet", self.parameters)):
            for one in system.findall(f"{SPACE}TelemetryMetaData/{SPACE}{tag}/*"):
                one.set("name", f"{here}/{one.get('name')}")
                table[one.get("name")] = one
        for container in system.findall(f"{SPACE}TelemetryMetaData/{SPACE}ContainerSet/*"):
            container.set("name", f"{here}/{container.get('name')}")
            self.containers.append((container, container.find(f"{SPACE}EntryList")))
        for child in system.findall(f"{SPACE}SpaceSystem"):
            self._collect(child, here)

    def _cut(self, container, entries):
        listed, is_whole = list(entries), True
        for entry in listed:
            entries.remove(entry)
        for entry in listed:
            path = entry.get("parameterRef")
            names = self._expand(path, self.parameters[path].get("parameterTypeRef")) if path and len(entry) == 0 else None
            if names is None:
                is_whole = False
                break
            entries.extend(ET.Element(f"{SPACE}ParameterRefEntry", parameterRef=name) for name in names)
        if is_whole:
            self.whole.add(container.get("name"))

    def _expand(self, name, type_name):
        """Names of the scalar parameters of a parameter; None if their number is not fixed."""
        made = self.types[type_name]
        if _tag(made) == "AggregateParameterType":
            parts = [(f"{name}.{one.get('name')}", one.get("typeRef")) for one in made.find(f"{SPACE}MemberList")]
        elif _tag(made) == "ArrayParameterType":
            last = made.find(f".//{SPACE}EndingIndex/{SPACE}FixedValue")
            if last is None:
                return None
            parts = [(f"{name}[{index}]", made.get("arrayTypeRef")) for index in range(int(last.text) + 1)]
        else:
            self.made[name] = type_name
            return [name]
        found = [self._expand(part, kind) for part, kind in parts]
        return None if None in found else sum(found, [])

    def _plain(self, made):
        """A type in a form that the library accepts: no end mark in a fixed size, and no label needed for a
        number."""
        for holder in made.iter():
            for child in list(holder):
                if _tag(child) == "TerminationChar":
                    holder.remove(child)
        name = made.get("name").rpartition("/")[2]
        if name in OPEN or name.startswith("words_"):
            plain = ET.Element(f"{SPACE}IntegerParameterType", name=made.get("name"))
            plain.append(made.find(f"{SPACE}IntegerDataEncoding"))
            return plain
        return made

    def definition(self, directory):
        """The library's definition, loaded from a file that is written into the directory."""
        system, telemetry = ET.Element(f"{SPACE}SpaceSystem", name="flat"), ET.Element(f"{SPACE}TelemetryMetaData")
        types, parameters, containers = (ET.Element(f"{SPACE}{tag}") for tag in ("ParameterTypeSet", "ParameterSet", "ContainerSet"))
        for name in sorted(set(self.made.values())):
            types.append(self._plain(self.types[name]))
        for name, kind in self.made.items():
            parameters.append(ET.Element(f"{SPACE}Parameter", name=name, parameterTypeRef=kind))
        containers.extend(container for container, _ in self.containers)
        telemetry.extend((types, parameters, containers))
        system.append(telemetry)
        ET.register_namespace("", SPACE.strip("{}"))
        path = directory / "flat.xml"
        ET.ElementTree(system).write(path, encoding="utf-8", xml_declaration=True)
        return XtcePacketDefinition.from_xtce(path, root_container_name=self.root)
