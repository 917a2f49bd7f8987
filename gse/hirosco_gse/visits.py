# SPDX-License-Identifier: Apache-2.0
"""Other users of the ground port in a flight that is repeated: reads, performs and records the lines of the actor `ground`.

    <time s> ground connect [NAME]       open a connection to the ground port
    <time s> ground send HEX [NAME]      send octets of telecommands on that connection
    <time s> ground hang-up [NAME]       close it

NAME distinguishes connections that are open at the same time.

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
    name: str = ""


def parse(place, time_ns, words):
    """The Visit of a line. Raises VisitError."""
    verb, *rest = words
    count = USAGES.get(verb, 0)
    if verb not in USAGES or len(rest) not in (count, count + 1):
        raise VisitError(f"{place}: found 'ground {' '.join(words)[:60]}', expected ground connect, ground send HEX or ground hang-up, and a name if there are several")
    try:
        return Visit(time_ns, verb, bytes.fromhex(rest[0]) if count else b"", rest[count] if len(rest) > count else "")
    except ValueError as error:
        raise VisitError(f"{place}: found '{rest[0][:60]}', expected octets as hexadecimal digits") from error


class Visits:
    """Performs the lines in order. connect(): a new connection to the ground port."""

    def __init__(self, lines, connect):
        self._lines, self._connect = list(lines), connect
        self._streams = {}

    @property
    def next_ns(self):
        """Time at which the next line is due; None: there is none."""
        return self._lines[0].time_ns if self._lines else None

    def act(self, now_ns):
        """Perform the lines that are due. Raises VisitError."""
        while self._lines and self._lines[0].time_ns <= now_ns:
            self._perform(self._lines.pop(0))

    def _perform(self, visit):
        stream = self._streams.get(visit.name)
        if visit.verb == "connect":
            self._hang_up(visit.name)
            self._streams[visit.name] = stream = self._connect()
            threading.Thread(target=_drain, args=(stream,), daemon=True).start()
        elif stream is None:
            named = f" {visit.name}" if visit.name else ""
            raise VisitError(f"ground {visit.verb}{named} at {visit.time_ns / 1e9:.4f} s: there is no connection; `ground connect{named}` comes first")
        elif visit.verb == "send":
            # The spacecraft may have closed the connection, as in the recorded flight.
            with contextlib.suppress(OSError):
                stream.sendall(visit.octets)
        else:
            self._hang_up(visit.name)

    def _hang_up(self, name):
        stream = self._streams.pop(name, None)
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.shutdown(2)
            stream.close()

    def close(self):
        """End all connections."""
        for name in list(self._streams):
            self._hang_up(name)


def _drain(stream):
    """Read and discard the octets that the spacecraft sends, so that the connection never fills up."""
    with contextlib.suppress(OSError):
        while stream.recv(65536):
            pass


def _operator_requests(run):
    """(APID, sequence count) of the telecommands of the operator's script."""
    found = set()
    with contextlib.suppress(FileNotFoundError):
        text = (run / "operator.log").read_text(encoding="utf-8", errors="backslashreplace")
        for number, line in enumerate(text.splitlines(), 1):
            try:
                found.update(tuple(key) for key in json.loads(line).get("asked") or ())
            except (ValueError, AttributeError, TypeError) as problem:
                raise VisitError(f"{run / 'operator.log'}:{number}: found {line[:60]!r}, expected a step of the operator; is the log damaged?") from problem
    return found


def _effects(run):
    """(time, verb, octets, user or None) of each action of other users, from the packet log; the first connection is that of the operator."""
    own, has_operator = _operator_requests(run), (run / "operator.log").exists()
    for time_ns, direction, packet, raw in packet_log.rows(run / "packets.log"):
        if direction == "TC":  # packet is None for octets that are not a telecommand; the operator does not send such octets.
            if packet is None or (packet.user < ON_BOARD and (packet.apid, packet.sequence) not in own):
                yield time_ns, "send", raw, None if packet is None else packet.user
        elif packet is not None and packet.apid == COMMUNICATION_APID and packet.message == (5, 1):
            event = int.from_bytes(packet.data[:2], "big")
            if event == CONNECTED and has_operator:
                has_operator = False
            elif event in (CONNECTED, LOST):
                yield time_ns, "connect" if event == CONNECTED else "hang-up", b"", None


class _Connections:
    """Assigns a connection to each action. The packet log does not contain connections, only the user of each telecommand. A user gets the
    oldest connection that no user has yet. If a connection ends, it is the newest one whose user sends nothing until the next connection
    begins. Connections without telecommands need not be distinguished, because what they receive is sent to all."""

    def __init__(self, effects):
        self._effects, self._at = effects, 0
        self._open, self._count = {}, 0  # name -> user

    def name_of(self, verb, user):
        """Name for the next action; None: there is no such connection."""
        self._at += 1
        if verb == "connect":
            self._count += 1
            self._open[str(self._count)] = None
            return str(self._count)
        if verb == "hang-up":
            name = self._ending()
            self._open.pop(name, None)
            return name
        names = [name for name, of in self._open.items() if of == user] or [name for name, of in self._open.items() if of is None]
        if names and user is not None:
            self._open[names[0]] = user
        return names[0] if names else next(iter(self._open), None)

    @property
    def count(self):
        """Connections that are open."""
        return len(self._open)

    def _ending(self):
        later = set()
        for _, verb, _, user in self._effects[self._at :]:
            if verb == "connect":
                break
            later.add(user)
        silent = [name for name, user in self._open.items() if user is None or user not in later]
        return (silent or list(self._open) or [None])[-1]


def recorded(run):
    """Lines of the actor `ground` of a flight, in order. Raises VisitError if telecommands were protected by a key."""
    run = pathlib.Path(run)
    if (run / "ground.key-file").exists():
        raise VisitError(f"{run}: telecommands were protected by a key; they cannot be sent again")
    effects = list(_effects(run))
    connections, actions, most = _Connections(effects), [], 0
    for time_ns, verb, raw, user in effects:
        name = connections.name_of(verb, user)
        if name is None:
            if verb == "hang-up":
                continue  # The connection of the operator, which ends with the flight.
            raise VisitError(f"{run}: a telecommand at {time_ns / 1e9:.4f} s came on no connection of the packet log; is the log complete?")
        most = max(most, connections.count)
        actions.append((max(0, time_ns - LEAD_NS), verb, raw, name))
    found = []
    for at_ns, verb, raw, name in actions:
        words = [verb, *([raw.hex()] if raw else []), *([name] if most > 1 else [])]
        found.append((at_ns / 1e9, f"{at_ns / 1e9:.9f} ground {' '.join(words)}"))
    return found
