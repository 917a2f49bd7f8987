# SPDX-License-Identifier: Apache-2.0
"""The live port of a simulator that flies in real time (docs/live.md): lines of hand and fault, and the pace of simulated time."""

import collections
import pathlib
import re
import socket
import time

from . import visits
from .link import LinkLost
from .run_directory import port_in
from .session import SessionError

ANSWER_S = 5.0  # Longest wait for an answer.
POLL_S = 0.001  # Time between two requests for the simulated time.
PACES = ("pause", "resume", "step", "speed")
VERBS = ("hand", "fault", *PACES)
REPORTS = ("frame", "columns", "truth", "dropped")
REPORTS_MAX = 100_000  # Reports that wait for the caller; then the oldest is dropped.
LINE_MAX = 500
ACTORS = ("hand", "fault", "operator", "ground")


class LiveRefused(SessionError):
    """The simulator has refused a line; nothing has changed."""


def port_of(run):
    """TCP port of the live port of a run. Raises LinkLost."""
    try:
        return port_in((pathlib.Path(run) / "live.port").read_text(encoding="ascii"))
    except (OSError, ValueError) as error:
        raise LinkLost(f"{run}: no live port; fly with TIME=real (make sim-run TIME=real)") from error


def octets_of(line):
    """Octets of a line for the live port. Raises LiveRefused if it is empty, too long, or more than one line."""
    if not line.strip() or any(ord(character) < 0x20 for character in line) or len(line) > LINE_MAX:
        raise LiveRefused(f"found {line[:60]!r}, expected one line of at most {LINE_MAX} characters")
    try:
        return line.encode() + b"\n"
    except UnicodeEncodeError as error:
        raise LiveRefused(f"found {line[:60]!r}, expected a line in UTF-8") from error


def taken(answer):
    """Decode an answer: (simulated time [s] at which the line acts, whether simulated time is paused). Raises LiveRefused."""
    if answer[0] != "ok" or len(answer) < 2:
        raise LiveRefused(re.sub(r"^refused (live:\d+: )?", "refused: ", " ".join(answer)))
    return float(answer[1]), "paused" in answer[2:3]


def pace_of(answer):
    """Decode the rest of an accepted answer: (speed of simulated time, name of the client that aims the hand or None)."""
    rest = [word for word in answer[2:] if word != "paused"]
    settings = dict(zip(rest[::2], rest[1::2]))
    return float(settings.get("speed", 1.0)), settings.get("hand")


class LiveWorld:
    """A connection to the live port of a run. Raises LinkLost if there is none."""

    def __init__(self, run, name="gse"):
        self.run = pathlib.Path(run)
        port = port_of(self.run)
        try:
            self._socket = socket.create_connection(("127.0.0.1", port), timeout=ANSWER_S)
        except OSError as error:
            raise LinkLost(f"{self.run}: the simulator does not answer at port {port}; has the flight ended?") from error
        self.reports = collections.deque(maxlen=REPORTS_MAX)  # frames and truth that arrived before answers
        self._answers = self._socket.makefile("r", encoding="utf-8", newline="\n")
        self.ask(f"name {name}")

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.close()

    def report(self):
        """Wait for the next line about a frame or the true state, which `frames` or `truth` has requested. Raises LinkLost."""
        if self.reports:
            return self.reports.popleft()
        try:
            line = self._answers.readline()
        except OSError as error:
            raise LinkLost(f"{self.run}: the simulator sends no line: {error}") from error
        if not line:
            raise LinkLost(f"{self.run}: the flight has ended")
        return line.rstrip("\n")

    def close(self):
        self._answers.close()
        self._socket.close()

    def stand_still(self):
        """Wait until simulated time is paused, as after `step`."""
        while not self.ask("time")[1]:
            time.sleep(POLL_S)

    def ask(self, line):
        """Send one line; returns (simulated time [s] at which it acts, whether simulated time is paused). Raises LiveRefused, LinkLost."""
        try:
            self._socket.sendall(octets_of(line))
            answer = self._answers.readline().split()
            while answer and answer[0] in REPORTS:
                self.reports.append(" ".join(answer))
                answer = self._answers.readline().split()
        except OSError as error:
            raise LinkLost(f"{self.run}: the simulator does not answer: {error}") from error
        if not answer:
            raise LinkLost(f"{self.run}: the flight has ended")
        return taken(answer)


def _timed(path):
    """(time in s, line) of each line of a scenario that begins with a time and an actor."""
    for text in path.read_text(encoding="utf-8").splitlines():
        words = text.split()
        if len(words) >= 3 and words[1] in ACTORS:
            yield float(words[0]), text


def recording(run, scenario):
    """The scenario that repeats the flight of a run: the lines of its scenario (None: none), of live.scn and of other users, by time.
    Lines of the scenario precede those of the live port of the same time, as they did in flight."""
    lines = [] if scenario is None else list(_timed(pathlib.Path(scenario)))
    live = pathlib.Path(run) / "live.scn"
    lines += list(_timed(live)) if live.exists() else []
    lines += visits.recorded(run)
    return "".join(f"{text}\n" for _, text in sorted(lines, key=lambda line: line[0]))
