# SPDX-License-Identifier: Apache-2.0
"""The catalogue of messages in pus/catalogue, as a tree for the ground and as format programs for flight software.

pus/catalogue/kinds.txt describes the syntax of a file of messages, pus/core/request_format.h the format programs."""

import re
from dataclasses import dataclass, field

from source import DescriptorError, text_of

# Octets of a field of each coding with a fixed size.
CODINGS = {"u8": 1, "u16": 2, "u32": 4, "u64": 8, "i16": 2, "i32": 4, "i64": 8, "f64": 8, "time": 8, "reltime": 7, "cds": 8}
CODINGS |= {"position": 6, "name": 8}
VARIABLE = {"text": "SIZED", "octets": "SIZED", "packet": "PACKET", "rest": "REST"}
HEAD = re.compile(r"(TC|TM) (\d+) ([^\[>]+?)(?: \[(medium|low)\])?(?: -> (\d+))?\Z")
COUNT = re.compile(r"(n|n1|n2|n3|nfa) ([01])\.\. \{\Z")
FIELD = re.compile(r"([a-z_0-9]+) ([a-z_0-9]+)(?: of ([a-z_]+))?( \?)?\Z")


@dataclass
class Message:
    """One message: each field is a dictionary that describes a name with its kind, a repetition, or a choice."""

    service: int
    subtype: int
    direction: str
    name: str
    confidence: str
    answer: int
    identifier: str
    is_critical: bool
    harmless: dict  # Field, and its words for which the request is not critical. None: the request is always critical, or never.
    fields: list = field(default_factory=list)


class Reader:
    """Lines of one file, with their numbers for errors."""

    def __init__(self, path):
        self.path, self.number = path, 0
        self.lines = text_of(path).splitlines()

    def next(self):
        """The next line that is neither empty nor a comment, stripped; None at the end."""
        while self.number < len(self.lines):
            line = self.lines[self.number].strip()
            self.number += 1
            if line and not line.startswith("#"):
                return line
        return None

    def wrong(self, found, expected):
        raise DescriptorError(self.path, self.number, f"'{found}' found, expected {expected}")


def _coding(kind, reader):
    name, bits = (kind.split(":") + ["0"])[:2]
    if kind not in CODINGS and kind not in VARIABLE and kind not in ("id", "layout") and name not in ("bits", "octets"):
        reader.wrong(kind, "a coding that the head of kinds.txt lists")
    return {"coding": name, "size": int(bits)} if int(bits) else {"coding": name}


def kinds(path):
    """Kinds by name: coding, size of `bits` and `octets`, unit, meaning."""
    reader, found = Reader(path), {}
    while (line := reader.next()) is not None:
        matched = re.match(r"([a-z_0-9]+) +([a-z0-9:]+)(?: \[([^\]]+)\])?: (.+)\Z", line)
        if not matched or matched[1] in found:
            reader.wrong(line, "a new `name coding [unit]: meaning`")
        found[matched[1]] = _coding(matched[2], reader) | {"unit": matched[3] or "", "meaning": matched[4]}
    return found


def failures(path, names):
    """[(number, name, words, detail)] of all failure codes; names: names by number, as tailoring.h defines them."""
    reader, found = Reader(path), {}
    while (line := reader.next()) is not None:
        matched = re.match(r"([A-Z_]+): ([^|\"\\]+?)(?: \| (.+))?\Z", line)
        if not matched or matched[1] in found or matched[1] not in names.values():
            reader.wrong(line, "`NAME: words | detail` with a new name of tailoring.h")
        found[matched[1]] = (matched[2], matched[3] or "")
    missing = [name for number, name in names.items() if number and name not in found]
    if missing:
        reader.wrong("the end", f"words for {missing[0]}")
    return [(number, name, *found[name]) for number, name in names.items() if number]


def failures_header(known):
    """C header with the words for the failure codes."""
    rows = "\n".join(f'    {{PUS_FAILURE_{name}, "{words}"}},' for _, name, words, _ in known)
    guard = "GENERATED_PUS_FAILURE_WORDS_H"
    return (
        "// SPDX-License-Identifier: Apache-2.0\n// Words for the failure codes of ST[01]; made from pus/catalogue.\n"
        f"#ifndef {guard}\n#define {guard}\n\n#include \"pus/core/tailoring.h\"\n\n#include <stdint.h>\n\n"
        f"static const struct {{\n    uint16_t code;\n    const char* words;\n}} pus_failure_words[] = {{\n{rows}\n}};\n\n#endif // {guard}\n"
    )


def titles_header(*services):
    """C header with the titles of all messages, sorted by service and subtype."""
    messages = [message for group in services for service in group.values() for message in service["messages"]]
    rows = "\n".join(f'    {{{one.service}U, {one.subtype}U, "{one.name}"}},' for one in sorted(messages, key=lambda one: (one.service, one.subtype)))
    guard = "GENERATED_PUS_MESSAGE_TITLES_H"
    return (
        "// SPDX-License-Identifier: Apache-2.0\n// Titles of the messages, by service and subtype; made from pus/catalogue.\n"
        f"#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n"
        f"static const struct {{\n    uint8_t service;\n    uint8_t subtype;\n    const char* title;\n}} pus_message_titles[] = {{\n{rows}\n}};\n\n"
        f"#endif // {guard}\n"
    )


class _Parser:
    def __init__(self, reader, known):
        self.reader, self.known = reader, known

    def fields(self, end):
        """Fields up to a closing brace, or up to the line for which `end` is true; that line is not consumed."""
        found = []
        while True:
            line = self.reader.next()
            if end(line):
                return found, line
            found.append(self.field(line, found))

    def group(self):
        return self.fields(lambda line: line == "}")[0]

    def field(self, line, before):
        """One field, repetition or choice."""
        if line is None:
            self.reader.wrong("end of file", "}")
        if counted := COUNT.match(line):
            return {"repeat": counted[1], "least": int(counted[2]), "fields": self.group()}
        if line == "values of structure":
            return {"values": "structure"}
        if line.startswith("choice ") and line.endswith(" {"):
            return self.choice(line.split()[1], before)
        matched = FIELD.match(line)
        if not matched or (matched[2] not in self.known and matched[2] not in ("value", "auxiliary")):
            self.reader.wrong(line, "`name kind` with a kind of kinds.txt")
        made = {"name": matched[1], "kind": matched[2]}
        return made | ({"of": matched[3]} if matched[3] else {}) | ({"optional": True} if matched[4] else {})

    def choice(self, name, before):
        """Cases up to the closing brace; the selector is the preceding field."""
        if not before or before[-1].get("name") != name:
            self.reader.wrong(name, "the name of the preceding field")
        cases = {}
        while (line := self.reader.next()) != "}":
            matched = re.match(r"case (\d+) \{\Z", line or "")
            if not matched:
                self.reader.wrong(line, "`case number {` or }")
            cases[matched[1]] = self.group()
        return {"choice": name, "cases": cases}


def identifiers(path):
    """Read names.txt: by (service, subtype) the name of a message, whether it is critical, and the words with which it is not critical."""
    reader, found = Reader(path), {}
    while (line := reader.next()) is not None:
        matched = re.match(r"(\d+),(\d+) ([A-Z][A-Z0-9_]*)( critical(?: unless (\w+)((?: [A-Z_]+)+))?)?\Z", line)
        key = (int(matched[1]), int(matched[2])) if matched else None
        if not matched or key in found or matched[3] in [name for name, *_ in found.values()]:
            reader.wrong(line, "`service,subtype NAME` with a new message and a new name")
        harmless = {"field": matched[5], "words": matched[6].split()} if matched[5] else None
        found[key] = matched[3], matched[4] is not None, harmless
    return found


def _service(path, known, names):
    reader = Reader(path)
    parser = _Parser(reader, known)
    head = re.match(r"service (\d+) (.+)\Z", reader.next() or "")
    if not head:
        reader.wrong("no service", "`service number name`")
    made = {"name": head[2], "enumerations": {}, "messages": []}
    line = reader.next()
    while line and (matched := re.match(r"([a-z_0-9]+): (.+)\Z", line)):
        pairs = [pair.split(" ", 1) for pair in matched[2].split(" | ")]
        made["enumerations"][matched[1]] = {int(number): word for number, word in pairs}
        line = reader.next()
    while line:
        matched = HEAD.match(line)
        if not matched:
            reader.wrong(line, "`TC|TM subtype name [confidence] -> answer`")
        direction, subtype, name, confidence, answer = matched.groups()
        if (int(head[1]), int(subtype)) not in names:
            reader.wrong(line, "a message with a name in names.txt")
        known_as = names[int(head[1]), int(subtype)]
        message = Message(int(head[1]), int(subtype), direction, name, confidence or "high", int(answer or 0), *known_as)
        message.fields, line = parser.fields(lambda line: line is None or HEAD.match(line))
        if message.harmless:
            _check_harmless(message, made["enumerations"], known, reader)
        made["messages"].append(message)
    return int(head[1]), made


def _check_harmless(message, enumerations, known, reader):
    """Check the field that decides whether a request is critical. It must be the first field and have one octet;
    its enumeration must have these words."""
    first, words = message.harmless["field"], message.harmless["words"]
    if not message.fields or message.fields[0].get("name") != first or known[message.fields[0]["kind"]]["coding"] != "u8":
        reader.wrong(first, f"the first field of {message.identifier}, of one octet, after `unless` in names.txt")
    if not set(words) <= set(enumerations.get(first, {}).values()):
        reader.wrong(" ".join(words), f"words of {first} after `unless` in names.txt")


def load(directory):
    """Kinds, and the services by number. A service has name, enumerations and messages."""
    known, names = kinds(directory / "kinds.txt"), identifiers(directory / "names.txt")
    services = dict(_service(path, known, names) for path in sorted(directory.glob("st*.txt")))
    return known, services


def private(directory):
    """Kinds and services of the private services, in the form of `load`."""
    known = kinds(directory / "kinds.txt") | kinds(directory / "private" / "kinds.txt")
    names = identifiers(directory / "names.txt")
    services = dict(_service(path, known, names) for path in sorted((directory / "private").glob("st*.txt")))
    return known, services


# ---- Format programs: pus/core/request_format.h ----

def _encode(fields, known, registers):
    """Octets of a format program as C expressions. `registers`: field name of an id or a layout -> register that keeps it for later fields."""
    words, skip, bits = [], 0, 0

    def flush():
        nonlocal skip
        while skip:
            words.extend(["PUS_REQUEST_FORMAT_SKIP", str(min(skip, 255))])
            skip -= min(skip, 255)

    for entry in fields:
        if "repeat" in entry:
            flush()
            body = _encode(entry["fields"], known, registers)
            words.extend(["PUS_REQUEST_FORMAT_COUNT", str(entry["least"]), str(len(body)), *body])
            continue
        if "choice" in entry:
            skip -= 1  # The selector.
            flush()
            words.extend(_choice(entry, known, registers))
            continue
        if entry["kind"] == "value":
            flush()
            words.extend(["PUS_REQUEST_FORMAT_VALUE", str(registers[entry["of"]])])
            continue
        kind = known[entry["kind"]]
        if kind["coding"] == "bits":
            bits += kind["size"]
            skip, bits = skip + bits // 8, bits % 8
        elif kind["coding"] in ("id", "layout"):
            flush()
            registers[entry["name"]] = len(registers) % 2
            words.extend([f"PUS_REQUEST_FORMAT_{kind['coding'].upper()}", str(registers[entry["name"]])])
        elif kind["coding"] == "octets" and "size" in kind:
            skip += kind["size"]
        elif kind["coding"] in VARIABLE:
            flush()
            words.append(f"PUS_REQUEST_FORMAT_{VARIABLE[kind['coding']]}")
        else:
            skip += CODINGS[kind["coding"]]
    flush()
    return words


def _choice(entry, known, registers):
    bodies = [(number, _encode(case, known, registers)) for number, case in entry["cases"].items()]
    words, left = ["PUS_REQUEST_FORMAT_SELECT"], sum(len(body) + 5 for _, body in bodies) + 1
    for number, body in bodies:
        left -= len(body) + 5
        words.extend(["PUS_REQUEST_FORMAT_CASE", number, str(len(body) + 2), *body, "PUS_REQUEST_FORMAT_JUMP", str(left)])
    return [*words, "PUS_REQUEST_FORMAT_FAIL"]


def formats_header(number, service, known):
    """C header with the formats of a service's requests."""
    programs = []
    for message in service["messages"]:
        if message.direction == "TC" and not _needs_definitions(message.fields):
            words = [*_encode(message.fields, known, {}), "PUS_REQUEST_FORMAT_END"]
            rows = "\n".join("    " + ", ".join(words[i : i + 4]) + "," for i in range(0, len(words), 4))
            name = f"PUS_REQUEST_FORMAT_{number}_{message.subtype}"
            programs.append(f"/// TC[{number},{message.subtype}] {message.name}.\nstatic const uint8_t {name}[] = {{\n{rows}\n}};\n")
    guard = f"GENERATED_PUS_ST{number:02}_REQUEST_FORMATS_H"
    return (
        f"// SPDX-License-Identifier: Apache-2.0\n// Formats of the requests of ST[{number:02}] {service['name']}; made from pus/catalogue.\n"
        f"#ifndef {guard}\n#define {guard}\n\n#include \"pus/core/request_format.h\"\n\n" + "\n".join(programs) + f"\n#endif // {guard}\n"
    )


def _needs_definitions(fields):
    """True if only a definition on board contains the type of a value, so that the service checks the request itself."""
    return any(
        entry.get("kind") == "auxiliary"
        or entry.get("of") in ("argument_id", "transaction_id")
        or _needs_definitions(entry.get("fields", []))
        for entry in fields
    )


def ground(known, services):
    """The catalogue in the form that the dictionary for the ground contains."""
    return {
        "kinds": known,
        "services": {
            str(number): service | {"messages": [vars(message) for message in service["messages"]]}
            for number, service in services.items()
        },
    }
