# SPDX-License-Identifier: Apache-2.0
"""Serves the page and its WebSocket on this machine only.

Browser -> station, JSON: {"do": "command", "text": ...}, {"do": "plan", "text": ...}, {"do": "live", "line": ...},
{"do": "structures", "subsystem": ...}, {"do": "forms"}, {"do": "script"}, {"do": "watch", "bus": name or null}, {"do": "watch", "truth": true},
{"do": "ask", "text": ...}, {"do": "upload", "words": [...], "data": base64}, each with an "id" that the answer repeats. Instead of "text", a
command or plan may have "form" and "values" (forms.py). Structures that a command with "display": true enables are disabled when no page is
open any more. Station -> browser: the messages of the hub, and answers {"kind": "answer", "id": ...}, for a line {"kind": "live", "id": ...}. The
answer to a request that is no JSON object has the "id" null."""

import asyncio
import base64
import contextlib
import errno
import itertools
import json
import logging
import re
import sys

from aiohttp import WSCloseCode, WSMsgType, web
from aiohttp.http import HttpProcessingError

from .. import live, packets
from ..command import UsageError, words_of
from ..critical import is_critical
from ..files import PageFiles
from ..values import json_of, quoted
from . import orders
from .forms import script_of
from .hub import Hub
from .interfaces import subsystems_of

# Messages that wait for a slow browser. If there are more, the oldest update is dropped, and the page gets the number of dropped updates.
QUEUE = 400
UPDATES = tuple(f'{{"kind": "{kind}"' for kind in ("housekeeping", "truth", "bus", "counts"))  # Each update has newer values than the one before.
# Other messages are not dropped. If so many messages or characters wait, the connection is closed: the page connects again, and gets the present state.
MESSAGES_MAX, CHARACTERS_MAX = 8 * QUEUE, 1 << 24
ROOM, CHARACTERS_ROOM = QUEUE // 2, 1 << 20  # While more messages or characters wait, no request of the page is read.
UNDER_WAY = 16  # Maximum number of `ask` of a page that wait for other programs at the same time; as many `live` may wait, too.
ALIVE, ALIVE_S = '{"kind": "alive"}', 0.5  # A page that hears nothing for 1 s knows that the station is silent.
MESSAGE_MAX = 1 << 18  # A file of 128 KiB in base64.
COMMAND_MAX = 1 << 16  # Characters of a command: the largest request in hexadecimal digits has half of them.
CLOSE_S = 1.0  # Time in which a page must answer that its connection is closed, when the station ends.
POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; frame-ancestors {framed_by}; base-uri 'none'; form-action 'none'"
SLOW = re.compile(r'\{"do": ?"(ask|live)"')  # Requests that another program answers.
REPLAY = "replay: a recorded flight takes no commands"  # The same text as in gse/page/src/replay.js.
READS = ("structures", "plan", "forms", "script", "watch", "packets")
DISPLAY = ("hk", "enable")
LIVE = [[verb] for verb in live.VERBS]  # Commands for the simulator, not for the spacecraft.
HEADERS = {"X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cache-Control": "no-cache"}


_NUMBERS = itertools.count(1)


def _bounded(text):
    """The text of a command. Raises UsageError: to read it would delay other pages."""
    if len(text) > COMMAND_MAX:
        raise UsageError(f"found a command of {len(text)} characters, expected at most {COMMAND_MAX}")
    return text


def _is_of_station(record):
    """False for the log record of a request that is not HTTP: its client gets the reason, and the console shows nothing."""
    return not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError))


logging.getLogger("aiohttp.server").addFilter(_is_of_station)


class _Browser:
    """One open page."""

    def __init__(self, socket, abort=lambda: None):
        """abort(): end the connection at once."""
        self.socket, self.abort = socket, abort
        self.waiting, self._characters, self._updates = [], 0, 0  # Messages, and how many characters and updates they have.
        self.bus = None  # Bus whose frames the page shows.
        self.has_truth = False  # The page shows the robot with the true state of the simulator.
        self.dropped = self._told = 0  # Dropped messages, and how many of them were reported to the page.
        self.number = next(_NUMBERS)
        self._wake, self._room = asyncio.Event(), asyncio.Event()
        self._room.set()

    def watch(self, order):
        """Select the bus whose frames the page receives from now on, and whether it receives the truth."""
        if "bus" in order:
            self.bus = str(order["bus"]) if order["bus"] else None
        self.has_truth = bool(order.get("truth", self.has_truth))

    def put(self, message):
        if len(self.waiting) >= QUEUE and self._updates:
            self._take(next(n for n, text in enumerate(self.waiting) if text.startswith(UPDATES)))
            self.dropped += 1
        self.waiting.append(message)
        self._characters += len(message)
        self._updates += message.startswith(UPDATES)
        if not self._has_room():
            self._room.clear()
        if len(self.waiting) > MESSAGES_MAX or self._characters > CHARACTERS_MAX:
            self.abort()
        self._wake.set()

    def _take(self, number):
        """Take a message from those that wait."""
        text = self.waiting.pop(number)
        self._characters -= len(text)
        self._updates -= text.startswith(UPDATES)
        return text

    def _has_room(self):
        return len(self.waiting) <= ROOM and self._characters <= CHARACTERS_ROOM

    async def room(self):
        """Wait until at most ROOM messages and CHARACTERS_ROOM characters wait for the page, or the connection has ended."""
        await self._room.wait()

    async def send(self):
        """Send the waiting messages until the connection ends. If none waits, report every ALIVE_S that the station runs."""
        try:
            await self._send()
        finally:
            self._room.set()

    async def _send(self):
        while True:
            try:
                async with asyncio.timeout(ALIVE_S):  # wait_for of Python 3.11 may ignore the end of this task.
                    await self._wake.wait()
            except TimeoutError:
                await self.socket.send_str(ALIVE)
            self._wake.clear()
            while self.waiting:
                if self.dropped > self._told:
                    self._told = self.dropped
                    await self.socket.send_str(json.dumps({"kind": "dropped", "updates": self.dropped}))
                text = self._take(0)
                if self._has_room():
                    self._room.set()
                await self.socket.send_str(text)


class Station:
    """The web application: hub and browsers."""

    def __init__(self, run, page, replayed=None, is_read_only=False, framed_by="'none'"):
        """replayed: directory or recording of a run that is replayed; then no flight is followed. is_read_only: pages
        cannot send commands. framed_by: origin of the page that may show the page of the station in a frame."""
        self.hub = Hub(run, self.publish, is_read_only=is_read_only, files=PageFiles())
        self.browsers = set()
        self._replayed, self._recorded, self._making = replayed, (None, b""), asyncio.Lock()
        self._page = page
        self._host = None
        self._headers = {"Content-Security-Policy": POLICY.format(framed_by=framed_by), **HEADERS}

    def publish(self, message):
        text = json_of(message)
        for browser in self.browsers:
            if message["kind"] != "truth" or browser.has_truth:
                browser.put(text)

    def application(self, host):
        """aiohttp application for browsers that address it as `host` (address:port)."""
        self._host = host
        application = web.Application(middlewares=[self._guard])
        application.router.add_get("/", self._index)
        application.router.add_get("/ws", self._socket)
        application.router.add_get("/recording", self._recording)
        application.router.add_static("/page/", self._page)
        if not self._replayed:
            application.cleanup_ctx.append(self._run_hub)
        application.on_shutdown.append(self._close_pages)
        return application

    async def _close_pages(self, _application):
        """Close the connections of all pages. A page that hangs does not delay the end of the station."""
        closing = [asyncio.create_task(browser.socket.close(code=WSCloseCode.GOING_AWAY)) for browser in self.browsers]
        if closing:
            _, late = await asyncio.wait(closing, timeout=CLOSE_S)
            for task in late:
                task.cancel()
        for browser in self.browsers:
            browser.abort()

    async def _run_hub(self, _application):
        task = asyncio.create_task(self.hub.serve())
        yield
        await self.hub.leave()
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task

    @web.middleware
    async def _guard(self, request, handler):
        """Refuse requests of other pages in the same browser, also if they use another name of this address: they must not command a spacecraft."""
        known = (self._host, self._host.replace("127.0.0.1", "localhost"))
        origin = request.headers.get("Origin")
        if request.host not in known or origin is not None and origin != f"http://{request.host}":
            raise web.HTTPForbidden(text="this station accepts requests of its own page only")
        try:
            response = await handler(request)
        except OSError as error:
            if error.errno != errno.ENAMETOOLONG:
                raise
            raise web.HTTPNotFound from error  # No file has such a name.
        if not response.prepared:
            response.headers.update(self._headers)
        return response

    async def _recording(self, _request):
        """The recording of the run that is replayed, or of the flight that has ended; made in a process of its own."""
        if not self._replayed and (self.hub.flight is None or self.hub.is_linked):
            raise web.HTTPConflict(text="there is no flight that has ended")
        if self._replayed and self._replayed.is_file():
            return web.FileResponse(self._replayed, headers={"Content-Type": "application/octet-stream"})
        directory = str(self._replayed or self.hub.flight[0])
        async with self._making:  # All pages that wait get the same recording.
            if self._recorded[0] != directory:
                self._recorded = (directory, await self._made(directory))
        return web.Response(body=self._recorded[1], content_type="application/octet-stream")

    @staticmethod
    async def _made(directory):
        """Octets of the recording of a run."""
        words = (sys.executable, "-m", "hirosco_gse.recording", directory)
        maker = await asyncio.create_subprocess_exec(*words, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE)
        octets, error_text = await maker.communicate()
        if maker.returncode:
            reason = error_text.decode("utf-8", "replace").strip().rpartition("\n")[2]
            raise web.HTTPInternalServerError(text=f"{directory} cannot be replayed: {reason or f'exit code {maker.returncode}'}")
        return octets

    async def _index(self, request):
        if self._replayed and "replay" not in request.query:
            raise web.HTTPFound("/?replay")
        return web.FileResponse(self._page / "index.html", headers=self._headers)

    async def _socket(self, request):
        if "Origin" not in request.headers:
            raise web.HTTPForbidden(text=f"found no header Origin, expected that of the page of this station: open http://{self._host}/ in a browser")
        socket = web.WebSocketResponse(heartbeat=10, max_msg_size=MESSAGE_MAX, compress=False)
        if not socket.can_prepare(request):
            raise web.HTTPBadRequest(text="found a request without the headers of a WebSocket, expected Upgrade: websocket, Connection: Upgrade, "
                                          "Sec-WebSocket-Version: 13 and a Sec-WebSocket-Key")
        await socket.prepare(request)
        browser = _Browser(socket, lambda: request.transport and request.transport.abort())
        for message in self.hub.snapshot():
            browser.put(json_of(message))
        browser.put(json.dumps({"kind": "ready", "page": browser.number}))
        self.browsers.add(browser)
        self._look()
        sender, lines, lists = asyncio.create_task(browser.send()), set(), set()
        try:
            async for message in socket:
                await asyncio.sleep(0)  # Other pages and the telemetry have a turn, however many requests of this page have arrived.
                if message.type == WSMsgType.TEXT:
                    # The answer takes time; meanwhile the page may send other requests.
                    if slow := SLOW.match(message.data):
                        group = lines if slow[1] == "live" else lists
                        if len(group) >= UNDER_WAY:
                            await self._reply(self._refuse(message.data), browser)
                            await browser.room()
                            continue
                        performed = self._perform(message.data, browser) if group is lines else self._ask(message.data)
                        group.add(task := asyncio.create_task(self._reply(performed, browser)))
                        task.add_done_callback(group.discard)
                        continue
                    await self._reply(self._perform(message.data, browser), browser)
                    await browser.room()
        finally:
            self.browsers.discard(browser)
            self._look()
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sender
            await asyncio.gather(*lines, return_exceptions=True)  # One of them may aim the hand, which is then given back.
            await self.hub.leave_hand(browser.number)
        return socket

    @staticmethod
    async def _reply(performing, browser):
        """Send a page the answer to its request."""
        browser.put(json_of(await performing))

    @staticmethod
    async def _refuse(text):
        """Refuse a request because too many are under way."""
        try:
            number = orders.read(text).get("id")
        except UsageError:
            number = None
        return {"kind": "answer", "id": number, "refused": f"{UNDER_WAY} requests of this page wait for their answers; try again when one has arrived"}

    def _look(self):
        self.hub.set_viewers(len(self.browsers))
        self.hub.truth.watch(any(browser.has_truth for browser in self.browsers))
        self.hub.taps.watch({browser.bus for browser in self.browsers} - {None})

    async def _perform(self, text, browser):
        number = None
        try:
            order = orders.read(text)
            number = order.get("id")
            orders.check(order)
            self._check_right(order["do"], order)
            if order["do"] == "live":
                return {**await self._live(order["line"], browser), "id": number}
            return {**await self._answer(order["do"], order, browser), "kind": "answer", "id": number}
        except (UsageError, live.LiveRefused) as problem:
            return {"kind": "answer", "id": number, "refused": str(problem)}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            refused = f"not understood: found {quoted(text)}, expected values as the page of the station sends them"
            return {"kind": "answer", "id": number, "refused": refused}

    async def _answer(self, do, order, browser):
        """Perform a request. Returns the content of its answer."""
        if do == "command":
            return await self._command(order, browser)
        if do == "structures":
            self.hub.display.ask(order["subsystem"])
            return {}
        if do == "plan":
            return self._preview(self._text(order))
        if do == "upload":
            words = [str(word) for word in order["words"]]
            _bounded(" ".join(words))
            try:
                octets = base64.b64decode(order["data"], validate=True)
            except ValueError as problem:
                raise UsageError(f"not understood: found \"data\": {quoted(order['data'])}, expected the octets of a file in base64") from problem
            return {"command": self.hub.upload(words, octets)}
        if do == "packets":
            return self.hub.kept(order.get("kind"))
        if do == "watch":
            browser.watch(order)
            self._look()
            return {}
        if do == "forms":
            return self.hub.forms.message() if self.hub.dictionary else {"refused": "no flight"}
        return {"text": script_of(self.hub.commands)}

    async def _live(self, line, browser):
        """Send a line of a page to the simulator: a verb of LIVE, or `time`. Others, such as `frames`, would change the connection, which all
        pages use. Raises UsageError."""
        if line.split()[:1] not in [*LIVE, ["time"]]:
            raise UsageError(f"found '{line[:60]}', expected a line that begins with {', '.join(live.VERBS)}")
        return await self.hub.live(line, browser.number)

    async def _command(self, order, browser):
        text = self._text(order)
        if text.split()[:1] in LIVE:
            return await self.hub.live(text, browser.number)
        return {"command": self.hub.command(text, bool(order.get("display")))}

    def _check_right(self, do, order):
        """In a read-only station, permit only requests that read, and the enabling of one housekeeping structure; in a replay, permit none.
        Raises UsageError."""
        self._check_replay()
        if not self.hub.is_read_only or do in READS:
            return
        if do != "command" or not order.get("display") or tuple(words_of(_bounded(str(order.get("text"))))[:2]) != DISPLAY:
            raise UsageError("this station is read only; start one without --read-only (make gse READ_ONLY=) to command")

    def _check_replay(self):
        if self._replayed:
            raise UsageError(REPLAY)

    async def _ask(self, text):
        order = {}
        try:
            order = orders.read(text)
            orders.check(order)
            self._check_replay()
            answer = {"rows": await self.hub.ask(_bounded(order["text"]))}
        except UsageError as problem:
            answer = {"refused": str(problem)}
        return {"kind": "answer", "id": order.get("id"), **answer}

    def _text(self, order):
        return _bounded(self.hub.text_of(order["form"], order["values"]) if "form" in order else order["text"])

    def _preview(self, text):
        if text.split()[:1] in LIVE:
            live.octets_of(text)
            return {"text": text, "line": text, "critical": False, "octets": [], "messages": ["line for the simulator"]}
        planned = self.hub.plan(text)
        octets = [
            packets.build_tc(request.apid, 0, request.service, request.subtype, request.data, self.hub.session.source)
            for request in planned.requests
        ]
        return {"text": planned.text, "line": text, "critical": is_critical(planned, self.hub.dictionary), "octets": [octet.hex() for octet in octets],
                "subsystems": subsystems_of(planned, self.hub.dictionary),
                "messages": [f"TC[{request.service},{request.subtype}]" for request in planned.requests]}
