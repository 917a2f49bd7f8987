# SPDX-License-Identifier: Apache-2.0
"""Event reports as sentences: the description of the event in its descriptor, then its values with their names and units:
`A torque is beyond its limit: joint 1, torque 12.01 Nm, limit 12 Nm`."""

from .identifiers import device_of
from .values import Word, to_text

DIGITS = 4  # Significant digits of a number that is not whole.
NAMES = {"apid": "subsystem"}


def plain(value, item):
    """The value of an event report for a program: the name of what a number identifies, the word of a number, a text, or the number. Several
    numbers are a list of these. item: parameter or field with the kind of the number; None: not known."""
    if isinstance(value, dict):
        fields = {field.name: field for field in getattr(item, "fields", ())}
        return {name: plain(one, fields.get(name)) for name, one in value.items()}
    if getattr(item, "kind", "") == "character":  # A text of a fixed size, padded with 0.
        return bytes(value).rstrip(b"\0").decode("ascii", "backslashreplace")
    numbers = [one.word if isinstance(one, Word) else one for one in value]
    return numbers[0] if len(numbers) == 1 else numbers


def _text(value, item):
    if getattr(item, "kind", "") == "character":
        return plain(value, item)
    return ", ".join(f"{one:.{DIGITS}g}" if isinstance(one, float) else to_text(one) for one in value)


def _clause(name, value, item):
    """Name, value and unit of one value; empty for an empty text."""
    if isinstance(value, dict):
        fields = {field.name: field for field in getattr(item, "fields", ())}
        return ", ".join(filter(None, (_clause(one, part, fields.get(one)) for one, part in value.items())))
    words = [NAMES.get(word, word) for word in name.rpartition(".")[2].lower().split("_")]
    unit = getattr(item, "unit", "")
    text = _text(value, item)
    shown = [" ".join(words), text, unit] if " ".join(words) != unit else [text, unit]  # `40 octets` instead of `octets 40 octets`.
    return " ".join(filter(None, shown)) if text else ""


def sentence(event, found):
    """event: dictionary.Event; found: values of its report, as identifiers.named returns them."""
    items = {item.name: item for item in event.parameters}
    said = ", ".join(filter(None, (_clause(name, value, items.get(name)) for name, value in found.items())))
    return ": ".join(filter(None, (event.description, said)))


def told(event, found):
    """An event report for a page: its sentence, its values by name, and the device that it is about, or None."""
    items = {item.name: item for item in event.parameters}
    values = {name: plain(value, items.get(name)) for name, value in found.items()}
    return {"text": sentence(event, found), "values": values, "device": device_of(found)}

