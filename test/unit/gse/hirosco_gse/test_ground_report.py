# SPDX-License-Identifier: Apache-2.0
"""The report: complete for a flight, and made from any incomplete one."""

import hashlib
import json
import re
import shutil

import pytest
from hirosco_gse import figures, report


@pytest.fixture(scope="module")
def written(flight_folder, dictionary_path, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    for path in flight_folder.iterdir():
        shutil.copy(path, folder)
    assert report.main([str(folder), str(dictionary_path)]) == 0
    return folder


def test_run_json_is_complete(written):
    facts = json.loads((written / "run.json").read_text())
    assert facts["seed"] == 1  # the launcher's facts stay
    for name in figures.BOUNDS:
        assert isinstance(facts[name], (int, float)), name
    assert facts["figures_hold"] is True
    for name in ("packets.log", "can-robot.log", "can-joystick.log", "truth.lcm"):
        assert facts["sha256"][name] == hashlib.sha256((written / name).read_bytes()).hexdigest()
    assert facts["interface_hash"].startswith("0x")
    assert facts["versions"]["numpy"]


def test_page_holds_everything_it_shows(written):
    page = (written / "report.html").read_text()
    assert not re.findall(r'(?:src|href)=["\'](?!data:)', page)
    assert page.count("<img") == page.count("data:image/png;base64,") == len(report_pngs(written))
    for name in figures.BOUNDS:
        assert name in page
    assert "flown to the end; all figures hold" in page


def report_pngs(folder):
    return sorted(folder.glob("*.png"))


def test_every_plot_is_a_png_beside(written):
    names = {path.stem for path in report_pngs(written)}
    assert names == {"scene", "states", "positions", "torques", "contact", "links", "bus_load"}
    for path in report_pngs(written):
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 10_000


@pytest.mark.parametrize("kept", [[], ["run.json"], ["packets.log"], ["can-robot.log", "run.json"], ["truth.lcm"], ["can-joystick.log", "packets.log"]])
def test_a_report_is_made_of_an_incomplete_run(flight_folder, dictionary_path, tmp_path, kept):
    for name in kept:
        octets = (flight_folder / name).read_bytes()
        (tmp_path / name).write_bytes(octets if name == "run.json" else octets[: len(octets) // 3 + 1])
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert json.loads((tmp_path / "run.json").read_text())["tracking_error"] is None
    assert "</html>" in (tmp_path / "report.html").read_text()


def test_a_crash_is_reported(flight_folder, dictionary_path, tmp_path):
    facts = {"mission": "rokviss", "scenario": "telepresence", "exit_code": 7, "exit_reason": "manipulator <crashed>"}
    (tmp_path / "run.json").write_text(json.dumps(facts))
    (tmp_path / "can-robot.log").write_text("garbage\n")
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    page = (tmp_path / "report.html").read_text()
    assert "manipulator &lt;crashed&gt;" in page
    assert "can-robot.log" in page
    facts = json.loads((tmp_path / "run.json").read_text())
    assert facts["figures_hold"] is False
    assert facts["report_problems"]


def test_a_figure_out_of_its_bound_fails_the_run(flight_folder, dictionary_path, tmp_path, monkeypatch):
    for path in flight_folder.iterdir():
        shutil.copy(path, tmp_path)
    name = next(iter(figures.BOUNDS))
    monkeypatch.setitem(figures.BOUNDS, name, (">=", 1e9))
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_FAILED == 3
    facts = json.loads((tmp_path / "run.json").read_text())
    assert facts["exit_code"] == 1
    assert facts["exit_reason"] == f"figures out of their bounds: {name}"
    assert f"figures out of their bounds: {name}" in (tmp_path / "report.html").read_text()


def test_another_scenario_is_not_measured_by_these_figures(tmp_path, dictionary_path):
    (tmp_path / "run.json").write_text(json.dumps({"scenario": "commissioning", "exit_code": 0}))
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert "figures_hold" not in json.loads((tmp_path / "run.json").read_text())
    assert "<h2>Figures</h2>" not in (tmp_path / "report.html").read_text()


def test_no_folder(tmp_path, capsys):
    assert report.main([str(tmp_path / "none")]) == 1
    assert report.main([]) == 1
    assert "usage" in capsys.readouterr().err


def test_without_a_dictionary(flight_folder, tmp_path):
    shutil.copy(flight_folder / "can-robot.log", tmp_path)
    shutil.copy(flight_folder / "packets.log", tmp_path)
    assert report.main([str(tmp_path), str(tmp_path / "none.json")]) == 0
    assert "run make" in (tmp_path / "report.html").read_text()
