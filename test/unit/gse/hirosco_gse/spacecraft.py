# SPDX-License-Identifier: Apache-2.0
"""A simulated spacecraft on a TCP port, which answers each telecommand by a function."""

import socket
import struct
import threading

from hirosco_gse import packets
from tm_packets import build_tm


def notice(code, detail, instruction=0):
    """Octets of a failure notice."""
    return struct.pack(">HHI", code, instruction, detail)


MISSION_TIME_NS = 1000 * 10**9  # Time of all reports.


class Spacecraft:
    """Serves one connection at a time. answer(packet) -> list of (apid, service, subtype, data, user); None closes the connection."""

    def __init__(self, answer, epoch_ns=0):
        self._answer, self._epoch_ns = answer, epoch_ns
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self.received = []
        self.connections = 0  # Number of accepted connections.
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        while True:
            try:
                stream, _ = self._server.accept()
            except OSError:
                return
            self.connections += 1
            with stream:
                self._talk(stream)

    def _talk(self, stream):
        splitter = packets.Splitter()
        while True:
            try:
                octets = stream.recv(4096)
            except OSError:
                return
            if not octets:
                return
            for raw in splitter.feed(octets):
                packet = packets.parse(raw)
                self.received.append(packet)
                answer = self._answer(packet)
                if answer is None:
                    return
                reports = [build_tm(apid, 0, service, subtype, data, user, self._epoch_ns + MISSION_TIME_NS) for apid, service, subtype, data, user in answer]
                try:
                    stream.sendall(b"".join(reports))
                except OSError:
                    return

    def close(self):
        """Accept no more connections."""
        self._server.close()


def success(packet, *reports):
    """All verification reports of a request; `reports` come before its completion."""
    request = packet.request_id
    return [
        (packet.apid, 1, 1, request, packet.user),
        (packet.apid, 1, 3, request, packet.user),
        *[(packet.apid, service, subtype, data, packet.user) for service, subtype, data in reports],
        (packet.apid, 1, 7, request, packet.user),
    ]


def failure(packet, subtype, code, detail):
    """A request that fails at a stage."""
    return [(packet.apid, 1, subtype, packet.request_id + notice(code, detail), packet.user)]
