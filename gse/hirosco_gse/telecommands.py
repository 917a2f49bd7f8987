# SPDX-License-Identifier: Apache-2.0
"""Decode telecommands in a log: a dict for programs and a line for people, as telemetry.py does for telemetry."""

import struct

from . import telemetry, values
from .dictionary import STATES, STRATEGIES
from .failures import name_of


def _state(packet, _):
    return {"state": name_of(STATES, packet.data[0])}


def _order(packet, _):
    return {"state": name_of(STATES, packet.data[0]), "cause": name_of(telemetry.CAUSES, packet.data[1])}


def _configuration(packet, dictionary):
    number, subsystem = struct.unpack(">H", packet.data)[0], dictionary.subsystem_of_apid(packet.apid)
    return {"configuration": subsystem.configuration_name(number) if subsystem else str(number)}


def _mode(packet, dictionary):
    names = {item["id"]: item["name"] for item in dictionary.modes}
    return {"mode": names.get(packet.data[0], str(packet.data[0]))}


def _log(packet, _):
    return {"strategy": name_of(STRATEGIES, packet.data[0])}


def _process(packet, dictionary):
    return {"subsystem": dictionary.name_of_apid(struct.unpack(">H", packet.data)[0])}


def _request(packet, dictionary):
    transaction, number, producer, producer_port, consumer, consumer_port = struct.unpack_from(">IHHHHH", packet.data)
    ends = (producer, producer_port, consumer, consumer_port)
    names = {(link.producer, link.producer_port, link.consumer, link.consumer_port): link.name for link in dictionary.links}
    return {"transaction": transaction, "link": names.get(ends, str(number))}


def _link(packet, _):
    return {"link": struct.unpack_from(">H", packet.data)[0]}


def _nothing(*_):
    return {}


_OWN = {  # docs/services: requests of the mission's own services
    (129, 1): ("request a state", _state),
    (129, 3): ("select a configuration", _configuration),
    (129, 4): ("report the status", _nothing),
    (129, 6): ("reload the descriptor", _nothing),
    (129, 8): ("order a state", _order),
    (130, 1): ("report the link offers", _nothing),
    (130, 3): ("request a link", _request),
    (130, 6): ("open a link", _link),
    (130, 7): ("close a link", _link),
    (130, 8): ("report the links", _nothing),
    (131, 1): ("set the mode", _mode),
    (131, 3): ("switch the packet log", _log),
    (131, 5): ("shut down", _nothing),
    (131, 6): ("start a process", _process),
    (131, 7): ("stop a process", _process),
    (131, 8): ("report the subsystems", _nothing),
    (131, 10): ("report the networks", _nothing),
}


def _function(packet, dictionary):
    name = packet.data[:8].rstrip(b"\0").decode("ascii", "replace")
    function = dictionary.subsystem_of_apid(packet.apid).function(name)
    arguments, offset = {item.id: item for item in function.arguments}, 9
    given = {}
    for _ in range(packet.data[8]):
        item = arguments[struct.unpack_from(">H", packet.data, offset)[0]]
        given[item.name], offset = item.decode(packet.data, offset + 2)
    return {"kind": "perform a function", "function": function.name, "values": given}


def _given(request, dictionary):
    """(Field or Parameter, its values) of a request for a function or for setting parameters."""
    subsystem, data = dictionary.subsystem_of_apid(request.apid), request.data
    if (request.service, request.subtype) == (8, 1):
        function = subsystem.function(data[:8].rstrip(b"\0").decode("ascii", "replace"))
        known, count, offset, size = {item.id: item for item in function.arguments}, data[8], 9, 2
    elif (request.service, request.subtype) == (20, 3):
        known, count, offset, size = {item.parameter_id: item for item in subsystem.parameters.values()}, data[0], 1, 4
    else:
        return
    for _ in range(count):
        item = known[int.from_bytes(data[offset : offset + size], "big")]
        offset += size
        for member in getattr(item, "fields", ()) or (item,):
            found, offset = member.decode(data, offset)
            yield member, found


def beyond_limits(request, dictionary):
    """Values of a request that are outside the limits of the dictionary, with unit and limits, in words; empty if there are none."""
    words = []
    try:
        for item, found in _given(request, dictionary):
            low, high = item.min, item.max
            numbers = [value for value in found if isinstance(value, (int, float))]
            if any(not ((low is None or value >= low) and (high is None or value <= high)) for value in numbers):
                unit = f" {item.unit}" if item.unit else ""
                limits = " and ".join(filter(None, (f"at least {low:g}" if low is not None else "", f"at most {high:g}" if high is not None else "")))
                words.append(f"{item.name} is {values.to_text(found)}{unit}, expected {limits}{unit}")
    except (struct.error, IndexError, KeyError, AttributeError, ValueError):
        pass  # The user has given raw octets that do not decode.
    return "; ".join(words)


def decode(packet, dictionary):
    """Content of a TC as a dict with at least "kind". If the content cannot be decoded, "error" contains the reason."""
    try:
        if packet.message == (8, 1):
            return _function(packet, dictionary)
        if packet.message in _OWN:
            kind, read = _OWN[packet.message]
            return {"kind": kind, **read(packet, dictionary)}
        entry = dictionary.catalogue.find("TC", *packet.message)
        if entry is None:
            raise values.ValueProblem("not in the catalogue of messages")
        return {"kind": entry["name"], **dictionary.catalogue.decode(packet)}
    except (struct.error, IndexError, KeyError, AttributeError, ValueError) as error:
        return {"kind": "request", "error": f"{packet.title} cannot be decoded: {error}"}


def describe(packet, decoded, dictionary):
    """One line of text, without the time."""
    target = dictionary.name_of_apid(packet.apid)
    if "function" in decoded:
        items = {item.name: item for item in dictionary.subsystem_of_apid(packet.apid).function(decoded["function"]).arguments}
        return f"to {target}: {decoded['function']} {telemetry.measured(decoded['values'], items)}".rstrip()
    return telemetry.describe(packet, decoded, dictionary).replace(f"{target}: ", f"to {target}: ", 1)
