# SPDX-License-Identifier: Apache-2.0
"""Connects one ground session to any number of browsers.

The hub runs in one asyncio loop. It follows the run directory: when a flight ends, it waits for the next one and begins anew. Everything that
a browser must know is a message (a dict); `publish` is called with each, `snapshot` returns those that describe the present state."""

import asyncio
import collections
import contextlib
import itertools
import math
import pathlib
import shlex
import time
import traceback

from .. import commands, sdls, telemetry, world
from ..async_link import AsyncLink
from ..command import UsageError, words_of
from ..dictionary import SUPERVISOR_APID, Dictionary, DictionaryError
from ..files import MACHINE, PageFiles
from ..run_directory import CLASSES, LOOPBACK, Place, compare_classes, end_of, world_of
from ..sentences import told
from ..session import LinkLost, Rejected, RequestLost, SessionError, TimedOut
from ..values import quoted
from . import display
from .about import hello
from .call import Call, WebSession
from .forms import Forms
from .geometry import as_lists
from .identity import Identity
from .interfaces import barrier
from .kept_packets import KeptPackets
from .led_to import LedTo
from .network import Network
from .silence import Silence
from .targets import targets
from .world_port import Taps, Truth, WorldPort

ALL_USERS = 0  # Destination of a report: all ground users.
LISTS = {("schedule", "list"), ("store", "list"), ("procedure", "status"), ("file", "list")}  # Commands that only read.
TIMEOUT_NS = 20_000_000_000  # Longest simulated time to wait for reports other than those of verification.
TICK_S = 0.1  # Period of tasks that depend on time.
RETRY_S = 0.5  # Time between two attempts to connect, and between two requests for the pace.
HAND_S = 1.0  # If the last `aim` of a page is older, the page no longer holds the hand.
LEAVE_S = 2.0  # A page that the user reloads connects again within this time.
COUNT_S = 1.0  # Time between two messages with the counts of packets.
GAP_MAX = 1000  # A larger jump of a message type counter means that the subsystem was restarted.
CALLS_MAX = 64  # Commands of pages that are under way at the same time.
KEPT_EVENTS = 10_000  # Events that the station stores.
KEPT_COMMANDS = 500  # Commands that the station stores.
SHOWN = 200  # Events and commands in a snapshot.
KEPT_STATES = 2000  # Changes of the state of a subsystem that the station stores.


class Hub:
    """One spacecraft link for all browsers. `run`: run directory or a link to it, such as runs/latest."""

    timeout_ns = TIMEOUT_NS

    def __init__(self, run, publish, user=None, is_read_only=False, files=MACHINE, **given):
        """user: id in the packets, None: a WEB user that no other station has; is_read_only: the pages show that they
        cannot send commands; files: those on ground that commands may use (files.py); given: arguments of run_directory.Place.of that replace
        the values of the run directory."""
        self.run, self.publish = pathlib.Path(run), publish
        self._user, self._given, self.is_read_only, self._files = user, given, is_read_only, files
        self.identity = None
        self.world_port = WorldPort()
        self.viewers, self._left = 0, 0.0
        self.taps, self.truth = Taps(publish), Truth(publish)
        self.dictionary = self.session = self.flight = self.world = self.world_problem = self.display = None
        self.link = {"kind": "link", "is_live": False, "text": "no flight yet"}
        self.hand = {"kind": "hand", "page": None, "other": None}
        self._step_end_s = -math.inf  # Simulated time at which the last step ends.
        self._aims = (None, 0.0)  # Page that aims the hand, and the time of its last `aim`.
        self.pace = {"kind": "pace", "is_there": False, "is_paused": False, "speed": 1.0}
        self._numbers = itertools.count(1)
        self._begin(None)

    # Flights ------------------------------------------------------------------------------------------------

    def _begin(self, flight):
        """Discard the state of the last flight."""
        self.flight = flight
        self.calls = []
        self.commands = collections.deque(maxlen=KEPT_COMMANDS)
        self.events = collections.deque(maxlen=KEPT_EVENTS)
        self.housekeeping, self.states = {}, {}
        self.lanes = {}  # subsystem -> its states so far: [mission time in s, state], for the time line of a page that is opened later
        if self.display:
            self.display.close()
        self.network, self.display = Network(self), display.Display(self, flight and flight[0])
        self.mismatches = {}  # subsystem -> message about the interface that flies
        self.seconds = None
        self._current = self._connection = self._sender = None
        self.counts = {"kind": "counts", "rows": {}}
        self._counters, self._counted = {}, 0.0
        self.packets = self._led_to = None

    def _load(self, run):
        """Begin with the flight of a run directory. Raises DictionaryError, SecurityError."""
        place = Place.of(run, **self._given)
        dictionary = Dictionary.load(place.dictionary)
        sender = sdls.Sender(place.key) if place.key else None
        self._begin((str(run), place.port))
        self.dictionary, self._sender = dictionary, sender
        self.forms = Forms(dictionary)
        if self.identity:
            self.identity.release()
        self.identity = Identity(self._user, "", False) if self._user else Identity.claim(dictionary, place.port)
        self.session = WebSession(dictionary, source=self.identity.number, protect=sender or bytes)
        self.session.on_sent = self._on_sent
        self.packets, self._led_to = KeptPackets(dictionary), LedTo(dictionary)
        self.session.on_packet = lambda raw: self.packets.take_sent(raw, self.seconds)
        self.session.listeners.append(self._listen)
        self.session.events = collections.deque(maxlen=KEPT_EVENTS)
        self.world_port.move_to(run, f"station-{self.identity.name or self.identity.number}")
        compare_classes(place, self.session)
        self.taps.move_to(run, dictionary, self.session.mismatches)
        self.truth.move_to(run)
        try:
            self.world, self.world_problem = as_lists(world.read(world_of(run))), None
        except (world.WorldError, AttributeError, TypeError, ValueError) as problem:
            self.world, self.world_problem = None, str(problem) if isinstance(problem, world.WorldError) else f"{world_of(run)}: {problem}"
        self.publish(self.hello())
        self._publish_mismatch(CLASSES, CLASSES)

    async def serve(self):
        """Follow the run directory until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._follow())
            group.create_task(self._tick())
            group.create_task(self._watch_pace())

    async def _follow(self):
        while True:
            with contextlib.suppress(OSError):
                await self._connect(self.run.resolve())
            await asyncio.sleep(RETRY_S)

    async def _connect(self, run):
        if (run / "run.json").exists():  # It has ended: another flight may use its port now.
            self._publish_link(False, *end_of(run))
            return
        if not self._given.get("port") and not (run / "ground.port").exists():
            self._publish_link(False, f"no flight in {run.name}")
            return
        place = Place.of(run, **self._given)
        try:
            place.check()
        except LinkLost as problem:
            self._publish_link(False, str(problem))
            return
        port, where = place.port, f"{place.host}:{place.port}"
        end = f"trying {where} again"
        try:
            reader, writer = await asyncio.open_connection(place.host, port)
        except OSError:
            self._publish_link(False, f"no link, trying {where}")
            return
        try:
            if self.flight != (str(run), port):
                self._load(run)
            elif self._sender:
                self._sender.begin_anew()
            await self._receive(reader, writer)
        except (DictionaryError, sdls.SecurityError) as problem:
            end = str(problem)
        finally:
            writer.close()
            self._connection = None
            if self.session:
                self.session.link_lost()
                self._led_to.end()
                self._resume_all()
            self._publish_link(False, end)

    async def _receive(self, reader, writer):
        self._connection = AsyncLink(reader, writer, self.session)
        self._counters.clear()
        self.session.is_time_known = False
        self._silence, where = Silence(), f"{LOOPBACK}:{self._connection.address[1]}"

        def arrived():
            self._silence.heard()
            self._publish_link(True, where)
            self._resume_all()

        self._publish_link(True, where)
        self.begin_own(self._ask_all())
        await self._connection.receive(arrived)

    def _publish_link(self, is_live, text, code=None, is_silent=False):
        """code: exit code of the flight that has ended; is_silent: the connection is open, but nothing arrives."""
        now = {"kind": "link", "is_live": is_live, "text": text} | ({} if code is None else {"code": code}) | ({"is_silent": True} if is_silent else {})
        if now != self.link:
            self.link = now
            self.publish(now)

    async def _tick(self):
        while True:
            await asyncio.sleep(TICK_S)
            if self._connection:
                self._keep()
                self._publish_counts()
                self._resume_all()
                if self._silence.look(self._is_watched() and not self.pace["is_paused"], self.pace["speed"]):
                    self._publish_link(False, "no telemetry arrives", is_silent=True)

    @property
    def is_linked(self):
        """Whether there is a link to the spacecraft."""
        return self._connection is not None

    def _keep(self):
        """Enable the telemetry that the pages need while a page is open, and disable it otherwise."""
        if self._is_watched():
            self.display.keep()
            self.network.keep()
        else:
            self.display.end()

    def set_viewers(self, viewers):
        """Set the number of pages that are open."""
        if self.viewers and not viewers:
            self._left = time.monotonic()
        self.viewers = viewers

    def _is_watched(self):
        return self.viewers > 0 or time.monotonic() - self._left < LEAVE_S

    async def leave(self):
        """Disable the structures that the station has enabled for its pages; called when the station ends."""
        if self._connection:
            asked = self.display.end()
            end = time.monotonic() + LEAVE_S
            while self._connection and time.monotonic() < end and not all(call.is_over for call in asked):
                await asyncio.sleep(TICK_S / 4)
        self.display.close()

    # Procedures ---------------------------------------------------------------------------------------------

    def _on_sent(self, verification):
        if self._current:
            self._current.verifications.append(verification)
            self._led_to.sent(verification.request, verification.request_id, self.session.source, self._current.reports)

    def _resume(self, call):
        self._current = call
        try:
            call.procedure.send(None)
        except StopIteration as end:
            call.is_over = True
            call.rows = [row for row in end.value or [] if isinstance(row, dict)]
            call.answer = [row["text"] for row in call.rows if "text" in row]
        except Rejected as problem:
            call.is_over, call.failure, call.code = True, str(problem), problem.failure.code
        except (SessionError, UsageError) as problem:
            call.is_over, call.failure = True, str(problem)
            call.is_unknown = isinstance(problem, (TimedOut, RequestLost, LinkLost))
        except Exception as problem:  # A defect of one command must not end the station.
            traceback.print_exc()
            call.is_over, call.is_unknown, call.failure = True, True, f"the station cannot continue this command: {problem!r}"
        finally:
            self._current = None
        call.note_silence(self.session.now_ns)

    def _resume_all(self):
        for call in list(self.calls):
            shown = getattr(call, "shown", None)
            self._resume(call)
            message = call.message()
            if call.is_over:
                self.calls.remove(call)
                if call.at_end:
                    call.at_end(call)
            if call.number and message != shown:
                call.shown = message
                self.publish(message)
        self._flush()

    def _flush(self):
        if self._connection:
            self._connection.flush()

    def command(self, text, is_for_display=False, files=None):
        """Start a command of an operator; its progress is published. Returns its number. is_for_display: structures that it
        enables are disabled when no page is open any more. files: as of `plan`. Raises UsageError."""
        planned, words = self.plan(text, files), words_of(text)
        if reason := barrier(self, planned):
            raise UsageError(reason)
        if words[0] != "stop" and sum(call.number > 0 for call in self.calls) >= CALLS_MAX:
            raise UsageError(f"{CALLS_MAX} commands of pages are under way; wait until one has ended")
        at_end = self.display.after(words, is_for_display)
        call = Call(next(self._numbers), planned.text, planned.procedure(self.session, TIMEOUT_NS), self.seconds, text, at_end)
        self.commands.append(call)
        self.calls.append(call)
        self._resume_all()
        return call.number

    def plan(self, text, files=None):
        """The command of these words. files: files that it may use instead of those of the hub. Raises UsageError."""
        if self.dictionary is None:
            raise UsageError("no flight")
        try:
            return commands.plan(words_of(text), self.dictionary, files or self._files)
        except ValueError as problem:
            raise UsageError(str(problem)) from problem

    def begin_own(self, procedure):
        """Start a procedure of the station itself, which is not in the list of commands. Returns its call."""
        call = Call(0, "", procedure, self.seconds)
        self.calls.append(call)
        self._resume_all()
        return call

    async def ask(self, text):
        """Rows of the answer of one of LISTS; it is not in the list of commands. Raises UsageError."""
        if tuple(text.split()[:2]) not in LISTS:
            raise UsageError(f"{quoted(text)} is no list; lists are {', '.join(sorted(map(' '.join, LISTS)))}")
        planned = self.plan(text)
        if not self._connection:
            raise UsageError("no link to the spacecraft")
        call = self.begin_own(planned.procedure(self.session, TIMEOUT_NS))
        while not call.is_over:
            await asyncio.sleep(TICK_S / 4)
        if call.failure:
            raise UsageError(call.failure)
        return call.rows

    def upload(self, words, octets):
        """Start a command with a file of a page, for which the word `{}` stands. Returns its number. Raises UsageError."""
        number = self.command(shlex.join(words), files=PageFiles(octets))
        self.commands[-1].line = ""  # It cannot be repeated without the file.
        return number

    def kept(self, kind=None):
        """The kinds of packets, or the packets of a kind with their octets and fields. Raises UsageError."""
        if self.packets is None:
            raise UsageError("no flight")
        return {"rows": self.packets.rows()} if kind is None else self.packets.packets(kind, self.session.configurations)

    def text_of(self, form, values):
        """Words of the command line for the values of a form. Raises UsageError."""
        if self.dictionary is None:
            raise UsageError("no flight")
        return self.forms.text(form, values)

    # Requests of the station --------------------------------------------------------------------------------

    def _ask_all(self):
        """Procedure: states, mode and links after a connection is made."""
        for text in ("status", f"hk once {self.dictionary.subsystem_of_apid(SUPERVISOR_APID).name} 1"):
            with contextlib.suppress(SessionError):
                yield from self.plan(text).procedure(self.session, TIMEOUT_NS)
        yield from self.network.ask()

    def quietly(self, texts):
        """Procedure: perform commands; failures are not reported."""
        for text in texts:
            with contextlib.suppress(SessionError):
                yield from self.plan(text).procedure(self.session, TIMEOUT_NS)

    # Telemetry ----------------------------------------------------------------------------------------------

    def _count(self, packet, subsystem):
        """Count received and lost packets of a subsystem. A gap in the message type counters is a loss. Only the
        counters of reports to all users, and of reports to a user that this station does not share, are used."""
        row = self.counts["rows"].setdefault(subsystem, {"received": 0, "lost": 0})
        row["received"] += 1
        if packet.counter and packet.user in (ALL_USERS, self.identity.number if self.identity and self.identity.is_own else ALL_USERS):
            key = packet.apid, packet.service, packet.subtype, packet.user
            gap = packet.counter - self._counters.get(key, packet.counter - 1) - 1
            row["lost"] += gap if 0 < gap < GAP_MAX else 0
            self._counters[key] = packet.counter

    def _publish_counts(self):
        now = time.monotonic()
        if now - self._counted >= COUNT_S:
            self._counted = now
            self.publish(self.counts)

    def _listen(self, packet, decoded):
        self.session.advance(packet.time_ns)
        self.seconds = (packet.time_ns - self.dictionary.epoch_ns) / 1e9
        subsystem = self.dictionary.name_of_apid(packet.apid)
        kind = decoded["kind"]
        self._count(packet, subsystem)
        self.packets.take(packet, self.seconds)
        self._led_to.take(self.seconds, packet, decoded)
        if "error" in decoded:
            return
        if kind == "housekeeping":
            self._take_housekeeping(packet, decoded, subsystem)
        elif kind in ("transition", "status"):
            self._take_state(packet, decoded, subsystem)
        elif kind == "subsystems":
            for row in decoded["rows"]:
                self._publish_state(row["subsystem"], row, None)
        elif kind == "event":
            self._take_event(packet, decoded, subsystem)
        elif kind == "mode":
            self._publish_mode()
        elif kind == "link transition":
            self.network.transition(decoded)

    def begin_own_later(self, procedure):
        """Start a procedure from a listener: it is resumed after the received octets are processed."""
        self.calls.append(Call(0, "", procedure, self.seconds))

    def _take_housekeeping(self, packet, decoded, subsystem):
        self.display.saw_report(packet.apid, decoded["structure"])
        leaves = telemetry.leaves(decoded["values"])
        message = {"kind": "housekeeping", "subsystem": subsystem, "structure": decoded["structure"], "time": self.seconds, "values": leaves}
        self.housekeeping[subsystem, decoded["structure"]] = message
        self.publish(message)
        if packet.apid == SUPERVISOR_APID and "STATUS.MODE" in leaves:
            names = {item["id"]: item["name"] for item in self.dictionary.modes}
            mode = names.get(leaves["STATUS.MODE"][0], leaves["STATUS.MODE"][0])
            if mode != self.session.mode:
                self.session.mode = mode
                self._publish_mode()

    def _publish_mode(self):
        self.publish({"kind": "mode", "mode": self.session.mode})
        self.publish_targets()

    def _take_state(self, packet, decoded, subsystem):
        if decoded["kind"] == "status":
            self.display.saw_status(packet.apid)
            self._publish_mismatch(packet.apid, subsystem)
        self._publish_state(subsystem, decoded, self.seconds)
        if decoded["kind"] == "transition":
            self.publish_targets()

    def _publish_mismatch(self, apid, subsystem):
        """Publish whether the interface hash of a subsystem, or the hash of the device classes, differs from the dictionary; without
        words: it no longer differs. Each snapshot contains the message."""
        words = self.session.mismatches.get(apid)
        if words != self.mismatches.get(subsystem, {}).get("words"):
            self.mismatches[subsystem] = {"kind": "mismatch", "subsystem": subsystem, "words": words}
            self.publish(self.mismatches[subsystem])

    def _publish_state(self, subsystem, decoded, seconds):
        old = self.states.get(subsystem, {})
        message = {
            "kind": "state",
            "subsystem": subsystem,
            "state": decoded["state"],
            "phase": decoded["phase"],
            "configuration": decoded["configuration"],
            "time": seconds,
            "since": old.get("since") if old.get("state") == decoded["state"] else seconds,
            "cause": decoded.get("cause", old.get("cause")),
            "targets": self._targets(subsystem),
        }
        self.states[subsystem] = message
        if old.get("state") != message["state"]:
            self.lanes.setdefault(subsystem, collections.deque(maxlen=KEPT_STATES)).append([self.seconds, message["state"]])
        self.publish(message)

    def _targets(self, name):
        return targets(self.session, self.dictionary.subsystem(name), self.network.open) if name in self.dictionary.subsystems else {}

    def publish_targets(self):
        """Publish the targets that have changed: they depend on the states of others, on the mode and on the links."""
        for name, message in self.states.items():
            found = self._targets(name)
            if found != message["targets"]:
                message["targets"] = found
                self.publish(message)

    def _take_event(self, packet, decoded, subsystem):
        message = {
            "kind": "event", "number": len(self.events), "subsystem": subsystem,
            "severity": decoded["severity"],
            "event": decoded["event"],
            "time": self.seconds,
            **told(self.dictionary.subsystem_of_apid(packet.apid).event(decoded["event"]), decoded["values"]),
        }
        self.events.append(message)
        self.publish(message)

    # The simulated world ------------------------------------------------------------------------------------

    async def live(self, line, page=None):
        """Send a line to the live port. Returns the result as a message. page: number of the page that sends the
        line."""
        words = line.split()
        is_hand = words[:1] == ["hand"]
        owner = self._hand_owner(page)
        if is_hand and owner:
            return {"kind": "live", "line": line, "refused": f"the hand is taken by {owner}"}
        try:
            seconds, is_paused = await self.world_port.ask(line)
        except SessionError as problem:
            return {"kind": "live", "line": line, "refused": str(problem)}
        if is_hand:
            self._aims = (page, time.monotonic()) if words[1] == "aim" else (None, 0.0)
        if words[0] in ("pause", "resume", "step"):
            self._step_end_s = seconds + float(words[1]) if words[0] == "step" else -math.inf
        # Simulated time is paused in a step, too: it stands still after it, and a page can only resume it.
        is_paused = is_paused or seconds < self._step_end_s
        self._publish_pace({"kind": "pace", "is_there": True, "is_paused": is_paused, "speed": self.world_port.speed})
        self._publish_hand()
        return {"kind": "live", "line": line, "time": seconds}

    async def leave_hand(self, page):
        """Give the hand back if this page, whose connection has ended, has aimed it last."""
        if self._aims[0] == page:
            await self.live("hand rest", page)

    def _hand_owner(self, page):
        """Words that say which other page or program aims the hand now; None if the hand is free or belongs to this page."""
        other, since = self._aims
        if other is not None and other != page and time.monotonic() - since < HAND_S:
            return "another page"
        return self.world_port.hand

    def _publish_hand(self):
        number, since = self._aims
        number = number if time.monotonic() - since < HAND_S else None
        hand = {"kind": "hand", "page": number, "other": self.world_port.hand}
        if hand != self.hand:
            self.hand = hand
            self.publish(hand)

    def _publish_pace(self, pace):
        if pace != self.pace:
            self.pace = pace
            self.publish(pace)

    async def _watch_pace(self):
        """Follow the pace of simulated time: other clients of the live port may change it."""
        while True:
            await asyncio.sleep(RETRY_S)
            if self.flight and self._connection and "refused" in await self.live("time"):
                self._publish_pace({**self.pace, "is_there": False})

    # Browsers -----------------------------------------------------------------------------------------------

    def hello(self):
        """The mission, for a page that begins with this flight."""
        who = {"number": self.identity.number, "name": self.identity.name, "is_own": self.identity.is_own}
        return {**hello(self.dictionary, self.flight[0], self.world, self.world_problem), "read_only": self.is_read_only, "user": who}

    def snapshot(self):
        """Messages that describe the present state."""
        if self.dictionary is None:
            return [self.link]
        found = [self.hello(), self.link, self.pace, self.hand, {"kind": "mode", "mode": self.session.mode}]
        found.append({"kind": "lanes", "lanes": {name: list(lane) for name, lane in self.lanes.items()}})
        found += self.states.values()
        found += self.housekeeping.values()
        found += itertools.islice(self.events, max(0, len(self.events) - SHOWN), None)
        found += [call.message() for call in list(self.commands)[-SHOWN:]]
        found += [*self.display.structures.values(), *self.mismatches.values(), self.counts]
        return found + ([self.network.message] if self.network.message else [])
