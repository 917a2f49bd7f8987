# SPDX-License-Identifier: Apache-2.0
"""Words for numbers with the same meaning in every mission, read from their definitions: enumerations of C headers, and the catalogue of messages."""

import functools
import pathlib
import re

import catalogue

ROOT = pathlib.Path(__file__).resolve().parents[2]
CATALOGUE = ROOT / "pus" / "catalogue"
# Quantity of descriptions.txt -> header with the enumeration of its numbers, prefix of the constants.
HEADERS = {
    "=refusal": (ROOT / "fsw" / "canopen" / "network.h", "REFUSAL_"),
    "=result": (ROOT / "base" / "status.h", "STATUS_"),
    "=observation": (ROOT / "pus" / "st18" / "st18_procedures.h", "PUS_OBSERVED_"),
}
TAILORING = ROOT / "pus" / "core" / "tailoring.h"


def constants(text, prefix):
    """Constants of an enumeration in a C header, one in a line: number -> name without the prefix. A constant without a value has the number
    after the one before it. COUNT, the number of constants, is left out."""
    found, number = {}, -1
    for name, value in re.findall(rf"^\s*{prefix}([A-Z0-9_]+)\s*(?:=\s*(0x[0-9A-Fa-f]+|\d+)U?)?\s*(?:,|//|$)", text, re.MULTILINE):
        number = int(value, 0) if value else number + 1
        found[number] = name
    return {number: name for number, name in found.items() if name != "COUNT"}


def failure_names():
    """Names of the failure codes of ST[01] by number."""
    return constants(TAILORING.read_text(encoding="utf-8"), "PUS_FAILURE_")


@functools.cache
def by_quantity():
    """Words by quantity of descriptions.txt: number -> word."""
    services = catalogue.load(CATALOGUE)[1] | catalogue.private(CATALOGUE)[1]
    checks = services[12]["enumerations"]
    found = {quantity: constants(path.read_text(encoding="utf-8"), prefix) for quantity, (path, prefix) in HEADERS.items()}
    return found | {
        "=failure": {number: words for number, _, words, _ in catalogue.failures(CATALOGUE / "failures.txt", failure_names())},
        "=service": {number: service["name"] for number, service in sorted(services.items())},
        "=check_type": checks["check_type"], "=check_status": checks["current_pmon_checking_status"],
    }
