# SPDX-License-Identifier: Apache-2.0
"""Connects one ground session to any number of browsers.

The hub runs in one asyncio loop. It follows the run folder: when a flight ends, it waits for the next one and begins anew. Everything that
a browser must know is a message (a dict); `publish` is called with each, `snapshot` returns those that describe the present."""

import asyncio
import collections
import contextlib
import itertools
import pathlib
import shlex
import tempfile
import time

from .. import commands, sdls, telemetry, world
from ..command import UsageError
from ..dictionary import STATES, SUPERVISOR_APID, Dictionary, DictionaryError
from ..place import DEFAULT_PORT, LOOPBACK, ROOT, Place, mission_of
from ..session import GROUND_USER, Rejected, Session, SessionError
from .about import hello
from .forms import Forms
from .geometry import as_lists
from .lights import lights_of
from .targets import targets
from .world_port import Taps, WorldPort

WEB_USER = 3
DISPLAY_ID = 9003  # housekeeping structure of the station
DISPLAY_PERIOD_US = 50_000
DISPLAY_STATES = STATES[3:7]
LISTS = {("schedule", "list"), ("store", "list"), ("procedure", "status"), ("file", "list")}  # Commands that ask only.
TIMEOUT_NS = 20_000_000_000
TICK_S = 0.1
RETRY_S = 0.5
DISPLAY_PATIENCE_S = 1.5
LEAVE_S = 2.0  # A page that is loaded again comes back within this time.
COUNT_S = 1.0  # Between two messages with the counts of packets.
GAP_MAX = 1000  # A larger jump of a message type counter is a restart.
KEPT_EVENTS = 10_000
KEPT_COMMANDS = 500
SHOWN = 200  # events and commands in a snapshot


class Call:
    """A command of a browser: its procedure while it is under way, its telecommands and its result."""

    def __init__(self, number, text, procedure, seconds, line="", at_end=None):
        """line: words of the command line; at_end(call): called when it is over."""
        self.number, self.text, self.procedure, self.seconds, self.line, self.at_end = number, text, procedure, seconds, line, at_end
        self.verifications, self.is_over = [], False
        self.words = self.code = None
        self.answer, self.rows = [], []

    def message(self):
        words = {"words": self.words, "code": self.code} if self.words else {}
        return {
            "kind": "command",
            "number": self.number,
            "text": self.text,
            "line": self.line,
            "time": self.seconds,
            "lights": lights_of(self.verifications),
            "over": self.is_over,
            "answer": self.answer,
            **words,
        }


class _WebSession(Session):
    """Tells the hub which telecommands a command has sent."""

    on_sent = staticmethod(lambda verification: None)

    def send_raw(self, raw, request):
        verification = super().send_raw(raw, request)
        self.on_sent(verification)
        return verification


class Hub:
    """One spacecraft link for all browsers. `run`: run folder or a link to it, such as runs/latest."""

    def __init__(self, run, publish, user=WEB_USER, is_read_only=False, **given):
        """user: id in the packets; is_read_only: pages are told that they command nothing; given: what place.Place.of shall not take from the run folder."""
        self.run, self.publish = pathlib.Path(run), publish
        self._user, self._given, self.is_read_only = user, given, is_read_only
        self.world_port = WorldPort()
        self.viewers, self._left = 0, 0.0
        self.taps = Taps(publish)
        self.dictionary = self.session = self.flight = self.world = None
        self.link = {"kind": "link", "is_live": False, "text": "no flight yet"}
        self.pace = {"kind": "pace", "is_there": False, "is_paused": False, "speed": 1.0}
        self._numbers = itertools.count(1)
        self._begin(None)

    # Flights ------------------------------------------------------------------------------------------------

    def _begin(self, flight):
        """Forget the last flight."""
        self.flight = flight
        self.calls = []
        self.commands = collections.deque(maxlen=KEPT_COMMANDS)
        self.events = collections.deque(maxlen=KEPT_EVENTS)
        self.housekeeping, self.states = {}, {}
        self.open_links = set()
        self.links = None
        self.seconds = None
        self._current = self._writer = self._sender = None
        self._display_seen, self._status_seen, self._other_reports, self._asked_display = {}, {}, set(), {}
        self._for_display = set()  # (subsystem, structure) that this station has enabled for its pages.
        self.structures = {}  # subsystem -> message
        self.counts = {"kind": "counts", "rows": {}}
        self._counters, self._counted = {}, 0.0

    def _load(self, run):
        """Begin with the flight of a run folder. Raises DictionaryError, SecurityError."""
        place = Place.of(run, **self._given)
        dictionary = Dictionary.load(place.dictionary)
        sender = sdls.Sender(place.key) if place.key else None
        self._begin((str(run), place.port))
        self.dictionary, self._sender = dictionary, sender
        self.forms = Forms(dictionary)
        self.session = _WebSession(dictionary, source=self._user, protect=sender or bytes)
        self.session.on_sent = self._on_sent
        self.session.listeners.append(self._listen)
        self.session.events = collections.deque(maxlen=KEPT_EVENTS)
        self.world_port.move_to(run)
        self.taps.move_to(run, dictionary)
        try:
            self.world = as_lists(world.read(ROOT / "descriptors" / "worlds" / f"{mission_of(run)}.xml"))
        except (world.WorldError, AttributeError, TypeError, ValueError):
            self.world = None
        self.publish(self.hello())

    async def serve(self):
        """Follow the run folder until cancelled."""
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
        if (run / "run.json").exists():  # Another flight may listen at its port now.
            self._say_link(False, f"the flight of {run.name} has ended")
            return
        if not self._given.get("port") and not (run / "ground.port").exists():
            self._say_link(False, f"no flight in {run.name}")
            return
        place = Place.of(run, **self._given)
        port, where = place.port, f"{place.host}:{place.port}"
        try:
            reader, writer = await asyncio.open_connection(place.host, port)
        except OSError:
            self._say_link(False, f"no link, trying {where}")
            return
        try:
            if self.flight != (str(run), port):
                self._load(run)
            elif self._sender:
                self._sender.begin_anew()
            await self._receive(reader, writer)
        except (DictionaryError, sdls.SecurityError) as problem:
            self._say_link(False, str(problem))
        finally:
            writer.close()
            self._writer = None
            if self.session:
                self.session.link_lost()
                self._resume_all()
            self._say_link(False, f"link lost, trying {where}")

    async def _receive(self, reader, writer):
        self._writer = writer
        self._counters.clear()
        self._say_link(True, where := f"{LOOPBACK}:{writer.get_extra_info('peername')[1]}")
        self._begin_own(self._ask_all())
        while octets := await reader.read(65536):
            self.session.now_ns = time.monotonic_ns()
            self.session.feed(octets)
            self._resume_all()
        self._say_link(False, f"{where} closed the link")

    def _say_link(self, is_live, text):
        now = {"kind": "link", "is_live": is_live, "text": text}
        if now != self.link:
            self.link = now
            self.publish(now)

    async def _tick(self):
        while True:
            await asyncio.sleep(TICK_S)
            if self._writer:
                self.session.now_ns = time.monotonic_ns()
                self._keep_display() if self._is_watched() else self._end_display()
                self._say_counts()
                self._resume_all()

    def look(self, viewers):
        """Number of pages that are open."""
        if self.viewers and not viewers:
            self._left = time.monotonic()
        self.viewers = viewers

    def _is_watched(self):
        return self.viewers > 0 or time.monotonic() - self._left < LEAVE_S

    async def leave(self):
        """The station ends: the structures that it has enabled for its pages are disabled."""
        if self._writer and self._for_display:
            asked = self._end_display()
            end = time.monotonic() + LEAVE_S
            while self._writer and time.monotonic() < end and not all(call.is_over for call in asked):
                await asyncio.sleep(TICK_S / 4)

    # Procedures ---------------------------------------------------------------------------------------------

    def _on_sent(self, verification):
        if self._current:
            self._current.verifications.append(verification)

    def _resume(self, call):
        self._current = call
        before = [(len(v.stages), v.is_finished) for v in call.verifications]
        try:
            self.session.now_ns = time.monotonic_ns()
            call.procedure.send(None)
        except StopIteration as end:
            call.is_over = True
            call.rows = [row for row in end.value or [] if isinstance(row, dict)]
            call.answer = [row["text"] for row in call.rows if "text" in row]
        except Rejected as problem:
            call.is_over, call.words, call.code = True, str(problem), problem.failure.code
        except (SessionError, UsageError) as problem:
            call.is_over, call.words = True, str(problem)
        finally:
            self._current = None
        return call.is_over or before != [(len(v.stages), v.is_finished) for v in call.verifications]

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
        if self._writer and self.session.outbox:
            self._writer.write(bytes(self.session.outbox))
            self.session.outbox.clear()

    def command(self, text, is_for_display=False):
        """Start a command of an operator; its progress is published. is_for_display: structures that it enables are disabled
        when no page is open any more. Raises UsageError."""
        planned = self.plan(text)
        if not self._writer:
            raise UsageError("no link to the spacecraft")
        at_end = self._after_structure(shlex.split(text), is_for_display)
        call = Call(next(self._numbers), planned.text, planned.procedure(self.session, TIMEOUT_NS), self.seconds, text, at_end)
        self.commands.append(call)
        self.calls.append(call)
        self._resume_all()
        return call.number

    def plan(self, text):
        """The command of these words. Raises UsageError."""
        if self.dictionary is None:
            raise UsageError("no flight")
        try:
            return commands.plan(shlex.split(text), self.dictionary)
        except ValueError as problem:
            raise UsageError(str(problem)) from problem

    def _begin_own(self, procedure):
        """Start a procedure of the station itself, which is not in the list of commands. Returns its call."""
        call = Call(0, "", procedure, self.seconds)
        self.calls.append(call)
        self._resume_all()
        return call

    async def ask(self, text):
        """Rows of the answer of one of LISTS; it is not in the list of commands. Raises UsageError."""
        if tuple(text.split()[:2]) not in LISTS:
            raise UsageError(f"'{text}' is no list; lists are {', '.join(sorted(map(' '.join, LISTS)))}")
        planned = self.plan(text)
        if not self._writer:
            raise UsageError("no link to the spacecraft")
        call = self._begin_own(planned.procedure(self.session, TIMEOUT_NS))
        while not call.is_over:
            await asyncio.sleep(TICK_S / 4)
        if call.words:
            raise UsageError(call.words)
        return call.rows

    def upload(self, words, octets):
        """A command with a file of a page in the place of the word `{}`. Raises UsageError."""
        with tempfile.NamedTemporaryFile() as file:
            file.write(octets)
            file.flush()
            number = self.command(shlex.join(file.name if word == "{}" else word for word in words))
        self.commands[-1].line = ""  # It cannot be repeated without the file.
        return number

    def text_of(self, form, values):
        """Words of the command line for the values of a form. Raises UsageError."""
        if self.dictionary is None:
            raise UsageError("no flight")
        return self.forms.text(form, values)

    def _after_structure(self, words, is_for_display):
        """What follows a command about a housekeeping structure; None for other commands."""
        if len(words) < 3 or words[0] != "hk":
            return None
        verb, subsystem = words[1], self.dictionary.subsystem(words[2])

        def after(call):
            if call.words is None and verb == "enable" and is_for_display:
                self._for_display.add((subsystem.name, int(words[3], 0)))
            elif call.words is None and verb in ("disable", "delete"):
                self._for_display.discard((subsystem.name, int(words[3], 0)))
            self._begin_own_later(self._ask_structures(subsystem))

        return after

    # What the station asks for ------------------------------------------------------------------------------

    def _ask_all(self):
        """Procedure: states, mode and links after a connection is made."""
        for text in ("status", f"hk once {self.dictionary.subsystem_of_apid(SUPERVISOR_APID).name} 1"):
            with contextlib.suppress(SessionError):
                yield from self.plan(text).procedure(self.session, TIMEOUT_NS)
        yield from self._ask_links()

    def _ask_links(self):
        if not self.dictionary.links:
            return
        with contextlib.suppress(SessionError):
            planned = commands.plan(["link", "list"], self.dictionary)
            rows = yield from planned.procedure(self.session, TIMEOUT_NS)
            self.open_links = {row["name"] for row in rows if row.get("state") == "open"}
            names = ("name", "state", "sent", "received", "lost", "late")
            self.links = {"kind": "links", "rows": [{key: row[key] for key in names if key in row} for row in rows]}
            self.publish(self.links)
            self._publish_targets()

    def ask_structures(self, name):
        """Publish which housekeeping structures of a subsystem are enabled. Raises UsageError."""
        if not self._writer:
            raise UsageError("no link to the spacecraft")
        try:
            subsystem = self.dictionary.subsystem(name)
        except DictionaryError as problem:
            raise UsageError(str(problem)) from problem
        self._begin_own(self._ask_structures(subsystem))

    def _ask_structures(self, subsystem):
        """Procedure: the structures of the present configuration, and those that were heard."""
        present = self.session.configurations.get(subsystem.apid)
        of_present = next((item.structures for item in subsystem.configurations.values() if item.id == present), {})
        wanted = sorted({*of_present, *(number for name, number in self.housekeeping if name == subsystem.name)})
        rows = []
        for number in wanted:  # One request each: a structure that does not exist would refuse the others.
            with contextlib.suppress(SessionError):
                words = ["tc", subsystem.name, "3,33", f"n=[{number}]"]
                answer = yield from commands.plan(words, self.dictionary).procedure(self.session, TIMEOUT_NS)
                rows += [row for reply in answer for row in reply.get("rows", ())]
        named = [{"id": row["structure"], "enabled": bool(row["enabled"]), "interval": row["interval"]} for row in rows]
        self.structures[subsystem.name] = {"kind": "structures", "subsystem": subsystem.name, "rows": named}
        self.publish(self.structures[subsystem.name])

    def _end_display(self):
        """Disable what was enabled for pages that are closed now; returns the calls."""
        asked = [self._begin_own(self._quietly([f"hk disable {name} {number}"])) for name, number in sorted(self._for_display)]
        self._for_display.clear()
        return asked

    def _quietly(self, texts):
        """Procedure: perform commands; failures are not reported."""
        for text in texts:
            with contextlib.suppress(SessionError):
                yield from self.plan(text).procedure(self.session, TIMEOUT_NS)

    def _keep_display(self):
        """Create or enable the display housekeeping of each member that does not send it."""
        now = time.monotonic()
        for subsystem in self.dictionary.members:
            apid = subsystem.apid
            is_on = self.session.configurations.get(apid) and self.session.states.get(apid) in DISPLAY_STATES
            last = max(self._display_seen.get(apid, 0), self._asked_display.get(apid, 0))
            is_alive = now - self._status_seen.get(apid, 0) < DISPLAY_PATIENCE_S
            if is_on and is_alive and now - last > DISPLAY_PATIENCE_S:
                self._asked_display[apid] = now
                if words := self._display_words(subsystem):
                    self._begin_own(self._display(subsystem, words))

    def _display_words(self, subsystem):
        """Words of `hk create` for the first structure of the present configuration; empty if that is fast enough."""
        present = self.session.configurations[subsystem.apid]
        configuration = next((item for item in subsystem.configurations.values() if item.id == present), None)
        structure = next(iter(configuration.structures.values()), None) if configuration else None
        if structure is None or not configuration.sampling_us:
            return []
        if structure.interval * configuration.sampling_us <= DISPLAY_PERIOD_US and not structure.repeated:
            return []
        names = [item.name for item in structure.once + tuple(p for _, items in structure.repeated for p in items)]
        cycles = max(1, DISPLAY_PERIOD_US // configuration.sampling_us)
        return ["hk", "create", subsystem.name, str(DISPLAY_ID), str(cycles), *names]

    def _display(self, subsystem, words):
        """Procedure: create and enable the display structure. A refusal is ignored: another station may have created it."""
        own = f"{subsystem.name} {DISPLAY_ID}"
        before = [f"hk disable {own}", f"hk delete {own}"] if subsystem.apid in self._other_reports else []
        self._other_reports.discard(subsystem.apid)
        self._for_display.add((subsystem.name, DISPLAY_ID))
        yield from self._quietly([*before, shlex.join(words), f"hk enable {own}"])

    # Telemetry ----------------------------------------------------------------------------------------------

    def _count(self, packet, subsystem):
        """Received and lost packets of a subsystem; a gap in the message type counters of packets to all or to this station is a loss."""
        row = self.counts["rows"].setdefault(subsystem, {"received": 0, "lost": 0})
        row["received"] += 1
        if packet.counter and packet.user in (GROUND_USER, WEB_USER):
            key = packet.apid, packet.service, packet.subtype, packet.user
            gap = packet.counter - self._counters.get(key, packet.counter - 1) - 1
            row["lost"] += gap if 0 < gap < GAP_MAX else 0
            self._counters[key] = packet.counter

    def _say_counts(self):
        now = time.monotonic()
        if now - self._counted >= COUNT_S:
            self._counted = now
            self.publish(self.counts)

    def _listen(self, packet, decoded):
        self.seconds = (packet.time_ns - self.dictionary.epoch_ns) / 1e9
        subsystem = self.dictionary.name_of_apid(packet.apid)
        kind = decoded["kind"]
        self._count(packet, subsystem)
        if "error" in decoded:
            if packet.message == (3, 25) and packet.data[:2] == DISPLAY_ID.to_bytes(2, "big"):
                self._other_reports.add(packet.apid)
            return
        if kind == "housekeeping":
            self._take_housekeeping(packet, decoded, subsystem)
        elif kind in ("transition", "status"):
            self._take_state(packet, decoded, subsystem)
        elif kind == "subsystems":
            for row in decoded["rows"]:
                self._say_state(row["subsystem"], row, None)
        elif kind == "event":
            self._take_event(packet, decoded, subsystem)
        elif kind == "mode":
            self._publish_mode()
        elif kind == "link transition":
            self._begin_own_later(self._ask_links())

    def _begin_own_later(self, procedure):
        """Start a procedure from a listener: it is resumed after the received octets are processed."""
        self.calls.append(Call(0, "", procedure, self.seconds))

    def _take_housekeeping(self, packet, decoded, subsystem):
        if decoded["structure"] == DISPLAY_ID:
            self._display_seen[packet.apid] = time.monotonic()
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
        self._publish_targets()

    def _take_state(self, packet, decoded, subsystem):
        if decoded["kind"] == "status":
            self._status_seen[packet.apid] = time.monotonic()
        self._say_state(subsystem, decoded, self.seconds)
        if decoded["kind"] == "transition":
            self._publish_targets()

    def _say_state(self, subsystem, decoded, seconds):
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
        self.publish(message)

    def _targets(self, name):
        return targets(self.session, self.dictionary.subsystem(name), self.open_links) if name in self.dictionary.subsystems else {}

    def _publish_targets(self):
        """Publish the targets that have changed: they depend on the states of others, on the mode and on the links."""
        for name, message in self.states.items():
            found = self._targets(name)
            if found != message["targets"]:
                message["targets"] = found
                self.publish(message)

    def _take_event(self, packet, decoded, subsystem):
        message = {
            "kind": "event",
            "number": len(self.events),
            "subsystem": subsystem,
            "severity": decoded["severity"],
            "event": decoded["event"],
            "text": telemetry.describe(packet, decoded, self.dictionary).split(f"{decoded['event']}", 1)[-1].strip(),
            "time": self.seconds,
        }
        self.events.append(message)
        self.publish(message)

    # The simulated world ------------------------------------------------------------------------------------

    async def live(self, line):
        """Send a line to the live port; the result as a message."""
        try:
            seconds, is_paused = await self.world_port.ask(line)
        except SessionError as problem:
            return {"kind": "live", "line": line, "refused": str(problem)}
        words = line.split()
        speed = float(words[1]) if words[0] == "speed" and len(words) == 2 else self.pace["speed"]
        self._say_pace({"kind": "pace", "is_there": True, "is_paused": is_paused, "speed": speed})
        return {"kind": "live", "line": line, "time": seconds}

    def _say_pace(self, pace):
        if pace != self.pace:
            self.pace = pace
            self.publish(pace)

    async def _watch_pace(self):
        """Follow the pace of simulated time: other clients of the live port may change it."""
        while True:
            await asyncio.sleep(RETRY_S)
            if self.flight and self.link["is_live"]:
                if "refused" in await self.live("time"):
                    self._say_pace({**self.pace, "is_there": False})

    # Browsers -----------------------------------------------------------------------------------------------

    def hello(self):
        """The mission, for a page that begins with this flight."""
        return {**hello(self.dictionary, self.flight[0], self.world), "read_only": self.is_read_only}

    def snapshot(self):
        """Messages that describe the present."""
        if self.dictionary is None:
            return [self.link]
        found = [self.hello(), self.link, self.pace, {"kind": "mode", "mode": self.session.mode}]
        found += self.states.values()
        found += self.housekeeping.values()
        found += itertools.islice(self.events, max(0, len(self.events) - SHOWN), None)
        found += [call.message() for call in list(self.commands)[-SHOWN:]]
        return [*found, *self.structures.values(), self.counts] + ([self.links] if self.links else [])


__all__ = ["DEFAULT_PORT", "Hub", "lights_of"]
