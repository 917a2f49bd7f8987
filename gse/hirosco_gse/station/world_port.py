# SPDX-License-Identifier: Apache-2.0
"""The simulator's live port (live.py) without blocking: one connection for lines, and others for the true state and for the frames of each bus."""

import asyncio
import collections
import contextlib
import pathlib
import time

from .. import live
from ..frames import Database, DatabaseError
from ..link import LinkLost, words_of
from ..run_directory import ROOT
from ..values import bits_of
from .bus_tap import BusTap

ANSWER_S = 2.0  # Longest wait for an answer.
SHOW_S = 0.25  # Time between two messages about a bus.
RETRY_S = 0.5  # Time between two attempts to connect.
TRUTH_HZ = 20
SILENT = "the simulator does not answer: time-out"
ENDED = "the flight has ended"


def _words(error):
    return f"the simulator does not answer: {words_of(error)}"


class WorldPort:
    """Sends lines to the live port of a run directory. A line is sent at once, also while others wait for their answers."""

    def __init__(self, name="station"):
        self._name = name
        self.speed, self.hand = 1.0, None  # Pace of simulated time; name of the client that aims the hand.
        self._run = self._writer = self._reading = None
        self._waiting = collections.deque()  # Futures of the answers that are still to come, in the order of their lines.
        self._turn = asyncio.Lock()

    def close(self, problem="the connection was closed"):
        """Close the connection; lines without an answer get LinkLost, and the next line opens another connection."""
        if self._writer:
            self._writer.close()
            self._reading.cancel()
        self._writer = self._reading = None
        waiting, self._waiting = self._waiting, collections.deque()
        for answer in waiting:
            if not answer.done():
                answer.set_exception(LinkLost(problem))

    def move_to(self, run, name):
        """Use the live port of another run, as a client of this name."""
        self.close()
        self._run, self._name = run, name

    async def _open(self):
        if self._run is None:
            raise LinkLost("no flight is known")
        reader, self._writer = await asyncio.open_connection("127.0.0.1", live.port_of(self._run))
        self._reading = asyncio.create_task(self._read(reader, self._waiting))
        self._send(f"name {self._name}").add_done_callback(lambda answer: answer.exception())  # The next line reports a loss.

    async def _read(self, reader, waiting):
        """Give each answer to its line, until the connection ends. Lines about frames or the true state, which an earlier line has
        requested, are skipped."""
        problem = ENDED
        try:
            while line := await reader.readline():
                words = line.decode("utf-8", "replace").split()
                if words[:1] and words[0] not in live.REPORTS:
                    answer = waiting.popleft()
                    if not answer.done():  # The sender of the line may have ended.
                        answer.set_result(words)
        except (OSError, ValueError, IndexError) as error:
            problem = _words(error)
        if waiting is self._waiting:
            self.close(problem)

    def _send(self, line):
        """Send a line. Returns the future of its answer."""
        answer = asyncio.get_running_loop().create_future()
        self._waiting.append(answer)
        self._writer.write(live.octets_of(line))
        return answer

    async def _exchange(self, line):
        """Send a line. Returns the words of its answer. Raises LinkLost."""
        async with self._turn:
            try:
                if self._writer is None:
                    await self._open()
            except OSError as error:
                raise LinkLost(_words(error)) from error
            waiting, answer = self._waiting, self._send(line)
        try:
            async with asyncio.timeout(ANSWER_S):
                return await answer
        except TimeoutError as error:
            if waiting is self._waiting:  # Otherwise another line has closed the connection.
                self.close(SILENT)
            raise LinkLost(SILENT) from error

    async def ask(self, line):
        """Send a line. Returns (simulated time [s] at which it acts, whether simulated time is paused). Raises
        LiveRefused, LinkLost."""
        live.octets_of(line)
        answer = await self._exchange(line)
        found = live.taken(answer)
        self.speed, hand = live.pace_of(answer)
        self.hand = hand if hand != self._name else None
        return found


BASE = ("x", "y", "z", "qw", "qx", "qy", "qz")
# Names of the entries of a row, as those of a recording, and the ending of the column that each of them has.
ENTRIES = {"joints": ".brake", "contacts": ".contact-x", "springs": ".spring-x", "bases": ".qw", "wheels": ".momentum", "valves": ".open"}


def names_of(columns):
    """Names of joints, contacts, springs, free bases, wheels and valves of a row of the true state, in their order."""
    return {kind: [name.removesuffix(ending) for name in columns if name.endswith(ending)] for kind, ending in ENTRIES.items()}


def poses_of(columns, values):
    """Values of a row of the true state by the names that the page uses: positions, torques and brakes of all joints, the force of the first
    contact and spring, the poses of all free bases, the momenta of the wheels, and whether each valve is open."""
    row, names = dict(zip(columns, values)), names_of(columns)
    joints = names["joints"]
    found = {"CUR_VALUES.POSITION": [row[f"{name}.position"] for name in joints], "CUR_VALUES.TORQUE": [row[f"{name}.torque"] for name in joints],
             "BRAKE": [row[f"{name}.brake"] for name in joints]}
    contact, spring = (next(iter(names[kind]), None) for kind in ("contacts", "springs"))
    if contact or spring:
        found["FORCE"] = _force(row, contact, spring)
    if spring:
        found["HOOKED"] = [row[f"{spring}.spring"]]
    rest = {"BASE": [row[f"{base}.{part}"] for base in names["bases"] for part in BASE],
            "WHEEL": [row[f"{wheel}.momentum"] for wheel in names["wheels"]], "VALVE": [row[f"{valve}.open"] for valve in names["valves"]]}
    return found | {leaf: numbers for leaf, numbers in rest.items() if numbers}


def _force(row, contact, spring):
    """Sum of the forces of a contact and a spring that may be None."""
    forces = [[row[f"{name}-{axis}"] for axis in "xyz"] for name in (contact and f"{contact}.contact", spring and f"{spring}.spring") if name]
    return [sum(parts) for parts in zip(*forces)]


class Truth:
    """The true state of the simulated world, TRUTH_HZ times a second of simulated time, while a page wants it."""

    def __init__(self, publish):
        self._publish, self._task, self._run = publish, None, None

    def move_to(self, run):
        """Follow another run."""
        self._run = run

    def watch(self, is_wanted):
        """Begin to follow the true state, or end it."""
        if is_wanted and self._task is None:
            self._task = asyncio.create_task(self._follow())
        elif not is_wanted and self._task is not None:
            self._task.cancel()
            self._task = None

    async def _follow(self):
        while True:
            with contextlib.suppress(OSError, LinkLost, ValueError):
                await self._read()
            await asyncio.sleep(RETRY_S)

    async def _read(self):
        reader, writer = await asyncio.open_connection("127.0.0.1", live.port_of(self._run))
        columns = []
        try:
            writer.write(live.octets_of("name station-truth") + live.octets_of(f"truth {TRUTH_HZ}"))
            while line := (await reader.readline()).decode("ascii"):
                word, *words = line.split()
                if word == "columns":
                    columns = words
                elif word == "truth" and len(words) == len(columns):
                    numbers = [float(number) for number in words]
                    self._publish({"kind": "truth", "time": numbers[0], "values": poses_of(columns, numbers), "names": names_of(columns)})
        finally:
            writer.close()


class Taps:
    """Frames of the buses that a page shows, from the listen-only tap of the live port, which does not influence the bus."""

    def __init__(self, publish):
        self._publish, self._tasks = publish, {}
        self._run = self._dictionary = self._mismatches = None

    def move_to(self, run, dictionary, mismatches):
        """Follow the buses of another run. mismatches: for each APID whose subsystem flies another interface, the words
        about it; entries may be added later."""
        self._run, self._dictionary, self._mismatches = run, dictionary, mismatches

    def watch(self, names):
        """Follow these buses from now on, and no others."""
        known = {bus["name"] for bus in self._dictionary.buses} if self._dictionary else set()
        for name in set(self._tasks) - names:
            self._tasks.pop(name).cancel()
        for name in (names & known) - set(self._tasks):
            self._tasks[name] = asyncio.create_task(self._follow(name))

    async def _follow(self, name):
        while True:
            try:
                await self._read(self._tap(name))
                problem = ENDED
            except OSError as error:  # The file live.port stays in the directory of a flight that has ended.
                problem = ENDED if (pathlib.Path(self._run) / "run.json").exists() else _words(error)
            except (LinkLost, StopIteration) as error:
                problem = str(error)
            self._publish({"kind": "bus", "bus": name, "problem": problem})
            await asyncio.sleep(RETRY_S)

    def _tap(self, name):
        about = next(bus for bus in self._dictionary.buses if bus["name"] == name)
        try:
            database = Database(ROOT / "build" / "generated" / f"{self._dictionary.mission}-{name}.dbc")
            warning = database.problem_with(self._dictionary.content, "the dictionary")
        except DatabaseError as error:
            database, warning = None, f"frames are not decoded: {error}"
        return BusTap(name, about.get("bit_rate") or 1e6, about.get("data_bit_rate") or 5e6, database, warning, bits_of(self._dictionary.content))

    def _message_of(self, tap):
        """Message of a tap. If a subsystem flies another interface, the message contains a warning about the frames."""
        message = tap.message()
        return message | {"warning": message["warning"] or next(iter(self._mismatches.values()), None)}

    async def _read(self, tap):
        reader, writer = await asyncio.open_connection("127.0.0.1", live.port_of(self._run))
        try:
            writer.write(live.octets_of("name station-frames") + live.octets_of(f"frames {tap.name} on"))
            shown = time.monotonic()
            while octets := await reader.read(1 << 16):
                tap.feed(octets)
                if time.monotonic() - shown >= SHOW_S:
                    shown = time.monotonic()
                    self._publish(self._message_of(tap))
        finally:
            writer.close()
