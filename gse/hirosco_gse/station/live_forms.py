# SPDX-License-Identifier: Apache-2.0
"""Forms of the lines of the live port: each verb of `hand` and `fault`, from the usage of the command line."""

import re

from ..command import UsageError
from ..usage import CONSOLE
from ..values import quoted

ACTORS = ("fault", "hand")
OPTIONAL = "[DEVICE]"
_SUGGESTING = ("BUS", "DEVICE", "JOINT", "INSTRUMENT", "BUS|INSTRUMENT", "PROCESS")
_UNITS = {"RADIANS": "rad", "SECONDS": "s", "NEWTONS": "N", "HERTZ": "Hz", "MICROSECONDS": "us"}


def verbs(actor):
    """(verb, words of its arguments) of an actor, each verb once; a fault of a bus or an instrument is one form."""
    for usage in CONSOLE[actor][0].split(", "):
        _, names, *words = usage.split()
        for name in names.split("|"):
            yield name, words


def suggestions(dictionary):
    """Names that the fields of these forms suggest, by the word of the usage."""
    content = dictionary.content
    buses = [name for bus in content.get("buses") or [] for name in (bus["name"], f"{bus['name']}-b")]
    devices = sorted({device["name"] for item in content["subsystems"] for part in item["configurations"] for device in part.get("devices", [])})
    found = {"BUS": buses, "DEVICE": [*devices, "FLIGHT"], "JOINT": devices, "INSTRUMENT": devices, "BUS|INSTRUMENT": [*buses, *devices],
             "PROCESS": [item["name"].lower() for item in content["subsystems"]]}
    return {f"live-{word}": [{"value": name, "name": ""} for name in names] for word, names in found.items()}


def fields_of(words):
    """Fields of the arguments of a verb."""
    found = []
    for word in words:
        bare = word.strip("[]")
        same = sum(1 for other in words if other == word)
        name = bare.replace("|", " or ").lower() + (f" {len([one for one in found if one['word'] == word]) + 1}" if same > 1 else "")
        field = {"name": name, "word": word, "unit": _UNITS.get(bare, "")}
        if re.fullmatch(r"[a-z]+(\|[a-z]+)+", bare):
            field["options"] = [{"value": one, "name": one} for one in bare.split("|")]
        else:
            field |= {"hint": "optional" if word == OPTIONAL else "", **({"suggest": f"live-{bare}"} if bare in _SUGGESTING else {})}
        found.append(field)
    return found


def line_of(words, fields, values):
    """The line for the live port. Raises UsageError: a value is missing or is more than one word."""
    line = list(words)
    for field in fields:
        text = str(values.get(field["name"]) or "").strip()
        if not text and field["word"] == OPTIONAL:
            continue
        if len(text.split()) != 1:
            raise UsageError(f"{field['name']} is missing" if not text else f"{field['name']}: found {quoted(text)}, expected one word")
        line.append(text)
    return line
