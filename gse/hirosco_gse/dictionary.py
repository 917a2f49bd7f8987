# SPDX-License-Identifier: Apache-2.0
"""The mission dictionary generated from the descriptors: names, ids, types and layouts of all contents of packets."""

import json
import pathlib
import zlib
from dataclasses import dataclass, field

from . import values
from .messages import Catalogue
from .values import ValueProblem, quoted

STATES = (
    "OFFLINE",
    "SOFTWARE_INIT",
    "HARDWARE_INIT",
    "PRE_OPERATIONAL",
    "SAFE_OPERATIONAL",
    "OPERATIONAL",
    "ERROR_OPERATIONAL",
    "POST_OPERATIONAL",
    "HARDWARE_DEINIT",
    "SOFTWARE_DEINIT",
)
SEVERITIES = {1: "INFORMATIVE", 2: "LOW", 3: "MEDIUM", 4: "HIGH"}
STRATEGIES = ("ASCII", "SQLITE", "POSTGRESQL", "RING")
SUPERVISOR_APID = 1
RATIO = "1"  # Quantity of a number without dimension.


class DictionaryError(ValueProblem):
    """A name that the dictionary does not contain, or a dictionary that cannot be read."""


def _not_found(what, name, known):
    offer = ", ".join(str(word) for word in known) or "none"
    return DictionaryError(f"no {what} {quoted(name)}; there are: {offer}")


@dataclass(frozen=True)
class Field:
    """A named sequence of scalars: an argument, an event value or a member of a structured parameter."""

    name: str
    type: str
    count: int = 1
    unit: str = ""  # Unit, or what the number counts.
    id: int = 0
    words: dict = None  # number -> word
    min: float = None
    max: float = None
    init: str = None  # initial value, as the descriptor writes it
    kind: str = ""  # What the number identifies; identifiers.py gives some kinds names.

    @property
    def size(self):
        return values.size_of(self.type, self.count)

    def decode(self, octets, offset):
        """Value (a list of numbers; a number that has a word is a values.Word) at the offset, and the offset after
        it."""
        return _decode(self, octets, offset)

    def encode_text(self, text):
        """Octets of a value as written by a user."""
        try:
            return _encode(self, text)
        except ValueProblem as problem:
            raise ValueProblem(f"{self.name}: {problem}") from problem


def _decode(item, octets, offset):
    found, offset = values.decode(item.type, item.count, octets, offset)
    return ([_worded(item.words, number) for number in found] if item.words else found), offset


def _worded(words, number):
    if isinstance(words, values.Bits):
        return values.Word(number, words[number], words.members(number))
    return values.Word(number, words[number]) if number in words else number


def _encode(item, text):
    return values.encode(item.type, values.from_text(item.type, item.count, text, item.words))


@dataclass(frozen=True)
class Parameter:
    """A parameter; a structured one has fields."""

    name: str
    parameter_id: int
    type: str
    count: int = 1
    unit: str = ""
    settable: bool = False
    min: float = None
    max: float = None
    fields: tuple = ()
    words: dict = None  # number -> word

    @property
    def size(self):
        return sum(item.size for item in self.fields) if self.fields else values.size_of(self.type, self.count)

    def decode(self, octets, offset):
        """Value (a list, or a dict of lists) at the offset, and the offset after it."""
        if not self.fields:
            return _decode(self, octets, offset)
        members = {}
        for item in self.fields:
            members[item.name], offset = item.decode(octets, offset)
        return members, offset

    def field(self, name):
        """(field of a structure by name, its octet offset)."""
        offset = 0
        for item in self.fields:
            if item.name.upper() == name.upper():
                return item, offset
            offset += item.size
        raise _not_found(f"field of {self.name}", name, [item.name for item in self.fields])

    def encode_text(self, text):
        """Octets of a value as written: 0.5,-0.3; the members of a structure follow each other in order."""
        try:
            if not self.fields:
                return _encode(self, text)
            words, octets, at = text.split(","), b"", 0
            if len(words) != sum(item.count for item in self.fields):
                raise ValueProblem(f"{quoted(text)} has {len(words)} values, {sum(i.count for i in self.fields)} expected")
            for item in self.fields:
                octets += item.encode_text(",".join(words[at : at + item.count]))
                at += item.count
            return octets
        except ValueProblem as problem:
            raise ValueProblem(f"{self.name}: {problem}") from problem


def defined_on_board(parameter_id):
    """Parameter that a request of ST[20] has defined: a scalar of the type in its layout bits, with its id as name; or None."""
    layout = parameter_id >> 16 & 0x1F
    kinds = tuple(values.FORMATS)
    return Parameter(f"0x{parameter_id:08X}", parameter_id, kinds[layout]) if layout < len(kinds) else None


@dataclass(frozen=True)
class Structure:
    """One housekeeping report: parameters sampled once, and sets sampled several times."""

    id: int
    interval: int
    once: tuple = ()
    repeated: tuple = ()  # of (repetitions, tuple of parameters)
    is_enabled: bool = False  # Periodic generation is enabled when the configuration is applied.
    is_display: bool = False

    def decode(self, octets, offset=0):
        """Dict name -> value; a repeatedly sampled parameter has a list with one value per sample."""
        sampled = {}
        for parameter in self.once:
            sampled[parameter.name], offset = parameter.decode(octets, offset)
        for repetitions, parameters in self.repeated:
            for parameter in parameters:
                sampled[parameter.name] = []
            for _ in range(repetitions):
                for parameter in parameters:
                    value, offset = parameter.decode(octets, offset)
                    sampled[parameter.name].append(value)
        if offset != len(octets):
            raise ValueProblem(f"structure {self.id}: {len(octets) - offset} octets too many")
        return sampled


@dataclass(frozen=True)
class Event:
    """An event definition with its auxiliary values."""

    name: str
    id: int
    severity: str
    parameters: tuple = ()
    description: str = ""

    def decode(self, octets, offset=0):
        """Dict name -> value of the auxiliary data."""
        values_by_name = {}
        for parameter in self.parameters:
            values_by_name[parameter.name], offset = parameter.decode(octets, offset)
        if offset != len(octets):
            raise ValueProblem(f"event {self.name}: {len(octets) - offset} octets too many")
        return values_by_name


@dataclass(frozen=True)
class Function:
    """A function of TC[8,1]; its id in the packet is its name."""

    name: str
    arguments: tuple = ()
    states: tuple = ()
    configurations: tuple = ()
    is_critical: bool = False


@dataclass(frozen=True)
class Port:
    """A port of a real-time link with the layout of its samples."""

    name: str
    id: int
    layout: tuple = ()
    period_us: int = 0
    max_age_us: int = 0

    @property
    def octets(self):
        return sum(item.size for item in self.layout)

    @property
    def layout_hash(self):
        """CRC-32 over the lines name:type:count, as both ends compute it."""
        return zlib.crc32("".join(f"{f.name}:{f.type}:{f.count}\n" for f in self.layout).encode("ascii"))


@dataclass(frozen=True)
class Link:
    """A real-time link that the mission defines."""

    name: str
    number: int
    producer: int
    producer_port: int
    consumer: int
    consumer_port: int


@dataclass(frozen=True)
class Configuration:
    """A configuration of a subsystem, with its housekeeping structures and ports."""

    name: str
    id: int
    sampling_us: int = 0
    structures: dict = field(default_factory=dict)
    provides: tuple = ()
    requires: tuple = ()
    identifiers: dict = field(default_factory=dict)  # as those of Subsystem, of the devices of this configuration
    initial: dict = field(default_factory=dict)  # (parameter, field) -> initial value, as the descriptor writes it

    @property
    def display(self):
        """The display structure that a station enables; None if there is none, or if it is enabled from the start."""
        return next((item for item in self.structures.values() if item.is_display and not item.is_enabled), None)


@dataclass
class Subsystem:
    """A subsystem: everything that the dictionary defines for one APID."""

    name: str
    apid: int
    parameters: dict
    events: dict
    functions: dict
    configurations: dict
    failures: dict = field(default_factory=dict)  # own failure codes: code -> (name, name of the detail)
    interface_hash: int = 0
    is_infrastructure: bool = False  # is started automatically and shut down last
    created: dict = field(default_factory=dict)  # structures created by this ground, id -> Structure
    identifiers: dict = field(default_factory=dict)  # kind of number ("CANopen node", "device") -> {number: name of the device}

    def parameter(self, name):
        return _lookup(self.parameters, name, f"parameter of {self.name}")

    def parameter_of_id(self, parameter_id):
        """Parameter of a 32-bit id, or None."""
        return next((p for p in self.parameters.values() if p.parameter_id == parameter_id), None)

    def event(self, name):
        return _lookup(self.events, name, f"event of {self.name}")

    def event_of_id(self, event_id):
        """Event of an id, or None."""
        return next((e for e in self.events.values() if e.id == event_id), None)

    def function(self, name):
        return _lookup(self.functions, name, f"function of {self.name}")

    def configuration(self, name):
        """Configuration of a name or number."""
        by_id = {str(item.id): item for item in self.configurations.values()}
        return by_id.get(str(name)) or _lookup(self.configurations, name, f"configuration of {self.name}")

    def configuration_name(self, configuration_id):
        """Name of a configuration, "-" for none."""
        if configuration_id == 0:
            return "-"
        found = next((c.name for c in self.configurations.values() if c.id == configuration_id), None)
        return found or str(configuration_id)

    def structures_of_id(self, structure_id, configuration_id=None):
        """Structures that a report may have: first those of the given configuration, then those of the others, then created ones."""
        ordered = sorted(self.configurations.values(), key=lambda c: c.id != configuration_id)
        found = [c.structures[structure_id] for c in ordered if structure_id in c.structures]
        if structure_id in self.created:
            found.insert(0, self.created[structure_id])
        return found

    def port(self, port_id, requires):
        """Port of an id, or None."""
        for configuration in self.configurations.values():
            for port in configuration.requires if requires else configuration.provides:
                if port.id == port_id:
                    return port
        return None

    def port_name(self, port_id, requires):
        """Name of a port by its id."""
        port = self.port(port_id, requires)
        return port.name if port else str(port_id)


def _lookup(table, name, what):
    wanted = str(name).upper()
    for key, item in table.items():
        if key.upper() == wanted:
            return item
    raise _not_found(what, name, table)


def words_of(item, enumerations):
    """Words for the numbers of an item of the dictionary (JSON), from its enumeration or from descriptions.txt; None if it has no words."""
    if "bits" in item:
        return values.Bits(item["bits"])
    numbers = enumerations.get(item.get("enumeration"))
    if numbers:
        return {number: word for word, number in numbers.items()}
    given = item.get("words")
    return values.Names((int(number), word) for number, word in given["numbers"].items()) if given else None


def unit_of(item):
    """Unit of an item of the dictionary (JSON), or what its number counts; empty for a ratio and for a number that counts nothing."""
    quantity = item.get("quantity") or ""
    return item.get("unit") or (quantity if quantity != RATIO else "")


def _fields(items, enumerations):
    return tuple(
        Field(item["name"], item["type"], int(item.get("count", 1)), unit_of(item), int(item.get("id", 0)),
              words_of(item, enumerations), item.get("min"), item.get("max"), item.get("init"), item.get("kind", ""))
        for item in items
    )


def _parameter(item, enumerations):
    return Parameter(
        name=item["name"],
        parameter_id=int(item["parameter_id"]),
        type=item["type"],
        count=int(item.get("count", 1)),
        unit=unit_of(item),
        settable=bool(item.get("settable", False)),
        min=item.get("min"),
        max=item.get("max"),
        fields=_fields(item.get("fields") or (), enumerations),
        words=words_of(item, enumerations),
    )


def _member(parameters, reference):
    """Parameter of a reference by name; NAME.FIELD is a member of a structured parameter."""
    name = reference["name"] if isinstance(reference, dict) else reference
    if name in parameters:
        return parameters[name]
    head, _, tail = name.partition(".")
    for item in parameters[head].fields if head in parameters else ():
        if item.name == tail:
            return Parameter(name, 0, item.type, item.count, item.unit, words=item.words)
    raise _not_found("parameter", name, parameters)


def _structure(parameters, item):
    once = tuple(_member(parameters, reference) for reference in item.get("once", ()))
    repeated = tuple(
        (int(part["nrep"]), tuple(_member(parameters, reference) for reference in part["parameters"]))
        for part in item.get("repeated", ())
    )
    return Structure(int(item["id"]), int(item.get("interval", 0)), once, repeated, bool(item.get("enabled")), bool(item.get("display")))


def _event(parameters, item, enumerations):
    auxiliary = []
    for reference in item.get("parameters", ()):
        if isinstance(reference, dict) and "type" in reference:
            auxiliary.append(_fields([reference], enumerations)[0])
        else:
            auxiliary.append(_member(parameters, reference))
    return Event(item["name"], int(item["id"]), item["severity"], tuple(auxiliary), item.get("description", ""))


def _ports(items, enumerations):
    return tuple(
        Port(
            item["name"],
            int(item["id"]),
            _fields(item.get("layout", ()), enumerations),
            int(item.get("period_us", 0)),
            int(item.get("stale_us", 0)),
        )
        for item in items or ()
    )


def _identifiers(devices):
    """Names of the devices of a configuration by kind of number: by their number, from 0, and by CANopen node."""
    nodes = {int(end["node"], 0): device["name"] for device in devices for end in device.get("endnodes", ()) if "node" in end}
    return {"device": {number: device["name"] for number, device in enumerate(devices)}, "CANopen node": nodes}


def _configuration(parameters, item, enumerations):
    structures = [_structure(parameters, part) for part in item.get("housekeeping", ())]
    return Configuration(
        name=item["name"],
        id=int(item["id"]),
        sampling_us=int(item.get("sampling_us", 0)),
        structures={structure.id: structure for structure in structures},
        provides=_ports(item.get("provides"), enumerations),
        requires=_ports(item.get("requires"), enumerations),
        identifiers=_identifiers(item.get("devices", ())),
        initial={(part["parameter"], part["field"]): part["value"] for part in item.get("initial", ())},
    )


def _subsystem(item):
    words = item.get("enumerations", {})
    parameters = {part["name"]: _parameter(part, words) for part in item.get("parameters", ())}
    functions = {
        part["name"]: Function(
            part["name"],
            _fields(part.get("arguments", ()), words),
            tuple(part.get("states", ())),
            tuple(part.get("configurations", ())),
            bool(part.get("critical", False)),
        )
        for part in item.get("functions", ())
    }
    return Subsystem(
        name=item["name"],
        apid=int(item["apid"]),
        parameters=parameters,
        events={part["name"]: _event(parameters, part, words) for part in item.get("events", ())},
        functions=functions,
        configurations={part["name"]: _configuration(parameters, part, words) for part in item.get("configurations", ())},
        failures={part["code"]: (part["name"], part["detail"]) for part in item.get("failures", ())},
        interface_hash=int(str(item.get("interface_hash", "0")), 0),
        is_infrastructure=bool(item.get("autostart", False)),
        identifiers={kind: {int(number): name for number, name in names.items()} for kind, names in item.get("identifiers", {}).items()},
    )


class Dictionary:
    """The dictionary of one mission."""

    def __init__(self, content):
        self.content = content
        self.mission = content["mission"]
        self.interface_hash = content.get("interface_hash", "")
        self.configuration_hash = content.get("configuration_hash", "")
        self.epoch_ns = int(content["epoch"]) * 1_000_000_000  # packet time of mission time 0
        self.modes = content.get("modes", [])
        self.buses = content.get("buses", [])
        self.links = [
            Link(
                item["name"],
                int(item["number"]),
                int(item["producer_apid"]),
                int(item["producer_port"]),
                int(item["consumer_apid"]),
                int(item["consumer_port"]),
            )
            for item in content.get("links", [])
        ]
        self.permissions = content.get("permissions", [])
        self.catalogue = Catalogue(content.get("catalogue", {}), self)
        self.files = None  # Files on ground of the command that is planned (files.py); commands.plan sets it.
        self.subsystems = {item["name"]: _subsystem(item) for item in content["subsystems"]}
        self._by_apid = {item.apid: item for item in self.subsystems.values()}

    @classmethod
    def load(cls, path):
        """Dictionary in a JSON file. Raises DictionaryError."""
        path = pathlib.Path(path)
        try:
            return cls(json.loads(path.read_text(encoding="utf-8")))
        except OSError as error:
            raise DictionaryError(f"{path}: {error.strerror}; run make") from error
        except (ValueError, KeyError, TypeError) as error:
            raise DictionaryError(f"{path}: not a mission dictionary ({error!r}); run make") from error

    def subsystem(self, name):
        """Subsystem of a name or APID."""
        if str(name).isdecimal() and int(name) in self._by_apid:
            return self._by_apid[int(name)]
        return _lookup(self.subsystems, name, "subsystem")

    def subsystem_of_apid(self, apid):
        """Subsystem of an APID, or None."""
        return self._by_apid.get(apid)

    def name_of_apid(self, apid):
        """Name of an APID, or its number as text."""
        found = self._by_apid.get(apid)
        return found.name if found else f"APID {apid}"

    def link(self, name):
        return _lookup({item.name: item for item in self.links}, name, "link")

    def mode(self, name):
        """Number of a mode's name or number."""
        by_id = {str(item["id"]): item for item in self.modes}
        return int((by_id.get(str(name)) or _lookup({m["name"]: m for m in self.modes}, name, "mode"))["id"])

    @property
    def members(self):
        """Subsystems whose states an operator commands."""
        return [item for item in self.subsystems.values() if not item.is_infrastructure]
