# SPDX-License-Identifier: Apache-2.0
"""Connections to the spacecraft and the two drivers of procedures: wall-clock time and stepped time.

Stepped time: the operator is a participant of the calendar and joins through its door, a UNIX stream socket
with text lines. It acts only within its grant: it reads exactly the octets announced, resumes its procedure,
sends telecommands, and gives the grant back with its next wake time and the octets it has sent.

    join operator <local tcp port>          ->
                                            <- grant <time_ns> <messages> <octets>
    done <wake_ns|never> <octets sent>      ->
    leave                                   ->
"""

import select
import socket
import time

from .session import LinkLost

NEVER = "never"
CONNECT_PAUSE_S = 0.1


def connect(host, port, patience_s=0.0):
    """TCP connection to the ground port; tries again for patience_s. Raises LinkLost."""
    deadline = time.monotonic() + patience_s
    while True:
        try:
            stream = socket.create_connection((host, port), timeout=5.0)
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return stream
        except OSError as error:
            if time.monotonic() >= deadline:
                reason = error.strerror or str(error)
                raise LinkLost(f"no link to {host}:{port}: {reason}; is a mission running (make sim-run)?") from error
        time.sleep(CONNECT_PAUSE_S)


def _send(stream, outbox):
    octets = bytes(outbox)
    outbox.clear()
    if octets:
        try:
            stream.sendall(octets)
        except OSError as error:
            raise LinkLost(f"the spacecraft closed the link: {error.strerror}") from error
    return len(octets)


def _telling(run, procedure):
    """Run; a lost link is told to the procedure, which may have expected it."""
    try:
        return run(procedure)
    except LinkLost as lost:
        try:
            procedure.throw(lost)
        except StopIteration as end:
            return end.value
        raise


class RealDriver:
    """Runs procedures in wall-clock time.

    Mission time is unknown until the first telemetry; it then follows the packets' times (epoch_ns is the
    packet time of mission time 0), extrapolated by the local clock.
    """

    def __init__(self, stream, session, epoch_ns=None):
        self._stream, self._session, self._epoch_ns = stream, session, epoch_ns
        self._origin_ns = time.monotonic_ns()
        session.listeners.append(self._synchronise)

    def _synchronise(self, packet, _):
        if self._epoch_ns is not None:
            ahead = packet.time_ns - self._epoch_ns - self._now()
            if ahead > 0:
                self._origin_ns -= ahead
                self._session.slipped_ns += ahead

    def _now(self):
        return time.monotonic_ns() - self._origin_ns

    def run(self, procedure):
        """Run to the end; the procedure's return value."""
        return _telling(self._run, procedure)

    def _run(self, procedure):
        session = self._session
        try:
            wake = self._resume(procedure)
            while True:
                _send(self._stream, session.outbox)
                pause = None if wake is None else max(0.0, (wake - self._now()) / 1e9)
                readable, _, _ = select.select([self._stream], [], [], pause)
                if readable:
                    self._receive()
                wake = self._resume(procedure)
        except StopIteration as end:
            _send(self._stream, session.outbox)
            return end.value

    def _resume(self, procedure):
        self._session.now_ns = max(self._session.now_ns, self._now())
        return procedure.send(None)

    def _receive(self):
        try:
            octets = self._stream.recv(65536)
        except OSError as error:
            raise LinkLost(f"link lost: {error.strerror}") from error
        if not octets:
            raise LinkLost("the spacecraft closed the link")
        self._session.now_ns = max(self._session.now_ns, self._now())
        self._session.feed(octets)


class StepClock:
    """Client of the calendar's door."""

    def __init__(self, path, local_port, role="operator", patience_s=0.0):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        deadline = time.monotonic() + patience_s
        while True:
            try:
                self._socket.connect(str(path))
                break
            except OSError as error:
                if time.monotonic() >= deadline:
                    raise LinkLost(f"no calendar at {path}: {error.strerror}") from error
            time.sleep(CONNECT_PAUSE_S / 5)
        self._lines = self._socket.makefile("rb")
        self._write(f"join {role} {local_port}")

    def _write(self, line):
        try:
            self._socket.sendall(line.encode("ascii") + b"\n")
        except OSError as error:
            raise LinkLost(f"the calendar is gone: {error.strerror}") from error

    def grant(self):
        """Wait for the grant: (time_ns, messages, octets). Raises LinkLost when the run is over."""
        try:
            line = self._lines.readline()
        except OSError as error:
            raise LinkLost(f"the calendar is gone: {error.strerror}") from error
        words = line.decode("ascii", "replace").split()
        if len(words) != 4 or words[0] != "grant":
            raise LinkLost("the run has ended" if not line else f"unexpected word of the calendar: {line!r}")
        return int(words[1]), int(words[2]), int(words[3])

    def done(self, wake_ns, sent):
        """Give the grant back."""
        self._write(f"done {NEVER if wake_ns is None else wake_ns} {sent}")

    def leave(self):
        """Leave the calendar; time goes on without us. Once is enough."""
        if self._socket.fileno() < 0:
            return
        try:
            self._write("leave")
        except LinkLost:
            pass  # the run was over first
        self._lines.close()
        self._socket.close()


class StepDriver:
    """Runs procedures within the grants of a StepClock."""

    def __init__(self, stream, session, clock):
        self._stream, self._session, self._clock = stream, session, clock

    def _receive(self, octets):
        while octets:
            try:
                part = self._stream.recv(octets)
            except OSError as error:
                raise LinkLost(f"link lost: {error}") from error
            if not part:
                raise LinkLost(f"the spacecraft closed the link, {octets} octets short of what was announced")
            octets -= len(part)
            self._session.feed(part)

    def run(self, procedure):
        """Run to the end, then hang up and leave; the procedure's return value."""
        return _telling(self._run, procedure)

    def _run(self, procedure):
        session = self._session
        while True:
            session.now_ns, _, octets = self._clock.grant()
            self._receive(octets)
            try:
                wake = procedure.send(None)
                while wake is not None and wake <= session.now_ns:
                    wake = procedure.send(None)
            except StopIteration as end:
                self._clock.done(session.now_ns, _send(self._stream, session.outbox))
                self._leave()
                return end.value
            self._check_open()
            self._clock.done(wake, _send(self._stream, session.outbox))

    def _check_open(self):
        """A spacecraft that has hung up takes no telecommand, though the first one sent to it seems to succeed."""
        if not self._session.outbox:
            return
        try:
            readable, _, _ = select.select([self._stream], [], [], 0)
            is_closed = bool(readable) and self._stream.recv(1, socket.MSG_PEEK) == b""
        except OSError as error:
            raise LinkLost(f"link lost: {error.strerror}") from error
        if is_closed:
            raise LinkLost("the spacecraft closed the link")

    def _leave(self):
        """Hang up and leave within one more grant, so that the spacecraft sees it at a defined time."""
        try:
            _, _, octets = self._clock.grant()
            self._receive(octets)
        except LinkLost:
            pass  # the run was over first
        self._stream.close()
        self._clock.leave()
