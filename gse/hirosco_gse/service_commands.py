# SPDX-License-Identifier: Apache-2.0
"""Commands for the services of the standard: any message by its numbers, and words for the most frequent commands."""

import json
import shlex

from . import packets, values
from .command import Command, UsageError, asking, simple
from .dictionary import SUPERVISOR_APID
from .session import Rejected, Request


def _fields(words):
    """Read the words field=value of a message. A value that is valid JSON is decoded, other text is used unchanged."""
    given = {}
    for word in words:
        name, sign, text = word.partition("=")
        if not sign or name in given:
            raise UsageError(f"{values.quoted(word)}: {'given twice' if sign else 'not field=value'}")
        try:
            given[name] = json.loads(text)
        except ValueError:
            given[name] = text
        except RecursionError as error:
            raise UsageError(f"{values.shortened(name)}: found lists that are nested too deeply, expected a value") from error
    return given


def _request(dictionary, apid, service, subtype, given, text):
    return Request(apid, service, subtype, dictionary.catalogue.encode("TC", service, subtype, given), text)


def _planned(dictionary, apid, message, given, text):
    """Command of one request of the catalogue; it waits for the answer if the message has one."""
    service, subtype = message
    entry = dictionary.catalogue.find("TC", service, subtype)
    if entry is None:
        raise UsageError(f"TC[{service},{subtype}] is not in the catalogue")
    request = _request(dictionary, apid, service, subtype, given, text)
    return asking(request, (service, entry["answer"])) if entry["answer"] else simple(request)


def _tc(dictionary, words):
    usage = "tc SUBSYSTEM SERVICE,SUBTYPE [FIELD=VALUE ...]"
    numbers = words[1].split(",") if len(words) > 1 else []
    if len(numbers) != 2 or not all(number.isdecimal() for number in numbers):
        raise UsageError(f"usage: {usage}")
    subsystem = dictionary.subsystem(words[0])
    message = int(numbers[0]), int(numbers[1])
    return _planned(dictionary, subsystem.apid, message, _fields(words[2:]), f"tc {subsystem.name} {words[1]}")


def _at(dictionary, words):
    usage = "at [+]SECONDS [SUB-SCHEDULE.GROUP] COMMAND ..."
    if len(words) < 2 or not words[0].lstrip("+").replace(".", "", 1).isdecimal():
        found = f"at: found {values.quoted(words[0])}, expected a time in seconds; " if len(words) > 1 else ""
        raise UsageError(f"{found}usage: {usage}")
    place, rest = (1, 1), words[1:]
    if words[1].replace(".", "", 1).isdecimal() and "." in words[1]:
        place, rest = tuple(int(number) for number in words[1].split(".")), words[2:]
    text = f"at {words[0]} {shlex.join(rest)}"

    def request(seconds):
        activity = {"group_id": place[1], "release_time": seconds, "request": shlex.join(rest)}
        return _request(dictionary, SUPERVISOR_APID, 11, 4, {"sub_schedule_id": place[0], "n": [activity]}, text)

    if not words[0].startswith("+"):
        return simple(request(words[0]))
    unsent = request("0")  # Errors in the words are reported before anything is sent.

    # The mission time on board is that of the answer to a ping.
    def procedure(session, timeout_ns):
        alive = yield from session.execute(Request(SUPERVISOR_APID, 17, 1, text="ping SUPERVISOR"), timeout_ns)
        sent_ns = max(packet.time_ns for packet, _ in alive.replies) - dictionary.epoch_ns
        later = simple(request(f"{sent_ns / 1e9 + float(words[0]):.9f}"))
        return (yield from later.procedure(session, timeout_ns))

    return Command(text, procedure, later=(unsent,))


def _one(dictionary, words, forms, usage):
    """Command of the first word: forms maps it to (message, names of its fields)."""
    if not words or words[0] not in forms or len(words) - 1 != len(forms[words[0]][1]):
        raise UsageError(f"usage: {usage}")
    message, fields = forms[words[0]]
    given = {}
    for name, text in zip(fields, words[1:]):
        group, dot, inner = name.partition(".")
        if dot:
            given.setdefault(group, [{}])[0][inner] = text
        else:
            given[name] = text
    return _planned(dictionary, SUPERVISOR_APID, message, given, f"{' '.join(words)}")


_SCHEDULE = {"enable": ((11, 1), ()), "disable": ((11, 2), ()), "reset": ((11, 3), ()), "list": ((11, 17), ())}
_SCHEDULE_USAGE = "schedule list|enable|disable|reset"


def _schedule(dictionary, words):
    return _one(dictionary, words, _SCHEDULE, _SCHEDULE_USAGE)


_MONITOR_USAGE = (
    "monitor limit SUBSYSTEM ID PARAMETER LOW HIGH EVENT EVENT, monitor enable|disable|delete SUBSYSTEM ID, "
    "monitor start|stop|list|violations SUBSYSTEM"
)
_MONITOR_ALL = {"start": (12, 15), "stop": (12, 16), "list": (12, 13), "violations": (12, 10)}
_MONITOR_ONE = {"enable": (12, 1), "disable": (12, 2), "delete": (12, 6)}


def _event_number(subsystem, word):
    return 0 if word == "0" else subsystem.event(word).id


def _monitor(dictionary, words):
    if len(words) < 2:
        raise UsageError(f"usage: {_MONITOR_USAGE}")
    verb, subsystem = words[0], dictionary.subsystem(words[1])
    text = f"monitor {verb} {subsystem.name}"
    if verb in _MONITOR_ALL and len(words) == 2:
        return _planned(dictionary, subsystem.apid, _MONITOR_ALL[verb], {}, text)
    if verb in _MONITOR_ONE and len(words) == 3:
        return _planned(dictionary, subsystem.apid, _MONITOR_ONE[verb], {"n": [words[2]]}, text)
    if verb != "limit" or len(words) != 8:
        raise UsageError(f"usage: {_MONITOR_USAGE}")
    identity, parameter, low, high = words[2:6]
    is_whole = parameter[:1].isdecimal() or "." in parameter  # A number, or a parameter of another subsystem.
    parameter = parameter if is_whole else f"{subsystem.name}.{parameter}"
    definition = {
        "pmon_id": identity, "monitored_parameter_id": parameter, "validity_parameter_id": 0, "validity_mask": 0,
        "validity_expected_value": 0, "monitoring_interval": 1, "repetition_number": 1, "check_type": "limit",
        "low_limit": low, "low_limit_event_definition_id": _event_number(subsystem, words[6]),
        "high_limit": high, "high_limit_event_definition_id": _event_number(subsystem, words[7]),
    }
    return _planned(dictionary, subsystem.apid, (12, 5), {"n": [definition]}, text)


_ACTION_USAGE = "action add SUBSYSTEM EVENT COMMAND ..., action enable|disable|delete SUBSYSTEM EVENT, action start|stop|list"
_ACTION_ALL = {"start": (19, 8), "stop": (19, 9), "list": (19, 6)}
_ACTION_ONE = {"add": (19, 1), "delete": (19, 2), "enable": (19, 4), "disable": (19, 5)}


def _action(dictionary, words):
    if len(words) == 1 and words[0] in _ACTION_ALL:
        return _planned(dictionary, SUPERVISOR_APID, _ACTION_ALL[words[0]], {}, f"action {words[0]}")
    has_command = bool(words) and words[0] == "add"
    if not words or words[0] not in _ACTION_ONE or not (len(words) > 3 if has_command else len(words) == 3):
        raise UsageError(f"usage: {_ACTION_USAGE}")
    subsystem = dictionary.subsystem(words[1])
    event = subsystem.event(words[2])
    entry = {"apid": subsystem.apid, "event_definition_id": event.id}
    if has_command:
        entry["request"] = shlex.join(words[3:])
    text = f"action {words[0]} {subsystem.name} {event.name}"
    return _planned(dictionary, SUPERVISOR_APID, _ACTION_ONE[words[0]], {"n": [entry]}, text)


_STORE_USAGE = (
    "store create STORE OCTETS, store keep STORE SUBSYSTEM [SERVICE], store enable|disable|delete|summary STORE, "
    "store get STORE FROM TO, store list"
)
_STORE_ONE = {"enable": (15, 1), "disable": (15, 2), "delete": (15, 21), "summary": (15, 12)}


def _store(dictionary, words):
    verb, names = (words[0], words[1:]) if words else ("", [])
    text = f"store {' '.join(words)}"
    if verb == "list" and not names:
        return _planned(dictionary, SUPERVISOR_APID, (15, 18), {}, text)
    if verb in _STORE_ONE and len(names) == 1:
        return _planned(dictionary, SUPERVISOR_APID, _STORE_ONE[verb], {"n": [names[0]]}, text)
    if verb == "create" and len(names) == 2:
        entry = {"packet_store_id": names[0], "packet_store_size": names[1], "packet_store_type": "circular", "virtual_channel": 0}
        return _planned(dictionary, SUPERVISOR_APID, (15, 20), {"n": [entry]}, text)
    if verb == "keep" and len(names) in (2, 3):
        services = [{"service_type": names[2], "n3": []}] if len(names) == 3 else []
        process = {"apid": dictionary.subsystem(names[1]).apid, "n2": services}
        return _planned(dictionary, SUPERVISOR_APID, (15, 3), {"packet_store_id": names[0], "n1": [process]}, text)
    if verb == "get" and len(names) == 3:
        entry = {"packet_store_id": names[0], "retrieval_priority": 0, "from_time": names[1], "to_time": names[2]}
        return _planned(dictionary, SUPERVISOR_APID, (15, 9), {"n": [entry]}, text)
    raise UsageError(f"usage: {_STORE_USAGE}")


_PROCEDURE_USAGE = (
    "procedure load PROCEDURE FILE, procedure run|activate PROCEDURE [TYPE:VALUE ...], procedure tell PROCEDURE TYPE:VALUE ..., "
    "procedure suspend|resume|stop|abort|unload PROCEDURE, procedure engine start|stop, procedure status"
)
_PROCEDURE_ONE = {"suspend": (18, 5), "resume": (18, 6), "stop": (18, 4), "abort": (18, 12), "unload": (18, 2)}
_CODE_MAX = 16384  # Octets of a procedure on board; code longer than a packet is transferred in parts.
_AT_A_STEP = ("suspend", "stop")
_PROCEDURE_ALL = {"procedure status": (18, 8), "procedure engine start": (18, 21), "procedure engine stop": (18, 22)}


def _arguments(words):
    for word in words:
        kind, colon, value = word.partition(":")
        if not colon or kind.upper() not in values.FORMATS:
            raise UsageError(f"{values.quoted(word)} is not TYPE:VALUE with a type of {', '.join(values.FORMATS)}")
        yield {"argument_layout": kind.upper(), "argument_value": value}


def _until_started(request):
    """Command that waits only for the start of execution of its request."""

    def procedure(session, timeout_ns):
        verification = session.send(request)
        # Stage 3 is TM[1,3].
        yield from session.wait_for(lambda: verification.is_finished or 3 in verification.stages, timeout_ns, f"{request.text}: start")
        if verification.failure is not None:
            raise Rejected(request, verification.failure, session.dictionary)
        return [{"text": f"{request.text}: started"}]

    return Command(request.text, procedure, (request,))


def _load_procedure(dictionary, name, path):
    code = dictionary.files.read(path, _CODE_MAX)
    given = {"obcp_id": name, "obcp_code": code, "checksum": packets.crc16(code)}
    return _planned(dictionary, SUPERVISOR_APID, (18, 1), given, f"procedure load {name}")


def _begin_procedure(dictionary, verb, name, arguments):
    given = {"obcp_id": name, "observability_level": "step level", "n": list(_arguments(arguments))}
    request = _request(dictionary, SUPERVISOR_APID, 18, 3, given, f"procedure {verb} {name}")
    return simple(request) if verb == "run" else _until_started(request)


def _procedure(dictionary, words):
    verb, rest = (words[0], words[1:]) if words else ("", [])
    text = " ".join(["procedure", *words[:2]])
    if verb in ("run", "activate") and rest:
        return _begin_procedure(dictionary, verb, rest[0], rest[1:])
    if verb == "load" and len(rest) == 2:
        return _load_procedure(dictionary, *rest)
    if verb == "tell" and len(rest) > 1:
        return _planned(dictionary, SUPERVISOR_APID, (18, 7), {"obcp_id": rest[0], "n": list(_arguments(rest[1:]))}, text)
    if verb in _PROCEDURE_ONE and len(rest) == 1:
        given = {"obcp_id": rest[0], **({"step_id": 0} if verb in _AT_A_STEP else {})}
        return _planned(dictionary, SUPERVISOR_APID, _PROCEDURE_ONE[verb], given, text)
    if text in _PROCEDURE_ALL and len(words) < 3:
        return _planned(dictionary, SUPERVISOR_APID, _PROCEDURE_ALL[text], {}, text)
    raise UsageError(f"usage: {_PROCEDURE_USAGE}")


VERBS = {
    "tc": (_tc, "tc SUBSYSTEM SERVICE,SUBTYPE [FIELD=VALUE ...]", "any request of the standard; groups as JSON"),
    "at": (_at, "at [+]SECONDS [SUB-SCHEDULE.GROUP] COMMAND ...", "schedule a command for a mission time, or from now"),
    "schedule": (_schedule, _SCHEDULE_USAGE, "the schedule of commands"),
    "monitor": (_monitor, _MONITOR_USAGE, "limits of parameters, monitored on board"),
    "action": (_action, _ACTION_USAGE, "commands that events release on board"),
    "store": (_store, _STORE_USAGE, "telemetry kept on board, and its retrieval"),
    "procedure": (_procedure, _PROCEDURE_USAGE, "procedures in Lua, run on board"),
}
