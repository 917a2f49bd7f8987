# SPDX-License-Identifier: Apache-2.0
"""The whole telepresence over vcan, recorded by candump."""

import cases
import socketcan
from socketcan import OUT, WORK, facts, flown, ip, recorder

LIMIT_S = 7200
INTERFACES = ("vcan-robot", "vcan-joystick")


def case_telepresence_is_flown_over_vcan():
    """What is recorded goes straight to the output folder: a million frames are too much for the memory here."""
    WORK.mkdir()
    for interface in INTERFACES:
        ip("link", "add", interface, "mtu", "72", "type", "vcan")
        ip("link", "set", interface, "up")
    dump = OUT / "candump.log"
    with recorder(dump, INTERFACES[0], *INTERFACES):
        flown("telepresence", "--bus", "vcan", "--scenario", "telepresence", seconds=LIMIT_S)
    assert facts("telepresence")["reproducible"]


if __name__ == "__main__":
    socketcan.BOUND_S = LIMIT_S
    cases.run({"case_telepresence_is_flown_over_vcan": case_telepresence_is_flown_over_vcan}, LIMIT_S + 600)
