# SPDX-License-Identifier: Apache-2.0
"""Telemetry packets as a spacecraft builds them, for tests of the ground segment."""

import struct

from hirosco_gse.packets import CRC_SIZE, PUS_VERSION, TM_HEADER, crc16, encode_time


def build_tm(apid, sequence, service, subtype, data=b"", destination=0, time_ns=0, counter=0):
    """Return the octets of one telemetry packet. `time_ns`: since 1958-01-01 TAI; `counter`: the message type counter."""
    head = struct.pack(
        ">HHHBBBHH",
        0x0800 | apid,
        0xC000 | (sequence & 0x3FFF),
        TM_HEADER + len(data) + CRC_SIZE - 7,
        PUS_VERSION << 4,
        service,
        subtype,
        counter & 0xFFFF,
        destination,
    )
    body = head + encode_time(time_ns) + bytes(data)
    return body + struct.pack(">H", crc16(body))
