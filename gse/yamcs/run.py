#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run Yamcs for a flying mission: write its configuration to a new directory and execute the server, which gse/setup/yamcs.sh fetches.

    python3 gse/yamcs/run.py --out runs/yamcs

Mission and ground port are those of the run in runs/latest, unless they are given. Yamcs stores its archive in its directory, in which one
Yamcs runs at a time. It retries a refused connection every ten seconds. Before it starts, the interface that each subsystem flies is
compared with that of the database, and the result is printed. Exit code 0 after Ctrl-C, 1 if Yamcs ends by itself, 2 usage."""

import argparse
import contextlib
import fcntl
import json
import pathlib
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIBRARIES = ROOT / "build" / "yamcs" / "lib"
GENERATED = ROOT / "build" / "generated"
sys.path.insert(0, str(ROOT / "gse"))

from hirosco_gse import packets
from hirosco_gse.run_directory import LATEST, LOOPBACK, Place, mission_of

USER, STATUS_TC, STATUS_TM = "YAMCS", (129, 4), (129, 5)
ANSWER_S = 3.0  # Longest wait for the answers to TC[129,4].
FIRST_PORT, PORTS = 8080, 10
STATION = "http://127.0.0.1:8090/"
# Each subsystem may use the id of an event for another event. So each has a decoder, which finds the names of its own events only.
DECODER = """  - class: org.yamcs.pus.PusEventDecoder
    name: events-{name}
    args:
      eventIdParameter: /{mission}/{name}/LAST_EVENT
      eventTemplateFile: "{templates}"
"""
ENDED = (0, 128 + signal.SIGINT, 128 + signal.SIGTERM, -signal.SIGINT, -signal.SIGTERM)
END_S = 60  # Longest wait for the end of the server.


def render(out, mission, ground_port, http_port, station=STATION):
    """Write the configuration to out/etc. Remove the archive of an earlier run: Yamcs would discard packets that are equal to archived ones."""
    shutil.rmtree(out / "data", ignore_errors=True)
    etc = out / "etc"
    etc.mkdir(parents=True, exist_ok=True)
    for bucket in ("displays", "stacks"):  # Copy the files, because users may change them in the web page.
        shutil.copytree(GENERATED / "yamcs" / mission / bucket, out / bucket, dirs_exist_ok=True)
    (out / "view").mkdir(exist_ok=True)
    view = (pathlib.Path(__file__).parent / "view.js").read_text(encoding="utf-8")
    (out / "view" / "view.js").write_text(view.replace("@STATION@", station), encoding="utf-8")
    dictionary = json.loads((GENERATED / f"{mission}.json").read_text(encoding="utf-8"))
    templates = GENERATED / f"{mission}.events.json"
    decoders = [DECODER.format(name=one["name"], mission=mission, templates=templates) for one in dictionary["subsystems"] if one["events"]]
    words = {
        "DECODERS": "".join(decoders), "MISSION": mission, "GROUND_PORT": ground_port, "HTTP_PORT": http_port, "DATA": (out / "data").resolve(),
        "DATABASE": GENERATED / f"{mission}.xtce.xml", "OUT": out.resolve(),
    }
    for source in (pathlib.Path(__file__).parent / "etc").iterdir():
        text = source.read_text(encoding="utf-8")
        for name, value in words.items():
            text = text.replace(f"@{name}@", str(value))
        (etc / source.name).write_text(text, encoding="utf-8")


def lacking(mission):
    """Text that names what is missing and the next step; empty if nothing is missing."""
    missions = sorted(path.name.removesuffix(".xtce.xml") for path in GENERATED.glob("*.xtce.xml"))
    if mission not in missions:
        return f"--mission {mission}: expected one of {', '.join(missions) or 'none yet'}; `make` makes build/generated/MISSION.xtce.xml"
    if not LIBRARIES.is_dir() or not shutil.which("java"):
        return "Yamcs is not installed: run gse/setup/yamcs.sh"
    return ""


def _ask(port, dictionary, timeout_s):
    """Interface hash by APID of the subsystems that answer TC[129,4]. Raises OSError."""
    user = next((one["id"] for one in dictionary["users"] if one["name"] == USER), dictionary["users"][0]["id"])
    found, splitter, end = {}, packets.Splitter(), time.monotonic() + timeout_s
    with socket.create_connection(("127.0.0.1", port), timeout=timeout_s) as stream:
        for subsystem in dictionary["subsystems"]:
            stream.sendall(packets.build_tc(subsystem["apid"], random.randrange(0x4000), *STATUS_TC, source=user))
        while len(found) < len(dictionary["subsystems"]) and (left := end - time.monotonic()) > 0:
            stream.settimeout(left)
            try:
                octets = stream.recv(65536)
            except TimeoutError:
                break
            if not octets:
                break
            for raw in splitter.feed(octets):
                packet = packets.parse(raw)
                if packet.message == STATUS_TM:
                    found[packet.apid] = struct.unpack_from(">Q", packet.data, 5)[0]
    return found


def compare_files(mission, wanted):
    """A line for each generated file for Yamcs that was made for another interface: database, event templates, displays and stacks."""
    used = [GENERATED / f"{mission}.xtce.xml", GENERATED / f"{mission}.events.json", *sorted((GENERATED / "yamcs" / mission).glob("*/*"))]
    return [f"{path.relative_to(GENERATED)} was not made for the interface of the dictionary, {wanted}: run make" for path in used
            if wanted not in path.read_text(encoding="utf-8")]


def compare(mission, port, timeout_s=ANSWER_S):
    """Lines that say whether the files for Yamcs, the dictionary and the flight have the same interface."""
    dictionary = json.loads((GENERATED / f"{mission}.json").read_text(encoding="utf-8"))
    wanted = dictionary["interface_hash"]
    lines = compare_files(mission, wanted)
    try:
        found = _ask(port, dictionary, timeout_s)
    except OSError as error:
        return [*lines, f"no mission at 127.0.0.1:{port} ({error.strerror or error}): its interface is not compared; Yamcs connects within 10 s of its start"]
    for subsystem in dictionary["subsystems"]:
        flown, known = found.get(subsystem["apid"]), int(subsystem["interface_hash"], 0)
        if flown is None:
            lines.append(f"{subsystem['name']} does not answer: its interface is not compared")
        elif flown != known:
            lines.append(f"{subsystem['name']} flies interface 0x{flown:016X}, the database has 0x{known:016X}: names and values may be wrong; run make")
    return lines or [f"the mission flies the interface of the database, {wanted}"]


def free_port():
    """The first port, beginning with FIRST_PORT, on which no program listens."""
    for port in range(FIRST_PORT, FIRST_PORT + PORTS):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)):
                return port
    raise SystemExit(f"ports {FIRST_PORT} to {FIRST_PORT + PORTS - 1} are in use: choose another with HTTP=")


def command(out):
    return [
        "java", "-Xmx256m", "-cp", f"{LIBRARIES}/*", "org.yamcs.YamcsServer", "--etc-dir", str(out / "etc"),
        "--data-dir", str(out / "data"), "--cache-dir", str(out / "cache"),
        "--log-config", str(out / "etc" / "logging.properties"), "--no-stream-redirect",
    ]


@contextlib.contextmanager
def alone(out):
    """Lock the directory until the end. Raises SystemExit if another Yamcs runs in it."""
    out.mkdir(parents=True, exist_ok=True)
    with (out / "lock").open("w", encoding="ascii") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise SystemExit(f"yamcs: another Yamcs runs in {out}: end it, or choose another directory with OUT=") from None
        yield lock


def serve(out, lock):
    """Run the server until it ends or this process receives a signal to end. Returns the exit code."""
    asked = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # SIGHUP: the terminal was closed.
        signal.signal(number, lambda number, _: asked.append(number))
    # In its own session the server does not receive the Ctrl-C of the terminal. It inherits the lock, so that the
    # directory stays locked if this process is killed.
    server = subprocess.Popen(command(out), start_new_session=True, pass_fds=[lock.fileno()])
    while server.poll() is None and not asked:
        time.sleep(0.1)
    if asked:
        server.terminate()
        try:
            server.wait(END_S)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()
    if asked and server.returncode in ENDED:
        return 0
    print(f"yamcs: Yamcs ended with code {server.returncode}", file=sys.stderr)
    return 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=pathlib.Path, default=LATEST, help="run directory of the flight (default runs/latest)")
    parser.add_argument("--mission", help="default: that of the run")
    parser.add_argument("--ground-port", type=int, help="ground port of the mission, on this machine (default: that of the run)")
    parser.add_argument("--http-port", type=int, help=f"port of the web interface (default: the first free from {FIRST_PORT})")
    parser.add_argument("--station", default=STATION, help=f"page of make gse, which the 3D view shows (default {STATION})")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "runs" / "yamcs", help="directory of configuration and archive")
    options = parser.parse_args()
    mission = options.mission or mission_of(options.run)
    place = Place.of(options.run, port=options.ground_port)
    missing = lacking(mission)
    if missing:
        parser.error(missing)
    with alone(options.out) as lock:
        http_port = options.http_port or free_port()
        render(options.out, mission, place.port, http_port, options.station)
        print(f"yamcs: mission {mission}, ground port {LOOPBACK}:{place.port}", flush=True)
        if place.key:
            print("yamcs: its telecommands need a key: run `gse gateway`, then make yamcs PORT= with the port of the gateway", flush=True)
        for line in compare(mission, place.port):
            print(f"yamcs: {line}", flush=True)
        print(f"yamcs: http://{LOOPBACK}:{http_port}/ (Ctrl-C ends it)", flush=True)
        if http_port != FIRST_PORT:
            print(f"yamcs: for the 3D view in its page: make gse FRAMED_BY=http://{LOOPBACK}:{http_port}", flush=True)
        return serve(options.out, lock)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # Before the server has started.
        print("yamcs: ended by Ctrl-C", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)
