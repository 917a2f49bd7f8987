# SPDX-License-Identifier: Apache-2.0
"""Descriptor files as trees of elements with their lines, checked against a table of the permitted structure.

The table, the semantic checks and both hashes are the same as in fsw/framework/descriptor; a test compares them.
"""

import re
import xml.parsers.expat

FNV_START = 0xCBF29CE484222325
FNV_PRIME = 0x100000001B3
IDENTIFIER = re.compile(r"[A-Z][A-Z0-9_]{0,31}\Z")
NAME_MAX = 32  # Characters of a name.
BUS_NAME_MAX = 15  # Characters of the name of a bus, which names an interface of Linux. osal/include/osal/can_interface.h has the same value.
LOWER_IDENTIFIER = re.compile(r"[a-z][a-z0-9_-]{0,31}\Z")
INTEGER = re.compile(r"-?[0-9]+\Z|0x[0-9A-Fa-f]+\Z")
REAL = re.compile(r"-?([0-9]+)(?:\.([0-9]+))?(?:[eE]([+-]?[0-9]{1,4}))?\Z")
TIME = re.compile(r"([0-9]{1,9})(us|ms|s)\Z")
TIME_US = {"us": 1, "ms": 1000, "s": 1000000}
NUMBER_OUT_OF_RANGE = object()

# Scalar types: code in the layout bits, octets, struct letter, C type, smallest and largest value.
TYPES = {
    "UINT8": (0, 1, "B", "uint8_t"),
    "UINT16": (1, 2, "H", "uint16_t"),
    "UINT32": (2, 4, "I", "uint32_t"),
    "UINT64": (3, 8, "Q", "uint64_t"),
    "INT8": (4, 1, "b", "int8_t"),
    "INT16": (5, 2, "h", "int16_t"),
    "INT32": (6, 4, "i", "int32_t"),
    "INT64": (7, 8, "q", "int64_t"),
    "FLOAT": (8, 4, "f", "float"),
    "DOUBLE": (9, 8, "d", "double"),
    "BOOL": (10, 1, "B", "bool"),
}
LAYOUT_STRUCT = 24
LAYOUT_ARRAY = 25
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
REST_STATES = (0, 3, 4, 5, 6)
SEVERITIES = {"INFORMATIVE": 1, "LOW": 2, "MEDIUM": 3, "HIGH": 4}
METHODS = ("SHARED_MEMORY", "TIPC", "UDP", "STREAM", "MESSAGE_QUEUE")


class DescriptorError(Exception):
    """An error in a descriptor: file, line, value found and value expected."""

    def __init__(self, path, line, message):
        super().__init__(f"{path}:{line}: {message}")


def text_of(path):
    """Text of a file in UTF-8. Raises DescriptorError with the line of an octet that is not UTF-8."""
    octets = path.read_bytes()
    try:
        return octets.decode("utf-8")
    except UnicodeDecodeError as error:
        line = octets[: error.start].count(b"\n") + 1
        raise DescriptorError(path, line, f"found octet 0x{octets[error.start]:02X}, expected UTF-8: convert the file, for example with iconv") from error


class Element:
    """An element: name, attributes, children, file and line."""

    def __init__(self, path, line, name, attributes):
        self.path, self.line, self.name, self.attributes, self.children = path, line, name, attributes, []

    def fail(self, message):
        """Raise an error at this element."""
        raise DescriptorError(self.path, self.line, message)

    def wrong(self, attribute, expected):
        """Raise an error about the value of an attribute."""
        self.fail(f"{attribute}=\"{self.attributes[attribute]}\" of <{self.name}>: expected {expected}")

    def all(self, *names):
        """Children of these names, in order."""
        return [child for child in self.children if child.name in names]

    def first(self, name):
        """First child of a name, or None."""
        return next((child for child in self.children if child.name == name), None)

    def text(self, attribute, default=None):
        """Value of an attribute as written."""
        return self.attributes.get(attribute, default)

    def identifier(self, attribute="name", longest=32):
        """Upper-case identifier."""
        value = self.attributes[attribute]
        if not IDENTIFIER.match(value) or len(value) > longest:
            self.wrong(attribute, f"an upper-case identifier (A-Z 0-9 _) of at most {longest} characters")
        return value

    def lower_identifier(self, attribute="name", longest=NAME_MAX):
        """Lower-case identifier: buses, missions, programs."""
        if not LOWER_IDENTIFIER.match(self.attributes[attribute]) or len(self.attributes[attribute]) > longest:
            self.wrong(attribute, f"a lower-case identifier (a-z 0-9 _ -) of at most {longest} characters")
        return self.attributes[attribute]

    def unsigned(self, attribute, low, high, default=None):
        """Unsigned number within bounds."""
        if attribute not in self.attributes:
            return default
        value = read_unsigned(self.attributes[attribute])
        if value is None or not low <= value <= high:
            self.wrong(attribute, f"a number from {low} to {high}")
        return value

    def time_us(self, attribute, low, high, default=None):
        """Time with a unit, in microseconds."""
        if attribute not in self.attributes:
            return default
        match = TIME.match(self.attributes[attribute])
        value = int(match[1]) * TIME_US[match[2]] if match else -1
        if not low <= value <= high:
            self.wrong(attribute, f"a time like 500us, 2ms or 1s, from {low}us to {high}us")
        return value

    def flag(self, attribute, default=False):
        """Value of an attribute that is true or false."""
        value = self.attributes.get(attribute)
        if value is None:
            return default
        if value not in ("true", "false"):
            self.wrong(attribute, "true or false")
        return value == "true"

    def word(self, attribute, words, default=None):
        """Value of an attribute that must be one of a list of words."""
        if attribute not in self.attributes:
            return default
        if self.attributes[attribute] not in words:
            self.wrong(attribute, "one of " + " ".join(words))
        return self.attributes[attribute]

    def words(self, attribute, known):
        """Value of an attribute that is a list of words, each at most once."""
        found = self.attributes[attribute].split(" ")
        for word in found:
            if word not in known or found.count(word) > 1:
                self.wrong(attribute, "one or more words, each once, separated by single spaces, of " + " ".join(known))
        return found


def unique(elements, *attributes):
    """Refuse two elements with the same value of an attribute. Names are compared as text, ids as numbers."""
    for attribute in attributes:
        seen = {}
        for element in elements:
            text = element.attributes.get(attribute)
            if text is None:
                continue
            key = read_unsigned(text) if attribute == "id" else text
            if key in seen:
                element.fail(f"{attribute}=\"{text}\" of <{element.name}> is taken in line {seen[key]}")
            seen[key] = element.line


def read_unsigned(text):
    """Unsigned number that a word contains, or None."""
    if not INTEGER.match(text) or text.startswith("-"):
        return None
    value = int(text, 16) if text.startswith("0x") else int(text)
    return value if value <= 0xFFFFFFFFFFFFFFFF else None


def read_number(text, kind):
    """Scalar of a type from a word; None if the word is not a number, NUMBER_OUT_OF_RANGE if it does not fit."""
    if kind == "BOOL":
        return {"true": 1, "false": 0, "1": 1, "0": 0}.get(text)
    if kind in ("FLOAT", "DOUBLE"):
        return _read_real(text, kind)
    if not INTEGER.match(text):
        return None
    value = int(text, 16) if text.startswith("0x") else int(text)
    bits = TYPES[kind][1] * 8
    low, high = (0, (1 << bits) - 1) if kind.startswith("U") else (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
    return value if low <= value <= high and not (low == 0 and text[0] == "-") else NUMBER_OUT_OF_RANGE


def _read_real(text, kind):
    match = REAL.match(text)
    if not match:
        return None
    fraction = match[2] or ""
    digits = (match[1] + fraction).lstrip("0")
    exponent = int(match[3] or 0) - len(fraction)
    if len(digits) > 15 or (digits and not -22 <= exponent <= 22):
        return NUMBER_OUT_OF_RANGE
    value = float(text)
    return value if kind == "DOUBLE" or abs(value) <= 3.4028234663852886e38 else NUMBER_OUT_OF_RANGE


def fnv64(octets, value=FNV_START):
    """Hash FNV-1a of 64 bits."""
    for octet in octets:
        value = ((value ^ octet) * FNV_PRIME) & 0xFFFFFFFFFFFFFFFF
    return value


def canonical(element):
    """Text of an element for the configuration hash: no comments, no white space, sorted attributes."""
    lines = [f"<{element.name}\n"]
    lines += [f"{name}={element.attributes[name]}\n" for name in sorted(element.attributes, key=str.encode)]
    lines += [canonical(child) for child in element.children]
    return "".join(lines) + ">\n"


def read(path, table, root):
    """Read the tree of a file and check its structure against a table {(parent, element): "attribute! attribute ..."}; `!` marks a required attribute."""
    try:
        octets = path.read_bytes()
    except OSError as error:
        raise DescriptorError(path, 0, f"cannot read: {error.strerror}") from error
    if len(octets) > 1 << 20:
        raise DescriptorError(path, 0, f"{len(octets)} octets, at most 1048576")
    return _Reader(path, table, root).read(octets)


class _Reader:
    def __init__(self, path, table, root):
        self.path, self.table, self.root = path, table, root
        self.stack, self.tree = [], None
        self.parser = xml.parsers.expat.ParserCreate("UTF-8")
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = lambda name: self.stack.pop()
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.parser.XmlDeclHandler = self.declaration
        self.parser.buffer_text = False

    def fail(self, message):
        raise DescriptorError(self.path, self.parser.CurrentLineNumber, message)

    def read(self, octets):
        try:
            self.parser.Parse(octets, True)
        except xml.parsers.expat.ExpatError as error:
            text = xml.parsers.expat.ErrorString(error.code)
            raise DescriptorError(self.path, error.lineno, f"not well-formed: {text}") from error
        return self.tree

    def doctype(self, *_):
        self.fail("document type declarations are not allowed")

    def declaration(self, version, encoding, _standalone):
        if version != "1.0":
            self.fail(f"version \"{version}\": expected 1.0")
        if encoding and encoding.upper() != "UTF-8":
            self.fail(f"encoding \"{encoding}\": expected UTF-8")

    def characters(self, text):
        if text.strip(" \t\r\n"):
            self.fail(f"text \"{text.strip()[:40]}\" between elements: expected none")

    def start(self, name, attributes):
        parent = self.stack[-1].name if self.stack else ""
        specification = self.table.get((parent, name))
        if specification is None:
            known = " ".join(child for above, child in self.table if above == parent)
            if not self.stack:
                self.fail(f"<{name}>: expected <{self.root}>")
            self.fail(f"<{name}> in <{parent}>: expected " + (f"one of {known}" if known else "nothing"))
        words = [word.rstrip("!") for word in specification.split()]
        for attribute in attributes:
            if attribute not in words:
                self.fail(f"attribute {attribute} of <{name}>: expected {'one of ' + ' '.join(words) if words else 'none'}")
        for word in specification.split():
            if word.endswith("!") and word[:-1] not in attributes:
                self.fail(f"<{name}> needs attribute {word[:-1]}")
        element = Element(self.path, self.parser.CurrentLineNumber, name, attributes)
        if self.stack:
            self.stack[-1].children.append(element)
        else:
            self.tree = element
        self.stack.append(element)
