# SPDX-License-Identifier: Apache-2.0
"""The commands of an operator, in words; the command line and the scenario scripts use them.

`plan` turns words into a Command whose procedure sends the telecommands and waits for their verification.
A procedure returns the lines of its answer, each a dict (for --json) with "text" for people.
"""

import itertools
import struct

from . import file_commands, packets, service_commands, telemetry
from .command import REPLY_NS, Command, UsageError, answers, asking, line, need, replies_of, rows_of, simple, words_of
from .dictionary import STATES, STRATEGIES, SUPERVISOR_APID, DictionaryError, Structure
from .files import MACHINE
from .session import Rejected, Request, SessionError, TimedOut
from .values import ValueProblem, quoted, shortened

EMBEDDED_FIRST = 0x2000  # Requests within requests use the upper half of the sequence counts; scripts count their own from 0.

_embedded_counts = itertools.count()
METHOD_ANY = 0xFF  # Transfer method of a link: any that both ends offer.
ERROR_OPERATIONAL = STATES.index("ERROR_OPERATIONAL")
REST_STATES = ("OFFLINE", "PRE_OPERATIONAL", "SAFE_OPERATIONAL", "OPERATIONAL", "ERROR_OPERATIONAL")
NESTED_MAX = 4  # Commands within commands, as in `at 100 at 200 ping SUPERVISOR`.
PARAMETERS_MAX = 255  # Parameters in a part of a structure; the request counts them in one octet.
STATUS = Request(SUPERVISOR_APID, 131, 8, text="status")


def _targets(dictionary, word, candidates):
    return list(candidates) if word.lower() == "all" else [dictionary.subsystem(word)]


def _ping(dictionary, words):
    if len(words) > 1:
        raise UsageError("usage: ping [SUBSYSTEM|all]")
    targets = _targets(dictionary, words[0] if words else "all", dictionary.subsystems.values())

    def procedure(session, timeout_ns):
        answer = []
        for target in targets:
            request = Request(target.apid, 17, 1, text=f"ping {target.name}")
            start = session.now_ns - session.slipped_ns
            yield from answers(session, request, (17, 2), timeout_ns)
            seconds = (session.now_ns - session.slipped_ns - start) / 1e9
            answer.append({"text": f"{target.name} is alive", "subsystem": target.name, "seconds": seconds})
        return answer

    requests = tuple(Request(target.apid, 17, 1, text=f"ping {target.name}") for target in targets)
    return Command("ping " + " ".join(target.name for target in targets), procedure, requests)


def _cmd(dictionary, words):
    usage = "cmd SUBSYSTEM.FUNCTION [ARGUMENT=VALUE ...]"
    if not words or "." not in words[0]:
        raise UsageError(f"usage: {usage}")
    subsystem_name, _, function_name = words[0].partition(".")
    subsystem = dictionary.subsystem(subsystem_name)
    function = subsystem.function(function_name)
    given = {}
    for word in words[1:]:
        name, sign, text = word.partition("=")
        if not sign or name.upper() in given:
            raise UsageError(f"{quoted(word)}: {'given twice' if sign else 'not argument=value'}; usage: {usage}")
        given[name.upper()] = text
    data = function.name.encode("ascii").ljust(8, b"\0") + bytes([len(function.arguments)])
    for argument in function.arguments:
        if argument.name.upper() not in given:
            names = " ".join(f"{a.name}={'|'.join(a.words.values()) if a.words else a.type}[{a.count}] {a.unit}".strip() for a in function.arguments)
            raise UsageError(f"argument {argument.name} is missing; {function.name} takes: {names}")
        data += struct.pack(">H", argument.id) + argument.encode_text(given.pop(argument.name.upper()))
    if given:
        known = ", ".join(a.name for a in function.arguments) or "no arguments"
        raise UsageError(f"{function.name} has no argument {shortened(', '.join(given))}; it takes: {known}")
    return simple(Request(subsystem.apid, 8, 1, data, f"cmd {subsystem.name}.{function.name}"))


def _state_number(word):
    name = word.upper()
    if name.isdecimal():
        name = STATES[int(name)] if int(name) < len(STATES) else name
    if name not in REST_STATES:
        raise UsageError(f"{quoted(word)} is not a state that can be requested; there are: {', '.join(REST_STATES)}")
    return STATES.index(name)


def _state(dictionary, words):
    need(words, 2, "state SUBSYSTEM|all STATE")
    target = _state_number(words[1])
    return simple(
        *(
            Request(item.apid, 129, 1, bytes([target]), f"state {item.name} {STATES[target]}")
            for item in _targets(dictionary, words[0], dictionary.members)
        )
    )


def _config(dictionary, words):
    need(words, 2, "config SUBSYSTEM CONFIGURATION")
    subsystem = dictionary.subsystem(words[0])
    configuration = subsystem.configuration(words[1])
    data = struct.pack(">H", configuration.id)
    return simple(Request(subsystem.apid, 129, 3, data, f"config {subsystem.name} {configuration.name}"))


def _reload(dictionary, words):
    need(words, 1, "reload SUBSYSTEM")
    subsystem = dictionary.subsystem(words[0])
    return simple(Request(subsystem.apid, 129, 6, b"", f"reload {subsystem.name}"))


def _properties_octets(producer, consumer):
    """Link properties in a request: layout, period and maximum age from the ports of the dictionary; the ends choose byte order and method."""
    age_us = consumer.max_age_us
    layout = producer.layout_hash, producer.octets
    return struct.pack(">IIBIHBBI", *layout, 0, producer.period_us, 0, METHOD_ANY, 1, age_us)


def _link_open(dictionary, link):
    producer = dictionary.subsystem_of_apid(link.producer).port(link.producer_port, requires=False)
    consumer = dictionary.subsystem_of_apid(link.consumer).port(link.consumer_port, requires=True)
    ports = struct.pack(">HHHH", link.producer, link.producer_port, link.consumer, link.consumer_port)
    text = f"link request {link.name}"
    data = struct.pack(">IH", link.number, 0) + ports + _properties_octets(producer, consumer)
    request = Request(SUPERVISOR_APID, 130, 3, data, text)

    def procedure(session, timeout_ns):
        verification = yield from session.execute(request, timeout_ns)

        def answered():
            return replies_of(verification, (130, 4)) + replies_of(verification, (130, 5))

        _, decoded = (yield from session.wait_for(answered, REPLY_NS, f"{text}: TM[130,4]"))[0]
        if "error" in decoded:
            raise SessionError(f"{text}: {decoded['error']}")
        if decoded["kind"] == "link refused":
            raise SessionError(f"{text}: refused, {decoded['reason']} does not fit; supported: {decoded['supported']}")
        data = struct.pack(">HI", decoded["link"], 0)
        opening = Request(SUPERVISOR_APID, 130, 6, data, f"link open {link.name}")
        yield from session.execute(opening, timeout_ns)
        session.links[link.name] = decoded["link"]
        return [{"text": f"link {link.name} is open, id {decoded['link']}", "link": link.name, "id": decoded["link"]}]

    return Command(f"link open {link.name}", procedure, (request,), (Request(SUPERVISOR_APID, 130, 6),))


def _link_rows(session, timeout_ns):
    """Procedure: rows of TM[130,9] of the supervisor, with the counters of the members."""
    rows = yield from link_rows_of(session, SUPERVISOR_APID, timeout_ns)
    for row in rows:
        for role, counters in (("producer", ("sent",)), ("consumer", ("received", "lost", "late"))):
            apid = session.dictionary.subsystem(row[role]).apid
            ends = yield from link_rows_of(session, apid, timeout_ns)
            row.update({key: end[key] for end in ends if end["link"] == row["link"] for key in counters})
    return rows


def link_rows_of(session, apid, timeout_ns):
    """Procedure: rows of TM[130,9] of one subsystem, with the names of the links."""
    rows = yield from rows_of(session, Request(apid, 130, 8, b"\0", "link list"), (130, 9), timeout_ns)
    names = {(x.producer, x.producer_port, x.consumer, x.consumer_port): x.name for x in session.dictionary.links}
    for row in rows:
        ports = (row["producer"], row["producer_port"], row["consumer"], row["consumer_port"])
        row["name"] = names.get(ports, str(row["link"]))
    return rows


def _link_close(dictionary, link):
    def procedure(session, timeout_ns):
        rows = yield from _link_rows(session, timeout_ns)
        ids = [row["link"] for row in rows if row["name"] == link.name and row["state"] != "closed"]
        if not ids:
            raise SessionError(f"link {link.name} is not open")
        request = Request(SUPERVISOR_APID, 130, 7, struct.pack(">HB", ids[-1], 0), f"link close {link.name}")
        yield from session.execute(request, timeout_ns)
        return [{"text": f"link {link.name} is closed", "link": link.name}]

    return Command(f"link close {link.name}", procedure, later=(Request(SUPERVISOR_APID, 130, 7),))


def _link_list():
    def procedure(session, timeout_ns):
        rows = yield from _link_rows(session, timeout_ns)
        found = {row["name"]: row for row in rows}
        answer = []
        for link in session.dictionary.links:
            row = found.get(link.name)
            counters = "  ".join(f"{key}={row[key]}" for key in ("sent", "received", "lost", "late")) if row else ""
            text = f"{link.name}: {row['state']}, id {row['link']}  {counters}" if row else f"{link.name}: closed"
            answer.append({"text": text, **(row or {"name": link.name, "state": "closed"})})
        return answer

    return Command("link list", procedure, (Request(SUPERVISOR_APID, 130, 8, b"\0", "link list"),))


def _link(dictionary, words):
    usage = "link open|close LINK, link list"
    if words == ["list"]:
        return _link_list()
    if len(words) != 2 or words[0] not in ("open", "close"):
        raise UsageError(f"usage: {usage}")
    return (_link_open if words[0] == "open" else _link_close)(dictionary, dictionary.link(words[1]))


def _mode(dictionary, words):
    need(words, 1, "mode MODE")
    mode = dictionary.mode(words[0])
    return simple(Request(SUPERVISOR_APID, 131, 1, bytes([mode]), f"mode {words[0].upper()}"))


def _log(_dictionary, words):
    need(words, 1, "log ascii|sqlite|ring")
    name = words[0].upper()
    if name not in STRATEGIES:
        raise UsageError(f"no packet log {quoted(words[0])}; there are: ascii, sqlite, ring")
    return simple(Request(SUPERVISOR_APID, 131, 3, bytes([STRATEGIES.index(name)]), f"log {name}"))


def _parameter(dictionary, word, usage):
    """(subsystem, parameter, name of a field of it or "")."""
    subsystem_name, dot, parameter_name = word.partition(".")
    if not dot:
        raise UsageError(f"usage: {usage}")
    subsystem = dictionary.subsystem(subsystem_name)
    head, _, field = parameter_name.partition(".")
    return subsystem, subsystem.parameter(head), field


def _value_request(subsystem, parameter):
    """Request for the value of a parameter."""
    data = struct.pack(">BI", 1, parameter.parameter_id)
    return Request(subsystem.apid, 20, 1, data, f"get {subsystem.name}.{parameter.name}")


def _set(dictionary, words):
    usage = "set SUBSYSTEM.PARAMETER[.FIELD] VALUE"
    need(words, 2, usage)
    subsystem, parameter, field = _parameter(dictionary, words[0], usage)
    text = ".".join(filter(None, (f"set {subsystem.name}", parameter.name, field.upper()))) + f" {words[1]}"

    def request(octets):
        return Request(subsystem.apid, 20, 3, struct.pack(">BI", 1, parameter.parameter_id) + octets, text)

    if not field:
        return simple(request(parameter.encode_text(words[1])))
    item, offset = parameter.field(field)
    octets = item.encode_text(words[1])

    def procedure(session, timeout_ns):
        """Read the structure, and write it with this field; a request contains whole parameters only."""
        reports = yield from answers(session, _value_request(subsystem, parameter), (20, 2), timeout_ns)
        value = reports[-1][0].data[6:]  # After the number of values and the id.
        changed = value[:offset] + octets + value[offset + item.size :]
        return (yield from simple(request(changed)).procedure(session, timeout_ns))

    return Command(text, procedure, later=(request(bytes(offset) + octets + bytes(parameter.size - offset - item.size)),))


def _get(dictionary, words):
    usage = "get SUBSYSTEM.PARAMETER[.FIELD]"
    need(words, 1, usage)
    subsystem, parameter, field = _parameter(dictionary, words[0], usage)
    request = _value_request(subsystem, parameter)
    if not field:
        return asking(request, (20, 2))
    item, _ = parameter.field(field)

    def procedure(session, timeout_ns):
        _, decoded = (yield from answers(session, request, (20, 2), timeout_ns))[-1]
        if "error" in decoded:
            raise SessionError(f"{request.text}: {decoded['error']}")
        value = decoded["values"][parameter.name][item.name]
        name = f"{parameter.name}.{item.name}"
        return [{"text": f"{subsystem.name}: {telemetry.measured({name: value}, subsystem.parameters)}", "values": {name: value}}]

    return Command(f"{request.text}.{item.name}", procedure, (request,))


def _number(word, what, octets):
    """A number that fits this many octets."""
    try:
        number = int(word, 0)
    except ValueError as error:
        raise UsageError(f"{what}: found {quoted(word)}, expected a number") from error
    largest = (1 << 8 * octets) - 1
    if not 0 <= number <= largest:
        raise UsageError(f"{what}: found {number}, expected 0 to {largest}")
    return number


_HK_USAGE = (
    "hk enable|disable|once|report|delete SUBSYSTEM STRUCTURE, hk interval SUBSYSTEM STRUCTURE CYCLES, "
    "hk create SUBSYSTEM STRUCTURE CYCLES PARAMETER|NREP:PARAMETER,PARAMETER [...]"
)
_HK_SUBTYPES = {"delete": 3, "enable": 5, "disable": 6, "report": 9, "once": 27}


def _hk_create(subsystem, structure_id, interval, words):
    once, repeated = [], []
    for word in words:
        count, colon, names = word.partition(":")
        if colon:
            sampled = tuple(subsystem.parameter(name) for name in names.split(","))
            repeated.append((_number(count, "number of samples", 2), sampled))
        else:
            once.append(subsystem.parameter(word))
    if max(len(once), len(repeated), *(len(sampled) for _, sampled in repeated)) > PARAMETERS_MAX:
        raise UsageError(f"hk create: expected at most {PARAMETERS_MAX} parameters, groups, and parameters of a group")
    data = struct.pack(">HIB", structure_id, interval, len(once))
    data += b"".join(struct.pack(">I", parameter.parameter_id) for parameter in once) + bytes([len(repeated)])
    for count, sampled in repeated:
        data += struct.pack(">HB", count, len(sampled))
        data += b"".join(struct.pack(">I", parameter.parameter_id) for parameter in sampled)
    subsystem.created[structure_id] = Structure(structure_id, interval, tuple(once), tuple(repeated))
    return simple(Request(subsystem.apid, 3, 1, data, f"hk create {subsystem.name} {structure_id}"))


def _hk(dictionary, words):
    if len(words) < 3:
        raise UsageError(f"usage: {_HK_USAGE}")
    verb, subsystem = words[0], dictionary.subsystem(words[1])
    structure_id = _number(words[2], "structure id", 2)
    text = f"hk {verb} {subsystem.name} {structure_id}"
    if verb in _HK_SUBTYPES and len(words) == 3:
        request = Request(subsystem.apid, 3, _HK_SUBTYPES[verb], struct.pack(">BH", 1, structure_id), text)
        if verb == "report":
            return asking(request, (3, 10))
        return _hk_once(request, subsystem.apid) if verb == "once" else simple(request)
    if verb == "interval" and len(words) == 4:
        data = struct.pack(">BHI", 1, structure_id, _number(words[3], "number of cycles", 4))
        return simple(Request(subsystem.apid, 3, 31, data, text))
    if verb == "create" and len(words) >= 5:
        return _hk_create(subsystem, structure_id, _number(words[3], "number of cycles", 4), words[4:])
    raise UsageError(f"usage: {_HK_USAGE}")


def _hk_once(request, apid):
    """One-shot report: the spacecraft sends it to all ground users, so it is not among the replies to this user."""

    def procedure(session, timeout_ns):
        found = []

        def listen(packet, decoded):
            if packet.apid == apid and packet.message == (3, 25):
                found.append((packet, decoded))

        session.listeners.append(listen)
        try:
            yield from session.execute(request, timeout_ns)
            yield from session.wait_for(lambda: found, REPLY_NS, f"{request.text}: TM[3,25]")
        finally:
            session.listeners.remove(listen)
        return [line(session, *found[-1])]

    return Command(request.text, procedure, (request,))


def _event_reports(dictionary, words):
    usage = "event enable|disable SUBSYSTEM EVENT, event disabled SUBSYSTEM"
    if len(words) == 2 and words[0] == "disabled":
        subsystem = dictionary.subsystem(words[1])
        return asking(Request(subsystem.apid, 5, 7, text=f"event disabled {subsystem.name}"), (5, 8))
    if len(words) != 3 or words[0] not in ("enable", "disable"):
        raise UsageError(f"usage: {usage}")
    subsystem = dictionary.subsystem(words[1])
    event = subsystem.event(words[2])
    subtype = 5 if words[0] == "enable" else 6
    data = struct.pack(">BH", 1, event.id)
    return simple(Request(subsystem.apid, 5, subtype, data, f"event {words[0]} {subsystem.name} {event.name}"))


def _shutdown(_dictionary, words):
    need(words, 0, "shutdown")
    return simple(Request(SUPERVISOR_APID, 131, 5, text="shutdown"))


def _status(_dictionary, words):
    need(words, 0, "status")

    def procedure(session, timeout_ns):
        rows = yield from rows_of(session, STATUS, (131, 9), timeout_ns)
        answer = []
        for row in rows:
            text = (
                f"{row['subsystem']:<14} {row['process']:<9} {row['state']:<18} {row['phase']:<13} "
                f"{row['configuration']:<14} restarts {row['restarts']}"
            )
            answer.append({"text": text, **row})
        return answer

    return Command("status", procedure, (STATUS,))


def _networks(_dictionary, words):
    need(words, 0, "networks")
    return asking(Request(SUPERVISOR_APID, 131, 10, text="networks"), (131, 11))


def _process(dictionary, words):
    need(words, 2, "process start|stop SUBSYSTEM")
    if words[0] not in ("start", "stop"):
        raise UsageError("usage: process start|stop SUBSYSTEM")
    subsystem = dictionary.subsystem(words[1])
    subtype = 6 if words[0] == "start" else 7
    data = struct.pack(">H", subsystem.apid)
    return simple(Request(SUPERVISOR_APID, 131, subtype, data, f"process {words[0]} {subsystem.name}"))


def _stop(dictionary, words):
    need(words, 0, "stop")

    def procedure(session, timeout_ns):
        rows = yield from rows_of(session, STATUS, (131, 9), timeout_ns)
        flying = [r for r in rows if r["state"] in REST_STATES[1:4] and r["apid"] in {m.apid for m in dictionary.members}]
        order = bytes([ERROR_OPERATIONAL])
        sent = [session.send(Request(r["apid"], 129, 1, order, f"stop {r['subsystem']}")) for r in flying]
        problems, answer = [], []
        for verification in sent:
            try:
                yield from session.finish(verification, timeout_ns)
                answer.append({"text": f"{verification.request.text}: ERROR_OPERATIONAL"})
            except (Rejected, TimedOut) as problem:
                problems.append(problem)
        if problems:
            raise problems[0]
        return answer or [{"text": "nothing to stop: no subsystem is in PRE_OPERATIONAL, SAFE_OPERATIONAL or OPERATIONAL"}]

    return Command("stop", procedure)


def _raw(_dictionary, words):
    try:
        octets = bytes.fromhex("".join(words))
    except ValueError as error:
        raise UsageError(f"raw: found {quoted(' '.join(words))}, expected octets, each as two hexadecimal digits") from error
    if len(octets) < packets.PRIMARY_HEADER:
        raise UsageError(f"raw: found {len(octets)} octet{'s' if len(octets) != 1 else ''}, expected at least the 6 of a primary header")
    apid = int.from_bytes(octets[:2], "big") & 0x7FF
    request = Request(apid, octets[7] if len(octets) > 7 else 0, octets[8] if len(octets) > 8 else 0, text="raw")

    def procedure(session, timeout_ns):
        verification = yield from session.finish(session.send_raw(octets, request), timeout_ns)
        return [{"text": "raw: completed"}] + [line(session, *reply) for reply in verification.replies]

    return Command("raw", procedure, (request,))


VERBS = {
    "ping": (_ping, "ping [SUBSYSTEM|all]", "TC[17,1] to one or all subsystems"),
    "cmd": (_cmd, "cmd SUBSYSTEM.FUNCTION [ARGUMENT=VALUE ...]", "perform a function; arrays as 0.5,-0.3"),
    "state": (_state, "state SUBSYSTEM|all STATE", "request a state"),
    "config": (_config, "config SUBSYSTEM CONFIGURATION", "select a configuration"),
    "reload": (_reload, "reload SUBSYSTEM", "reload its descriptor, at its next PRE_OPERATIONAL or OFFLINE"),
    "link": (_link, "link open|close LINK, link list", "real-time links"),
    "mode": (_mode, "mode MODE", "set the mission mode"),
    "log": (_log, "log ascii|sqlite|ring", "switch the packet log"),
    "set": (_set, "set SUBSYSTEM.PARAMETER[.FIELD] VALUE", "set a parameter, or one field of a structure"),
    "get": (_get, "get SUBSYSTEM.PARAMETER[.FIELD]", "read a parameter, or one field of a structure"),
    "hk": (_hk, _HK_USAGE, "housekeeping reports"),
    "event": (_event_reports, "event enable|disable SUBSYSTEM EVENT", "enable or disable event reports"),
    "status": (_status, "status", "processes, states and configurations of all subsystems"),
    "networks": (_networks, "networks", "real-time networks and their members"),
    "process": (_process, "process start|stop SUBSYSTEM", "start or stop a process"),
    "stop": (_stop, "stop", "bring all subsystems to ERROR_OPERATIONAL at once"),
    "shutdown": (_shutdown, "shutdown", "shut the mission down"),
    "raw": (_raw, "raw HEX", "send octets as they are"),
    **service_commands.VERBS,
    **file_commands.VERBS,
}


def _embedded(text, dictionary, files, depth):
    """Octets of the single request that a command sends, for example to schedule it. depth: number of commands that contain it."""
    if depth > NESTED_MAX:
        raise UsageError(f"found more than {NESTED_MAX} commands within commands")
    embed = dictionary.catalogue.plan
    planned = plan(words_of(text), dictionary, files, depth)
    dictionary.catalogue.plan = embed
    if len(planned.requests) != 1:
        raise UsageError(f"{quoted(text)} sends {len(planned.requests)} requests, expected a command that sends one")
    request = planned.requests[0]
    count = EMBEDDED_FIRST | next(_embedded_counts) % EMBEDDED_FIRST
    return packets.build_tc(request.apid, count, request.service, request.subtype, request.data)


def plan(words, dictionary, files=MACHINE, depth=0):
    """Command for these words. files: the files on ground that it may read and write (files.py); depth: number of commands that contain it.
    Raises UsageError."""
    if not words or words[0] not in VERBS:
        found = f"no command {quoted(words[0])}" if words else "no command"
        raise UsageError(f"{found}; there are: {', '.join(VERBS)}")
    dictionary.catalogue.plan = lambda text: _embedded(text, dictionary, files, depth + 1)
    dictionary.files = files
    try:
        return VERBS[words[0]][0](dictionary, list(words[1:]))
    except (DictionaryError, ValueProblem, packets.PacketError) as error:
        raise UsageError(str(error)) from error
