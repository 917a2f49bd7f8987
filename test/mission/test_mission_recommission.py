# SPDX-License-Identifier: Apache-2.0
"""A subsystem whose process dies in OPERATIONAL telepresence returns to this state with its links if the
mission requires it."""

import shutil

import flying
import pytest

DEATH_S = 3.0
BOUND_S = 0.2  # Longest time from the death to OPERATIONAL, without the time for the tare of the arm (decision 0034).
APIDS = {"MANIPULATOR": 16, "JOYSTICK": 17}
MARKS = ('executable="joystick"', 'executable="manipulator"')
AT_ONCE = ('state="OFFLINE" after="500ms"', 'state="OFFLINE"')


@pytest.fixture(scope="module")
def tree(session_directory):
    """rokviss in which both members are recommissioned, with a recovery plan without delay."""
    place = session_directory / "again"
    place.mkdir()
    shutil.copytree(flying.ROOT / "descriptors", place / "descriptors")
    for name in ("build", "sim", "gse"):
        (place / name).symlink_to(flying.ROOT / name)
    path = place / "descriptors" / "missions" / "rokviss.xml"
    text = path.read_text(encoding="utf-8")
    for mark in MARKS:
        assert mark in text
        text = text.replace(mark, mark + ' recommission="true" restartPeriod="60s"')
    assert AT_ONCE[0] in text
    path.write_text(text.replace(*AT_ONCE), encoding="utf-8")
    return place


def _transitions(flight, apid):
    """(time_s, state, phase) of every TM[129,2]."""
    return [(time_ns / 1e9, raw[22], raw[23]) for time_ns, direction, raw in flight.packets
            if direction == "TM" and raw[7:9] == b"\x81\x02" and raw[0] & 7 == 0 and raw[1] == apid]


def _events(flight, number):
    """(time_s, APID, state) of each event of the supervisor with this number."""
    return [(time_ns / 1e9, int.from_bytes(raw[23:25], "big"), int.from_bytes(raw[25:27], "big")) for time_ns, direction, raw in flight.packets
            if direction == "TM" and raw[7] == 5 and raw[1] == 1 and int.from_bytes(raw[21:23], "big") == number]


def _replies(flight, service, subtype):
    """(time_s, data) of every report of this kind from the manipulator."""
    return [(time_ns / 1e9, raw[21:-2]) for time_ns, direction, raw in flight.packets
            if direction == "TM" and raw[7:9] == bytes((service, subtype)) and raw[1] == 16]


def _fly(tree, directory, name, form, lines):
    directory.mkdir(exist_ok=True)
    scenario = flying.write_scenario(directory / f"{name}.scn", *flying.bring_up(0.0), *lines)
    return flying.fly(directory / f"{name}-{form}", "--scenario", scenario, "--form", form, root=tree)


@pytest.mark.parametrize("victim", ["manipulator", "joystick"])
def test_a_subsystem_that_dies_is_recommissioned_with_its_links(tree, directory, victim):
    lines = ["2.5 operator event disable MANIPULATOR OPERATOR_NOTE", "2.5 operator hk disable MANIPULATOR 4711",
             "2.6 operator event disabled MANIPULATOR", f"{DEATH_S} fault kill {victim}",
             "6.0 operator event disabled MANIPULATOR", "6.0 operator link list", "6.0 operator shutdown"]
    flight = _fly(tree, directory, victim, "processes", lines)
    assert "FAILED" not in flight.console, flight.transcript()
    back = _events(flight, 31)
    assert {(apid, state) for _, apid, state in back} == {(16, 5), (17, 5)}, flight.transcript()
    assert not _events(flight, 32)
    safe_s = next(time_s for time_s, state, phase in _transitions(flight, 16) if time_s > DEATH_S and (state, phase) == (4, 0))
    up_s = max(time_s for time_s, _, _ in back)
    tare_s = max(time_s for time_s, apid, _ in back if apid == 16) - safe_s
    assert up_s - DEATH_S - tare_s < BOUND_S, (back, safe_s)
    lists = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x82\x09" and raw[1] == 1]
    assert lists and lists[-1][21:23] == b"\x00\x02", "expected both links to be open"
    # Settings of reports made by command are not restored: a new process does not have them, and the
    # configuration sets the periodic reports.
    before, after = (data.hex() for _, data in _replies(flight, 5, 8))
    assert (before, after) == ("00010009", "0000" if victim == "manipulator" else "00010009")
    reported = [time_s for time_s, data in _replies(flight, 3, 25) if data[:2] == (4711).to_bytes(2, "big")]
    assert not [time_s for time_s in reported if 2.6 < time_s < DEATH_S] and [time_s for time_s in reported if time_s > DEATH_S]
    flying.assert_clean(flight)


# At the first of these times the supervisor has just commanded the start of the manipulator.
@pytest.mark.parametrize("later_s", [0.0101, 0.03, 0.09])
def test_the_supervisor_may_die_during_recommissioning(tree, directory, later_s):
    lines = [f"{DEATH_S} fault kill manipulator", f"{DEATH_S + later_s} fault kill supervisor",
             "6.0 operator link list", "6.0 operator shutdown"]
    flight = _fly(tree, directory, f"both-{later_s}", "processes", lines)
    assert "FAILED" not in flight.console, flight.transcript()
    assert _events(flight, 20), "expected a restart of the supervisor"
    assert {(apid, state) for _, apid, state in _events(flight, 31)} == {(16, 5), (17, 5)}, flight.transcript()
    assert not _events(flight, 32)
    lists = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x82\x09" and raw[1] == 1]
    assert lists and lists[-1][21:23] == b"\x00\x02", "expected both links to be open"
    flying.assert_clean(flight)


def test_forms_give_identical_logs(tree, directory):
    lines = [f"{DEATH_S} fault kill manipulator", "6.0 operator shutdown"]
    one, other = (_fly(tree, directory, "forms", form, lines) for form in ("processes", "image"))
    for name in flying.TRACED:
        assert one.octets(name) == other.octets(name), name
