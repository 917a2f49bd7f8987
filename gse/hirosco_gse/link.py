# SPDX-License-Identifier: Apache-2.0
"""Connections to the spacecraft and the two drivers of procedures: wall-clock time and stepped time.

Stepped time: the operator is a participant of the scheduler and connects to its co-simulation port, a UNIX stream socket
with text lines. It acts only within its grant: it reads exactly the octets announced, resumes its procedure,
sends telecommands, and returns the grant with its next wake time, the octets it has sent and the local port of
its connection.

    join operator <local tcp port>                  ->
                                                    <- grant <time_ns> <messages> <octets> <served port|0>
    done <wake_ns|never> <octets sent> <local port> ->
    leave                                           ->

The scheduler reports when `communication` begins to serve a connection and when the connection has ended. The state of
the socket is not used, because the kernel reports both events later. Telecommands wait until the connection is served.
When the connection has ended, octets in transit are lost, and the operator connects again at once.

While its procedure ignores telemetry (session.Pause), the operator reads the octets and returns the grant. It decodes the octets
at the end of the pause, together, because that takes less time; if a listener wants the reports, or if there are many octets,
it decodes them while the flight continues.
"""

import os
import select
import socket
import time

from .session import LinkLost, Pause

NEVER = "never"
CONNECT_PAUSE_S = 0.1  # Time between two attempts to connect.
UNDECODED_MAX = 65536  # Octets that an operator keeps undecoded during a pause.
CLOSED = "the spacecraft closed the link; if all its connection slots are used, one becomes free within 30 s: try again"


def words_of(error):
    """Words for an error of a connection: those of the system, because those of asyncio also contain number and address."""
    return os.strerror(error.errno) if isinstance(error, ConnectionError) and error.errno else getattr(error, "strerror", None) or str(error)


def connect(host, port, timeout_s=0.0):
    """TCP connection to the ground port; tries again for timeout_s. Raises LinkLost."""
    deadline = time.monotonic() + timeout_s
    while True:
        try:
            stream = socket.create_connection((host, port), timeout=5.0)
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return stream
        except OSError as error:
            if time.monotonic() >= deadline:
                raise LinkLost(f"no link to {host}:{port}: {words_of(error)}; is a mission running (make sim-run)?") from error
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


def _reporting(run, procedure):
    """Run a procedure. LinkLost is raised in the procedure, too, because it may expect the end of the link."""
    try:
        return run(procedure)
    except LinkLost as lost:
        try:
            procedure.throw(lost)
        except StopIteration as end:
            return end.value
        raise


class WallClock:
    """The time of a session in wall-clock time.

    Mission time is unknown until the first telemetry; then it is taken from the packets' times (epoch_ns is the
    packet time of mission time 0), extrapolated by the local clock.
    """

    def __init__(self, session, epoch_ns=None):
        self._session, self._epoch_ns = session, epoch_ns
        self._origin_ns = time.monotonic_ns()
        session.follow = self._synchronise

    def _synchronise(self, packet):
        if self._epoch_ns is not None:
            ahead = packet.time_ns - self._epoch_ns - self._now()
            if ahead > 0:
                self._origin_ns -= ahead
                self._session.slipped_ns += ahead

    def _now(self):
        return time.monotonic_ns() - self._origin_ns

    def resume(self, procedure):
        """Resume a procedure at the present time. Returns the time at which it must be resumed even without telemetry;
        None: never."""
        self._session.now_ns = max(self._session.now_ns, self._now())
        return procedure.send(None)

    def seconds_until(self, wake_ns):
        """Seconds from now to a time of the session."""
        return max(0.0, (wake_ns - self._now()) / 1e9)


class RealDriver(WallClock):
    """Runs procedures in wall-clock time, one after the other."""

    def __init__(self, stream, session, epoch_ns=None):
        super().__init__(session, epoch_ns)
        self._stream = stream

    def run(self, procedure):
        """Run to the end. Returns the value of the procedure."""
        return _reporting(self._run, procedure)

    def _run(self, procedure):
        session = self._session
        try:
            wake = self.resume(procedure)
            while True:
                _send(self._stream, session.outbox)
                pause = None if wake is None else self.seconds_until(wake)
                readable, _, _ = select.select([self._stream], [], [], pause)
                if readable:
                    self._receive()
                wake = self.resume(procedure)
        except StopIteration as end:
            _send(self._stream, session.outbox)
            return end.value

    def _receive(self):
        try:
            octets = self._stream.recv(65536)
        except OSError as error:
            raise LinkLost(f"link lost: {error.strerror}") from error
        if not octets:
            raise LinkLost(CLOSED)
        self._session.now_ns = max(self._session.now_ns, self._now())
        self._session.feed(octets)


class StepClock:
    """Client of the scheduler's co-simulation port."""

    def __init__(self, path, local_port, role="operator", timeout_s=0.0):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                self._socket.connect(str(path))
                break
            except OSError as error:
                if time.monotonic() >= deadline:
                    raise LinkLost(f"no scheduler at {path}: {error.strerror}; expected the socket of a run in stepped time that has not ended") from error
            time.sleep(CONNECT_PAUSE_S / 5)
        self._unread = b""
        self._port = local_port
        self._write(f"join {role} {local_port}")

    def _write(self, line):
        try:
            self._socket.sendall(line.encode("ascii") + b"\n")
        except OSError as error:
            raise LinkLost(f"the connection to the scheduler was lost: {error.strerror}") from error

    def _read_line(self):
        """The next line without its end; empty when the run is over. A buffered file of the socket would be slower: it reads by
        functions in Python."""
        while b"\n" not in self._unread:
            try:
                part = self._socket.recv(256)
            except OSError as error:
                raise LinkLost(f"the connection to the scheduler was lost: {error.strerror}") from error
            if not part:
                return b""
            self._unread += part
        line, _, self._unread = self._unread.partition(b"\n")
        return line

    def grant(self):
        """Wait for the grant. Returns (time_ns, octets, whether the connection is served). Raises LinkLost when the run is over."""
        line = self._read_line()
        words = line.decode("ascii", "replace").split()
        if len(words) != 5 or words[0] != "grant":
            raise LinkLost("the run has ended" if not line else f"found {line[:60]!r} from the scheduler, expected `grant` and four numbers")
        return int(words[1]), int(words[3]), int(words[4]) == self._port != 0

    def moved(self, local_port):
        """Use another connection after the end of this grant."""
        self._port = local_port

    def done(self, wake_ns, sent):
        self._write(f"done {NEVER if wake_ns is None else wake_ns} {sent} {self._port}")

    def leave(self):
        """Leave the scheduler; time continues without this participant. A second call has no effect."""
        if self._socket.fileno() < 0:
            return
        try:
            self._write("leave")
        except LinkLost:
            pass  # the run has already ended
        self._socket.close()


def attend(clock, visits):
    """Perform the actions of other users (visits.Visits) in the grants of a StepClock that has no connection of its own, then leave."""
    while visits.next_ns is not None:
        now_ns, _, _ = clock.grant()
        visits.act(now_ns)
        clock.done(now_ns if visits.next_ns is None else visits.next_ns, 0)
    clock.grant()  # A participant leaves in a grant.
    clock.leave()


class StepDriver:
    """Runs procedures within the grants of a StepClock."""

    def __init__(self, stream, session, clock, reconnect=None, report=lambda text: None, visits=None):
        """reconnect(): opens another connection; None: a lost connection ends the procedure. report(text) is called at
        each change of the connection. visits: the actions of other users (visits.Visits)."""
        self._visits = visits
        self._stream, self._session, self._clock = stream, session, clock
        session.follow = None  # Time passes only by grants.
        self._reconnect, self._report = reconnect, report
        self._is_served = self._was_lost = False
        self._undecoded = bytearray()

    def _grant(self):
        try:
            return self._clock.grant()
        except LinkLost:
            self._decode()  # The procedure reads the reports that came before the end of the run.
            raise

    def _decode(self):
        octets = bytes(self._undecoded)
        self._undecoded.clear()
        self._session.feed(octets)

    def _read(self, octets):
        """Read the announced octets. If the connection has ended, decode what came before."""
        while octets > 0:
            try:
                part = self._stream.recv(octets)
            except OSError:
                part = b""
            if not part:  # The process `communication` was killed from outside of the run; the scheduler has not reported it yet.
                self._lose()
                return
            self._undecoded += part
            octets -= len(part)

    def _lose(self):
        self._is_served, self._was_lost = False, True
        self._stream.close()
        self._decode()
        lost = self._session.link_lost()
        if self._reconnect is None:
            raise LinkLost("the spacecraft closed the link")
        self._report(f"the link is lost; {lost} {'request has' if lost == 1 else 'requests have'} no end of verification")
        self._stream = self._reconnect()
        self._clock.moved(self._stream.getsockname()[1])

    def _follow(self, is_served):
        if self._is_served and not is_served:
            self._lose()
        if is_served and not self._is_served and self._was_lost:
            self._report("the link is open again")
        self._is_served = is_served

    def _send(self):
        """Send the queued octets and return their number; while the connection is not served, they wait."""
        if not self._is_served:
            return 0
        try:
            return _send(self._stream, self._session.outbox)
        except LinkLost:
            self._lose()
            return 0

    def run(self, procedure):
        """Run to the end, then close the connection and leave. Returns the value of the procedure."""
        return _reporting(self._run, procedure)

    def _run(self, procedure):
        session, wake = self._session, None
        while True:
            session.now_ns, octets, is_served = self._grant()
            self._follow(is_served)
            self._read(octets)
            if self._visits is not None:
                self._visits.act(session.now_ns)
            if isinstance(wake, Pause) and session.now_ns < wake:
                self._clock.done(self._earlier(wake), self._send())
                if session.listeners or len(self._undecoded) > UNDECODED_MAX:
                    self._decode()
                continue
            self._decode()
            try:
                wake = procedure.send(None)
                while wake is not None and wake <= session.now_ns:
                    wake = procedure.send(None)
            except StopIteration as end:
                self._clock.done(session.now_ns, self._send())
                self._leave()
                return end.value
            self._clock.done(self._earlier(wake), self._send())

    def _earlier(self, wake):
        """The earlier of the procedure's wake time and the next visit; None: no time."""
        visit = self._visits.next_ns if self._visits is not None else None
        return min((time for time in (wake, visit) if time is not None), default=None)

    def _leave(self):
        """Close the connection and leave within one more grant, so that the spacecraft notices it at a defined time."""
        self._reconnect = None
        try:
            _, octets, _ = self._clock.grant()
            self._read(octets)
            self._decode()
        except LinkLost:
            pass  # the run has already ended
        self._stream.close()
        self._clock.leave()
