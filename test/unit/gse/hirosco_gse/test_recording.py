# SPDX-License-Identifier: Apache-2.0
"""The recording of a run, read without the code of the writer."""

import contextlib
import json
import struct
import sys

import numpy as np
import pytest
from hirosco_gse import recording, telemetry, truth
from hirosco_gse import run as runs
from hirosco_gse.values import Word
from recorded import Reader


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
def test_a_written_column_is_read_back(numbers, per):
    found, back = read_column(numbers)
    assert found == per
    np.testing.assert_allclose(back, numbers, rtol=0, atol=5e-7)


@pytest.fixture(scope="module")
def run(flight_directory, dictionary_path):
    return runs.load(flight_directory, dictionary_path, has_buses=False)


@pytest.fixture(scope="module")
def read(run):
    return Reader(recording.make(run, {"facts": run.facts}))


def test_the_truth_is_that_of_the_log(read, run):
    (found,) = [table for table in read.tables if table["kind"] == "truth"]
    joints = run.truth["JOINTS"]
    index = np.searchsorted(joints["time_us"], np.rint(found["t"] * 1e6).astype(int))
    assert np.diff(found["t"]).max() <= 1.001 / recording.TRUTH_HZ
    np.testing.assert_allclose(found["leaves"]["POSITION"], joints["position_rad"][index], rtol=0, atol=5e-7)
    contact = run.truth["CONTACT"]
    np.testing.assert_allclose(found["leaves"]["FORCE"], (contact["contact_force_n"] + contact["spring_force_n"])[index], rtol=0, atol=5e-7)


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


def _text(word):
    return struct.pack(">I", len(word) + 1) + word.encode() + b"\0"


def _log(*events):
    """A truth.lcm of (time [us], channel, octets after time_ns)."""
    whole = b""
    for number, (time_us, channel, body) in enumerate(events):
        data = struct.pack(">Qq", truth.types()[channel].fingerprint, time_us * 1000) + body
        whole += struct.pack(">IQQII", 0xEDA1DA01, number, time_us, len(channel), len(data)) + channel.encode() + data
    return whole


def test_a_world_without_joints_has_its_bodies_wheels_and_valves(tmp_path):
    """Rows that the log leaves out equal the rows before them; entries of a body are adjacent."""
    def base(x):
        return struct.pack(">i26d", 2, x, 0, 0, 9, 8, 7, 1, 0, 0, 0, 0, 1, 0, 0, *[0.0] * 12)

    names = struct.pack(">iiii", 0, 0, 0, 0) + struct.pack(">i", 2) + _text("satellite") + _text("client")
    (tmp_path / "truth.lcm").write_bytes(_log(
        (0, "WORLD", names), (0, "NAMES", _text("WHEEL") + struct.pack(">i", 1) + _text("W1")), (500, "BASE", base(0.0)),
        (500, "WHEEL", struct.pack(">i2d", 1, 2.5, 0.0)), (200_000, "VALVE", _text("PUSH") + b"\1"), (300_000, "VALVE", _text("PUSH") + b"\0"),
        (399_500, "BASE", base(0.0)), (400_000, "BASE", base(1.0))))
    read = Reader(recording.make(runs.Run(tmp_path, None)))
    (table,) = read.tables
    assert read.head["truth"] == {"joints": [], "bases": ["satellite", "client"], "contacts": [], "springs": [], "wheels": ["W1"], "valves": ["PUSH"]}
    assert table["t"].tolist() == pytest.approx([0.0005 + 0.02 * n for n in range(20)])
    assert table["leaves"]["BASE"][3].tolist() == [0, 0, 0, 1, 0, 0, 0, 9, 8, 7, 0, 1, 0, 0]
    assert (table["leaves"]["WHEEL"] == 2.5).all()
    assert table["leaves"]["VALVE"][:, 0].tolist() == [0] * 10 + [1] * 5 + [0] * 5


def test_a_recording_contains_all_contacts(flight_directory, dictionary_path):
    run = runs.load(flight_directory, dictionary_path, has_buses=False)
    table = run.truth["CONTACTS"]
    run.truth["CONTACTS"] = {name: column if name == "time_us" else np.concatenate([column, 2.0 * column], axis=1) for name, column in table.items()}
    (found,) = [table for table in Reader(recording.make(run)).tables if table["kind"] == "truth"]
    touches = found["leaves"]["CONTACTS"]
    assert touches.shape[1] == 12
    np.testing.assert_allclose(touches[:, 6:], 2.0 * touches[:, :6], rtol=0, atol=2e-6)
    assert np.abs(touches[:, 3:6]).max() > 1.0


def test_the_same_run_gives_the_same_octets(run):
    assert recording.make(run) == recording.make(run)


def test_a_recording_of_an_incomplete_run_has_the_parts_that_exist(tmp_path, dictionary_path, flight_directory):
    assert Reader(recording.make(runs.load(tmp_path, dictionary_path))).head["states"] == []
    (tmp_path / "operator.log").write_bytes(b"\xff\xfe\n")
    (tmp_path / "packets.ascii").write_bytes(b"")
    damaged = runs.load(tmp_path, dictionary_path)
    assert damaged.operator == []
    assert any("packet-archive-sqlite merge" in problem for problem in damaged.problems)
    (tmp_path / "truth.lcm").write_bytes((flight_directory / "truth.lcm").read_bytes())
    without = runs.Run(tmp_path, None)
    assert [table["kind"] for table in Reader(recording.make(without)).tables] == ["truth"]


def test_a_recording_says_why_there_is_no_world(tmp_path, dictionary_path):
    world = tmp_path / "bad.xml"
    world.write_text("<World>")
    (tmp_path / "run.json").write_text(json.dumps({"mission": "rokviss", "world": str(world)}))
    hello = Reader(recording.make(runs.load(tmp_path, dictionary_path))).head["hello"]
    assert hello["world"] is None and hello["world_problem"].startswith(f"{world}: no element found")


def test_a_recording_that_cannot_be_written_is_no_stack_trace(flight_directory, monkeypatch):
    """README: `python -m hirosco_gse.recording runs/... >FILE`."""
    full = open("/dev/full", "w", encoding="utf-8")
    monkeypatch.setattr(sys, "stdout", full)
    monkeypatch.setattr(recording, "make", lambda *_: bytes(100_000))
    with pytest.raises(SystemExit, match="^recording: cannot write the output: No space left on device$"):
        recording.main([str(flight_directory)])
    assert sys.stdout is not full
    with contextlib.suppress(OSError):
        full.close()
