# SPDX-License-Identifier: Apache-2.0
"""The state of a ground user: requests, their verification, and the last reported values.

The session is passive: the caller feeds it received octets, and octets to send wait in `outbox`. A *procedure* is a generator that
yields the mission time [ns] at which it wants to wake (or None: only when something arrives) and is resumed by a
driver (link.py) at that time or whenever telemetry arrived, with `session.now_ns` set. The same procedure
therefore runs in stepped and in real time. If it yields a Pause, it ignores telemetry until that time.
"""

import collections
import random
from dataclasses import dataclass, field

from . import large, packets, telecommands, telemetry
from .dictionary import STATES, SUPERVISOR_APID
from .failures import FINAL_SUBTYPES, STAGES, Failure
from .values import TEXT_MAX, shortened

GROUND_USER = 1  # Source id of telecommands of the command line.
OUT_OF_RANGE = 0x0203  # Failure code of a value outside its limits.

HOUSEKEEPING = (3, 25)  # Message of the reports that are decoded only if they are read.
ENDED = 32  # Maximum number of ended requests whose reports may still arrive in parts.
ASKED = 0x4000  # Maximum number of sent packets that are stored until a script logs them.


class SessionError(Exception):
    """A request was not performed."""


class Rejected(SessionError):
    """The spacecraft refused the request or failed to perform it."""

    def __init__(self, request, failure, dictionary):
        limits = telecommands.beyond_limits(request, dictionary) if failure.code == OUT_OF_RANGE else ""
        super().__init__(f"{request.text}: {failure.words(dictionary)}{f': {limits}' if limits else ''}")
        self.request, self.failure = request, failure


class TimedOut(SessionError):
    """An expected report did not arrive in time."""


class LinkLost(SessionError):
    """No connection to the ground port, or it was closed."""


class RequestLost(SessionError):
    """The connection ended before the end of verification arrived; the request may have been performed."""


class Pause(int):
    """Time [ns] at which a procedure wants to wake; until then it ignores telemetry."""


@dataclass(frozen=True)
class Request:
    """One telecommand before it gets its sequence count."""

    apid: int
    service: int
    subtype: int
    data: bytes = b""
    text: str = ""

    def __post_init__(self):
        object.__setattr__(self, "text", shortened(self.text, TEXT_MAX))


@dataclass
class Verification:
    """The verification reports of a sent request."""

    request: Request
    request_id: bytes
    sent_ns: int
    stages: list = field(default_factory=list)
    failure: Failure = None  # The last failure.
    failures: list = field(default_factory=list)  # A request of several instructions may have several.
    is_finished: bool = False
    lost_ns: int = None  # Time at which the connection ended before the end of verification arrived.
    replies: list = field(default_factory=list)  # Other reports to this user since the request was sent.
    whole: object = None  # The Verification of the long request of which this request contains a part.


class Session:
    """State of one ground user."""

    def __init__(self, dictionary, first_sequence=None, source=GROUND_USER, protect=bytes):
        """first_sequence None: every APID starts at a random count, as interactive users must. protect(packet) returns
        the octets that are sent for a packet (sdls.Sender)."""
        self.dictionary = dictionary
        self.source = source
        self._protect = protect
        self.now_ns = 0
        self.slipped_ns = 0  # Time by which the driver has advanced its clock without waiting.
        self.outbox = bytearray()
        self.listeners = []  # called with (packet, decoded)
        self.follow = None  # follow(packet) lets the clock of a driver follow the time of telemetry.
        self.states = {}  # APID -> name of the last reported state
        self.configurations = {}  # APID -> last reported configuration id
        self.links = {}  # name of a link that this user has opened -> its id
        self.events = []  # (packet, decoded) of ST[05], in order
        self.housekeeping = {}  # (APID, octets of the structure's id) -> (last report, id of the configuration), the newest at the end
        self.mode = None
        self.asked = collections.deque(maxlen=ASKED)  # (APID, sequence count) of each packet of a request, in order.
        self.malformed = []
        self.mismatches = {}  # APID, or CLASSES -> error text: what flies differs from the dictionary
        self._awaited = collections.Counter()  # (APID, name of the event) -> events that wait_event has returned
        self._splitter = packets.Splitter()
        self._first = first_sequence
        self._sequences = {}
        self._open = {}
        self._ended = collections.deque(maxlen=ENDED)
        self._assembler = large.Assembler()
        self._transaction = random.randrange(0x10000) if first_sequence is None else first_sequence

    def sequence(self, apid):
        """Next sequence count of an APID."""
        if apid not in self._sequences:
            self._sequences[apid] = random.randrange(0x4000) if self._first is None else self._first
        count = self._sequences[apid]
        self._sequences[apid] = (count + 1) & 0x3FFF
        return count

    def send(self, request):
        """Queue a request; its Verification is updated by the reports."""
        raw = packets.build_tc(
            request.apid, self.sequence(request.apid), request.service, request.subtype, request.data, self.source
        )
        return self.send_raw(raw, request)

    def send_raw(self, raw, request):
        """Queue octets unchanged; octets longer than a packet are sent in parts."""
        verification = Verification(request, bytes(raw[:4]), self.now_ns)
        self._open[verification.request_id] = verification
        if len(raw) <= packets.PACKET_MAX:
            self._put(raw)
        else:
            self._send_parts(raw, verification)
        return verification

    def _put(self, raw):
        self.asked.append((int.from_bytes(raw[:2], "big") & 0x7FF, int.from_bytes(raw[2:4], "big") & 0x3FFF))
        self.outbox += self._protect(raw)

    def _send_parts(self, raw, whole):
        for subtype, data in large.cut(bytes(raw), self._transaction):
            count = self.sequence(SUPERVISOR_APID)
            part = packets.build_tc(SUPERVISOR_APID, count, large.SERVICE, subtype, data, self.source, packets.ACK_COMPLETION)
            request = Request(SUPERVISOR_APID, large.SERVICE, subtype, data, f"part of {whole.request.text}")
            self._open[part[:4]] = Verification(request, part[:4], self.now_ns, whole=whole)
            self._put(part)
        self._transaction = (self._transaction + 1) & 0xFFFF

    def link_lost(self):
        """The connection has ended; another one follows. Returns the number of requests without an end of verification. Octets in
        the queue wait for the next connection."""
        lost = [verification for verification in self._open.values() if verification.whole is None]
        for verification in self._open.values():
            verification.lost_ns, verification.is_finished = self.now_ns, True
        self._open.clear()
        self._splitter = packets.Splitter()
        self._assembler = large.Assembler()
        return len(lost)

    def feed(self, octets):
        """Process received octets."""
        for raw in self._splitter.feed(octets):
            try:
                packet = packets.parse(raw)
            except packets.PacketError as error:
                self.malformed.append(f"{error}: {raw.hex()}")
                continue
            if packet.direction == "TM":
                self._take(packet)
                self._put_together(packet)
                if self.follow is not None:
                    self.follow(packet)

    def _put_together(self, packet):
        if not large.is_part(packet):
            return
        whole = self._assembler.take(packet)
        self.malformed += self._assembler.problems
        self._assembler.problems.clear()
        if whole is None:
            return
        asked = next((ended for ended in self._ended if self._awaits(ended, whole)), None)
        decoded = self._take(whole, asked is not None)
        if asked is not None:
            asked.replies.append((whole, decoded))

    def _awaits(self, ended, report):
        """Whether a report must still answer a request that has ended: its parts may arrive after the end."""
        request = ended.request
        entry = self.dictionary.catalogue.find("TC", request.service, request.subtype) or {}
        is_answer = (request.apid, request.service, entry.get("answer")) == (report.apid, *report.message)
        return is_answer and report.user == self.source and all(packet.message != report.message for packet, _ in ended.replies)

    def _keep(self, packet):
        """Keep a housekeeping report. Returns whether it must be decoded now: decoding takes longest, and an operator reads few reports."""
        key = packet.apid, packet.data[:2]
        self.housekeeping.pop(key, None)
        self.housekeeping[key] = packet, self.configurations.get(packet.apid)
        return bool(self.listeners) or any(verification.request.apid == packet.apid for verification in self._open.values())

    def _take(self, packet, is_awaited=False):
        """Process a report. Returns its content; None for a housekeeping report that is only kept."""
        if packet.message == HOUSEKEEPING and not self._keep(packet) and not is_awaited:
            return None
        decoded = telemetry.decode(packet, self.dictionary, self.configurations)
        if packet.service == 1:
            self._verify(packet)
        elif packet.user == self.source and not large.is_part(packet):
            for verification in self._open.values():
                if verification.request.apid == packet.apid:
                    verification.replies.append((packet, decoded))
        self._remember(packet, decoded)
        for listener in list(self.listeners):
            listener(packet, decoded)
        return decoded

    def _verify(self, packet):
        verification = self._open.get(packet.data[:4])
        if verification is None:
            return
        verification.stages.append(packet.subtype)
        if packet.subtype in STAGES:
            verification.failure = Failure.decode(packet.subtype, packet.data[4:], packet.apid)
            verification.failures.append(verification.failure)
        if packet.subtype in FINAL_SUBTYPES:
            verification.is_finished = True
            is_of_instruction = packet.subtype == 4 and verification.failure.instruction > 0
            if is_of_instruction:  # Reports of other instructions and of the end may follow, or no further report.
                self._forget_refused()
            else:
                del self._open[packet.data[:4]]
                self._ended.append(verification)
                self._keep_own(verification)
            if verification.failure is not None and verification.whole is not None:
                self._give_up(verification.whole, verification.failure)

    def _keep_own(self, ended):
        """The same request may be in progress several times at one subsystem: a report that has answered the request `ended` answers no other
        request."""
        request, found = ended.request, {id(packet) for packet, _ in ended.replies}
        for other in self._open.values() if ended.failure is None else ():
            if (other.request.apid, other.request.service, other.request.subtype) == (request.apid, request.service, request.subtype):
                answer = (request.service, (self.dictionary.catalogue.find("TC", request.service, request.subtype) or {}).get("answer"))
                other.replies = [each for each in other.replies if each[0].message != answer or id(each[0]) not in found]

    def _forget_refused(self):
        """Keep only the newest requests that may end without a report, because an open request stores all reports of its subsystem."""
        for verification in [found for found in self._open.values() if found.is_finished][:-ENDED]:
            del self._open[verification.request_id]

    def _give_up(self, whole, failure):
        """A part of a long request was refused: there will be no report about the request itself."""
        if self._open.pop(whole.request_id, None) is whole:
            whole.failure = failure
            whole.failures.append(failure)
            whole.is_finished = True

    def _remember(self, packet, decoded):
        kind = decoded["kind"]
        problem = telemetry.interface_problem(packet, decoded, self.dictionary)
        if problem:
            self.mismatches[packet.apid] = problem
        elif kind == "status" and "error" not in decoded:
            self.mismatches.pop(packet.apid, None)  # The subsystem was started again with the interface of the dictionary.
        if kind in ("transition", "status") and "error" not in decoded:
            self.states[packet.apid] = decoded["state"]
            self.configurations[packet.apid] = decoded["configuration_id"]
        elif kind == "subsystems" and "error" not in decoded:
            self.states.update({row["apid"]: row["state"] for row in decoded["rows"]})
        elif kind == "mode" and "error" not in decoded:
            self.mode = decoded["mode"]
        elif kind == "event":
            self.events.append((packet, decoded))

    # Procedures -------------------------------------------------------------------------------------------

    def wait_until(self, time_ns):
        """Procedure: wait until a time."""
        while self.now_ns < time_ns:
            yield Pause(time_ns)

    def wait_for(self, condition, timeout_ns, what):
        """Procedure: wait until condition() is true; TimedOut otherwise. Returns its value."""
        start = self.now_ns - self.slipped_ns
        while True:
            found = condition()
            if found:
                return found
            deadline = start + self.slipped_ns + timeout_ns
            if self.now_ns >= deadline:
                raise TimedOut(f"{what} did not come within {timeout_ns / 1e9:g} s")
            yield deadline

    def execute(self, request, timeout_ns):
        """Procedure: send, wait for the end of verification. Returns the Verification; raises Rejected."""
        verification = self.send(request)
        return (yield from self.finish(verification, timeout_ns))

    def finish(self, verification, timeout_ns):
        """Procedure: wait for the end of a request sent before."""
        text = verification.request.text or verification.request_id.hex()
        try:
            yield from self.wait_for(lambda: verification.is_finished, timeout_ns, f"{text}: end of verification")
        except TimedOut:
            if self._open.get(verification.request_id) is verification:  # The result of the request is no longer needed.
                del self._open[verification.request_id]
            raise
        if verification.lost_ns is not None:
            raise RequestLost(
                f"{text}: the link was lost at {verification.lost_ns / 1e9:.4f} s, before the end of verification arrived; "
                "the spacecraft may have carried it out"
            )
        if verification.failure is not None:
            raise Rejected(verification.request, verification.failure, self.dictionary)
        return verification

    def wait_state(self, apid, state, timeout_ns):
        """Procedure: wait until a subsystem has reported a state."""
        name = STATES[state] if isinstance(state, int) else state
        what = f"state {name} of {self.dictionary.name_of_apid(apid)} (it is {self.states.get(apid, 'not reported')})"
        try:
            yield from self.wait_for(lambda: self.states.get(apid) == name, timeout_ns, what)
        except TimedOut as error:
            now = self.states.get(apid, "not reported")
            raise TimedOut(
                f"{self.dictionary.name_of_apid(apid)} did not reach {name} within "
                f"{timeout_ns / 1e9:g} s; its state is {now}"
            ) from error

    def wait_event(self, apid, name, timeout_ns):
        """Procedure: the first event of this name that no earlier call has returned, as (packet, decoded)."""

        def came():
            found = [(packet, decoded) for packet, decoded in self.events if packet.apid == apid and decoded.get("event") == name]
            return found[self._awaited[apid, name] :]

        try:
            found = yield from self.wait_for(came, timeout_ns, f"event {name} of {self.dictionary.name_of_apid(apid)}")
        except TimedOut as problem:
            if not self.events:
                raise TimedOut(f"{problem}; there was no event at all") from problem
            packet, last = self.events[-1]
            source = self.dictionary.name_of_apid(packet.apid)
            raise TimedOut(f"{problem}; the last event was {last.get('event')} of {source}") from problem
        self._awaited[apid, name] += 1
        return found[0]
