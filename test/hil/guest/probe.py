# SPDX-License-Identifier: Apache-2.0
"""Print the kernel features that the hardware-in-the-loop tests need and that are missing, one on each line;
exit code 0 if none is missing. Run it in a separate network namespace, because it makes interfaces."""

import socket
import subprocess
import sys


def command(*words):
    try:
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    except FileNotFoundError:
        raise OSError(f"there is no command {words[0]}") from None
    if done.returncode != 0:
        raise OSError(done.stderr.strip() or f"{' '.join(words)}: exit code {done.returncode}")


def vcan():
    command("ip", "link", "add", "probe0", "type", "vcan")
    command("ip", "link", "set", "probe0", "mtu", "72", "up")
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as endpoint:
        endpoint.bind(("probe0",))
    command("ip", "link", "delete", "probe0")


def vxcan():
    command("ip", "link", "add", "probe0", "type", "vxcan", "peer", "name", "probe1")
    command("ip", "link", "delete", "probe0")


def tipc():
    with socket.socket(socket.AF_TIPC, socket.SOCK_RDM) as endpoint:
        endpoint.bind((socket.TIPC_ADDR_NAMESEQ, 0x4849, 0, 0, socket.TIPC_NODE_SCOPE))


def namespaces():
    command("ip", "netns", "add", "probe")
    command("ip", "netns", "exec", "probe", "ip", "link", "set", "lo", "up")
    command("ip", "netns", "delete", "probe")


def main():
    lacking = []
    for needed in (vcan, vxcan, tipc, namespaces):
        try:
            needed()
        except OSError as reason:
            lacking.append(f"no {needed.__name__}: {reason}")
    print("\n".join(lacking))
    return 1 if lacking else 0


if __name__ == "__main__":
    sys.exit(main())
