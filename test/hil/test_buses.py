# SPDX-License-Identifier: Apache-2.0
"""The buses over SocketCAN: the same flight as on shared memory, frame by frame, as tools that nobody here wrote record it."""

import pathlib
import re
import subprocess

import pytest

import place as places

PROGRAM = "test/hil/guest/socketcan.py"
SECONDS = 2400
TELEPRESENCE, TELEPRESENCE_S = "test/hil/guest/telepresence.py", 8000
TOOLS = ("7FE#EE", "7FF#FF")  # Probe and sentinel of the recorder.
FD_FLAG = 0x4  # candump shows the kernel's mark of an FD frame among its flags; our log has the frame's own flags only.
HIL = {"vcan": ("rokviss", "hil"), "controllers": ("classic", "classic")}


@pytest.fixture(scope="module")
def group(place):
    return place.group("socketcan", f"{places.PYTHON} {PROGRAM}", seconds=SECONDS, cans=2)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The same flights on shared memory, here."""
    folders = {}
    for name, (mission, scenario) in HIL.items():
        folders[name] = tmp_path_factory.mktemp("buses") / name
        ended = subprocess.run([places.ROOT / "build" / "bin" / "hirosco", "run", "--mission", mission, "--scenario", scenario,
                                "--report", "no", "--out", folders[name]], cwd=places.ROOT, stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, timeout=600)
        assert ended.returncode == 0, ended.stdout + ended.stderr
    return folders


@pytest.mark.parametrize("case", places.cases(PROGRAM))
def test_case(group, case):
    group.check(case)


def frames(path, interface):
    """Identifiers and data of an interface, in order; flags of FD frames without the mark that they are FD."""
    found = []
    for line in pathlib.Path(path).read_text().splitlines():
        _, name, frame = line.split()[:3]
        if name == interface and frame not in TOOLS:
            found.append(re.sub("##(.)", lambda match: f"##{int(match[1], 16) & ~FD_FLAG:X}", frame))
    return found


@pytest.mark.parametrize("name", HIL)
def test_logs_are_those_of_shared_memory(group, flown, name):
    group.check({"vcan": "vcan_flight_is_seen_by_candump",
                 "controllers": "emulated_controllers_carry_the_classic_mission"}[name])
    for log in ("can-robot.log", "can-robot-b.log", "can-joystick.log", "packets.log"):
        assert (group.result.folder / name / log).read_bytes() == (flown[name] / log).read_bytes(), log


@pytest.mark.parametrize("bus, least", [("robot", 10000), ("robot-b", 10), ("joystick", 10000)])
def test_candump_recorded_the_same_frames(group, flown, bus, least):
    """Channel B, which nobody uses, carries what devices say after they are switched on."""
    group.check("vcan_flight_is_seen_by_candump")
    expected = frames(flown["vcan"] / f"can-{bus}.log", bus)
    recorded = frames(group.result.folder / "vcan" / "candump.log", f"vcan-{bus}")
    assert len(expected) > least
    assert recorded == expected


@pytest.mark.long
@pytest.mark.timeout(TELEPRESENCE_S + 600)
def test_whole_telepresence_is_that_of_shared_memory(place, tmp_path):
    """Contact, springs, pulled plugs and coming back: the logs, and what candump has recorded."""
    flight = tmp_path / "telepresence"
    ended = subprocess.run([places.ROOT / "build" / "bin" / "hirosco", "run", "--scenario", "telepresence", "--report", "no",
                            "--out", flight], cwd=places.ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    group = place.group("telepresence", f"{places.PYTHON} {TELEPRESENCE}", seconds=TELEPRESENCE_S)
    group.check("telepresence_is_flown_over_vcan")
    for log in ("can-robot.log", "can-robot-b.log", "can-joystick.log", "packets.log"):
        assert (group.result.folder / "telepresence" / log).read_bytes() == (flight / log).read_bytes(), log
    dump = group.result.folder / "candump.log"
    assert "DROPCOUNT" not in dump.read_text()
    for bus in ("robot", "joystick"):
        expected = frames(flight / f"can-{bus}.log", bus)
        assert len(expected) > 500_000
        assert frames(dump, f"vcan-{bus}") == expected, bus
