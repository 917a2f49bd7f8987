# SPDX-License-Identifier: Apache-2.0
"""Fly missions as a user does: with the launcher's command line. Check what a run leaves and what it must not
leave."""

import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = ROOT / "build" / "bin"
PUSDUMP = BIN / "pusdump"
# Wall-clock limits that only end tests that would wait without end; no test measures the speed of the
# machine.
FLIGHT_LIMIT_S = 600.0
MOMENT_S = 120.0
BUS_LOGS = ("can-robot.log", "can-joystick.log")
TRACED = ("packets.log", *BUS_LOGS)
# Numbers of states (docs/states.md), as in TM[129,2].
OPERATIONAL = 5
ERROR_TO_OFFLINE = [6, 7, 8, 9, 0]  # ERROR_OPERATIONAL, POST_OPERATIONAL, HARDWARE_DEINIT, SOFTWARE_DEINIT, OFFLINE.

sys.path.insert(0, str(ROOT / "gse"))

from hirosco_gse import run_directory  # noqa: E402


@dataclass
class Flight:
    """A launcher, running or ended, and the directory of its run."""

    directory: pathlib.Path
    process: subprocess.Popen
    began: float = field(default_factory=time.monotonic)
    output: str = ""
    seconds: float = 0.0

    @property
    def code(self):
        """Exit code of the launcher; None while it runs."""
        return self.process.returncode

    @property
    def identity(self):
        """Prefix of every name of the run."""
        return f"hirosco-{self.process.pid}"

    @property
    def facts(self):
        """run.json."""
        return json.loads(self.read("run.json"))

    @property
    def console(self):
        """Output of the programs of the run."""
        path = self.directory / "console.log"
        return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""

    @property
    def packets(self):
        """(time_ns, direction, octets) of every line of packets.log.

        Places in the octets, counted from 0: 0 and 1 have the APID, 2 and 3 the sequence count, 7 the service, 8 the subtype. A request has its
        source in 9 and 10, and its data from 11 on. A report has its destination in 11 and 12, its time in 13 to 20, and its data from 21 on. The
        last two octets are the checksum."""
        found = []
        for line in self.read("packets.log").splitlines():
            stamp, direction, text = line.split(" ")
            found.append((int(stamp.replace(".", "")), direction, bytes.fromhex(text)))
        return found

    def read(self, name):
        """Text of a file of the run."""
        return (self.directory / name).read_text(encoding="utf-8")

    def octets(self, name):
        """Octets of a file of the run."""
        return (self.directory / name).read_bytes()

    def wait(self, limit_s=FLIGHT_LIMIT_S):
        """Wait until the launcher has ended; returns the flight."""
        try:
            self.output, _ = self.process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            self.abandon()
            raise AssertionError(f"the run has not ended within {limit_s} s:\n{self.console[-3000:]}") from None
        self.seconds = time.monotonic() - self.began
        return self

    def abandon(self):
        """End the launcher if it is still running."""
        if self.process.poll() is None:
            self.process.kill()
            self.output, _ = self.process.communicate()
            for entry in self.leftovers():
                if not entry.startswith("process "):
                    os.unlink(entry)

    def transcript(self):
        """Everything that a user could read about the run, for assertion messages."""
        return f"exit code {self.code}\n{self.output}\n{self.console[-3000:]}"

    def port(self, limit_s=MOMENT_S):
        """The ground port, as soon as the run has written it."""
        path = self.directory / "ground.port"
        wait_until(lambda: path.exists() and path.read_text(encoding="ascii").strip(), "a ground port", limit_s)
        return int(path.read_text(encoding="ascii"))

    def steps(self):
        """Lines of the operator's log so far."""
        path = self.directory / "operator.log"
        return len(path.read_bytes().splitlines()) if path.exists() else 0

    def children(self):
        """Dictionary: program name -> process id of the launcher's children."""
        return {name: pid for pid, parent, name in processes() if parent == self.process.pid}

    def leftovers(self):
        """Processes, the operator's co-simulation port and shared memory of this run that still exist."""
        mark, directory = self.identity.encode(), str(self.directory).encode()
        found = [f"process {pid} {line.decode(errors='replace')}" for pid, line in command_lines() if _is_of(line, mark, directory)]
        found += [str(path) for path in pathlib.Path("/dev/shm").glob(f"*{self.identity}*") if _has_identity(path.name, self.identity)]
        return found


def _is_of(line, mark, directory):
    return re.search(re.escape(mark) + rb"(?![0-9])", line) is not None or directory in line.split(b" ")


def _has_identity(name, identity):
    return re.search(re.escape(identity) + r"(?![0-9])", name) is not None


def command_lines():
    """(process id, command line) of every process but this one."""
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            with contextlib.suppress(OSError):
                yield int(entry.name), (entry / "cmdline").read_bytes().replace(b"\0", b" ").strip()


def is_enabled(statusword):
    """True if a drive is in the state OPERATION ENABLED of CiA 402."""
    return statusword & 0x6F == 0x27


def processes():
    """(process id, parent, name of the program) of every process that is not a zombie."""
    for pid, line in command_lines():
        with contextlib.suppress(OSError, IndexError):
            status = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
            state, parent = status.rpartition(")")[2].split()[:2]
            words = line.decode(errors="replace").split(" ")
            name = "operator" if "script" in words else pathlib.Path(words[0]).name
            if state != "Z":
                yield pid, int(parent), name


def descendants(pid):
    """Process ids of the children of a process, of their children and of the children of those, by the name of the program."""
    found, parents = {}, {pid}
    for _ in range(3):
        for child, parent, name in processes():
            if parent in parents:
                found[name] = child
        parents |= set(found.values())
    return found


def wait_until(condition, awaited, limit_s=MOMENT_S):
    """Poll until the condition holds; `awaited` names it for the message of a failure: a text, or a function that returns it then."""
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {limit_s} s: {awaited() if callable(awaited) else awaited}")
        time.sleep(0.005)


def start(directory, *options, root=ROOT, binaries=None, environment=None, report="no"):
    """Start `hirosco run`; options as on the command line."""
    program = (binaries or root / "build" / "bin") / "hirosco"
    words = [str(program), "run", "--out", str(directory), "--report", report, *map(str, options)]
    process = subprocess.Popen(
        words,
        cwd=root,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        env={**os.environ, **(environment or {})},
    )
    return Flight(pathlib.Path(directory), process)


def fly(directory, *options, limit_s=FLIGHT_LIMIT_S, **how):
    """Start a run and wait for its end."""
    return start(directory, *options, **how).wait(limit_s)


def fly_in_both_forms(directory, name, path, *options):
    """Fly a scenario to its end in the image and in processes. Returns a dictionary: form -> Flight."""
    found = {}
    for form in ("image", "processes"):
        found[form] = fly(directory / f"{name}-{form}", "--scenario", path, "--form", form, *options)
        assert found[form].code == 0, found[form].transcript()
    return found


def refuse(*words, root=ROOT):
    """Call the launcher with options that it must refuse. Returns the finished process."""
    return subprocess.run(
        [root / "build" / "bin" / "hirosco", *map(str, words)],
        cwd=root,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=MOMENT_S,
    )


def gse_words(flight):
    """The command line of the ground segment for this flight. Without the dictionary it would be that of the flight in runs/latest, which
    may be of another mission."""
    return [sys.executable, str(ROOT / "gse" / "gse"), "--port", str(flight.port()), "--dictionary", str(run_directory.default_dictionary(flight.directory))]


def gse(flight, *words, timeout=FLIGHT_LIMIT_S):
    """Call the command line of the ground segment as a user does. Returns the finished process."""
    return subprocess.run(
        [*gse_words(flight), *map(str, words)],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout,
    )


def free_port():
    """A port without a listener, below those that systems give to clients, so that it stays free until it is used."""
    while True:
        with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", random.randrange(12000, 32000))) as listener:
            return listener.getsockname()[1]


def connect(port, limit_s=MOMENT_S):
    """Open a TCP connection to a ground port that is about to be opened."""
    end = time.monotonic() + limit_s
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=MOMENT_S)
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.01)


def assert_clean(flight):
    """Expect that soon after the end of the run no process, socket or shared memory of it is left."""
    with contextlib.suppress(AssertionError):
        wait_until(lambda: not flight.leftovers(), "the end of all processes and names of the run")
    left = flight.leftovers()
    for entry in left:
        if entry.startswith("process "):
            with contextlib.suppress(OSError):
                os.kill(int(entry.split(" ")[1]), signal.SIGKILL)
    assert not left, left


def descriptors_copied(directory):
    """Make a directory with a copy of the descriptors that otherwise refers to the project: the XML files may be
    changed, programs are those of the project."""
    directory.mkdir()
    shutil.copytree(ROOT / "descriptors", directory / "descriptors")
    for name in ("build", "sim", "gse"):
        (directory / name).symlink_to(ROOT / name)
    return directory


def replace(path, *changes):
    """Replace texts of a file, each given as (old, new); `old` must occur."""
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def write_scenario(path, *lines):
    """Write these lines to a scenario file. Returns its path."""
    path.write_text("# SPDX-License-Identifier: Apache-2.0\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def bring_up(at, configuration="TELEPRESENCE", tare=True):
    """Lines of the operator that take both members from OFFLINE to OPERATIONAL in telepresence, from `at` [s]
    on."""
    both = ("JOYSTICK", "MANIPULATOR")
    lines = [f"{at:.6f} operator state {name} PRE_OPERATIONAL" for name in both]
    lines += [f"{at:.6f} operator config {name} {configuration}" for name in both]
    if configuration == "TELEPRESENCE":
        lines += [f"{at:.6f} operator link open {link}" for link in ("HAND_POSITION", "ROBOT_STATE")]
    lines += [f"{at:.6f} operator state {name} SAFE_OPERATIONAL" for name in both]
    if tare:
        lines += [f"{at:.6f} operator cmd MANIPULATOR.TARE", f"{at:.6f} operator wait-event MANIPULATOR TARE_DONE 2"]
    return lines + [f"{at:.6f} operator state {name} OPERATIONAL" for name in both]
