# SPDX-License-Identifier: Apache-2.0
"""While a MEDIUM plan runs, the supervisor still reacts to HIGH events and runs their plan."""

import shutil

import flying
import pytest
from lives import STEP_NS

MANIPULATOR, JOYSTICK, SUPERVISOR = 16, 17, 1
NETWORK_SHUT_DOWN, PLAN_OVERRULED = 3, 19
DRIVE_WARNING, DEVICE_LOST = 7, 1
MEDIUM_S, CUT_S = 2.0, 3.0
SLOW = """<Plan name="SLOW" severity="MEDIUM">
      <Action do="STATE" target="SELF" state="SAFE_OPERATIONAL"/>
      <Action do="STATE" target="NETWORK" state="PRE_OPERATIONAL" after="20s"/>
    </Plan>
    <Plan name="EASE" """


@pytest.fixture(scope="module")
def packets(session_directory):
    """In operation the manipulator reports that a drive is too hot (MEDIUM), then the joystick is unplugged
    (HIGH)."""
    tree = session_directory / "slow-plan"
    tree.mkdir()
    shutil.copytree(flying.ROOT / "descriptors", tree / "descriptors")
    for name in ("build", "sim", "gse"):
        (tree / name).symlink_to(flying.ROOT / name)
    mission = tree / "descriptors" / "missions" / "rokviss.xml"
    text = mission.read_text(encoding="utf-8")
    assert '<Plan name="EASE" ' in text
    mission.write_text(text.replace('<Plan name="EASE" ', SLOW, 1), encoding="utf-8")
    lines = ["0.0 hand rest", *flying.bring_up(0.1, tare=False)]
    lines += [
        f"{MEDIUM_S} fault error robot JOINT1 0x4310 on",  # EMCY 0x4310: over-temperature of the drive.
        f"{MEDIUM_S} operator wait-state MANIPULATOR SAFE_OPERATIONAL 1",
        f"{CUT_S} fault unplug joystick",
        f"{CUT_S} operator wait-state MANIPULATOR OFFLINE 2",
        f"{CUT_S} operator wait-state JOYSTICK OFFLINE 2",
        f"{CUT_S + 1.5} operator shutdown",
    ]
    path = flying.write_scenario(session_directory / "slow-plan.scn", *lines)
    flight = flying.fly(session_directory / "slow-plan-run", "--scenario", path, "--form", "image", root=tree)
    assert flight.code == 0, flight.transcript()
    return [(t, int.from_bytes(raw[:2], "big") & 0x7FF, raw) for t, kind, raw in flight.packets if kind == "TM"]


def _events(packets, severity):
    return [(t, int.from_bytes(raw[21:23], "big"), raw[23:-2]) for t, apid, raw in packets if apid == SUPERVISOR and raw[7:9] == bytes((5, severity))]


def test_the_plan_of_a_high_event_ends_the_medium_plan(packets):
    reports = [data for _, event, data in _events(packets, 1) if event == PLAN_OVERRULED]
    assert reports == [bytes((0, MANIPULATOR, 0, DRIVE_WARNING, 0, JOYSTICK, 0, DEVICE_LOST))]


def test_a_high_event_shuts_the_network_down_at_once_and_its_plan_leads_to_offline(packets):
    lost = next(t for t, apid, raw in packets if apid == JOYSTICK and raw[7:9] == b"\5\4")
    shut = [t for t, event, _ in _events(packets, 1) if event == NETWORK_SHUT_DOWN]
    assert len(shut) == 1
    assert 0 <= shut[0] - lost <= STEP_NS, "expected the shutdown in the time step of the event, or in the next"
    for member in (MANIPULATOR, JOYSTICK):
        after = [raw[22] for t, apid, raw in packets if apid == member and raw[7:9] == bytes((129, 2)) and t >= round(CUT_S * 1e9) and raw[21] != raw[22]]
        assert after == flying.ERROR_TO_OFFLINE
