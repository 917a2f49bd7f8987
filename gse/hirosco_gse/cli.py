# SPDX-License-Identifier: Apache-2.0
"""The command `gse`.

Exit codes: 0 success, 1 rejected or failed (with the reason in words), 2 usage, 3 no link, 4 time-out, 130 Ctrl-C before the result of a
command is known.
"""

import argparse
import contextlib
import io
import math
import os
import pathlib
import re
import signal
import sys

from . import __version__, commands, completion, decode, frames, gateway, interrupt, link, live, packet_log, pcap, sdls, telemetry, usage, values, visits
from .colours import coloured
from .commands import UsageError
from .dictionary import STATES, Dictionary, DictionaryError
from .files import next_step
from .run_directory import DEFAULT_PORT, LATEST, LOOPBACK, ROOT, FACTS, FactMissing, Place, fact, facts_of
from .script import Script, ScriptError, ScriptFailure, link_entry
from .session import LinkLost, SessionError, TimedOut
from .shell import Shell
from .spacecraft import Spacecraft

SUCCESS, FAILED, USAGE, NO_LINK, TIMED_OUT = range(5)
INTERRUPTED = 128 + signal.SIGINT
EXIT_CODES = "exit codes: 0 success, 1 rejected or failed, 2 usage, 3 no link, 4 time-out, 130 Ctrl-C before the result"
LISTEN_S = 2.0  # Time for which `hk` and `events` receive reports without -f.
LONGEST_S = 1e9  # Longest time-out.
CONNECT_TIMEOUT_S = 10.0  # a script may be started together with the mission
NEGATIVE = re.compile(r"-[\d.]")  # Beginning of a negative number, which is not an option.
WITHOUT_END = ("hk", "events", "gateway", "monitor", "replay", "shell")  # Ctrl-C ends them without an error.


class OutputLost(Exception):
    """The standard output cannot be written, for example because its disk is full."""


def _given(text):
    """A word of an option. An empty one, such as an unset variable of a shell, must not stand for the default."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"found {values.quoted(text)}, expected a word")
    return text


def _port(text):
    if not text.strip().isdecimal() or not 1 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"found {values.quoted(text)}, expected a port from 1 to 65535")
    return int(text)


def _page_port(text):
    return 0 if text.strip() == "0" else _port(text)


def _seconds(text):
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds <= LONGEST_S:
        raise argparse.ArgumentTypeError(f"found {values.quoted(text)}, expected seconds, more than 0 and at most {LONGEST_S:.0f}")
    return seconds


class _Parser(argparse.ArgumentParser):
    """Parser whose error messages shorten the words of the user that they quote."""

    def error(self, message):
        super().error(values.shortened(message, values.TEXT_MAX))


def _parser():
    parser = _Parser(
        prog="gse",
        description="Command a mission from the ground: telecommands over TCP, verification in words.",
        epilog=f"{usage.overview()}\n\ngse COMMAND --help: one command, with an example\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"gse {__version__}")
    parser.add_argument("--host", type=_given, default=LOOPBACK, help="address of the ground port (default %(default)s)")
    parser.add_argument("--port", type=_port, help=f"ground port (default: runs/latest/ground.port, else {DEFAULT_PORT})")
    parser.add_argument("--dictionary", type=_given, help="mission dictionary (default: that of the run's mission)")
    parser.add_argument("--timeout", type=_seconds, default=20.0, help="longest wait for a verification [s] (default 20)")
    parser.add_argument("--key", type=_given, metavar="FILE", help="protect telecommands with this key (default: that of the run; for other runs $GSE_KEY)")
    parser.add_argument("--listen", type=_port, metavar="PORT", help=f"gateway: port on this machine (default {gateway.PORT})")
    parser.add_argument("--http-port", type=_page_port, metavar="PORT", help="replay: port of the page (default: the first free one)")
    parser.add_argument("--json", action="store_true", help="one JSON object per line instead of text")
    parser.add_argument("-f", "--follow", action="store_true", help="hk, events: continue until Ctrl-C")
    parser.add_argument("--cosimulation", type=_given, help="script: UNIX socket of the scheduler (stepped time)")
    parser.add_argument("--run", type=_given, help="run directory (default: runs/latest); script writes operator.log only to a directory that is given")
    parser.add_argument("command", metavar="COMMAND", nargs="?", help="see below")
    parser.add_argument("words", metavar="WORD", nargs="*", help="arguments of the command")
    return parser


def _print(arguments, entry, meaning=None):
    _print_line(values.json_of(values.in_words(entry)) if arguments.json else coloured(entry["text"], meaning))


def _print_error(text, meaning="failed"):
    text = values.with_short_words(text)
    try:
        print(coloured(f"gse: {text}", meaning, sys.stderr), file=sys.stderr, flush=True)
    except OSError:  # The caller still returns its exit code.
        sys.stderr = open(os.devnull, "w", encoding="utf-8")


def _print_line(text, end="\n"):
    """Print to the standard output. Raises OutputLost, BrokenPipeError."""
    try:
        print(text, end=end, flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputLost(f"cannot write the output: {error.strerror}; the rest of the output is lost") from error


class _Console:
    """One call of the command line."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.run = pathlib.Path(arguments.run or LATEST)
        self._warned = set()

    def spacecraft(self, **options):
        """Client for the flight that the options name; it is not connected yet."""
        given = self.arguments
        return Spacecraft(
            self.run, host=given.host, port=given.port, key=given.key, dictionary=given.dictionary, timeout_s=given.timeout, **options
        )

    def gateway(self):
        """Serve until Ctrl-C."""
        if self.arguments.words:
            raise UsageError("usage: gateway [--listen PORT] [--key FILE]")
        place = Place.of(self.run, self.arguments.host, self.arguments.port, self.arguments.key)
        place.check()
        if not place.key:
            raise UsageError("gateway: telecommands of this run need no key; connect to its ground port, or give --key FILE")
        sdls.read_key(place.key)
        gateway.serve(self.arguments.listen or gateway.PORT, (place.host, place.port), lambda: sdls.Sender(place.key), _print_line)
        return SUCCESS

    def command(self):
        """Perform one command. It is planned before the connection, so that a usage error is reported without a link."""
        craft = self.spacecraft()
        words = [self.arguments.command, *self.arguments.words]
        commands.plan(words, craft.dictionary)
        try:
            with craft:
                for entry in craft.do(*words):
                    _print(self.arguments, entry)
        except KeyboardInterrupt:
            _print_error(f"{' '.join(words)}: the wait was ended; the spacecraft may still perform the command")
            return INTERRUPTED
        self._warn(craft)
        return SUCCESS

    def _warn(self, craft):
        """Warn once of each interface in flight that differs from that of the dictionary."""
        for problem in craft.session.mismatches.values():
            if problem not in self._warned:
                self._warned.add(problem)
                _print_error(f"warning: {problem}", "warning")

    def listen(self, wanted):
        """Print reports as they arrive."""
        if len(self.arguments.words) > 1:
            raise UsageError(f"usage: {self.arguments.command} [-f] [SUBSYSTEM]")
        craft = self.spacecraft()
        dictionary = craft.dictionary
        only = dictionary.subsystem(self.arguments.words[0]).apid if self.arguments.words else None

        def show(packet, decoded):
            self._warn(craft)
            if wanted(packet) and only in (None, packet.apid):
                seconds = (packet.time_ns - dictionary.epoch_ns) / 1e9
                text = f"{seconds:12.6f}  {telemetry.describe(packet, decoded, dictionary)}"
                _print(self.arguments, {"text": text, "time": seconds, "subsystem": dictionary.name_of_apid(packet.apid), **decoded}, decoded.get("severity"))

        craft.session.listeners.append(show)
        with craft:
            craft.listen(math.inf if self.arguments.follow else LISTEN_S)
        return SUCCESS

    def shell(self):
        """Commands at a prompt."""
        if self.arguments.words:
            raise UsageError("usage: shell")
        if isinstance(sys.stdin, io.TextIOWrapper):
            sys.stdin.reconfigure(errors="backslashreplace")  # Octets that are no text are refused as words, and do not end the shell.
        with self.spacecraft() as craft:
            Shell(craft).run()
        return SUCCESS

    def monitor(self):
        """The live view in the terminal."""
        if not sys.stdout.isatty():
            raise UsageError("monitor: found no terminal, expected one; `hk -f` and `events -f` write to files")
        try:
            from .monitor import Monitor
        except ImportError as error:
            python = ROOT / "build" / "venv" / "bin" / "python"
            if sys.executable == str(python) or not python.exists():
                raise UsageError(f"monitor: {error}; run make, then build/venv/bin/gse monitor") from error
            os.execv(python, [str(python), "-m", "hirosco_gse", *sys.argv[1:]])
        given = self.arguments
        end = Monitor(self.run, host=given.host, port=given.port, key=given.key, dictionary=given.dictionary).run()
        if end is None:  # The user has left it.
            return SUCCESS
        words, code = end
        _print_error(words, "failed" if code else "ok")
        return NO_LINK if code is None else FAILED if code else SUCCESS

    def permissions(self):
        """Print the permitted requests of the mission descriptor."""
        if self.arguments.words:
            raise UsageError("usage: permissions")
        rules = self.spacecraft().dictionary.permissions
        rows = [(f"TC[{rule['service']},{rule['subtype']}]", rule["select"], f"to {rule['to']}", " ".join(rule["modes"]),
                 "any state" if len(rule["states"]) == len(STATES) else " ".join(rule["states"])) for rule in rules]
        widths = [max(map(len, column)) for column in zip(*rows)]
        for rule, row in zip(rules, rows):
            text = "  ".join(f"{word:<{width}}" for word, width in zip(row, widths)).rstrip()
            _print(self.arguments, {"text": text, **rule})
        return SUCCESS

    def live(self):
        """Send one line to the live port of the run."""
        line = " ".join([self.arguments.command, *self.arguments.words])
        with live.LiveWorld(self.run) as world:
            seconds, is_paused = world.ask(line)
        text = f"{line}: at {seconds:.4f} s{', paused' if is_paused else ''}"
        _print(self.arguments, {"text": text, "time": seconds, "line": line, "paused": is_paused})
        return SUCCESS

    def decode(self):
        """Print recorded octets in words."""
        if not self.arguments.words:
            raise UsageError("usage: decode FILE|-|HEX ...")
        place = Place.of(self.run, dictionary=self.arguments.dictionary, port=self.arguments.port)
        for row in decode.rows(self.arguments.words, Dictionary.load(place.dictionary), place.dictionary.parent, place.port):
            _print(self.arguments, row, "failed" if "error" in row else row.get("content", {}).get("severity"))
        return SUCCESS

    def record(self):
        """Print the scenario that repeats a flight."""
        if len(self.arguments.words) > 1:
            raise UsageError("usage: record [RUN]")
        run = pathlib.Path(self.arguments.words[0]) if self.arguments.words else self.run
        facts, problem = facts_of(run)
        if problem or not (run / FACTS).exists():
            raise UsageError(f"{run}: {problem or 'found no run.json, expected the directory of a flight that has ended'}")
        name = fact(facts, "scenario", run)
        known = ROOT / "sim" / "scenarios" / f"{name}.scn"
        _print_line(live.recording(run, None if name == "none" else known if known.exists() else name), end="")
        return SUCCESS

    def replay(self):
        """Serve a run on the page of the station."""
        if len(self.arguments.words) > 1:
            raise UsageError("usage: replay [RUN] [--http-port PORT]")
        from .station import __main__ as station

        options = ["--replay", str(self.arguments.words[0] if self.arguments.words else self.run)]
        if self.arguments.http_port is not None:
            options += ["--http-port", str(self.arguments.http_port)]
        try:
            return station.main(options)
        except ImportError as error:  # The station needs packages.
            raise UsageError(f"replay: {error}; after make setup call build/venv/bin/gse replay") from error
        except SystemExit as end:
            raise UsageError(end.code) from end

    def pcap(self):
        """Write the packets of a run as a capture."""
        if len(self.arguments.words) > 1:
            raise UsageError("usage: pcap [RUN]")
        path, count = pcap.write(self.arguments.words[0] if self.arguments.words else self.run)
        _print(self.arguments, {"text": f"{path}: {count} packets", "path": str(path), "packets": count})
        return SUCCESS

    def mcap(self):
        """Write a run as an MCAP file."""
        if len(self.arguments.words) > 1:
            raise UsageError("usage: mcap [RUN]")
        try:
            from . import mcap_export  # Needs packages, which no other command needs.
        except ImportError as error:
            raise UsageError(f"mcap: {error}; after make setup call build/venv/bin/gse mcap") from error
        try:
            path, count, problems = mcap_export.write(self.arguments.words[0] if self.arguments.words else self.run)
        except mcap_export.ExportError as error:
            raise UsageError(str(error)) from error
        for problem in problems:
            _print_error(f"warning: {problem}", "warning")
        _print(self.arguments, {"text": f"{path}: {count} messages", "path": str(path), "messages": count, "problems": problems})
        return SUCCESS

    def script(self):
        """Perform the operator's lines of a scenario."""
        if len(self.arguments.words) != 1:
            raise UsageError("usage: script FILE [--cosimulation PATH] [--run DIRECTORY]")
        craft = self.spacecraft(first_sequence=0)
        script = Script.load(self.arguments.words[0], craft.dictionary)
        if not script.steps and not script.visits:
            _print_line(f"{self.arguments.words[0]}: no line for the operator")
            return SUCCESS
        if self.arguments.cosimulation and not script.steps:
            return self._attend(craft.place, script)
        with contextlib.ExitStack() as stack:
            log = None
            if self.arguments.run:
                path = pathlib.Path(self.arguments.run) / "operator.log"
                path.write_bytes(b"")
                log = stack.enter_context(path.open("ab", buffering=0))  # The simulator appends lines, too.
            return self._fly(craft, script, log)

    def _attend(self, place, script):
        """Repeat what other users did in a flight without an operator. This makes no connection of an operator, which would change the packet
        log."""
        clock = link.StepClock(self.arguments.cosimulation, 0, timeout_s=CONNECT_TIMEOUT_S)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # As in a flight with an operator.
        others = visits.Visits(script.visits, lambda: link.connect(place.host, place.port))
        try:
            link.attend(clock, others)
        finally:
            clock.leave()
            others.close()
        return SUCCESS

    def _fly(self, craft, script, log):
        def record(entry):
            nonlocal log
            _print_if_possible(values.json_of(values.in_words(entry)) if self.arguments.json else entry["text"])
            if log and not _append(log, values.json_of(values.in_words(entry)) + "\n"):
                log = None

        clock = None
        with craft.connect(CONNECT_TIMEOUT_S):
            if self.arguments.cosimulation:
                others = visits.Visits(script.visits, lambda: link.connect(craft.place.host, craft.place.port))
                clock = craft.join(self.arguments.cosimulation, lambda text: record(link_entry(craft.session, text)), others, CONNECT_TIMEOUT_S)
            if self.arguments.run:  # Ignore SIGTERM of the launcher, which waits until the interpreter has ended.
                signal.signal(signal.SIGTERM, signal.SIG_IGN)
            try:
                craft.run(script.procedure(craft.session, int(self.arguments.timeout * 1e9), record))
            finally:
                self._warn(craft)
                if clock:
                    clock.leave()
        return SUCCESS


def _append(log, text):
    """Append a line to the operator's log. If the disk is full, report this and return False; the mission continues."""
    whole, rest = os.fstat(log.fileno()).st_size, text.encode()
    try:
        while rest:
            rest = rest[log.write(rest) :]
    except OSError as error:
        with contextlib.suppress(OSError):
            os.ftruncate(log.fileno(), whole)
        _print_if_possible(f"gse: {log.name}: {error.strerror}; later steps are not in it")
        return False
    return True


def _print_if_possible(text):
    """Print to the console, which may be redirected to a full disk."""
    try:
        print(text, flush=True)
    except OSError:
        _give_up_output()


def _give_up_output():
    """Discard all further output. Otherwise Python would try to write the buffered text again at exit, and change the exit code."""
    sys.stdout = open(os.devnull, "w", encoding="utf-8")


def _is_event(packet):
    return packet.service == 5 and packet.subtype <= 4 or packet.message in ((129, 2), (131, 2), (131, 4), (130, 10))


def _key(words):
    """Commands about keys."""
    if len(words) != 2 or words[0] != "make":
        raise UsageError("usage: key make FILE")
    sdls.make_key(words[1])
    _print_line(f"{words[1]}: made, with its marks .sent (ground) and .received (spacecraft); keep all three together")
    return SUCCESS


def _completion(words):
    """Print the completion for a shell."""
    scripts = {"bash": completion.BASH, "zsh": completion.ZSH}
    if len(words) != 1 or words[0] not in scripts:
        raise UsageError("usage: completion bash|zsh")
    _print_line(scripts[words[0]], end="")
    return SUCCESS


def _complete(words):
    """Print the candidates for the last word; a shell calls this at each Tab."""

    def load(options):
        place = Place.of(options.get("--run"), dictionary=options.get("--dictionary"))
        return Dictionary.load(place.dictionary)

    _print_line("\n".join(completion.complete(words, load)))
    return SUCCESS


def _run(arguments):
    if arguments.command is None:
        raise UsageError("no command; gse --help lists them")
    if arguments.command == "key":
        return _key(arguments.words)
    if arguments.command == "completion":
        return _completion(arguments.words)
    console = _Console(arguments)
    special = {
        "script": console.script,
        "permissions": console.permissions,
        "shell": console.shell,
        "gateway": console.gateway,
        "record": console.record,
        "replay": console.replay,
        "decode": console.decode,
        "pcap": console.pcap,
        "mcap": console.mcap,
        **dict.fromkeys(live.VERBS, console.live),
        "events": lambda: console.listen(_is_event),
    }
    if arguments.command in special:
        return special[arguments.command]()
    if arguments.command == "monitor" and not arguments.words:
        return console.monitor()
    if arguments.command == "hk" and len(arguments.words) < 2:
        return console.listen(lambda packet: packet.message == (3, 25))
    if arguments.command not in commands.VERBS:
        raise UsageError(f"no command {values.quoted(arguments.command)}; gse --help lists them")
    return console.command()


def _words(argv):
    """Make argparse accept values such as -0.5,0.3 as words, not as options: put a blank before them."""
    return [" " + word if NEGATIVE.match(word) else word for word in argv]


def _parsed(argv):
    """The arguments, with the words as they were given."""
    arguments = _parser().parse_intermixed_args(_words(argv))
    arguments.words = [word[1:] if word[:1] == " " and NEGATIVE.match(word[1:]) else word for word in arguments.words]
    return arguments


_PROBLEMS = {  # Exit code of each kind of exception. The first kind that matches applies.
    UsageError: USAGE,
    DictionaryError: USAGE,
    ScriptError: USAGE,
    visits.VisitError: USAGE,
    sdls.SecurityError: USAGE,
    packet_log.LogError: USAGE,
    FactMissing: USAGE,
    LinkLost: NO_LINK,
    TimedOut: TIMED_OUT,
    SessionError: FAILED,
    ScriptFailure: FAILED,
    decode.DecodeError: FAILED,
    frames.DatabaseError: FAILED,
    OutputLost: FAILED,
    OSError: USAGE,
}


def _words_of(problem):
    if isinstance(problem, OSError) and problem.strerror:
        return f"{f'{problem.filename}: ' if problem.filename else ''}{problem.strerror}{next_step(problem)}"
    return f"time-out: {problem}" if isinstance(problem, TimedOut) else str(problem)


def _performed(arguments):
    """Perform the command. Returns the exit code."""
    try:
        return _run(arguments)
    except KeyboardInterrupt:
        if arguments.command in WITHOUT_END:
            return SUCCESS
        _print_error(f"{arguments.command}: ended by Ctrl-C before its result")
        return INTERRUPTED


def _flushed(code):
    """Write the text that argparse has printed. Returns the exit code, which differs from `code` if the text cannot be written."""
    try:
        _print_line("", end="")
    except OutputLost as problem:
        _give_up_output()
        _print_error(problem)
        return FAILED
    except BrokenPipeError:
        _give_up_output()
    return code


def _permit_all_names():
    """Print characters that the locale does not have as escapes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def main(argv=None):
    """Entry point; returns the exit code."""
    argv = sys.argv[1:] if argv is None else argv
    _permit_all_names()
    try:
        interrupt.release()
        if argv[:2] == ["complete", "--"]:
            return _complete(argv[2:])
        asked = [word for word in argv if word in usage.table()]
        if asked and {"-h", "--help"} & set(argv):
            _print_line(usage.help_of(asked[0]))
            return SUCCESS
        return _performed(_parsed(argv))
    except SystemExit as end:  # argparse: 0 after --help, 2 after a usage error
        return _flushed(end.code) if isinstance(end.code, int) else USAGE
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _give_up_output()
        return SUCCESS
    except tuple(_PROBLEMS) as problem:
        if isinstance(problem, OutputLost):
            _give_up_output()
        _print_error(_words_of(problem))
        return next(code for kind, code in _PROBLEMS.items() if isinstance(problem, kind))
