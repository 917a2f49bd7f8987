# SPDX-License-Identifier: Apache-2.0
"""Which ground user a station is: the first WEB user of the mission that no other station on this machine has taken.

The spacecraft tells the connections of one user apart by the requests that they have sent, but not in reports that name no request: an
answer to one of them goes to all. A station of its own user is not disturbed by the others."""

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
        """A user of this mission at this ground port. If all are taken, the first is shared; a mission without such users has only CLI."""
        users = [(user["id"], user["name"]) for user in dictionary.content["users"] if user["name"].startswith(PREFIX)]
        for number, name in users:
            held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            with contextlib.suppress(OSError):
                held.bind(f"\0hirosco-user-{port}-{number}")  # The kernel gives it back however the process ends.
                return cls(number, name, True, held)
            held.close()
        return cls(*users[0], False) if users else cls(GROUND_USER, "CLI", False)

    def release(self):
        """Another station may take the user."""
        if self._held:
            self._held.close()
            self._held = None
