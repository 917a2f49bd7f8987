# SPDX-License-Identifier: Apache-2.0
"""The report of a transition has the cause that the supervisor gave in its command, whatever the target state
is."""

import flying
import pytest

COMMUNICATION, MANIPULATOR, JOYSTICK = 2, 16, 17
REQUEST, OWN_ERROR, NETWORK, PLAN, SHUTDOWN = range(5)
# Numbers of states, as in TM[129,2].
OFFLINE, PRE_OPERATIONAL, SAFE_OPERATIONAL, OPERATIONAL, ERROR_OPERATIONAL = 0, 3, 4, 5, 6
BEGIN_S = 2.0


def _causes(flight, apid, begin_s=0.0, end_s=1000.0):
    """State -> cause of each transition into another state."""
    return {raw[22]: raw[26] for t, kind, raw in flight.packets
            if kind == "TM" and raw[7:9] == b"\x81\x02" and raw[1] == apid and raw[21] != raw[22] and begin_s <= t / 1e9 < end_s}


@pytest.mark.parametrize("form", ["processes", "image"])
def test_shutdown_and_autostart_are_no_plans(directory, form):
    directory.mkdir()
    path = flying.write_scenario(directory / "down.scn", *flying.bring_up(0.1, tare=False), f"{BEGIN_S} operator shutdown")
    flight = flying.fly(directory / "flight", "--scenario", path, "--form", form)
    assert flight.code == 0, flight.transcript()
    up = dict.fromkeys((PRE_OPERATIONAL, SAFE_OPERATIONAL, OPERATIONAL), REQUEST)
    ground = _causes(flight, COMMUNICATION, end_s=BEGIN_S)
    assert {state: ground[state] for state in up} == up
    for member in (MANIPULATOR, JOYSTICK):
        down = _causes(flight, member, BEGIN_S)
        assert down[SAFE_OPERATIONAL] == SHUTDOWN
        assert set(down.values()) == {SHUTDOWN}


def test_a_plan_that_ends_in_offline_is_no_shutdown(directory):
    directory.mkdir()
    lines = [*flying.bring_up(0.1, tare=False), f"{BEGIN_S} fault unplug joystick", f"{BEGIN_S} operator wait-state MANIPULATOR OFFLINE 2",
             f"{BEGIN_S} operator wait-state JOYSTICK OFFLINE 2", f"{BEGIN_S + 1.5} operator shutdown"]
    flight = flying.fly(directory / "flight", "--scenario", flying.write_scenario(directory / "plan.scn", *lines), "--form", "image")
    assert flight.code == 0, flight.transcript()
    assert _causes(flight, JOYSTICK, BEGIN_S)[ERROR_OPERATIONAL] == OWN_ERROR
    assert _causes(flight, MANIPULATOR, BEGIN_S)[ERROR_OPERATIONAL] == NETWORK
    for member in (MANIPULATOR, JOYSTICK):
        assert _causes(flight, member, BEGIN_S)[OFFLINE] == PLAN
