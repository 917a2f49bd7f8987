# SPDX-License-Identifier: Apache-2.0
"""The recording of a run, read back without the writer's own code."""

import gzip
import json
import struct

import numpy as np
import pytest
from hirosco_gse import recording, telemetry
from hirosco_gse import run as runs
from hirosco_gse.values import Word


class Reader:
    def __init__(self, octets):
        whole = gzip.decompress(octets)
        (size,) = struct.unpack_from("<I", whole)
        self.head, self._rest = json.loads(whole[4 : 4 + size]), whole[4 + size :]
        self.tables = []
        for about in self.head["tables"]:
            times = self._column(about["rows"], about["per"])
            leaves = {name: np.array([self._column(about["rows"], per) for per in pers]).T for name, pers in about["leaves"]}
            self.tables.append({**about, "t": times, "leaves": leaves})
        assert not self._rest

    def _column(self, rows, per):
        width = 8 if per is None else 4
        planes, self._rest = self._rest[: width * rows], self._rest[width * rows :]
        octets = np.frombuffer(planes, np.uint8).reshape(width, rows).T.copy()
        if per is None:
            return octets.view("<f8").ravel()
        coded = octets.view("<u4").ravel().astype(np.int64)
        total = np.cumsum((coded >> 1) ^ -(coded & 1))
        whole = (total + 2**31) % 2**32 - 2**31
        return np.where(whole == -(2**31), np.nan, whole / per)


def read_column(numbers):
    per, octets = recording.column(numbers)
    reader = Reader.__new__(Reader)
    reader._rest = octets
    return per, reader._column(len(numbers), per)


@pytest.mark.parametrize(
    ("numbers", "per"),
    [
        ([], 1),
        ([0, 1, -1, 2**31 - 2, -(2**31) + 2], 1),
        ([0.5, -0.25, 1e-6, 2147.0], 1_000_000),
        ([1.5, np.nan, -1.5, np.nan, np.nan, 2000.25], 1_000_000),
        ([2**31, 0], None),
        ([0.1, 1e9], None),
        ([1.0, np.inf, np.nan], None),
    ],
)
def test_a_column_comes_back(numbers, per):
    found, back = read_column(numbers)
    assert found == per
    np.testing.assert_allclose(back, numbers, rtol=0, atol=5e-7)


@pytest.fixture(scope="module")
def run(flight_folder, dictionary_path):
    return runs.load(flight_folder, dictionary_path, has_buses=False)


@pytest.fixture(scope="module")
def read(run):
    return Reader(recording.make(run, {"facts": run.facts}))


def test_the_truth_is_that_of_the_log(read, run):
    (truth,) = [table for table in read.tables if table["kind"] == "truth"]
    joints = run.truth["JOINTS"]
    index = np.searchsorted(joints["time_us"], np.rint(truth["t"] * 1e6).astype(int))
    assert np.diff(truth["t"]).max() <= 1.001 / recording.TRUTH_HZ
    np.testing.assert_allclose(truth["leaves"]["POSITION"], joints["position_rad"][index], rtol=0, atol=5e-7)
    contact = run.truth["CONTACT"]
    np.testing.assert_allclose(truth["leaves"]["FORCE"], (contact["contact_force_n"] + contact["spring_force_n"])[index], rtol=0, atol=5e-7)


def test_the_telemetry_is_that_of_the_log(read, run):
    reported = [(time_ns, packet.apid, decoded) for time_ns, packet, decoded in run.reports_of("housekeeping")]
    tables = [table for table in read.tables if table["kind"] == "housekeeping"]
    assert sum(table["rows"] for table in tables) == len(reported)
    kept = {(table["structure"], leaf) for table in tables for leaf in table["leaves"]}
    assert kept == {(decoded["structure"], leaf) for _, _, decoded in reported for leaf in telemetry.leaves(decoded["values"])}
    assert any(isinstance(value[0], Word) for _, _, decoded in reported for value in telemetry.leaves(decoded["values"]).values())
    assert [[row[0], row[1], row[3]] for row in read.head["events"]] == [
        [pytest.approx(time_ns / 1e9, abs=1e-6), run.dictionary.name_of_apid(packet.apid), decoded["event"]]
        for time_ns, packet, decoded in run.reports_of("event")
    ]
    for name, history in run.states().items():
        rows = [row for row in read.head["states"] if row[1] == name]
        kept = [(row[0], row[2]) for n, row in enumerate(rows) if n == 0 or row[2] != rows[n - 1][2]]
        assert kept == [(pytest.approx(time), state) for time, state in history]


def test_phases_follow_each_other(read):
    phases = read.head["phases"]
    assert all(before[1] == after[0] for before, after in zip(phases, phases[1:]))
    assert any(words.startswith("unplug") for _, _, words in phases)


def test_the_same_run_gives_the_same_octets(run):
    assert recording.make(run) == recording.make(run)


def test_a_recording_is_made_of_what_there_is(tmp_path, dictionary_path, flight_folder):
    assert Reader(recording.make(runs.load(tmp_path, dictionary_path))).head["states"] == []
    (tmp_path / "truth.lcm").write_bytes((flight_folder / "truth.lcm").read_bytes())
    without = runs.Run(tmp_path, None)
    assert [table["kind"] for table in Reader(recording.make(without)).tables] == ["truth"]
