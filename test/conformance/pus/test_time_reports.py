# SPDX-License-Identifier: Apache-2.0
"""ST[09] of a mission whose descriptor selects CDS for its time reports."""

import shutil
import signal

import flying
import pytest
import station as stations

MISSION = "descriptors/missions/rokviss.xml"


@pytest.fixture
def day_segmented(notes, tmp_path):
    """The mission, with another format of its time reports."""
    tree = tmp_path / "tree"
    shutil.copytree(flying.ROOT / "descriptors", tree / "descriptors")
    for name in ("build", "sim", "gse"):
        (tree / name).symlink_to(flying.ROOT / name)
    text = (tree / MISSION).read_text(encoding="utf-8")
    (tree / MISSION).write_text(text.replace('power="200"', 'power="200" timeReports="CDS"', 1), encoding="utf-8")
    flight = stations.launch(tmp_path / "run", root=tree)
    ground = stations.Station(flight, notes)
    yield ground
    ground.close()
    flight.process.send_signal(signal.SIGINT)
    flight.wait()


def test_the_time_is_reported_as_cds(day_segmented):
    station = day_segmented
    station.do("SUPERVISOR", 9, 1, rate_exponential_value=0)
    since = len(station.reports)
    station.report(9, 3, apid=0, since=since)
    station.wait(lambda: sum(p.message == (9, 3) for p, _ in station.reports[since:]) >= 3, "three time reports")
    reports = [packet for packet, _ in station.reports[since:] if packet.service == 9]
    assert {packet.message for packet in reports} == {(9, 3)}
    times = [packet.time_ns for packet in reports]
    assert all(900_000_000 < later - earlier < 1_100_000_000 for earlier, later in zip(times, times[1:]))
    assert all(0 <= time_ns - station.dictionary.epoch_ns < 1_000_000 * 1_000_000_000 for time_ns in times)
