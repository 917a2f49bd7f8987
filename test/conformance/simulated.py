# SPDX-License-Identifier: Apache-2.0
"""A simulator without flight software, for masters and tools of other projects."""

import pathlib
import re
import signal
import subprocess
import time

import canopen

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIMULATOR = ROOT / "build/bin/simulator"
WORLD = ROOT / "descriptors/worlds/rokviss.xml"
CUBE = ROOT / "test/conformance/worlds/cube.xml"
SHEETS = ROOT / "descriptors/devices"
SYNC = 0x080
BOUND_S = 300.0  # Wall-clock limit for waits only: devices are in simulated time.


class Simulator:
    """The simulator, its tool port, and the directory of its logs."""

    def __init__(self, directory, *options, world=WORLD):
        self.directory = directory
        arguments = [SIMULATOR, "--world", world, "--free-run", "3600", "--socketcand", "0", "--out", directory, *options]
        self.process = subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.port = int(re.search(r"127\.0\.0\.1:(\d+)", line).group(1))
        self.networks = []

    def connect(self, bus):
        """A network on one of the simulator's buses, over the tool port."""
        network = canopen.Network()
        network.connect(interface="socketcand", host="127.0.0.1", port=self.port, channel=bus)
        self.networks.append(network)
        return network

    def close(self):
        """End the simulator; it must end without error."""
        for network in self.networks:
            network.disconnect()
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(BOUND_S) == 0
        self.process.stdout.close()


def pass_time(network, milliseconds):
    """Let simulated time pass; for `--in-step --quantum 2000`, in which each frame lets 2 ms pass."""
    for _ in range(milliseconds // 2):
        network.send_message(SYNC, [])


def patient(node):
    """Give a node of profile 402 time-outs for a busy machine."""
    node.sdo.RESPONSE_TIMEOUT = BOUND_S
    node.TIMEOUT_SWITCH_STATE_FINAL = node.TIMEOUT_SWITCH_STATE_SINGLE = BOUND_S
    node.TIMEOUT_SWITCH_OP_MODE = node.TIMEOUT_CHECK_TPDO = node.TIMEOUT_HOMING_DEFAULT = BOUND_S
    return node


def until(condition, what):
    """Poll until a condition holds; simulated time continues only if a client advances it."""
    end = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < end, f"not within {BOUND_S} s: {what}"
        time.sleep(0.01)
