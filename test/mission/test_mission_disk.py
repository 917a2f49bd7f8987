# SPDX-License-Identifier: Apache-2.0
"""A disk that is full, becomes full, or is removed: the flight continues and reports it, and run.json is complete."""

import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
from time import sleep

import flying
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "conformance" / "pus"))
import station as stations

SECONDS = 150
COMPONENTS = ("JOYSTICK", "MANIPULATOR", "SUPERVISOR", "COMMUNICATION")
LOG_FAILED, SUPERVISOR_RESTARTED = b"\x00\x08", b"\x00\x14"  # Ids of events of the supervisor.
HIGH_EVENT, STRATEGY_CHANGED = b"\x05\x04", b"\x83\x04"  # TM[5,4] and TM[131,4].
ASCII, RING = 0, 3  # Strategies of the packet log in TM[131,4].
TO_RING, TO_FILE = (ASCII, RING), (RING, ASCII)  # (previous, present) strategy.


@pytest.fixture
def disk(directory):
    """A function that mounts a small disk with this number of octets and returns its directory."""
    made = []

    def mount(size):
        path = directory / "disk"
        path.mkdir(parents=True)
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", path], capture_output=True, text=True)
        if done.returncode != 0:
            pytest.skip(f"no disk can be mounted here: {done.stderr.strip()}")
        made.append(path)
        return path

    yield mount
    for path in made:
        subprocess.run(["umount", path], check=True)


@pytest.fixture(scope="module")
def scenario(session_directory):
    """A flight in which each subsystem gets a request every second."""
    return flying.write_scenario(session_directory / "disk.scn", "0 hand rest", *(f"{second} operator ping all" for second in range(1, SECONDS)), f"{SECONDS} operator shutdown")


def _numbers(flight):
    return [int(line.split()[0]) for line in flight.read("packets.ascii").splitlines()]


def _fill(path):
    with (path / "filler").open("wb", buffering=0) as filler:
        try:
            while filler.write(bytes(65536)):
                pass
        except OSError:
            pass
    return path / "filler"


def _is_logging(flight):
    """True if the file of the packet log is open in the supervisor."""
    files = pathlib.Path(f"/proc/{flight.children().get('supervisor')}/fd")
    try:
        return any(os.readlink(entry).endswith("/packets.ascii") for entry in files.iterdir())
    except OSError:
        return True  # The process has just closed a file, or does not exist yet.


def test_a_flight_on_a_full_disk_continues_to_its_end(disk):
    flight = flying.fly(disk(3_000_000) / "out", "--scenario", "telepresence")
    assert flight.code == 1
    assert flight.facts["exit_code"] == 1
    assert flight.facts["simulated_s"] > 90, "expected the flight to continue to its end"
    assert flight.facts["exit_reason"].startswith("simulator ended with exit code 1")
    for name in ("joystick", "manipulator", "supervisor", "communication", "operator"):
        assert next(entry for entry in flight.facts["processes"] if entry["name"] == name)["exit_code"] == 0
    numbers = _numbers(flight)
    assert numbers == list(range(1, len(numbers) + 1))
    for name in ("packets.ascii", "can-robot.log", "operator.log"):
        assert flight.octets(name).endswith(b"\n"), f"{name} ends within a line"
    assert all(json.loads(line) for line in flight.read("operator.log").splitlines())
    assert not (flight.directory / "packets.log").exists(), "an incomplete file has the name of a complete one"
    assert not (flight.directory / "run.json.part").exists()
    flying.assert_clean(flight)


@pytest.mark.long
def test_the_log_continues_when_the_disk_has_room_again(disk, scenario):
    """While the disk is full, the ring in memory keeps the records; at the end no record is missing."""
    place = disk(64_000_000)
    flight = flying.start(place / "out", "--scenario", scenario)
    try:
        flying.wait_until(lambda: flight.steps() > 5, "step of the operator")
        filler = _fill(place)
        held = len(_numbers(flight))
        flying.wait_until(lambda: not _is_logging(flight) or flight.process.poll() is not None, "the log in the ring")
        filler.unlink()
        flight.wait()
    finally:
        flight.abandon()
    assert flight.facts["simulated_s"] >= SECONDS
    assert "records of the packet log" not in flight.console, flight.transcript()
    numbers = _numbers(flight)
    assert sorted(numbers) == list(range(1, len(numbers) + 1)), "expected every record once"
    assert len(numbers) > held
    packets = [raw for _, direction, raw in flight.packets if direction == "TM"]
    assert len(flight.packets) == len(numbers)
    changes = [(raw[21], raw[22]) for raw in packets if raw[7:9] == STRATEGY_CHANGED]
    assert changes == [TO_RING, TO_FILE], "expected a change to the ring and one back to the file, without a command"
    assert any(raw[7:9] == HIGH_EVENT and raw[21:23] == LOG_FAILED for raw in packets)


def test_a_run_whose_directory_is_removed_fails_with_a_message(directory, scenario):
    flight = flying.start(directory / "out", "--scenario", scenario)
    try:
        flying.wait_until(lambda: flight.steps() > 5, "step of the operator")
        for _ in range(2):  # A process may make a file while the first call removes the directory.
            shutil.rmtree(flight.directory, ignore_errors=True)
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 1
    assert "cannot write run.json into the run's directory" in flight.output
    assert not flight.leftovers()


def test_the_merge_names_missing_records(directory):
    """The merge reports missing records, also those after the last existing record."""
    flight = flying.fly(directory / "out", "--scenario", "commissioning")
    lines = flight.read("packets.ascii").splitlines(keepends=True)
    count = len(lines)
    (flight.directory / "packets.ascii").write_text("".join(lines[:9] + ["10 19 GAP\n"] + lines[19:-2]), encoding="utf-8")
    for name in ("packets.db", "packets.log"):
        (flight.directory / name).unlink()
    done = subprocess.run([flying.BIN / "packet-archive-sqlite", "merge", flight.directory, str(count)], capture_output=True, text=True)
    assert done.returncode == 1
    assert f"12 missing, 0 doubled: 10-19 {count - 1}-{count}; known in flight: 10" in done.stderr, done.stderr
    assert len(flight.packets) == count - 12


# ---- A disk that is slow, does not answer, or turns read-only ----


@pytest.fixture(scope="module")
def programs(session_directory):
    """Programs of a mission whose supervisor has slow_disk.c preloaded."""
    programs = session_directory / "programs"
    shutil.copytree(flying.BIN, programs)
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", programs / "slow.so", pathlib.Path(__file__).with_name("slow_disk.c"), "-ldl"], check=True)
    (programs / "supervisor").rename(programs / "supervisor.plain")
    (programs / "supervisor").write_text(f'#!/bin/sh\nLD_PRELOAD="{programs}/slow.so" exec "{programs}/supervisor.plain" "$@"\n', encoding="utf-8")
    (programs / "supervisor").chmod(0o755)
    return programs


@contextlib.contextmanager
def _station(directory, programs, time):
    """A ground station, and a flight on a disk that the files `hold` and `readonly` in `directory` cause to hang
    or to fail."""
    gate = directory / "gate"
    gate.mkdir(parents=True)
    flight = flying.start(directory / "out", "--time", time, "--scenario", "none", binaries=programs, environment={"SLOW_DISK_DIRECTORY": str(gate)})
    try:
        ground = stations.Station(flight, stations.Notes())
        for name in COMPONENTS:
            assert ground.do(name, 17, 1).is_completed
        yield flight, ground, gate
        ground.close()
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        (gate / "hold").unlink(missing_ok=True)
        flight.abandon()


def _strategies(ground):
    """(from, to) of each reported change of strategy."""
    return [(p.data[0], p.data[1]) for p, _ in ground.reports if p.message == (131, 4)]


def _assert_whole(flight, changes):
    assert flight.code == 0, flight.transcript()
    assert flight.facts["exit_code"] == 0
    assert "records of the packet log" not in flight.console, flight.transcript()
    numbers = _numbers(flight)
    assert numbers == list(range(1, len(numbers) + 1)), "expected every record once, in order"
    assert len(flight.packets) == len(numbers)
    packets = [raw for _, direction, raw in flight.packets if direction == "TM"]
    assert [(raw[21], raw[22]) for raw in packets if raw[7:9] == STRATEGY_CHANGED] == changes
    assert sum(raw[7:9] == HIGH_EVENT and raw[21:23] == LOG_FAILED for raw in packets) == len(changes) / 2


@pytest.mark.parametrize("time", ["real", "free"])
def test_a_disk_that_does_not_answer_delays_no_answer_of_a_subsystem(directory, programs, time):
    """A write of the log does not end until every subsystem has answered and the log has reported that the
    ring is selected."""
    with _station(directory, programs, time) as (flight, ground, gate):
        (gate / "hold").touch()
        flying.wait_until(lambda: ground.do("JOYSTICK", 17, 1).is_completed and (gate / "held").exists(), "a write that waits")
        ground.wait(lambda: _strategies(ground) == [TO_RING], "the log in the ring")
        for _ in range(20):
            for name in COMPONENTS:
                assert ground.do(name, 17, 1).is_completed
        assert _strategies(ground) == [TO_RING]
        (gate / "hold").unlink()
        ground.wait(lambda: _strategies(ground) == [TO_RING, TO_FILE], "the log in its file again")
    _assert_whole(flight, [TO_RING, TO_FILE])
    assert all(entry.get("starts", 1) == 1 for entry in flight.facts["processes"]), flight.facts["processes"]
    assert "hangs" not in flight.console, flight.transcript()


def test_the_next_supervisor_writes_the_records_that_waited_for_the_disk(directory, programs):
    """The next supervisor writes the records that the writer of the dead one had not written."""
    with _station(directory, programs, "free") as (flight, ground, gate):
        (gate / "hold").touch()
        flying.wait_until(lambda: ground.do("JOYSTICK", 17, 1).is_completed and (gate / "held").exists(), "a write that waits")
        ground.wait(lambda: _strategies(ground) == [TO_RING], "the log in the ring")
        os.kill(flight.children()["supervisor.plain"], signal.SIGKILL)
        ground.wait(lambda: any(p.service == 5 and p.data[:2] == SUPERVISOR_RESTARTED for p, _ in ground.reports), "the next supervisor")
        assert ground.do("MANIPULATOR", 17, 1).is_completed
        (gate / "hold").unlink()
        for name in COMPONENTS:
            assert ground.do(name, 17, 1).is_completed
    numbers = _numbers(flight)
    assert sorted(numbers) == list(range(1, len(numbers) + 1)), "expected every record once"
    assert "records of the packet log" not in flight.console, flight.transcript()


@pytest.mark.parametrize("time", ["real", "free"])
def test_the_log_returns_to_its_file_when_the_disk_is_no_longer_read_only(directory, programs, time):
    """Writes fail, and the file can be neither truncated nor opened; later everything works again."""
    with _station(directory, programs, time) as (flight, ground, gate):
        (gate / "readonly").touch()
        flying.wait_until(lambda: ground.do("JOYSTICK", 17, 1).is_completed and _strategies(ground) == [TO_RING], "the log in the ring")
        began = ground.now()
        # Retries fail here. The ring holds the records of these few requests.
        while ground.now() <= began + 4.0:
            assert ground.do("JOYSTICK", 17, 1).is_completed
            sleep(0.05)
        assert _strategies(ground) == [TO_RING]
        (gate / "readonly").unlink()
        flying.wait_until(lambda: ground.do("JOYSTICK", 17, 1).is_completed and _strategies(ground) == [TO_RING, TO_FILE], "the log in its file again")
    _assert_whole(flight, [TO_RING, TO_FILE])


@pytest.fixture
def failing_disk(directory):
    """A function that mounts a file system and returns its directory, and a function that makes it fail."""
    image, path = directory / "image", directory / "disk"
    path.mkdir(parents=True)
    with image.open("wb") as file:
        file.truncate(64_000_000)
    made = subprocess.run(["sh", "-c", f"mkfs.ext4 -q '{image}' && mount -o loop '{image}' '{path}'"], capture_output=True, text=True)
    if made.returncode != 0:
        pytest.skip(f"no file system can be mounted here: {made.stderr.strip()}")
    yield path, lambda: subprocess.run(["mount", "-o", "remount,abort", path], check=True)
    subprocess.run(["umount", path], check=True)


@pytest.mark.long
def test_a_flight_continues_when_the_kernel_makes_the_file_system_read_only(failing_disk, scenario):
    """As after an error of the disk, open files fail permanently. The flight continues to its end."""
    place, fail = failing_disk
    flight = flying.start(place / "out", "--scenario", scenario)
    try:
        flying.wait_until(lambda: flight.steps() > 5, "step of the operator")
        fail()
        flying.wait_until(lambda: not _is_logging(flight) or flight.process.poll() is not None, "the log in the ring")
        flight.wait()
    finally:
        flight.abandon()
    assert flight.code == 1, flight.transcript()
    assert "cannot write run.json into the run's directory" in flight.output, flight.transcript()
    assert not (flight.directory / "run.json").exists(), "an incomplete file has the name of a complete one"
    assert not flight.leftovers()


def test_slow_disk_is_reported_and_changes_nothing(directory, programs):
    """In stepped time a slow write only delays the flight: simulated time stands still meanwhile, and the packets are the same."""
    flight = flying.fly(directory / "slow", "--scenario", "commissioning", binaries=programs)
    assert flight.code == 0, flight.transcript()
    reported = re.search(r"supervisor: one write of the packet log took (\d+) ms", flight.console)
    assert reported and int(reported[1]) >= 300, flight.transcript()
    plain = flying.fly(directory / "plain", "--scenario", "commissioning")
    assert flight.octets("packets.log") == plain.octets("packets.log")
