# SPDX-License-Identifier: Apache-2.0
"""Loops of services of a configuration: which services may have a loop, and why other services may not."""

from dataclasses import dataclass

SERVICES = ["17", "20"]
# Services of every subsystem that only the main loop may perform, with the reason.
BOUND = {
    "1": "the loop that performs a request verifies it",
    "3": "each <HKService> names its loop",
    "5": "an event is reported in the cycle that raises it",
    "8": "functions act on devices",
    "129": "the state machine starts and stops the control",
    "130": "links are opened, read and written in the cycle of the control",
}


@dataclass
class Loop:
    """A loop of services of a configuration."""

    name: str
    sampling_us: int
    priority: int
    services: list  # numbers of the services whose requests it performs


def loop_of(element):
    period_us, priority = element.time_us("samplingTime", 100, 10000000), element.unsigned("priority", 1, 99)
    return Loop(element.identifier(), period_us, priority, _services(element))


def _services(element):
    if "services" not in element.attributes:
        return []
    for number, reason in BOUND.items():
        if number in element.attributes["services"].split(" "):
            element.fail(f"service {number} cannot have a <Loop> of its own: {reason}")
    return [int(number) for number in element.words("services", SERVICES)]


def services_once(elements, loops):
    """Refuse a loop that names a service of an earlier loop."""
    newest = elements[len(loops) - 1]
    for earlier, element in zip(loops[:-1], elements):
        if set(earlier.services) & set(loops[-1].services):
            newest.fail(f"services=\"{newest.text('services')}\": expected no service of the <Loop> in line {element.line}")
