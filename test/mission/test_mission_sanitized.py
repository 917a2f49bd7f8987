# SPDX-License-Identifier: Apache-2.0
"""Flights with the programs of SANITIZE=1: AddressSanitizer and UBSan report nothing, and the logs of telepresence are
the same as with the usual programs."""

import re

import flying
import pytest

SANITIZED = flying.ROOT / "build" / "sanitize" / "bin"
REPORT = re.compile(r"ERROR: \w*Sanitizer|runtime error:|LeakSanitizer|SUMMARY: ")
ENVIRONMENT = {"ASAN_OPTIONS": "detect_leaks=1:detect_stack_use_after_return=1", "UBSAN_OPTIONS": "print_stacktrace=1"}

pytestmark = pytest.mark.skipif(not (SANITIZED / "hirosco").exists(), reason="not built: make SANITIZE=1 all")


@pytest.mark.parametrize("form", ["image", "processes"])
@pytest.mark.parametrize("scenario", ["commissioning", "standalone", "hil", pytest.param("telepresence", marks=pytest.mark.long)])
def test_sanitizers_report_nothing_in_a_flight(directory, shared_flights, form, scenario):
    options = ("--scenario", scenario, "--form", form)
    flight = flying.fly(directory, *options, binaries=SANITIZED, environment=ENVIRONMENT)
    assert not REPORT.search(flight.console + flight.output), flight.transcript()
    assert flight.code == 0, flight.transcript()
    if scenario == "telepresence":
        for name in flying.TRACED:
            assert flight.octets(name) == shared_flights.flight(form=form).octets(name), f"{name} depends on the compiler's options"
    flying.assert_clean(flight)


@pytest.mark.parametrize("scenario", ["hil", pytest.param("telepresence", marks=pytest.mark.long)])
def test_sanitizers_report_nothing_with_links_by_udp(directory, scenario):
    flight = flying.fly(directory, "--scenario", scenario, "--links", "udp", binaries=SANITIZED, environment=ENVIRONMENT)
    assert not REPORT.search(flight.console + flight.output), flight.transcript()
    assert flight.code == 0, flight.transcript()
