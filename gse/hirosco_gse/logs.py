# SPDX-License-Identifier: Apache-2.0
"""Readers of a run's raw logs: bus logs (candump -L text), truth (LCM event log) and packets.log.

Bus logs of a flight have millions of lines: they are decoded column by column in numpy, not line by line.
If a log ends in the middle of a line or an event (a crashed run), the readers return everything before it.
"""

import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from . import large, packets

LCM_SYNC = 0xEDA1DA01
_LCM_HEADER = struct.Struct(">IQQII")
_HEX = np.full(256, 255, np.uint8)
for _digit in range(16):
    _HEX[ord("0123456789ABCDEF"[_digit])] = _HEX[ord("0123456789abcdef"[_digit])] = _digit


class LogError(ValueError):
    """A log that cannot be read."""


@dataclass
class BusLog:
    """Frames of one bus in order of the log; data is zero-filled to eight octets."""

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
    data = np.zeros((len(at), 8), np.uint8)
    for column in range(8):
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
        raise LogError(f"line {line + 1} is not a frame: {bytes(text[starts[line] : ends[line]])[:80]!r}")
    time_us = _digits(text, starts + 1, 10) * 1_000_000 + _digits(text, starts + 12, 6)
    identifier = np.where(is_short, _hex(text, at, 3), _hex(text, np.where(is_short, at - 5, at), 8))
    is_fd = text[hash_at + 1] == ord("#")
    data_at = hash_at + 1 + 2 * is_fd
    digits = ends - data_at
    return BusLog(time_us, identifier, (digits // 2).astype(np.int8), is_fd, _octets(text, data_at, digits))


def _second_space(text, starts, ends):
    """Index of the space behind the interface name; names of one log may differ in length."""
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
    """BusLog of a file; an empty one if there is none."""
    path = pathlib.Path(path)
    try:
        return parse_bus(path.read_bytes())
    except FileNotFoundError:
        return _empty_bus()
    except LogError as error:
        raise LogError(f"{path}: {error}") from error


def parse_packets(lines, path="packets.log"):
    """List of (time_ns, direction, Packet or None, raw) of `<s, 9 decimals> TC|TM <hex>` lines."""
    found = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words:
            continue
        try:
            stamp, direction, text = words
            seconds, fraction = stamp.split(".")
            raw = bytes.fromhex(text)
            if direction not in ("TC", "TM") or len(fraction) != 9:
                raise ValueError
            time_ns = int(seconds) * 1_000_000_000 + int(fraction)
        except ValueError as error:
            if not line.endswith("\n"):
                break  # the run ended while this line was written
            raise LogError(f"{path}:{number}: not a packet line: {line[:80]!r}") from error
        try:
            packet = packets.parse(raw)
        except packets.PacketError:
            packet = None  # the log contains a refused malformed telecommand with its received octets
        found.append((time_ns, direction, packet, raw))
    return found


def with_whole(found):
    """The same list, with each packet that was transferred in parts (ST[13]) inserted after its last part."""
    assembler, rows = large.Assembler(), []
    for row in found:
        rows.append(row)
        time_ns, direction, packet, _ = row
        whole = assembler.take(packet) if packet is not None and large.is_part(packet) else None
        if whole is not None:
            rows.append((time_ns, direction, whole, whole.raw))
    return rows


def read_packets(path):
    """As parse_packets and with_whole, of a file; empty if there is none."""
    try:
        with open(path, encoding="ascii") as log:
            return with_whole(parse_packets(log, path))
    except FileNotFoundError:
        return []


def parse_lcm(octets):
    """Dict channel -> (array of times [us], list of event octets) of an LCM event log."""
    channels, offset, size = {}, 0, len(octets)
    unpack, header_size = _LCM_HEADER.unpack_from, _LCM_HEADER.size
    view = memoryview(octets)
    while offset + header_size <= size:
        sync, _, time_us, name_size, data_size = unpack(octets, offset)
        if sync != LCM_SYNC:
            raise LogError(f"no event at octet {offset} (sync word 0x{sync:08X})")
        body = offset + header_size
        end = body + name_size + data_size
        if end > size:
            break
        name = octets[body : body + name_size]
        entry = channels.get(name)
        if entry is None:
            entry = channels[name] = ([], [])
        entry[0].append(time_us)
        entry[1].append(view[body + name_size : end])
        offset = end
    return {name.decode("ascii"): (np.array(times, np.int64), events) for name, (times, events) in channels.items()}


def read_lcm(path):
    """As parse_lcm, of a file; empty if there is none."""
    try:
        return parse_lcm(pathlib.Path(path).read_bytes())
    except FileNotFoundError:
        return {}
    except LogError as error:
        raise LogError(f"{path}: {error}") from error
