# SPDX-License-Identifier: Apache-2.0
"""Limits of memory and open files of a subsystem's process: a process with a leak dies, the other processes
continue."""

import shutil
import signal
import struct
import subprocess

import flying
import pytest

LEAK = flying.ROOT / "test" / "mission" / "leak.c"
MISSION = "descriptors/missions/rokviss.xml"
OTHERS = ("simulator", "supervisor", "communication", "manipulator", "packet-archive-sqlite")


def _programs_with_leak(directory, kind):
    """A copy of the programs in which the joystick has a leak once the file `go` exists. Returns the directory
    of the programs and this file."""
    programs, go = directory / "programs", directory / "go"
    shutil.copytree(flying.BIN, programs)
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", f'-DLEAK_TRIGGER="{go}"', f"-DLEAK_KIND={kind}", "-o", programs / "leak.so", LEAK, "-lpthread"], check=True)
    (programs / "joystick").rename(programs / "joystick.plain")
    script = programs / "joystick"
    script.write_text(f'#!/bin/sh\nLD_PRELOAD="{programs}/leak.so" exec "{programs}/joystick.plain" "$@"\n', encoding="utf-8")
    script.chmod(0o755)
    return programs, go


def _fly_with_leak(directory, kind):
    directory.mkdir()
    programs, go = _programs_with_leak(directory, kind)
    scenario = flying.write_scenario(directory / "leak.scn", "0 hand rest", "0 operator ping all", *flying.bring_up(0.1), *(f"{second} operator ping MANIPULATOR" for second in range(2, 60)), "60 operator shutdown")
    flight = flying.start(directory / "out", "--scenario", scenario, binaries=programs)
    try:
        flying.wait_until(lambda: flight.steps() > 15 or flight.process.poll() is not None, "step of the operator")
        go.touch()
        flight.wait()
    finally:
        flight.abandon()
    return flight


def _process(flight, name):
    return next(entry for entry in flight.facts["processes"] if entry["name"] == name)


@pytest.mark.parametrize("kind", ["take_memory", "take_descriptors"])
def test_a_leaking_subsystem_dies_alone(directory, kind):
    flight = _fly_with_leak(directory, kind)
    leaking = _process(flight, "joystick")
    assert flight.facts["exit_reason"].startswith("joystick was ended by signal 6"), flight.transcript()
    assert leaking["memory_high_kib"] <= leaking["memory_limit_kib"] == 12288
    assert "joystick: had " in flight.output and "its address space is limited to 12288 KiB" in flight.output, flight.transcript()
    for name in OTHERS:
        assert _process(flight, name).get("exit_code") == 0, flight.transcript()
    assert _process(flight, "manipulator")["starts"] == 1
    assert flight.facts["simulated_s"] > 5
    flying.assert_clean(flight)


LIVES = 3  # The first life and the two restarts of the budget.
HIGH_EVENT = b"\x05\x04"
JOYSTICK_LOST = struct.pack(">HH", 1, 17)  # Event PROCESS_LOST of the supervisor, APID of the joystick.
MODE_CHANGED = b"\x83\x02"


def _next_life(flight, before):
    """Wait for a process of the joystick that is not in `before`, or for the end of the run. Returns the
    process."""
    flying.wait_until(lambda: flight.children().get("joystick.plain", 0) not in {0, *before} or flight.process.poll() is not None, "another life of the joystick")
    return flight.children().get("joystick.plain", 0)


def _await_end(flight, joystick):
    flying.wait_until(lambda: flight.children().get("joystick.plain", 0) != joystick or flight.process.poll() is not None, "the end of this life of the joystick")


def _leak_in_each_life(flight, go):
    """Each life of the joystick in turn takes all memory that it can get."""
    seen = set()
    for _ in range(LIVES):
        joystick = _next_life(flight, seen)
        seen.add(joystick)
        go.touch()
        _await_end(flight, joystick)
        assert not go.exists()


def test_a_leak_in_each_life_uses_up_the_budget_and_ends_in_the_fallback(directory):
    """The limit ends each life, and the process is started again. After the last start the mission enters its
    fallback mode once and continues without the joystick."""
    directory.mkdir()
    programs, go = _programs_with_leak(directory, "take_memory")
    flight = flying.start(directory / "out", "--time", "real", "--scenario", "none", binaries=programs)
    try:
        flight.port()
        flying.wait_until(lambda: "JOYSTICK is alive" in flying.gse(flight, "ping", "all").stdout, "answers of all subsystems")
        _leak_in_each_life(flight, go)
        flying.wait_until(lambda: "MANIPULATOR is alive" in flying.gse(flight, "ping", "MANIPULATOR").stdout, "an answer of MANIPULATOR")
        assert "joystick.plain" not in flight.children()
        flight.process.send_signal(signal.SIGINT)
        flight.wait()
    finally:
        flight.abandon()
    lost = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == HIGH_EVENT and raw[21:25] == JOYSTICK_LOST]
    modes = [raw[21:24] for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == MODE_CHANGED]
    assert len(lost) == LIVES, flight.transcript()
    assert [mode[:2] for mode in modes] == [b"\x01\x00"], (modes, flight.transcript())  # From NOMINAL to SAFE.
    leaking = _process(flight, "joystick")
    assert leaking["starts"] == LIVES
    assert leaking["memory_high_kib"] <= leaking["memory_limit_kib"]
    assert _process(flight, "manipulator")["starts"] == 1
    for name in OTHERS:
        assert _process(flight, name).get("exit_code") == 0, flight.transcript()
    flying.assert_clean(flight)


def test_a_limit_below_the_program_itself_is_refused(directory):
    root = _copy(directory, 'memoryKiB="12288"', 'memoryKiB="100"')
    flight = flying.fly(directory / "out", "--scenario", "commissioning", root=root)
    assert flight.code == 1
    assert 'rokviss.xml:6: memoryKiB="100" of <Subsystem>: expected more KiB than the program alone needs, ' in flight.output, flight.transcript()
    assert not flight.directory.exists()


def test_without_a_limit_one_is_derived_and_reported(directory):
    root = _copy(directory, 'memoryKiB="12288"', "")
    flight = flying.fly(directory / "out", "--scenario", "commissioning", root=root)
    assert flight.code == 0, flight.transcript()
    limit = _process(flight, "joystick")["memory_limit_kib"]
    assert f"rokviss.xml:6: JOYSTICK has no memoryKiB: limited to {limit} KiB" in flight.output, flight.transcript()
    assert 10240 < limit < 16384


def _copy(directory, old, new):
    """A copy of the descriptors with the first `old` replaced, in a directory with links to the other parts
    of the project."""
    root = directory / "root"
    root.mkdir(parents=True)
    shutil.copytree(flying.ROOT / "descriptors", root / "descriptors")
    for name in ("build", "sim", "gse"):
        (root / name).symlink_to(flying.ROOT / name)
    text = (root / MISSION).read_text(encoding="utf-8")
    assert old in text
    (root / MISSION).write_text(text.replace(old, new, 1), encoding="utf-8")
    return root
