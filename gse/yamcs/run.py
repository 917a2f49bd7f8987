#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run Yamcs for a flying mission: write its configuration to a new folder and execute the server, which gse/setup/yamcs.sh fetches.

    python3 gse/yamcs/run.py --mission rokviss --ground-port 10015 --out runs/yamcs

Yamcs stores its archive in that folder. It retries a refused connection every ten seconds. Before it starts, the interface that each
subsystem flies is compared with that of the database, and the result is printed."""

import argparse
import json
import os
import pathlib
import random
import shutil
import socket
import struct
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIBRARIES = ROOT / "build" / "yamcs" / "lib"
GENERATED = ROOT / "build" / "generated"
sys.path.insert(0, str(ROOT / "gse"))

from hirosco_gse import packets

USER, STATUS_TC, STATUS_TM = "YAMCS", (129, 4), (129, 5)
ANSWER_S = 3.0
FIRST_PORT, PORTS = 8080, 10


def render(out, mission, ground_port, http_port):
    """Configuration in out/etc; the archive of an earlier run, whose packets would hide equal ones, is removed."""
    shutil.rmtree(out / "data", ignore_errors=True)
    etc = out / "etc"
    etc.mkdir(parents=True, exist_ok=True)
    for bucket in ("displays", "stacks"):  # A copy: users may change them in the web page.
        shutil.copytree(GENERATED / "yamcs" / mission / bucket, out / bucket, dirs_exist_ok=True)
    words = {
        "MISSION": mission, "GROUND_PORT": ground_port, "HTTP_PORT": http_port, "DATA": (out / "data").resolve(),
        "DATABASE": GENERATED / f"{mission}.xtce.xml", "EVENTS": GENERATED / f"{mission}.events.json", "OUT": out.resolve(),
    }
    for source in (pathlib.Path(__file__).parent / "etc").iterdir():
        text = source.read_text(encoding="utf-8")
        for name, value in words.items():
            text = text.replace(f"@{name}@", str(value))
        (etc / source.name).write_text(text, encoding="utf-8")


def lacking(mission):
    """What is missing, with the next step; empty if nothing is."""
    missions = sorted(path.name.removesuffix(".xtce.xml") for path in GENERATED.glob("*.xtce.xml"))
    if mission not in missions:
        return f"--mission {mission}: expected one of {', '.join(missions) or 'none yet'}; `make` makes build/generated/MISSION.xtce.xml"
    if not LIBRARIES.is_dir() or not shutil.which("java"):
        return "Yamcs is not installed: run gse/setup/yamcs.sh"
    return ""


def _ask(port, dictionary, patience_s):
    """Interface hash by APID of the subsystems that answer TC[129,4]. Raises OSError."""
    user = next((one["id"] for one in dictionary["users"] if one["name"] == USER), dictionary["users"][0]["id"])
    found, splitter, end = {}, packets.Splitter(), time.monotonic() + patience_s
    with socket.create_connection(("127.0.0.1", port), timeout=patience_s) as stream:
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


def compare(mission, port, patience_s=ANSWER_S):
    """Lines that say whether database, dictionary and flight have the same interface."""
    dictionary = json.loads((GENERATED / f"{mission}.json").read_text(encoding="utf-8"))
    lines, wanted = [], dictionary["interface_hash"]
    with (GENERATED / f"{mission}.xtce.xml").open(encoding="utf-8") as database:
        if f'interface {wanted}"' not in database.read(4096):
            lines.append(f"the database is not of the dictionary's interface {wanted}: run make")
    try:
        found = _ask(port, dictionary, patience_s)
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
    """The first port from FIRST_PORT on that no program listens at."""
    for port in range(FIRST_PORT, FIRST_PORT + PORTS):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)):
                return port
    raise SystemExit(f"ports {FIRST_PORT} to {FIRST_PORT + PORTS - 1} are in use: choose another by HTTP=")


def command(out):
    return [
        "java", "-Xmx256m", "-cp", f"{LIBRARIES}/*", "org.yamcs.YamcsServer", "--etc-dir", str(out / "etc"),
        "--data-dir", str(out / "data"), "--cache-dir", str(out / "cache"),
        "--log-config", str(out / "etc" / "logging.properties"), "--no-stream-redirect",
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mission", default="rokviss")
    parser.add_argument("--ground-port", type=int, default=10015, help="ground port of the mission, on this machine")
    parser.add_argument("--http-port", type=int, help=f"port of the web interface (default: the first free from {FIRST_PORT})")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "runs" / "yamcs", help="folder of configuration and archive")
    options = parser.parse_args()
    missing = lacking(options.mission)
    if missing:
        parser.error(missing)
    http_port = options.http_port or free_port()
    render(options.out, options.mission, options.ground_port, http_port)
    for line in compare(options.mission, options.ground_port):
        print(f"yamcs: {line}", flush=True)
    print(f"yamcs: http://127.0.0.1:{http_port}/ (Ctrl-C ends it)", flush=True)
    words = command(options.out)
    os.execvp(words[0], words)


if __name__ == "__main__":
    main()
