# SPDX-License-Identifier: Apache-2.0
"""A whole mission under random telecommands: no invariant is violated, the flight depends on its seed only, and each
planted fault is found. The flight without a fault uses the image of the sanitizer build if there is one."""

import collections
import subprocess

import pytest
import random_flight
from database_reading import check
from flat_xtce import Flattened
from hirosco_gse import packets
from hirosco_gse.dictionary import Dictionary

SANITIZED = random_flight.ROOT / "build/sanitize/random-flight/image"
COUNT = 2000
SEED = 1
COMPARED = 1500  # Number of reports that are compared; the library reads about 300 in a second.
LONG_COUNT, LONG_FLIGHTS = 20000, 50

pytestmark = pytest.mark.skipif(not random_flight.PROGRAM.exists(), reason="not built: make random-flight")


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Directory and counts of a flight without a fault."""
    out = tmp_path_factory.mktemp("random-flight")
    return out, random_flight.fly(SEED, COUNT, out, SANITIZED if SANITIZED.exists() else random_flight.PROGRAM, keep=True)


def test_no_telecommand_violates_an_invariant(flown):
    _, counts = flown
    assert counts["sent"] == COUNT
    assert counts["followed"] > COUNT * 3 // 4
    # Telecommands are accepted and refused, and subsystems operate with links meanwhile.
    assert min(counts["accepted"], counts["refused"]) > COUNT // 5, counts
    assert counts["linked_cycles"] > 100, counts


def test_reports_of_all_services_read_the_same_by_the_database(flown):
    """The generated XTCE file, read by space_packet_parser, gives the values of the ground segment, also for the reports that
    random telecommands cause."""
    out, _ = flown
    generated = random_flight.ROOT / "build/generated" / random_flight.MISSION
    dictionary = Dictionary.load(generated.with_suffix(".json"))
    definition = Flattened(generated.with_suffix(".xtce.xml")).definition(out)
    lines = [line.split() for line in (out / str(SEED) / "packets.log").read_text().splitlines()]
    reports = [packets.parse(bytes.fromhex(octets)) for _, direction, octets in lines if direction == "TM"]
    compared = collections.Counter()
    for packet in reports[:COMPARED]:
        compared[packet.message] += check(definition, packet, dictionary)
    assert sum(compared.values()) > 0.9 * min(len(reports), COMPARED), compared
    assert sum(count > 0 for count in compared.values()) > 15, compared


def lines_until_ground_is_silent(directory):
    """Lines of the packet log of a flight up to its last telecommand of the ground user."""
    lines = (directory / "packets.log").read_text().splitlines()
    ours = [at for at, line in enumerate(lines) if line.split()[1] == "TC" and line.split()[2][18:22] == "0001"]  # Source.
    return lines[: ours[-1]]


def test_a_flight_depends_on_its_seed_only(flown, tmp_path):
    """A flight with fewer telecommands begins like the one with the same seed, and differently from one with another seed."""
    logs = []
    for seed in (SEED, SEED + 1):
        random_flight.fly(seed, 100, tmp_path, keep=True)
        logs.append(lines_until_ground_is_silent(tmp_path / str(seed)))
    whole = lines_until_ground_is_silent(flown[0] / str(SEED))
    assert len(logs[0]) > 200
    assert logs[0] == whole[: len(logs[0])]
    assert logs[1] != whole[: len(logs[1])]


@pytest.mark.parametrize(
    "fault, found",
    [
        ("order", "(before == STATE_SAFE_OPERATIONAL)"),
        ("links", "cycles_linkless <= LINKLESS_CYCLES"),
        ("brakes", "is_braked"),
        ("assertion", "assertion at faults.c"),
        ("epoch", "session->epoch > seen.last_epoch"),
        ("counters", "counters->tc_forbidden"),
        ("pool", "_is_consistent"),
        ("backlog", "ground_backlog_is_consistent"),
        ("twice", "report TM[1,2]"),
        ("answers", "telecommands without an answer"),
    ],
)
def test_a_planted_fault_is_found(tmp_path, fault, found):
    with pytest.raises(AssertionError, match="seed 1") as caught:
        random_flight.fly(SEED, COUNT if fault == "links" else 200, tmp_path, fault=fault)
    assert found in str(caught.value)
    if fault not in ("answers", "order", "pool", "backlog"):  # These are found before the first telecommand, or at the end.
        assert " TC 18" in str(caught.value), "expected the last telecommands"


def test_a_flight_that_does_not_end_is_stopped_and_reported(tmp_path, monkeypatch):
    def run(words, timeout, **_):
        raise subprocess.TimeoutExpired(words, timeout, output=b"the flight begins\n")  # As subprocess.run: octets.

    monkeypatch.setattr(random_flight.subprocess, "run", run)
    with pytest.raises(AssertionError, match="did not end within 60 s of wall-clock time") as caught:
        random_flight.fly(SEED, COUNT, tmp_path, timeout_s=60)
    assert "the flight begins" in str(caught.value)
    assert f"--seed {SEED} --count {COUNT}" in str(caught.value)


def test_requests_of_all_services_are_in_the_pool(tmp_path):
    assert random_flight.write_pool(tmp_path / "pool") > 800
    octets = (tmp_path / "pool").read_bytes()
    services, at = set(), 4
    while at < len(octets):
        services.add(octets[at + 2])
        at += 6 + int.from_bytes(octets[at + 4 : at + 6], "big")
    assert services >= {2, 3, 4, 5, 6, 8, 11, 12, 13, 14, 15, 17, 18, 19, 20, 21, 22, 23, 129, 130, 131}


@pytest.mark.long
def test_a_million_telecommands_violate_no_invariant(tmp_path):
    total = sum(random_flight.fly(seed, LONG_COUNT, tmp_path)["sent"] for seed in range(1, LONG_FLIGHTS + 1))
    assert total == LONG_COUNT * LONG_FLIGHTS
