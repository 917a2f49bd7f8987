# SPDX-License-Identifier: Apache-2.0
"""Checks of the test environment of the hardware-in-the-loop tests (environments.py): its buses work with the tools of other
projects and with plain sockets."""

import contextlib
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import cases
import environments

BOUND_S = 300
PROBE = "001#"


def command(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=BOUND_S).stdout


def until(condition, what):
    """Poll until a condition holds; the time limit only ends a wait without end."""
    end = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < end, f"not within {BOUND_S} s: {what}"
        time.sleep(0.02)


def command_lines():
    """Command lines of all processes."""
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            yield path.read_bytes()


def recorded(listen, send, *frames):
    """The frames that `candump -L` records on one interface while `cansend` sends on another."""
    log = pathlib.Path(os.environ["OUT"]) / f"{listen}.log"
    with open(log, "w") as file:
        recorder = subprocess.Popen(["candump", "-L", listen], stdout=file, stdin=subprocess.DEVNULL)
        try:
            # candump listens as soon as a probe frame has arrived; it has all frames as soon as the last one
            # has arrived.
            def records_probe():
                command("cansend", send, PROBE)
                return f" {PROBE}\n" in log.read_text()
            until(records_probe, "the probe frame in candump's log")
            for frame in frames:
                command("cansend", send, frame)
            until(lambda: f" {frames[-1]}\n" in log.read_text(), "the last frame in candump's log")
        finally:
            recorder.terminate()
            recorder.wait()
    words = [line.split()[2] for line in log.read_text().splitlines()]
    return [word for word in words if word != PROBE]


def case_loopback_is_up():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        one.bind(("127.0.0.1", 0))
        one.settimeout(BOUND_S)
        other.sendto(b"octets", one.getsockname())
        assert one.recv(100) == b"octets"


def case_candump_records_what_cansend_sends_on_vcan():
    command("ip", "link", "add", "vcan-a", "type", "vcan")
    command("ip", "link", "set", "vcan-a", "mtu", "72", "up")
    frames = ["123#DEADBEEF", "1ABCDEF0#11", "191##53302B4EE08004602"]  # Flags 5: CANFD_BRS (bit rate switch) and CANFD_FDF, which kernels set
    assert recorded("vcan-a", "vcan-a", *frames) == frames


def case_vxcan_joins_two_interfaces():
    command("ip", "link", "add", "vx-a", "type", "vxcan", "peer", "name", "vx-b")
    for name in ("vx-a", "vx-b"):
        command("ip", "link", "set", name, "up")
    assert recorded("vx-b", "vx-a", "321#01", "322#02") == ["321#01", "322#02"]


def case_tipc_carries_a_message():
    service = (socket.TIPC_ADDR_NAMESEQ, 18500, 0, 0, socket.TIPC_NODE_SCOPE)
    with socket.socket(socket.AF_TIPC, socket.SOCK_RDM) as one, socket.socket(socket.AF_TIPC, socket.SOCK_RDM) as other:
        one.bind(service)
        one.settimeout(BOUND_S)
        other.sendto(b"octets", (socket.TIPC_ADDR_NAME, 18500, 0, 0))
        assert one.recv(100) == b"octets"


def case_network_namespaces_are_joined_by_veth():
    for name in ("node-a", "node-b"):
        command("ip", "netns", "add", name)
    command("ip", "link", "add", "va", "netns", "node-a", "type", "veth", "peer", "name", "vb", "netns", "node-b")
    for name, interface, address in (("node-a", "va", "10.99.0.1/24"), ("node-b", "vb", "10.99.0.2/24")):
        command("ip", "-n", name, "address", "add", address, "dev", interface)
        command("ip", "-n", name, "link", "set", interface, "up")
    command("ip", "netns", "exec", "node-a", "ip", "route", "get", "10.99.0.2")
    command("ip", "netns", "exec", "node-a", "tc", "qdisc", "add", "dev", "va", "root", "netem", "loss", "100%")


def case_shared_memory_can_be_written():
    path = pathlib.Path("/dev/shm/hirosco-buses")
    path.write_bytes(bytes(1 << 20))
    path.unlink()


def case_this_kernel_is_chosen_and_its_commands_are_isolated():
    with tempfile.TemporaryDirectory() as directory:
        os.environ["HIL_ENVIRONMENT"] = ""
        chosen = environments.choose(directory)
        assert chosen.name == "running kernel", chosen.why
        done = chosen.run("ip link add inside type vcan && touch /run/inside && echo $OUT; sleep 1000 & exit 3", BOUND_S)
        assert (done.code, done.stdout.strip()) == (3, str(done.directory)), done.end()
        assert not os.path.exists("/sys/class/net/inside") and not os.path.exists("/run/inside")
        hung = chosen.run("echo begun; sleep 1000", 1)
        assert hung.code == environments.LIMIT_REACHED, hung.end()
    until(lambda: b"sleep\x001000\x00" not in command_lines(), "the end of the process that the command has left")


if __name__ == "__main__":
    cases.run(globals())
