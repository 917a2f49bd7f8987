# SPDX-License-Identifier: Apache-2.0
"""The newest packets of each kind that a station has received and sent, for the pages.

Many packets arrive in a second. A packet is therefore only stored when it arrives; its fields are read when a page asks for them."""

import collections
import contextlib
import dataclasses

from .. import packets
from ..command import UsageError
from ..octets import Layouts

KEPT = 20  # Packets of each kind.
OCTETS_MAX = 1 << 16  # Largest number of octets of all packets in one answer; a single packet may have more.
KINDS_MAX = 300  # Kinds of packets. If there are more, the kind that is the oldest is dropped.
DETAILED = {(3, 25), (3, 26), (5, 1), (5, 2), (5, 3), (5, 4)}  # The first two octets of these reports identify a structure or an event.


class KeptPackets:
    """A kind is a message of one subsystem; each structure of housekeeping and each event is a kind of its own."""

    def __init__(self, dictionary):
        self.dictionary = dictionary
        self._kinds = collections.OrderedDict()  # (direction, APID, service, subtype, structure or event) -> newest packets
        self._layouts = None

    def take(self, packet, seconds):
        """Store a packet. seconds: mission time at which it has arrived or was sent."""
        detail = int.from_bytes(packet.data[:2], "big") if packet.direction == "TM" and packet.message in DETAILED else None
        kind = packet.direction, packet.apid, *packet.message, detail
        if kind not in self._kinds:
            if len(self._kinds) >= KINDS_MAX:
                self._kinds.popitem(last=False)
            self._kinds[kind] = collections.deque(maxlen=KEPT)
        self._kinds[kind].append((seconds, packet))

    def take_sent(self, raw, seconds):
        """Store a telecommand. Octets that are no packet, as a user may send them, are not stored."""
        with contextlib.suppress(packets.PacketError):
            self.take(packets.parse(raw), seconds)

    def _known(self):
        if self._layouts is None:
            self._layouts = Layouts(self.dictionary)
        return self._layouts

    def _name(self, kind, packet):
        """Name of a kind: its structure, its event, or its message."""
        _, apid, service, _, detail = kind
        owner = self.dictionary.subsystem_of_apid(apid)
        if detail is None or owner is None:
            return self._known().title(packet)
        event = owner.event_of_id(detail) if service == 5 else None
        return f"structure {detail}" if service == 3 else event.name if event else f"event {detail}"

    def rows(self):
        """The kinds, telecommands first, with the newest packet of each."""
        found = []
        for kind, kept in sorted(self._kinds.items(), key=lambda item: (item[0][0], item[0][1:4], item[0][4] or 0)):
            seconds, packet = kept[-1]
            found.append({"kind": list(kind), "time": seconds, "message": packet.title, "size": len(packet.raw),
                          "subsystem": self.dictionary.name_of_apid(packet.apid), "name": self._name(kind, packet)})
        return found

    def packets(self, kind, configurations):
        """The stored packets of a kind with their octets and fields, the oldest first; of long packets only the newest. A page keeps them, so
        that the user can compare them while others arrive. configurations: APID -> id of the present configuration. Raises UsageError."""
        kept = self._kinds.get(tuple(kind))
        if not kept:
            raise UsageError("no packet of this kind is stored")
        found, octets = [], 0
        for seconds, packet in reversed(kept):
            octets += len(packet.raw)
            if found and octets > OCTETS_MAX:
                break
            spans = self._known().spans(packet, configurations.get(packet.apid))
            found.insert(0, {"time": seconds, "octets": packet.raw.hex(), "fields": [dataclasses.asdict(one) for one in spans]})
        packet = kept[-1][1]
        about = {"message": packet.title, "subsystem": self.dictionary.name_of_apid(packet.apid), "name": self._name(tuple(kind), packet)}
        return {**about, "packets": found}
