# SPDX-License-Identifier: Apache-2.0
"""Commands for the services of the standard: any message by its numbers, and words for what operators do most."""

import json

from .command import UsageError, asking, simple
from .dictionary import SUPERVISOR_APID
from .session import Request


def _fields(words):
    """field=value of a message; a value that reads as JSON is taken as that, other text as it is."""
    given = {}
    for word in words:
        name, sign, text = word.partition("=")
        if not sign or name in given:
            raise UsageError(f"'{word}': {'given twice' if sign else 'not field=value'}")
        try:
            given[name] = json.loads(text)
        except ValueError:
            given[name] = text
    return given


def _request(dictionary, apid, service, subtype, given, text):
    return Request(apid, service, subtype, dictionary.catalogue.encode("TC", service, subtype, given), text)


def _planned(dictionary, apid, message, given, text):
    """Command of one request of the catalogue; it waits for the answer that the message has."""
    service, subtype = message
    entry = dictionary.catalogue.find("TC", service, subtype)
    if entry is None:
        raise UsageError(f"TC[{service},{subtype}] is not in the catalogue")
    request = _request(dictionary, apid, service, subtype, given, text)
    return asking(request, (service, entry["answer"])) if entry["answer"] else simple(request)


def _tc(dictionary, words):
    usage = "tc SUBSYSTEM SERVICE,SUBTYPE [field=value ...]"
    numbers = words[1].split(",") if len(words) > 1 else []
    if len(numbers) != 2 or not all(number.isdigit() for number in numbers):
        raise UsageError(f"usage: {usage}")
    subsystem = dictionary.subsystem(words[0])
    message = int(numbers[0]), int(numbers[1])
    return _planned(dictionary, subsystem.apid, message, _fields(words[2:]), f"tc {subsystem.name} {words[1]}")


def _at(dictionary, words):
    usage = "at SECONDS [SUB-SCHEDULE.GROUP] COMMAND ..."
    if len(words) < 2:
        raise UsageError(f"usage: {usage}")
    place, rest = (1, 1), words[1:]
    if words[1].replace(".", "", 1).isdigit() and "." in words[1]:
        place, rest = tuple(int(number) for number in words[1].split(".")), words[2:]
    quoted = " ".join(f"'{word}'" if " " in word else word for word in rest)
    activity = {"group_id": place[1], "release_time": words[0], "request": quoted}
    given = {"sub_schedule_id": place[0], "n": [activity]}
    return _planned(dictionary, SUPERVISOR_APID, (11, 4), given, f"at {words[0]} {quoted}")


VERBS = {
    "tc": (_tc, "tc SUBSYSTEM SERVICE,SUBTYPE [field=value ...]", "any request of the standard; groups as JSON"),
    "at": (_at, "at SECONDS [SUB-SCHEDULE.GROUP] COMMAND ...", "schedule a command for a mission time"),
}
