# SPDX-License-Identifier: Apache-2.0
"""`make gse`: the light ground station beside a flight; starts a flight in real time if none is running."""

from .. import interrupt

if __name__ == "__main__":
    interrupt.hold()

import argparse
import contextlib
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys

from ..files import next_step
from ..run_directory import LOOPBACK, ROOT, facts_of, is_under_way, problem_of
from ..values import TEXT_MAX, quoted, shortened, with_short_words

PORT = 8090  # First port that is tried for the page.
PORTS = 20  # Number of ports that are tried.
FRAMED_BY = "http://127.0.0.1:8080"
END_S = 30.0  # Time in which a flight must end after Ctrl-C; then the station sends Ctrl-C again. The third one ends a flight at once.
ENDS = 4  # A flight that has not ended after this number of Ctrl-C is killed; its guard removes what is left.


class _Parser(argparse.ArgumentParser):
    """Parser whose error messages shorten the words of the user that they quote."""

    def error(self, message):
        super().error(shortened(message, TEXT_MAX))


def _parser():
    parser = _Parser(prog="station", description="The light ground station: a web page beside a flight.")
    parser.add_argument("--run", type=pathlib.Path, default=ROOT / "runs" / "latest", help="run directory (default runs/latest)")
    parser.add_argument("--http-port", type=http_port, help=f"port of the page (default: the first free from {PORT})")
    parser.add_argument("--page", type=pathlib.Path, default=ROOT / "build" / "station" / "page", help="the built page")
    parser.add_argument("--replay", type=pathlib.Path, help="replay the run of this directory, or this recording of a run; no flight is started or followed")
    parser.add_argument("--read-only", action="store_true", help="pages cannot send telecommands, move the hand, cause faults or change the pace")
    parser.add_argument("--framed-by", type=_origin, default=FRAMED_BY, metavar="ORIGIN",
                        help=f"page of this machine that may show the page of the station in a frame, or none (default {FRAMED_BY}, the page of make yamcs)")
    parser.add_argument("--fly", nargs=argparse.REMAINDER, help="start this command if no flight answers")
    return parser


def http_port(text):
    """A port of the page; 0: any free one."""
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"found {quoted(text)}, expected a port from 0 to 65535")
    return int(text)


def _origin(text):
    """A value of frame-ancestors: an origin on this machine, or 'none'."""
    if text == "none":
        return "'none'"
    if not re.fullmatch(r"http://(127\.0\.0\.1|localhost):\d{1,5}", text):
        raise argparse.ArgumentTypeError(f"found {quoted(text)}, expected none or a page of this machine such as {FRAMED_BY}")
    return text


def _listen(wanted):
    """Listening socket on this machine."""
    for port in [wanted] if wanted is not None else range(PORT, PORT + PORTS):
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((LOOPBACK, port))
            listener.listen()  # A page that is opened as soon as the address is printed is served.
            return listener
        except OSError as error:
            listener.close()
            problem = error.strerror
    if wanted is not None:
        raise SystemExit(f"station: port {wanted} of this machine: {problem}; is another station there? Give another port with HTTP= or --http-port")
    raise SystemExit(f"station: no free port for the page from {PORT} to {PORT + PORTS - 1}: {problem}; give one with HTTP= or --http-port")


def _check(arguments):
    """Raise SystemExit if there is nothing to show."""
    if arguments.replay and arguments.replay.is_dir() and (problem := problem_of(arguments.replay)):
        raise SystemExit(f"station: {problem}")
    if not (arguments.page / "index.html").exists():
        raise SystemExit(f"station: {arguments.page} has no page; run make gse")
    if arguments.replay and not arguments.replay.exists():
        raise SystemExit(f"station: there is no run directory {arguments.replay}, and no recording of a run")
    problem = facts_of(arguments.replay)[1] if arguments.replay and arguments.replay.is_dir() else None
    if problem:
        print(f"station: warning: {arguments.replay}: {problem}; the page shows the logs without these facts", file=sys.stderr, flush=True)


def _end(flight):
    """End a flight as Ctrl-C at its terminal does, and wait for its end. Each further Ctrl-C is passed on."""
    for _ in range(ENDS):
        if flight.poll() is not None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.kill(flight.pid, signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired, KeyboardInterrupt):
            flight.wait(END_S)
    if flight.poll() is None:
        flight.kill()
        flight.wait()


def _interrupt(_number, _frame):
    raise KeyboardInterrupt


def _load():
    """The modules whose loading takes longest, aiohttp.web and .server: a flight begins meanwhile. Ctrl-C waits."""
    interrupt.hold()
    try:
        from aiohttp import web

        from . import server
    finally:
        interrupt.release()
    return web, server


def _serve(arguments, listener):
    """Serve until Ctrl-C, with the flight that is started, if there is none."""
    host = f"{LOOPBACK}:{listener.getsockname()[1]}"
    flight = None
    try:
        if arguments.fly and not arguments.replay and not is_under_way(arguments.run):
            flight = subprocess.Popen(arguments.fly, start_new_session=True)
        web, server = _load()
        print(f"The ground station is at http://{host}/ (Ctrl-C ends it{' and its flight' if flight else ''}).", flush=True)
        station = server.Station(arguments.run, arguments.page, arguments.replay, arguments.read_only, arguments.framed_by)
        web.run_app(station.application(host), sock=listener, print=None, shutdown_timeout=2 * server.CLOSE_S)
    finally:
        if flight:
            _end(flight)


def main(argv=None):
    """Serve until Ctrl-C. The end of its terminal and a request to end have the same effect."""
    arguments = _parser().parse_args(argv)
    try:
        interrupt.release()
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, _interrupt)
        _check(arguments)
        _serve(arguments, _listen(arguments.http_port))
    except KeyboardInterrupt:
        print("station: ended by Ctrl-C", file=sys.stderr)
        return 128 + signal.SIGINT
    except OSError as problem:
        words = f"station: {problem.filename or arguments.run}: {problem.strerror}{next_step(problem)}"
        raise SystemExit(with_short_words(words)) from problem
    return 0


if __name__ == "__main__":
    sys.exit(main())
