# SPDX-License-Identifier: Apache-2.0
"""ST[13] on the ground: splits a packet longer than PACKET_MAX into parts, and assembles received parts.

The parts contain the whole packet, headers and checksum included, are numbered from 1, and have the largest possible length."""

import struct

from . import packets

SERVICE = 13
REPORT_PARTS, REQUEST_PARTS, ABORTED = (1, 2, 3), (9, 10, 11), 16
HEAD = struct.Struct(">HH")  # Transaction and part number, from 1.
PART_MAX = packets.PACKET_MAX - packets.TC_HEADER - HEAD.size - packets.CRC_SIZE
FIRST, MIDDLE, LAST = range(3)  # Indices in REPORT_PARTS and REQUEST_PARTS.


def is_part(packet):
    """Whether a packet contains a part of another one."""
    return packet.service == SERVICE and packet.subtype in (REPORT_PARTS if packet.direction == "TM" else REQUEST_PARTS)


def cut(raw, transaction, part=PART_MAX):
    """The (subtype, application data) of the requests that transfer the octets of a long request."""
    pieces = [raw[at : at + part] for at in range(0, len(raw), part)]
    if len(pieces) < 2:
        raise packets.PacketError(f"{len(raw)} octets are one part, not several")
    kinds = [FIRST] + [MIDDLE] * (len(pieces) - 2) + [LAST]
    return [
        (REQUEST_PARTS[kind], HEAD.pack(transaction & 0xFFFF, number) + piece)
        for number, (kind, piece) in enumerate(zip(kinds, pieces), 1)
    ]


class Assembler:
    """Assembles parts of any number of processes, users and transactions; a missing part discards its packet."""

    def __init__(self):
        self.problems = []  # The packets that could not be assembled, in words.
        self._open = {}  # Direction, APID, user, transaction -> octets of the received parts.

    def take(self, packet):
        """The packet that this part completes, or None."""
        transaction, number = HEAD.unpack_from(packet.data) if len(packet.data) >= HEAD.size else (None, 0)
        kind = (REPORT_PARTS if packet.direction == "TM" else REQUEST_PARTS).index(packet.subtype)
        key = packet.direction, packet.apid, packet.user, transaction
        parts = self._open.pop(key, [])
        if kind == FIRST:
            parts = []
        if number != len(parts) + 1 or (kind != FIRST and not parts):
            self.problems.append(f"{packet.title} of transaction {transaction}: part {number}, {len(parts) + 1} expected")
            return None
        parts.append(packet.data[HEAD.size :])
        if kind != LAST:
            self._open[key] = parts
            return None
        try:
            return packets.parse(b"".join(parts))
        except packets.PacketError as error:
            self.problems.append(f"{packet.title} of transaction {transaction}: {error}")
            return None
