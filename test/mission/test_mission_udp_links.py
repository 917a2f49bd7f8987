# SPDX-License-Identifier: Apache-2.0
"""Real-time links by UDP: hand and robot behave in the same way, the figures are the same, and the forms are
still identical."""

import flying
import pytest
from hirosco_gse import figures

UDP = {"links": "udp"}


@pytest.mark.parametrize("name", figures.BOUNDS)
def test_each_figure_is_within_its_bound(shared_flights, name):
    flight = shared_flights.flight(**UDP)
    assert flight.code == 0, flight.transcript()
    found, reasons = shared_flights.computed(**UDP)
    assert figures.holds(name, found[name]), f"{name} = {found[name]}: {reasons.get(name)}"


def test_forms_give_identical_logs(shared_flights):
    one, other = shared_flights.flight(form="processes", **UDP), shared_flights.flight(form="image", **UDP)
    assert other.code == 0, other.transcript()
    for name in flying.TRACED:
        assert one.octets(name) == other.octets(name), name


def test_frames_on_the_buses_are_equal_with_links_over_udp_and_shared_memory(shared_flights):
    """The frames on the buses are the same, octet by octet, as with links in shared memory."""
    one, other = shared_flights.flight(), shared_flights.flight(**UDP)
    for name in flying.BUS_LOGS:
        assert one.octets(name) == other.octets(name), name


def test_the_method_is_agreed_and_reported(shared_flights):
    """TM[130,4] of each link contains the method UDP; its end node is a logical name."""
    flight = shared_flights.flight(**UDP)
    accepted = [raw for _, direction, raw in flight.packets if direction == "TM" and raw[7:9] == b"\x82\x04"]
    assert accepted
    for raw in accepted:
        assert b"127.0.0.1" not in raw
        # After transaction and link (6 octets) and the 15 octets of the properties before it.
        assert raw[21 + 6 + 15] == 2, "expected method UDP"
    flying.assert_clean(flight)
