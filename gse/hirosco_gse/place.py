# SPDX-License-Identifier: Apache-2.0
"""Ground port, mission and key of a flight, from the files that the launcher writes into the run folder."""

import contextlib
import json
import os
import pathlib
from dataclasses import dataclass

from .session import LinkLost

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 10015
CLASSES = "device classes"
DEFAULT_MISSION = "rokviss"
LOGS = ("run.json", "packets.log", "packets.ascii", "truth.lcm")  # Files of which each run has one.
LATEST = ROOT / "runs" / "latest"


def problem_of(run):
    """Words that say why a folder is not that of a run; None if it is."""
    if any((pathlib.Path(run) / name).exists() for name in LOGS):
        return None
    return f"{run}: found no log of a flight, expected the folder of a run, with {', '.join(LOGS)}"


def facts_of(run):
    """(facts, None): `facts` are those of a flight that has ended, from the launcher's file run.json. ({}, None) if there is no such file, because
    the flight has not ended; ({}, words that say how) if the file is damaged."""
    try:
        text = (pathlib.Path(run) / "run.json").read_text(encoding="utf-8")
        facts = json.loads(text)
    except FileNotFoundError:
        return {}, None
    except (OSError, ValueError, RecursionError) as error:
        return {}, f"run.json: {error}"
    if not isinstance(facts, dict):
        return {}, f"run.json: found '{' '.join(text[:40].split())}', expected an object with the facts of the flight"
    return facts, None


def port_in(text):
    """The port in a file of the launcher. Raises ValueError."""
    port = int(text)
    if not 1 <= port <= 65535:
        raise ValueError(f"found {port}, expected a port from 1 to 65535")
    return port


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
    facts, _ = facts_of(run)
    try:
        code, reason, seconds = facts["exit_code"], facts["exit_reason"], facts["simulated_s"]
        return f"flight {'failed' if code else 'ended'} at {seconds:.2f} s, code {code}{f': {reason}' if reason else ''}", int(code)
    except (KeyError, TypeError, ValueError):
        return f"the flight of {run.name} has ended", None


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
    """How a ground user reaches a flight: run folder, ground port, key file (None: telecommands are not protected), dictionary."""

    run: pathlib.Path
    host: str
    port: int
    key: str
    dictionary: pathlib.Path
    is_port_given: bool = True  # Not taken from the run folder.

    @classmethod
    def of(cls, run=None, host=LOOPBACK, port=None, key=None, dictionary=None):
        """The place of a run. Arguments that are not given come from the run folder, or else from the default mission."""
        run = pathlib.Path(run or LATEST)
        found = port or default_port(run)
        return cls(run, host, found, key or default_key(run, host, found), pathlib.Path(dictionary or default_dictionary(run)), bool(port))

    def check(self):
        """Raise LinkLost if the port would be that of another flight: the flight of the run folder has ended, or the folder has none."""
        if self.is_port_given:
            return
        if (self.run / "run.json").exists():
            raise LinkLost(f"{self.run}: {end_of(self.run)[0]}; name a flight under way with --run or --port")
        try:
            port_in((self.run / "ground.port").read_text(encoding="ascii"))
        except FileNotFoundError as error:
            if self.run != LATEST:
                raise LinkLost(f"{self.run}: found no file ground.port, expected the folder of a flight under way") from error
        except (OSError, ValueError) as error:
            raise LinkLost(f"{self.run}/ground.port: {error}; name the port of the flight with --port") from error


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
