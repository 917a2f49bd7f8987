# SPDX-License-Identifier: Apache-2.0
"""Electronic data sheets of devices (CiA 306): objects with their names, types and defaults."""

import configparser
import pathlib
import re
from dataclasses import dataclass

from source import DescriptorError

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "descriptors" / "devices"
# Device class of a descriptor -> sheet. The flight side's table of classes is fsw/canopen/device_profile.c.
CLASSES = {"cia402-drive": "joint-drive.eds", "joystick": "joystick.eds"}
SECTION = re.compile(r"([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2}))?\Z")
TERM = re.compile(r"(?:\$NODEID\s*\+\s*)?(-?(?:0x[0-9A-Fa-f]+|[0-9]+))\Z", re.IGNORECASE)
# Data type of CiA 301 -> bits, signed. Process data contain no others.
INTEGERS = {1: (1, False), 2: (8, True), 3: (16, True), 4: (32, True), 5: (8, False), 6: (16, False), 7: (32, False),
            0x15: (64, True), 0x1B: (64, False)}


@dataclass
class Entry:
    """One object or member of an object."""

    name: str
    kind: int
    default: str

    def value(self, node):
        """Default as a number; $NODEID is the node id. None if it is not a number."""
        match = TERM.match(self.default.strip())
        if not match:
            return None
        return int(match[1], 0) + (node if "$NODEID" in self.default.upper() else 0)


@dataclass
class Sheet:
    """A device: its name and its objects by (index, subindex)."""

    path: pathlib.Path
    entries: dict

    def defaults(self, node):
        """{(index, subindex): number} of a device with this node id."""
        values = {key: entry.value(node) for key, entry in self.entries.items()}
        return {key: value for key, value in values.items() if value is not None}


def load(path):
    """Sheet of a file. Raises DescriptorError."""
    reader = configparser.ConfigParser(interpolation=None, comment_prefixes=(";",), strict=True)
    try:
        with path.open(encoding="utf-8") as file:
            reader.read_file(file)
    except OSError as error:
        raise DescriptorError(path, 0, f"cannot read: {error.strerror}") from error
    except configparser.Error as error:
        raise DescriptorError(path, getattr(error, "lineno", None) or 0, f"not a data sheet: {error.message}") from error
    entries = {}
    for name in reader.sections():
        match, section = SECTION.match(name), reader[name]
        if match and "datatype" in section:
            try:
                kind = int(section["datatype"], 0)
            except ValueError as error:
                raise DescriptorError(path, 0, f"[{name}] DataType={section['datatype']}: expected a number") from error
            key = (int(match[1], 16), int(match[2] or "0", 16))
            entries[key] = Entry(section.get("parametername", name), kind, section.get("defaultvalue", ""))
    return Sheet(path, entries)


def of_class(element, name):
    """Sheet of a device class that a descriptor's element names."""
    if name not in CLASSES:
        element.wrong("type", "a class with a data sheet: " + " ".join(CLASSES))
    return load(FOLDER / CLASSES[name])
