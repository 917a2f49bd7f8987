# SPDX-License-Identifier: Apache-2.0
"""The content of packets as tshark reads it with the generated dissector and as the ground segment reads
it."""

import collections
import math
import re
import struct
import subprocess
import xml.etree.ElementTree as ET

from hirosco_gse import packets, pcap, telemetry
from hirosco_gse.dictionary import Field
from hirosco_gse.messages import Catalogue
from hirosco_gse.values import Bits


STATE_MASK = 0x6F  # Bits of the statusword (CiA 402) that contain the state.
PROBLEMS = {"pus.malformed", "pus.crc.wrong", "pus.interface.differs"}


def tshark(script, path, *options):
    """Output of tshark with a dissector."""
    arguments = ["tshark", "-X", f"lua_script:{script}", "-r", path, *options]
    done = subprocess.run(arguments, check=True, capture_output=True, text=True)
    assert "Lua" not in done.stderr, done.stderr
    return done.stdout


def capture(path, raws):
    """Write a capture of packets."""
    path.write_bytes(pcap.capture([(number, "", None, raw) for number, raw in enumerate(raws)]))
    return path


def read(script, path):
    """For each frame a dictionary: field name -> list of texts in the order of the packet; nested packets are
    left out."""
    found = []
    for packet in ET.fromstring(tshark(script, path, "-T", "pdml")).iter("packet"):
        fields = {}
        _collect(next(proto for proto in packet if proto.get("name") == "pus"), fields)
        found.append(fields)
    return found


def _collect(element, fields):
    for child in element:
        if child.get("name") != "pus":
            name = re.sub(r"^(pus\.st\d+\.\w+)\.\w+$", r"\1", child.get("name"))  # A value without its type.
            fields.setdefault(name, []).append(child.get("show"))
            _collect(child, fields)


def compare(script, path, raws, dictionary):
    """Compare all values of packets. Returns the number of values by message."""
    expected, compared = Expected(dictionary), collections.Counter()
    dissected = read(script, capture(path, raws))
    assert len(dissected) == len(raws)
    for raw, fields in zip(raws, dissected):
        packet = packets.parse(raw)
        wanted = expected.of(packet)
        assert not differences(wanted, fields), (packet.title, packet.data.hex())
        assert not PROBLEMS & fields.keys(), (packet.title, packet.data.hex())
        compared[packet.title] += len(wanted)
    return compared


class Expected:
    """The content of packets as the ground segment reads it, with the names of the dissector's fields."""

    def __init__(self, dictionary):
        self.dictionary, self.configurations = dictionary, {}
        content = dictionary.content["catalogue"]
        # With the services of the mission.
        both = {key: content[key] | content["private"][key] for key in ("kinds", "services")}
        self.catalogue = Catalogue(both, dictionary)

    def of(self, packet):
        """Dictionary: field name -> list of numbers and texts."""
        self.found = {}
        if packet.apid:
            self._add("apid", packet.apid)
            self._add("source" if packet.direction == "TC" else "destination", packet.user)
        if packet.direction == "TC":
            for bit, name in enumerate(("acceptance", "start", "progress", "completion")):
                self._add(f"ack.{name}", bool(packet.raw[6] >> bit & 1))
        if packet.direction == "TM" and packet.apid:
            self._add("time", (packet.time_ns - self.dictionary.epoch_ns) / 1e9)
            decoded = telemetry.decode(packet, self.dictionary, self.configurations)
            if "configuration_id" in decoded:
                self.configurations[packet.apid] = decoded["configuration_id"]
            if decoded["kind"] in ("housekeeping", "event") and "error" not in decoded:
                owner = self.dictionary.subsystem_of_apid(packet.apid)
                listed = owner.parameters
                if decoded["kind"] == "event":
                    self._add("event", decoded["event"])
                    event = owner.event(decoded["event"])
                    listed = {one.name: one for one in event.parameters}
                for name, value in decoded["values"].items():
                    # A name that is not a field of the event is a parameter to which the event refers.
                    own = isinstance(listed.get(name), Field)
                    place = f"{owner.name}.{decoded['event']}.{name}" if own else f"{owner.name}.{name}"
                    self._values(place.lower(), listed.get(name) or owner.parameters.get(name), value)
                return self.found
        if packet.direction == "TC" and packet.message == (8, 1):
            self._function(packet)
            return self.found
        entry = self.catalogue.find(packet.direction, packet.service, packet.subtype)
        if entry:
            self._group(packet, entry["fields"], self.catalogue.decode(packet))
        return self.found

    def _add(self, name, value):
        self.found.setdefault(f"pus.{name}", []).append(value)

    def _values(self, place, item, value):
        """Values of a parameter or field; samples of a repeated one are a list of lists or of dicts."""
        if isinstance(value, dict):
            fields = {one.name: one for one in item.fields}
            for name, inner in value.items():
                self._values(f"{place}.{name.lower()}", fields[name], inner)
        elif isinstance(value, list):
            for inner in value:
                self._values(place, item, inner)
        else:
            numbers = {word: number for number, word in (getattr(item, "words", None) or {}).items()}
            self._add(place, numbers.get(value, value))
            if isinstance(getattr(item, "words", None), Bits):
                self._bits(place, item.words.about, int(value))

    def _bits(self, place, about, number):
        """The parts of a word of bits."""
        self._add(f"{place}.state", number & STATE_MASK)
        for bit, name in about["flags"].items():
            self._add(f"{place}.{name.lower()}", bool(number >> int(bit) & 1))

    def _function(self, packet):
        owner = self.dictionary.subsystem_of_apid(packet.apid)
        name = packet.data[:8].rstrip(b"\0").decode("ascii")
        self._add("st8.function_id", name)
        at, items = 9, {item.id: item for item in owner.functions[name].arguments} if name in owner.functions else {}
        for _ in range(packet.data[8] if items else 0):
            item = items[struct.unpack_from(">H", packet.data, at)[0]]
            value, at = item.decode(packet.data, at + 2)
            self._values(f"{owner.name}.{name}.{item.name}".lower(), item, value)

    def _group(self, packet, fields, given):
        service = packet.service
        for field in fields:
            if "repeat" in field:
                groups = given[field["repeat"]]
                self._add(f"st{service}.{field['repeat']}", len(groups))
                for group in groups:
                    self._group(packet, field["fields"], group)
            elif "choice" in field:
                self._group(packet, field["cases"][str(self.catalogue.number_of(service, field["choice"], given[field["choice"]]))], given)
            elif "values" not in field and field["kind"] != "auxiliary":
                self._field(packet, field, given)

    def _field(self, packet, field, given):
        name, value = field["name"], given[field["name"]]
        place, coding = f"st{packet.service}.{name}", self.catalogue.kinds.get(field["kind"], {}).get("coding")
        if field["kind"] == "value":
            parameter = given.get(field["of"])
            if packet.service == 20 and isinstance(parameter, str) and "." in parameter:
                owner, _, parameter = parameter.partition(".")
                self._values(f"{owner}.{parameter}".lower(), self.dictionary.subsystem(owner).parameter(parameter), value)
            elif not isinstance(value, (dict, list)):
                self._add(place, value)
        elif coding == "id":
            self._add(place, self.catalogue.parameter_id(value))
        elif coding == "layout":
            self._add(place, self.dictionary.content["types"].get(value, {"code": value})["code"])
        elif coding == "time" and value is None or value == "":
            return
        elif coding in ("packet", "octets", "rest", "text", "name", "f64", "time", "cds", "reltime", "position"):
            self._add(place, value)
        else:
            self._add(place, self.catalogue.number_of(packet.service, name, value))


def differences(expected, fields):
    """Names whose values differ."""
    wrong = {}
    for name, values in expected.items():
        shown = fields.get(name, [])
        if len(shown) != len(values) or not all(map(_is_same, values, shown)):
            wrong[name] = (values, shown)
    return wrong


def _is_same(value, text):
    if isinstance(value, bool):
        return text in (("1", "True") if value else ("0", "False"))
    if isinstance(value, float):
        return math.isclose(value, float(text), rel_tol=1e-6, abs_tol=1e-9) or math.isnan(value) and "nan" in text.lower()
    if isinstance(value, int):
        return int(text, 0) == value
    return text.replace(":", "").lower() == value.replace(":", "").lower()
