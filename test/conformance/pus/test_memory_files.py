# SPDX-License-Identifier: Apache-2.0
"""ST[06] by reference in flight: the supervisor's memories are loaded from files and dumped to them."""

import binascii
import random

import pytest

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
EXISTS = 0x0202
OUT_OF_RANGE = 0x0203
ADDRESS = 0x0207
PROTECTED = 0x0208
VERIFY = 0x0401

PARAMETERS, BUFFER = 1, 3  # Memories.
DIRECTORY = "/memory"
PIECE = 3000


def crc(octets):
    """CRC-16 of the standard."""
    return binascii.crc_hqx(octets, 0xFFFF)


def named(name):
    """Fields for a file of the tests."""
    return {"repository_path": DIRECTORY, "file_name": name}


@pytest.fixture(autouse=True)
def _directory(station):
    """A directory for the test, removed with its content."""
    station.do("SUPERVISOR", 23, 9, repository_path="/", directory_name=DIRECTORY[1:])
    yield
    for entry in station.ask("SUPERVISOR", 23, 12, repository_path=DIRECTORY)["n"]:
        station.do("SUPERVISOR", 23, 2, **named(entry["object_name"]))
    station.do("SUPERVISOR", 23, 10, repository_path="/", directory_name=DIRECTORY[1:])


def fill(station, octets):
    """Load the buffer with TC[6,2], whose requests contain the data."""
    for start in range(0, len(octets), PIECE):
        piece = octets[start : start + PIECE]
        area = {"start_address": start, "data": piece.hex(), "checksum": crc(piece)}
        station.do("SUPERVISOR", 6, 2, memory_id=BUFFER, n=[area])


def held(station, length):
    """Octets of the buffer."""
    areas = station.ask("SUPERVISOR", 6, 5, memory_id=BUFFER, n=[{"start_address": 0, "length": length}])["n"]
    return b"".join(bytes.fromhex(area["data"]) for area in areas)


def part(start, offset, octets, checksum=None):
    """Fields of an area that is loaded by reference."""
    checksum = crc(octets) if checksum is None else checksum
    return {"start_address": start, "offset_in_file": offset, "length": len(octets), "checksum": checksum}


def test_raw_memory_is_dumped_to_a_file_and_loaded_again(station):
    octets = random.Random(6).randbytes(10000)
    fill(station, octets)
    areas = [{"start_address": 5000, "length": 5000}, {"start_address": 0, "length": 5000}]
    station.do("SUPERVISOR", 6, 20, memory_id=BUFFER, n=areas, **named("halves"))
    assert station.ask("SUPERVISOR", 23, 3, **named("halves"))["file_size"] == len(octets)
    turned = octets[5000:] + octets[:5000]
    station.do("SUPERVISOR", 6, 19, memory_id=BUFFER, n=[part(0, 0, turned[:9000]), part(9000, 9000, turned[9000:])], **named("halves"))
    assert held(station, len(octets)) == turned


def test_a_parameter_is_dumped_to_a_file_and_loaded_again(station):
    period = station.dictionary.subsystem("SUPERVISOR").parameter("ORBIT_PERIOD").parameter_id
    here = {"memory_id": PARAMETERS, "base_id": period}
    before = station.command("get", "SUPERVISOR.ORBIT_PERIOD")
    whole = station.ask("SUPERVISOR", 6, 17, **here)
    station.do("SUPERVISOR", 6, 22, **here, n=[{"offset": 0, "length": whole["length"]}], **named("period"))
    station.command("set", "SUPERVISOR.ORBIT_PERIOD", "4000000")
    area = {"offset": 0, "offset_in_file": 0, "length": whole["length"], "checksum": whole["checksum"]}
    station.do("SUPERVISOR", 6, 21, **here, n=[area], **named("period"))
    assert station.command("get", "SUPERVISOR.ORBIT_PERIOD") == before


def test_faulty_memory_file_requests_are_refused(station):
    octets = bytes(range(100))
    fill(station, octets)
    station.do("SUPERVISOR", 6, 20, memory_id=BUFFER, n=[{"start_address": 0, "length": 100}], **named("a"))
    again = {"memory_id": BUFFER, "n": [{"start_address": 0, "length": 100}]}
    station.refuse(EXISTS, "SUPERVISOR", 6, 20, **again, **named("a"))
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 6, 20, **again, repository_path="/..", file_name="a")
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 6, 19, memory_id=BUFFER, n=[part(0, 0, octets)], **named("b"))
    station.refuse(OUT_OF_RANGE, "SUPERVISOR", 6, 19, memory_id=BUFFER, n=[part(0, 1, octets)], **named("a"))
    station.refuse(ADDRESS, "SUPERVISOR", 6, 19, memory_id=BUFFER, n=[part(131071, 0, octets)], **named("a"))
    station.do("SUPERVISOR", 6, 15, memory_id=BUFFER)
    station.refuse(PROTECTED, "SUPERVISOR", 6, 19, memory_id=BUFFER, n=[part(0, 0, octets)], **named("a"))
    station.do("SUPERVISOR", 6, 16, memory_id=BUFFER)


def test_an_area_with_a_wrong_checksum_is_not_loaded(station):
    octets = bytes(range(200))
    fill(station, octets)
    station.do("SUPERVISOR", 6, 20, memory_id=BUFFER, n=[{"start_address": 0, "length": 200}], **named("a"))
    fill(station, bytes(200))
    areas = [part(0, 0, octets[:100], checksum=crc(octets[:100]) ^ 1), part(100, 100, octets[100:])]
    outcome = station.refuse(VERIFY, "SUPERVISOR", 6, 19, memory_id=BUFFER, n=areas, **named("a"))
    assert (outcome.failure.instruction, outcome.failure.detail) == (1, crc(octets[:100]))
    assert held(station, 200) == bytes(100) + octets[100:]


def test_gse_commands_upload_and_download_files(station, tmp_path):
    octets = random.Random(7).randbytes(40000)
    (tmp_path / "up").write_bytes(octets)
    (tmp_path / "empty").write_bytes(b"")
    station.command("file", "upload", tmp_path / "up", f"{DIRECTORY}/up")
    station.command("file", "upload", tmp_path / "empty", f"{DIRECTORY}/empty")
    assert {line.split()[1] for line in station.command("file", "list", DIRECTORY).splitlines()} == {"up", "empty"}
    for name, expected in (("up", octets), ("empty", b"")):
        station.command("file", "download", f"{DIRECTORY}/{name}", tmp_path / "down")
        assert (tmp_path / "down").read_bytes() == expected
    station.command("file", "delete", f"{DIRECTORY}/up")
    assert "up" not in station.command("file", "list", DIRECTORY)
