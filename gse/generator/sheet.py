# SPDX-License-Identifier: Apache-2.0
"""Electronic data sheets of devices (CiA 306): objects with their names, types and defaults; process data and units.

This is the only reader of data sheets on the ground: the generator and the reader of a run's bus logs import it."""

import functools
import math
import pathlib
import re
import struct
import unicodedata
from dataclasses import dataclass

DIRECTORY = pathlib.Path(__file__).resolve().parents[2] / "descriptors" / "devices"
# Names of sections and keys are not case-sensitive.
SECTION = re.compile(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,2}))?\Z", re.IGNORECASE)
NUMBER = re.compile(r"-?(?:0x[0-9a-f]+|0[0-7]*|[1-9][0-9]*)\Z", re.IGNORECASE)
REAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\Z")
# Data type of CiA 301 -> bits, signed.
INTEGERS = {1: (1, False), 2: (8, True), 3: (16, True), 4: (32, True), 5: (8, False), 6: (16, False), 7: (32, False),
            0x10: (24, True), 0x12: (40, True), 0x13: (48, True), 0x14: (56, True), 0x15: (64, True),
            0x16: (24, False), 0x18: (40, False), 0x19: (48, False), 0x1A: (56, False), 0x1B: (64, False)}
REALS = {0x08: 32, 0x11: 64}  # Data type of CiA 301 -> bits, of IEEE 754. Their defaults are not in Sheet.defaults().
MEMBERS_MAX = 254
UNIT_POSITION, UNIT_VELOCITY, ENCODER, GEAR, AXIS_STEP = 0x60A8, 0x60A9, 0x608F, 0x6091, 0x800
RADIANS = {0x10: 1.0, 0x41: math.pi / 180.0, 0xB4: 2.0 * math.pi}  # CiA 303-2: rad, degree, revolution.
SECONDS = {0x03: 1.0, 0x47: 60.0}
SEVERITIES = ("LOW", "MEDIUM", "HIGH")
EMERGENCY = re.compile(r"EMCY\s+(0x[0-9A-Fa-f]{1,4})\s+(\w+)\s+(\S.*)\Z")


class SheetError(Exception):
    """An error in a data sheet: file, line (0: the whole file) and what is wrong."""

    def __init__(self, path, line, reason):
        super().__init__(f"{path}:{line}: {reason}" if line else f"{path}: {reason}")


def _number(text):
    """A number as CiA 306 writes it: decimal, hexadecimal with 0x, or octal with a leading 0. None if it is not a number."""
    text = text.strip().lower()
    if not NUMBER.match(text):
        return None
    digits = text.lstrip("-")
    return int(text, 16 if digits.startswith("0x") else 8 if digits.startswith("0") else 10)


@dataclass
class Entry:
    """One object or member of an object, and the line of its default."""

    name: str
    kind: int
    default: str
    access: str = ""
    is_mappable: bool = False
    line: int = 0

    def value(self, node):
        """Default as an integer, in which $NODEID is the node id; None if it is not an integer. Makers write negative numbers in hexadecimal,
        too."""
        if self.kind in REALS:
            return None
        terms = [node if term.strip().upper() == "$NODEID" else _number(term) for term in self.default.split("+")]
        if None in terms[:2] or len(terms) > 2:
            return None
        bits, signed = INTEGERS.get(self.kind, (0, False))
        is_negative = signed and "x" in self.default.lower() and 1 << bits - 1 <= sum(terms) < 1 << bits
        return sum(terms) - (1 << bits if is_negative else 0)


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


@dataclass
class _Section:
    """A section of the file: its name, line, and values with their lines by the names of their keys in small letters."""

    name: str
    line: int
    values: dict

    def get(self, key, default=""):
        return self.values.get(key, (default, self.line))[0]

    def line_of(self, key):
        return self.values.get(key, ("", self.line))[1]


def _text(path):
    """Text of the file. CiA 306 has ASCII only; the sheets of many makers contain Latin-1."""
    try:
        octets = path.read_bytes()
    except OSError as error:
        raise SheetError(path, 0, f"cannot read: {error.strerror}") from error
    try:
        return octets.decode("utf-8-sig")
    except UnicodeDecodeError:
        return octets.decode("latin-1")


def _sections(path):
    """Sections by their names in small letters."""
    sections, section = {}, None
    for number, line in enumerate(_text(path).split("\n"), 1):
        line = line.strip()
        if not line or line[0] in ";#":
            continue
        if line[0] == "[" and line[-1] == "]":
            section = _Section(line[1:-1].strip(), number, {})
            if section.name.lower() in sections:
                raise SheetError(path, number, f"not a data sheet: {line}: expected each section only once; the first is in line "
                                               f"{sections[section.name.lower()].line}")
            sections[section.name.lower()] = section
            continue
        key, equals, value = (part.strip() for part in line.partition("="))
        if not equals or section is None:
            raise SheetError(path, number, f"not a data sheet: {line[:60]}: expected {'[section]' if section is None else 'key=value, [section]'} or ; comment")
        if key.lower() in section.values:
            raise SheetError(path, number, f"not a data sheet: {line[:60]}: expected each key of [{section.name}] only once")
        section.values[key.lower()] = (value, number)
    return sections


@functools.cache
def _read(path, changed_ns, octets):
    sections, entries = _sections(path), {}
    for section in sections.values():
        match = SECTION.match(section.name)
        is_head = match and not match[2] and _number(section.get("objecttype", "7")) in (8, 9)  # Its members have sections of their own.
        if is_head:
            entries.update(_members(path, section, sections))
        elif match and section.get("datatype"):
            entry = _entry(path, section)
            entries[int(match[1], 16), int(match[2] or "0", 16)] = entry
    return Sheet(path, entries, tuple(_emergencies(path, sections)))


def _members(path, section, sections):
    """The members of an array or record that have no sections of their own, because CompactSubObj describes them."""
    text = section.get("compactsubobj") or "0"
    count, index = _number(text), int(section.name, 16)
    if count is None or not 0 <= count <= MEMBERS_MAX:
        raise SheetError(path, section.line_of("compactsubobj"), f"[{section.name}] CompactSubObj={text}: expected a number of sub-objects from 0 to {MEMBERS_MAX}")
    values = sections.get(f"{section.name.lower()}value")
    if values:
        raise SheetError(path, values.line, f"[{values.name}]: expected the values of CompactSubObj as DefaultValue in a section for each sub-object")
    if not count:
        return {}
    member = _entry(path, section)
    return {(index, 0): Entry(member.name, 5, str(count), "ro"), **dict.fromkeys(((index, number) for number in range(1, count + 1)), member)}


def _entry(path, section):
    """The object of a section. Refuse a default that is not a number of its type."""
    kind = _number(section.get("datatype"))
    if kind is None:
        raise SheetError(path, section.line_of("datatype"), f"[{section.name}] DataType={section.get('datatype')}: expected a number")
    default = section.get("defaultvalue")
    entry = Entry(section.get("parametername", section.name), kind, default, section.get("accesstype").lower(),
                  _number(section.get("pdomapping", "0")) == 1, section.line_of("defaultvalue"))
    if default and kind in REALS and not _is_real(default, REALS[kind]):
        raise SheetError(path, entry.line, f"[{section.name}] DefaultValue={default}: expected a finite number of {REALS[kind]} bits, like 0.5 or 1e-3, "
                                           f"as DataType={section.get('datatype')}")
    if default and kind in INTEGERS:
        bits, signed = INTEGERS[kind]
        value = entry.value(0)
        if value is None or not (-(1 << bits - 1) <= value < 1 << bits - 1 if signed else 0 <= value < 1 << bits):
            raise SheetError(path, entry.line, f"[{section.name}] DefaultValue={default}: expected {'a signed' if signed else 'an unsigned'} number of {bits} "
                                               f"bit{'s' if bits > 1 else ''}, as DataType={section.get('datatype')}")
    return entry


def _is_real(text, bits):
    """True for a finite number that a REAL32 or REAL64 can hold."""
    try:
        return REAL.match(text) is not None and math.isfinite(struct.unpack("<f" if bits == 32 else "<d", struct.pack("<f" if bits == 32 else "<d", float(text)))[0])
    except OverflowError:
        return False


def _emergencies(path, sections):
    """Emergency codes of the manufacturer. They are in [Comments], the only section of CiA 306 with free content."""
    known = set()
    comments = sections.get("comments", _Section("Comments", 0, {}))
    for key, (line, number) in comments.values.items():
        if key == "lines" or line.split(" ")[0] != "EMCY":
            continue
        match = EMERGENCY.match(line)
        code = int(match[1], 16) if match else 0
        if code == 0 or match[2] not in SEVERITIES or code in known:
            raise SheetError(path, number, f"[Comments] {key}={line}: expected EMCY, a code from 0x0001 to 0xFFFF that no other line has, "
                                           f"one of {' '.join(SEVERITIES)}, and a text")
        known.add(code)
        yield code, match[2], match[3]


def ascii_of(text):
    """Text of a sheet for files that are in ASCII: letters lose their accents, other characters are left out."""
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode("ascii")


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


def type_of(kind):
    """(bits, signed, real) of a data type of CiA 301; 0 bits if it is no number."""
    return (REALS[kind], True, True) if kind in REALS else (*INTEGERS.get(kind, (0, False)), False)


def prefix(code):
    """Factor of a unit object: the power of ten in its highest octet."""
    exponent = code >> 24 & 0xFF
    return float(f"1e{exponent - 256 if exponent > 127 else exponent}")


def _factor(code, numerator, denominator):
    return None if numerator is None or denominator is None else prefix(code) * numerator / denominator
