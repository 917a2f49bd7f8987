# SPDX-License-Identifier: Apache-2.0
"""Damage to a journal between two flights: in the second flight an event reports it. If it is the journal of the
supervisor, the damaged file is kept and the mission enters its fallback mode. A third flight reports no damage."""

import signal
import subprocess

import flying
import pytest
import station as stations
from hirosco_gse import packets

EVENT = "event=90"  # JOURNAL_DAMAGED has this number in every component.
CODE = b"step(1)"


def _flip(path):
    octets = bytearray(path.read_bytes())
    octets[60] ^= 1
    path.write_bytes(octets)


def _zero(path):
    path.write_bytes(bytes(path.stat().st_size))


def _cut(path):
    octets = path.read_bytes()
    path.write_bytes(octets[: len(octets) // 2])


def _fly(directory, storage, act):
    """Reports of damage by the supervisor and the manipulator, and whether the mode has changed."""
    flight = stations.launch(directory, "--storage", storage)
    ground = stations.Station(flight, stations.Notes())
    try:
        act(ground)
    finally:
        ground.close()
        flight.process.send_signal(signal.SIGINT)
        assert flight.wait().code == 0, flight.transcript()
    lines = subprocess.run([flying.ROOT / "build/bin/pusdump", directory / "packets.log"], check=True, capture_output=True, text=True).stdout
    reported = {apid: [line for line in lines.splitlines() if f" TM {apid} " in line and EVENT in line.split()] for apid in (1, 16)}
    return reported, any(" TM 1 " in line and "[131,2]" in line for line in lines.splitlines())


def _load(ground):
    for name in ("FIRST", "SECOND"):
        ground.do("SUPERVISOR", 18, 1, obcp_id=name, obcp_code=CODE.hex(), checksum=packets.crc16(CODE))


def _names(ground):
    return sorted(entry["obcp_id"] for entry in ground.ask("SUPERVISOR", 18, 8)["n"])


@pytest.mark.parametrize("damage", [_flip, _zero, _cut], ids=["a bit flipped", "zeros", "cut"])
def test_a_damaged_journal_is_reported(tmp_path, damage):
    storage, found = tmp_path / "storage", []
    reported, is_changed = _fly(tmp_path / "1", storage, _load)
    assert reported == {1: [], 16: []} and not is_changed
    journal = storage / "SUPERVISOR.journal.0"
    damage(journal)
    octets = journal.read_bytes()
    reported, is_changed = _fly(tmp_path / "2", storage, lambda ground: found.extend(_names(ground)))
    assert len(reported[1]) == 1 and "[5,4]" in reported[1][0] and not reported[16]
    assert is_changed and len(found) < 2
    assert (storage / "SUPERVISOR.journal.0.damaged.0").read_bytes() == octets
    reported, is_changed = _fly(tmp_path / "3", storage, _names)
    assert reported == {1: [], 16: []} and not is_changed


def test_a_subsystem_reports_damage_of_its_own_journal(tmp_path):
    storage = tmp_path / "storage"
    _fly(tmp_path / "1", storage, lambda ground: ground.do("MANIPULATOR", 12, 15))
    _zero(storage / "MANIPULATOR.journal.0")
    reported, is_changed = _fly(tmp_path / "2", storage, _names)
    assert not reported[1] and len(reported[16]) == 1 and "[5,3]" in reported[16][0] and not is_changed
    reported, _ = _fly(tmp_path / "3", storage, _names)
    assert reported == {1: [], 16: []}
