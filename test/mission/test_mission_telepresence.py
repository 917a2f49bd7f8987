# SPDX-License-Identifier: Apache-2.0
"""Telepresence in both forms and with two seeds: figures of each flight, and equality of the logs of repeated flights."""

import flying
import numpy as np
import pytest
from hirosco_gse import figures

FLIGHTS = [("processes", 1), ("image", 1), pytest.param("processes", 2, marks=pytest.mark.long), ("image", 2)]
# The logs of both forms are equal (test_forms_give_identical_logs), and so are the figures computed from them.
IMAGES = [flight for flight in FLIGHTS if flight[0] == "image"]


@pytest.mark.parametrize(("form", "seed"), FLIGHTS)
class TestFlight:
    """Checks of every flight."""

    def test_ends_with_success(self, shared_flights, form, seed):
        flight = shared_flights.flight(form=form, seed=seed)
        assert flight.code == 0, flight.transcript()
        assert "failed" not in flight.output

    def test_every_step_of_the_operator_succeeded(self, shared_flights, form, seed):
        flight = shared_flights.flight(form=form, seed=seed)
        scenario = (flying.ROOT / "sim" / "scenarios" / "telepresence.scn").read_text(encoding="utf-8")
        wanted = [line for line in scenario.splitlines() if line.split()[1:2] == ["operator"] and line.split()[0] != "#"]
        log = flight.read("operator.log").splitlines()
        assert len(log) == len(wanted), flight.transcript()
        assert not [line for line in log if "FAILED" in line]

    def test_leaves_nothing_behind(self, shared_flights, form, seed):
        flying.assert_clean(shared_flights.flight(form=form, seed=seed))


@pytest.mark.parametrize(("form", "seed"), IMAGES)
class TestFigures:
    """Figures of the flights of the image, from their raw logs."""

    @pytest.mark.parametrize("name", figures.BOUNDS)
    def test_each_figure_is_within_its_bound(self, shared_flights, form, seed, name):
        found, reasons = shared_flights.computed(form=form, seed=seed)
        relation, bound = figures.BOUNDS[name]
        assert figures.holds(name, found[name]), f"{name} = {found[name]}, wanted {relation} {bound}: {reasons.get(name)}"

    def test_all_members_react_to_each_unplug(self, shared_flights, form, seed):
        found, _ = shared_flights.computed(form=form, seed=seed)
        assert found["unplugs"] == 2
        assert found["unplug_members_reported"] is True

    def test_figures_are_computed_from_enough_data(self, shared_flights, form, seed):
        found, _ = shared_flights.computed(form=form, seed=seed)
        assert found["latency_forward_significance"] >= 20
        assert found["latency_back_significance"] >= 20
        assert found["tracking_periods"] >= 3
        assert found["tracking_frequency_hz"] == pytest.approx(0.5, abs=0.01)
        assert found["engagements"] >= 4
        assert found["torque_limits_exceeded"] == 1

    def test_no_event_reports_a_loss_of_passivity(self, shared_flights, form, seed):
        found = [decoded for _, _, decoded in shared_flights.run(form=form, seed=seed).reports_of("event")]
        assert found and not [decoded for decoded in found if decoded["event"] == "PASSIVITY"]


def test_bounds_are_those_of_the_specification():
    wanted = {
        "latency_forward_cycles": ("<=", 2),
        "latency_back_cycles": ("<=", 2),
        "tracking_error": ("<", 0.01),
        "reflection_error": ("<", 0.01),
        "reflection_error_contour": ("<", 0.01),
        "hold_motion_rad": ("<", 0.001),
        "contact_share": (">=", 0.99),
        "contact_force_max_n": ("<=", 25),
        "brake_drop_rad": ("<", 0.001),
        "engagement_step_rad": ("<", 0.001),
        "link_lost": ("<=", 0),
        "unplug_reaction_s": ("<=", 0.005),
        "torque_limit_reaction_cycles": ("<=", 2),
        "free_drag_nm": ("<=", 0.015),
        "press_ripple_nm": ("<=", 0.5),
        "passivity_local_j": (">=", -1e-4),
    }
    assert wanted == figures.BOUNDS


def _first_difference(one, other):
    for number, (a, b) in enumerate(zip(one.splitlines(), other.splitlines()), 1):
        if a != b:
            return f"line {number}: {a[:160]!r} against {b[:160]!r}"
    return f"{len(one)} against {len(other)} octets"


def _assert_equal(one, other):
    for name in flying.TRACED:
        a, b = one.octets(name), other.octets(name)
        if a != b:
            pytest.fail(f"{name} of {one.directory.name} and {other.directory.name}: {_first_difference(a, b)}")


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_forms_give_identical_logs(shared_flights, seed):
    _assert_equal(shared_flights.flight(form="processes", seed=seed), shared_flights.flight(form="image", seed=seed))


@pytest.mark.parametrize("form", ["processes", "image"])
def test_two_runs_of_one_seed_give_identical_logs(shared_flights, form):
    _assert_equal(shared_flights.flight(form=form), shared_flights.flight(form=form, again=1, report="yes"))


def test_truth_of_one_seed_is_identical_too(shared_flights):
    assert shared_flights.flight().octets("truth.lcm") == shared_flights.flight(again=1, report="yes").octets("truth.lcm")


def test_another_seed_differs_in_sensor_noise(shared_flights):
    one, other = shared_flights.flight(form="image", seed=1), shared_flights.flight(form="image", seed=2)
    for name in flying.BUS_LOGS:
        assert one.octets(name) != other.octets(name)
    # At rest with engaged brakes: two seeds differ only in the noise, which has the same standard deviation.
    start, end = 2000 * 5, 2000 * 6
    first = [shared_flights.run(form="image", seed=1).joint_tpdo[joint]["torque"][start:end].astype(float) for joint in range(2)]
    second = [shared_flights.run(form="image", seed=2).joint_tpdo[joint]["torque"][start:end].astype(float) for joint in range(2)]
    for a, b in zip(first, second):
        assert not np.array_equal(a, b)
        assert 0 < a.std() < 1.5 * b.std() and b.std() < 1.5 * a.std()
        assert abs(np.corrcoef(a, b)[0, 1]) < 0.2
