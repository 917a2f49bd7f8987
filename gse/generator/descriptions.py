# SPDX-License-Identifier: Apache-2.0
"""Descriptions, quantities and warning limits of parameters for the ground, from descriptors/descriptions.txt.

They are not in the descriptors, because a change of their text would change the hashes that the flight software
reports."""

import pathlib
import re

from source import STATES, DescriptorError

FILE = pathlib.Path(__file__).resolve().parents[2] / "descriptors" / "descriptions.txt"
LINE = re.compile(r"([A-Z0-9_.]+) \| ([^|]+?) \| ([^|]+?)(?: \| (-?[0-9.]+))?\Z")
# Words of the quantities =strategy and =hand, in the order of their numbers.
STRATEGIES = ("ASCII", "SQLITE", "POSTGRESQL", "RING")
HAND = ("LEADS", "NO_HAND", "RANGE", "SPEED", "SINGULAR")


def load(path=FILE):
    """(quantity, description, warning) by name."""
    found = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        matched = LINE.match(line)
        if not matched or matched[1] in found:
            raise DescriptorError(path, number, f"'{line}': expected a new `NAME | quantity | description | warning`")
        found[matched[1]] = (matched[2], matched[3], float(matched[4]) if matched[4] else None)
    return found


def describe(dictionary, lines):
    """Add description, quantity and warning limit to each parameter, or to each of its fields. Returns the dictionary."""
    words = {
        "=state": dict(enumerate(STATES)), "=mode": {mode["id"]: mode["name"] for mode in dictionary["modes"]},
        "=strategy": dict(enumerate(STRATEGIES)), "=switch": {0: "OFF", 1: "ON"}, "=hand": dict(enumerate(HAND)),
    }
    for subsystem in dictionary["subsystems"]:
        for parameter in subsystem["parameters"]:
            for leaf in parameter.get("fields", [parameter]):
                name = parameter["name"] if leaf is parameter else f"{parameter['name']}.{leaf['name']}"
                line = lines.get(f"{subsystem['name']}.{name}") or lines.get(name)
                if line is None:
                    continue
                quantity, leaf["description"], warning = line
                if quantity in words:
                    leaf["words"] = {"name": quantity[1:], "numbers": words[quantity]}
                elif quantity != "-" and not leaf["unit"] and "enumeration" not in leaf:
                    leaf["quantity"] = quantity
                if warning is not None:
                    leaf["warning"] = warning
    return dictionary
