# SPDX-License-Identifier: Apache-2.0
"""CCSDS space packets with PUS-C secondary headers, as the ground uses them.

It builds telecommands and parses telemetry; `Splitter` splits a byte stream into packets.
Tailoring: CRC-16 always, time CUC 4+3 with explicit P-field 0x1F (TAI, epoch 1958), 16-bit user ids.
"""

import binascii
import struct
from dataclasses import dataclass

ACK_ACCEPTANCE, ACK_START, ACK_PROGRESS, ACK_COMPLETION = 0x1, 0x2, 0x4, 0x8
ACK_ALL = 0xF
PUS_VERSION = 2
P_FIELD = 0x1F
TC_HEADER, TM_HEADER, PRIMARY_HEADER, CRC_SIZE = 11, 21, 6, 2
TIME_PACKET = 18  # Spacecraft time packet: APID 0, no secondary header; rate, time and status.
PACKET_MAX = 4096
LARGE_MAX = 65542  # Limit of the length field; packets longer than PACKET_MAX are transferred by ST[13].
FRACTION = 1 << 24  # Units of the fraction of a time in a second.


class PacketError(ValueError):
    """A malformed packet; the text gives the reason."""


def crc16(data):
    """CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF."""
    return binascii.crc_hqx(data, 0xFFFF)


def encode_time(time_ns):
    """CUC 4+3 with P-field, of nanoseconds since 1958 TAI."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    return struct.pack(">BI", P_FIELD, seconds) + (rest * FRACTION // 1_000_000_000).to_bytes(3, "big")


def decode_time(octets):
    """Nanoseconds since 1958 TAI (rounded to nearest) of eight octets CUC."""
    if len(octets) != 8:
        raise PacketError(f"time field has {len(octets)} octets, expected 8")
    if octets[0] != P_FIELD:
        raise PacketError(f"time P-field is 0x{octets[0]:02X}, expected 0x{P_FIELD:02X}")
    seconds = int.from_bytes(octets[1:5], "big")
    fraction = int.from_bytes(octets[5:8], "big")
    return seconds * 1_000_000_000 + (fraction * 1_000_000_000 + FRACTION // 2) // FRACTION


@dataclass(frozen=True)
class Packet:
    """One space packet. `user` is the source id of a TC and the destination id of a TM."""

    direction: str
    apid: int
    sequence: int
    service: int
    subtype: int
    user: int
    data: bytes
    raw: bytes
    ack: int = 0
    counter: int = 0
    time_ns: int = 0

    @property
    def message(self):
        return self.service, self.subtype

    @property
    def request_id(self):
        """The first four octets, by which reports name a request."""
        return self.raw[:4]

    @property
    def title(self):
        """Name of the message type in the standard's notation, such as TM[17,2]."""
        return f"{self.direction}[{self.service},{self.subtype}]"


def build_tc(apid, sequence, service, subtype, data=b"", source=1, ack=ACK_ALL):
    if not 0 <= apid <= 0x7FF:
        raise PacketError(f"APID is {apid}, expected 0 to 2047")
    length = TC_HEADER + len(data) + CRC_SIZE
    if length > LARGE_MAX:
        raise PacketError(f"packet has {length} octets, expected at most {LARGE_MAX}")
    head = struct.pack(
        ">HHHBBBH",
        0x1800 | apid,
        0xC000 | (sequence & 0x3FFF),
        length - 7,
        PUS_VERSION << 4 | ack,
        service,
        subtype,
        source,
    )
    body = head + bytes(data)
    return body + struct.pack(">H", crc16(body))


def _time_packet(raw, sequence):
    """Parse a spacecraft time packet as the report that it represents: TM[9,2] if its time is CUC, otherwise TM[9,3]."""
    if len(raw) != TIME_PACKET:
        raise PacketError(f"spacecraft time packet of {len(raw)} octets, expected {TIME_PACKET}")
    field = raw[PRIMARY_HEADER + 1 : PRIMARY_HEADER + 9]
    is_cuc = field[0] == P_FIELD
    day, ms, us = struct.unpack(">HIH", field)
    time_ns = decode_time(field) if is_cuc else (day * 86_400_000 + ms) * 1_000_000 + us * 1000
    subtype = 2 if is_cuc else 3
    return Packet("TM", 0, sequence, 9, subtype, 0, raw[PRIMARY_HEADER:-2], raw, time_ns=time_ns)


def parse(raw):
    """The Packet in exactly these octets. Raises PacketError."""
    raw = bytes(raw)
    if len(raw) < PRIMARY_HEADER:
        raise PacketError(f"packet has {len(raw)} octets, too short for a primary header: expected at least {PRIMARY_HEADER}")
    word, sequence, length = struct.unpack(">HHH", raw[:PRIMARY_HEADER])
    if word >> 13:
        raise PacketError(f"packet version number is {word >> 13}, expected 0")
    if len(raw) != length + 7:
        raise PacketError(f"length field says {length + 7} octets, the packet has {len(raw)}")
    if sequence >> 14 != 3:
        raise PacketError(f"sequence flags are {sequence >> 14}, expected 3 (unsegmented)")
    if not word & 0x0800 and word:
        raise PacketError("secondary header flag is 0, expected 1")
    if crc16(raw):
        raise PacketError(f"CRC is wrong: computed 0x{crc16(raw[:-2]):04X}, found 0x{raw[-2:].hex().upper()}")
    if word == 0:
        return _time_packet(raw, sequence & 0x3FFF)
    is_tc = bool(word & 0x1000)
    least = (TC_HEADER if is_tc else TM_HEADER) + CRC_SIZE
    if len(raw) < least:
        raise PacketError(f"packet has {len(raw)} octets, too short for a {'TC' if is_tc else 'TM'}: expected at least {least}")
    if raw[6] >> 4 != PUS_VERSION:
        raise PacketError(f"PUS version is {raw[6] >> 4}, expected {PUS_VERSION}")
    common = {"apid": word & 0x7FF, "sequence": sequence & 0x3FFF, "service": raw[7], "subtype": raw[8], "raw": raw}
    if is_tc:
        user = struct.unpack(">H", raw[9:11])[0]
        return Packet("TC", user=user, data=raw[TC_HEADER:-2], ack=raw[6] & 0xF, **common)
    counter, user = struct.unpack(">HH", raw[9:13])
    time_ns = decode_time(raw[13:21])
    return Packet("TM", user=user, data=raw[TM_HEADER:-2], counter=counter, time_ns=time_ns, **common)


class Splitter:
    """Splits a stream of back-to-back packets; `feed` returns the complete packets as octets."""

    def __init__(self):
        self._buffer = bytearray()

    def feed(self, octets):
        """The packets that these octets complete, in order."""
        self._buffer += octets
        packets = []
        while len(self._buffer) >= PRIMARY_HEADER:
            size = int.from_bytes(self._buffer[4:6], "big") + 7
            if len(self._buffer) < size:
                break
            packets.append(bytes(self._buffer[:size]))
            del self._buffer[:size]
        return packets
