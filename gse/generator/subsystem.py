# SPDX-License-Identifier: Apache-2.0
"""Read subsystem descriptors: from XML to a checked model, with interface hash and configuration hash."""

import binascii
import re
from dataclasses import dataclass, field

import names
from device import device_of
from loop import loop_of, services_once
from services import compiled, service_of
from source import (
    LAYOUT_ARRAY,
    LAYOUT_STRUCT,
    METHODS,
    NUMBER_OUT_OF_RANGE,
    SEVERITIES,
    STATES,
    TYPES,
    canonical,
    fnv64,
    read,
    read_number,
    unique,
)

# Elements of the file by (parent, element), with their attributes; `!` marks a required one (source.read).
FIELD = "name! id type! count unit init min max enumeration"
SYNC_ORDERS = ("AFTER_COMMANDS", "BEFORE_COMMANDS")
PORT_FIELD = "name! type! count unit enumeration"
TABLE = {
    ("", "Subsystem"): "name! id! samplingTime sync",
    ("Subsystem", "Resources"): "poolWarning poolClear",
    ("Subsystem", "States"): "",
    ("States", "State"): "name! timeout!",
    ("Subsystem", "Enumerations"): "",
    ("Enumerations", "Enumeration"): "name! first values!",
    ("Subsystem", "Failures"): "",
    ("Failures", "Failure"): "name! id! detail",
    ("Subsystem", "Parameters"): "",
    ("Parameters", "StructRef"): "name! id! type! settable",
    ("StructRef", "ParamRef"): FIELD,
    ("StructRef", "StructRef"): "name! id type!",
    ("Parameters", "ParamRef"): "name! id! type! count unit init min max enumeration settable",
    ("Subsystem", "Events"): "",
    ("Events", "Event"): "name! id! severity! rate burst",
    ("Event", "ParamRef"): "name! type count unit enumeration",
    ("Subsystem", "Functions"): "",
    ("Functions", "Function"): "name! id! states! configurations critical",
    ("Function", "Argument"): "name! id! type! count unit min max enumeration",
    ("Subsystem", "Services"): "",
    ("Services", "Service"): "type! capacity functional",
    ("Subsystem", "Configuration"): "name! id! priority! samplingTime!",
    ("Configuration", "Initial"): "parameter! field value!",
    ("Configuration", "Loop"): "name! samplingTime! priority! services",
    ("Configuration", "HKService"): "id! interval! enabled display loop",
    ("HKService", "SampledOnce"): "",
    ("SampledOnce", "ParamRef"): "name!",
    ("HKService", "SampledNREPTimes"): "nrep!",
    ("SampledNREPTimes", "ParamRef"): "name!",
    ("Configuration", "RTLinkService"): "",
    ("RTLinkService", "Provides"): "name! id! methods!",
    ("Provides", "ParamRef"): PORT_FIELD,
    ("RTLinkService", "Requires"): "name! id! methods! required staleAfter",
    ("Requires", "ParamRef"): PORT_FIELD,
    ("Configuration", "Devices"): "",
    ("Devices", "Device"): "name! type!",
    ("Device", "Setting"): "object! type! value!",
    ("Device", "Quantity"): "name! id! object! type! scale! unit settable",
    ("Device", "Supply"): "unit! on! off!",
    ("Device", "Field"): "name! direction! type! scale offset safe unit",
    ("Device", "Endnode"): "type! bus redundantBus node name address port framing order direction baud checksum silence retry retryLongest",
}
REPORT_OCTETS = 4000  # Largest parameter, and largest housekeeping report.
NESTING = 3  # Maximum depth of structures within the structure of a parameter.
CONFIGURATION_LOOPS = 2  # Maximum number of loops in a configuration.
SERVICES = 16  # Maximum number of services in a subsystem.
PORT_OCTETS = 1024  # Largest sample of a port.
AUXILIARY_OCTETS = 1024  # Largest auxiliary data of an event, and largest arguments of a function.
HIGH_EVENT_HEAD = 27  # Octets of a stored report without its auxiliary data.
HIGH_EVENTS_OCTETS = 2048  # All stored reports of HIGH events together.
RATE = re.compile(r"([1-9][0-9]{0,3})/s\Z")


@dataclass
class Field:
    """One sequence of scalars: member of a parameter, argument, event value or element of a port's layout."""

    element: object
    name: str
    type: str
    id: int
    count: int
    unit: str
    init: str = None
    min: float = None
    max: float = None
    enumeration: names.Enumeration = None

    @property
    def size(self):
        return TYPES[self.type][1] * self.count


@dataclass
class Parameter:
    """A parameter: one field of its own name, or a structure of fields."""

    element: object
    name: str
    number: int
    layout: int
    apid: int
    fields: list
    settable: bool

    @property
    def is_struct(self):
        return self.layout == LAYOUT_STRUCT

    @property
    def id(self):
        return self.apid << 21 | self.layout << 16 | self.number

    @property
    def size(self):
        return sum(item.size for item in self.fields)


@dataclass
class Event:
    """An event with the values that the raising code supplies, or the parameters that are sampled for it."""

    name: str
    id: int
    severity: str
    fields: list
    references: list

    @property
    def size(self):
        return sum(item.size for item in self.fields + self.references)


@dataclass
class Function:
    """A function, which TC[8,1] performs."""

    element: object
    name: str
    id: int
    arguments: list
    states: list
    is_critical: bool
    configurations: list = None


@dataclass
class Structure:
    """A housekeeping report."""

    id: int
    interval: int  # Cycles of its loop from one report to the next.
    enabled: bool
    display: bool
    once: list
    repeated: list  # Elements (nrep, parameters): these parameters are sampled nrep times.
    loop: str  # Name of the loop; None: the main loop.


@dataclass
class Port:
    """A port of a real-time link."""

    element: object
    name: str
    id: int
    provided: bool
    required: bool
    fields: list
    methods: list
    period_us: int
    stale_us: int

    @property
    def layout_hash(self):
        """CRC-32 over the lines name:type:count."""
        return binascii.crc32("".join(f"{f.name}:{f.type}:{f.count}\n" for f in self.fields).encode())

    @property
    def size(self):
        return sum(item.size for item in self.fields)


@dataclass
class Configuration:
    """A configuration of a subsystem."""

    name: str
    id: int
    priority: int
    sampling_us: int
    structures: list
    ports: list
    devices: list
    loops: list
    initial: dict  # (parameter, field) -> text of the value

    def sampling_of(self, structure):
        """Cycle of the loop that samples a structure [us]."""
        return next((loop.sampling_us for loop in self.loops if loop.name == structure.loop), self.sampling_us)


@dataclass
class Subsystem:
    """The content of a subsystem descriptor."""

    element: object
    name: str
    apid: int
    enumerations: list = field(default_factory=list)
    failures: list = field(default_factory=list)
    parameters: list = field(default_factory=list)
    events: list = field(default_factory=list)
    functions: list = field(default_factory=list)
    services: list = field(default_factory=list)
    configurations: list = field(default_factory=list)
    interface_hash: int = 0
    configuration_hash: int = 0

    def configuration(self, name):
        """Configuration of a name, or None."""
        return next((item for item in self.configurations if item.name == name), None)

    def ports(self):
        """All ports in the order of their first appearance; a port of several configurations appears once."""
        found = {}
        for configuration in self.configurations:
            for port in configuration.ports:
                found.setdefault(port.name, port)
        return list(found.values())


def load(path):
    """Checked model of a subsystem descriptor. Raises DescriptorError."""
    root = read(path, TABLE, "Subsystem")
    subsystem = Subsystem(root, root.identifier(), root.unsigned("id", 1, 2046))
    root.time_us("samplingTime", 100, 10000000)
    root.word("sync", SYNC_ORDERS)
    _once(root, "Resources", "States", "Enumerations", "Failures", "Parameters", "Events", "Functions", "Services")
    _resources(root.first("Resources"))
    _states(root.first("States"))
    for container, build in (("Enumerations", names.enumerations), ("Failures", names.failures), ("Parameters", _parameters), ("Events", _events), ("Functions", _functions)):
        if root.first(container):
            build(subsystem, root.first(container))
    for element in root.first("Services").children if root.first("Services") else ():
        subsystem.services.append(service_of(element, subsystem.apid))
        if len(subsystem.services) > SERVICES:
            element.fail(f"too many services, at most {SERVICES}")
        unique(root.first("Services").children[: len(subsystem.services)], "type")
    configurations = root.all("Configuration")
    for element in configurations:
        subsystem.configurations.append(_configuration(subsystem, element))
        unique(configurations[: len(subsystem.configurations)], "name", "id")
    _resolve_functions(subsystem)
    _same_ports(subsystem)
    subsystem.interface_hash = fnv64(interface_text(subsystem).encode())
    subsystem.configuration_hash = fnv64(canonical(root).encode())
    return subsystem


def interface_text(subsystem):
    """Canonical text of the interface part."""
    lines = [f"subsystem {subsystem.name} {subsystem.apid}"]
    for parameter in subsystem.parameters:
        lines.append(f"parameter {parameter.name} {parameter.number} {parameter.layout}")
        lines += [f"field {f.name} {f.type} {f.count}" for f in parameter.fields]
    for event in subsystem.events:
        lines.append(f"event {event.name} {event.id}")
        lines += [f"field {f.name} {f.type} {f.count}" for f in event.fields]
        lines += [f"sample {p.name}" for p in event.references]
    for function in subsystem.functions:
        lines.append(f"function {function.name} {function.id}")
        lines += [f"argument {f.name} {f.id} {f.type} {f.count}" for f in function.arguments]
    lines += [f"service {service.type} {service.capacity} {service.functional}" for service in compiled(subsystem.services)]
    for configuration in subsystem.configurations:
        lines.append(f"configuration {configuration.name} {configuration.id}")
        for port in configuration.ports:
            lines.append(f"port {port.name} {port.id} {'provides' if port.provided else 'requires'}")
            lines += [f"field {f.name} {f.type} {f.count}" for f in port.fields]
    lines += [f"enumeration {each.name} {each.first} {' '.join(each.numbers)}" for each in subsystem.enumerations]
    lines += [f"failure {failure.name} {failure.id}" for failure in subsystem.failures]
    return "\n".join(lines) + "\n"


def _once(root, *names):
    for name in names:
        for element in root.all(name)[1:]:
            element.fail(f"a second <{name}>: expected one")


def _resources(element):
    if element:
        warning = element.unsigned("poolWarning", 1, 100, 75)
        if element.unsigned("poolClear", 0, 99, 65) >= warning:
            element.fail("expected poolClear < poolWarning")


def _states(element):
    for state in element.children if element else ():
        state.word("name", STATES)
        state.time_us("timeout", 1000, 600000000)
    unique(element.children if element else (), "name")


def _field(subsystem, element, index, with_id):
    name = element.identifier()
    kind = element.word("type", tuple(TYPES))
    count = element.unsigned("count", 1, 256, 1)
    number = element.unsigned("id", 0, 65535, index) if with_id else index
    item = Field(element, name, kind, number, count, element.text("unit", ""), element.text("init"))
    if len(item.unit) > 16:
        element.wrong("unit", "at most 16 characters")
    for bound in ("min", "max"):
        if bound in element.attributes:
            value = read_number(element.attributes[bound], kind)
            if value is None or value is NUMBER_OUT_OF_RANGE:
                element.wrong(bound, f"a number of type {kind}")
            setattr(item, bound, value)
    if item.min is not None and item.max is not None and item.min > item.max:
        element.wrong("min", f"at most max={element.attributes['max']}")
    names.enumerate_field(subsystem, element, item)
    if item.init is not None:
        item.init = numbers(element, "init", item, item.init)
    return item


def numbers(element, attribute, item, text):
    """Check the values of a field in `text`, those of an enumeration by name: number, type and bounds. Returns them as text with numbers."""
    words = text.split(" ")
    if item.enumeration:
        known = item.enumeration.numbers
        if len(words) != item.count or not all(word in known for word in words):
            element.wrong(attribute, f"{item.count} name(s) of {item.enumeration.name}, one space between: {' '.join(known)}")
        return " ".join(str(known[word]) for word in words)
    for word in words if len(words) == item.count else (None,):
        value = None if word is None else read_number(word, item.type)
        if value is None or value is NUMBER_OUT_OF_RANGE:
            element.wrong(attribute, f"{item.count} number(s) of type {item.type}, one space between")
        if (item.min is not None and value < item.min) or (item.max is not None and value > item.max):
            element.wrong(attribute, f"numbers within min and max of {item.name}")
    return text


def _members(subsystem, element, group, depth, first):
    """Fields of a structure, numbered from `first`. Fields of nested structures are named GROUP.NAME."""
    fields = []
    for child in element.children:
        if child.name == "StructRef":
            name = child.identifier()
            child.word("type", ("STRUCT",))
            child.unsigned("id", 0, 65535, 0)
            if depth == NESTING:
                child.fail(f"structures nested more than {NESTING} deep")
            fields += _members(subsystem, child, f"{group}{name}.", depth + 1, first + len(fields))
        else:
            item = _field(subsystem, child, first + len(fields), True)
            item.name = group + item.name
            fields.append(item)
    if not fields:
        element.fail("<StructRef> has no <ParamRef>")
    unique(element.children, "name")
    return fields


def _parameters(subsystem, container):
    for element in container.children:
        name, number = element.identifier(), element.unsigned("id", 0, 65535)
        settable = element.flag("settable")
        if element.name == "StructRef":
            element.word("type", ("STRUCT",))
            fields = _members(subsystem, element, "", 0, 0)
            layout = LAYOUT_STRUCT
        else:
            fields = [_field(subsystem, element, 0, False)]
            layout = LAYOUT_ARRAY if fields[0].count > 1 else TYPES[fields[0].type][0]
        parameter = Parameter(element, name, number, layout, subsystem.apid, fields, settable)
        if parameter.size > REPORT_OCTETS:
            element.fail(f"{parameter.size} octets, at most {REPORT_OCTETS}")
        subsystem.parameters.append(parameter)
        unique(container.children[: len(subsystem.parameters)], "name")
        same = next((p for p in subsystem.parameters[:-1] if p.id == parameter.id), None)
        if same:
            element.fail(f"layout and id of {name} are those of {same.name} in line {same.element.line}: expected another id")


def _reference(subsystem, element):
    name = element.identifier()
    found = next((item for item in subsystem.parameters if item.name == name), None)
    if not found:
        element.wrong("name", "the name of a parameter of this subsystem")
    return found


def _check_limiter(element, severity):
    if severity == "HIGH" and ("rate" in element.attributes or "burst" in element.attributes):
        element.fail("an <Event> of severity HIGH cannot have rate or burst")
    element.unsigned("burst", 1, 255)
    match = RATE.match(element.attributes.get("rate", "10/s"))
    if not match or int(match[1]) > 1000:
        element.wrong("rate", "a rate like 10/s, from 1/s to 1000/s")


def _events(subsystem, container):
    for element in container.children:
        event = Event(element.identifier(), element.unsigned("id", 1, 65535), element.word("severity", SEVERITIES), [], [])
        for index, child in enumerate(element.children):
            if ("type" in child.attributes) != ("type" in element.children[0].attributes):
                child.fail("either all <ParamRef> of an <Event> have a type, or none has")
            if "type" in child.attributes:
                event.fields.append(_field(subsystem, child, index, False))
            elif any(each in child.attributes for each in ("count", "unit", "enumeration")):
                child.fail("<ParamRef> without type cannot have count, unit or enumeration")
            else:
                event.references.append(_reference(subsystem, child))
        unique(element.children, "name")
        if event.size > AUXILIARY_OCTETS:
            element.fail(f"{event.size} octets of auxiliary data, at most {AUXILIARY_OCTETS}")
        _check_limiter(element, event.severity)
        subsystem.events.append(event)
        high = sum(HIGH_EVENT_HEAD + each.size for each in subsystem.events if each.severity == "HIGH")
        if high > HIGH_EVENTS_OCTETS:
            element.fail(f"{high} octets of reports of HIGH events, at most {HIGH_EVENTS_OCTETS}")
        unique(container.children[: len(subsystem.events)], "name", "id")


def _functions(subsystem, container):
    for element in container.children:
        states = list(STATES) if element.attributes["states"] == "*" else element.words("states", STATES)
        name = element.identifier(longest=8)
        arguments = [_field(subsystem, child, index, True) for index, child in enumerate(element.children)]
        unique(element.children, "name", "id")
        size = sum(item.size + 2 for item in arguments)
        if size > AUXILIARY_OCTETS:
            element.fail(f"{size} octets of arguments, at most {AUXILIARY_OCTETS}")
        subsystem.functions.append(Function(element, name, element.unsigned("id", 1, 65535), arguments, states, element.flag("critical")))
        unique(container.children[: len(subsystem.functions)], "name", "id")


def _resolve_functions(subsystem):
    names = [item.name for item in subsystem.configurations]
    for function in subsystem.functions:
        text = function.element.text("configurations", "*")
        function.configurations = names if text == "*" else function.element.words("configurations", names)


def _configuration(subsystem, element):
    name, number = element.identifier(), element.unsigned("id", 1, 65535)
    priority = element.unsigned("priority", 1, 99)
    sampling = element.time_us("samplingTime", 100, 10000000)
    configuration = Configuration(name, number, priority, sampling, [], [], [], [], {})
    _once(element, "RTLinkService", "Devices")
    for child in element.children:
        if child.name == "Initial":
            _initial(subsystem, child, configuration.initial)
        elif child.name == "Loop":
            if len(configuration.loops) == CONFIGURATION_LOOPS:
                child.fail(f"too many <Loop> in one configuration, at most {CONFIGURATION_LOOPS}")
            configuration.loops.append(loop_of(child))
            unique(element.all("Loop")[: len(configuration.loops)], "name")
            services_once(element.all("Loop"), configuration.loops)
        elif child.name == "HKService":
            configuration.structures.append(_structure(subsystem, child, configuration.loops))
            unique(element.all("HKService")[: len(configuration.structures)], "id")
        elif child.name == "RTLinkService":
            for port in child.children:
                configuration.ports.append(_port(subsystem, port, configuration.sampling_us))
                unique(child.children[: len(configuration.ports)], "name", "id")
        else:
            for device in child.children:
                configuration.devices.append(device_of(device))
                for attribute in ("name", "id"):
                    unique(device.all("Quantity"), attribute)
                unique(device.all("Field"), "name")
                unique(child.children[: len(configuration.devices)], "name")
    return configuration


def _initial(subsystem, element, initial):
    name = element.identifier("parameter")
    parameter = next((item for item in subsystem.parameters if item.name == name), None)
    if not parameter:
        element.wrong("parameter", "the name of a parameter of this subsystem")
    if parameter.is_struct != ("field" in element.attributes):
        element.fail(f"parameter {name} is {'a structure: name its field' if parameter.is_struct else 'no structure and has no field'}")
    wanted = element.attributes["field"] if parameter.is_struct else name
    item = next((item for item in parameter.fields if item.name == wanted), None)
    if not item:
        element.wrong("field", f"the name of a field of {name}")
    if (name, wanted) in initial:
        element.fail(f"{name} {wanted} already has an initial value in this configuration: expected one")
    initial[name, wanted] = numbers(element, "value", item, element.attributes["value"])


def _sampled(subsystem, element):
    parameters = [_reference(subsystem, reference) for reference in element.children]
    if not parameters:
        element.fail(f"<{element.name}> has no <ParamRef>")
    return parameters


def _structure(subsystem, element, loops):
    interval = element.unsigned("interval", 1, 0xFFFFFFFF)
    loop = element.text("loop")
    if loop is not None and loop not in [item.name for item in loops]:
        element.wrong("loop", "the name of a <Loop> above in this configuration")
    structure = Structure(element.unsigned("id", 1, 65535), interval, element.flag("enabled", True), element.flag("display"), [], [], loop)
    _once(element, "SampledOnce")
    for child in element.children:
        if child.name == "SampledOnce":
            structure.once = _sampled(subsystem, child)
        else:
            nrep = child.unsigned("nrep", 2, 1000)
            if interval % nrep:
                child.wrong("nrep", f"a divisor of the interval {interval}")
            structure.repeated.append((nrep, _sampled(subsystem, child)))
    references = [reference for child in element.children for reference in child.children]
    if not references:
        element.fail("<HKService> has no <ParamRef>")
    unique(references, "name")
    size = sum(p.size for p in structure.once) + sum(n * sum(p.size for p in ps) for n, ps in structure.repeated)
    if size > REPORT_OCTETS:
        element.fail(f"{size} octets in one report, at most {REPORT_OCTETS}")
    return structure


def _port(subsystem, element, sampling_us):
    provided = element.name == "Provides"
    name, number = element.identifier(), element.unsigned("id", 1, 65535)
    methods = element.words("methods", METHODS)
    required = not provided and element.flag("required", True)
    stale = 0 if provided else element.time_us("staleAfter", 100, 60000000, 4 * sampling_us)
    fields = [_field(subsystem, child, index, False) for index, child in enumerate(element.children)]
    port = Port(element, name, number, provided, required, fields, methods, sampling_us, stale)
    if not fields:
        element.fail(f"<{element.name}> has no <ParamRef>")
    unique(element.children, "name")
    if port.size > PORT_OCTETS:
        element.fail(f"{port.size} octets in one sample, at most {PORT_OCTETS}")
    return port


def _same_ports(subsystem):
    """Refuse a port that differs between two configurations."""
    all_ports = [port for configuration in subsystem.configurations for port in configuration.ports]
    for index, port in enumerate(all_ports):
        for other in all_ports[:index]:
            if (port.name == other.name) != (port.id == other.id) or (
                port.name == other.name
                and (port.provided != other.provided or port.layout_hash != other.layout_hash)
            ):
                port.element.fail(f"port {port.name} differs from port {other.name} in line {other.element.line}: "
                                  "expected one id, direction and layout for a name")
