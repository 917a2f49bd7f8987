# SPDX-License-Identifier: Apache-2.0
"""The gateway for ground systems that exchange packets over TCP, such as Yamcs. It forwards telecommands in protected frames, and telemetry
unchanged. It listens on this machine only. Each of its clients has its own connection to the spacecraft and its own session."""

import socket
import threading

from . import link, packets
from .sdls import SecurityError
from .session import LinkLost

PORT = 10025
CHUNK = 65536  # Octets of one read.


def _hang_up(*streams):
    for stream in streams:
        try:
            stream.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # already closed


def _down(spacecraft, client):
    """Forward telemetry until one side closes its connection."""
    try:
        while octets := spacecraft.recv(CHUNK):
            client.sendall(octets)
    except OSError:
        pass  # the other direction reports it
    _hang_up(client)  # Ends the wait of _up for a telecommand.


def _up(client, spacecraft, protect):
    """Forward telecommands, one by one."""
    splitter = packets.Splitter()
    while octets := client.recv(CHUNK):
        for packet in splitter.feed(octets):
            if len(packet) > packets.PACKET_MAX:
                raise LinkLost(f"a packet of {len(packet)} octets; a telecommand has at most {packets.PACKET_MAX}")
            spacecraft.sendall(protect(packet))


def _connect(client, name, target, make_sender, report):
    """Serve one client until its connection ends."""
    try:
        with client, link.connect(*target) as spacecraft:
            spacecraft.settimeout(None)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            telemetry = threading.Thread(target=_down, args=(spacecraft, client), daemon=True)
            telemetry.start()
            try:
                _up(client, spacecraft, make_sender())
            finally:
                _hang_up(spacecraft, client)  # Before the join: it ends the wait of _down for telemetry.
                telemetry.join()
        report(f"gateway: {name} has disconnected")
    except (OSError, SecurityError, LinkLost) as problem:
        report(f"gateway: {name}: {problem}")


def serve(port, target, make_sender, report):
    """Accept clients at a port of this machine (0: any free one) until it is interrupted. make_sender() returns an sdls.Sender for each."""
    with socket.create_server(("127.0.0.1", port)) as listener:
        report(f"gateway: packets at 127.0.0.1:{listener.getsockname()[1]}, frames to {target[0]}:{target[1]}")
        while True:
            client, address = listener.accept()
            name = f"{address[0]}:{address[1]}"
            threading.Thread(target=_connect, args=(client, name, target, make_sender, report), daemon=True).start()
