// SPDX-License-Identifier: Apache-2.0
/// Traffic class of a packet. It determines the priority of the packet, and whether the packet is kept if the
/// connection to its receiver is full.
///
///     FIRM   packets that a receiver awaits or must react to: ST[01], transitions of states, links and modes
///            (TM[129,2], [130,10], [131,2]), HIGH events and their notices, orders of the supervisor
///     PLAIN  other events and notices, answers that fit one packet, other requests
///     BULK   housekeeping, diagnostics, statistics, lists over many packets, dumps, parts of large packets:
///            the sender continues later, or counts the lost packets
///
/// Context    Any.
/// Time       O(1).
#ifndef PUS_CORE_TRAFFIC_CLASS_H
#define PUS_CORE_TRAFFIC_CLASS_H

#include "pus/core/packet.h"

typedef enum {
    PUS_CLASS_FIRM,
    PUS_CLASS_PLAIN,
    PUS_CLASS_BULK
} pus_class_t;

#define PUS_CLASSES 3U

/// Class of a packet, from its headers and, for a notice of an event, its severity. Packets that are too
/// short or malformed are BULK.
pus_class_t pus_class_of(const uint8_t* packet, size_t size);

#endif // PUS_CORE_TRAFFIC_CLASS_H
