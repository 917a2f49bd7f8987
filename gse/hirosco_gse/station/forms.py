# SPDX-License-Identifier: Apache-2.0
"""Forms of commands: one for each entry of the dictionary. The values that a user types are converted to words of the command line.

A form is plain JSON: {"id", "name", "kind", "subsystems", "fields"}; subsystems: those whose interface defines the words of the form. A
field has a name, and may have unit, min, max, options (nothing else can be chosen), suggest (a list of names that may be chosen), hint and
optional; `repeat` is a field with groups of fields, at least `least` of them; `choice` has the fields of the value of another field. The
keys type, count and coding are for the check of the values. The values of a form are a dict of texts, with a list of dicts for each `repeat`."""

import json
import re
import shlex
from dataclasses import dataclass, replace

from ..command import UsageError
from ..commands import REST_STATES
from ..messages import NUMBERS
from ..values import FORMATS, REALS, quoted, shortened
from . import live_forms

UPWARD = REST_STATES[1:4]
STRUCTURE_VERBS = ("enable", "disable", "once", "report", "delete")
STANDARD = ("TC[129,1]", "TC[17,1]", "TC[129,6]", "process")  # Kinds of forms whose requests are the same for every interface.
_RANGE = re.compile(r"(\d+)\.\.(\d+)$")


@dataclass(frozen=True)
class Form:
    """One form: `compose` makes words of its values."""

    id: str
    name: str
    kind: str
    fields: tuple
    compose: object
    subsystems: tuple = ()

    def message(self):
        return {"id": self.id, "name": self.name, "kind": self.kind, "subsystems": self.subsystems, "fields": self.fields}


def script_of(calls):
    """Commands of a flight as a scenario for `gse script`. `try` precedes a command that failed. Commands with a file are left out."""
    lines = ["# commands of the ground station"]
    kept = [call for call in calls if call.line]
    for call in kept:
        lines.append(f"{max(0.0, (call.seconds or 0.0) - (kept[0].seconds or 0.0)):.3f} operator {'try ' if call.failure else ''}{call.line}")
    return "".join(f"{line}\n" for line in lines)


# ---- Fields ----


def _field_of(item):
    """Field of an argument, a parameter or a member of a structure in the dictionary (JSON)."""
    field = {"name": item["name"], "unit": item.get("unit") or "", "type": item["type"], "count": int(item.get("count", 1))}
    field |= {key: item[key] for key in ("min", "max") if item.get(key) is not None}
    return field


def _with_words(field, item, enumerations):
    """The field with the words of its enumeration: as options, or as a hint if it has several values."""
    numbers = enumerations.get(item.get("enumeration"))
    if numbers and field["count"] == 1:
        field["options"] = [{"value": word, "name": f"{number} {word}"} for word, number in numbers.items()]
    elif numbers:
        field["hint"] = f"{field['count']} of {', '.join(numbers)}"
    return field


def _options(names):
    return [{"value": str(name), "name": str(name)} for name in names]


def _range(kind):
    """(least, greatest) of a kind of the catalogue, or None."""
    bounds = _RANGE.search(kind["meaning"])
    if bounds:
        return int(bounds[1]), int(bounds[2])
    if kind["coding"] in NUMBERS:
        size, signed = NUMBERS[kind["coding"]]
        return (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) if signed else (0, (1 << 8 * size) - 1)
    return (0, (1 << kind["size"]) - 1) if kind["coding"] == "bits" else None


_SUGGEST = {"apid": "subsystems", "event_id": "events", "parameter_id": "parameters"}
_UNITS = {"time": "s of mission time", "cds": "s of mission time", "reltime": "s", "position": "orbits"}
_HINTS = {"octets": "hexadecimal", "rest": "hexadecimal", "packet": "a command, or its octets in hexadecimal", "name": "at most 8 characters"}


def _of_catalogue(catalogue, service, field):
    """Field of a form for a field of a message."""
    if "repeat" in field:
        return {"name": field["repeat"], "repeat": True, "least": field.get("least", 0), "fields": [_of_catalogue(catalogue, service, item) for item in field["fields"]]}
    if "choice" in field:
        cases = {number: [_of_catalogue(catalogue, service, item) for item in items] for number, items in field["cases"].items()}
        words = catalogue.words(service, field["choice"])
        return {"choice": field["choice"], "cases": cases | {words[int(number)]: items for number, items in cases.items() if int(number) in words}}
    if "values" in field:
        return {"name": "values", "unit": "", "coding": "octets", "hint": "hexadecimal", "optional": True}
    if field["kind"] in ("value", "auxiliary"):
        return {"name": field["name"], "unit": "", "coding": "text", "hint": "in the type of its parameter or layout" if field["kind"] == "value" else "hexadecimal"}
    return _of_kind(catalogue, service, field)


def _of_kind(catalogue, service, field):
    kind = catalogue.kinds[field["kind"]]
    found = {"name": field["name"], "unit": _UNITS.get(kind["coding"], ""), "coding": kind["coding"], "hint": _HINTS.get(kind["coding"], kind["meaning"])}
    words = catalogue.words(service, field["name"])
    if words:
        found["options"] = [{"value": word, "name": f"{number} {word}"} for number, word in words.items()]
    elif field["kind"] == "bool8":
        found["options"] = [{"value": "0", "name": "0 false"}, {"value": "1", "name": "1 true"}]
    elif kind["coding"] == "layout":
        found["options"] = _options(FORMATS)
    elif span := _range(kind):
        found |= {"min": span[0], "max": span[1]}
    return found | ({"suggest": _SUGGEST[field["kind"]]} if field["kind"] in _SUGGEST else {})


# ---- Values of a form ----


def _label(field):
    return f"{field['name']}, {field['unit']}" if field["unit"] else field["name"]


def _text(field, values):
    """Text of a field. Raises UsageError if it is missing or out of range."""
    text = values.get(field["name"])
    if text is None or not str(text).strip():
        raise UsageError(f"{field['name']} is missing")
    text = str(text).strip()
    if "options" not in field and ("min" in field or "max" in field):
        for word in text.split(","):
            _check(field, word.strip())
    return text


def _check(field, word):
    try:
        value = float(word) if field.get("type") in REALS else int(word, 0)
    except ValueError:
        return  # The command line reports this error.
    unit = f" {field['unit']}" if field["unit"] else ""
    if value < field.get("min", value):
        raise UsageError(f"{_label(field)}: {shortened(word)}{unit} is below {field['min']}{unit}")
    if value > field.get("max", value):
        raise UsageError(f"{_label(field)}: {shortened(word)}{unit} is above {field['max']}{unit}")


def _compact(field, values):
    return re.sub(r"\s", "", _text(field, values))


def _number_or_text(field, text):
    """JSON value of a field of a message. Digits become a number, because the catalogue would read them as text otherwise."""
    if field["coding"] in NUMBERS or field["coding"] == "bits":
        try:
            return int(text, 0)
        except ValueError:
            return text
    return text


def _group(fields, values, seen):
    """Values of a group of fields, by name."""
    if not isinstance(values, dict):
        raise UsageError(f"found {shortened(repr(values))}, expected values by name")
    given = {}
    for field in fields:
        if "repeat" in field:
            groups = values.get(field["name"]) or []
            if len(groups) < field["least"]:
                raise UsageError(f"{field['name']}: found {len(groups)} groups, expected at least {field['least']}")
            given[field["name"]] = [_group(field["fields"], group, dict(seen)) for group in groups]
        elif "choice" in field:
            given |= _group(field["cases"].get(str(seen.get(field["choice"])), ()), values, seen)
        elif not (field.get("optional") and not values.get(field["name"])):
            text = _text(field, values)
            given[field["name"]] = seen[field["name"]] = _number_or_text(field, text)
    return given


def _word(value):
    """Text of a value after `field=`: a text that would be read as JSON is quoted."""
    if not isinstance(value, str):
        return json.dumps(value)
    try:
        json.loads(value)
    except ValueError:
        return value
    return json.dumps(value)


# ---- Forms ----


def _plain(identity, name, kind, words):
    return Form(identity, name, kind, (), lambda values: list(words))


def _positional(identity, name, kind, words, *fields):
    return Form(identity, name, kind, fields, lambda values: [*words, *(_compact(field, values) for field in fields)])


def _choice(name, options):
    return {"name": name, "unit": "", "options": options if options and isinstance(options[0], dict) else _options(options)}


def _function(item, one):
    fields = tuple(_with_words(_field_of(argument), argument, item.get("enumerations", {})) for argument in one["arguments"])
    if one["name"] == "RAISE":
        events = [{"value": str(event["id"]), "name": f"{event['id']} {event['name']}"} for event in item["events"]]
        fields = tuple({**field, "options": events} if field["name"] == "EVENT" else field for field in fields)
    name = f"{item['name']}.{one['name']}"
    return Form(f"cmd {name}", name, "function", fields, lambda values: ["cmd", name, *(f"{field['name']}={_compact(field, values)}" for field in fields)])


def _setting(item, parameter):
    name = f"{item['name']}.{parameter['name']}"
    members = parameter.get("fields") or [parameter]
    fields = tuple(_with_words(_field_of(member), member, item.get("enumerations", {})) for member in members)
    return Form(f"set {name}", f"{name}: set", "TC[20,3]", fields, lambda values: ["set", name, ",".join(_compact(field, values) for field in fields)])


def _of_subsystem(item):
    name = item["name"]
    if not item.get("autostart"):
        yield _positional(f"state {name}", f"{name}: request state", "TC[129,1]", ("state", name), _choice("Target state", UPWARD + (REST_STATES[0], REST_STATES[4])))
        for verb in ("start", "stop"):
            yield _plain(f"process {verb} {name}", f"{name}: {verb} the process", "process", ("process", verb, name))
    configurations = [{"value": one["name"], "name": f"{one['id']} {one['name']}"} for one in item["configurations"]]
    yield _positional(f"config {name}", f"{name}: select configuration", "TC[129,3]", ("config", name), _choice("Configuration", configurations))
    yield from (_function(item, one) for one in item["functions"])
    yield _plain(f"ping {name}", f"{name}: ping", "TC[17,1]", ("ping", name))
    yield _plain(f"reload {name}", f"{name}: reload the descriptor", "TC[129,6]", ("reload", name))
    structures = sorted({hk["id"] for one in item["configurations"] for hk in one["housekeeping"]})
    number = {"name": "Structure", "unit": "", "type": "UINT16", "min": 0, "max": 65535, "hint": f"in the dictionary: {', '.join(map(str, structures))}"}
    for verb in STRUCTURE_VERBS:
        yield _positional(f"hk {verb} {name}", f"{name}: housekeeping {verb}", "service 3", ("hk", verb, name), number)
    cycles = {"name": "Interval", "unit": "cycles", "type": "UINT32", "min": 1, "max": 0xFFFFFFFF}
    yield _positional(f"hk interval {name}", f"{name}: housekeeping interval", "service 3", ("hk", "interval", name), number, cycles)
    events = _choice("Event", [event["name"] for event in item["events"]])
    for verb in ("enable", "disable"):
        yield _positional(f"event {verb} {name}", f"{name}: {verb} an event", "service 5", ("event", verb, name), events)
    for parameter in item["parameters"]:
        yield _plain(f"get {name}.{parameter['name']}", f"{name}.{parameter['name']}: get", "TC[20,1]", ("get", f"{name}.{parameter['name']}"))
        if parameter["settable"]:
            yield _setting(item, parameter)


def _having(dictionary, service):
    """Names of the subsystems that have a service."""
    return [item["name"] for item in dictionary.content["subsystems"] if service in item["services"]]


def _request(dictionary, entry):
    """Form of a request of the catalogue, for the subsystems that have its service."""
    message = f"{entry['service']},{entry['subtype']}"
    fields = tuple(_of_catalogue(dictionary.catalogue, entry["service"], field) for field in entry["fields"])
    subsystem = {"name": "Subsystem", "unit": "", "options": _options(_having(dictionary, entry["service"]))}

    def compose(values):
        given = _group(fields, {key: value for key, value in values.items() if key != "Subsystem"}, {})
        return ["tc", _text(subsystem, values), message, *(f"{name}={_word(value)}" for name, value in given.items())]

    return Form(f"tc {message}", f"TC[{message}] {entry['name']}", f"service {entry['service']}", (subsystem, *fields), compose)


def _of_mission(dictionary):
    for link in dictionary.links:
        for verb, ends in (("open", tuple(map(dictionary.name_of_apid, (link.producer, link.consumer)))), ("close", ())):
            yield replace(_plain(f"link {verb} {link.name}", f"link {link.name}: {verb}", "link", ("link", verb, link.name)), subsystems=ends)
    modes = [{"value": mode["name"], "name": f"{mode['id']} {mode['name']}"} for mode in dictionary.modes]
    yield _positional("mode", "mission mode", "TC[131,1]", ("mode",), _choice("Mode", modes))
    yield _positional("log", "packet log", "TC[131,3]", ("log",), _choice("Strategy", ("ascii", "sqlite", "ring")))
    for words, name in (("status", "status of all subsystems"), ("networks", "real-time networks"), ("link list", "list of links"), ("shutdown", "shut the mission down")):
        yield _plain(words, name, "mission", words.split())


def _of_world():
    """Forms of the lines of the live port, which are not telecommands."""
    for actor in live_forms.ACTORS:
        for verb, words in live_forms.verbs(actor):
            fields = tuple(live_forms.fields_of(words))
            start = (actor, verb)
            yield Form(f"{actor} {verb}", f"{actor} {verb}", "simulated world", fields, lambda values, start=start, fields=fields: live_forms.line_of(start, fields, values))


def _depending(name, form):
    """The form; with the name of its subsystem if the interface of the subsystem defines words or values of the form."""
    return form if form.kind in STANDARD else replace(form, subsystems=(name,))


class Forms:
    """All forms of a dictionary, by id."""

    def __init__(self, dictionary):
        self.by_id = {}
        for item in dictionary.content["subsystems"]:
            self._add(_depending(item["name"], form) for form in _of_subsystem(item))
        self._add(_of_mission(dictionary))
        self._add(_request(dictionary, entry) for entry in dictionary.catalogue.all("TC") if _having(dictionary, entry["service"]))
        self._add(_of_world())
        self._suggestions = _suggestions(dictionary) | live_forms.suggestions(dictionary)

    def _add(self, forms):
        self.by_id.update((form.id, form) for form in forms)

    def text(self, identity, values):
        """Words of the command line for the values of a form. Raises UsageError."""
        if identity not in self.by_id:
            raise UsageError(f"no form {quoted(identity)}")
        return shlex.join(self.by_id[identity].compose(values))

    def message(self):
        """All forms, and the names that fields suggest."""
        return {"forms": [form.message() for form in self.by_id.values()], "suggestions": self._suggestions}


def _suggestions(dictionary):
    subsystems = dictionary.subsystems.values()
    return {
        "subsystems": [{"value": str(item.apid), "name": item.name} for item in subsystems],
        "events": [{"value": str(event.id), "name": f"{item.name} {event.name}"} for item in subsystems for event in item.events.values()],
        "parameters": [{"value": f"{item.name}.{name}", "name": ""} for item in subsystems for name in item.parameters],
    }
