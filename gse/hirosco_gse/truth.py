# SPDX-License-Identifier: Apache-2.0
"""Decode the simulator's truth log with the types in sim/truth/*.lcm, which are the only description of its channels on the ground."""

import functools
import pathlib
import re
from dataclasses import dataclass

import numpy as np

TYPES = pathlib.Path(__file__).resolve().parents[2] / "sim" / "truth"
NUMBERS = {"int8_t": "i1", "int16_t": ">i2", "int32_t": ">i4", "int64_t": ">i8", "float": ">f4", "double": ">f8", "boolean": "u1", "byte": "u1"}
HEAD = 16  # Octets of the fingerprint and of time_ns, with which each event begins.
_MEMBER = re.compile(r"\s*(\w+)\s+(\w+)((?:\[\w+\])*);")


class TruthError(ValueError):
    """A type that cannot be read, or a log with other types."""


@dataclass(frozen=True)
class Member:
    """A member of a message: numbers of one LCM type, or text; a dimension is a number or the name of a member before it."""

    name: str
    kind: str
    sizes: tuple = ()


@dataclass(frozen=True)
class Type:
    """The messages of one channel."""

    channel: str
    members: tuple  # Those after time_ns.
    fingerprint: int

    @property
    def has_text(self):
        return any(member.kind == "string" for member in self.members)


def _mix(value, number):
    """One step of LCM's fingerprint, in 64 bits with an arithmetic shift."""
    signed = value - (1 << 64) if value >> 63 else value
    return ((value << 8 ^ signed >> 55) + number) & 0xFFFFFFFFFFFFFFFF


def _mix_text(value, text):
    value = _mix(value, len(text))
    for letter in text.encode("ascii"):
        value = _mix(value, letter)
    return value


def _fingerprint(members):
    value = 0x12345678
    for member in members:
        value = _mix(_mix_text(_mix_text(value, member.name), member.kind), len(member.sizes))
        for size in member.sizes:
            value = _mix_text(_mix(value, 0 if size.isdigit() else 1), size)
    return (value << 1 | value >> 63) & 0xFFFFFFFFFFFFFFFF


def parse(text, path="type"):
    """Type of the only struct in an LCM type file."""
    text = re.sub(r"//[^\n]*", "", text)
    found = re.search(r"struct\s+(\w+)_t\s*\{(.*)\}", text, re.DOTALL)
    members = [Member(name, kind, tuple(re.findall(r"\w+", sizes))) for kind, name, sizes in _MEMBER.findall(found[2])] if found else []
    if not members or members[0] != Member("time_ns", "int64_t") or not {one.kind for one in members} <= {"string", *NUMBERS}:
        raise TruthError(f"{path}: expected a struct of numbers and texts that begins with int64_t time_ns")
    return Type(found[1].upper(), tuple(members[1:]), _fingerprint(members))


@functools.cache
def types():
    """Dict channel -> Type."""
    listed = [parse(path.read_text(encoding="utf-8"), path) for path in sorted(TYPES.glob("*.lcm"))]
    return {one.channel: one for one in listed}


def check(channels):
    """Raise TruthError if a channel of a log has another type than this version."""
    for name, (_, events) in channels.items():
        known = types().get(name)
        if known is None:
            raise TruthError(f"channel {name} has no type in sim/truth")
        flown = int.from_bytes(events[0][:8], "big")
        if flown != known.fingerprint:
            raise TruthError(f"channel {name} has the fingerprint 0x{flown:016X}, its type in sim/truth 0x{known.fingerprint:016X}")


def _sizes(member, numbers):
    return tuple(int(size) if size.isdigit() else numbers[size] for size in member.sizes)


def _columns(events, members):
    """(dict name -> array with a row for each event, octet after the members in an event) for members without text. Counts are those of the
    first event."""
    fields, numbers, at = [("head", f"V{HEAD - 8}"), ("time_ns", ">i8")], {}, HEAD
    for member in members:
        kind = np.dtype((NUMBERS[member.kind], _sizes(member, numbers)))
        if not member.sizes and kind.kind == "i" and events:
            numbers[member.name] = int(np.frombuffer(events[0], kind, 1, at)[0])
        fields.append((member.name, kind))
        at += kind.itemsize
    table = np.frombuffer(events.heads(at), np.dtype(fields))
    found = {"time_us": table["time_ns"] // 1000}
    for member in members:
        if member.name in numbers:
            continue
        column = np.ascontiguousarray(table[member.name])
        found[member.name] = column.astype(bool if member.kind == "boolean" else float)
    return found, at


def _with_text_at_end(events, members):
    """Decode as _columns does, for members of which the last is a text. Equal texts are decoded once."""
    found, at = _columns(events, members[:-1])
    known = {}
    numbers = [known.setdefault(bytes(event[at + 4 : -1]), len(known)) for event in events]
    names = np.array([text.decode("ascii", "replace") for text in known])
    return {**found, members[-1].name: names[numbers] if len(names) else names}


def _record(event, members):
    """Dict of one event."""
    found, at = {"time_us": int.from_bytes(event[8:HEAD], "big") // 1000}, HEAD
    for member in members:
        shape = _sizes(member, found)
        if member.kind == "string":
            texts = []
            for _ in range(int(np.prod(shape))):
                size = int.from_bytes(event[at : at + 4], "big")
                texts.append(bytes(event[at + 4 : at + 4 + size - 1]).decode("ascii", "replace"))
                at += 4 + size
            found[member.name] = texts if shape else texts[0]
        else:
            kind = np.dtype((NUMBERS[member.kind], shape))
            value = np.frombuffer(event, kind, 1, at)[0]
            found[member.name] = value if shape else int(value)
            at += kind.itemsize
    return found


def decode(channels):
    """Dict channel -> dict of arrays with a row for each event (with "time_us"), or a list of dicts if the events have texts.

    OPERATOR, whose text is its last member, is a dict of arrays, too."""
    decoded = {}
    for name, (_, events) in channels.items():
        kind = types()[name]
        if not kind.has_text:
            decoded[name] = _columns(events, kind.members)[0]
        elif name == "OPERATOR":
            decoded[name] = _with_text_at_end(events, kind.members)
        else:
            decoded[name] = [_record(event, kind.members) for event in events]
    return decoded


def held(table, want_us):
    """Row of a table of columns that is valid at each of these instants. The log omits rows while its channel is at rest, so a row is valid
    until the next one. The first row is also valid before its time."""
    return np.maximum(np.searchsorted(table["time_us"], want_us, side="right") - 1, 0)


def at(table, name, want_us, end_us):
    """Column of a table at these instants as floating point numbers; NaN after `end_us`, the end of the log."""
    found = table[name][held(table, want_us)].astype(float)
    found[np.asarray(want_us) > end_us] = np.nan
    return found
