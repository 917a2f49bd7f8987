# SPDX-License-Identifier: Apache-2.0
"""Captures of a run's packets."""

import pathlib
import struct

import pytest
from hirosco_gse import cli, packets, recording

DICTIONARY = pathlib.Path(__file__).resolve().parents[4] / "build" / "generated" / "rokviss.json"


@pytest.fixture
def gse(capsys):
    """The command line: (exit code, output, errors)."""
    def call(*words):
        code = cli.main(["--dictionary", str(DICTIONARY), *map(str, words)])
        return code, *capsys.readouterr()
    return call


def test_a_capture_has_each_packet_with_its_time(gse, tmp_path):
    raws = [packets.build_tc(16, 1, 17, 1), bytes(3), packets.build_tc(17, 2, 17, 1)]
    lines = [f"{second}.{second:09d} TC {raw.hex()}\n" for second, raw in enumerate(raws)]
    # The run has ended in the middle of a line.
    (tmp_path / "packets.log").write_text("".join(lines) + "3.00000", encoding="ascii")
    assert gse("pcap", tmp_path) == (0, f"{tmp_path / 'packets.pcap'}: 3 packets\n", "")
    octets = (tmp_path / "packets.pcap").read_bytes()
    assert struct.unpack_from("<IHHiIII", octets) == (0xA1B23C4D, 2, 4, 0, 0, 65542, 147)
    at, found = 24, []
    while at < len(octets):
        second, rest, size, whole = struct.unpack_from("<IIII", octets, at)
        found.append((second, rest, octets[at + 16 : at + 16 + size]))
        assert size == whole
        at += 16 + size
    assert found == [(second, second, raw) for second, raw in enumerate(raws)]


def test_a_run_without_a_readable_packet_log_is_refused(gse, tmp_path):
    code, _, output = gse("pcap", tmp_path)
    assert code == 2 and "packets.log" in output
    (tmp_path / "packets.log").write_text("nonsense\n", encoding="ascii")
    code, _, output = gse("pcap", tmp_path)
    assert code == 2 and "packets.log:1: not a packet line" in output
    assert gse("pcap", "a", "b")[0] == 2
    (tmp_path / "packets.log").write_bytes(b"\xff\xfe\n")
    code, _, output = gse("pcap", tmp_path)
    assert code == 2 and "packets.log:1: not a packet line" in output
    assert not (tmp_path / "packets.pcap").exists()


def test_a_packet_that_the_end_of_the_log_cuts_is_left_out(gse, tmp_path):
    line = f"0.000000000 TC {packets.build_tc(16, 1, 17, 1).hex()}\n"
    (tmp_path / "packets.log").write_text(line + line[:-5], encoding="ascii")
    assert gse("pcap", tmp_path)[1] == f"{tmp_path / 'packets.pcap'}: 1 packets\n"


@pytest.mark.parametrize("words", [("mcap",), ("replay",)])
def test_a_directory_that_is_no_run_is_refused(gse, tmp_path, words):
    (tmp_path / "note.txt").write_text("no log")
    code, _, output = gse(*words, tmp_path)
    assert code == 2 and f"{tmp_path}: found no log of a flight" in output
    assert [path.name for path in tmp_path.iterdir()] == ["note.txt"]


@pytest.mark.parametrize(("content", "reason"), [
    (None, "found no run.json, expected the directory of a flight that has ended"), ("{}", "run.json: scenario: found none, expected text"),
    ("[\n]", "run.json: found '[ ]', expected an object with the facts of the flight"), ("{", "run.json: Expecting property name"),
])
def test_a_damaged_run_json_has_no_scenario_and_is_a_warning_of_the_export(gse, tmp_path, content, reason):
    (tmp_path / "packets.log").write_text("", encoding="ascii")
    if content is not None:
        (tmp_path / "run.json").write_text(content, encoding="ascii")
    code, _, output = gse("record", tmp_path)
    assert code == 2 and f"{tmp_path}: {reason}" in output
    code, _, output = gse("mcap", tmp_path)
    assert code == 0 and (f"gse: warning: {reason}" in output) == (content not in (None, "{}"))


def test_an_absent_packet_log_is_named_with_the_next_step(gse, tmp_path):
    code, _, output = gse("pcap", tmp_path)
    assert code != 0
    assert f"{tmp_path}/packets.log: No such file or directory; for a flight that was killed, make it: build/bin/packet-archive-sqlite merge {tmp_path}" in output


def test_a_recording_without_one_directory_is_a_usage_error(capsys):
    for words in ([], ["a", "b"]):
        with pytest.raises(SystemExit, match="^2$"):
            recording.main(words)
        assert capsys.readouterr().err == "usage: python3 -m hirosco_gse.recording RUN_DIR\n"


def test_no_recording_is_made_of_a_directory_that_is_no_run(tmp_path):
    with pytest.raises(SystemExit, match="found no log of a flight"):
        recording.main([str(tmp_path)])
