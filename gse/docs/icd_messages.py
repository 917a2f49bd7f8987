# SPDX-License-Identifier: Apache-2.0
"""Page of the interface control document with every message of the standard's services, from the catalogue."""

import pathlib

import catalogue
from page import escape, shell, table

DIRECTORY = pathlib.Path(__file__).resolve().parents[2] / "pus" / "catalogue"
FILE, TITLE = "icd-messages.html", "Messages of the packet services"
# Octets of a field by its coding, if the catalogue does not give its size.
OCTETS = {"id": "4", "layout": "1", "text": "2 + n", "octets": "2 + n", "packet": "n", "rest": "the rest"} | {
    name: str(size) for name, size in catalogue.CODINGS.items()
}


def _mono(text):
    return f'<span class="mono">{escape(text)}</span>'


def _octets(kind):
    if kind["coding"] == "bits":
        return f"{kind['size']} bits"
    return str(kind["size"]) if "size" in kind else OCTETS[kind["coding"]]


class _Rows:
    """Rows of a message's fields. Fields of a repetition or case are indented below its count or selector."""

    def __init__(self, known, enumerations, direction):
        self.known, self.enumerations, self.direction = known, enumerations, direction
        self.rows = []

    def add(self, fields, depth):
        for entry in fields:
            self.field(entry, "&nbsp;" * 4 * depth, depth)

    def field(self, entry, indent, depth):
        if "repeat" in entry:
            least = "at least 1" if entry["least"] else "may be 0"
            size = "1" if self.direction == "TC" else "2"
            self.rows.append([indent + _mono(entry["repeat"]), size, f"count, {least}; the following fields are repeated that many times:"])
            self.add(entry["fields"], depth + 1)
        elif "choice" in entry:
            for number, case in entry["cases"].items():
                word = self.enumerations.get(entry["choice"], {}).get(int(number), "")
                nothing = "" if case else " nothing"
                self.rows.append([indent, "", f"if {_mono(entry['choice'])} is {number} {escape(word)}:{nothing}"])
                self.add(case, depth + 1)
        elif "values" in entry:
            self.rows.append([indent + _mono("values"), "", "in the layout of the report structure"])
        elif entry["kind"] in ("value", "auxiliary"):
            what = "value of the type that belongs to" if entry["kind"] == "value" else "auxiliary data of the event"
            self.rows.append([indent + _mono(entry["name"]), "", f"{what} {_mono(entry['of'])}"])
        else:
            kind = self.known[entry["kind"]]
            words = self.enumerations.get(entry["name"], {})
            meaning = ", ".join(f"{number} {word}" for number, word in words.items()) or kind["meaning"] + (f" [{kind['unit']}]" if kind["unit"] else "")
            self.rows.append([indent + _mono(entry["name"]), _octets(kind), escape(meaning)])


def _message(message, known, enumerations):
    number = f"{message.service},{message.subtype}"
    answer = f"<p>Answered by TM[{message.service},{message.answer}].</p>" if message.answer else ""
    doubt = "" if message.confidence == "high" else f' <span class="chip">{message.confidence} confidence</span>'
    rows = _Rows(known, enumerations, message.direction)
    rows.add(message.fields, 0)
    fields = table(["field", "octets", "meaning"], rows.rows, (1,)) if rows.rows else "<p>No fields.</p>"
    return f"<h3>{message.direction}[{number}] {escape(message.name)}{doubt}</h3>{answer}{fields}"


def page():
    known, services = catalogue.load(DIRECTORY)
    parts, contents = [], []
    for number, service in services.items():
        anchor, title = f"st{number:02}", f"ST[{number:02}] {service['name']}"
        contents.append((2, anchor, title))
        parts.append(f'<h2 id="{anchor}">{title}</h2>')
        parts += [_message(message, known, service["enumerations"]) for message in service["messages"]]
    total = sum(len(service["messages"]) for service in services.values())
    body = (
        f'<h1>{TITLE}</h1><p class="sub">{total} messages of ECSS-E-ST-70-41C with the widths of this mission, from the catalogue. '
        "Octets are big-endian. Absolute time is CUC 4+3 with its P-field, TAI since 1958.</p>" + "".join(parts)
    )
    return shell(FILE, TITLE, body, contents)
