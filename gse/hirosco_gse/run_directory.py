# SPDX-License-Identifier: Apache-2.0
"""Ground port, mission and key of a flight, from the files that the launcher writes into the run directory."""

import contextlib
import errno
import json
import math
import os
import pathlib
import re
import socket
from dataclasses import dataclass

from .session import LinkLost
from .values import quoted, shortened

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 10015
CLASSES = "device classes"
DEFAULT_MISSION = "rokviss"
LOGS = ("run.json", "packets.log", "packets.ascii", "truth.lcm")  # Each run has at least one of these files.
LATEST = ROOT / "runs" / "latest"
FACTS = "run.json"
TEXT, HASH, WHOLE, NUMBER, TRUTH, OBJECT, LIST = "text", "a hash such as 0x12AB", "a whole number", "a number", "true or false", "an object", "a list"
# Types of the values of run.json that the ground uses, an object before its members. Figures are other values: numbers, or null.
FACT_TYPES = {
    **dict.fromkeys(("relay", "versions", "sha256", "figures_missing", "report"), OBJECT),
    **dict.fromkeys(("mission", "scenario", "world", "form", "time", "bus", "transport", "links", "remote_endian", "rtos", "exit_reason"), TEXT),
    **dict.fromkeys(("interface_hash", "configuration_hash", "device_classes_hash"), HASH),
    **dict.fromkeys(("seed", "nodes", "live_lines", "exit_code", "guards", "packets"), WHOLE),
    **dict.fromkeys(("simulated_s", "wall_s", "real_time_factor", "relay.round_trip_ms"), NUMBER),
    **dict.fromkeys(("reproducible", "cut_short", "figures_hold", "relay.network"), TRUTH),
    **dict.fromkeys(("processes", "figures_failed", "report_problems"), LIST),
}
PYTHON_TYPES = {TEXT: str, HASH: str, WHOLE: int, NUMBER: (int, float), TRUTH: bool, OBJECT: dict, LIST: list}
LARGEST = 1 << 64  # Largest absolute value of a number in run.json.


def problem_of(run):
    """Words that say why a directory is not that of a run; None if it is."""
    if any((pathlib.Path(run) / name).exists() for name in LOGS):
        return None
    return f"{run}: found no log of a flight, expected the directory of a run, with one of {', '.join(LOGS)}"


def _infinite(value, name):
    """(name, value) of the first number within a value that is not finite, in the order of the file; None if all are finite."""
    if isinstance(value, float) and not math.isfinite(value):
        return name, value
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    within = (_infinite(member, f"{name}.{key}" if name else str(key)) for key, member in members)
    return next((found for found in within if found), None)


def _is_of(kind, value):
    if kind == HASH and isinstance(value, str):
        return re.fullmatch("0[xX][0-9A-Fa-f]{1,16}", value) is not None
    is_small = kind not in (WHOLE, NUMBER) or isinstance(value, (int, float)) and abs(value) <= LARGEST
    return isinstance(value, PYTHON_TYPES[kind]) and isinstance(value, bool) == (kind == TRUTH) and is_small


def _misfit(facts):
    """Words about the first value of run.json that is not of its type; None if there is no such value."""
    if found := _infinite(facts, ""):
        return f"{shortened(found[0])}: found {json.dumps(found[1])}, expected a finite number"
    for name, kind in FACT_TYPES.items():
        owner, _, member = name.rpartition(".")
        within = facts.get(owner, {}) if owner else facts
        if member not in within:
            continue
        value = within[member]
        if not _is_of(kind, value):
            return f"{name}: found {shortened(json.dumps(value))}, expected {kind}"
    return None


def facts_of(run):
    """(facts, None): `facts` are those of a flight that has ended, from the launcher's file run.json. ({}, None) if there is no such file, because
    the flight has not ended; ({}, words that say how) if the file is damaged."""
    try:
        text = (pathlib.Path(run) / FACTS).read_text(encoding="utf-8")
        facts = json.loads(text)
        problem = _misfit(facts) if isinstance(facts, dict) else f"found '{' '.join(text[:40].split())}', expected an object with the facts of the flight"
    except FileNotFoundError:
        return {}, None
    except OSError as error:
        return {}, f"{FACTS}: {error.strerror}"
    except (ValueError, RecursionError) as error:
        return {}, f"{FACTS}: {error}"
    return ({}, f"{FACTS}: {problem}") if problem else (facts, None)


class FactMissing(ValueError):
    """run.json without a key, with the file and the key in words."""


def fact(facts, name, run=None):
    """A value of the facts of a flight that has ended. run: its directory, which the words about a missing key name. Raises FactMissing."""
    if name not in facts:
        raise FactMissing(f"{f'{run}: ' if run else ''}{FACTS}: {name}: found none, expected {FACT_TYPES[name]}")
    return facts[name]


def is_under_way(run):
    """Whether the flight of a run directory is under way: it has no run.json, and its ground port is in use. The function does not connect to
    the port, because a connection would change the flight."""
    if (run / FACTS).exists() or not (run / "ground.port").exists():
        return False
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, default_port(run)))
        except OSError as error:
            return error.errno == errno.EADDRINUSE
    return False


def port_in(text):
    """The port in a file of the launcher. Raises ValueError."""
    word = text.strip()
    if not word.isascii() or not word.isdecimal() or len(word) > 5 or not 1 <= int(word) <= 65535:
        raise ValueError(f"found {quoted(word)}, expected a port from 1 to 65535")
    return int(word)


def default_port(run):
    """Ground port of a run."""
    try:
        return port_in((run / "ground.port").read_text(encoding="ascii"))
    except (OSError, ValueError):
        return DEFAULT_PORT


def mission_of(run):
    """Name of the mission of a run from the launcher's file; without this file the default mission."""
    try:
        return (run / "ground.mission").read_text(encoding="utf-8").strip() or DEFAULT_MISSION
    except (OSError, ValueError):
        return DEFAULT_MISSION


def scenario_of(run):
    """Name of the scenario of a run, without its directory, from the launcher's file: "none" if the run has no scenario, "" if the file is
    missing."""
    try:
        return pathlib.Path((pathlib.Path(run) / "ground.scenario").read_text(encoding="utf-8").strip()).stem
    except (OSError, ValueError):
        return ""


def world_of(run):
    """File of the world of a run from the launcher's file; without this file the world of the mission."""
    try:
        name = (run / "ground.world").read_text(encoding="utf-8").strip()
    except (OSError, ValueError):
        name = ""
    name = name or mission_of(run)
    return ROOT / name if name.endswith(".xml") else ROOT / "descriptors" / "worlds" / f"{name}.xml"


def end_of(run):
    """(words about the end of a flight, its exit code or None if that is not known) from the launcher's file run.json."""
    facts, problem = facts_of(run)
    try:
        code, reason, seconds = (fact(facts, name) for name in ("exit_code", "exit_reason", "simulated_s"))
        return f"flight {'failed' if code else 'ended'} at {seconds:.2f} s, code {code}{f': {reason}' if reason else ''}", code
    except FactMissing as missing:
        return f"the flight of {run.name} has ended; {problem or missing}", None


def default_key(run, host, port):
    """Key file of a run from the launcher's file; for a flight on another host or port, the file that the environment names. None: telecommands
    are not protected."""
    if host != LOOPBACK or not (run / "ground.port").exists() or port != default_port(run):
        return os.environ.get("GSE_KEY")
    try:
        return (run / "ground.key-file").read_text(encoding="utf-8").strip() or None
    except OSError:
        return None


def default_dictionary(run):
    """Dictionary of the mission of a run."""
    return ROOT / "build" / "generated" / f"{mission_of(run)}.json"


@dataclass(frozen=True)
class Place:
    """How a ground user reaches a flight: run directory, ground port, key file (None: telecommands are not protected), dictionary."""

    run: pathlib.Path
    host: str
    port: int
    key: str
    dictionary: pathlib.Path
    is_port_given: bool = True  # Not taken from the run directory.

    @classmethod
    def of(cls, run=None, host=LOOPBACK, port=None, key=None, dictionary=None):
        """The place of a run. Arguments that are not given come from the run directory, or else from the default mission."""
        run = pathlib.Path(run or LATEST)
        found = port or default_port(run)
        return cls(run, host, found, key or default_key(run, host, found), pathlib.Path(dictionary or default_dictionary(run)), bool(port))

    def check(self):
        """Raise LinkLost if the port would be that of another flight: the flight of the run directory has ended, or the directory has none."""
        if self.is_port_given:
            return
        if (self.run / "run.json").exists():
            raise LinkLost(f"{self.run}: {end_of(self.run)[0]}; name a flight under way with --run or --port")
        try:
            port_in((self.run / "ground.port").read_text(encoding="ascii", errors="replace"))
        except FileNotFoundError as error:
            if self.run != LATEST:
                raise LinkLost(f"{self.run}: found no file ground.port, expected the directory of a flight under way") from error
        except (OSError, ValueError) as error:
            raise LinkLost(f"{self.run}/ground.port: {error.strerror if isinstance(error, OSError) else error}; name the port of the flight with --port") from error


def compare_classes(place, session):
    """Compare the hash of the device classes of a flight, from the launcher's file, with that of the session's dictionary. If they differ,
    session.mismatches says so under CLASSES. A flight on another host or port is not compared: its file is not here."""
    known = session.dictionary.content.get("device_classes_hash")
    if not known or place.host != LOOPBACK or place.port != default_port(place.run):
        return
    with contextlib.suppress(OSError, ValueError):
        flown = (place.run / "ground.classes").read_text(encoding="ascii").strip()
        if int(flown, 0) != int(known, 0):
            session.mismatches[CLASSES] = f"the flight has device classes {flown}, the dictionary has those of {known}: run make"
