# SPDX-License-Identifier: Apache-2.0
"""Requests that a station sends by itself, not for an operator, as a packet log shows them."""

from .display import ID
from .identity import PREFIX

READ = {(3, 27), (3, 33), (130, 8), (131, 8)}  # One report of a structure, its state, real-time links, subsystems.
# Requests about the display structure: create; delete, enable, disable. Its id is the first field of TC[3,1], and the last of the others.
CREATE, ENABLE = {(3, 1)}, {(3, 3), (3, 5), (3, 6)}


def is_own(packet, dictionary):
    """Whether a telecommand is one that stations send by themselves. An operator who sends the same request from a page cannot be told apart."""
    users = {user["id"] for user in dictionary.content["users"] if user["name"].startswith(PREFIX)}
    if packet.user not in users:
        return False
    structure = packet.data[:2] if packet.message in CREATE else packet.data[-2:] if packet.message in ENABLE else b""
    return packet.message in READ or structure == ID.to_bytes(2, "big")
