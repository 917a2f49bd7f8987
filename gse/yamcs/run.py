#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run Yamcs for a flying mission: write its configuration to a new folder and execute the server, which gse/setup/yamcs.sh fetches.

    python3 gse/yamcs/run.py --mission rokviss --ground-port 10015 --http-port 8090 --out runs/yamcs

Yamcs stores its archive in that folder. It retries a refused connection every ten seconds."""

import argparse
import os
import pathlib
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIBRARIES = ROOT / "build" / "yamcs" / "lib"
GENERATED = ROOT / "build" / "generated"


def render(out, mission, ground_port, http_port):
    """Configuration in out/etc; the archive of an earlier run, whose packets would hide equal ones, is removed."""
    shutil.rmtree(out / "data", ignore_errors=True)
    etc = out / "etc"
    etc.mkdir(parents=True, exist_ok=True)
    words = {
        "MISSION": mission, "GROUND_PORT": ground_port, "HTTP_PORT": http_port, "DATA": (out / "data").resolve(),
        "DATABASE": GENERATED / f"{mission}.xtce.xml", "EVENTS": GENERATED / f"{mission}.events.json",
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


def command(out):
    return [
        "java", "-Xmx256m", "-cp", f"{LIBRARIES}/*", "org.yamcs.YamcsServer", "--etc-dir", str(out / "etc"),
        "--data-dir", str(out / "data"), "--cache-dir", str(out / "cache"),
        "--log-config", str(out / "etc" / "logging.properties"), "--no-stream-redirect",
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mission", default="rokviss")
    parser.add_argument("--ground-port", type=int, default=10015, help="where the mission flies, on this machine")
    parser.add_argument("--http-port", type=int, default=8090, help="of the web interface")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "runs" / "yamcs", help="folder of configuration and archive")
    options = parser.parse_args()
    missing = lacking(options.mission)
    if missing:
        parser.error(missing)
    render(options.out, options.mission, options.ground_port, options.http_port)
    words = command(options.out)
    os.execvp(words[0], words)


if __name__ == "__main__":
    main()
