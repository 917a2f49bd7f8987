# SPDX-License-Identifier: Apache-2.0
"""Decide which commands must be armed before they are sent: those with a request that the catalogue declares critical, or with a function
that its descriptor declares critical. Requests within requests count too, for example those of a schedule."""

from . import packets
from .dictionary import DictionaryError

FUNCTION, NAME_OCTETS = (8, 1), 8
RAW = "raw"


def is_critical(planned, dictionary):
    """Whether a planned command is critical. Raw octets are always critical, because nothing checks them."""
    asked = (*planned.requests, *planned.later)
    return planned.text == RAW or any(_request(dictionary, one.apid, one.service, one.subtype, one.data) for one in asked)


def _request(dictionary, apid, service, subtype, data):
    catalogue = dictionary.catalogue
    entry = catalogue.flags(service, subtype)
    if entry is None:
        return True
    if (service, subtype) == FUNCTION:
        return _function(dictionary, apid, data)
    if entry["is_critical"]:
        return not catalogue.is_harmless(entry, data)
    return any(_within(dictionary, octets) for octets in catalogue.requests_in(entry, data))


def _function(dictionary, apid, data):
    try:
        name = data[:NAME_OCTETS].rstrip(b"\0").decode("ascii")
        return dictionary.subsystem(str(apid)).function(name).is_critical
    except (UnicodeDecodeError, DictionaryError):
        return True


def _within(dictionary, octets):
    try:
        packet = packets.parse(octets)
    except packets.PacketError:
        return True
    return _request(dictionary, packet.apid, packet.service, packet.subtype, packet.data)
