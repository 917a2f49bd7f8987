# SPDX-License-Identifier: Apache-2.0
"""Write the packet log of a run as a capture file for Wireshark, with link type USER0, which the generated dissector reads. It needs no package.

Times are mission time, as in the captures of the buses."""

import pathlib
import struct

from . import packet_log
from .files import write_whole

MAGIC_NS, LINK_TYPE, LONGEST = 0xA1B23C4D, 147, 65542
_GLOBAL, _RECORD = struct.Struct("<IHHiIII"), struct.Struct("<IIII")


def capture(rows):
    """Octets of a capture of rows of the packet log."""
    parts = [_GLOBAL.pack(MAGIC_NS, 2, 4, 0, 0, LONGEST, LINK_TYPE)]
    for time_ns, _, _, raw in rows:
        seconds, rest = divmod(time_ns, 1_000_000_000)
        parts += [_RECORD.pack(seconds, rest, len(raw), len(raw)), raw]
    return b"".join(parts)


def write(run):
    """Write packets.pcap of a run; (path, count of packets). Raises OSError, packet_log.LogError."""
    run = pathlib.Path(run)
    rows = packet_log.rows(run / "packets.log")
    path = run / "packets.pcap"
    write_whole(path, lambda stream: stream.write(capture(rows)))
    return path, len(rows)
