# SPDX-License-Identifier: Apache-2.0
"""Electronic data sheets of devices (CiA 306): objects with their names, types and defaults; process data and units.

This is the only reader of data sheets on the ground: the generator and the reader of a run's bus logs import it."""

import configparser
import functools
import math
import pathlib
import re
from dataclasses import dataclass

DIRECTORY = pathlib.Path(__file__).resolve().parents[2] / "descriptors" / "devices"
SECTION = re.compile(r"([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]{1,2}))?\Z")
TERM = re.compile(r"(?:\$NODEID\s*\+\s*)?(-?(?:0x[0-9A-Fa-f]+|[0-9]+))\Z", re.IGNORECASE)
# Data type of CiA 301 -> bits, signed. Process data contain no others.
INTEGERS = {1: (1, False), 2: (8, True), 3: (16, True), 4: (32, True), 5: (8, False), 6: (16, False), 7: (32, False),
            0x10: (24, True), 0x15: (64, True), 0x16: (24, False), 0x1B: (64, False)}
UNIT_POSITION, UNIT_VELOCITY, ENCODER, GEAR, AXIS_STEP = 0x60A8, 0x60A9, 0x608F, 0x6091, 0x800
RADIANS = {0x10: 1.0, 0x41: math.pi / 180.0, 0xB4: 2.0 * math.pi}  # CiA 303-2: rad, degree, revolution.
SECONDS = {0x03: 1.0, 0x47: 60.0}
SEVERITIES = ("LOW", "MEDIUM", "HIGH")
EMERGENCY = re.compile(r"EMCY\s+(0x[0-9A-Fa-f]{1,4})\s+(\w+)\s+(\S.*)\Z")


class SheetError(Exception):
    """An error in a data sheet: file, line (0: unknown) and what is wrong."""

    def __init__(self, path, line, reason):
        super().__init__(f"{path}:{line}: {reason}")


@dataclass
class Entry:
    """One object or member of an object."""

    name: str
    kind: int
    default: str
    access: str = ""
    is_mappable: bool = False

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
    emergencies: tuple = ()  # (code, severity, text) of the lines "EMCY code severity text" of [Comments].

    def defaults(self, node):
        """{(index, subindex): number} of a device with this node id."""
        values = {key: entry.value(node) for key, entry in self.entries.items()}
        return {key: value for key, value in values.items() if value is not None}


def load(path):
    """The sheet in a file, which is read again only if the file has changed. Raises SheetError. Callers share the result and do not
    change it."""
    try:
        status = path.stat()
    except OSError as error:
        raise SheetError(path, 0, f"cannot read: {error.strerror}") from error
    return _read(path, status.st_mtime_ns, status.st_size)


@functools.cache
def _read(path, changed_ns, octets):
    reader = configparser.ConfigParser(interpolation=None, comment_prefixes=(";",), strict=True)
    try:
        with path.open(encoding="utf-8") as file:
            reader.read_file(file)
    except OSError as error:
        raise SheetError(path, 0, f"cannot read: {error.strerror}") from error
    except configparser.Error as error:
        raise SheetError(path, getattr(error, "lineno", None) or 0, f"not a data sheet: {error.message}") from error
    entries = {}
    for name in reader.sections():
        match, section = SECTION.match(name), reader[name]
        if match and "datatype" in section:
            try:
                kind = int(section["datatype"], 0)
            except ValueError as error:
                raise SheetError(path, 0, f"[{name}] DataType={section['datatype']}: expected a number") from error
            key = (int(match[1], 16), int(match[2] or "0", 16))
            entries[key] = Entry(section.get("parametername", name), kind, section.get("defaultvalue", ""),
                                 section.get("accesstype", "").lower(), section.get("pdomapping", "0").strip() == "1")
    return Sheet(path, entries, tuple(_emergencies(path, reader)))


def _emergencies(path, reader):
    """Emergency codes of the manufacturer. They are in [Comments], the only section of CiA 306 with free content."""
    known = set()
    for key, line in reader.items("Comments") if reader.has_section("Comments") else ():
        if key == "lines" or line.split(" ")[0] != "EMCY":
            continue
        match = EMERGENCY.match(line)
        code = int(match[1], 16) if match else 0
        if code == 0 or match[2] not in SEVERITIES or code in known:
            raise SheetError(path, 0, f"[Comments] {key}={line}: expected EMCY, a code from 0x0001 to 0xFFFF that no other line has, "
                                      f"one of {' '.join(SEVERITIES)}, and a text")
        known.add(code)
        yield code, match[2], match[3]


def mapped(values, record):
    """(index, subindex, bits) of each entry of a mapping record."""
    codes = (values.get((record, number), 0) for number in range(1, values.get((record, 0), 0) + 1))
    return [(code >> 16, code >> 8 & 0xFF, code & 0xFF) for code in codes]


def units(values, axis=0):
    """Units of position [rad] and velocity [rad/s] of an axis: 0x60A8 and 0x60A9, or increments of the encoder (0x608F),
    converted to the output of the gear (0x6091). None for a unit that the sheet does not define."""
    offset = axis * AXIS_STEP
    position, velocity = (values.get((index + offset, 0), 0) for index in (UNIT_POSITION, UNIT_VELOCITY))
    ratios = [values.get((index + offset, sub), 0) for index in (ENCODER, GEAR) for sub in (1, 2)]
    counts = 2.0 * math.pi * ratios[1] * ratios[3] / (ratios[0] * ratios[2]) if all(ratios) else None
    angle = counts if position == 0 else _factor(position, RADIANS.get(position >> 16 & 0xFF), 1.0 if position >> 8 & 0xFF == 0 else None)
    speed = angle if velocity == 0 else _factor(velocity, RADIANS.get(velocity >> 16 & 0xFF), SECONDS.get(velocity >> 8 & 0xFF))
    return angle, speed


def made_of(values, axis=0):
    """Objects (index, subindex) that units() uses for the units of an axis."""
    offset = axis * AXIS_STEP
    stated = [(index + offset, 0) for index in (UNIT_POSITION, UNIT_VELOCITY) if values.get((index + offset, 0), 0) != 0]
    ratios = [(index + offset, sub) for index in (ENCODER, GEAR) for sub in (1, 2)]
    return stated if stated[:1] == [(UNIT_POSITION + offset, 0)] else stated + ratios


def prefix(code):
    """Factor of a unit object: the power of ten in its highest octet."""
    exponent = code >> 24 & 0xFF
    return float(f"1e{exponent - 256 if exponent > 127 else exponent}")


def _factor(code, numerator, denominator):
    return None if numerator is None or denominator is None else prefix(code) * numerator / denominator
