# SPDX-License-Identifier: Apache-2.0
"""Decode frames of a CAN bus to words with the database of the bus (DBC), which the generator makes from the descriptors. It needs no package."""

import re
import struct
from dataclasses import dataclass, field

from .values import bits_for

MESSAGE = re.compile(r"BO_ (\d+) (\w+): (\d+) ")
SIGNAL = re.compile(r' SG_ (\w+)( M| m(\d+)M?)? : (\d+)\|(\d+)@1([+-]) \(([^,]+),([^)]+)\) \[[^\]]*\] "([^"]*)"')
WORDS = re.compile(r"VAL_ (\d+) (\w+) ")
WORD = re.compile(r'(-?\d+) "([^"]*)"')
SELECTED = re.compile(r"SG_MUL_VAL_ (\d+) (\w+) \w+ ([\d, -]+);")
REAL = re.compile(r"SIG_VALTYPE_ (\d+) (\w+) : [12];")
EXTENDED = 0x80000000


class DatabaseError(ValueError):
    """A database that cannot be read."""


@dataclass
class Signal:
    """A signal of a frame, little-endian."""

    name: str
    start: int
    bits: int
    is_signed: bool
    factor: float
    offset: float
    unit: str
    is_multiplexor: bool = False  # The value of this signal decides which multiplexed signals are present.
    when: set = field(default_factory=set)  # values of the multiplexor with which it is present; empty: always
    words: dict = field(default_factory=dict)
    is_real: bool = False  # A number of IEEE 754 with 32 or 64 bits.

    def value(self, octets):
        """Number in the frame."""
        raw = int.from_bytes(octets, "little") >> self.start & (1 << self.bits) - 1
        if self.is_real:
            return struct.unpack("<f" if self.bits == 32 else "<d", raw.to_bytes(self.bits // 8, "little"))[0]
        return raw - (1 << self.bits) if self.is_signed and raw >> self.bits - 1 else raw


class Database:
    """Frames of one bus."""

    def __init__(self, path):
        """Read a generated database. Raises DatabaseError."""
        self.path, self.names, self.octets, self.signals, self.about = path, {}, {}, {}, ""
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, ValueError) as error:
            raise DatabaseError(f"{path}: {getattr(error, 'strerror', None) or error}; run make") from error
        identifier = None
        for line in lines:
            if found := MESSAGE.match(line):
                identifier = int(found[1])
                self.names[identifier], self.octets[identifier], self.signals[identifier] = found[2], int(found[3]), {}
            elif found := SIGNAL.match(line):
                when = {int(found[3])} if found[3] else set()
                self.signals[identifier][found[1]] = Signal(
                    found[1], int(found[4]), int(found[5]), found[6] == "-", float(found[7]), float(found[8]), found[9], found[2] == " M", when)
            elif line.startswith("CM_ \""):
                self.about = line  # Mission and hashes.
            elif found := WORDS.match(line):
                self.signals[int(found[1])][found[2]].words = {int(number): word for number, word in WORD.findall(line)}
            elif found := REAL.match(line):
                self.signals[int(found[1])][found[2]].is_real = True
            elif found := SELECTED.match(line):
                spans = (span.strip().split("-") for span in found[3].split(","))
                self.signals[int(found[1])][found[2]].when = {number for low, high in spans for number in range(int(low), int(high) + 1)}

    def problem_with(self, content, whose):
        """Returns a warning if the database and `content`, which is a dictionary or the facts of a run, come from
        different descriptors; otherwise None. The configuration hash is compared, because devices and settings define
        identifiers and contents of frames, and the interface hash does not cover them."""
        wanted = str(content.get("configuration_hash") or "")
        if wanted.upper() in self.about.upper():
            return None
        return f"{self.path.name}: made from other descriptors than {whose}, configuration {wanted}: names and values may be wrong; run make"

    def decode(self, identifier, octets, is_extended=False):
        """(name of the frame or None, list of (signal, number or word, unit))."""
        key = identifier | (EXTENDED if is_extended else 0)
        found, selected = [], None
        for signal in sorted(self.signals.get(key, {}).values(), key=lambda item: not item.is_multiplexor):
            if signal.start + signal.bits > 8 * len(octets) or (signal.when and selected not in signal.when):
                continue
            number = signal.value(octets)
            if signal.is_multiplexor:
                selected = number
            value = signal.words.get(number)
            if value is None:
                value = number * signal.factor + signal.offset if (signal.factor, signal.offset) != (1.0, 0.0) else number
            found.append((signal.name, value, signal.unit))
        return self.names.get(key), found

    def describe(self, identifier, octets, is_extended=False, bits=None):
        """One line of text. The octets of a frame that the database does not contain are shown in hexadecimal. bits: those of values.bits_of;
        numbers whose bits have names are shown by these."""
        name, signals = self.decode(identifier, octets, is_extended)
        if name is None:
            return f"0x{identifier:03X} (not in the database of the bus)  {octets.hex(' ')}".rstrip()
        words = (f"{signal}={_word(signal, value, bits or {})} {unit}".rstrip() for signal, value, unit in signals)
        return "  ".join([name, *words])


def _word(signal, value, bits):
    """Text of a value."""
    names = bits_for(signal, bits)
    if names and isinstance(value, int):
        return names[value]
    return f"{value:.6g}" if isinstance(value, float) else value
