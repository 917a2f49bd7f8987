# SPDX-License-Identifier: Apache-2.0
"""A flight in which processes are stopped, killed, suspended and started again. Tests fly it as
processes, as one image and on two nodes."""

import hashlib

import flying

STEP_NS = 500_000
BUS_LOGS = ("can-robot.log", "can-joystick.log", "can-robot-b.log", "can-joystick-b.log")
MANIPULATOR = 16
PING = b"\x11\x01"
ALIVE = b"\x11\x02"
PINGS = 20  # Pings after each end and start of a process.
FEW = 3  # Pings after a hang that ends before it is detected.
MANIPULATOR_PINGS = 4 * PINGS + FEW + 1  # Pings of the manipulator: four series, a short one, and the ping of all subsystems.


def pings(begin_s, count=PINGS, step_s=0.01):
    return [f"{begin_s + i * step_s:.3f} operator ping MANIPULATOR" for i in range(count)]


def scenario(path):
    """Processes end and start in every way, in OPERATIONAL and in other states, some within one step of the supervisor (10 ms)."""
    lines = ["0.0 hand rest"]
    lines += flying.bring_up(0.2)
    lines += ["7.0 hand circle 0.1 0.5 1 3 1"]
    lines += ["3.0 fault kill manipulator"] + pings(3.2)
    lines += ["3.6 operator process stop MANIPULATOR", "3.601 operator process start MANIPULATOR"] + pings(3.7)
    lines += ["4.0 operator process stop MANIPULATOR", "6.0 operator process start MANIPULATOR"] + pings(6.1)
    lines += ["6.5 fault hang JOYSTICK", "6.51 fault resume JOYSTICK"] + pings(6.6, FEW)
    lines += ["7.0 fault hang manipulator", "7.3 fault resume manipulator"] + pings(8.2)
    # 0x0408 is PUS_FAILURE_LOST: the joystick died before it answered.
    lines += ["8.6 fault kill joystick", "8.6 operator expect-refusal 0x0408 ping JOYSTICK", "9.0 operator ping all", "9.1 operator shutdown"]
    return flying.write_scenario(path, *sorted(lines, key=lambda line: float(line.split()[0])))


def assert_in_order(flight):
    """The flight ended; every ping was answered within two time steps, and no step of the operator failed."""
    assert flight.facts["reproducible"], flight.transcript()
    assert "FAILED" not in flight.console, flight.transcript()
    answers = list(_answers(flight))
    assert len(answers) == MANIPULATOR_PINGS
    assert max(answers) <= 2 * STEP_NS
    flying.assert_clean(flight)


def fly(directory, path, *options, **how):
    """Fly with these options, and check the flight with assert_in_order."""
    flight = flying.fly(directory, "--scenario", path, *options, **how)
    assert_in_order(flight)
    return flight


def digest(flight, names=BUS_LOGS):
    """Checksums of the named logs of a flight."""
    return {name: hashlib.sha256(flight.octets(name)).hexdigest() for name in names}


def _answers(flight):
    """Yield the delay [ns] of each answer of the manipulator to a ping, in the order of the answers."""
    asked = []
    for time_ns, direction, raw in flight.packets:
        if int.from_bytes(raw[:2], "big") & 0x7FF != MANIPULATOR:
            continue
        if direction == "TC" and raw[7:9] == PING:
            asked.append(time_ns)
        elif direction == "TM" and raw[7:9] == ALIVE:
            yield time_ns - asked.pop(0)
