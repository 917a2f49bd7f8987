# SPDX-License-Identifier: Apache-2.0
"""A flight that ends without a shutdown, or a supervisor whose checkpoint is damaged: the state of the
spacecraft is unknown. This is reported, and the mission continues in its fallback mode."""

import mmap
import os
import signal
import subprocess

import flying
import pytest
import station as stations

# Failure codes of ST[01].
PERMISSION = 0x0110

INTERRUPTED, CHECKPOINT_DAMAGED = "event=23", "event=22"
SAFE, NOMINAL = 0, 1
SUPERVISOR, MANIPULATOR = 1, 16


def _reports_of_supervisor(directory):
    """Reports of the supervisor, as pusdump writes them."""
    lines = subprocess.run([flying.ROOT / "build/bin/pusdump", directory / "packets.log"], check=True, capture_output=True, text=True).stdout
    return [line for line in lines.splitlines() if " TM 1 " in line]


def _events(directory, number):
    return [line for line in _reports_of_supervisor(directory) if number in line.split()]


def _set_mode(ground, mode):
    assert ground.settle(ground.send_data(SUPERVISOR, 131, 1, bytes([mode]))).is_completed


def _assert_in_fallback_mode(ground):
    """Disabling an event requires mode NOMINAL; the refusal names mode and state."""
    refused = ground.settle(ground.send_data(MANIPULATOR, 5, 6, bytes([1, 0, 1]))).failure
    assert (refused.code, refused.detail >> 8) == (PERMISSION, SAFE)


def _begin(directory, storage):
    flight = stations.launch(directory, "--storage", storage, "--form", "processes")
    return flight, stations.Station(flight, stations.Notes())


def _shut_down(flight, ground, code=0):
    ground.close()
    flight.process.send_signal(signal.SIGINT)
    assert flight.wait().code == code, flight.transcript()


def _cut_off(flight, ground):
    """Kill the launcher; all other processes end with it."""
    flight.process.kill()
    flight.wait()
    ground.close()
    flying.wait_until(lambda: not flight.leftovers(), "the end of all processes of the flight")


@pytest.mark.parametrize("mode", [SAFE, NOMINAL])
def test_a_flight_after_an_interrupted_one_begins_in_the_fallback_mode(tmp_path, mode):
    storage = tmp_path / "storage"
    flight, ground = _begin(tmp_path / "1", storage)
    _set_mode(ground, mode)
    _cut_off(flight, ground)
    assert not _events(tmp_path / "1", INTERRUPTED)

    flight, ground = _begin(tmp_path / "2", storage)
    _assert_in_fallback_mode(ground)
    _set_mode(ground, NOMINAL)
    _shut_down(flight, ground)
    (line,) = _events(tmp_path / "2", INTERRUPTED)
    assert f"auxiliary={mode:02X}" in line.upper().replace("AUXILIARY", "auxiliary")

    flight, ground = _begin(tmp_path / "3", storage)
    _shut_down(flight, ground)
    assert not _events(tmp_path / "3", INTERRUPTED)


def _flip_both_banks(identity):
    """Change a bit of each page of the supervisor's checkpoint, and so of both banks. Returns the changed
    octets."""
    with open(f"/dev/shm/{identity}.checkpoint", "r+b") as file, mmap.mmap(file.fileno(), 0) as memory:
        for place in range(mmap.PAGESIZE // 2, len(memory), mmap.PAGESIZE):
            memory[place] ^= 1
        return memory[:]


def test_a_damaged_checkpoint_is_reported_and_kept_and_the_flight_continues(tmp_path):
    storage = tmp_path / "storage"
    flight, ground = _begin(tmp_path / "1", storage)
    ground.do("SUPERVISOR", 17, 1)
    victim = flight.children()["supervisor"]
    os.kill(victim, signal.SIGSTOP)
    octets = _flip_both_banks(flight.identity)
    os.kill(victim, signal.SIGKILL)
    ground.report(5, 4, apid=SUPERVISOR)
    _assert_in_fallback_mode(ground)
    _shut_down(flight, ground, code=1)
    (line,) = _events(tmp_path / "1", CHECKPOINT_DAMAGED)
    assert line.endswith("auxiliary=0001")
    kept = (storage / "SUPERVISOR.checkpoint.damaged.0").read_bytes()
    assert len(kept) == len(octets)
    assert sum(one != other for one, other in zip(kept, octets, strict=True)) <= 16  # The generations of both banks were cleared.
