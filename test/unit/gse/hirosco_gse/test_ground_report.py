# SPDX-License-Identifier: Apache-2.0
"""The report: complete for a flight, and made from any incomplete one."""

import base64
import errno
import gzip
import hashlib
import json
import re
import shutil
import types

import pytest
from hirosco_gse import figures, recording, report
from hirosco_gse import run as runs
from recorded import Reader


@pytest.fixture(scope="module")
def written(flight_directory, dictionary_path, tmp_path_factory):
    directory = tmp_path_factory.mktemp("run")
    for path in flight_directory.iterdir():
        shutil.copy(path, directory)
    assert report.main([str(directory), str(dictionary_path)]) == 0
    return directory


def test_run_json_is_complete(written):
    facts = json.loads((written / "run.json").read_text())
    assert facts["seed"] == 1  # The facts of the launcher are kept.
    for name in figures.BOUNDS:
        assert isinstance(facts[name], (int, float)), name
    assert facts["figures_hold"] is True
    for name in ("packets.log", "can-robot.log", "can-joystick.log", "truth.lcm"):
        assert facts["sha256"][name] == hashlib.sha256((written / name).read_bytes()).hexdigest()
    assert facts["interface_hash"].startswith("0x")
    assert facts["versions"]["numpy"]


@pytest.mark.parametrize(("flown", "known", "is_reported"), [("0x1A", "0x1a", False), ("0x1A", "0x1B", True), (None, "0x1B", False), ("0x1A", None, False)])
def test_a_flight_with_other_device_classes_than_the_dictionary_is_reported(flown, known, is_reported):
    run = types.SimpleNamespace(facts={"device_classes_hash": flown}, dictionary=types.SimpleNamespace(content={"device_classes_hash": known}),
                                reports_of=lambda kind: [])
    assert report.mismatches(run) == ([f"the flight had device classes {flown}, the dictionary has those of {known}: run make"] if is_reported else [])


def test_the_page_contains_everything_that_it_shows(written):
    page = (written / "report.html").read_text()
    assert not re.findall(r'(?:src|href)=["\'](?!data:)', re.sub(r"<script>.*?</script>", "", page, flags=re.S))
    assert "default-src 'none'" in page
    for name in figures.BOUNDS:
        assert name in page
    assert "flown to the end; all figures hold" in page


def test_run_json_contains_size_and_time_of_the_report(written):
    facts = json.loads((written / "run.json").read_text())["report"]
    assert facts["octets"] == (written / "report.html").stat().st_size
    assert facts["seconds"] > 0


@pytest.fixture
def built(tmp_path):
    """A page of the station as it is built, with a bundle that contains the end tag of its own element."""
    directory = tmp_path / "page"
    directory.mkdir()
    (directory / "station.js").write_text('draw("</script>");')
    (directory / "station.css").write_text('@font-face{src:url("./plex.woff2")format("woff2"),url()format("woff")}')
    (directory / "plex.woff2").write_bytes(b"wOF2")
    return directory


def test_the_page_of_the_station_and_the_recording_are_inside(flight_directory, dictionary_path, built):
    run = runs.load(flight_directory, dictionary_path)
    page = report.page(run, report.complete_facts(run), built)
    assert page.count("</script>") == page.count("<script") == 2
    assert f'url(data:font/woff2;base64,{base64.b64encode(b"wOF2").decode()})format("woff2")}}' in page
    inside = base64.b64decode(re.search(r'id="recording" type="text/plain">([^<]*)<', page)[1])
    whole = gzip.decompress(inside)
    assert b'"DEVICE_LOST", "A device does not answer any more: node STICK (0x21)"' in whole.replace(b'","', b'", "') and b'"hello"' in whole


def test_without_a_built_page_the_next_step_is_printed(flight_directory, dictionary_path, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(report, "PAGE", tmp_path / "none")
    for path in flight_directory.iterdir():
        shutil.copy(path, tmp_path)
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert f"make report OUT={tmp_path}" in capsys.readouterr().out
    page = (tmp_path / "report.html").read_text()
    assert f"make report OUT={tmp_path}" in page and "16 of 16 figures hold" in page
    assert 'class="reason"' not in page  # This class cuts text that is longer than one line.
    cells = [re.findall("<td>(.*?)</td>", row) for row in re.findall("<tr>(.*?)</tr>", page)]
    assert any("DEVICE_LOST" in row and "HIGH" in row and "A device does not answer any more: node STICK (0x21)" in row for row in cells)
    assert any(row[1:3] == ["MANIPULATOR", "OPERATIONAL"] for row in cells if len(row) == 4)
    assert any(row[1] == "set parameter values: MANIPULATOR" for row in cells if len(row) == 4)
    assert [report._outcome(lights) for lights in ("dddd", "dfee", "ddwe")] == ["done", "failed", "not known"]


@pytest.mark.parametrize(
    ("value", "bound", "unit", "words"),
    [(0.0045, 0.01, "", "0.45 1 %"), (0.00019, 0.001, "rad", "0.19 1 mrad"), (0, 0, "samples", "0 0 samples"), (-1e-6, -1e-4, "J", "−0.001 −0.1 mJ")],
)
def test_figures_are_printed_with_few_digits_in_a_readable_unit(value, bound, unit, words):
    found, limit, unit = report._in_readable_unit(value, bound, unit)
    assert f"{report._number(found)} {report._number(limit)} {unit}" == words


@pytest.mark.parametrize("kept", [["run.json"], ["packets.log"], ["can-robot.log", "run.json"], ["truth.lcm"], ["can-joystick.log", "packets.log"]])
def test_a_report_is_made_of_an_incomplete_run(flight_directory, dictionary_path, tmp_path, kept):
    for name in kept:
        octets = (flight_directory / name).read_bytes()
        (tmp_path / name).write_bytes(octets if name == "run.json" else octets[: len(octets) // 3 + 1])
    is_judged = "run.json" in kept  # It contains the scenario.
    assert report.main([str(tmp_path), str(dictionary_path)]) == (report.FIGURES_FAILED if is_judged else 0)
    assert json.loads((tmp_path / "run.json").read_text()).get("tracking_error", "absent") == (None if is_judged else "absent")
    assert "</html>" in (tmp_path / "report.html").read_text()


def test_a_crash_is_reported(flight_directory, dictionary_path, tmp_path):
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


def test_a_packet_log_that_was_cut_is_reported_with_the_number_of_packets(flight_directory, dictionary_path, tmp_path):
    """By the number in run.json, which a report of the cut log keeps."""
    for path in flight_directory.iterdir():
        shutil.copy(path, tmp_path)
    whole = report.write(tmp_path, dictionary_path)
    assert not any("packets.log" in problem for problem in whole["report_problems"])
    lines = (tmp_path / "packets.log").read_text().splitlines(keepends=True)
    (tmp_path / "packets.log").write_text("".join(lines[:10]))
    words = f"packets.log: 10 of {whole['packets']} packets are there, the last at {float(lines[9].split()[0]):.3f} s; the log was cut after the flight"
    for _ in range(2):
        assert words in report.write(tmp_path, dictionary_path)["report_problems"] and words in (tmp_path / "report.html").read_text()
    assert words in Reader(recording._made_of(tmp_path)).head["about"]["problems"]


def test_a_figure_out_of_its_bound_fails_the_run(flight_directory, dictionary_path, tmp_path, monkeypatch, capsys):
    for path in flight_directory.iterdir():
        shutil.copy(path, tmp_path)
    name = next(iter(figures.BOUNDS))
    monkeypatch.setitem(figures.BOUNDS, name, (">=", 1e9))
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_FAILED == 3
    facts = json.loads((tmp_path / "run.json").read_text())
    assert facts["exit_code"] == 1
    assert facts["exit_reason"] == f"figures missing or out of their bounds: {name}"
    assert f"figures missing or out of their bounds: {name}" in (tmp_path / "report.html").read_text()
    assert f"figure {name} >= 1e+09: {facts[name]:.4g}" in capsys.readouterr().out.splitlines()
    monkeypatch.undo()  # A later report is judged again.
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert json.loads((tmp_path / "run.json").read_text())["exit_code"] == 0


def test_a_missing_figure_fails_the_run_unless_it_was_ended_early(flight_directory, dictionary_path, tmp_path, capsys):
    for path in flight_directory.iterdir():
        if path.name != "truth.lcm":
            shutil.copy(path, tmp_path)
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_FAILED
    facts = json.loads((tmp_path / "run.json").read_text())
    assert facts["exit_code"] == 1
    assert "figure tracking_error < 0.01: missing: the hand never did 'circle'" in capsys.readouterr().out.splitlines()
    (tmp_path / "run.json").write_text(json.dumps({**facts, "cut_short": True}))
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0


def test_another_scenario_is_not_measured_by_these_figures(tmp_path, dictionary_path):
    (tmp_path / "run.json").write_text(json.dumps({"scenario": "commissioning", "exit_code": 0}))
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert "figures_hold" not in json.loads((tmp_path / "run.json").read_text())
    assert "This scenario has no figures with bounds." in (tmp_path / "report.html").read_text()


def test_a_report_that_cannot_be_made_fails_a_run_with_bounds(flight_directory, dictionary_path, tmp_path, capsys):
    """Entries of a damaged operator.log are not steps, so no report can be made: one line is printed, without
    a stack trace."""
    for path in flight_directory.iterdir():
        shutil.copy(path, tmp_path)
    (tmp_path / "operator.log").write_text("17\n")
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_UNKNOWN == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("report: not written: AttributeError: ") and "recording.py:" in line and f"make report OUT={tmp_path}" in line
    facts = json.loads((tmp_path / "run.json").read_text())
    assert (facts["exit_code"], facts["exit_reason"]) == (1, "the report could not be made, so the figures are not known")
    shutil.copy(flight_directory / "operator.log", tmp_path)
    assert report.main([str(tmp_path), str(dictionary_path)]) == 0
    assert json.loads((tmp_path / "run.json").read_text())["exit_code"] == 0


@pytest.mark.parametrize(("facts", "code"), [({"scenario": "commissioning", "exit_code": 0}, 1), ([1], 4)])
def test_a_report_that_cannot_be_written_is_an_error(tmp_path, dictionary_path, capsys, facts, code):
    (tmp_path / "run.json").write_text(json.dumps(facts))
    (tmp_path / "report.html").mkdir()
    assert report.main([str(tmp_path), str(dictionary_path)]) == code
    assert capsys.readouterr().err.startswith("report: not written: ")


def test_a_file_that_cannot_be_written_is_named_and_no_log(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "run.json"))

    monkeypatch.setattr(report, "write", full)
    assert report.main([str(tmp_path)]) == 1
    assert capsys.readouterr().err == (f"report: not written: {tmp_path}/run.json: No space left on device. "
                                       f"To try again: make report OUT={tmp_path}\n")


@pytest.mark.parametrize("content", ["[]", '"rokviss"', "{", "[" * 100_000, "\xff"])
def test_a_damaged_run_json_is_named_and_kept(flight_directory, dictionary_path, tmp_path, capsys, content):
    """The figures of the run are not known. The report overwrites run.json, so it is not made."""
    shutil.copy(flight_directory / "packets.log", tmp_path)
    (tmp_path / "run.json").write_text(content, encoding="latin-1")
    run = runs.load(tmp_path, dictionary_path)
    assert run.facts == {} and run.packets
    assert [problem for problem in run.problems if problem.startswith("run.json: ")]
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_UNKNOWN
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"report: not written: {tmp_path}: run.json: ") and line.endswith(f"delete the file and call: make report OUT={tmp_path}")
    assert (tmp_path / "run.json").read_text(encoding="latin-1") == content
    assert sorted(path.name for path in tmp_path.iterdir()) == ["packets.log", "run.json"]


def test_a_directory_that_is_no_run_is_refused_and_stays_as_it_is(tmp_path, capsys):
    (tmp_path / "letter.txt").write_text("")
    assert report.main([str(tmp_path)]) == 1
    assert capsys.readouterr().err == (f"report: not written: {tmp_path}: found no log of a flight, expected the directory of a run, with one of run.json, "
                                       "packets.log, packets.ascii, truth.lcm. Name such a directory: make report OUT=runs/...\n")
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_a_missing_directory_is_refused(tmp_path, capsys):
    assert report.main([str(tmp_path / "none")]) == 1
    assert report.main([]) == 1
    assert "usage" in capsys.readouterr().err


def test_a_report_without_a_dictionary_names_the_next_step(flight_directory, tmp_path):
    shutil.copy(flight_directory / "can-robot.log", tmp_path)
    shutil.copy(flight_directory / "packets.log", tmp_path)
    assert report.main([str(tmp_path), str(tmp_path / "none.json")]) == 0
    assert "run make" in (tmp_path / "report.html").read_text()
