# SPDX-License-Identifier: Apache-2.0
"""A member without a supervisor stays in OPERATIONAL as long as its mission allows, then goes to
SAFE_OPERATIONAL by itself."""

import datetime
import shutil

import flying
import pytest
from hirosco_gse import packets

DEATH_S = 2.0
AWAY_S = 5.0  # Declared boot time of the supervisor.
MANIPULATOR = 16
EPOCH_S = (datetime.datetime(2026, 6, 1, 12) - datetime.datetime(1958, 1, 1)).total_seconds()  # Epoch of rokviss after 1958.
SUPERVISOR_LOST = 6  # Cause in TM[129,2].


def _mission(session_directory, timeout):
    """rokviss with a supervisor that is restarted late."""
    place = session_directory / f"timeout-{timeout or 'default'}"
    shutil.copytree(flying.ROOT / "descriptors", place / "descriptors")
    for name in ("build", "sim", "gse"):
        (place / name).symlink_to(flying.ROOT / name)
    path = place / "descriptors" / "missions" / "rokviss.xml"
    text = path.read_text(encoding="utf-8")
    changes = [('executable="supervisor"', f'bootTime="{AWAY_S:.0f}s"')]
    if timeout:
        changes.append(('executable="manipulator"', f'supervisorTimeout="{timeout}"'))
    for mark, attribute in changes:
        assert text.count(mark) == 1
        text = text.replace(mark, f"{mark} {attribute}")
    path.write_text(text, encoding="utf-8")
    return place


def _left_s(flight):
    """Time [s] at which the arm left OPERATIONAL because of the lost supervisor, from its own report."""
    found = [packets.decode_time(raw[13:21]) / 1e9 - EPOCH_S for _, direction, raw in flight.packets
             if direction == "TM" and raw[7:9] == b"\x81\x02" and raw[1] == MANIPULATOR and raw[21:23] == b"\x05\x04" and raw[26] == SUPERVISOR_LOST]
    assert len(found) <= 1
    return found[0] if found else None


@pytest.mark.parametrize(("timeout", "timeout_s"), [("1s", 1.0), (None, 3.0), ("10s", None)])
def test_a_subsystem_waits_for_its_supervisor_as_long_as_the_mission_defines(session_directory, directory, timeout, timeout_s):
    directory.mkdir()
    lines = [*flying.bring_up(0.0), f"{DEATH_S} fault kill supervisor", f"{DEATH_S + AWAY_S + 1.0} operator shutdown"]
    scenario = flying.write_scenario(directory / "timeout.scn", *lines)
    flight = flying.fly(directory / "flight", "--scenario", scenario, root=_mission(session_directory, timeout))
    assert "FAILED" not in flight.console, flight.transcript()
    left_s = _left_s(flight)
    if timeout_s is None:
        assert left_s is None
    else:
        # The last heartbeat was at most a third of the time-out, or a second, before the death.
        assert DEATH_S - min(1.0, timeout_s / 3) + timeout_s < left_s <= DEATH_S + timeout_s + 0.001, flight.transcript()
    flying.assert_clean(flight)
