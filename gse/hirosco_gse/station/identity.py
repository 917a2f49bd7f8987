# SPDX-License-Identifier: Apache-2.0
"""Choose the ground user of a station: the first WEB user of the mission that no other station on this machine uses.

If several connections belong to one user, the spacecraft sends a verification report to the connection that has sent the request, but other
answers to all of them. A station with a user of its own does not receive the answers to other stations."""

import contextlib
import socket

from ..session import GROUND_USER

PREFIX = "WEB"


class Identity:
    """A ground user, kept until `release` or the end of the process."""

    def __init__(self, number, name, is_own, held=None):
        self.number, self.name, self.is_own, self._held = number, name, is_own, held

    @classmethod
    def claim(cls, dictionary, port):
        """A user of this mission at this ground port. If all are taken, the first one is shared. In a mission without
        such users the station uses the user CLI."""
        users = [(user["id"], user["name"]) for user in dictionary.content["users"] if user["name"].startswith(PREFIX)]
        for number, name in users:
            held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            with contextlib.suppress(OSError):
                held.bind(f"\0hirosco-user-{port}-{number}")  # The kernel releases the name however the process ends.
                return cls(number, name, True, held)
            held.close()
        return cls(*users[0], False) if users else cls(GROUND_USER, "CLI", False)

    def release(self):
        """Release the user, so that another station may take it."""
        if self._held:
            self._held.close()
            self._held = None
