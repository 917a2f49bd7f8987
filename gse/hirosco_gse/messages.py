# SPDX-License-Identifier: Apache-2.0
"""Every message of the standard's services, encoded and decoded with the catalogue in the mission dictionary.

The content of a message is a JSON object with a member for each field. A repetition is a list of groups under the name of its count; a
group of one field may be given as the value of this field alone. The fields of a choice are beside their selector. Enumerations are words
or numbers; absolute times are seconds of mission time, relative times seconds, positions orbits; a parameter is SUBSYSTEM.NAME or its id;
octets are hexadecimal; a request is hexadecimal, or words as an operator types them.
"""

import contextlib
import struct
from fractions import Fraction

from . import packets, values
from .values import ValueProblem, quoted, shortened

FRACTION = 1 << 24  # Units of a relative time in a second.
ANGLE = 1 << 16  # Units of a position in an orbit.
NUMBERS = {"u8": (1, False), "u16": (2, False), "u32": (4, False), "u64": (8, False)}
NUMBERS |= {"i16": (2, True), "i32": (4, True), "i64": (8, True)}
LAYOUTS = tuple(values.FORMATS)  # In the order of their codes.
LAYOUT_SHIFT, LAYOUT_MASK = 16, 0x1F
MS_OF_DAY = 86_400_000
EXPONENT_MAX = 4  # Characters of the exponent of a number.


class MessageProblem(ValueProblem):
    """Values that cannot be encoded as a message, or octets that are not a message."""


def _signed(number, octets):
    bits = 8 * octets
    try:
        return number.to_bytes(octets, "big", signed=True)
    except OverflowError as error:
        raise MessageProblem(f"{number} does not fit {bits} bits") from error


def _text(value):
    octets = value.encode("ascii", "strict") if isinstance(value, str) else bytes(value)
    return struct.pack(">H", len(octets)) + octets


def _hex(value):
    return bytes.fromhex(value) if isinstance(value, str) else bytes(value)


class _Octets:
    """Octets of a message, with the position of the reader."""

    def __init__(self, octets):
        self.octets, self.at, self.bits = octets, 0, 0

    def take(self, size):
        if self.at + size > len(self.octets):
            raise MessageProblem(f"{len(self.octets) - self.at} octets left, {size} needed")
        self.at += size
        return self.octets[self.at - size : self.at]

    def number(self, size, signed=False):
        return int.from_bytes(self.take(size), "big", signed=signed)

    def take_bits(self, count):
        """Bits of an octet group, most significant first."""
        octet, shift = divmod(self.bits, 8)
        end = self.at + octet + (shift + count + 7) // 8
        if end > len(self.octets):
            raise MessageProblem(f"{len(self.octets) - self.at} octets left, {end - self.at} needed")
        window = int.from_bytes(self.octets[self.at : end], "big")
        total = (end - self.at) * 8
        self.bits += count
        value = (window >> (total - self.bits)) & ((1 << count) - 1)
        if self.bits % 8 == 0:
            self.at, self.bits = self.at + self.bits // 8, 0
        return value


class Catalogue:
    """The messages of a mission, with the parameters, events and time of the dictionary."""

    def __init__(self, content, dictionary, plan=None):
        """content: "messages" of the dictionary; plan: words of an operator -> octets of a request."""
        self.kinds = content.get("kinds", {})
        self.services = content.get("services", {})
        self.failures = {int(code): words for code, words in content.get("failures", {}).items()}  # [what failed, detail]
        self.dictionary, self.plan = dictionary, plan
        self._messages = {
            (message["direction"], message["service"], message["subtype"]): message
            for service in self.services.values()
            for message in service["messages"]
        }
        self._private_services = content.get("private", {}).get("services", {})
        self._own_numbers = set(map(int, self._private_services))
        self._private = {
            (message["direction"], message["service"], message["subtype"]): message
            for service in self._private_services.values()
            for message in service["messages"]
        }

    def find(self, direction, service, subtype):
        """Entry of a message, or None."""
        return self._messages.get((direction, service, subtype))

    def flags(self, service, subtype):
        """Entry of a request of a standard or private service, with its name and whether it is critical; None if there is no such request."""
        return self._messages.get(("TC", service, subtype)) or self._private.get(("TC", service, subtype))

    def all(self, direction=None):
        """All entries, in order."""
        return [entry for key, entry in sorted(self._messages.items(), key=lambda item: item[0][1:]) if direction in (None, key[0])]

    def words(self, service, field):
        """Words of an enumeration by number; empty if it has none."""
        return {int(n): word for n, word in self.services[str(service)]["enumerations"].get(field, {}).items()}

    # ---- writing ----

    def encode(self, direction, service, subtype, given):
        """Data field of a message. Raises MessageProblem."""
        entry = self.find(direction, service, subtype)
        if entry is None:
            raise MessageProblem(f"{direction}[{service},{subtype}] is not in the catalogue")
        writer = _Writer(self, entry)
        octets = writer.group(entry["fields"], dict(given))
        return octets

    def number_of(self, service, field, value):
        """Number of an enumeration's word; a number is returned unchanged."""
        if isinstance(value, str) and not value.lstrip("-").isdigit() and not value.lower().startswith("0x"):
            for number, word in self.words(service, field).items():
                if word == value:
                    return number
            known = ", ".join(self.words(service, field).values())
            raise MessageProblem(f"{quoted(value)} is none of: {known}" if known else f"{quoted(value)} is not a number")
        return int(value, 0) if isinstance(value, str) else int(value)

    def parameter_id(self, value):
        """Id of SUBSYSTEM.NAME, or a number."""
        if isinstance(value, str) and "." in value:
            subsystem, _, name = value.partition(".")
            return self.dictionary.subsystem(subsystem).parameter(name).parameter_id
        return int(value, 0) if isinstance(value, str) else int(value)

    def parameter(self, parameter_id):
        """Parameter of an id, or None."""
        subsystem = self.dictionary.subsystem_of_apid(parameter_id >> 21)
        return subsystem.parameter_of_id(parameter_id) if subsystem else None

    # ---- reading ----

    def requests_in(self, entry, data):
        """Octets of the requests within a request. Requests of private services contain none."""
        if entry["service"] in self._own_numbers:
            return []
        reader = MessageReader(self, entry, data, None, None)
        # The spacecraft refuses octets of another form.
        with contextlib.suppress(MessageProblem, ValueProblem, struct.error):
            reader.group(entry["fields"])
        return reader.requests

    def is_harmless(self, entry, data):
        """Whether the first field of a critical request has one of the words for which the request is not critical."""
        if not entry.get("harmless") or not data:
            return False
        service = (self.services | self._private_services)[str(entry["service"])]
        return service["enumerations"][entry["harmless"]["field"]].get(str(data[0])) in entry["harmless"]["words"]

    def decode(self, packet, structure=None, auxiliary=None):
        """Fields of a message as a dict. `structure` and `auxiliary` decode octets whose layout is defined on board:
        functions of (octets) -> value. Raises MessageProblem."""
        entry = self.find(packet.direction, packet.service, packet.subtype)
        if entry is None:
            raise MessageProblem(f"{packet.title} is not in the catalogue")
        reader = MessageReader(self, entry, packet, structure, auxiliary)
        found = reader.group(entry["fields"])
        if reader.octets.at != len(packet.data):
            raise MessageProblem(f"{len(packet.data) - reader.octets.at} octets too many")
        return found


class _Writer:
    """Writes one message."""

    def __init__(self, catalogue, entry):
        self.catalogue, self.entry = catalogue, entry
        self.count_size = 1 if entry["direction"] == "TC" else 2
        self.seen = {}  # Numbers, for choices.
        self.layouts = {}  # Parameter ids, or layouts shifted to their position in an id, for the values that refer to them.
        self.bits, self.bit_count = 0, 0

    def group(self, fields, given):
        octets = b"".join(self.field(field, given) for field in fields)
        if given:
            known = ", ".join(_names(fields)) or "none"
            raise MessageProblem(f"no field {shortened(', '.join(given))} here; there are: {known}")
        return octets

    def field(self, field, given):
        if "repeat" in field:
            return self.repeat(field, given)
        if "choice" in field:
            case = field["cases"].get(str(self.seen[field["choice"]]), [])
            return b"".join(self.field(inner, given) for inner in case)
        if "values" in field:
            return _hex(given.pop("values", b""))
        if field["name"] not in given:
            raise MessageProblem(f"field {field['name']} is missing")
        return self.value(field, given.pop(field["name"]))

    def repeat(self, field, given):
        groups = given.pop(field["repeat"], [])
        if not isinstance(groups, list):
            raise MessageProblem(f"{field['repeat']}: {quoted(groups)} is not a list of groups in JSON, such as {field['repeat']}=[1,2]")
        if len(groups) >= 1 << (8 * self.count_size):
            raise MessageProblem(f"{field['repeat']}: found {len(groups)} groups, expected at most {(1 << (8 * self.count_size)) - 1}")
        octets = len(groups).to_bytes(self.count_size, "big")
        for group in groups:
            if not isinstance(group, dict):
                inner = field["fields"][0]
                group = {inner.get("name", inner.get("repeat")): group}
            octets += self.group(field["fields"], dict(group))
        return octets

    def value(self, field, value):
        name = field["name"]
        if field["kind"] == "value":
            try:
                return self.deduced(field, value)
            except ValueProblem as problem:
                raise MessageProblem(f"{name}: {problem}") from problem
        if field["kind"] == "auxiliary":
            return _hex(value)
        kind = self.catalogue.kinds[field["kind"]]
        coding = kind["coding"]
        try:
            return self.coded(field, kind, coding, value)
        except ValueProblem as problem:  # Its text already contains the reason, for example an unknown name or a range.
            raise MessageProblem(f"{name}: {problem}") from problem
        except (OverflowError, ValueError, TypeError, struct.error) as problem:
            raise MessageProblem(f"{name}: {quoted(value)} is not {kind['meaning']} ({coding})") from problem

    def coded(self, field, kind, coding, value):
        name = field["name"]
        if coding in NUMBERS:
            size, signed = NUMBERS[coding]
            number = self.catalogue.number_of(self.entry["service"], name, value)
            self.seen[name] = number
            return number.to_bytes(size, "big", signed=signed)
        if coding == "bits":
            return self.add_bits(int(value), kind["size"])
        if coding == "id":
            number = self.catalogue.parameter_id(value)
            self.layouts[name] = number
            return number.to_bytes(4, "big")
        if coding == "layout":
            number = LAYOUTS.index(value) if value in LAYOUTS else int(value)
            self.layouts[name] = number << LAYOUT_SHIFT
            return number.to_bytes(1, "big")
        return _PLAIN[coding](self.catalogue, value, kind)

    def add_bits(self, value, count):
        if value >> count:
            raise MessageProblem(f"{value} does not fit {count} bits")
        self.bits, self.bit_count = self.bits << count | value, self.bit_count + count
        if self.bit_count % 8:
            return b""
        octets = self.bits.to_bytes(self.bit_count // 8, "big")
        self.bits, self.bit_count = 0, 0
        return octets

    def deduced(self, field, value):
        """Write a value in the type of its parameter, layout or argument. It must be hexadecimal if only a definition on board contains its type."""
        of = self.layouts.get(field["of"])
        parameter = self.catalogue.parameter(of) if of is not None and of >> 21 else None
        if parameter is not None and (parameter.fields or parameter.count > 1 or parameter.words):
            return parameter.encode_text(",".join(map(str, value)) if isinstance(value, list) else str(value))
        layout = (of >> LAYOUT_SHIFT) & LAYOUT_MASK if of is not None else len(LAYOUTS)
        if isinstance(value, str) and layout >= len(LAYOUTS):
            return bytes.fromhex(value)
        if layout >= len(LAYOUTS):
            raise MessageProblem(f"found {quoted(value)}, expected octets in hexadecimal")
        kind = LAYOUTS[layout]
        return values.encode(kind, [values.scalar_from_text(kind, value) if isinstance(value, str) else value])


def _names(fields):
    for field in fields:
        if "choice" in field:
            for case in field["cases"].values():
                yield from _names(case)
        else:
            yield field.get("name") or field.get("repeat") or "values"


def _exact(value):
    """The exact value of a number. A long exponent is refused: the conversion would take minutes, and the number fits no field."""
    text = str(value)
    if len(text.lower().partition("e")[2]) > EXPONENT_MAX:
        raise ValueError(f"exponent of more than {EXPONENT_MAX} characters")
    return Fraction(text)


def _write_time(catalogue, value, _kind):
    return packets.encode_time(catalogue.dictionary.epoch_ns + round(_exact(value) * 1_000_000_000))


def _write_relative(_catalogue, value, _kind):
    return _signed(round(_exact(value) * FRACTION), 7)


def _write_cds(catalogue, value, _kind):
    total_us = catalogue.dictionary.epoch_ns // 1000 + round(_exact(value) * 1_000_000)
    ms, us = divmod(total_us, 1000)
    return struct.pack(">HIH", ms // MS_OF_DAY, ms % MS_OF_DAY, us)


def _write_name(_catalogue, value, _kind):
    octets = value.encode("ascii")
    if len(octets) > 8:
        raise MessageProblem(f"{quoted(value)} has more than 8 characters")
    return octets.ljust(8, b"\0")


def _write_request(catalogue, value, _kind):
    if isinstance(value, str) and not all(c in "0123456789abcdefABCDEF " for c in value):
        if catalogue.plan is None:
            raise MessageProblem(f"{quoted(value)} is not hexadecimal")
        return catalogue.plan(value)
    return _hex(value)


def _write_fixed(_catalogue, value, kind):
    octets = _hex(value)
    if "size" in kind and len(octets) != kind["size"]:
        raise MessageProblem(f"{len(octets)} octets, {kind['size']} expected")
    return octets if "size" in kind else struct.pack(">H", len(octets)) + octets


_PLAIN = {
    "f64": lambda _c, value, _k: struct.pack(">d", float(value)),
    "time": _write_time,
    "reltime": _write_relative,
    "cds": _write_cds,
    "position": lambda _c, value, _k: _signed(round(_exact(value) * ANGLE), 6),
    "name": _write_name,
    "text": lambda _c, value, _k: _text(value),
    "octets": _write_fixed,
    "packet": _write_request,
    "rest": lambda _c, value, _k: _hex(value),
}


class MessageReader:
    """Reads one message."""

    def __init__(self, catalogue, entry, packet, structure, auxiliary):
        self.catalogue, self.entry = catalogue, entry
        self.octets = _Octets(packet if isinstance(packet, bytes) else packet.data)
        self.requests = []  # Requests within this one.
        self.structure, self.auxiliary = structure, auxiliary
        self.count_size = 1 if entry["direction"] == "TC" else 2
        self.seen = {}  # Numbers, for choices.
        self.layouts = {}  # Parameter ids, or layouts shifted to their position in an id, for the values that refer to them.

    def group(self, fields):
        found = {}
        for field in fields:
            self.field(field, found)
        return found

    def field(self, field, found):
        if "repeat" in field:
            found[field["repeat"]] = [self.group(field["fields"]) for _ in range(self.octets.number(self.count_size))]
        elif "choice" in field:
            number = self.seen[field["choice"]]
            if str(number) not in field["cases"]:
                raise MessageProblem(f"{field['choice']} is {number}, expected one of {', '.join(field['cases'])}")
            for inner in field["cases"][str(number)]:
                self.field(inner, found)
        elif "values" in field:
            found["values"] = self.rest(self.structure)
        elif field["kind"] == "auxiliary":
            found[field["name"]] = self.rest(self.auxiliary)
        elif field["kind"] == "value":
            found[field["name"]] = self.deduced(field)
        else:
            found[field["name"]] = self.value(field, self.catalogue.kinds[field["kind"]])

    def rest(self, decoder):
        octets = self.octets.take(len(self.octets.octets) - self.octets.at)
        return decoder(octets) if decoder else octets.hex()

    def value(self, field, kind):
        coding, name, octets = kind["coding"], field["name"], self.octets
        if coding in NUMBERS:
            number = octets.number(*NUMBERS[coding])
            self.seen[name] = number
            return self.catalogue.words(self.entry["service"], name).get(number, number)
        if coding == "bits":
            return octets.take_bits(kind["size"])
        if coding == "id":
            number = octets.number(4)
            self.layouts[name] = number
            parameter = self.catalogue.parameter(number)
            owner = self.catalogue.dictionary.name_of_apid(number >> 21)
            return f"{owner}.{parameter.name}" if parameter else f"0x{number:08X}"
        if coding == "layout":
            number = octets.number(1)
            self.layouts[name] = number << LAYOUT_SHIFT
            return LAYOUTS[number] if number < len(LAYOUTS) else number
        return _READ[coding](self, kind)

    def deduced(self, field):
        of = self.layouts.get(field["of"])
        if of is None:  # Only definitions on board contain its size.
            return self.rest(None)
        parameter = self.catalogue.parameter(of) if of >> 21 else None
        if parameter is not None:
            found, self.octets.at = parameter.decode(self.octets.octets, self.octets.at)
            return found[0] if isinstance(found, list) and len(found) == 1 else found
        layout = (of >> LAYOUT_SHIFT) & LAYOUT_MASK
        if layout >= len(LAYOUTS):
            raise MessageProblem(f"{field['name']}: parameter 0x{of:08X} is not in the dictionary")
        found, self.octets.at = values.decode(LAYOUTS[layout], 1, self.octets.octets, self.octets.at)
        return found[0]

    def sized(self):
        return self.octets.take(self.octets.number(2))

    def mission_seconds(self, time_ns):
        """Seconds of mission time. None for the time code 0, which stands for "no time"."""
        return (time_ns - self.catalogue.dictionary.epoch_ns) / 1e9 if time_ns else None


def _read_request(reader, _kind):
    head = reader.octets.octets[reader.octets.at : reader.octets.at + packets.PRIMARY_HEADER]
    if len(head) < packets.PRIMARY_HEADER:
        raise MessageProblem("octets are missing in the request within")
    reader.requests.append(reader.octets.take(int.from_bytes(head[4:6], "big") + 7))
    return reader.requests[-1].hex()


def _read_cds(reader, _kind):
    day, ms, us = struct.unpack(">HIH", reader.octets.take(8))
    return reader.mission_seconds(((day * MS_OF_DAY + ms) * 1000 + us) * 1000)


_READ = {
    "f64": lambda reader, _k: struct.unpack(">d", reader.octets.take(8))[0],
    "time": lambda reader, _k: reader.mission_seconds(packets.decode_time(reader.octets.take(8))),
    "reltime": lambda reader, _k: reader.octets.number(7, True) / FRACTION,
    "cds": _read_cds,
    "position": lambda reader, _k: reader.octets.number(6, True) / ANGLE,
    "name": lambda reader, _k: reader.octets.take(8).rstrip(b"\0").decode("ascii", "replace"),
    "text": lambda reader, _k: reader.sized().decode("ascii", "replace"),
    "octets": lambda reader, kind: (reader.octets.take(kind["size"]) if "size" in kind else reader.sized()).hex(),
    "packet": _read_request,
    "rest": lambda reader, _k: reader.rest(None),
}
