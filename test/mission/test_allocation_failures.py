# SPDX-License-Identifier: Apache-2.0
"""Each flight refuses one request for a block of a pool or for a socket: flight n refuses request n (without
LONG=1 every fourth). The flight does not crash and leaves nothing behind, and the refusal is counted and
reported. The programs of SANITIZE=1 refuse the request that HIROSCO_REFUSE_TAKE numbers."""

import json
import re

import flying
import pytest

SANITIZED = flying.ROOT / "build" / "sanitize" / "bin"
REPORT = re.compile(r"ERROR: \w*Sanitizer|runtime error:|LeakSanitizer|SUMMARY: |assertion")

pytestmark = pytest.mark.skipif(not (SANITIZED / "image").exists(), reason="not built: make SANITIZE=1 all")

SCENARIO = (
    "0.0 hand rest",
    "0.0 operator ping all",
    "0.1 operator state MANIPULATOR PRE_OPERATIONAL",
    "0.1 operator state JOYSTICK PRE_OPERATIONAL",
    "0.6 operator config MANIPULATOR STAND_ALONE",
    "0.6 operator config JOYSTICK STAND_ALONE",
    "0.8 operator state MANIPULATOR SAFE_OPERATIONAL",
    "0.8 operator state JOYSTICK SAFE_OPERATIONAL",
    "0.8 operator nowait cmd MANIPULATOR.TARE",
    "1.8 operator state MANIPULATOR OPERATIONAL",
    "1.8 operator state JOYSTICK OPERATIONAL",
    "2.2 operator nowait cmd MANIPULATOR.MOVE_TO POSITION=1.0472,-1.5708 DURATION=0.5",
    "2.2 operator nowait cmd JOYSTICK.FORCE TORQUE=0.05,-0.05 DURATION=0.2",
    "3.0 operator nowait cmd MANIPULATOR.STOP",
    "3.0 operator nowait cmd JOYSTICK.STOP",
    "3.0 operator nowait cmd MANIPULATOR.RAISE EVENT=9",
    "3.0 operator nowait cmd JOYSTICK.RAISE EVENT=9",
    "3.1 operator nowait tc SUPERVISOR 11,22 'n=[{\"group_id\": 1, \"group_status\": \"enabled\"}]'",
    "3.1 operator nowait at 60 ping MANIPULATOR",
    """3.1 operator nowait tc SUPERVISOR 21,1 request_sequence_id=LOOK 'n=[{"request": "ping MANIPULATOR", "delay": 1}]'""",
    "3.1 operator nowait action add MANIPULATOR TORQUE_LIMIT cmd MANIPULATOR.STOP",
    "3.2 operator get SUPERVISOR.BLOCKS",
    "3.2 operator get MANIPULATOR.COUNTERS",
    "3.2 operator get JOYSTICK.COUNTERS",
    "3.2 operator get COMMUNICATION.COUNTERS",
    "3.2 operator get SUPERVISOR.GROUND",
    "3.3 operator shutdown",
)


def fly(directory, number):
    """Fly once; the request with this number is refused (0: none)."""
    directory.parent.mkdir(parents=True, exist_ok=True)
    scenario = flying.write_scenario(directory.parent / "allocation.scn", *SCENARIO)
    flight = flying.fly(
        directory, "--scenario", scenario, "--form", "image", binaries=SANITIZED,
        environment={"HIROSCO_REFUSE_TAKE": str(number), "ASAN_OPTIONS": "detect_leaks=1:abort_on_error=0"},
    )
    assert not REPORT.search(flight.console + flight.output), flight.transcript()
    flying.assert_clean(flight)
    return flight


def refusals(flight):
    """Sum of the components' counters that the operator has read; None if it could not read them."""
    path = flight.directory / "operator.log"
    steps = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    found = re.findall(r"(?:POOL|SOCKET|BLOCK|REQUEST|SEQUENCE)_REFUSED: (\d+)", " ".join(step["outcome"] for step in steps if step["verb"] == "get"))
    return sum(map(int, found)) if found else None


def takes(flight):
    """Number of blocks and sockets that the image requested."""
    return int(re.search(r"image: takes (\d+)", flight.console)[1])


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.long)])
def test_each_refusal_is_counted_and_ends_nothing(directory, every):
    undisturbed = fly(directory / "0", 0)
    assert undisturbed.code == 0, undisturbed.transcript()
    assert refusals(undisturbed) == 0, undisturbed.read("operator.log")
    total = takes(undisturbed)
    # The image takes at least the blocks of the requests in SCENARIO and of their packets, and the listening
    # socket.
    assert total >= 20
    for number in range(1, total + 1, every):
        flight = fly(directory / str(number), number)
        counted = refusals(flight)
        if counted is None:  # The ground could not connect; then the run reports the refusal.
            assert flight.code != 0, flight.transcript()
        else:
            assert counted == 1, f"take {number}: {flight.read('operator.log')}"
