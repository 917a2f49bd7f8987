# SPDX-License-Identifier: Apache-2.0
"""Decode telemetry (and telecommands in a log): a dict for programs and a line for people.

`decode` raises no exception for a packet of a known spacecraft with unknown content: "error" in the dict contains the reason.
"""

import struct

from . import values
from .dictionary import SEVERITIES, STATES, STRATEGIES, SUPERVISOR_APID, defined_on_board
from .failures import LINK_REASONS, STAGES, Failure, name_of
from .identifiers import named

CAUSES = ("request", "own error", "network", "plan", "shutdown", "time-out", "supervisor lost")
LINK_STATES = ("closed", "requested", "accepted", "open", "stale", "failed")
PROCESS_STATES = ("stopped", "running", "lost")
PHASES = (
    "IDLE",
    "ENTERING",
    "INVALID",
    "UNCONFIGURED",
    "CONFIGURING",
    "CONFIGURED",
    "LEAVING",
    "SECURED",
    "UNSECURED",
)
METHODS = ("shm", "TIPC", "UDP", "stream", "queue")
LINK_FIELDS = (
    "none",
    "layout hash",
    "layout size",
    "byte order",
    "period",
    "tolerance",
    "method",
    "depth",
    "age",
    "port",
    "role",
)
VERIFICATION = {
    1: "accepted",
    2: "acceptance failed",
    3: "started",
    4: "start failed",
    5: "progress",
    6: "progress failed",
    7: "completed",
    8: "completion failed",
    10: "routing failed",
}


class Reader:
    """Reads big-endian fields in order. Raises struct.error if there are too few octets."""

    def __init__(self, octets):
        self.octets, self.offset = octets, 0

    def take(self, layout):
        """Next fields of a struct layout as a tuple; a single field as its value."""
        layout = ">" + layout
        found = struct.unpack_from(layout, self.octets, self.offset)
        self.offset += struct.calcsize(layout)
        return found[0] if len(found) == 1 else found

    def end(self):
        """Raise ValueProblem if octets are left."""
        if self.offset != len(self.octets):
            raise values.ValueProblem(f"{len(self.octets) - self.offset} octets too many")


def _fields(packet, layout):
    """All fields of a report with a fixed layout."""
    reader = Reader(packet.data)
    found = reader.take(layout)
    reader.end()
    return found


def _state_fields(dictionary, apid, state, phase, configuration):
    subsystem = dictionary.subsystem_of_apid(apid)
    return {
        "state": name_of(STATES, state),
        "phase": name_of(PHASES, phase),
        "configuration": subsystem.configuration_name(configuration) if subsystem else str(configuration),
    }


def _verification(packet, dictionary, _):
    reader = Reader(packet.data)
    word, count = reader.take("HH")
    found = {
        "kind": "verification",
        "request_apid": word & 0x7FF,
        "request_sequence": count & 0x3FFF,
        "stage": VERIFICATION.get(packet.subtype, str(packet.subtype)),
    }
    if packet.subtype in STAGES:
        failure = Failure.decode(packet.subtype, packet.data[4:], packet.apid)
        found.update(code=failure.code, instruction=failure.instruction, detail=failure.detail)
        found["words"] = failure.words(dictionary)
        return found
    if packet.subtype == 5:
        found["step"] = reader.take("H")
    reader.end()
    return found


def _housekeeping(packet, dictionary, configurations):
    structure_id = struct.unpack_from(">H", packet.data)[0]
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    if subsystem is None:
        raise values.ValueProblem("unknown APID")
    problem = "unknown structure"
    for structure in subsystem.structures_of_id(structure_id, (configurations or {}).get(packet.apid)):
        try:
            return {"kind": "housekeeping", "structure": structure_id, "values": structure.decode(packet.data, 2)}
        except values.ValueProblem as error:
            problem = str(error)
    raise values.ValueProblem(f"structure {structure_id}: {problem}")


def _structure_report(packet, dictionary, _):
    reader = Reader(packet.data)
    structure_id, enabled, interval, count = reader.take("HBIH")
    subsystem = dictionary.subsystem_of_apid(packet.apid)

    def named(parameter_id):
        parameter = subsystem.parameter_of_id(parameter_id) if subsystem else None
        return parameter.name if parameter else f"0x{parameter_id:08X}"

    once = [named(reader.take("I")) for _ in range(count)]
    repeated = []
    for _ in range(reader.take("H")):
        repetitions, count = reader.take("HH")
        repeated.append({"nrep": repetitions, "parameters": [named(reader.take("I")) for _ in range(count)]})
    reader.end()
    return {
        "kind": "structure",
        "structure": structure_id,
        "enabled": bool(enabled),
        "interval": interval,
        "once": once,
        "repeated": repeated,
    }


def _periodic(packet, *_):
    reader = Reader(packet.data)
    rows = [dict(zip(("structure", "enabled", "interval"), reader.take("HBI"))) for _ in range(reader.take("H"))]
    reader.end()
    return {"kind": "periodic", "rows": rows}


def _event(packet, dictionary, configurations):
    event_id = struct.unpack_from(">H", packet.data)[0]
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    event = subsystem.event_of_id(event_id & 0xFF) or subsystem.event_of_id(event_id) if subsystem else None
    found = {"kind": "event", "severity": SEVERITIES[packet.subtype], "id": event_id}
    if event is None:
        raise values.ValueProblem(f"event {event_id} is not in the dictionary")
    return {**found, "event": event.name, "values": named(event.decode(packet.data, 2), event, subsystem, dictionary, configurations)}


def _event_notice(packet, dictionary, _):
    event_id, severity = _fields(packet, "HB")
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    event = subsystem.event_of_id(event_id) if subsystem else None
    return {"kind": "event notice", "event": event.name if event else str(event_id), "severity": SEVERITIES.get(severity, str(severity))}


def _disabled_events(packet, dictionary, _):
    reader = Reader(packet.data)
    ids = [reader.take("H") for _ in range(reader.take("H"))]
    reader.end()
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    events = [subsystem.event_of_id(event_id) if subsystem else None for event_id in ids]
    names = [event.name if event else str(event_id) for event, event_id in zip(events, ids)]
    return {"kind": "disabled events", "events": names or ["none"]}


def _alive(packet, *_):
    Reader(packet.data).end()
    return {"kind": "alive"}


def _parameters(packet, dictionary, _):
    reader = Reader(packet.data)
    count, found = reader.take("H"), {}
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    for _ in range(count):
        parameter_id = reader.take("I")
        parameter = subsystem.parameter_of_id(parameter_id) if subsystem else None
        if parameter is None and parameter_id >> 21 == packet.apid:
            parameter = defined_on_board(parameter_id)
        if parameter is None:
            raise values.ValueProblem(f"parameter 0x{parameter_id:08X} is not in the dictionary")
        found[parameter.name], reader.offset = parameter.decode(packet.data, reader.offset)
    reader.end()
    return {"kind": "parameters", "values": found}


def _transition(packet, dictionary, _):
    previous, state, phase, configuration, cause, code, cycle = _fields(packet, "BBBHBHI")
    return {
        "kind": "transition",
        "previous": name_of(STATES, previous),
        **_state_fields(dictionary, packet.apid, state, phase, configuration),
        "configuration_id": configuration,
        "cause": name_of(CAUSES, cause),
        "code": code,
        "cycle": cycle,
    }


def _status(packet, dictionary, _):
    state, phase, target, configuration, interface, content, epoch, cycle = _fields(packet, "BBBHQQII")
    return {
        "kind": "status",
        **_state_fields(dictionary, packet.apid, state, phase, configuration),
        "target": name_of(STATES, target),
        "configuration_id": configuration,
        "interface_hash": f"0x{interface:016x}",
        "configuration_hash": f"0x{content:016x}",
        "epoch": epoch,
        "cycle": cycle,
    }


def _mode(packet, dictionary, _):
    previous, mode, cause = _fields(packet, "BBB")
    names = {item["id"]: item["name"] for item in dictionary.modes}
    return {
        "kind": "mode",
        "previous": names.get(previous, str(previous)),
        "mode": names.get(mode, str(mode)),
        "cause": name_of(CAUSES, cause),
    }


def _log(packet, *_):
    previous, strategy, first, code = _fields(packet, "BBQH")
    return {
        "kind": "packet log",
        "previous": name_of(STRATEGIES, previous),
        "strategy": name_of(STRATEGIES, strategy),
        "first_record": first,
        "code": code,
    }


def _table(packet, dictionary, _):
    reader = Reader(packet.data)
    rows = []
    for _ in range(reader.take("H")):
        apid, process, state, phase, configuration, restarts = reader.take("HBBBHB")
        rows.append(
            {
                "apid": apid,
                "subsystem": dictionary.name_of_apid(apid),
                "process": name_of(PROCESS_STATES, process),
                **_state_fields(dictionary, apid, state, phase, configuration),
                "restarts": restarts,
            }
        )
    reader.end()
    return {"kind": "subsystems", "rows": rows}


def _networks(packet, dictionary, _):
    reader = Reader(packet.data)
    rows = []
    for _ in range(reader.take("H")):
        network, members = reader.take("HH")
        apids = [reader.take("H") for _ in range(members)]
        links = [reader.take("H") for _ in range(reader.take("H"))]
        rows.append({"network": network, "members": [dictionary.name_of_apid(apid) for apid in apids], "links": links})
    reader.end()
    return {"kind": "networks", "rows": rows}


def properties(reader):
    """Link properties P."""
    names = ("layout_hash", "octets", "byte_order", "period_us", "tolerance_permille", "method", "depth", "max_age_us")
    found = dict(zip(names, reader.take("IIBIHBBI")))
    found["method"] = name_of(METHODS, found["method"])
    found["byte_order"] = ("big", "little")[found["byte_order"] & 1]
    return found


def _link_offers(packet, dictionary, _):
    reader = Reader(packet.data)
    rows = []
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    for _ in range(reader.take("H")):
        port, role = reader.take("HB")
        name = subsystem.port_name(port, requires=bool(role)) if subsystem else str(port)
        rows.append({"port": name, "role": ("producer", "consumer")[role & 1], **properties(reader)})
    reader.end()
    return {"kind": "link offers", "rows": rows}


def _link_accept(packet, *_):
    reader = Reader(packet.data)
    transaction, link_id = reader.take("IH")
    agreed = properties(reader)
    kind, size = reader.take("BB")
    endpoint = reader.take(f"{size}s") if size else b""
    reader.end()
    return {
        "kind": "link accepted",
        "transaction": transaction,
        "link": link_id,
        "properties": agreed,
        "endpoint": f"{name_of(METHODS, kind)} {endpoint.rstrip(bytes(1)).decode('ascii', 'replace')}".strip(),
    }


def _link_refuse(packet, *_):
    reader = Reader(packet.data)
    transaction, reason, offending = reader.take("IBB")
    supported = properties(reader)
    reader.end()
    return {
        "kind": "link refused",
        "transaction": transaction,
        "reason": name_of(LINK_REASONS, reason),
        "field": name_of(LINK_FIELDS, offending),
        "supported": supported,
    }


def _link_status(packet, *_):
    reader = Reader(packet.data)
    rows = []
    names = ("link", "state", "producer", "producer_port", "consumer", "consumer_port")
    counters = ("sent", "received", "lost", "late", "last_sequence")
    for _ in range(reader.take("H")):
        row = dict(zip(names, reader.take("HBHHHH")))
        row["state"] = name_of(LINK_STATES, row["state"])
        row["properties"] = properties(reader)
        row.update(zip(counters, reader.take("IIIII")))
        rows.append(row)
    reader.end()
    return {"kind": "links", "rows": rows}


def _link_transition(packet, *_):
    link_id, previous, state, cause, _time = _fields(packet, "HBBB8s")
    return {
        "kind": "link transition",
        "link": link_id,
        "previous": name_of(LINK_STATES, previous),
        "state": name_of(LINK_STATES, state),
        "cause": name_of(LINK_REASONS, cause),
    }


_DECODERS = {
    (3, 10): _structure_report,
    (3, 25): _housekeeping,
    (3, 35): _periodic,
    (5, 1): _event,
    (5, 2): _event,
    (5, 3): _event,
    (5, 4): _event,
    (5, 8): _disabled_events,
    (17, 2): _alive,
    (20, 2): _parameters,
    (129, 2): _transition,
    (129, 5): _status,
    (129, 7): _event_notice,
    (130, 2): _link_offers,
    (130, 4): _link_accept,
    (130, 5): _link_refuse,
    (130, 9): _link_status,
    (130, 10): _link_transition,
    (131, 2): _mode,
    (131, 4): _log,
    (131, 9): _table,
    (131, 11): _networks,
}
for _subtype in VERIFICATION:
    _DECODERS[(1, _subtype)] = _verification


def _by_catalogue(packet, dictionary, _):
    """Any other message of the standard."""
    entry = dictionary.catalogue.find(packet.direction, packet.service, packet.subtype)
    if entry is None:
        raise values.ValueProblem("not in the catalogue of messages")
    return {"kind": entry["name"], **dictionary.catalogue.decode(packet)}


def decode(packet, dictionary, configurations=None):
    """Content of a TM as a dict with at least "kind". `configurations`: APID -> present configuration id."""
    decoder = _DECODERS.get(packet.message)
    if decoder is None:
        decoder = _by_catalogue
    try:
        return decoder(packet, dictionary, configurations)
    except (struct.error, IndexError, ValueError) as error:
        return {"kind": decoder.__name__.strip("_"), "error": f"{packet.title} cannot be decoded: {error}"}


def leaves(values_by_name):
    """Leaves of housekeeping values: NAME or NAME.FIELD -> list of scalars; of repeated samples the last."""
    found = {}
    for name, value in values_by_name.items():
        if isinstance(value, dict):
            found.update({f"{name}.{key}": list(item) for key, item in value.items()})
        elif value and isinstance(value[0], (list, tuple, dict)):
            found.update(leaves({name: value[-1]}))
        else:
            found[name] = list(value)
    return found


def _with_unit(value, item):
    if getattr(item, "kind", "") == "character":  # A text of a fixed size, padded with 0.
        return repr(bytes(value).rstrip(b"\0").decode("ascii", "backslashreplace"))
    unit = f" {item.unit}" if item is not None and item.unit else ""
    return f"{values.to_text(value)}{unit}"


def measured(values_by_name, items):
    """Names, values and units in one line. items: name -> Parameter or Field."""
    words = []
    for name, value in values_by_name.items():
        head, _, tail = name.partition(".")
        item = items.get(name) or items.get(head)
        fields = {field.name: field for field in getattr(item, "fields", ())}
        if isinstance(value, dict):
            members = ", ".join(f"{key}: {_with_unit(member, fields.get(key))}" for key, member in value.items())
            words.append(f"{name}={{{members}}}")
        else:
            words.append(f"{name}={_with_unit(value, fields.get(tail, item) if tail else item)}")
    return "  ".join(words)


def interface_problem(packet, decoded, dictionary):
    """Text if a status report has another interface than the dictionary; otherwise None."""
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    if decoded["kind"] != "status" or "error" in decoded or subsystem is None:
        return None
    flown, known = int(decoded["interface_hash"], 0), subsystem.interface_hash
    if known in (0, flown):
        return None
    return f"{subsystem.name} flies interface 0x{flown:016x}, the dictionary has 0x{known:016x}: names and values may be wrong; run make"


def _flat(content):
    skipped = ("kind", "rows", "interface_hash", "configuration_hash", "configuration_id", "epoch")
    return "  ".join(f"{name}={values.to_text(value)}" for name, value in content.items() if name not in skipped)


def describe(packet, decoded, dictionary):
    """One line of text, without the time."""
    source = dictionary.name_of_apid(packet.apid)
    if "error" in decoded:
        return f"{source}: {decoded['error']}"
    kind = decoded["kind"]
    subsystem = dictionary.subsystem_of_apid(packet.apid)
    if kind == "event":
        aux = measured(decoded["values"], {item.name: item for item in subsystem.event(decoded["event"]).parameters})
        return f"{source}: {decoded['severity']} {decoded['event']}" + (f"  {aux}" if aux else "")
    if kind == "transition":
        return (
            f"{source}: {decoded['previous']} -> {decoded['state']} ({decoded['phase']}), "
            f"configuration {decoded['configuration']}, cause {decoded['cause']}"
        )
    if kind == "verification":
        target = dictionary.name_of_apid(decoded["request_apid"])
        words = f": {decoded['words']}" if "words" in decoded else ""
        # In TM[1,5] of a subsystem the step is a state; of the supervisor, a step of a procedure or percent of a copy.
        states = () if packet.apid == SUPERVISOR_APID else STATES
        step = f" {name_of(states, decoded['step'])}" if "step" in decoded else ""
        return f"{source}: request {decoded['request_sequence']} to {target} {decoded['stage']}{step}{words}"
    if kind in ("housekeeping", "parameters"):
        return f"{source}: {measured(decoded['values'], subsystem.parameters if subsystem else {})}"
    if "rows" in decoded:
        return f"{source}: {kind}: " + "; ".join(_flat(row) for row in decoded["rows"])
    return f"{source}: {kind}" + (f"  {_flat(decoded)}" if len(decoded) > 1 else "")
