# SPDX-License-Identifier: Apache-2.0
"""Other users of the ground port in a flight that is repeated: reads, performs and records the lines of the actor `ground`.

    <time s> ground connect              open a connection to the ground port
    <time s> ground send HEX             send octets of telecommands on that connection
    <time s> ground hang-up              close it

The operator performs these lines in its grants, also while its own script waits. COMMUNICATION polls its connections every 10 ms. A
line is performed LEAD_NS before the time at which the packet log shows its effect, so that the same poll finds it as in the recorded flight.
"""

import contextlib
import json
import pathlib
import threading
from dataclasses import dataclass

from . import packet_log

LEAD_NS = 1_000_000
COMMUNICATION_APID = 2
CONNECTED, LOST = 1, 2  # events of COMMUNICATION
USAGES = {"connect": 0, "send": 1, "hang-up": 0}
ON_BOARD = 0x8000  # set in the source of a telecommand that a subsystem has sent


class VisitError(ValueError):
    """A line that cannot be performed, or a flight that cannot be recorded."""


@dataclass(frozen=True)
class Visit:
    """One line of the actor `ground`."""

    time_ns: int
    verb: str
    octets: bytes = b""


def parse(place, time_ns, words):
    """The Visit of a line. Raises VisitError."""
    verb, *rest = words
    if verb not in USAGES or len(rest) != USAGES[verb]:
        raise VisitError(f"{place}: found 'ground {' '.join(words)[:60]}', expected ground connect, ground send HEX or ground hang-up")
    try:
        return Visit(time_ns, verb, bytes.fromhex(rest[0]) if rest else b"")
    except ValueError as error:
        raise VisitError(f"{place}: found '{rest[0][:60]}', expected octets as hexadecimal digits") from error


class Visits:
    """Performs the lines in order. connect(): a new connection to the ground port."""

    def __init__(self, lines, connect):
        self._lines, self._connect = list(lines), connect
        self._stream = None

    @property
    def next_ns(self):
        """When the next line is due; None: there is none."""
        return self._lines[0].time_ns if self._lines else None

    def act(self, now_ns):
        """Perform the lines that are due. Raises VisitError."""
        while self._lines and self._lines[0].time_ns <= now_ns:
            self._perform(self._lines.pop(0))

    def _perform(self, visit):
        if visit.verb == "connect":
            self.close()
            self._stream = self._connect()
            threading.Thread(target=_drain, args=(self._stream,), daemon=True).start()
        elif self._stream is None:
            raise VisitError(f"ground {visit.verb} at {visit.time_ns / 1e9:.4f} s: there is no connection; `ground connect` comes first")
        elif visit.verb == "send":
            with contextlib.suppress(OSError):  # The spacecraft may have closed it, as in the flight recorded.
                self._stream.sendall(visit.octets)
        else:
            self.close()

    def close(self):
        """End the connection."""
        if self._stream is not None:
            with contextlib.suppress(OSError):
                self._stream.shutdown(2)
            self._stream.close()
            self._stream = None


def _drain(stream):
    """Read what the spacecraft sends, so that it does not find the connection full."""
    with contextlib.suppress(OSError):
        while stream.recv(65536):
            pass


def _operator_requests(run):
    """(APID, sequence count) of the telecommands of the operator's script."""
    found = set()
    with contextlib.suppress(FileNotFoundError):
        for line in (run / "operator.log").read_text(encoding="utf-8").splitlines():
            found.update(tuple(key) for key in json.loads(line)["asked"])
    return found


def _effects(run):
    """(time, verb, octets) of each action of other users, from the packet log; the first connection is that of the operator."""
    own, has_operator = _operator_requests(run), (run / "operator.log").exists()
    with (run / "packets.log").open(encoding="ascii") as log:
        found = packet_log.parse_packets(log, run / "packets.log")
    for time_ns, direction, packet, raw in found:
        if direction == "TC":  # None: not a telecommand, so the operator has not sent it.
            if packet is None or (packet.user < ON_BOARD and (packet.apid, packet.sequence) not in own):
                yield time_ns, "send", raw
        elif packet.apid == COMMUNICATION_APID and packet.message == (5, 1):
            event = int.from_bytes(packet.data[:2], "big")
            if event == CONNECTED and has_operator:
                has_operator = False
            elif event in (CONNECTED, LOST):
                yield time_ns, "connect" if event == CONNECTED else "hang-up", b""


def recorded(run):
    """Lines of the actor `ground` of a flight, in order. Raises VisitError if two others were connected at once: their telecommands
    cannot be told apart, or if telecommands were protected by a key."""
    run = pathlib.Path(run)
    if (run / "ground.key-file").exists():
        raise VisitError(f"{run}: telecommands were protected by a key; they cannot be sent again")
    lines, is_connected = [], False
    for time_ns, verb, raw in _effects(run):
        if verb == "connect" and is_connected:
            raise VisitError(f"{run}: two users besides the operator were connected at {time_ns / 1e9:.4f} s; their telecommands cannot be told apart")
        if verb == "hang-up" and not is_connected:
            continue  # The operator's, at the end.
        is_connected = verb != "hang-up"
        at_ns = max(0, time_ns - LEAD_NS)
        lines.append((at_ns / 1e9, f"{at_ns / 1e9:.9f} ground {verb}{' ' + raw.hex() if raw else ''}"))
    return lines
