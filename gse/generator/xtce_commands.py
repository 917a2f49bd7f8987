# SPDX-License-Identifier: Apache-2.0
"""Commands of an XTCE database: one for each request of the catalogue, each function, and each parameter that can be set.

Each case of a choice is a command of its own. Repeated groups are an array; if a group contains a choice, or a value whose type
depends on the id before it, the command has one group, and such values are hexadecimal."""

import struct

import xtce_types as xt
from source import STATES
from xtce_reports import GROUPS, application_process, bits, fields_within, kind_type
from xtce_types import element

HEADER = (  # Name, bits, unit, description.
    ("apid", 11, "id", "application process that performs the request"), ("ack", 4, "flags", "which verification reports are wanted"),
    ("service", 8, "type", "service type"), ("subtype", 8, "type", "message subtype"), ("source", 16, "user", "ground user that sends it"),
)
ACK_ALL, UNSEGMENTED, PUS_VERSION = 15, 3, 2
# Name, element, subtype of the success, subtypes of failures, time limit [s].
STAGES = (
    ("Accepted", "AcceptedVerifier", 1, (2, 10), 30), ("Started", "ExecutionVerifier", 3, (4,), 60),
    ("Completed", "CompleteVerifier", 7, (6, 8), 600),
)
# This script replaces the PUS verifier of Yamcs, which supports neither TM[1,10] nor an APID with words.
VERIFIER = """
if (!sent_apid || !sent_sequence || !apid || !sequence || !subtype) return null;
if (sent_apid.rawValue != apid.rawValue || sent_sequence.value != sequence.rawValue) return null;
if (subtype.rawValue == %d) return true;
return [%s].indexOf(Number(subtype.rawValue)) < 0 ? null : String(failure_code.value);
"""
SUPERVISOR = "SUPERVISOR"
METHOD_ANY = 0xFF  # Transfer method of a link: any that both ends offer.
# Transaction, link, producer and its port, consumer and its port, layout hash and size, byte order, period, tolerance, method, queue depth,
# maximum age (docs/services/st130.md).
LINK_REQUEST = ">IHHHHHIIBIHBBI"


def _fixed(name, octets, count=None):
    return element("FixedValueEntry", name=name, binaryValue=octets.hex(), sizeInBits=count or 8 * len(octets))


def _argument_entry(name):
    return element("ArgumentRefEntry", argumentRef=name)


def base(root, service_path, source, catalogue):
    """The base command of all others: both headers, and the verifiers."""
    initial = {"ack": ACK_ALL, "source": source}
    types = {name: bits(root, "Argument", count, unit) for name, count, unit, _ in HEADER} | {"apid": application_process(root, "Argument", catalogue)}
    arguments = [
        element("Argument", name=name, argumentTypeRef=types[name], initialValue=initial.get(name), shortDescription=words)
        for name, _, _, words in HEADER
    ]
    entries = [
        _fixed("version_type_flag", b"\x03", 5), _argument_entry("apid"), _fixed("sequence_flags", bytes([UNSEGMENTED]), 2),
        _fixed("sequence_count", b"\0\0", 14), _fixed("length", b"\0\0"), _fixed("pus_version", bytes([PUS_VERSION]), 4),
        *(_argument_entry(name) for name, *_ in HEADER[1:]),
    ]
    verifiers = [_verifier(root.path, service_path, *stage) for stage in STAGES]
    root.commands.append(
        element(
            "MetaCommand", element("ArgumentList", *arguments),
            element("CommandContainer", element("EntryList", *entries), name="pus_tc"), element("VerifierSet", *verifiers),
            name="pus_tc", abstract="true", shortDescription="request of PUS-C",
        )
    )


def _verifier(root, service_path, name, tag, success, failures, seconds):
    """Verifier of one stage of ST[01]."""
    inputs = (
        ("/yamcs/cmd/arg/apid", "sent_apid"), ("/yamcs/cmdHist/ccsds-seqcount", "sent_sequence"),
        (f"{service_path}/request_apid", "apid"), (f"{service_path}/request_sequence_count", "sequence"),
        (f"{root}/subtype", "subtype"), (f"{service_path}/failure_code", "failure_code"),
    )
    listed = [element("InputParameterInstanceRef", parameterRef=path, inputName=name) for path, name in inputs]
    text = VERIFIER % (success, ", ".join(map(str, failures)))
    algorithm = element(
        "CustomAlgorithm", element("AlgorithmText", text, language="JavaScript"), element("InputSet", *listed),
        name=f"verify_{name.lower()}",
    )
    ends = {"yamcs.onFail": "FAIL"} | ({"yamcs.onSuccess": "SUCCESS", "yamcs.onTimeout": "FAIL"} if name == "Completed" else {})
    data = [element("AncillaryData", value, name=key) for key, value in ends.items()]
    window = element("CheckWindow", timeToStopChecking=f"PT{seconds}S", timeWindowIsRelativeTo="commandRelease")
    return element(tag, element("AncillaryDataSet", *data), algorithm, window, name=name)


def command(system, name, assignments, arguments, entries, description, alias, is_critical=False):
    """A command that refines the base: its own arguments (name, type, element) and entries."""
    given = [element("ArgumentAssignment", argumentName=key, argumentValue=value) for key, value in assignments.items()]
    root = system.root.path
    parent = element("BaseMetaCommand", element("ArgumentAssignmentList", *given), metaCommandRef=f"{root}/pus_tc")
    listed = element("ArgumentList", *(element("Argument", name=n, argumentTypeRef=t, shortDescription=words) for n, t, words in arguments))
    holder = element(
        "CommandContainer", element("EntryList", *entries), element("BaseContainer", containerRef=f"{root}/pus_tc"), name=name
    )
    words = "if it is sent by mistake, it can endanger the spacecraft or delete data that are stored on board"
    significance = element("DefaultSignificance", consequenceLevel="critical", reasonForWarning=words) if is_critical else None
    system.commands.append(
        element(
            "MetaCommand", xt.aliases(alias), parent, listed if arguments else None, holder, significance,
            name=name, shortDescription=description,
        )
    )


class Variant:
    """One variant of a request: arguments and entries so far, and the words of its choices."""

    def __init__(self):
        self.arguments, self.entries, self.words = [], [], []

    def copy(self):
        """A copy, to be continued separately."""
        made = Variant()
        made.arguments, made.entries, made.words = self.arguments[:], self.entries[:], self.words[:]
        return made

    def add(self, name, type_path, description):
        """Add an argument with an unused name."""
        taken = {one for one, *_ in self.arguments} | {one for one, *_ in HEADER}
        word, number = name, 2
        while word in taken:
            word, number = f"{name}_{number}", number + 1
        self.arguments.append((word, type_path, description))
        self.entries.append(_argument_entry(word))
        return word


class Request:
    """Commands of one request of the catalogue."""

    def __init__(self, system, catalogue, message):
        self.system, self.catalogue, self.message = system, catalogue, message

    def fields(self, fields, variants):
        """Extend all variants by these fields; returns the resulting variants."""
        selectors = {field["choice"] for field in fields if "choice" in field}
        for field in fields:
            if field.get("name") in selectors:
                continue
            if "choice" in field:
                variants = self.choice(field, fields, variants)
            elif "repeat" in field:
                variants = self.repeat(field, variants)
            else:
                for variant in variants:
                    variant.add(field["name"], self.type(field), self.meaning(field))
        return variants

    def type(self, field):
        """Path of the type of an argument."""
        root = self.system.root
        if field["kind"] in ("value", "auxiliary"):
            return root.type("Argument", "octets", lambda made: xt.binary("Argument", made, -1))
        path = kind_type(self.system, "Argument", self.catalogue, self.message["service"], field)
        if path is not None:
            return path
        coding = self.catalogue["kinds"][field["kind"]]["coding"]
        makers = {"text": xt.text, "octets": xt.octets}
        if coding in makers:
            return root.type("Argument", f"sized_{coding}", lambda made: makers[coding]("Argument", made))
        return root.type("Argument", "octets", lambda made: xt.binary("Argument", made, -1))

    def meaning(self, field):
        """Description of an argument."""
        if field["kind"] in ("value", "auxiliary"):
            return f"hexadecimal octets, of the type that {field['of']} says"
        return f"{field['name'].replace('_', ' ')}: {self.catalogue['kinds'][field['kind']]['meaning']}"

    def choice(self, field, fields, variants):
        """Make a variant for each case of a choice."""
        selector = next(one for one in fields if one.get("name") == field["choice"])
        words = self.catalogue["services"][self.message["service"]]["enumerations"].get(field["choice"], {})
        words = {int(number): word for number, word in words.items()}
        found = []
        for number, case in field["cases"].items():
            started = [variant.copy() for variant in variants]
            for variant in started:
                variant.entries.append(_fixed(selector["name"], bytes([int(number)])))
                variant.words.append(words.get(int(number), number))
            found += self.fields(case, started)
        return found

    def repeat(self, field, variants):
        """An array of groups with its count, or one group."""
        inner = field["fields"]
        if any("choice" in one or one.get("kind") == "value" for one in fields_within(inner)):
            for variant in variants:
                variant.entries.append(_fixed(field["repeat"], b"\1"))
            return self.fields(inner, variants)
        for variant in variants:
            count = variant.add(field["repeat"], xt.scalar(self.system.root, "Argument", "UINT8", GROUPS), "number of groups")
            item = self.group(inner, count)
            variant.add(self.array_name(field), self.array(item, count), f"groups, as many as {count} says")
        return variants

    @staticmethod
    def array_name(field):
        """Name of the array of a repetition."""
        return f"{field['repeat']}_groups"

    def array(self, item, count):
        """Path of the type of an array whose length is the argument or member `count`."""
        name = f"{item.rpartition('/')[2]}_by_{count}"
        return self.system.type("Argument", name, lambda made: xt.array("Argument", made, item, count))

    def group(self, inner, count):
        """Path of the type of one group."""
        members = []
        for field in inner:
            if "repeat" in field:
                members.append((field["repeat"], xt.scalar(self.system.root, "Argument", "UINT8", GROUPS), "number of groups"))
                inside = self.array(self.group(field["fields"], field["repeat"]), field["repeat"])
                members.append((self.array_name(field), inside, f"groups, as many as {field['repeat']} says"))
            else:
                members.append((field["name"], self.type(field), self.meaning(field)))
        if len(members) == 1:
            return members[0][1]
        name = f"tc{self.message['subtype']}_{count}_group"
        return self.system.type("Argument", name, lambda made: xt.aggregate("Argument", made, members))


def request(system, catalogue, message):
    """Commands of one request of the catalogue."""
    service, subtype = message["service"], message["subtype"]
    for variant in Request(system, catalogue, message).fields(message["fields"], [Variant()]):
        suffix = "".join("_" + "".join(c if c.isalnum() else "_" for c in word).upper() for word in variant.words)
        description = message["name"] + "".join(f", {word}" for word in variant.words)
        assignments = {"service": service, "subtype": subtype}
        name = message["identifier"] + suffix
        command(system, name, assignments, variant.arguments, variant.entries, description, f"TC[{service},{subtype}]", message["is_critical"])


def _typed(system, owner, field):
    return xt.field_type(system, "Argument", owner, field)


def _of_function(function):
    states = "any state" if len(function["states"]) == len(STATES) else ", ".join(function["states"])
    return f"{function['description']}; in {states}" if function.get("description") else f"in {states}"


def functions(system, subsystem):
    """A command for each function: TC[8,1]."""
    for function in subsystem["functions"]:
        given = function["arguments"]
        entries = [_fixed("function_id", function["name"].encode("ascii").ljust(8, b"\0")), _fixed("n", bytes([len(given)]))]
        arguments = []
        for one in given:
            entries += [_fixed(f"{one['name']}_id", one["id"].to_bytes(2, "big")), _argument_entry(one["name"])]
            arguments.append((one["name"], _typed(system, function["name"], one), one.get("description") or f"{one['name']} of {function['name']}"))
        assignments = {"apid": subsystem["name"], "service": 8, "subtype": 1}
        command(system, function["name"], assignments, arguments, entries, _of_function(function), "TC[8,1]", function["critical"])


def settings(system, subsystem):
    """A command to set each parameter that can be set: TC[20,3]."""
    for parameter in subsystem["parameters"]:
        if not parameter["settable"]:
            continue
        identifier = parameter["parameter_id"].to_bytes(4, "big")
        entries, arguments = [_fixed("n", b"\1"), _fixed("parameter_id", identifier)], []
        for one in parameter.get("fields", [parameter]):
            entries.append(_argument_entry(one["name"]))
            arguments.append((one["name"], _typed(system, f"set_{parameter['name']}", one), one.get("description") or f"{one['name']} of {parameter['name']}"))
        assignments = {"apid": subsystem["name"], "service": 20, "subtype": 3}
        command(system, f"SET_{parameter['name']}", assignments, arguments, entries, f"set {parameter['name']}", "TC[20,3]")


def management(system, subsystem, catalogue):
    """Commands of service 129 with the words of one subsystem; an infrastructure subsystem has no states to be requested."""
    apid = {"apid": subsystem["name"], "service": 129}
    configurations = {one["id"]: one["name"] for one in subsystem["configurations"]}
    states = catalogue["services"][129]["enumerations"]["target"]
    target = system.root.type("Argument", "state_request", lambda made: xt.enumeration("Argument", made, states, 8))
    selected = system.type("Argument", "configuration", lambda made: xt.enumeration("Argument", made, configurations, 16))
    for name, subtype, arguments, words in (
        ("REQUEST_STATE", 1, [("target", target, "state to reach")], "request a state"),
        ("SELECT_CONFIGURATION", 3, [("configuration", selected, "configuration to select")], "select a configuration"),
        ("REPORT_STATUS", 4, [], "report state, phase, configuration and hashes"),
        ("RELOAD", 6, [], "read the descriptor again"),
    ):
        if arguments and subsystem["autostart"]:
            continue
        entries = [_argument_entry(argument) for argument, *_ in arguments]
        command(system, name, apid | {"subtype": subtype}, arguments, entries, words, f"TC[129,{subtype}]", name in ("REQUEST_STATE", "RELOAD"))


def link_request(system, dictionary, link):
    """The request for one link of the mission: TC[130,3] with the properties of its ports, as `gse link open` sends it."""
    ports = {}
    for subsystem in dictionary["subsystems"]:
        for configuration in subsystem["configurations"]:
            for role in ("provides", "requires"):
                ports |= {(subsystem["apid"], role, port["id"]): port for port in configuration[role]}
    producer = ports[link["producer_apid"], "provides", link["producer_port"]]
    consumer = ports[link["consumer_apid"], "requires", link["consumer_port"]]
    octets = struct.pack(
        LINK_REQUEST, link["number"], 0, link["producer_apid"], link["producer_port"], link["consumer_apid"], link["consumer_port"],
        producer["layout_hash"], producer["octets"], 0, producer["period_us"], 0, METHOD_ANY, 1, consumer["stale_us"],
    )
    assignments = {"apid": SUPERVISOR, "service": 130, "subtype": 3}
    description = f"request the link {link['from']} to {link['to']}; LINK_OPEN opens it"
    command(system, f"LINK_REQUEST_{link['name']}", assignments, [], [_fixed("link", octets)], description, "TC[130,3]")
