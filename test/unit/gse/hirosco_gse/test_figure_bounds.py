# SPDX-License-Identifier: Apache-2.0
"""The file of the bounds of a scenario: what it may contain, and which figures a run with it has."""

import json

import pytest
from hirosco_gse import arm_figures, figure_bounds, figures, report
from hirosco_gse import run as runs
from hirosco_gse.run_directory import ROOT
from hirosco_gse.script import Script, ScriptError


@pytest.fixture
def scenario(tmp_path):
    """A scenario of one line; scenario(text) gives it this file of bounds."""
    path = tmp_path / "mine.scn"
    path.write_text("1.0 operator ping all\n", encoding="utf-8")

    def write(text):
        (tmp_path / "mine.bounds").write_text(text, encoding="utf-8")
        return path

    return write


def test_each_line_is_a_figure_with_its_bound(scenario):
    path = scenario("# comment\n\njoint1_error_rad <= 0.002  # 2 mrad\ntool_error_m < 1e-3\njoint_range_margin >= 0\n")
    expected = {"joint1_error_rad": ("<=", 0.002), "tool_error_m": ("<", 0.001), "joint_range_margin": (">=", 0.0)}
    assert figure_bounds.of({"scenario": str(path)}) == figures.bounds_of({"scenario": str(path)}) == expected


@pytest.mark.parametrize("facts", [{}, {"scenario": ""}, {"scenario": "no-such"}, {"scenario": "no/such/directory/a.scn"}])
def test_a_scenario_without_the_file_has_no_bounds(facts):
    assert figure_bounds.of(facts) == {}


@pytest.mark.parametrize(("line", "words"), [
    ("tool_error_m", "found 'tool_error_m', expected <figure> <relation> <number>, relation <, <=, >="),
    ("tool_error_m = 1", "found 'tool_error_m = 1', expected <figure> <relation> <number>"),
    ("Tool <= 1", "found 'Tool <= 1', expected <figure>"),
    ("tool_error_m <= 1 m", "found 'tool_error_m <= 1 m', expected <figure> <relation> <number>"),
    ("tool_error_m <= one", "found 'one', expected a finite number"),
    ("tool_error_m <= nan", "found 'nan', expected a finite number"),
    ("first_m <= 2", "found 'first_m' again, expected one bound for each figure"),
])
def test_a_line_that_is_no_bound_is_refused_before_the_flight(scenario, dictionary, line, words):
    path = scenario(f"first_m <= 1\n{line}\n")
    for read in (lambda: figure_bounds.of({"scenario": str(path)}), lambda: Script.load(path, dictionary)):
        with pytest.raises((figure_bounds.BoundsError, ScriptError)) as refused:
            read()
        assert f"{path.with_suffix('.bounds')}:2: {words}" in str(refused.value)


def test_figures_of_every_module_may_have_bounds(scenario):
    """A flight of another mission has the figures that its file names, and only these; one that nothing computes is missing."""
    path = scenario("press_ripple_nm <= 1\ngoal_error_rad <= 1\nnot_known <= 1\n")
    run = runs.Run(path.parent)
    run.facts = {"mission": "mine", "scenario": str(path)}
    found, reasons = figures.compute(run)
    assert {name: found[name] for name in ("press_ripple_nm", "goal_error_rad", "not_known")} == dict.fromkeys(found, None)
    assert reasons["not_known"] == "no function computes a figure of this name for this flight"
    assert reasons["goal_error_rad"].startswith("0 arms (subsystems with GEOMETRY, LIMITS and CUR_VALUES): none; expected one")
    assert [line.split()[0] for line in figures.failures({**run.facts, **found, "figures_missing": reasons})] == ["press_ripple_nm", "goal_error_rad", "not_known"]


def test_a_run_is_not_judged_again_without_its_bounds(scenario, dictionary_path, tmp_path, capsys):
    """Otherwise a second report would make a run that has failed by its figures a success."""
    path = scenario("goal_error_rad <= 1\n")
    (tmp_path / "run.json").write_text(json.dumps({"mission": "rokviss", "scenario": str(path), "exit_code": 0}), encoding="utf-8")
    assert report.main([str(tmp_path), str(dictionary_path)]) == report.FIGURES_FAILED
    path.with_suffix(".bounds").unlink()
    assert report.main([str(tmp_path), str(dictionary_path)]) != 0
    assert f"{path.with_suffix('.bounds')}: no such file, expected the bounds by which the figures of this run were judged" in capsys.readouterr().err
    assert json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))["exit_code"] == 1


@pytest.mark.parametrize("path", sorted((ROOT / "sim" / "scenarios").glob("*.bounds")), ids=lambda path: path.stem)
def test_every_file_of_bounds_belongs_to_a_scenario_and_names_known_figures(path):
    bounds = figure_bounds.read(path)
    computed = {name for _, names in (*figures.KNOWN, *arm_figures.figures_of(bounds)) for name in names}
    assert bounds and set(bounds) <= computed
    assert path.with_suffix(".scn").exists()
    for name in bounds:
        title, unit = report.text_of(name)
        assert title != name and (unit == "" or name.endswith(f"_{unit}"))
