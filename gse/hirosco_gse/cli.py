# SPDX-License-Identifier: Apache-2.0
"""The command `gse`.

Exit codes: 0 success, 1 rejected or failed (with the reason in words), 2 usage, 3 no link, 4 time-out.
"""

import argparse
import contextlib
import json
import os
import pathlib
import re
import signal
import sys
import time

from . import __version__, commands, gateway, link, sdls, telemetry
from .commands import UsageError
from .dictionary import STATES, Dictionary, DictionaryError
from .script import Script, ScriptError, ScriptFailure, link_entry
from .session import LinkLost, Session, SessionError, TimedOut

SUCCESS, FAILED, USAGE, NO_LINK, TIMED_OUT = range(5)
ROOT = pathlib.Path(__file__).resolve().parents[2]
LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 10015
DEFAULT_MISSION = "rokviss"
LISTEN_S = 2.0
PATIENCE_S = 10.0  # a script may be started together with the mission


def _default_port(run):
    try:
        return int((run / "ground.port").read_text(encoding="ascii"))
    except (OSError, ValueError):
        return DEFAULT_PORT


def _mission_of(run):
    """Name of the mission of a run, as the launcher wrote it; otherwise that of the default mission."""
    try:
        return (run / "ground.mission").read_text(encoding="utf-8").strip() or DEFAULT_MISSION
    except OSError:
        return DEFAULT_MISSION


def _default_key(run, host, port):
    """Key file of the connected run, as the launcher wrote it; for another run that of the environment. None: telecommands
    are not protected."""
    if host != LOOPBACK or not (run / "ground.port").exists() or port != _default_port(run):
        return os.environ.get("GSE_KEY")
    try:
        return (run / "ground.key-file").read_text(encoding="utf-8").strip() or None
    except OSError:
        return None


def _default_dictionary(run):
    return ROOT / "build" / "generated" / f"{_mission_of(run)}.json"


def _epilog():
    lines = ["commands:"]
    for _, usage, about in commands.VERBS.values():
        lines += [f"  {part.strip()}" for part in usage.split(", hk ")[:1]] + [f"        {about}"]
    lines += [
        "  hk [-f] [SUBSYSTEM]",
        "        show housekeeping reports as they arrive; -f continues until Ctrl-C",
        "  events [-f] [SUBSYSTEM]",
        "        show events and state transitions as they arrive; -f continues until Ctrl-C",
        "  permissions",
        "        permitted requests by mode and state (from the dictionary)",
        "  script FILE [--cosimulation PATH] [--run DIR]",
        "        fly the operator's lines of a scenario",
        "  key make FILE",
        "        make a key for authenticated telecommands, with its marks FILE.sent and FILE.received",
        "  gateway [--listen PORT]",
        "        accept packets from programs on this machine, such as Yamcs, protect them with the key and forward them",
        "",
        "exit codes: 0 success, 1 rejected or failed, 2 usage, 3 no link, 4 time-out",
    ]
    return "\n".join(lines)


def _parser():
    parser = argparse.ArgumentParser(
        prog="gse",
        description="Command a mission from the ground: telecommands over TCP, verification in words.",
        epilog=_epilog(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"gse {__version__}")
    parser.add_argument("--host", default=LOOPBACK, help="address of the ground port (default %(default)s)")
    parser.add_argument("--port", type=int, help=f"ground port (default: runs/latest/ground.port, else {DEFAULT_PORT})")
    parser.add_argument("--dictionary", help="mission dictionary (default: that of the run's mission)")
    parser.add_argument("--timeout", type=float, default=20.0, help="longest wait for a verification [s] (default 20)")
    parser.add_argument("--key", metavar="FILE", help="protect telecommands with this key (default: that of the run; for other runs $GSE_KEY)")
    parser.add_argument("--listen", type=int, metavar="PORT", help=f"gateway: port on this machine (default {gateway.PORT})")
    parser.add_argument("--json", action="store_true", help="one JSON object per line instead of text")
    parser.add_argument("-f", "--follow", action="store_true", help="hk, events: go on until Ctrl-C")
    parser.add_argument("--cosimulation", help="script: UNIX socket of the scheduler (stepped time)")
    parser.add_argument("--run", help="script: folder for operator.log (default: runs/latest, for reading only)")
    parser.add_argument("command", metavar="COMMAND", help="see below")
    parser.add_argument("words", metavar="WORD", nargs="*", help="arguments of the command")
    return parser


def _print(arguments, entry):
    text = json.dumps(entry, default=str) if arguments.json else entry["text"]
    print(text, flush=True)


def _report(line):
    print(line, flush=True)


class _Console:
    """One call of the command line."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.run = pathlib.Path(arguments.run) if arguments.run else ROOT / "runs" / "latest"
        self.port = arguments.port or _default_port(self.run)
        self.key = arguments.key or _default_key(self.run, arguments.host, self.port)
        self.dictionary = Dictionary.load(arguments.dictionary or _default_dictionary(self.run))
        self.sender = None

    def connect(self, first_sequence=None, patience_s=0.0):
        """(stream, session) of a new connection."""
        self.sender = sdls.Sender(self.key) if self.key else None
        stream = link.connect(self.arguments.host, self.port, patience_s)
        return stream, Session(self.dictionary, first_sequence, protect=self.sender or bytes)

    def reconnect(self):
        """The next connection of the same session."""
        if self.sender:
            self.sender.begin_anew()
        return link.connect(self.arguments.host, self.port)

    def gateway(self):
        """Serve until Ctrl-C."""
        if self.arguments.words:
            raise UsageError("usage: gateway [--listen PORT] [--key FILE]")
        if not self.key:
            raise UsageError("gateway: telecommands of this run need no key; connect to its ground port, or give --key FILE")
        sdls.read_key(self.key)
        gateway.serve(self.arguments.listen or gateway.PORT, (self.arguments.host, self.port), lambda: sdls.Sender(self.key), _report)
        return SUCCESS

    def command(self):
        """Plan first: a usage error needs no link."""
        command = commands.plan([self.arguments.command, *self.arguments.words], self.dictionary)
        stream, session = self.connect()
        driver = link.RealDriver(stream, session)
        with stream:
            for entry in driver.run(command.procedure(session, int(self.arguments.timeout * 1e9))):
                _print(self.arguments, entry)
        for problem in session.mismatches.values():
            print(f"gse: warning: {problem}", file=sys.stderr)
        return SUCCESS

    def listen(self, wanted):
        """Print reports as they arrive."""
        if len(self.arguments.words) > 1:
            raise UsageError(f"usage: {self.arguments.command} [-f] [SUBSYSTEM]")
        only = self.dictionary.subsystem(self.arguments.words[0]).apid if self.arguments.words else None
        stream, session = self.connect()
        epoch_ns = self.dictionary.epoch_ns

        def show(packet, decoded):
            if wanted(packet) and only in (None, packet.apid):
                seconds = (packet.time_ns - epoch_ns) / 1e9
                text = f"{seconds:12.6f}  {telemetry.describe(packet, decoded, self.dictionary)}"
                subsystem = self.dictionary.name_of_apid(packet.apid)
                _print(self.arguments, {"text": text, "time": seconds, "subsystem": subsystem, **decoded})

        session.listeners.append(show)
        driver = link.RealDriver(stream, session)
        end = time.monotonic() + LISTEN_S
        with stream:
            while self.arguments.follow or time.monotonic() < end:
                driver.run(session.wait_until(session.now_ns + 100_000_000))
        return SUCCESS

    def permissions(self):
        """The matrix of the mission descriptor."""
        for rule in self.dictionary.permissions:
            request = f"TC[{rule['service']},{rule['subtype']}]"
            states = "any state" if len(rule["states"]) == len(STATES) else " ".join(rule["states"])
            text = f"{request:<9} {rule['select']:<17} to {rule['to']:<14} {' '.join(rule['modes']):<13} {states}"
            _print(self.arguments, {"text": text, **rule})
        return SUCCESS

    def script(self):
        """Fly a scenario."""
        if len(self.arguments.words) != 1:
            raise UsageError("usage: script FILE [--cosimulation PATH] [--run DIR]")
        script = Script.load(self.arguments.words[0], self.dictionary)
        if not script.steps:
            print(f"{self.arguments.words[0]}: no line for the operator")
            return SUCCESS
        with contextlib.ExitStack() as stack:
            log = None
            if self.arguments.run:
                path = pathlib.Path(self.arguments.run) / "operator.log"
                log = stack.enter_context(path.open("wb", buffering=0))
            return self._fly(script, log)

    def _fly(self, script, log):
        stream, session = self.connect(first_sequence=0, patience_s=PATIENCE_S)

        def tell(entry):
            nonlocal log
            _try_to_say(json.dumps(entry, default=str) if self.arguments.json else entry["text"])
            if log and not _append(log, json.dumps(entry, default=str) + "\n"):
                log = None

        with stream:
            if self.arguments.cosimulation:
                local_port = stream.getsockname()[1]
                clock = link.StepClock(self.arguments.cosimulation, local_port, patience_s=PATIENCE_S)
                driver = link.StepDriver(stream, session, clock, self.reconnect, lambda text: tell(link_entry(session, text)))
            else:
                clock = None
                driver = link.RealDriver(stream, session, self.dictionary.epoch_ns)
            if self.arguments.run:  # The launcher, which ends the run, waits for the end of this process, the interpreter's included.
                signal.signal(signal.SIGTERM, signal.SIG_IGN)
            try:
                driver.run(script.procedure(session, int(self.arguments.timeout * 1e9), tell))
            finally:
                if clock:
                    clock.leave()
        return SUCCESS


def _append(log, text):
    """Append a line to the operator's log. False: the disk accepts no more; that is reported, and the mission continues."""
    whole, rest = log.tell(), text.encode()
    try:
        while rest:
            rest = rest[log.write(rest) :]
    except OSError as error:
        with contextlib.suppress(OSError):
            os.ftruncate(log.fileno(), whole)
        _try_to_say(f"gse: {log.name}: {error.strerror}; later steps are not in it")
        return False
    return True


def _try_to_say(text):
    """Print to the console, which may be redirected to a full disk."""
    try:
        print(text, flush=True)
    except OSError:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # Its buffered text would fail again at exit.


def _is_event(packet):
    return packet.service == 5 and packet.subtype <= 4 or packet.message in ((129, 2), (131, 2), (131, 4), (130, 10))


def _key(words):
    """Commands about keys."""
    if len(words) != 2 or words[0] != "make":
        raise UsageError("usage: key make FILE")
    sdls.make_key(words[1])
    print(f"{words[1]}: made, with its marks .sent (ground) and .received (spacecraft); keep all three together")
    return SUCCESS


def _run(arguments):
    if arguments.command == "key":
        return _key(arguments.words)
    console = _Console(arguments)
    special = {
        "script": console.script,
        "permissions": console.permissions,
        "gateway": console.gateway,
        "events": lambda: console.listen(_is_event),
    }
    if arguments.command in special:
        return special[arguments.command]()
    if arguments.command == "hk" and len(arguments.words) < 2:
        return console.listen(lambda packet: packet.message == (3, 25))
    return console.command()


def _words(argv):
    """Values such as -0.5,0.3 are words, not options: a leading blank makes argparse accept them."""
    return [" " + word if re.match(r"-[\d.]", word) else word for word in argv]


def main(argv=None):
    """Entry point; returns the exit code."""
    parser = _parser()
    try:
        arguments = parser.parse_intermixed_args(_words(sys.argv[1:] if argv is None else argv))
        return _run(arguments)
    except SystemExit as end:  # argparse: 0 after --help, 2 after a usage error
        return end.code if isinstance(end.code, int) else USAGE
    except (UsageError, DictionaryError, ScriptError, sdls.SecurityError) as problem:
        print(f"gse: {problem}", file=sys.stderr)
        return USAGE
    except LinkLost as problem:
        print(f"gse: {problem}", file=sys.stderr)
        return NO_LINK
    except TimedOut as problem:
        print(f"gse: time-out: {problem}", file=sys.stderr)
        return TIMED_OUT
    except (SessionError, ScriptFailure) as problem:
        print(f"gse: {problem}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return SUCCESS
    except BrokenPipeError:
        sys.stderr.close()
        return SUCCESS
    except OSError as problem:
        print(f"gse: {problem}", file=sys.stderr)
        return USAGE
