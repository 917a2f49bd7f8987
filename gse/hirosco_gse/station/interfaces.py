# SPDX-License-Identifier: Apache-2.0
"""Decide on the interface of which subsystems a command depends: the octets of its requests contain ids and types that the dictionary defines
for them. Requests within requests count too, for example those of a schedule."""

import struct

from .. import packets

# Requests that are the same for every interface: ping, state, reload, closing of a link, start and stop of a process.
STANDARD = {(17, 1), (129, 1), (129, 6), (130, 7), (131, 6), (131, 7)}
LINK, LINK_ENDS = (130, 3), struct.Struct(">IHHHHH")  # A link: transaction, id, then APID and port of its producer and of its consumer.


def subsystems_of(planned, dictionary):
    """Names of the subsystems on whose interface a planned command depends, in the order of its requests."""
    apids = (apid for one in (*planned.requests, *planned.later) for apid in _apids(dictionary, one.apid, one.service, one.subtype, one.data))
    return [dictionary.name_of_apid(apid) for apid in dict.fromkeys(apids)]


def barrier(hub, planned):
    """Why a command of an operator is not sent now, in words; None if it is sent. If one of its subsystems flies another interface, its octets
    may mean something else there."""
    if not hub.is_linked:
        return "no link to the spacecraft"
    differing = (hub.mismatches.get(name, {}).get("words") for name in subsystems_of(planned, hub.dictionary))
    return next((f"disabled: {words}" for words in differing if words), None)


def _apids(dictionary, apid, service, subtype, data):
    if (service, subtype) not in STANDARD:
        yield apid
    if (service, subtype) == LINK and len(data) >= LINK_ENDS.size:  # The request contains the layout of the samples, which both ends define.
        _, _, producer, _, consumer, _ = LINK_ENDS.unpack_from(data)
        yield from (producer, consumer)
    entry = dictionary.catalogue.flags(service, subtype)
    for octets in dictionary.catalogue.requests_in(entry, data) if entry else ():
        try:
            packet = packets.parse(octets)
        except packets.PacketError:
            continue
        yield from _apids(dictionary, packet.apid, packet.service, packet.subtype, packet.data)
