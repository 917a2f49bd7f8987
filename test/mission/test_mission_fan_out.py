# SPDX-License-Identifier: Apache-2.0
"""A port with two readers in flight: whatever happens to one reader, the other reader loses no sample."""

import os
import struct

import flying
import pytest
import second_reader

CYCLE_NS = 500_000
TOGETHER_NS = 600_000_000  # Largest interval between the link reports before and after a closing or a death.
FIRST_DEATH_NS = 3_100_000_000
# A row of TM[130,9]: link, state, APID and port of both ends, (21 octets of properties), sent, received, lost, late, last sequence.
ROW = struct.Struct(">HBHHHH21xIIIII")
REPORTS_NS = 100_000_000  # Within this time all members have answered a request for link reports.
APIDS = {"MANIPULATOR": 16, "JOYSTICK": 17, "SHADOW": 18}
LINKS = {2: "MANIPULATOR", 5: "SHADOW"}  # Number of the link in the mission: its reader.


@pytest.fixture(scope="module")
def root(session_directory):
    return second_reader.build(session_directory / "shadow")


def _lists(flight):
    """Each TM[130,9] of a member as (time_ns, apid, {link: (state, sent, received, lost, late)})."""
    found = []
    for time_ns, direction, raw in flight.packets:
        apid = struct.unpack(">H", raw[:2])[0] & 0x7FF
        if direction == "TM" and raw[7:9] == b"\x82\x09" and apid != 1:
            rows = {row[0]: (row[1], *row[6:10]) for row in ROW.iter_unpack(raw[23:-2])}
            found.append((time_ns, apid, rows))
    return found


def _up(at):
    """Lines that bring all three members to PRE_OPERATIONAL and open both links."""
    lines = [f"{at} operator state {name} PRE_OPERATIONAL" for name in second_reader.MEMBERS]
    lines += [f"{at} operator config {name} TELEPRESENCE" for name in second_reader.MEMBERS]
    return lines + [f"{at} operator link open {link}" for link in second_reader.READERS.values()]


def _closing(at):
    """Lines that close and open the link of each reader, with link reports of all members before, between and
    after."""
    lines = [f"{at} operator link list"]
    for reader, link in second_reader.READERS.items():
        lines += [f"{at} operator link close {link}", f"{at + 0.2} operator link list", f"{at + 0.2} operator link open {link}", f"{at + 0.4} operator link list"]
        at += 0.5
    return lines


def _dying(at):
    """Lines that kill each reader, with link reports of all members before, and after the death while the
    network waits for its recovery plan; then all members are brought up again."""
    lines = []
    for reader in second_reader.READERS:
        lines += [f"{at} operator link list", f"{at + 0.1} fault kill {reader.lower()}", f"{at + 0.3} operator link list", *_up(at + 1.5)]
        at += 2.5
    return [*lines, f"{at} operator link list", f"{at + 0.1} operator shutdown"]


# With two nodes, JOYSTICK and MANIPULATOR are on the second computer and SHADOW is on the first, so each computer has a reader of the port.
WAYS = {
    "shm": ("--links", "shm"),
    "udp": ("--links", "udp"),
    "udp-nodes": ("--links", "udp", "--nodes", "2"),
    "image": ("--form", "image"),
}


def fly(root, directory, *options):
    directory.mkdir()
    scenario = flying.write_scenario(directory / "readers.scn", *_up(0.0), *_closing(1.0), *_dying(3.0))
    flight = second_reader.fly(root, directory / "run", scenario, *options)
    if "image" in options:  # In the image a life ends without the end of a process.
        assert flight.code == 0, flight.transcript()
    else:
        # A death makes the run fail; no other failure is permitted.
        assert "ended by signal 9" in flight.output, flight.transcript()
    assert "FAILED" not in flight.console, flight.transcript()
    return flight


def _intervals(reported, number, reader):
    """Samples that a reader received from its link between two link reports, and whether the other link was
    closed: (end_ns, samples, cycles, is_away)."""
    other = next(link for link in LINKS if link != number)
    mine = [(time_ns, rows[number][2]) for time_ns, apid, rows in reported if apid == APIDS[reader] and number in rows]
    theirs = [(time_ns, other in rows) for time_ns, apid, rows in reported if apid == APIDS["JOYSTICK"]]
    for (before_ns, before), (after_ns, after) in zip(mine, mine[1:]):
        # Otherwise the link was opened again in between.
        if after >= before and after_ns - before_ns <= TOGETHER_NS:
            is_away = any(not is_there for at_ns, is_there in theirs if before_ns <= at_ns <= after_ns + REPORTS_NS)
            yield after_ns, after - before, (after_ns - before_ns) // CYCLE_NS, is_away


def _epochs(flight):
    """Epochs of every TC[130,6] that a reader received."""
    return [raw[13:17] for _, direction, raw in flight.packets if direction == "TC" and raw[7:9] == b"\x82\x06" and raw[0] & 7 == 0 and raw[1] in (16, 18)]


@pytest.mark.parametrize("way", WAYS)
def test_a_reader_loses_no_sample_while_the_other_reader_closes_its_link_dies_and_restarts(root, directory, way):
    if "nodes" in way and os.geteuid() != 0:
        pytest.skip("network namespaces need root")
    judge(fly(root, directory, *WAYS[way]))


def judge(flight):
    """Expect that both readers of a flight have every sample of the cycles in which their link was open."""
    reported = _lists(flight)
    for time_ns, apid, rows in reported:
        for number, (_, _, _, lost, late) in rows.items():
            assert lost == 0, f"link {number} at {time_ns / 1e9} s of {apid}"
            assert late == 0 or time_ns > FIRST_DEATH_NS, f"link {number} at {time_ns / 1e9} s of {apid}"
    for number, reader in LINKS.items():
        intervals = list(_intervals(reported, number, reader))
        for end_ns, samples, cycles, _ in intervals:
            assert abs(samples - cycles) <= 1, f"{reader}: {samples} samples in {cycles} cycles before {end_ns / 1e9} s"
        assert sum(is_away for *_, is_away in intervals) >= 2, f"{reader}: expected an interval with the other link closed, and one with the other reader dead"
    opened = _epochs(flight)
    assert len(opened) == len(set(opened)) >= 8, "fewer than 8 openings, or two openings with one epoch"
    flying.assert_clean(flight)
