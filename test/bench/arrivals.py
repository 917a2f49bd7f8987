# SPDX-License-Identifier: Apache-2.0
"""Receive what a TCP port of this machine sends, and note when it arrives: `arrivals.py PORT GREETING`. It sends the greeting, prints an empty
line, receives until its standard input or the connection ends, and then writes the list of (time of arrival [s], octets), pickled.

This is a process of its own: in a program that drives a browser, the lock of the Python interpreter would delay the receiver."""

import gc
import pickle
import select
import socket
import sys
import time


def main(port, greeting):
    """Receive, and write what has arrived."""
    parts = []
    gc.disable()  # A collection of all parts would delay the next one.
    with socket.create_connection(("127.0.0.1", int(port))) as connection:
        connection.sendall(greeting.encode())
        print(flush=True)
        while connection in select.select([connection, sys.stdin], [], [])[0]:
            octets = connection.recv(1 << 16)
            if not octets:
                break
            parts.append((time.monotonic(), octets))
    pickle.dump(parts, sys.stdout.buffer)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
