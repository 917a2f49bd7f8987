# SPDX-License-Identifier: Apache-2.0
"""Containers of an XTCE database: the reports of the catalogue, housekeeping structures and events.

Repeated groups of equal size are arrays of aggregates. Other groups have a container of one group, which is entered `count` times. In such
a container a reader of the database can use only a length that the container itself contains, and only conditions decide whether an entry
is present. Therefore each bit of a nested count is a parameter of its own: if it is 1, the nested group is entered as many times as the
weight of the bit. A value after a parameter id is one of several parameters, one for each scalar type; the layout within the id selects it.
Auxiliary parameters have names with two underscores."""

import xtce_types as xt
from identifiers import Identifiers, subject_of
from xtce_types import element

TM_HEADER, PRIMARY, CRC = 21, 6, 2
LAYOUT_BITS, NUMBER_BITS, ID_BITS = 5, 16, 32
APID_BITS = 11
GROUPS = "groups"
OF_PARAMETER = "as the parameter"
COUNT_BITS = 12  # No packet contains more groups.
NUMBERS = {"u8": "UINT8", "u16": "UINT16", "u32": "UINT32", "u64": "UINT64"}
NUMBERS |= {"i16": "INT16", "i32": "INT32", "i64": "INT64", "f64": "DOUBLE"}
OCTETS = {"time": 8, "reltime": 7, "cds": 8, "position": 6, "name": 8, "id": 4, "layout": 1}
OCTETS |= {coding: xt.SCALARS.get(kind, (64,))[0] // 8 for coding, kind in NUMBERS.items()}
HEADER = (  # Name, bits, unit.
    ("ccsds_version", 3, "version"), ("ccsds_type", 1, "type"), ("secondary_header_flag", 1, "flag"), ("apid", 11, "id"),
    ("sequence_flags", 2, "flags"), ("sequence_count", 14, "packets"), ("packet_length", 16, "octets - 1"),
)
SECONDARY = (
    ("pus_version", 4, "version"), ("time_status", 4, "state"), ("service", 8, "type"), ("subtype", 8, "type"),
    ("message_counter", 16, "packets"), ("destination", 16, "user"),
)
REQUEST = (
    ("request_version", 3, "version"), ("request_type", 1, "type"), ("request_header_flag", 1, "flag"), ("request_apid", 11, "id"),
    ("request_sequence_flags", 2, "flags"), ("request_sequence_count", 14, "packets"),
)


def name_of(catalogue, service, subtype):
    """Name of a message."""
    return next(one["identifier"] for one in catalogue["services"][service]["messages"] if one["subtype"] == subtype)


def application_process(root, what, catalogue):
    """Path of the type of an application process in a primary header."""
    return root.type(what, "application_process", lambda name: xt.enumeration(what, name, catalogue["words"]["apid"], APID_BITS))


def bits(root, what, count, unit=""):
    """Path of the type of an unsigned number with this number of bits."""
    own = f"bits{count}" + (f"_{xt.unit_word(unit)}" if unit else "")
    return root.type(what, own, lambda name: xt.integer(what, name, count, unit=unit))


def kind_type(system, what, catalogue, service, field):
    """Path of the type of a field of fixed size; None if its size depends on the message."""
    root, kind = system.root, catalogue["kinds"][field["kind"]]
    coding, name = kind["coding"], field["kind"]
    words = catalogue["services"][service]["enumerations"].get(field["name"])
    if catalogue["words"].get(name):
        return root.type(what, name, lambda made: xt.enumeration(what, made, catalogue["words"][name], 8 * OCTETS[coding]))
    if name == "failure_code":
        return root.type(what, name, lambda made: xt.enumeration(what, made, catalogue["failures"], 16))
    if name == "bool8":
        return xt.scalar(root, what, "BOOL")
    if words:
        return system.type(what, field["name"], lambda made: xt.enumeration(what, made, words, 8 * OCTETS[coding]))
    if coding in NUMBERS:
        return xt.scalar(root, what, NUMBERS[coding], kind["unit"])
    if coding == "bits":
        return bits(root, what, kind["size"], kind["unit"])
    makers = {
        "time": lambda made: xt.cuc_time(what, made),
        "reltime": lambda made: xt.fraction(what, made, 56, 24, "s"),
        "position": lambda made: xt.fraction(what, made, 48, 16, "orbits"),
        "name": lambda made: xt.label(what, made, 8),
        "id": lambda made: xt.enumeration(what, made, catalogue["parameters"], ID_BITS),
        "layout": lambda made: xt.enumeration(what, made, catalogue["layouts"], 8),
        "cds": lambda made: _members(root, what, made, (("day", "UINT16", "d"), ("ms", "UINT32", "ms"), ("us", "UINT16", "us"))),
    }
    if coding in makers:
        return root.type(what, name, makers[coding])
    if coding == "octets" and "size" in kind:
        return root.type(what, f"octets{kind['size']}", lambda made: xt.binary(what, made, kind["size"]))
    return None


def _members(root, what, name, members):
    return xt.aggregate(what, name, [(member, xt.scalar(root, what, kind, unit), f"{member} of the value") for member, kind, unit in members])


def is_plain(fields, catalogue):
    """True if all groups of these fields have one size."""
    for field in fields:
        if "kind" not in field or field["kind"] in ("value", "auxiliary"):
            return False
        kind = catalogue["kinds"][field["kind"]]
        if kind["coding"] in ("text", "packet", "rest") or (kind["coding"] == "octets" and "size" not in kind):
            return False
    return True


def comparison(path, value, operator=None):
    return element("Comparison", parameterRef=path, comparisonOperator=operator, value=value, useCalibratedValue="false")


def container(name, entries, base=None, restrictions=(), description=None, period_s=None, alias=None):
    """A container that is derived from another if all restrictions are met; alias: the type of the message."""
    parent = None
    if base:
        held = [comparison(*restriction) for restriction in restrictions]
        criteria = held[0] if len(held) == 1 else element("ComparisonList", *held)
        parent = element("BaseContainer", element("RestrictionCriteria", criteria), containerRef=base)
    rate = element("DefaultRateInStream", basis="perSecond", minimumValue=1 / period_s) if period_s else None
    return element(
        "SequenceContainer", xt.aliases(alias), rate, element("EntryList", *entries), parent,
        name=name, shortDescription=description,
    )


def _meaning(word):
    """Description of an entry that the catalogue describes by its position only."""
    if "__" in word:
        return "determines the position of the entries after it"
    if word in ("n", "n1", "n2", "n3", "nfa"):
        return "number of groups"
    return "groups, as many as the number before them" if word.endswith("_groups") else word.replace("_", " ")


class Message:
    """Entries of one report of the catalogue."""

    def __init__(self, system, catalogue, message, prefix, is_group=False):
        self.system, self.catalogue, self.message, self.prefix = system, catalogue, message, prefix
        self.is_group = is_group
        self.entries, self.conditions, self.taken = [], [], set()
        self.offset = TM_HEADER  # Offset of the next entry [octets]; None after an entry of variable size.
        self.layouts, self.numbers, self.shift = {}, {}, 0

    def name(self, word):
        """A name that is unused in this report."""
        name, number = f"{self.prefix}{word}", 2
        while name in self.taken:
            name, number = f"{self.prefix}{word}_{number}", number + 1
        self.taken.add(name)
        return name

    def enter(self, tag, child=None, extra=(), **reference):
        """Add an entry with the present conditions, after a gap of some bits if there is one."""
        location = None
        if self.shift:
            fixed = element("FixedValue", str(self.shift))
            location = element("LocationInContainerInBits", fixed, referenceLocation="previousEntry")
            self.shift = 0
        conditions = [comparison(path, value) for path, value in (*self.conditions, *extra)]
        include = None
        if conditions:
            held = conditions[0] if len(conditions) == 1 else element("ComparisonList", *conditions)
            include = element("IncludeCondition", held)
        repeat = child if child is not None and child.tag == "RepeatEntry" else None
        instance = child if repeat is None else None
        self.entries.append(element(tag, location, repeat, include, instance, **reference))

    def parameter(self, word, type_path, extra=(), description=None):
        """Enter a new parameter. Returns its path."""
        path = self.system.parameter(self.name(word), type_path, description or _meaning(word))
        self.enter("ParameterRefEntry", extra=extra, parameterRef=path)
        return path

    def fields(self, fields):
        """Enter all fields of a group."""
        for field in fields:
            if "repeat" in field:
                self.repeat(field)
            elif "choice" in field:
                self.choice(field)
            elif "kind" in field and field["kind"] == "value":
                self.value(field)
            elif "kind" in field and field["kind"] != "auxiliary":
                self.field(field, any(other.get("of") == field["name"] for other in fields_within(fields)))

    def field(self, field, is_id):
        """Enter a field of a kind."""
        kind, name = self.catalogue["kinds"][field["kind"]], field["name"]
        type_path = kind_type(self.system, "Parameter", self.catalogue, self.message["service"], field)
        if field["kind"] == "failure_detail":
            root = self.system.root
            members = (("instruction", "UINT16", "number"), ("detail", "UINT32", "value"))
            type_path = root.type("Parameter", "failure_data", lambda made: _members(root, "Parameter", made, members))
        if type_path is None:
            self.variable(kind["coding"], name)
            return
        path = self.parameter(name, type_path, description=kind["meaning"])
        self.numbers[name] = path
        size = kind["size"] if kind["coding"] == "octets" else OCTETS.get(kind["coding"])
        self.offset = None if self.offset is None or size is None else self.offset + size
        if is_id and kind["coding"] == "id":
            self.shift = -(NUMBER_BITS + LAYOUT_BITS)
            layout = self.system.root.type(
                "Parameter", "layout_of_value", lambda made: xt.enumeration("Parameter", made, self.catalogue["layouts"], LAYOUT_BITS)
            )
            self.layouts[name] = (path, self.parameter(f"{name}__layout", layout))
            self.shift = NUMBER_BITS

    def variable(self, coding, name):
        """Enter text, octets or a request with its length field, or all octets up to the checksum."""
        if coding == "rest":
            beyond = PRIMARY + 1 - self.offset - CRC
            length = f"{self.system.root.path}/packet_length"
            self.sized(name, lambda made: xt.octets_of(made, length, beyond))
            return
        root = self.system.root
        if coding == "packet":  # Its length field is the number of following octets minus one.
            self.parameter(f"{name}__head", root.type("Parameter", "octets4", lambda made: xt.binary("Parameter", made, 4)))
            self.parameter(name, root.type("Parameter", "sized_octets", lambda made: xt.octets("Parameter", made)))
            self.parameter(f"{name}__end", root.type("Parameter", "octets1", lambda made: xt.binary("Parameter", made, 1)))
        elif self.is_group:
            make = xt.text if coding == "text" else xt.octets
            self.parameter(name, root.type("Parameter", f"sized_{coding}", lambda made: make("Parameter", made)))
        else:
            length = self.parameter(f"{name}__length", xt.scalar(root, "Parameter", "UINT16", "octets"))
            self.sized(name, lambda made: (xt.text_of if coding == "text" else xt.octets_of)(made, length))
        self.offset = None

    def sized(self, name, make):
        """Enter a parameter with a type that only this parameter uses."""
        self.parameter(name, self.system.type("Parameter", f"{self.prefix}{name}_type", make))

    def repeat(self, field):
        """Enter a count, and the number of groups that it contains."""
        count = self.parameter(field["repeat"], xt.scalar(self.system.root, "Parameter", "UINT16", GROUPS))
        inner, name = field["fields"], f"{field['repeat']}_groups"
        self.offset = None
        if is_plain(inner, self.catalogue) and not self.is_group:
            service, own = self.message["service"], f"{self.prefix}{name}"
            kinds = self.catalogue["kinds"]
            members = [(one["name"], kind_type(self.system, "Parameter", self.catalogue, service, one), kinds[one["kind"]]["meaning"]) for one in inner]
            item = members[0][1]
            if len(members) > 1:
                item = self.system.type("Parameter", f"{own}_group", lambda made: xt.aggregate("Parameter", made, members))
            self.parameter(name, self.system.type("Parameter", own, lambda made: xt.array("Parameter", made, item, count)))
            return
        group = Message(self.system, self.catalogue, self.message, self.prefix, is_group=True)
        group.taken, group.offset = self.taken, None
        group.fields(inner)
        if group.shift:
            nothing = self.system.root.type("Parameter", "nothing", lambda made: xt.binary("Parameter", made, 0))
            group.parameter("__end", nothing)
        path = self.name(f"{name}_group")
        self.system.containers.append(container(path, group.entries))
        self.enter_groups(f"{self.system.path}/{path}", field["repeat"], count)

    def enter_groups(self, path, word, count):
        """Enter a container `count` times."""
        if not self.is_group:
            repeat = element("RepeatEntry", element("Count", element("DynamicValue", xt.reference(count))))
            self.enter("ContainerRefEntry", repeat, containerRef=path)
            return
        self.shift = -COUNT_BITS
        one = self.system.root.type("Parameter", "flag", lambda made: xt.boolean("Parameter", made, 1))
        weights = [(1 << bit, self.parameter(f"{word}__bit{bit}", one)) for bit in reversed(range(COUNT_BITS))]
        for weight, bit in weights:
            repeat = element("RepeatEntry", element("Count", element("FixedValue", str(weight))))
            self.enter("ContainerRefEntry", repeat, extra=((bit, 1),), containerRef=path)

    def choice(self, field):
        """Enter the fields of each case under the condition of its selector."""
        selector = self.numbers[field["choice"]]
        for number, case in field["cases"].items():
            self.conditions.append((selector, number))
            self.fields(case)
            self.conditions.pop()
        self.offset = None

    def value(self, field):
        """Enter a value whose type follows from the id before it."""
        if field["of"] not in self.layouts:
            self.variable("rest", field["name"])
            return
        identifier, layout = self.layouts[field["of"]]
        if (self.message["service"], self.message["subtype"]) == (20, 2):
            instance = element("ParameterInstance", parameterRef=identifier, useCalibratedValue="false")
            self.enter("IndirectParameterRefEntry", instance, aliasNameSpace="id")
            return
        shift = self.shift
        for code, kind in self.catalogue["layouts"].items():
            self.shift = shift  # A packet contains only one of these parameters, at the same position.
            type_path = xt.scalar(self.system.root, "Parameter", kind, OF_PARAMETER)
            self.parameter(f"{field['name']}_{kind}", type_path, extra=((layout, code),), description=f"value of the parameter before it, if that is {kind}")
        self.offset = None


def fields_within(fields):
    """All fields of a group and of the groups and cases within."""
    found = []
    for field in fields:
        found.append(field)
        found += fields_within(field.get("fields", []))
        for case in field.get("cases", {}).values():
            found += fields_within(case)
    return found


def headers(root, catalogue):
    """Containers of the primary header, of a report and of the time packet."""
    root.parameter("apid", application_process(root, "Parameter", catalogue), "application process that has made the packet")

    def header(name, count, unit):
        return _entry(root.parameter(name, bits(root, "Parameter", count, unit), f"{name.replace('_', ' ')} of the header"))

    entries = [header(*each) for each in HEADER]
    root.containers.append(container("ccsds", entries, description="space packet"))
    entries = [header(*each) for each in SECONDARY]
    time = root.type("Parameter", "time_abs", lambda made: xt.cuc_time("Parameter", made))
    entries.append(_entry(root.parameter("time", time, "time of the packet")))
    flag = f"{root.path}/secondary_header_flag"
    root.containers.append(
        container("pus_tm", entries, f"{root.path}/ccsds", [(flag, 1)], description="report of PUS-C")
    )


def _entry(path):
    return element("ParameterRefEntry", parameterRef=path)


def entry_at(path, octet, conditions=()):
    """Entry of a parameter at an octet of the packet, if all conditions (path, value, operator) hold."""
    fixed = element("FixedValue", str(8 * octet))
    location = element("LocationInContainerInBits", fixed, referenceLocation="containerStart")
    held = [comparison(*condition) for condition in conditions]
    include = element("IncludeCondition", held[0] if len(held) == 1 else element("ComparisonList", *held)) if held else None
    return element("ParameterRefEntry", location, include, parameterRef=path)


def report(system, catalogue, message):
    """Container of one report of the catalogue."""
    root, service, subtype = system.root.path, message["service"], message["subtype"]
    shared = service in (1, 5)
    writer = Message(system, catalogue, message, "" if shared else f"tm{subtype}_")
    fields = message["fields"]
    if service == 1:
        for name, count, unit in REQUEST:
            writer.parameter(name, bits(system.root, "Parameter", count, unit), description=f"{name.replace('_', ' ')} of the request that is verified")
        fields = fields[1:]
    if service == 5 and subtype <= 4:
        fields = fields[:1]  # Containers of the subsystems follow for the name and the values: each may use the number for another event.
    if service == 3 and "values" in fields[-1]:
        fields = fields[:1]
    writer.fields(fields)
    restrictions = [(f"{root}/service", service), (f"{root}/subtype", subtype)]
    system.containers.append(
        container(message["identifier"], writer.entries, f"{root}/pus_tm", restrictions, description=message["name"], alias=f"TM[{service},{subtype}]")
    )


# ---- layouts of the descriptors ----


def parameter_type(system, parameter):
    """Path of the type of a parameter of the descriptors."""
    if "fields" not in parameter:
        return xt.field_type(system, "Parameter", "", parameter)
    members = [
        (one["name"], xt.field_type(system, "Parameter", parameter["name"], one), one.get("description", "")) for one in parameter["fields"]
    ]
    return system.type("Parameter", f"{parameter['name']}_struct", lambda made: xt.aggregate("Parameter", made, members))


def parameter_path(system, known, name):
    """Path and octets of a parameter, or of a member NAME.FIELD; created on first use."""
    head, _, tail = name.partition(".")
    parameter = known[head]
    if not tail:
        words = parameter.get("description") or f"{', '.join(one['name'] for one in parameter.get('fields', [parameter]))}"
        path = system.parameter(name, parameter_type(system, parameter), words, parameter["parameter_id"])
        return path, parameter["size"]
    field = next(one for one in parameter["fields"] if one["name"] == tail)
    path = system.parameter(f"{head}_{tail}".replace(".", "_"), xt.field_type(system, "Parameter", head, field), field.get("description"))
    return path, field["count"] * octets(field["type"])


def octets(kind):
    return {"BOOL": 1, "FLOAT": 4, "DOUBLE": 8}.get(kind) or xt.SCALARS[kind][0] // 8


def _layout(system, known, structure):
    """Entries of a housekeeping structure, and its size in octets. The fields of structures are separate parameters, because Yamcs
    raises no alarm for a member of an aggregate."""
    entries, total = [], 0
    for name in structure["once"]:
        fields = known[name].get("fields") if "." not in name else None
        for part in [f"{name}.{one['name']}" for one in fields] if fields else [name]:
            path, size = parameter_path(system, known, part)
            entries.append(_entry(path))
            total += size
    for number, repeated in enumerate(structure["repeated"], 1):
        members = []
        for name in repeated["parameters"]:
            path, size = parameter_path(system, known, name)
            one = system.parameters[path.rpartition("/")[2]]
            members.append((one.get("name"), one.get("parameterTypeRef"), one.get("shortDescription")))
            total += repeated["nrep"] * size
        own = f"HK_{structure['id']}_samples_{number}_" + "_".join(member for member, *_ in members)
        item = system.type("Parameter", f"{own}_sample", lambda made, m=members: xt.aggregate("Parameter", made, m))
        own, times = f"{own}_x{repeated['nrep']}", repeated["nrep"]
        many = system.type("Parameter", own, lambda made, i=item, n=times: xt.array("Parameter", made, i, n))
        entries.append(_entry(system.parameter(own, many, f"{times} samples in the order of time")))
    return entries, total


def housekeeping(system, subsystem, report_name, base):
    """Containers of a subsystem's structures; structures with the same id are distinguished by the length of the packet."""
    known = {parameter["name"]: parameter for parameter in subsystem["parameters"]}
    found = {}
    for configuration in subsystem["configurations"]:
        for structure in configuration["housekeeping"]:
            entries, size = _layout(system, known, structure)
            found.setdefault(structure["id"], {}).setdefault(size, (entries, structure, configuration["name"]))
    root = system.root.path
    for identifier, layouts in found.items():
        for size, (entries, structure, configuration) in layouts.items():
            restrictions = [(f"{root}/apid", subsystem["apid"]), (f"{base.path}/tm25_hk_structure_id", identifier)]
            name = f"HK_{identifier}"
            if len(layouts) > 1:
                length = TM_HEADER + 2 + size + CRC - PRIMARY - 1
                restrictions.append((f"{root}/packet_length", length))
                name += f"_{configuration}"
            period = structure["period_us"] / 1e6 or None
            system.containers.append(container(name, entries, f"{base.path}/{report_name}", restrictions, period_s=period))


def _shown(name, item):
    """A value of an event in the text that Yamcs shows. The number stands beside the name of what it identifies: Yamcs writes UNDEF for a number
    that has no name."""
    if item.get("kind") == "CANopen object":
        return f"{{{name}.raw; 0x%06X}}"  # index and subindex
    return f"{{{name}}} ({{{name}.raw}})" if "words" in item and "kind" in item else f"{{{name}}}"


def _name_in(event, one):
    return f"{event['name']}_{one['name']}"


def _value_of_event(system, event, one, item):
    """Path of the parameter for a value of an event; item: the value with its words."""
    words = one.get("description") or f"{one['name']} of the event {event['name']}"
    return system.parameter(_name_in(event, one), xt.field_type(system, "Parameter", event["name"], item), words)


def _of_each_subsystem(system, dictionary, event, one):
    """(name of the subsystem, path of the parameter for a value of an event, conditions) for each subsystem that the value may be about:
    different subsystems use a number for different things. The parameters have the same names, in a space system of their own for each
    subsystem. UNKNOWN: the number without a name, if no subsystem has the APID."""
    apid = f"{system.path}/{event['name']}_{subject_of(one, event)}"
    whose = {subsystem["name"]: subsystem for subsystem in dictionary["subsystems"]}
    for name, subsystem in [*whose.items(), ("UNKNOWN", None)]:
        within = next((child for child in system.children if child.name == f"ABOUT_{name}"), None) or xt.System(f"ABOUT_{name}", system)
        item = Identifiers(dictionary, subsystem).worded(one, {"parameters": []}) if subsystem else one
        those = [(apid, subsystem["apid"])] if subsystem else [(apid, other["apid"], "!=") for other in whose.values()]
        yield name, _value_of_event(within, event, one, item), those


def _about_others(system, dictionary, event, values):
    """Containers of the values of an event, each with its octet in the packet, that identify events or configurations of one other subsystem:
    one for each subsystem."""
    base, found = f"{system.path}/EVENT_{event['name']}", {}
    for one, octet in values:
        for name, path, those in _of_each_subsystem(system, dictionary, event, one):
            found.setdefault(name, (those, []))[1].append(entry_at(path, octet))
    for name, (those, entries) in found.items():
        system.containers.append(container(f"EVENT_{event['name']}_{name}", entries, base, those))


def _others_in(event):
    """Names of the values for `_about_others`: those about the first other subsystem. Values about a second other subsystem are entries with
    conditions, because only one container can inherit from the container of the event."""
    found = [(subject_of(one, event), one["name"]) for one in event["parameters"] if isinstance(one, dict)]
    first = next((subject for subject, _ in found if subject), None)
    return {name for subject, name in found if subject and subject == first}


def events(system, dictionary, subsystem, catalogue, base, severities):
    """Containers of a subsystem's events; rows of the event templates for Yamcs. Values that follow one about another subsystem are at their
    octets in the packet."""
    known = {parameter["name"]: parameter for parameter in subsystem["parameters"]}
    words = {event["id"]: event["name"] for event in subsystem["events"]}
    kind = system.type("Parameter", "last_event", lambda made: xt.enumeration("Parameter", made, words, 16))
    own = system.parameter("LAST_EVENT", kind, f"last event of {subsystem['name']}") if words else None
    rows, identified = [], Identifiers(dictionary, subsystem)
    for event in subsystem["events"]:
        entries, shown, about, octet, others = [], [], [], TM_HEADER + 2, _others_in(event)
        for one in event["parameters"]:
            if isinstance(one, dict):
                size, item = one["count"] * octets(one["type"]), identified.worded(one, event)
                shown.append(f"{one['name'].lower()} {_shown(_name_in(event, one), item)}")
                about += [(one, octet)] if one["name"] in others else []
                is_other = subject_of(one, event) is not None
                path = None if is_other else _value_of_event(system, event, one, item)
                if is_other and one["name"] not in others:
                    entries += [entry_at(each, octet, those) for _, each, those in _of_each_subsystem(system, dictionary, event, one)]
            else:
                path, size = parameter_path(system, known, one)
            if path:
                entries.append(entry_at(path, octet) if about else _entry(path))
            octet += size
        subtype = severities.index(event["severity"]) + 1
        restrictions = [
            (f"{system.root.path}/apid", subsystem["apid"]), (f"{base.path}/event_definition_id", event["id"])
        ]
        entries.append(entry_at(own, TM_HEADER))
        report = f"{base.path}/{name_of(catalogue, 5, subtype)}"
        system.containers.append(container(f"EVENT_{event['name']}", entries, report, restrictions, description=event.get("description")))
        if about:
            _about_others(system, dictionary, event, about)
        text = " ".join([subsystem["name"], event["name"], *shown])
        rows.append({"eventId": f"{event['name']}-{subsystem['apid']}", "template": text})
    return rows
