# SPDX-License-Identifier: Apache-2.0
"""Links through a relay with delay, jitter, loss and reordering, in simulated time."""

import os

import flying
import pressing
import pytest
from hirosco_gse import figures

TRACED = ("packets.log", "can-robot.log", "can-joystick.log", "truth.lcm")


def fly(directory, delay_ms, form="image", seed=1, *options, report="no"):
    flight = flying.fly(
        directory, "--scenario", "relay", "--delay", str(delay_ms), "--form", form, "--seed", str(seed), *options, report=report
    )
    assert flight.code == 0, flight.transcript()
    assert flight.facts["reproducible"] is True
    return flight


def assert_figures_hold(flight):
    """Expect that the run has succeeded: its exit code is 0, no figure is missing, and the report
    shows each figure."""
    facts = flight.facts
    assert facts["figures_missing"] == {}
    assert facts["figures_hold"] is True
    bounds = figures.bounds_of(facts)
    assert len(bounds) >= 6
    assert figures.failures(facts) == []
    page = flight.read("report.html")
    assert f"{len(bounds)} of {len(bounds)} figures hold" in page
    assert [name for name in bounds if f'title="{name}"' not in page] == []


def logs(flight):
    return [(flight.directory / name).read_bytes() for name in TRACED]


FLIGHTS = [(100, "rokviss"), *(pytest.param(*case, marks=pytest.mark.long) for case in ((20, "rokviss"), (300, "rokviss"), (100, "rokviss-20bit")))]


# With LONG=1 the processes, too: their logs are the same.
FORMS = ("image", *(("processes",) if os.environ.get("LONG") else ()))


@pytest.mark.parametrize(("delay_ms", "world"), FLIGHTS)
def test_a_flight_with_delay_holds_its_figures_and_is_the_same_in_each_form(directory, delay_ms, world):
    flown = [fly(directory / form, delay_ms, form, 1, "--world", world, report="yes" if form == "image" else "no") for form in FORMS]
    image = flown[0]
    counts = image.facts["relay"]
    for flight in flown:
        assert logs(flight) == logs(image) and flight.facts["relay"] == counts
    assert counts["round_trip_ms"] == delay_ms
    sent = counts["delayed"] + counts["lost"]
    assert sent > 210000
    assert counts["lost"] == pytest.approx(0.05 * sent, rel=0.05)
    assert counts["reordered"] > 0.25 * sent
    # The play-out buffers restore the order: no sample is stale, and only lost samples are missing.
    links = [line for line in image.read("operator.log").splitlines() if '"verb": "link", "words": ["list"]' in line]
    assert links[-1].count("late=0") == 4  # Two links, each in `text` and in `outcome`.
    assert_figures_hold(image)


def test_a_flight_with_delay_whose_figures_fail_ends_with_an_exit_code_and_a_line_for_each(directory):
    """The hand presses with 28 instead of 15 N without a limit by the arm, and the flight ends before the
    circle."""
    lines = (flying.ROOT / "sim" / "scenarios" / "relay.scn").read_text(encoding="utf-8").replace("press 15 ", "press 28 ").splitlines()
    lines.insert(lines.index(" 4.5  operator state JOYSTICK OPERATIONAL"), " 4.0  operator set MANIPULATOR.REMOTE.FORCE_LIMIT 100")
    directory.mkdir()
    scenario = directory / "relay.scn"
    kept = [line for line in lines if not line[:4].strip() or line.startswith("#") or float(line.split()[0]) < 44]
    scenario.write_text("\n".join([*kept, "44.5 operator shutdown", ""]), encoding="utf-8")
    flight = flying.fly(directory / "out", "--scenario", scenario, "--delay", "20", "--form", "image", report="yes")
    assert flight.code == 1, flight.transcript()
    facts = flight.facts
    assert facts["exit_code"] == 1
    lines = flight.output.splitlines()
    assert f"figure delay_force_peak_n <= 25: {facts['delay_force_peak_n']:.4g}" in lines, flight.transcript()
    assert facts["delay_force_peak_n"] > 25
    assert "figure delay_free_drag_nm <= 0.015: missing: the hand never did 'circle'" in lines
    assert any(line.startswith("figure delay_end_error_m <= 0.0015: missing: the hand never did 'home'") for line in lines), flight.transcript()
    for name in ("delay_force_peak_n", "delay_end_error_m", "delay_free_drag_nm"):
        assert name in facts["exit_reason"]
        assert f'title="{name}"' in flight.read("report.html")


@pytest.mark.long
@pytest.mark.parametrize("delay_ms", (20, 100, 300))
@pytest.mark.parametrize("seed", (2, 3))
@pytest.mark.parametrize("contact", ({}, {"stiffness": 2000, "shear": 1600}, {"friction": 0.1}, {"friction": 0.4}))
def test_the_figures_hold_on_other_surfaces(directory, delay_ms, seed, contact):
    world = pressing.write_world(directory, contact=contact)
    assert_figures_hold(fly(directory / "out", delay_ms, "image", seed, "--world", str(world), report="yes"))


@pytest.mark.long
@pytest.mark.parametrize(("delay_ms", "peak_n"), [(20, 25), (100, 40), (300, 50)])
@pytest.mark.parametrize("seed", (1, 2))
def test_a_wall_of_20_kn_per_m_has_its_own_bound_of_the_force_and_all_other_bounds(directory, delay_ms, peak_n, seed):
    """The force grows until the arm gives way. A stiffer wall gives more force until then (docs/control.md)."""
    world = pressing.write_world(directory, contact={"stiffness": 20000, "shear": 16000})
    options = ("--scenario", "relay", "--delay", delay_ms, "--form", "image", "--seed", seed, "--world", world)
    facts = flying.fly(directory / "out", *options, report="yes").facts
    assert facts["figures_missing"] == {}
    assert {line.split()[0] for line in figures.failures(facts)} <= {"delay_force_peak_n"}
    assert facts["delay_force_peak_n"] <= peak_n


@pytest.mark.long
def test_another_seed_loses_other_frames(directory):
    assert fly(directory / "1", 20).facts["relay"]["lost"] != fly(directory / "2", 20, seed=2).facts["relay"]["lost"]
