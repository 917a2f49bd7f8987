# SPDX-License-Identifier: Apache-2.0
"""A simulator that crashes first writes all records of its logs, then ends by the signal."""

import signal

import lcm
import pytest
from simulated import BOUND_S, SHEETS, SYNC, Simulator, pass_time, patient

CRASHES = (signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT)
PASSED_MS = 40  # Less than the second after which the simulator flushes its logs for the first time.
QUANTUM_MS = 2


def _crashed(directory, number):
    """Let time pass, then let the simulator crash while it waits for its master."""
    simulator = Simulator(directory, "--in-step", "--quantum", f"{1000 * QUANTUM_MS}")
    network = simulator.connect("robot")
    node = patient(network.add_node(0x11, str(SHEETS / "joint-drive.eds")))
    pass_time(network, PASSED_MS)
    device_type = node.sdo["Device type"].raw  # The answer comes after all frames before the request.
    assert (directory / "can-robot.log").stat().st_size == 0, "the log was flushed before the crash, so the test would show nothing"
    simulator.process.send_signal(number)
    code = simulator.process.wait(BOUND_S)
    network.disconnect()
    simulator.process.stdout.close()
    return code, device_type


def _pcap_records(octets):
    """Number of records of a capture; each must be complete."""
    found, place = 0, 24
    while place < len(octets):
        place += 16 + int.from_bytes(octets[place + 8:place + 12], "little")
        found += 1
    assert place == len(octets)
    return found


@pytest.mark.parametrize("number", CRASHES, ids=lambda number: number.name)
def test_all_records_up_to_a_crash_are_in_the_logs(tmp_path, number):
    code, device_type = _crashed(tmp_path, number)
    assert code == -number
    text = (tmp_path / "can-robot.log").read_text(encoding="ascii")
    assert text.endswith("\n")
    frames = [line.split(" ")[2] for line in text.splitlines()]
    assert frames.count(f"{SYNC:03X}#") == PASSED_MS // QUANTUM_MS
    answer = f"591#43001000{device_type.to_bytes(4, 'little').hex().upper()}"
    assert answer in frames[-20:], "expected the answer that the master has received among the last frames"
    assert _pcap_records((tmp_path / "can-robot.pcap").read_bytes()) == len(frames)
    log = lcm.EventLog(str(tmp_path / "truth.lcm"), "r")
    events = list(log)
    assert log.tell() == (tmp_path / "truth.lcm").stat().st_size
    assert {"WORLD", "DRIVE", "BUS"} <= {event.channel for event in events}
