# SPDX-License-Identifier: Apache-2.0
"""A Yamcs server with the generated configuration, and its interface, for tests."""

import base64
import json
import pathlib
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "gse" / "yamcs"))

import run as yamcs_run

MISSION = "rokviss"
TIMEOUT_S = 300.0
NEWEST = 1000  # Number of packets in one answer.
SYNTHETIC = """
  - name: synthetic
    class: org.yamcs.tctm.TcpTmDataLink
    stream: tm_realtime
    host: 127.0.0.1
    port: %d
    packetInputStreamClassName: org.yamcs.tctm.CcsdsPacketInputStream
    packetInputStreamArgs: {maxPacketLength: 65542}
    packetPreprocessorClassName: org.yamcs.pus.PusPacketPreprocessor
    packetPreprocessorArgs:
      errorDetection: {type: CRC-16-CCIIT}
      timeEncoding: {type: CUC, epoch: TAI}
      checkSequence: false
mdb:"""


def until(condition, what):
    """Wait until the condition is true. Returns its value."""
    end = time.monotonic() + TIMEOUT_S
    while not (found := condition()):
        assert time.monotonic() < end, f"{what} did not come within {TIMEOUT_S} s"
        time.sleep(0.2)
    return found


class Yamcs:
    """A running server and its interface."""

    def __init__(self, directory, ground_port, synthetic_port):
        self.directory = directory
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.port = free.getsockname()[1]
        yamcs_run.render(directory, MISSION, ground_port, self.port)
        etc = directory / "etc" / "yamcs.mission.yaml"
        etc.write_text(etc.read_text(encoding="utf-8").replace("\nmdb:", SYNTHETIC % synthetic_port), encoding="utf-8")
        self.log = directory / "yamcs.log"
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(yamcs_run.command(directory), stdout=log, stderr=subprocess.STDOUT)

    def log_text(self):
        return self.log.read_text(encoding="utf-8", errors="replace")

    def has_started(self):
        assert self.process.poll() is None, self.log_text()[-3000:]
        return "Yamcs started" in self.log_text()

    def ask(self, path, **content):
        """The answer to a request to the interface."""
        data = json.dumps(content).encode() if content else None
        asked = urllib.request.Request(f"http://127.0.0.1:{self.port}/api/{path}", data=data)
        try:
            with urllib.request.urlopen(asked, timeout=TIMEOUT_S) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            raise AssertionError(f"{path} {content}: {error.read().decode()}") from error

    def command(self, name, dry=False, **arguments):
        """Issue a command. Returns the answer."""
        path = f"processors/mission/realtime/commands/{MISSION}/{name}"
        return self.ask(path, args=arguments, dryRun=dry)

    def history(self, identifier):
        """Attributes of an issued command."""
        found = self.ask(f"archive/mission/commands/{urllib.parse.quote(identifier)}")
        return {one["name"]: next(iter(v for k, v in one["value"].items() if k != "type"), None) for one in found.get("attr", [])}

    def carried_out(self, name, **arguments):
        """Issue a command and wait for its end. Returns its history."""
        identifier = self.command(name, **arguments)["id"]
        until(lambda: "CommandComplete_Status" in self.history(identifier), f"end of {name}")
        return self.history(identifier)

    def packets(self):
        """(name, time, sequence, octets) of the newest packets in the archive by their own time, newest first."""
        page = until(self._newest, "the packets")
        return [(one["id"]["name"], one["generationTime"], one["sequenceNumber"], one["packet"]) for one in page.get("packet", [])]

    def _newest(self):
        """Yamcs 5.13 answers with its own ConcurrentModificationException if a packet with a new name arrives while it reads the archive;
        None in that case."""
        try:
            return self.ask(f"archive/mission/packets?limit={NEWEST}&order=desc")
        except AssertionError as error:
            if "ConcurrentModificationException" not in str(error):
                raise
            return None

    def extract(self, name, stamp, sequence):
        """(path, raw value, calibrated value) of the content of a packet, in the order of the packet."""
        path = f"archive/mission/packets/{urllib.parse.quote(name, safe='')}/{stamp}/{sequence}:extract"
        found = self.ask(path).get("parameterValues", [])
        return [(one["parameter"]["qualifiedName"], plain(one.get("rawValue")), plain(one.get("engValue"))) for one in found]

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def plain(value):
    """A value of the interface as a Python value."""
    if value is None:
        return None
    kind = value["type"]
    if kind == "AGGREGATE":
        return {name: plain(one) for name, one in zip(value["aggregateValue"]["name"], value["aggregateValue"]["value"])}
    if kind == "ARRAY":
        return [plain(one) for one in value.get("arrayValue", [])]
    if kind == "BINARY":
        return base64.b64decode(value.get("binaryValue", "")).hex()
    if kind in ("STRING", "ENUMERATED", "TIMESTAMP"):
        return value.get("stringValue", "")
    if kind == "BOOLEAN":
        return value["booleanValue"]
    number = value[f"{kind.lower()}Value"]
    return int(number) if "INT" in kind else float(number)
