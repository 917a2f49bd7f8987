# SPDX-License-Identifier: Apache-2.0
"""Names of a subsystem descriptor for numbers (enumerations) and for failures of functions."""

from dataclasses import dataclass

from source import IDENTIFIER, NUMBER_OUT_OF_RANGE, read_number, unique

ENUMERATIONS = 16  # Maximum number in a subsystem.
FAILURES = 32  # Maximum number in a subsystem.
FAILURE_IDS = 0x7FFF
FAILURE_OWN = 0x8000  # PUS_FAILURE_OWN: failure code of id 0


@dataclass
class Enumeration:
    """Names for the numbers of a field."""

    element: object
    name: str
    first: int
    numbers: dict  # name -> number


@dataclass
class Failure:
    """A failure of functions that the subsystem defines itself, with the name of its detail."""

    element: object
    name: str
    id: int
    detail: str

    @property
    def code(self):
        return FAILURE_OWN + self.id


def enumerations(subsystem, container):
    """Read the contents of <Enumerations>."""
    for element in container.children:
        name, first, words = element.identifier(), element.unsigned("first", 0, 65535, 0), element.attributes["values"].split(" ")
        if not all(IDENTIFIER.match(word) for word in words) or len(set(words)) < len(words):
            element.wrong("values", "different upper-case identifiers (A-Z 0-9 _) of at most 32 characters, one space between")
        subsystem.enumerations.append(Enumeration(element, name, first, {word: first + index for index, word in enumerate(words)}))
        if len(subsystem.enumerations) > ENUMERATIONS:
            element.fail(f"too many enumerations, at most {ENUMERATIONS}")
        unique(container.children[: len(subsystem.enumerations)], "name")


def failures(subsystem, container):
    """Read the contents of <Failures>."""
    for element in container.children:
        detail = element.identifier("detail") if "detail" in element.attributes else ""
        subsystem.failures.append(Failure(element, element.identifier(), element.unsigned("id", 1, FAILURE_IDS), detail))
        if len(subsystem.failures) > FAILURES:
            element.fail(f"too many failures, at most {FAILURES}")
        unique(container.children[: len(subsystem.failures)], "name", "id")


def enumerate_field(subsystem, element, item):
    """Set the enumeration of a field. Its first and last number become the bounds of the field and must fit its type."""
    if "enumeration" not in element.attributes:
        return
    above = [each for each in subsystem.enumerations if each.element.line <= element.line]
    found = next((each for each in above if each.name == element.attributes["enumeration"]), None)
    if not found:
        known = " ".join(each.name for each in above) or "none"
        element.wrong("enumeration", f"an <Enumeration> defined above; there are: {known}")
    if item.min is not None or item.max is not None:
        element.fail("a field with an enumeration cannot have min or max")
    item.enumeration = found
    item.min, item.max = min(found.numbers.values()), max(found.numbers.values())
    if item.type in ("FLOAT", "DOUBLE", "BOOL") or read_number(str(item.max), item.type) is NUMBER_OUT_OF_RANGE:
        element.wrong("enumeration", f"one whose numbers fit {item.type}")
