# SPDX-License-Identifier: Apache-2.0
"""Synthetic reports whose layouts are those of the descriptors: housekeeping and events of every subsystem of
a mission."""

import struct

from hirosco_gse import values
from tm_packets import build_tm

SEVERITIES = ("INFORMATIVE", "LOW", "MEDIUM", "HIGH")


def _octets(rng, items):
    """Octets of parameters or fields: random ones; for an enumeration one of its numbers, for characters a text, padded with 0."""
    octets = b""
    for item in items:
        if getattr(item, "fields", ()):
            octets += _octets(rng, item.fields)
        elif isinstance(item.words, values.Bits):
            octets += b"".join(values.encode(item.type, [rng.getrandbits(8 * values.size_of(item.type))]) for _ in range(item.count))
        elif item.words:
            octets += b"".join(values.encode(item.type, [rng.choice(sorted(item.words))]) for _ in range(item.count))
        elif getattr(item, "kind", "") == "character":
            octets += bytes(rng.choices(range(32, 127), k=rng.randrange(item.size + 1))).ljust(item.size, b"\0")
        else:
            octets += rng.randbytes(item.size)
    return octets


def reports_of(dictionary, rng):
    """Octets of one report of each structure of each configuration, and of each event."""
    for subsystem in dictionary.subsystems.values():
        for configuration in subsystem.configurations.values():
            for structure in configuration.structures.values():
                data = struct.pack(">H", structure.id) + _octets(rng, structure.once)
                data += b"".join(_octets(rng, parameters) for times, parameters in structure.repeated for _ in range(times))
                yield build_tm(subsystem.apid, 1, 3, 25, data, 0, dictionary.epoch_ns, 0)
        for event in subsystem.events.values():
            data = struct.pack(">H", event.id) + _octets(rng, event.parameters)
            yield build_tm(subsystem.apid, 1, 5, SEVERITIES.index(event.severity) + 1, data, 0, dictionary.epoch_ns, 0)
