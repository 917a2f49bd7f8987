# SPDX-License-Identifier: Apache-2.0
"""An event whose report is disabled (TC[5,6]) still has effects: the supervisor receives a notice, shuts the
network down, and starts the recovery plan."""

import flying
import pytest
from lives import STEP_NS

MANIPULATOR, JOYSTICK, SUPERVISOR = 16, 17, 1
NETWORK_SHUT_DOWN, PLAN_STARTED = 3, 6
ERROR_OPERATIONAL = 6
CUT_S = 2.0


@pytest.fixture(scope="module")
def disabled(session_directory):
    """A joint drive is disconnected while the reports of DEVICE_LOST and LINK_STALE of both members are
    disabled. Returns the reports from then on: (time since then [ns], APID, octets)."""
    lines = ["0.0 hand rest", *flying.bring_up(0.5, tare=False)]
    lines += [f"1.9 operator event disable {name} {event}" for name in ("MANIPULATOR", "JOYSTICK") for event in ("DEVICE_LOST", "LINK_STALE")]
    lines += [
        f"{CUT_S} fault unplug robot JOINT1",
        f"{CUT_S} operator wait-state MANIPULATOR OFFLINE 1",
        f"{CUT_S} operator wait-state JOYSTICK OFFLINE 1",
        f"{CUT_S + 1.0} operator shutdown",
    ]
    path = flying.write_scenario(session_directory / "disabled-events.scn", *lines)
    flight = flying.fly(session_directory / "disabled-events", "--scenario", path, "--form", "image")
    assert flight.code == 0, flight.transcript()
    cut_ns = round(CUT_S * 1e9)
    return [(t - cut_ns, int.from_bytes(raw[:2], "big") & 0x7FF, raw) for t, kind, raw in flight.packets if kind == "TM" and t >= cut_ns]


def _of(packets, apid, *message):
    """(time [ns], source data) of the reports of an application process with this type and subtype."""
    return [(t, raw[21:-2]) for t, sender, raw in packets if sender == apid and raw[7:9] == bytes(message)]


def test_the_supervisor_gets_a_notice_in_place_of_the_report(disabled):
    assert not _of(disabled, MANIPULATOR, 5, 4)
    notices = [raw for _, apid, raw in disabled if apid == MANIPULATOR and raw[7:9] == bytes((129, 7))]
    assert notices
    assert notices[0][21:-2] == bytes((0, 1, 4)), "DEVICE_LOST, HIGH"
    assert notices[0][11:13] == b"\x80\x01"  # Destination: the supervisor as a user.


def test_network_goes_to_error_operational_and_the_plan_runs(disabled):
    shut = [t for t, data in _of(disabled, SUPERVISOR, 5, 1) if data[:2] == NETWORK_SHUT_DOWN.to_bytes(2, "big")]
    plan = [t for t, data in _of(disabled, SUPERVISOR, 5, 1) if data[:2] == PLAN_STARTED.to_bytes(2, "big")]
    notice = _of(disabled, MANIPULATOR, 129, 7)[0][0]
    assert len(shut) == len(plan) == 1
    assert 0 <= shut[0] - notice <= STEP_NS, "expected the shutdown in the time step of the notice, or in the next"
    for apid in (MANIPULATOR, JOYSTICK):
        states = [data[1] for _, data in _of(disabled, apid, 129, 2) if data[0] != data[1]]
        assert states == [ERROR_OPERATIONAL, 7, 8, 9, 0]  # Then POST_OPERATIONAL, both DEINIT states and OFFLINE.
