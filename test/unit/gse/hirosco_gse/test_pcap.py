# SPDX-License-Identifier: Apache-2.0
"""Captures of a run's packets."""

import pathlib
import struct

import pytest
from hirosco_gse import cli, packets

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
    assert not (tmp_path / "packets.pcap").exists()
