# SPDX-License-Identifier: Apache-2.0
"""Links through a relay with delay, jitter, loss and reordering, in simulated time."""

import flying
import pressing
import pytest
from hirosco_gse import figures

TRACED = ("packets.log", "can-robot.log", "can-joystick.log", "truth.lcm")


def fly(folder, delay_ms, form="image", seed=1, *options, report="no"):
    flight = flying.fly(
        folder, "--scenario", "relay", "--delay", str(delay_ms), "--form", form, "--seed", str(seed), *options, report=report
    )
    assert flight.code == 0, flight.told()
    assert flight.facts["reproducible"] is True
    return flight


def holds(flight):
    """The run judges itself: its exit code is 0, and nothing is missing."""
    facts = flight.facts
    assert facts["figures_missing"] == {}
    assert figures.bounds_of(facts)
    assert figures.failures(facts) == []


def logs(flight):
    return [(flight.folder / name).read_bytes() for name in TRACED]


@pytest.mark.parametrize("delay_ms", (20, pytest.param(100, marks=pytest.mark.long), pytest.param(300, marks=pytest.mark.long)))
def test_a_flight_with_delay_holds_its_figures_and_is_the_same_in_both_forms(folder, delay_ms):
    first = fly(folder / "processes", delay_ms, "processes")
    second = fly(folder / "image", delay_ms, report="yes")
    assert logs(first) == logs(second)
    counts = first.facts["relay"]
    assert counts == second.facts["relay"]
    assert counts["round_trip_ms"] == delay_ms
    sent = counts["delayed"] + counts["lost"]
    assert sent > 210000
    assert counts["lost"] == pytest.approx(0.05 * sent, rel=0.05)
    assert counts["reordered"] > 0.25 * sent
    # The play-out buffers restore the order: no sample is stale, and only what was lost is missing.
    links = [line for line in first.read("operator.log").splitlines() if '"verb": "link", "words": ["list"]' in line]
    assert links[-1].count("late=0") == 4  # Two links, in `text` and in `outcome`.
    holds(second)


@pytest.mark.long
@pytest.mark.parametrize("delay_ms", (20, 100, 300))
@pytest.mark.parametrize("seed", (2, 3))
@pytest.mark.parametrize("contact", ({}, {"stiffness": 2000, "shear": 1600}, {"friction": 0.1}, {"friction": 0.4}))
def test_the_figures_hold_on_other_surfaces(folder, delay_ms, seed, contact):
    world = pressing.write_world(folder, contact=contact)
    holds(fly(folder / "out", delay_ms, "image", seed, "--world", str(world), report="yes"))


@pytest.mark.parametrize("name", ("delay_hold_oscillation_rad", "delay_force_peak_n"))
def test_a_delay_is_judged_by_the_bound_of_its_length(name):
    def bound(delay_ms):
        found = figures.bounds_of({"scenario": "sim/scenarios/relay.scn", "relay": {"round_trip_ms": delay_ms}})
        return found.get(name, (None, None))[1]

    assert bound(1) == bound(20) == bound(100) < bound(101) == bound(300)
    assert bound(301) is None
    assert figures.bounds_of({"scenario": "relay"}) == {}


def test_the_seed_selects_what_is_lost(folder):
    assert fly(folder / "1", 20).facts["relay"]["lost"] != fly(folder / "2", 20, seed=2).facts["relay"]["lost"]
