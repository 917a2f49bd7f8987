# SPDX-License-Identifier: Apache-2.0
"""Readers of a run's raw logs: bus logs (candump -L text) and truth (LCM event log).

Bus logs of a flight have millions of lines: they are decoded column by column in numpy, not line by line.
If a log ends in the middle of a line or an event (a crashed run), the readers return everything before it.
"""

import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from .packet_log import LogError

LCM_SYNC = 0xEDA1DA01  # First octets of an event.
_LCM_HEADER = struct.Struct(">IQQII")
_HEX = np.full(256, 255, np.uint8)
for _digit in range(16):
    _HEX[ord("0123456789ABCDEF"[_digit])] = _HEX[ord("0123456789abcdef"[_digit])] = _digit


@dataclass
class BusLog:
    """Frames of one bus in order of the log; data is zero-filled to eight octets, or to those of the longest frame."""

    time_us: np.ndarray
    id: np.ndarray
    length: np.ndarray
    is_fd: np.ndarray
    data: np.ndarray

    def __len__(self):
        return len(self.id)

    def frames(self, identifier):
        """Indices of the frames with this identifier."""
        return np.flatnonzero(self.id == identifier)

    def field(self, rows, offset, dtype):
        """Little-endian field of the frames at `rows`."""
        width = np.dtype(dtype).itemsize
        part = np.ascontiguousarray(self.data[rows, offset : offset + width])
        return part.view("<" + np.dtype(dtype).str[1:]).ravel()


def _empty_bus():
    return BusLog(
        np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int8), np.zeros(0, bool), np.zeros((0, 8), np.uint8)
    )


def _digits(text, at, count):
    number = np.zeros(len(at), np.int64)
    for column in range(count):
        number = number * 10 + (text[at + column] - ord("0"))
    return number


def _hex(text, at, count):
    number = np.zeros(len(at), np.int64)
    for column in range(count):
        number = number << 4 | _HEX[text[at + column]]
    return number


def _octets(text, at, digits):
    width = max(8, int(digits.max(initial=0)) // 2)
    data = np.zeros((len(at), width), np.uint8)
    for column in range(width):
        rows = np.flatnonzero(digits >= 2 * column + 2)
        where = at[rows] + 2 * column
        data[rows, column] = _HEX[text[where]] << 4 | _HEX[text[where + 1]]
    return data


def parse_bus(text):
    """BusLog of candump -L text: `(0000000001.000500) robot 191##1<hex>`; raises LogError with the line."""
    text = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(text == ord("\n"))
    if not len(ends):
        return _empty_bus()
    starts = np.concatenate(([0], ends[:-1] + 1))
    dots = starts + 11
    name_end = _second_space(text, starts, ends)
    at = name_end + 1
    is_short = text[np.minimum(at + 3, len(text) - 1)] == ord("#")
    hash_at = np.where(is_short, at + 3, at + 8)
    ok = (ends - starts > 24) & (text[starts] == ord("(")) & (name_end < ends)
    ok[ok] &= (text[dots[ok]] == ord(".")) & (text[starts[ok] + 18] == ord(")"))
    ok[ok] &= (hash_at[ok] < ends[ok]) & (text[np.minimum(hash_at[ok], len(text) - 1)] == ord("#"))
    if not ok.all():
        line = int(np.flatnonzero(~ok)[0])
        found = bytes(text[starts[line] : ends[line]])[:80].decode("ascii", "backslashreplace")
        raise LogError(f"line {line + 1}: found {found!r}, expected (seconds) bus id#octets, as candump -L writes")
    time_us = _digits(text, starts + 1, 10) * 1_000_000 + _digits(text, starts + 12, 6)
    identifier = np.where(is_short, _hex(text, at, 3), _hex(text, np.where(is_short, at - 5, at), 8))
    is_fd = text[hash_at + 1] == ord("#")
    data_at = hash_at + 1 + 2 * is_fd
    digits = ends - data_at
    return BusLog(time_us, identifier, (digits // 2).astype(np.int8), is_fd, _octets(text, data_at, digits))


def _second_space(text, starts, ends):
    """Index of the space after the interface name; names of one log may differ in length."""
    found = np.zeros(len(starts), np.int64)
    open_rows = np.arange(len(starts))
    for width in range(1, 20):
        at = np.minimum(starts[open_rows] + 20 + width, ends[open_rows])
        hit = (text[at] == ord(" ")) | (at == ends[open_rows])
        found[open_rows[hit]] = at[hit]
        open_rows = open_rows[~hit]
        if not len(open_rows):
            break
    found[open_rows] = ends[open_rows]
    return found


def read_bus(path):
    """BusLog of a file. Empty if there is no file."""
    path = pathlib.Path(path)
    try:
        return parse_bus(path.read_bytes())
    except FileNotFoundError:
        return _empty_bus()
    except LogError as error:
        raise LogError(f"{path}: {error}") from error


def _u32(whole, at):
    """Big-endian numbers of 32 bit at these places."""
    return sum(whole[at + octet].astype(np.int64) << (24 - 8 * octet) for octet in range(4))


def _events(whole):
    """(places, ends) of the events of an LCM log. An event begins where the one before it ends, so octets within an event that look like the
    head of another event are not taken for one."""
    most = len(whole) - _LCM_HEADER.size
    at = np.flatnonzero(whole[: max(0, most + 1)] == LCM_SYNC >> 24)
    at = at[_u32(whole, at) == LCM_SYNC]
    ends = at + _LCM_HEADER.size + _u32(whole, at + 20) + _u32(whole, at + 24)
    following = np.searchsorted(at, ends)
    is_next = following == np.arange(1, len(at) + 1)
    is_next[is_next] = at[np.minimum(following[is_next], len(at) - 1)] == ends[is_next]
    kept, first, offset = [], 0, 0
    while offset <= most:
        if first == len(at) or at[first] != offset:
            word = int.from_bytes(bytes(whole[offset : offset + 4]), "big")
            raise LogError(f"octet {offset}: found 0x{word:08X}, expected the sync word 0x{LCM_SYNC:08X} of an event")
        last = first + int(np.argmin(is_next[first:]))  # The last of the events that follow each other without a gap.
        kept.append(np.arange(first, last + 1))
        first, offset = int(following[last]), int(ends[last])
    kept = np.concatenate(kept) if kept else np.zeros(0, np.int64)
    kept = kept[ends[kept] <= len(whole)]
    return at[kept], ends[kept]


class Events:
    """Octets of the events of a channel: a sequence of views into the log, made when they are asked for. A log of an hour has millions of events."""

    def __init__(self, octets, starts, ends):
        self._view, self._starts, self._ends = memoryview(octets), starts, ends

    def __len__(self):
        return len(self._starts)

    def __getitem__(self, number):
        return self._view[int(self._starts[number]) : int(self._ends[number])]

    def __iter__(self):
        return (self._view[start:end] for start, end in zip(self._starts.tolist(), self._ends.tolist()))

    def heads(self, size):
        """The first octets of each event, one after the other. Raises LogError if an event is shorter."""
        shortest = int((self._ends - self._starts).min(initial=size))
        if shortest < size:
            raise LogError(f"an event has {shortest} octets, expected {size}")
        if not len(self):
            return b""
        rows = np.ndarray((len(self._view) - size + 1,), f"V{size}", self._view, 0, (1,))  # At each place of the log.
        return rows[self._starts].tobytes()


def parse_lcm(octets):
    """Dict channel -> (array of times [us], Events) of an LCM event log."""
    whole = np.frombuffer(octets, np.uint8)
    at, ends = _events(whole)
    sizes = _u32(whole, at + 20)
    starts = at + _LCM_HEADER.size + sizes
    codes = sizes.copy()  # Codes of the channels, equal for equal names.
    for octet in range(int(sizes.max(initial=0))):
        inside = octet < sizes
        codes[inside] = (codes[inside] * 1_000_003) ^ whole[at[inside] + _LCM_HEADER.size + octet]
    channels = {}
    _, firsts, groups = np.unique(codes, return_index=True, return_inverse=True)
    for group in np.argsort(firsts):
        rows = np.flatnonzero(groups == group)
        place = int(at[firsts[group]]) + _LCM_HEADER.size
        name = bytes(octets[place : place + int(sizes[firsts[group]])]).decode("ascii", "replace")
        times = (_u32(whole, at[rows] + 12) << 32) | _u32(whole, at[rows] + 16)
        channels[name] = (times, Events(octets, starts[rows], ends[rows]))
    return channels


def read_lcm(path):
    """Read a file as parse_lcm does. Empty if there is no file."""
    try:
        return parse_lcm(pathlib.Path(path).read_bytes())
    except FileNotFoundError:
        return {}
    except LogError as error:
        raise LogError(f"{path}: {error}") from error
