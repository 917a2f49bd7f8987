# SPDX-License-Identifier: Apache-2.0
"""Scalar values in packets (big-endian) and in the text form of a user."""

import json
import re
import struct

QUOTED_MAX = 200  # Characters of a user's text that a refusal repeats.
TEXT_MAX = 1000  # Characters of a command that its messages repeat.

FORMATS = {
    "UINT8": "B",
    "UINT16": "H",
    "UINT32": "I",
    "UINT64": "Q",
    "INT8": "b",
    "INT16": "h",
    "INT32": "i",
    "INT64": "q",
    "FLOAT": "f",
    "DOUBLE": "d",
    "BOOL": "?",
}
REALS = ("FLOAT", "DOUBLE")


class ValueProblem(ValueError):
    """A value that does not fit its type, or octets that are too few for it."""


def shortened(text, most=QUOTED_MAX):
    """Text of a user for a message: of a long text its beginning, and how long it is."""
    text = str(text)
    return text if len(text) <= most else f"{text[:most]}... ({len(text)} characters)"


def quoted(text):
    """Text of a user in quotes, for a message."""
    text = str(text)
    return f"'{text}'" if len(text) <= QUOTED_MAX else f"'{text[:QUOTED_MAX]}...' ({len(text)} characters)"


def with_short_words(text):
    """A message with its words shortened, such as the path of a file that cannot be opened."""
    return re.sub(rf"\S{{{TEXT_MAX + 1},}}", lambda word: shortened(word[0], TEXT_MAX), str(text))


def json_of(value, default=str, **options):
    """JSON of a value (RFC 8259), with options of json.dumps. JSON has no infinite numbers and no NaN: null stands for them."""
    try:
        return json.dumps(value, default=default, allow_nan=False, **options)
    except ValueError:
        return json.dumps(json.loads(json.dumps(value, default=default), parse_constant=lambda _: None), **options)


class Word(int):
    """A number of an enumeration with its word. Arithmetic uses the number, and the text form is the word; the object compares equal to both.
    `members`: the parts of a number whose bits have names, by name; None for other numbers."""

    def __new__(cls, number, word, members=None):
        made = super().__new__(cls, number)
        made.word, made.members = word, members
        return made

    def __str__(self):
        return self.word

    def __repr__(self):
        return repr(self.word)

    def __format__(self, form):
        return format(self.word, form)

    def __eq__(self, other):
        return self.word == other if isinstance(other, str) else int(self) == other

    def __ne__(self, other):
        return not self == other

    __hash__ = int.__hash__

    def __getnewargs__(self):
        return int(self), self.word, self.members


class Named(Word):
    """A number that identifies something, with the name of this thing as word. `text` is the text form, such as `JOINT1 (0x11)`."""

    def __new__(cls, number, word, text):
        made = super().__new__(cls, number, word)
        made.text = text
        return made

    def __str__(self):
        return self.text

    def __format__(self, form):
        return format(self.text, form)

    def __getnewargs__(self):
        return int(self), self.word, self.text


def in_words(value):
    """A value of decoded content for JSON that people read: a number that has a word is replaced by the word; an identifying number stays."""
    if isinstance(value, Named):
        return int(value)
    if isinstance(value, Word):
        return value.word
    if isinstance(value, dict):
        return {name: in_words(one) for name, one in value.items()}
    return [in_words(one) for one in value] if isinstance(value, (list, tuple)) else value


def size_of(kind, count=1):
    """Octets of `count` scalars on the wire."""
    return struct.calcsize(">" + FORMATS[kind]) * count


def encode(kind, values):
    """Octets of a list of scalars of one type."""
    try:
        return struct.pack(f">{len(values)}{FORMATS[kind]}", *values)
    except (struct.error, OverflowError) as error:
        raise ValueProblem(f"{shortened(values)} does not fit {kind}") from error


def decode(kind, count, octets, offset):
    """List of `count` scalars at the offset, and the offset after them."""
    layout = f">{count}{FORMATS[kind]}"
    end = offset + struct.calcsize(layout)
    if end > len(octets):
        raise ValueProblem(f"{len(octets) - offset} octets left, {end - offset} needed for {count} x {kind}")
    return list(struct.unpack(layout, octets[offset:end])), end


def scalar_from_text(kind, text):
    """One scalar as written by a user: 0x1F, 31, 0.5, true."""
    word = text.strip()
    try:
        if kind in REALS:
            return float(word)
        if kind == "BOOL":
            return {"true": True, "1": True, "on": True, "false": False, "0": False, "off": False}[word.lower()]
        return int(word, 0)
    except (ValueError, KeyError) as error:
        raise ValueProblem(f"{quoted(text)} is not a {kind} value") from error


class Names(dict):
    """Words that the ground gives to some numbers (number -> word); other numbers are valid too."""


class Bits(Names):
    """Words for a number whose bits have names: that of the state, which a mask selects, and those of the flags that are set, joined by `+`.
    `about` is the item `bits` of the dictionary."""

    def __init__(self, about):
        super().__init__()
        self.about, self._known = about, {}
        self._flags = {int(bit): name for bit, name in about["flags"].items()}

    def __bool__(self):
        return True

    def __contains__(self, number):
        return True

    def __getitem__(self, number):
        if number not in self._known:
            flags = [name for bit, name in sorted(self._flags.items()) if number >> bit & 1]
            self._known[number] = "+".join([self.state(number), *flags])
        return self._known[number]

    def state(self, number):
        """Name of the state."""
        return next((name for mask, value, name in self.about["states"] if number & mask == value), "UNKNOWN")

    def members(self, number):
        """The flags above the bits of the state, from the highest, and the state, as the XTCE database has them."""
        above = [bit for bit in sorted(self._flags, reverse=True) if bit >= self.about["state_bits"]]
        return {**{self._flags[bit]: number >> bit & 1 for bit in above}, "STATE": self.state(number)}


def number_of(words, text):
    """Number of a word of an enumeration. A number is accepted if it has a word; if the words are Names, any number is accepted."""
    for number, word in words.items():
        if text.strip().upper() == word or text.strip() == str(number):
            return number
    if isinstance(words, Names) and text.strip().isdecimal():
        return int(text)
    raise ValueProblem(f"no {quoted(text.strip())}; there are: {', '.join(words.values())}")


def from_text(kind, count, text, enumeration=None):
    """List of exactly `count` scalars, separated by commas. With an enumeration (number -> word), each is one of its words or numbers."""
    words = text.split(",")
    if len(words) != count:
        raise ValueProblem(f"{quoted(text)} has {len(words)} value{'s' if len(words) != 1 else ''}, {count} expected")
    return [number_of(enumeration, word) if enumeration else scalar_from_text(kind, word) for word in words]


def to_text(values):
    """Compact text of one value or a list."""
    if isinstance(values, (list, tuple)):
        return "[" + ", ".join(to_text(value) for value in values) + "]" if len(values) != 1 else to_text(values[0])
    if isinstance(values, dict):
        return "{" + ", ".join(f"{name}: {to_text(value)}" for name, value in values.items()) + "}"
    if isinstance(values, float):
        return f"{values:.6g}"
    return str(values)


def bits_of(item):
    """Names of the bits of values in the content of a dictionary, by the name of the value: {"statusword": Bits}."""
    found = {}
    for part in item.values() if isinstance(item, dict) else item if isinstance(item, list) else ():
        found |= bits_of(part)
    if isinstance(item, dict) and isinstance(item.get("bits"), dict):
        found[item["bits"]["name"]] = Bits(item["bits"])
    return found


def bits_for(signal, bits):
    """The names of the bits of a signal, whose name begins with that of the value, as StatuswordAxis2; or None. bits: those of bits_of."""
    return next((item for name, item in bits.items() if signal.lower().startswith(name)), None)
