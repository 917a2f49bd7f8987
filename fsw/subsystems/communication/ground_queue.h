// SPDX-License-Identifier: Apache-2.0
/// Reports waiting for one ground client. If the client reads slowly, the oldest housekeeping reports are
/// dropped. Other reports, such as events and verification, are never dropped: they have their own queue.
/// The order of arrival is kept across both queues.
///
/// Ownership  The caller provides communication_ground_queue_t.
/// Context    One loop.
/// Time       O(size).
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_QUEUE_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_QUEUE_H

#include "base/status.h"
#include "fsw/framework/message/message_ring.h"
#include "pus/core/tailoring.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GROUND_QUEUE_OCTETS 131072U ///< Size of each of the two queues.
#define GROUND_STAMP_OCTETS 4U

typedef struct { // Private, except `dropped`.
    message_ring_t housekeeping;
    message_ring_t firm; // All other reports, which are never dropped.
    uint32_t next_stamp;
    size_t sending_size; // Size of the report being sent; 0: none.
    size_t sent;         // Number of its octets that were sent.
    uint32_t dropped;    ///< Housekeeping reports dropped [wraps].
    // The octets below are always written before they are read, so communication_ground_queue_init does not
    // clear them.
    uint8_t sending[GROUND_STAMP_OCTETS + PUS_PACKET_MAX];
    uint8_t housekeeping_storage[GROUND_QUEUE_OCTETS];
    uint8_t firm_storage[GROUND_QUEUE_OCTETS];
} communication_ground_queue_t;

void communication_ground_queue_init(communication_ground_queue_t* queue);
/// Append a report. STATUS_OK (old housekeeping reports may have been dropped), STATUS_FULL (no room for a
/// report that must not be dropped: the client does not read at all).
MUST_USE status_t communication_ground_queue_put(communication_ground_queue_t* queue, const uint8_t* packet,
                                                 size_t size);
/// Returns the octets to be sent next, or null if no report waits. They are kept until
/// communication_ground_queue_sent.
const uint8_t* communication_ground_queue_next(communication_ground_queue_t* queue, size_t* out_size);
/// Remove octets that were sent: `size` is at most the size that communication_ground_queue_next returned.
void communication_ground_queue_sent(communication_ground_queue_t* queue, size_t size);
/// Returns the free room for reports that must not be dropped [octets].
size_t communication_ground_queue_room(const communication_ground_queue_t* queue);
/// Returns the number of waiting reports.
uint32_t communication_ground_queue_count(const communication_ground_queue_t* queue);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_QUEUE_H
