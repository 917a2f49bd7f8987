# SPDX-License-Identifier: Apache-2.0
"""Reader of the packet log of a run. It needs no third-party package."""

from . import large, packets


class LogError(ValueError):
    """A log that cannot be read."""


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
            raise LogError(f"{path}:{number}: not a packet line: {line[:80]!r}, expected <seconds, 9 decimals> TC|TM <octets in hex>") from error
        try:
            packet = packets.parse(raw)
        except packets.PacketError:
            if not line.endswith("\n"):
                break
            packet = None  # the log contains a refused malformed telecommand with its received octets
        found.append((time_ns, direction, packet, raw))
    return found


def rows(path):
    """parse_packets of a file. Raises LogError, OSError."""
    with open(path, encoding="ascii", errors="backslashreplace") as log:
        return parse_packets(log, path)


def with_whole(found):
    """The same list, with each packet that was transferred in parts (ST[13]) inserted after its last part."""
    assembler, all_rows = large.Assembler(), []
    for row in found:
        all_rows.append(row)
        time_ns, direction, packet, _ = row
        whole = assembler.take(packet) if packet is not None and large.is_part(packet) else None
        if whole is not None:
            all_rows.append((time_ns, direction, whole, whole.raw))
    return all_rows


def read_packets(path):
    """Read a file as parse_packets and with_whole do. Empty if there is no file."""
    try:
        return with_whole(rows(path))
    except FileNotFoundError:
        return []
