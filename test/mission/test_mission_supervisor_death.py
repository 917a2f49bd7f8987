# SPDX-License-Identifier: Apache-2.0
"""The supervisor dies in a busy flight and comes back: nobody but the packet log notices.

A point is an instant of the flight at which `fault kill supervisor` strikes. One that fails flies again, alone, with
    POINTS=2.1335 build/venv/bin/python -m pytest test/mission/test_mission_supervisor_death.py -k by_points
"""

import os
import random
import sqlite3

import flying
import pytest

SLOT_S = 0.0005
BOOT_S = 0.050  # Declared for the supervisor where its mission says nothing.
FOUND_S = 0.031  # Its promise, 20 ms more, and the step of a member.
BRINGING_UP_S = (0.1, 1.5)
BUSY_S = (2.0, 3.8)
END_S = 4.4
POINTS = 12
LONG_POINTS = 1000
PART = 50  # Points of one test.
RESTARTED = bytes.fromhex("0014")
SUPERVISOR = 1
RESTARTED_CODE = 0x040B


def _lines():
    """Both members in operation, then commands of every kind that shows no trace on a bus."""
    steps = [
        "ping MANIPULATOR",
        "nowait ping JOYSTICK",
        "nowait ping COMMUNICATION",
        "nowait ping SUPERVISOR",
        "at +0.2 ping MANIPULATOR",
        "hk once MANIPULATOR 4711",
        "nowait ping MANIPULATOR",
        "link list",
        "log sqlite",
        "at +0.15 ping JOYSTICK",
        "networks",
        "get MANIPULATOR.TORQUE_OFFSET",
        "log ascii",
        "log ring",
        "status",
        "nowait ping MANIPULATOR",
        "schedule list",
    ]
    lines = ["0.0 hand rest", "1.8 hand circle 0.1 0.5 1 3 1", *flying.bring_up(0.1)]
    schedule = ("tc SUPERVISOR 11,22 'n=[{\"group_id\":1,\"group_status\":\"enabled\"}]'", "at +0.5 ping MANIPULATOR", "tc SUPERVISOR 11,20 n=[1]", "schedule enable")
    lines += [f"1.6 operator {step}" for step in schedule]
    time_s, count = BUSY_S[0], 0
    while time_s < BUSY_S[1]:
        lines.append(f"{time_s:.4f} operator {steps[count % len(steps)]}")
        time_s, count = time_s + 0.01, count + 1
    return [*lines, f"{END_S} operator shutdown"]


def _write(folder, name, points=()):
    kills = [f"{point:.4f} fault kill supervisor" for point in points]
    return flying.write_scenario(folder / f"{name}.scn", *kills, *_lines())


@pytest.fixture(scope="module")
def undisturbed(hangar):
    """The flight in which nobody dies."""
    flight = flying.fly(hangar / "alive", "--scenario", _write(hangar, "alive"), "--port", flying.free_port())
    assert flight.code == 0, flight.told()
    return flight


def _fly(folder, point, form="processes"):
    folder.mkdir(exist_ok=True)
    name = f"{round(point / SLOT_S)}-{form}"
    return flying.fly(folder / name, "--scenario", _write(folder, name, [point]), "--form", form, "--port", flying.free_port())


def _draw(count, seed, part=BUSY_S):
    """Instants of a part of the flight."""
    drawn = random.Random(seed)
    first, last = (round(time_s / SLOT_S) for time_s in part)
    return [drawn.randrange(first, last) * SLOT_S for _ in range(count)]


# ---- What holds after each ----


def _apid(raw):
    return int.from_bytes(raw[:2], "big") & 0x7FF


def _assert_log_is_whole(flight):
    with sqlite3.connect(f"file:{flight.folder}/packets.db?mode=ro", uri=True) as database:
        numbers = [number for (number,) in database.execute("SELECT number FROM packet ORDER BY number")]
    assert numbers == list(range(1, len(flight.packets) + 1))


def _assert_nothing_is_doubled_or_missing(flight):
    """Each application's reports have consecutive sequence counts."""
    counts = {}
    for time_ns, direction, raw in flight.packets:
        if direction == "TM":
            apid, count = _apid(raw), int.from_bytes(raw[2:4], "big") & 0x3FFF
            assert count == counts.get(apid, -1) + 1, f"APID {apid} at {time_ns} ns"
            counts[apid] = count


def _assert_each_request_ends_once(flight):
    """One completion, or one failure, of each telecommand that asked for it. Returns those that ended because of the restart."""
    requests, ends, restarted = {}, {}, 0
    for _, direction, raw in flight.packets:
        if direction == "TC" and raw[6] & 0x08:
            identity = raw[:4] + raw[9:11]  # with who asked
            requests[identity] = requests.get(identity, 0) + 1
        elif direction == "TM" and raw[7] == 1 and raw[8] in (2, 4, 7, 8, 10):
            identity = raw[21:25] + raw[11:13]
            ends[identity] = ends.get(identity, 0) + 1
            restarted += raw[8] == 8 and int.from_bytes(raw[25:27], "big") == RESTARTED_CODE
    assert requests
    for identity, times in requests.items():
        assert ends.get(identity, 0) == times, f"request {identity.hex()}"
    return restarted


def _assert_links_stay_fresh(flight):
    stale = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == bytes([130, 10]) and raw[24] == 4]
    assert not stale


def _back_after_s(flight, point):
    for time_ns, direction, raw in flight.packets:
        if direction == "TM" and _apid(raw) == SUPERVISOR and raw[7:9] == bytes([5, 2]) and raw[21:23] == RESTARTED:
            return time_ns / 1e9 - point
    raise AssertionError("no SUPERVISOR_RESTARTED")


def _assert_goes_on(flight, point):
    assert flight.code == (0 if flight.facts["form"] == "image" else 1), flight.told()  # a death fails a run of processes
    assert flight.facts["reproducible"] is True
    assert flight.facts["simulated_s"] >= END_S
    assert _back_after_s(flight, point) <= BOOT_S + 3 * SLOT_S + 1e-9
    _assert_log_is_whole(flight)
    _assert_nothing_is_doubled_or_missing(flight)
    _assert_links_stay_fresh(flight)
    _assert_each_request_ends_once(flight)
    flying.assert_clean(flight)


def _assert_nobody_notices(flight, undisturbed, point):
    _assert_goes_on(flight, point)
    for name in flying.BUS_LOGS:
        assert flight.octets(name) == undisturbed.octets(name), name


def _fly_all(folder, undisturbed, points):
    """Commands that take effect on a bus come later where they wait for the supervisor: only the others leave no trace."""
    for point in points:
        flight = _fly(folder, point)
        try:
            if point >= BUSY_S[0]:
                _assert_nobody_notices(flight, undisturbed, point)
            else:
                _assert_goes_on(flight, point)
        except AssertionError as error:
            raise AssertionError(f"POINTS={point:.4f}: {error}") from error


# ---- Tests ----


def test_undisturbed_flight_is_whole(undisturbed):
    """The checks hold where nobody dies."""
    _assert_log_is_whole(undisturbed)
    _assert_nothing_is_doubled_or_missing(undisturbed)
    assert _assert_each_request_ends_once(undisturbed) == 0


def test_death_by_points(folder, undisturbed):
    """At instants drawn from a seed, or at those that POINTS names."""
    named = [float(text) for text in os.environ.get("POINTS", "").split()]
    _fly_all(folder, undisturbed, named or _draw(POINTS, "short"))


def test_death_while_members_come_up(folder, undisturbed):
    """Configurations, negotiations and transitions under way go on."""
    _fly_all(folder, undisturbed, _draw(POINTS // 2, "up", BRINGING_UP_S))


@pytest.mark.long
@pytest.mark.parametrize("part", range(LONG_POINTS // PART))
def test_death_by_many_points(folder, undisturbed, part):
    """A thousand instants, one in ten while members come up."""
    _fly_all(folder, undisturbed, _draw(PART // 10, part, BRINGING_UP_S) + _draw(PART - PART // 10, part))


def test_a_supervisor_that_hangs_is_killed_and_comes_back(folder):
    """The members find it by its beat, at the same instant in every form; one that hangs for less goes on."""
    folder.mkdir()
    for name, words, ends in (("hang", ["2.5 fault hang supervisor"], 1), ("blink", ["2.5 fault hang supervisor", "2.52 fault resume supervisor"], 0)):
        path = flying.write_scenario(folder / f"{name}.scn", *words, *_lines())
        flights = [flying.fly(folder / f"{name}-{form}", "--scenario", path, "--form", form, "--duration", 20) for form in ("image", "processes")]
        for flight in flights:
            assert flight.facts["reproducible"] is True, flight.told()
            assert flight.facts["simulated_s"] < 2 * END_S
            _assert_log_is_whole(flight)
            _assert_each_request_ends_once(flight)
            assert sum(direction == "TM" and raw[7:9] == bytes([5, 2]) and raw[21:23] == RESTARTED for _, direction, raw in flight.packets) == ends
            flying.assert_clean(flight)
        if ends:
            assert _back_after_s(flights[0], 2.5) <= FOUND_S + BOOT_S + 3 * SLOT_S + 1e-9
        assert flights[0].octets("packets.log") == flights[1].octets("packets.log")


def test_death_in_the_image(folder, undisturbed):
    """In one address space the same octets."""
    point = _draw(1, "image")[0]
    flights = [_fly(folder, point, form) for form in ("processes", "image")]
    for flight in flights:
        _assert_nobody_notices(flight, undisturbed, point)
    for name in flying.TRACED:
        assert flights[0].octets(name) == flights[1].octets(name), name
