# SPDX-License-Identifier: Apache-2.0
"""Requests that a station sends by itself, not for an operator, as a packet log shows them."""

import struct

from .identity import PREFIX

READ = {(3, 27), (3, 33), (130, 8), (131, 8)}  # One report of a structure, its state, real-time links, subsystems.
ENABLE = {(3, 5), (3, 6)}  # Periodic generation of the display structure is enabled and disabled.


def is_own(packet, dictionary):
    """Whether a telecommand is one that stations send by themselves. An operator who sends the same request from a page cannot be told apart."""
    users = {user["id"] for user in dictionary.content["users"] if user["name"].startswith(PREFIX)}
    if packet.user not in users:
        return False
    return packet.message in READ or (packet.message in ENABLE and packet.data in _displays(packet.apid, dictionary))


def _displays(apid, dictionary):
    """Octets of the requests TC[3,5] and [3,6] for each of the display structures of a subsystem: the number of ids, 1, and the id."""
    subsystem = dictionary.subsystem_of_apid(apid)
    return [struct.pack(">BH", 1, item.display.id) for item in subsystem.configurations.values() if item.display] if subsystem else []
