# SPDX-License-Identifier: Apache-2.0
"""Decide on the interface of which subsystems a command depends: the octets of its requests contain ids and types that the dictionary defines
for them. Requests within requests count too, for example those of a schedule."""

from .. import packets

STANDARD = {(17, 1), (129, 1), (129, 6)}  # Requests that are the same for every interface: ping, state, reload.


def subsystems_of(planned, dictionary):
    """Names of these subsystems, in the order of the requests."""
    apids = (apid for one in planned.requests for apid in _apids(dictionary, one.apid, one.service, one.subtype, one.data))
    return [dictionary.name_of_apid(apid) for apid in dict.fromkeys(apids)]


def _apids(dictionary, apid, service, subtype, data):
    if (service, subtype) not in STANDARD:
        yield apid
    entry = dictionary.catalogue.flags(service, subtype)
    for octets in dictionary.catalogue.requests_in(entry, data) if entry else ():
        try:
            packet = packets.parse(octets)
        except packets.PacketError:
            continue
        yield from _apids(dictionary, packet.apid, packet.service, packet.subtype, packet.data)
