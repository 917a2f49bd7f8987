# SPDX-License-Identifier: Apache-2.0
"""The whole telepresence over vcan, recorded by candump."""

import shutil

import cases
import socketcan
from socketcan import OUT, WORK, facts, flown, ip, recorder

LIMIT_S = 7200
BACKLOG = 1 << 28
INTERFACES = ("vcan-robot", "vcan-joystick")


def case_telepresence_is_flown_over_vcan():
    """The recorder writes to memory: the output directory would be too slow. Most of the flight fits into its
    backlog."""
    WORK.mkdir()
    for interface in INTERFACES:
        ip("link", "add", interface, "mtu", "72", "type", "vcan")
        ip("link", "set", interface, "up")
    dump = WORK / "candump.log"
    with recorder(dump, INTERFACES[0], *INTERFACES, backlog=BACKLOG):
        flown("telepresence", "--bus", "vcan", "--scenario", "telepresence", seconds=LIMIT_S)
    shutil.copy(dump, OUT / dump.name)
    assert facts("telepresence")["reproducible"]


if __name__ == "__main__":
    socketcan.BOUND_S = LIMIT_S
    cases.run({"case_telepresence_is_flown_over_vcan": case_telepresence_is_flown_over_vcan}, LIMIT_S + 600)
