# SPDX-License-Identifier: Apache-2.0
"""`make gse`: the light ground station beside a flight; starts a flight by the wall clock if none is running."""

import argparse
import contextlib
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys

from aiohttp import web

from ..place import LOOPBACK, ROOT, default_port, problem_of
from .server import Station

PORT = 8090  # First port that is tried for the page.
PORTS = 20  # Number of ports that are tried.
FRAMED_BY = "http://127.0.0.1:8080"


def _parser():
    parser = argparse.ArgumentParser(prog="station", description="The light ground station: a web page beside a flight.")
    parser.add_argument("--run", type=pathlib.Path, default=ROOT / "runs" / "latest", help="run folder (default runs/latest)")
    parser.add_argument("--http-port", type=http_port, help=f"port of the page (default: the first free from {PORT})")
    parser.add_argument("--page", type=pathlib.Path, default=ROOT / "build" / "station" / "page", help="the built page")
    parser.add_argument("--replay", type=pathlib.Path, help="replay the run of this folder, or this recording of a run; no flight is started or followed")
    parser.add_argument("--read-only", action="store_true", help="pages cannot send telecommands, move the hand, cause faults or change the pace")
    parser.add_argument("--framed-by", type=_origin, default=FRAMED_BY, metavar="ORIGIN",
                        help=f"page of this machine that may show the page of the station in a frame, or none (default {FRAMED_BY}, the page of make yamcs)")
    parser.add_argument("--fly", nargs=argparse.REMAINDER, help="start this command if no flight answers")
    return parser


def http_port(text):
    """A port of the page; 0: any free one."""
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"found '{text}', expected a port from 0 to 65535")
    return int(text)


def _origin(text):
    """A value of frame-ancestors: an origin on this machine, or 'none'."""
    if text == "none":
        return "'none'"
    if not re.fullmatch(r"http://(127\.0\.0\.1|localhost):\d{1,5}", text):
        raise argparse.ArgumentTypeError(f"found '{text}', expected none or a page of this machine such as {FRAMED_BY}")
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


def _is_flying(run):
    if (run / "run.json").exists() or not (run / "ground.port").exists():  # It has ended: another flight may use its port now.
        return False
    with contextlib.suppress(OSError), socket.create_connection((LOOPBACK, default_port(run.resolve())), timeout=1.0):
        return True
    return False


def main(argv=None):
    """Serve until Ctrl-C."""
    arguments = _parser().parse_args(argv)
    if arguments.replay and arguments.replay.is_dir() and (problem := problem_of(arguments.replay)):
        raise SystemExit(f"station: {problem}")
    if not (arguments.page / "index.html").exists():
        raise SystemExit(f"station: {arguments.page} has no page; run make gse")
    if arguments.replay and not arguments.replay.exists():
        raise SystemExit(f"station: there is no run folder {arguments.replay}, and no recording of a run")
    listener = _listen(arguments.http_port)
    host = f"{LOOPBACK}:{listener.getsockname()[1]}"
    flight = None
    if arguments.fly and not arguments.replay and not _is_flying(arguments.run):
        flight = subprocess.Popen(arguments.fly, start_new_session=True)
    print(f"The ground station is at http://{host}/ (Ctrl-C ends it{' and its flight' if flight else ''}).", flush=True)
    station = Station(arguments.run, arguments.page, arguments.replay, arguments.read_only, arguments.framed_by)
    try:
        web.run_app(station.application(host), sock=listener, print=None)
    finally:
        if flight and flight.poll() is None:
            os.killpg(flight.pid, signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                flight.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
