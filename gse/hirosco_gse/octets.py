# SPDX-License-Identifier: Apache-2.0
"""The fields of a packet with the octets that each of them has, from the headers to the checksum."""

import struct
from dataclasses import dataclass

from . import values
from .identifiers import named
from .messages import Catalogue, MessageProblem, MessageReader
from .packets import CRC_SIZE, PRIMARY_HEADER, TC_HEADER, TM_HEADER

ACKNOWLEDGED = ((0x1, "acceptance"), (0x2, "start"), (0x4, "progress"), (0x8, "completion"))
FUNCTION = (8, 1)
ALL_USERS = 0  # Destination of a report: all ground users.
SPLIT = (values.ValueProblem, struct.error, IndexError, KeyError, AttributeError, ValueError)  # Octets that are not of the expected form.


@dataclass(frozen=True)
class Span:
    """A field: its name, its first octet in the packet, its number of octets, and its value in words."""

    name: str
    at: int
    size: int
    text: str


class _Reader(MessageReader):
    """Reads one message and notes the octets of each field."""

    def __init__(self, layouts, entry, packet, start, configuration):
        super().__init__(layouts.catalogue, entry, packet, None, None)
        self.dictionary, self.packet, self.configuration = layouts.dictionary, packet, configuration
        self.owner = layouts.dictionary.subsystem_of_apid(packet.apid)
        self.start, self.spans, self.function = start, [], None

    def note(self, name, begin, text):
        """Note the octets from `begin` of the data field to those that are read next. Bits share an octet."""
        first = begin + self.octets.bits // 8 if self.octets.at == begin else begin
        self.spans.append(Span(name, self.start + first, max(1, self.octets.at - first), text))

    def field(self, field, found):
        begin = self.octets.at
        if "repeat" in field:
            count = self.octets.octets[begin : begin + self.count_size]
            self.spans.append(Span(f"number of groups {field['repeat']}", self.start + begin, self.count_size, str(int.from_bytes(count, "big"))))
            super().field(field, found)
        elif "choice" in field:
            super().field(field, found)
        elif "values" in field:
            self.structure_of(self.seen.get("hk_structure_id", self.seen.get("diag_structure_id")))
        elif field["kind"] == "auxiliary":
            self.event_of(self.seen["event_definition_id"])
        else:
            before = len(self.spans)
            super().field(field, found)
            if field["name"] == "function_id":
                self.function = found["function_id"]
            if len(self.spans) == before:  # Otherwise the field has noted its parts.
                self.note(field["name"], begin, self.words(field, found[field["name"]]))

    def words(self, field, value):
        """Text of a value. A number that identifies something is followed by its name in `owner`, or in the subsystem whose
        APID the packet contains."""
        owner = self.dictionary.subsystem_of_apid(self.seen["apid"]) if "apid" in self.seen else self.owner
        name = _name_of(field["kind"], value, owner, self.dictionary)
        return f"{value} {name}" if name is not None else values.to_text(value)

    def deduced(self, field):
        if self.packet.message != FUNCTION:
            parameter = self.catalogue.parameter(self.layouts.get(field["of"], 0))
            return self.item(parameter) if parameter else super().deduced(field)
        arguments = self.owner.function(self.function).arguments
        return self.item(next(one for one in arguments if one.id == self.seen[field["of"]]))

    def item(self, item, sample=None, found=None):
        """Note a parameter, argument or value of an event; a structure by its fields. found: value to show instead of the read one."""
        for member in getattr(item, "fields", ()) or (item,):
            begin = self.octets.at
            value, self.octets.at = member.decode(self.octets.octets, begin)
            name = item.name if member is item else f"{item.name}.{member.name}"
            unit = f" {member.unit}" if member.unit else ""
            shown = value if found is None else found[member.name] if isinstance(found, dict) else found
            self.note(f"{name}{f', sample {sample}' if sample else ''}", begin, f"{values.to_text(shown)}{unit}")

    def structure_of(self, structure_id):
        """Note the parameters of a housekeeping structure. Raises ValueProblem if none with this id has so many octets."""
        rest = self.octets.octets[self.octets.at :]
        for structure in self.owner.structures_of_id(structure_id, self.configuration):
            size = sum(one.size for one in structure.once) + sum(times * sum(one.size for one in each) for times, each in structure.repeated)
            if size == len(rest):
                break
        else:
            raise values.ValueProblem(f"no structure {structure_id} of {len(rest)} octets in the dictionary")
        for parameter in structure.once:
            self.item(parameter)
        for times, parameters in structure.repeated:
            for sample in range(1, times + 1):
                for parameter in parameters:
                    self.item(parameter, sample)

    def event_of(self, event_id):
        """Note the values of an event, with the names of what its numbers identify."""
        event = self.owner.event_of_id(event_id)
        found = named(event.decode(self.octets.octets, self.octets.at), event, self.owner, self.dictionary,
                      {self.packet.apid: self.configuration})
        for parameter in event.parameters:
            self.item(parameter, found=found[parameter.name])


def _failure_of(owner, code):
    return owner.failures.get(code) if owner else None


def _name_of(kind, value, owner, dictionary):
    """Name of the thing that a number of a kind of the catalogue identifies; None if it identifies nothing, or something unknown."""
    if not isinstance(value, int):
        return None
    dictionary_names = {
        "apid": lambda: dictionary.name_of_apid(value),
        "link_id": lambda: next((link.name for link in dictionary.links if link.number == value), None),
        "mode8": lambda: next((mode["name"] for mode in dictionary.modes if mode["id"] == value), None),
        "failure_code": lambda: (_failure_of(owner, value) or dictionary.catalogue.failures.get(value) or (None,))[0],
    }
    owner_names = {
        "event_id": lambda: getattr(owner.event_of_id(value), "name", None),
        "configuration_id": lambda: owner.configuration_name(value),
    }
    names = {**dictionary_names, **owner_names} if owner else dictionary_names
    found = names[kind]() if kind in names else None
    return None if found == str(value) else found


def _user(number, dictionary):
    name = next((user["name"] for user in dictionary.content.get("users", ()) if user["id"] == number), None)
    return f"{number} {name}" if name else "0 all users" if number == ALL_USERS else str(number)


class Layouts:
    """The layouts of all packets of a mission."""

    def __init__(self, dictionary):
        self.dictionary = dictionary
        content = dictionary.content["catalogue"]
        private = content.get("private", {})
        every = {key: content.get(key, {}) | private.get(key, {}) for key in ("kinds", "services")}
        self.catalogue = Catalogue({**content, **every}, dictionary)

    def title(self, packet):
        """Name of the message of a packet in the catalogue, or "unknown message"."""
        entry = self.catalogue.find(packet.direction, *packet.message)
        return entry["name"] if entry else "unknown message"

    def spans(self, packet, configuration=None):
        """The fields of a packet in the order of their octets, each octet in one or more of them. configuration: id of the present configuration
        of the subsystem, on which the layout of its housekeeping depends. Octets that do not fit the dictionary are one field with the reason."""
        found = self._headers(packet)
        start = found[-1].at + found[-1].size
        entry = self.catalogue.find(packet.direction, *packet.message)
        read = 0
        problem = "not in the catalogue of messages"
        if entry:
            reader = _Reader(self, entry, packet, start, configuration)
            try:
                reader.group(entry["fields"])
                problem = "more octets than the message has"
            except (MessageProblem, *SPLIT) as error:
                problem = str(error)
            found += reader.spans
            read = max((one.at + one.size - start for one in reader.spans), default=0)
        if read < len(packet.data):
            found.append(Span("octets", start + read, len(packet.data) - read, problem))
        return [*found, Span("checksum", len(packet.raw) - CRC_SIZE, CRC_SIZE, f"0x{packet.raw[-CRC_SIZE:].hex().upper()}")]

    def _headers(self, packet):
        """The fields of the primary and the secondary header. A spacecraft time packet has no secondary header."""
        size = f"{len(packet.raw)} octets in all"
        primary = [Span("type and APID", 0, 2, f"{packet.direction}, {packet.apid} {self.dictionary.name_of_apid(packet.apid)}"),
                   Span("sequence count", 2, 2, str(packet.sequence)), Span("length less 7", 4, 2, size)]
        if len(packet.raw) - len(packet.data) - CRC_SIZE == PRIMARY_HEADER:
            return primary
        message = [Span("service", 7, 1, str(packet.service)), Span("subtype", 8, 1, f"{packet.subtype} {self.title(packet)}")]
        if packet.direction == "TC":
            asked = ", ".join(name for bit, name in ACKNOWLEDGED if packet.ack & bit) or "no reports"
            return [*primary, Span("PUS version, reports", 6, 1, asked), *message, Span("source", 9, TC_HEADER - 9, _user(packet.user, self.dictionary))]
        seconds = (packet.time_ns - self.dictionary.epoch_ns) / 1e9
        return [*primary, Span("PUS version, time status", 6, 1, f"{packet.raw[6] >> 4}, {packet.raw[6] & 0xF}"), *message,
                Span("message counter", 9, 2, str(packet.counter)), Span("destination", 11, 2, _user(packet.user, self.dictionary)),
                Span("time", 13, TM_HEADER - 13, f"{seconds:.6f} s")]
