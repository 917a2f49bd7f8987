# SPDX-License-Identifier: Apache-2.0
"""ST[23] in flight: files and directories below the root, locks, searches and copies."""

import pytest
from hirosco_gse import packets

# Failure codes of ST[01].
UNKNOWN_ID = 0x0201
EXISTS = 0x0202
STATE = 0x0204
IO = 0x0404
ABORTED = 0x0405

DIRECTORY = "/tests"


@pytest.fixture(autouse=True)
def _directory(station):
    """A directory for the test, removed with its content."""
    station.do("SUPERVISOR", 23, 9, repository_path="/", directory_name="tests")
    yield
    for _ in range(3):
        _empty(station, DIRECTORY)
    station.do("SUPERVISOR", 23, 10, repository_path="/", directory_name="tests")


def _empty(station, path):
    for entry in station.ask("SUPERVISOR", 23, 12, repository_path=path)["n"]:
        name = entry["object_name"]
        if entry["object_type"] == "directory":
            _empty(station, f"{path}/{name}")
            station.do("SUPERVISOR", 23, 10, repository_path=path, directory_name=name)
        else:
            station.settle(station.send("SUPERVISOR", 23, 6, repository_path=path, file_name=name))
            station.do("SUPERVISOR", 23, 2, repository_path=path, file_name=name)


def _create(station, name, path=DIRECTORY):
    station.do("SUPERVISOR", 23, 1, repository_path=path, file_name=name, maximum_size=4096, file_locked_status=0)


def _names(station, path=DIRECTORY):
    return {entry["object_name"]: entry["object_type"] for entry in station.ask("SUPERVISOR", 23, 12, repository_path=path)["n"]}


def _file(name, path=DIRECTORY):
    return {"repository_path": path, "file_name": name}


def test_files_are_created_and_deleted(station):
    _create(station, "a")
    about = station.ask("SUPERVISOR", 23, 3, **_file("a"))
    assert (about["repository_path"], about["file_name"], about["file_size"]) == (DIRECTORY, "a", 0)
    station.refuse(EXISTS, "SUPERVISOR", 23, 1, **_file("a"), maximum_size=1, file_locked_status=0)
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 23, 3, **_file("b"))
    station.do("SUPERVISOR", 23, 2, **_file("a"))
    assert _names(station) == {}


@pytest.mark.parametrize("path", ["/..", "/../..", "/tests/../..", "/./tests", "//etc"])
def test_no_path_leads_out_of_the_root(station, path):
    outcome = station.settle(station.send("SUPERVISOR", 23, 3, repository_path=path, file_name="passwd"))
    assert outcome.failure is not None and 7 not in outcome.stages


@pytest.mark.parametrize("name", ["..", ".", "", "a/b", "*", "x" * 300, "a\0b"])
def test_an_invalid_file_name_is_refused(station, name):
    outcome = station.settle(station.send("SUPERVISOR", 23, 1, **_file(name), maximum_size=1, file_locked_status=0))
    assert outcome.failure is not None and 7 not in outcome.stages


def test_locked_files_cannot_be_deleted(station):
    _create(station, "a")
    station.do("SUPERVISOR", 23, 5, **_file("a"))
    assert station.ask("SUPERVISOR", 23, 3, **_file("a"))["file_locked_status"] == 1
    station.refuse(STATE, "SUPERVISOR", 23, 2, **_file("a"))
    station.do("SUPERVISOR", 23, 6, **_file("a"))
    station.do("SUPERVISOR", 23, 2, **_file("a"))


def test_directories_are_made_and_renamed_but_not_deleted_while_they_contain_a_file(station):
    station.do("SUPERVISOR", 23, 9, repository_path=DIRECTORY, directory_name="inner")
    _create(station, "a", f"{DIRECTORY}/inner")
    station.refuse(STATE, "SUPERVISOR", 23, 10, repository_path=DIRECTORY, directory_name="inner")
    station.do("SUPERVISOR", 23, 11, repository_path=DIRECTORY, old_directory_name="inner", new_directory_name="outer")
    assert _names(station) == {"outer": "directory"}
    assert _names(station, f"{DIRECTORY}/outer") == {"a": "file"}


def test_search_finds_files_by_a_pattern(station):
    for name in ("one.lua", "two.lua", "three.txt"):
        _create(station, name)
    found = station.ask("SUPERVISOR", 23, 7, repository_path=DIRECTORY, search_pattern="t*.lua")
    assert found["n"] == [{"file_path": f"{DIRECTORY}/two.lua"}]


def test_copy_keeps_the_source_file_and_move_removes_it(station):
    _create(station, "a")
    paths = {"source_repository_path": DIRECTORY, "source_file_name": "a", "target_repository_path": DIRECTORY}
    station.do("SUPERVISOR", 23, 14, operation_id=1, **paths, target_file_name="b")
    station.do("SUPERVISOR", 23, 15, operation_id=2, **paths, target_file_name="c")
    assert _names(station) == {"b": "file", "c": "file"}
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 23, 14, operation_id=3, **paths, target_file_name="d")


def _large_file(flight, size):
    """A file too large to be copied at once, made outside of the flight."""
    directory = flight.directory / "storage" / "files" / DIRECTORY.strip("/")
    with (directory / "large").open("wb") as file:
        file.truncate(size)


def test_copies_are_suspended_resumed_and_aborted(station, flight):
    _large_file(flight, 60_000_000)
    paths = {"source_repository_path": DIRECTORY, "source_file_name": "large", "target_repository_path": DIRECTORY}
    station.do("SUPERVISOR", 23, 22, reporting_interval=1)
    copies = [station.send("SUPERVISOR", 23, 14, operation_id=number, **paths, target_file_name=f"copy{number}") for number in (1, 2, 3)]
    station.send("SUPERVISOR", 23, 16, n=[1])
    held = station.send("SUPERVISOR", 23, 19, repository_path=DIRECTORY)
    station.settle(held)
    since = len(station.reports)
    station.report(23, 23, since=since, where=lambda report: any(entry["operation_status"] == "on hold" for entry in report["n"]))
    station.do("SUPERVISOR", 23, 19, repository_path=DIRECTORY)
    station.do("SUPERVISOR", 23, 17, n=[1])
    station.do("SUPERVISOR", 23, 16, n=[1])
    station.do("SUPERVISOR", 23, 20, repository_path=DIRECTORY)
    station.do("SUPERVISOR", 23, 19, repository_path=DIRECTORY)
    station.do("SUPERVISOR", 23, 18, n=[1])
    station.do("SUPERVISOR", 23, 21, repository_path=DIRECTORY)
    for copy in copies:
        assert station.settle(copy).failure.code == ABORTED
    station.do("SUPERVISOR", 23, 24)
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 23, 18, n=[1])
    assert "copy1" not in _names(station)


def test_a_copy_that_fails_halfway_reports_the_step(station, flight):
    """The source becomes shorter while the copy is suspended."""
    _large_file(flight, 60_000_000)
    since = len(station.reports)
    copy = station.send(
        "SUPERVISOR", 23, 14, operation_id=9, source_repository_path=DIRECTORY, source_file_name="large",
        target_repository_path=DIRECTORY, target_file_name="copy",
    )
    station.settle(station.send("SUPERVISOR", 23, 16, n=[9]))
    _large_file(flight, 1)
    station.do("SUPERVISOR", 23, 17, n=[9])
    outcome = station.settle(copy)
    assert outcome.stages[-2:] == [6, 8] and outcome.failure.code == IO
    assert outcome.failures[0].step in (25, 50, 75, 100)
    station.report(1, 6, since=since)
    assert "copy" not in _names(station)


def test_a_sequence_is_loaded_from_a_file(station, flight):
    """The file contains the part of TC[21,1] after the identifier."""
    content = station.catalogue.encode("TC", 21, 1, {"request_sequence_id": "X", "n": [{"request": packets.build_tc(17, 1, 17, 1, source=2), "delay": 0.1}]})[8:]
    (flight.directory / "storage" / "files" / DIRECTORY.strip("/") / "wake").write_bytes(content)
    station.do("SUPERVISOR", 21, 2, request_sequence_id="WAKE", repository_path=DIRECTORY, file_name="wake")
    station.refuse(EXISTS, "SUPERVISOR", 21, 2, request_sequence_id="WAKE", repository_path=DIRECTORY, file_name="wake")
    station.refuse(UNKNOWN_ID, "SUPERVISOR", 21, 2, request_sequence_id="OTHER", repository_path=DIRECTORY, file_name="none")
    station.do("SUPERVISOR", 21, 3, request_sequence_id="WAKE")
    since = len(station.reports)
    station.do("SUPERVISOR", 21, 8, request_sequence_id="WAKE", repository_path=DIRECTORY, file_name="wake")
    station.wait(lambda: any(p.message == (17, 2) and p.apid == 17 for p, _ in station.reports[since:]), "the answer to its request")
    station.wait(lambda: station.ask("SUPERVISOR", 21, 6)["n"][0]["execution_status"] == "inactive", "the end of the sequence")
    station.do("SUPERVISOR", 21, 3, request_sequence_id="WAKE")
