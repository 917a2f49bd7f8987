# SPDX-License-Identifier: Apache-2.0
"""Wireshark dissector of a mission's packets (Lua): tables of names and layouts from the dictionary, followed by dissector.lua."""

import collections
import pathlib

import identifiers
from common_words import CATALOGUE
from identifiers import Identifiers, subject_of
from source import DescriptorError

ENGINE = pathlib.Path(__file__).with_name("dissector.lua")
LARGEST_WORD = (1 << 31) - 1  # Largest number of a value string in Wireshark's interface to Lua.
KIND_OF = {"u8": "UINT8", "u16": "UINT16", "u32": "UINT32", "u64": "UINT64", "i16": "INT16", "i32": "INT32", "i64": "INT64",
           "f64": "DOUBLE", "id": "UINT32", "layout": "UINT8", "bits": "UINT16", "time": "DOUBLE", "reltime": "DOUBLE",
           "position": "DOUBLE", "cds": "DOUBLE", "name": "STRING", "text": "STRING"}  # All other kinds are octets.
WORDED = ("UINT8", "UINT16", "INT8", "INT16", "INT32")  # Types that may have a value string in Wireshark, with numbers of any size.
SIZES = {"UINT8": 1, "UINT16": 2, "UINT32": 4}
HEADER = {  # field -> type, label, table of names of its numbers; a flag also has its mask and the width of the number in bits.
    "type": ("UINT8", "Type", "type"), "apid": ("UINT16", "APID", "apid"), "sequence": ("UINT16", "Sequence count", None),
    "length": ("UINT16", "Length less 7", None), "service": ("UINT8", "Service", None), "subtype": ("UINT8", "Subtype", None),
    "ack": ("UINT8", "Acknowledgement flags", None), "ack.acceptance": ("BOOL", "Acceptance", None, 1, 8),
    "ack.start": ("BOOL", "Start", None, 2, 8), "ack.progress": ("BOOL", "Progress", None, 4, 8), "ack.completion": ("BOOL", "Completion", None, 8, 8),
    "source": ("UINT16", "Source", "user"), "counter": ("UINT16", "Message counter", None),
    "destination": ("UINT16", "Destination", "user"), "time": ("DOUBLE", "Mission time [s]", None), "crc": ("UINT16", "Checksum", None),
    "message": ("STRING", "Message", None), "event": ("STRING", "Event", None), "octets": ("OCTETS", "Octets", None),
}


def script(dictionary):
    """Text of the dissector of a mission."""
    tables = _Tables(dictionary)
    about = (f"mission {dictionary['mission']}; interface {dictionary['interface_hash']}, configuration "
             f"{dictionary['configuration_hash']}")
    lines = ["-- SPDX-License-Identifier: Apache-2.0",
             f"-- Wireshark dissector of PUS packets, {about}. Made by gse/generator; do not edit.",
             f"-- tshark -X lua_script:{dictionary['mission']}.lua -r packets.pcap; in a TCP stream at port {dictionary['ground']['port']}", ""]
    lines += [f"local {name} = {_lua(table)}" for name, table in tables.all().items()]
    return "\n".join(lines) + "\n" + ENGINE.read_text(encoding="utf-8")


def _lua(value):
    """A value as an expression of Lua, with one entry of the outermost table per line."""
    if isinstance(value, dict):
        return "{\n" + "".join(f"  [{_inner(key)}] = {_inner(item)},\n" for key, item in value.items()) + "}"
    return _inner(value)


def _inner(value):
    if value is None:
        return "false"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return '"' + "".join(c if " " <= c <= "~" and c not in '"\\' else f"\\{ord(c):03d}" for c in value) + '"'
    if isinstance(value, dict):
        return "{" + ", ".join(f"[{_inner(key)}] = {_inner(item)}" for key, item in value.items()) + "}"
    return "{" + ", ".join(map(_inner, value)) + "}"


class _Tables:
    """All tables of one dictionary."""

    def __init__(self, dictionary):
        self.dictionary = dictionary
        catalogue = dictionary["catalogue"]
        own = catalogue.get("private", {})  # Services of the mission.
        self.kinds = catalogue["kinds"] | own.get("kinds", {})
        self.services = catalogue["services"] | own.get("services", {})
        apids = {one["apid"]: one["name"] for one in dictionary["subsystems"]}
        self.words = {"type": {0: "TM", 1: "TC"}, "apid": apids, "user": {0: "all", **{one["id"]: one["name"] for one in dictionary["users"]}}}
        self.fields = dict(HEADER)
        self.bits = {"ack": [name for name in HEADER if name.startswith("ack.")]}
        self.parameters, self.structures, self.events, self.functions = {}, {}, {}, {}
        self.names = {"configuration": {}, "device": {}, "failure": self._shared_failures()}
        for subsystem in dictionary["subsystems"]:
            self._subsystem(subsystem)
        self._common_words(catalogue)
        self.messages = {}
        for number, service in sorted(self.services.items(), key=lambda item: int(item[0])):
            for message in service["messages"]:
                self._message_fields(int(number), service, message["fields"])
                self.messages[f"{message['direction']}[{number},{message['subtype']}]"] = {"name": message["name"], "fields": message["fields"]}

    def all(self):
        dictionary = self.dictionary
        mission = {"name": dictionary["mission"], "epoch": int(dictionary["epoch"]), "port": dictionary["ground"]["port"],
                   "apids": self.words["apid"]}
        used = sorted({field["kind"] for field in self._leaves()} - {"value", "auxiliary"} | {"part"})
        kinds = {name: {key: self.kinds[name][key] for key in ("coding", "size") if key in self.kinds[name]} for name in used}
        return {
            "MISSION": mission,
            "INTERFACES": {one["apid"]: f"{int(one['interface_hash'], 16):016X}" for one in dictionary["subsystems"]},
            "LAYOUTS": {entry["code"]: name for name, entry in dictionary["types"].items()},
            "WORDS": dict(sorted(self.words.items())),
            "FIELDS": dict(sorted(self.fields.items())),
            "BITS": dict(sorted(self.bits.items())),
            "NAMES": self.names,
            "PARAMETERS": self.parameters, "STRUCTURES": self.structures, "EVENTS": self.events, "FUNCTIONS": self.functions,
            "CATALOGUE": {"kinds": kinds, "messages": self.messages},
        }

    def _leaves(self):
        waiting = [message["fields"] for message in self.messages.values()]
        while waiting:
            for field in waiting.pop():
                waiting += [field.get("fields", []), *field.get("cases", {}).values()]
                if "kind" in field:
                    yield field

    def _common_words(self, catalogue):
        failures = {int(number): words[0] for number, words in catalogue["failures"].items()}
        failures |= {failure["code"]: f"{subsystem['name']}.{failure['name']}" for subsystem in self.dictionary["subsystems"] for failure in subsystem["failures"]}
        failures |= {code: "of the subsystem" for codes in self.names["failure"].values() for code in codes}
        self.words["failure_code"] = failures
        self.words["layout"] = {entry["code"]: name for name, entry in self.dictionary["types"].items()}
        self.words["mode8"] = {mode["id"]: mode["name"] for mode in self.dictionary["modes"]}
        self.words["link_id"] = {link["number"]: link["name"] for link in self.dictionary["links"]}

    def _shared_failures(self):
        """Names of the failure codes that several subsystems use for different failures: APID -> code -> name."""
        uses = collections.Counter(failure["code"] for one in self.dictionary["subsystems"] for failure in one["failures"])
        return {one["apid"]: found for one in self.dictionary["subsystems"]
                if (found := {failure["code"]: failure["name"] for failure in one["failures"] if uses[failure["code"]] > 1})}

    # ---- layouts of the descriptors ----

    def _item(self, key, owner, one):
        """Register a field of a descriptor under a key. Returns [key, type, count]."""
        words = None
        numbers = owner["enumerations"].get(one.get("enumeration"))
        if numbers and max(numbers.values()) <= LARGEST_WORD and one["type"] != "UINT64":
            words = f"{owner['name']}.{one['enumeration']}"
            self.words[words] = {number: word for word, number in numbers.items()}
        elif "words" in one and one["type"] in WORDED:
            words = one["words"]["name"]
            self.words[words] = {int(number): word for number, word in one["words"]["numbers"].items()}
        unit = f" [{one['unit']}]" if one.get("unit") else ""
        key = key.lower()
        self.fields[key] = (one["type"], f"{key.rpartition('.')[2].upper()}{unit}", words)
        if "bits" in one:
            self._bits(key, one["type"], one["bits"])
        return [key, one["type"], one.get("count", 1)]

    def _bits(self, key, kind, about):
        """Register the parts of a number whose bits have names: its state (each mask covers only some of the state's bits) and its flags."""
        mask = 0
        for one, _, _ in about["states"]:
            mask |= one
        self.words[about["name"]] = {number: name for number in range(mask + 1) if not number & ~mask
                                     for one, value, name in about["states"] if number & one == value}
        self.fields[f"{key}.state"] = (kind, "State", about["name"], mask)
        flags = {f"{key}.{name.lower()}": (1 << int(bit), name) for bit, name in about["flags"].items()}
        self.fields |= {flag: ("BOOL", name, None, only, 8 * SIZES[kind]) for flag, (only, name) in flags.items()}
        self.bits[key] = [f"{key}.state", *flags]

    def _parameter(self, owner, parameter):
        key = f"{owner['name']}.{parameter['name']}"
        if "fields" in parameter:
            return [self._item(f"{key}.{one['name']}", owner, one) for one in parameter["fields"]]
        return [self._item(key, owner, parameter)]

    def _subsystem(self, owner):
        items = {}
        for parameter in owner["parameters"]:
            items[parameter["name"]] = self._parameter(owner, parameter)
            name = f"{owner['name']}.{parameter['name']}"
            self.parameters[parameter["parameter_id"]] = {"name": name, "items": items[parameter["name"]]}
            for one, item in zip(parameter.get("fields", ()), items[parameter["name"]]):
                items[f"{parameter['name']}.{one['name']}"] = [item]

        def listed(names):
            return [item for name in names for item in items[name]]

        self._present_names(owner)
        structures = self.structures.setdefault(owner["apid"], {})
        for configuration in owner["configurations"]:
            for structure in configuration["housekeeping"]:
                layout = listed(structure["once"]) + [[part["nrep"], listed(part["parameters"])] for part in structure["repeated"]]
                structures.setdefault(structure["id"], []).append({"configuration": configuration["id"], "items": layout})
        events, identified = self.events.setdefault(owner["apid"], {}), Identifiers(self.dictionary, owner)
        for event in owner["events"]:
            layout = []
            for one in event["parameters"]:
                if isinstance(one, dict):
                    layout.append(self._value_of_event(owner, event, one, identified))
                else:
                    layout += items[one]
            events[event["id"]] = {"name": event["name"], "items": layout}
        self.functions[owner["apid"]] = {
            function["name"]: {one["id"]: self._item(f"{owner['name']}.{function['name']}.{one['name']}", owner, one)
                               for one in function["arguments"]}
            for function in owner["functions"]
        }

    def _value_of_event(self, owner, event, one, identified):
        """[key, type, count] of a value of an event. If its numbers mean something else in another subsystem or configuration, a fourth member
        says what the dissector looks up: the kind of names, and the value with the APID of the subsystem (None: the sender of the event)."""
        key, subject = f"{owner['name']}.{event['name']}.{one['name']}", subject_of(one, event)
        if subject:
            about = f"{owner['name']}.{event['name']}.{subject}".lower()
            return [*self._item(key, owner, one), [one["kind"].removesuffix(" id"), about]]
        worded = identified.worded(one, event)
        if one.get("kind") in owner["identifiers"] and identifiers.is_ambiguous(worded.get("words", {}).get("numbers", {})):
            return [*self._item(key, owner, one), [one["kind"], None]]
        return self._item(key, owner, worded)

    def _present_names(self, owner):
        """Names of the configurations of a subsystem, and of the devices of each, by the kind of number."""
        self.names["configuration"][owner["apid"]] = {one["id"]: one["name"] for one in owner["configurations"]}
        if any(map(identifiers.is_ambiguous, owner["identifiers"].values())):
            self.names["device"][owner["apid"]] = {one["id"]: identifiers.devices([one]) for one in owner["configurations"]}

    # ---- messages of the catalogue ----

    def _message_fields(self, number, service, fields):
        for field in fields:
            name = field.get("name") or field.get("repeat")
            key = f"st{number}.{name}"
            if "repeat" in field:
                self._register(key, "UINT16", name)
                self._message_fields(number, service, field["fields"])
            elif "choice" in field:
                for case in field["cases"].values():
                    self._message_fields(number, service, case)
            elif field.get("kind") == "value":
                self._register(key, "OCTETS", name)
                for kind in self.dictionary["types"]:
                    self._register(f"{key}.{kind.lower()}", kind, name)
            elif field.get("kind") and field["kind"] != "auxiliary":
                self._kind_field(key, service, field)

    def _kind_field(self, key, service, field):
        kind = self.kinds[field["kind"]]
        words = field["kind"] if field["kind"] in self.words else None
        listed = service["enumerations"].get(field["name"])
        if listed:
            words = key
            self.words[key] = {int(number): word for number, word in listed.items()}
        elif field["kind"] == "bool8":
            words = "bool8"
            self.words[words] = {0: "false", 1: "true"}
        self._register(key, KIND_OF.get(kind["coding"], "OCTETS"), field["name"], words)

    def _register(self, key, kind, label, words=None):
        """Register a field. Raises DescriptorError if another message uses the name for another type."""
        known = self.fields.get(key)
        if known and known[0] != kind:
            raise DescriptorError(CATALOGUE, 0, f"{key} is {known[0]} in one message and {kind} in another: expected one type for a name")
        self.fields[key] = (kind, label.replace("_", " "), words or (known[2] if known else None))
