# SPDX-License-Identifier: Apache-2.0
"""Decode recorded octets to words: hexadecimal packets, packets.log, captures (pcap, pcapng) and bus logs of candump.

`rows` returns a dict for each packet or frame, with "text" for people. Input that cannot be read raises DecodeError with file, line or
offset, the value found, the value expected and what to do. A malformed packet gives a row that describes the error.
"""

import os
import pathlib
import re
import stat
import struct
import sys

from . import frames, large, packet_log, packets, telecommands, telemetry
from .run_directory import facts_of
from .values import bits_of, quoted

CANDUMP = re.compile(r"\((\d+\.\d+)\) (\S+) ([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})(?:#R\d?|#((?:[0-9A-Fa-f]{2})*)|##[0-9A-Fa-f]((?:[0-9A-Fa-f]{2})*))(?: [RT])?\s*")
PACKET_LINE = re.compile(r"\d+\.\d+ T[CM] ")
PCAP = {b"\xd4\xc3\xb2\xa1": ("<", 1e-6), b"\xa1\xb2\xc3\xd4": (">", 1e-6), b"\x4d\x3c\xb2\xa1": ("<", 1e-9), b"\xa1\xb2\x3c\x4d": (">", 1e-9)}
BODY_LEAST = {1: 8, 6: 20}  # Octets of the fixed fields of a block: the description of an interface, and a packet.
PCAPNG = b"\x0a\x0d\x0d\x0a"
PACKETS, CAN, ETHERNET, NULL, RAW, SLL, SLL2 = 147, 227, 1, 0, 101, 113, 276
LINK_HEADS = {ETHERNET: 14, NULL: 4, RAW: 0, SLL: 16, SLL2: 20}
FORMS = "packets.log, a log of candump -L, a capture (pcap, pcapng) or packets in hexadecimal"
CAN_FRAME_HEAD, EXTENDED, REMOTE = 8, 0x80000000, 0x40000000


class DecodeError(ValueError):
    """Input that cannot be read, as file:line or offset, with what was found, what was expected and what to do."""


class _Decoder:
    """State that is kept between packets: the configurations, on which the layout of housekeeping depends, and parts of long packets."""

    def __init__(self, dictionary, directory):
        self.dictionary, self._directory = dictionary, pathlib.Path(directory)
        self._configurations, self._databases = {}, {}
        self._bits = bits_of(dictionary.content)
        self._assembler = large.Assembler()
        self._facts, self._warnings = {}, []

    def compare_with_run(self, directory):
        """Compare the dictionary with the facts of the flight in run.json, if this file is in the directory of the input."""
        self._facts, problem = facts_of(directory)
        self._warn(problem and f"{directory}: {problem}")
        flown = str(self._facts.get("interface_hash") or "")
        if flown and flown.upper() != self.dictionary.interface_hash.upper():
            self._warn(f"{directory / 'run.json'}: the flight had interface {flown}, the dictionary has {self.dictionary.interface_hash}: "
                       "names and values may be wrong; run make")

    def _warn(self, text):
        if text is not None:
            self._warnings.append({"text": f"warning: {text}", "time": None, "warning": text})

    def with_warnings(self, found):
        """Yield these rows; the warnings that a row has caused precede it."""
        for row in found:
            yield from self._warnings
            self._warnings.clear()
            yield row

    def packet(self, raw, seconds=None):
        """Rows of one packet: its own row, and a second one if it completes a long packet."""
        try:
            packet = packets.parse(raw)
        except packets.PacketError as error:
            return [self._row(seconds, f"malformed packet: {error}  {raw.hex()}", error=str(error), octets=raw.hex())]
        rows = [self._packet(packet, seconds)]
        whole = self._assembler.take(packet) if large.is_part(packet) else None
        return rows + ([self._packet(whole, seconds)] if whole is not None else [])

    def _packet(self, packet, seconds):
        name = self.dictionary.name_of_apid(packet.apid)
        about = {"packet": packet.title, "subsystem": name, "sequence": packet.sequence, "user": packet.user}
        if packet.direction == "TC":
            decoded = telecommands.decode(packet, self.dictionary)
            text = telecommands.describe(packet, decoded, self.dictionary)
        else:
            decoded = telemetry.decode(packet, self.dictionary, self._configurations)
            text = telemetry.describe(packet, decoded, self.dictionary)
            problem = telemetry.interface_problem(packet, decoded, self.dictionary)
            text += f"  ({problem})" if problem else ""
            if "configuration_id" in decoded:
                self._configurations[packet.apid] = decoded["configuration_id"]
            if seconds is None and packet.time_ns:
                seconds = (packet.time_ns - self.dictionary.epoch_ns) / 1e9
        return self._row(seconds, f"{packet.title:<10} {text}", **about, content=decoded)

    def frame(self, place, bus, identifier, octets, seconds, is_extended=False):
        """Row of one frame."""
        names = [item["name"] for item in self.dictionary.buses]
        if bus not in names:
            raise DecodeError(f"{place}: found bus {quoted(bus)}, expected a bus of mission {self.dictionary.mission}: {', '.join(names) or 'none'}; "
                              "give the dictionary of the mission with --dictionary")
        if bus not in self._databases:
            self._databases[bus] = database = frames.Database(self._directory / f"{self.dictionary.mission}-{bus}.dbc")
            self._warn(database.problem_with(self._facts, "those that flew") or database.problem_with(self.dictionary.content, "the dictionary"))
        name, signals = self._databases[bus].decode(identifier, octets, is_extended)
        text = f"{bus} {self._databases[bus].describe(identifier, octets, is_extended, self._bits)}"
        return self._row(seconds, text, bus=bus, id=identifier, frame=name, values={signal: value for signal, value, _ in signals})

    @staticmethod
    def _row(seconds, text, **about):
        return {"text": text if seconds is None else f"{seconds:12.6f}  {text}", "time": seconds, **about}


def _packets_in(decoder, octets, place, seconds=None):
    """Rows of packets that follow each other directly."""
    splitter, used = packets.Splitter(), 0
    for raw in splitter.feed(octets):
        used += len(raw)
        yield from decoder.packet(raw, seconds)
    if used != len(octets):
        rest = octets[used:]
        needed = int.from_bytes(rest[4:6], "big") + 7 if len(rest) >= packets.PRIMARY_HEADER else packets.PRIMARY_HEADER
        found = f"{len(rest)} octet{'s' if len(rest) > 1 else ''}"
        raise DecodeError(f"{place}: found {found} at octet {used}, expected {needed} of a whole packet; add what is missing")


def _hex_lines(decoder, lines, path):
    for number, line in enumerate(lines, 1):
        digits = re.sub(r"0[xX]|[\s:,]", "", line)
        wrong = re.search(r"[^0-9A-Fa-f]", digits)
        if wrong or len(digits) % 2:
            found = f"{quoted(wrong[0])} in {line.strip()[:60]!r}" if wrong else f"{len(digits)} digit{'s' if len(digits) > 1 else ''}"
            raise DecodeError(f"{path}:{number}: found {found}, expected an even number of hexadecimal digits, one packet or more a line")
        yield from _packets_in(decoder, bytes.fromhex(digits), f"{path}:{number}")


def _packet_lines(decoder, lines, path):
    try:
        for time_ns, _, _, raw in packet_log.parse_packets(lines, path):
            yield from decoder.packet(raw, time_ns / 1e9)
    except packet_log.LogError as error:
        raise DecodeError(f"{error}; remove the line") from error


def _candump_lines(decoder, lines, path):
    for number, line in enumerate(lines, 1):
        found = CANDUMP.fullmatch(line)
        if not found:
            if not line.strip() or not line.endswith("\n"):
                continue  # The run ended while this line was written.
            raise DecodeError(f"{path}:{number}: found {line.strip()[:60]!r}, expected (seconds) bus id#octets, as candump -L writes; remove the line")
        octets = bytes.fromhex(found[4] or found[5] or "")
        yield decoder.frame(f"{path}:{number}", found[2], int(found[3], 16), octets, float(found[1]), len(found[3]) == 8)


# ---- Captures ----


def _cut(path, offset, found, expected):
    return DecodeError(f"{path}: offset {offset}: found {found} octets, expected {expected}; the capture was cut, capture again or remove the rest")


def _pcap_records(octets, path):
    """(link type, seconds, octets, offset) of each record of a pcap file."""
    order, unit = PCAP[octets[:4]]
    if len(octets) < 24:
        raise _cut(path, 0, len(octets), 24)
    link_type, at = struct.unpack_from(f"{order}I", octets, 20)[0] & 0xFFFF, 24
    while at < len(octets):
        if len(octets) - at < 16:
            raise _cut(path, at, len(octets) - at, 16)
        seconds, fraction, length, _ = struct.unpack_from(f"{order}IIII", octets, at)
        if len(octets) - at - 16 < length:
            raise _cut(path, at + 16, len(octets) - at - 16, length)
        yield link_type, seconds + fraction * unit, octets[at + 16 : at + 16 + length], at
        at += 16 + length


def _option(octets, order, wanted):
    """Value of an option of a block, or None."""
    at = 0
    while at + 4 <= len(octets):
        code, length = struct.unpack_from(f"{order}HH", octets, at)
        if code == wanted:
            return octets[at + 4 : at + 4 + length]
        at += 4 + (length + 3) // 4 * 4
    return None


def _pcapng_records(octets, path):
    """(link type, seconds, octets, offset) of each record of a pcapng file."""
    at, order, interfaces = 0, "<", []
    while at < len(octets):
        if len(octets) - at < 12:
            raise _cut(path, at, len(octets) - at, 12)
        if octets[at : at + 4] == PCAPNG:
            order, interfaces = ("<" if octets[at + 8 : at + 12] == b"\x4d\x3c\x2b\x1a" else ">"), []
        kind, length = struct.unpack_from(f"{order}II", octets, at)
        if length < 12 or length % 4 or len(octets) - at < length:
            raise _cut(path, at, len(octets) - at, max(length, 12))
        body = octets[at + 8 : at + length - 4]
        if len(body) < BODY_LEAST.get(kind, 0):
            raise _cut(path, at + 8, len(body), BODY_LEAST[kind])
        if kind == 1:
            resolution = (_option(body[8:], order, 9) or b"\x06")[0]
            interfaces.append((struct.unpack_from(f"{order}H", body)[0], 2.0 ** -(resolution & 0x7F) if resolution & 0x80 else 10.0**-resolution))
        elif kind == 6:
            interface, high, low, captured, _ = struct.unpack_from(f"{order}IIIII", body)
            if interface >= len(interfaces) or captured > len(body) - 20:
                raise DecodeError(f"{path}: offset {at}: found interface {interface} with {captured} octets, expected a described one; capture again")
            link_type, unit = interfaces[interface]
            yield link_type, (high << 32 | low) * unit, body[20 : 20 + captured], at
        at += length


class _Stream:
    """One direction of a TCP connection."""

    def __init__(self):
        self.next, self.splitter = None, packets.Splitter()

    def take(self, sequence, payload):
        """(packets, octets missing before them)."""
        missing = 0
        if self.next is not None:
            behind = (self.next - sequence) & 0xFFFFFFFF
            if behind < 0x80000000:
                payload = payload[behind:]  # Drop octets that TCP has transmitted again.
                sequence = self.next if payload else sequence
            else:
                missing, self.splitter = (sequence - self.next) & 0xFFFFFFFF, packets.Splitter()
        if payload:
            self.next = (sequence + len(payload)) & 0xFFFFFFFF
        return self.splitter.feed(payload), missing


def _tcp(octets):
    """((ports), sequence number, payload) of an IP packet with TCP, or None."""
    if len(octets) < 20:
        return None
    version = octets[0] >> 4
    head = (octets[0] & 0xF) * 4 if version == 4 else 40
    total = struct.unpack_from(">H", octets, 2)[0] if version == 4 else 40 + struct.unpack_from(">H", octets, 4)[0]
    if version not in (4, 6) or octets[9 if version == 4 else 6] != 6 or len(octets) < head + 20:
        return None
    source, target, sequence = struct.unpack_from(">HHI", octets, head)
    is_first = octets[head + 13] & 2  # A SYN takes one sequence number before the first octet.
    return (source, target), (sequence + 1 if is_first else sequence) & 0xFFFFFFFF, octets[head + (octets[head + 12] >> 4) * 4 : total]


def _capture(decoder, octets, path, port):
    streams = {}
    bus = next((item["name"] for item in sorted(decoder.dictionary.buses, key=lambda item: -len(item["name"])) if item["name"] in path.stem), path.stem)
    for link_type, seconds, record, at in (_pcap_records if octets[:4] in PCAP else _pcapng_records)(octets, path):
        if link_type == PACKETS:
            yield from _packets_in(decoder, record, f"{path}: offset {at}", seconds)
        elif link_type == CAN:
            identifier = struct.unpack_from(">I", record)[0] if len(record) >= CAN_FRAME_HEAD else REMOTE
            if not identifier & REMOTE:
                data = record[CAN_FRAME_HEAD : CAN_FRAME_HEAD + record[4]]
                yield decoder.frame(f"{path}: offset {at}", bus, identifier & 0x1FFFFFFF, data, seconds, bool(identifier & EXTENDED))
        elif link_type in LINK_HEADS:
            found = _tcp(record[LINK_HEADS[link_type] :])
            if found is None or port not in found[0]:
                continue
            stream = streams.setdefault((link_type, found[0]), _Stream())
            raws, missing = stream.take(found[1], found[2])
            if missing:
                yield {"text": f"{seconds:12.6f}  {missing} octets of the connection are missing in the capture", "time": seconds, "missing": missing}
            for raw in raws:
                yield from decoder.packet(raw, seconds)
        else:
            known = f"{PACKETS} (packets), {CAN} (CAN) or of TCP: {', '.join(map(str, LINK_HEADS))}"
            raise DecodeError(f"{path}: offset {at}: found link type {link_type}, expected {known}; capture the ground port or the bus")


# ---- Text and the choice of the format ----


def _text(decoder, octets, path):
    try:
        lines = octets.decode("ascii").splitlines(keepends=True)
    except UnicodeDecodeError as error:
        raise DecodeError(f"{path}: offset {error.start}: found octet 0x{octets[error.start]:02X}, expected {FORMS}") from error
    first = next((line for line in lines if line.strip()), "")
    read = _candump_lines if first.startswith("(") else _packet_lines if PACKET_LINE.match(first) else _hex_lines
    return read(decoder, lines, path)


def _octets_of(path):
    """Octets of a file or a pipe. A device such as /dev/zero would fill the memory. Raises OSError, DecodeError."""
    kind = path.stat().st_mode
    if stat.S_ISCHR(kind) or stat.S_ISBLK(kind):
        raise DecodeError(f"{path}: found a device, expected {FORMS}; check the path")
    return path.read_bytes()


def rows(words, dictionary, directory, port):
    """Rows of the input that the words of the command name: a file, `-` for the standard input, or octets in hexadecimal. directory: directory with
    the databases of the buses; port: the ground port in a capture of TCP. Raises DecodeError, frames.DatabaseError."""
    decoder = _Decoder(dictionary, directory)
    path = pathlib.Path(words[0])
    if len(words) > 1 or (re.fullmatch(r"(0[xX])?[0-9A-Fa-f]+", words[0]) and not os.path.exists(words[0])):
        return decoder.with_warnings(_hex_lines(decoder, [" ".join(words)], "octets"))
    try:
        octets = sys.stdin.buffer.read() if words == ["-"] else _octets_of(path)
    except OSError as error:
        raise DecodeError(f"{path}: {error.strerror}, expected {FORMS}; check the path") from error
    if words == ["-"]:
        path = pathlib.Path("stdin")
    else:
        decoder.compare_with_run(path.parent)
    is_capture = octets[:4] in PCAP or octets[:4] == PCAPNG
    return decoder.with_warnings(_capture(decoder, octets, path, port) if is_capture else _text(decoder, octets, path))
