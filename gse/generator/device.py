# SPDX-License-Identifier: Apache-2.0
"""Devices of a configuration: their settings, quantities, supplies and end nodes."""

from dataclasses import dataclass

from source import BUS_NAME_MAX, NUMBER_OUT_OF_RANGE, TYPES, read_number

# Attributes of an end node that describe the records which it transfers.
RECORDS = ("checksum", "silence", "retry", "retryLongest")
ENDNODES = {  # type: required and optional attributes; all others are refused
    "CAN": (("bus", "node"), ()),
    "SHM": (("name",), ("order", *RECORDS)),
    "MQUEUE": (("name",), ("order", *RECORDS)),
    "UDP": (("address", "port"), ("order", *RECORDS)),
    "TCP": (("address", "port"), ("framing", "order", *RECORDS)),
    "SERIAL": (("name",), ("framing", "order", "baud", *RECORDS)),
    "FILE": (("name",), ("framing", "order", "direction", *RECORDS)),
}
FLOW_FORMAT = {
    "framing": ("RAW", "LENGTH", "SLIP", "LINE"),
    "order": ("BIG", "LITTLE"),
    "direction": ("BOTH", "READ", "WRITE"),
    "baud": ("9600", "19200", "38400", "57600", "115200", "230400", "460800", "921600"),
}
SETTING_TYPES = tuple(name for name in TYPES if name != "BOOL")


@dataclass
class Device:
    """A device with its settings and addresses."""

    element: object
    name: str
    type: str
    settings: list
    endnodes: list


def device_of(element):
    """Device that an element describes. The caller must check that names and ids of its quantities are unique."""
    device = Device(element, element.identifier(), element.lower_identifier("type"), [], [])
    for child in element.children:
        if child.name == "Setting":
            _setting(child)
            device.settings.append(child)
        elif child.name == "Quantity":
            _quantity(child)
        elif child.name == "Supply":
            _supply(child)
        elif child.name == "Field":
            _field(child)
        else:
            _endnode(child)
            device.endnodes.append(child)
    return device


def _object(element):
    text = element.attributes["object"]
    index, _, sub = text.partition(":")
    if len(text) != 9 or not text.startswith("0x") or any(c not in "0123456789ABCDEFabcdef" for c in index[2:] + sub):
        element.wrong("object", "an object like 0x6060:00")
    return element.word("type", SETTING_TYPES)


def _setting(element):
    kind = _object(element)
    value = read_number(element.attributes["value"], kind)
    if value is None or value is NUMBER_OUT_OF_RANGE:
        element.wrong("value", f"a number of type {kind}")


def _unit(element):
    if len(element.text("unit", "")) > 16:
        element.wrong("unit", "at most 16 characters")


def _quantity(element):
    element.identifier()
    element.unsigned("id", 0, 65535)
    _object(element)
    _unit(element)
    element.flag("settable")
    if read_number(element.attributes["scale"], "DOUBLE") in (None, NUMBER_OUT_OF_RANGE, 0.0):
        element.wrong("scale", "a number other than 0")


def _supply(element):
    element.unsigned("unit", 1, 127)
    if element.unsigned("on", 1, 255) == element.unsigned("off", 1, 255):
        element.wrong("off", "a line other than that of on")


def _field(element):
    """Check a field in the records of a stream device."""
    element.identifier()
    direction = element.word("direction", ("IN", "OUT"))
    element.word("type", tuple(name for name in TYPES if name != "BOOL"))
    _unit(element)
    for attribute in ("scale", "offset", "safe"):
        if attribute in element.attributes and read_number(element.attributes[attribute], "DOUBLE") in (None, NUMBER_OUT_OF_RANGE):
            element.wrong(attribute, "a number of type DOUBLE")
    if read_number(element.attributes.get("scale", "1"), "DOUBLE") == 0.0:
        element.wrong("scale", "a number other than 0")
    if direction == "IN" and "safe" in element.attributes:
        element.fail("<Field> of direction IN cannot have attribute safe")


def _records(element, may_have):
    """Check the attributes of an end node that describe the records which it transfers."""
    kind = element.attributes["type"]
    for attribute in RECORDS:
        if attribute in element.attributes and attribute not in may_have:
            element.fail(f"<Endnode> of type {kind} cannot have attribute {attribute}")
    if kind == "CAN":
        return
    element.flag("checksum")
    element.time_us("silence", 100, 60000000, 100000)
    retry = element.time_us("retry", 100, 60000000, 10000)
    if retry > element.time_us("retryLongest", 100, 60000000, 1000000):
        element.fail(f"<Endnode>: expected a retryLongest of at least retry, {retry} us")


def _endnode(element):
    needs, may_have = ENDNODES[element.word("type", tuple(ENDNODES))]
    for attribute in ("bus", "node", "name", "address", "port"):
        if (attribute in element.attributes) != (attribute in needs):
            verb = "needs" if attribute in needs else "cannot have"
            element.fail(f"<Endnode> of type {element.attributes['type']} {verb} attribute {attribute}")
    for attribute, words in FLOW_FORMAT.items():
        if attribute in element.attributes and attribute not in may_have:
            element.fail(f"<Endnode> of type {element.attributes['type']} cannot have attribute {attribute}")
        element.word(attribute, words)
    _records(element, may_have)
    if "redundantBus" in element.attributes and "bus" not in needs:
        element.fail(f"<Endnode> of type {element.attributes['type']} cannot have attribute redundantBus")
    if "bus" in needs:
        element.lower_identifier("bus", BUS_NAME_MAX)
        if "redundantBus" in element.attributes:
            element.lower_identifier("redundantBus", BUS_NAME_MAX)
        element.unsigned("node", 1, 127)
    if "port" in needs:
        element.unsigned("port", 1, 65535)
