// SPDX-License-Identifier: Apache-2.0
/// Checks whether the reports that wait for the ground are consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_GROUND_H
#define TEST_SUPPORT_CONSISTENT_GROUND_H

#include "fsw/supervisor/ground_backlog.h"

/// True if the number of blocks in the queues equals the number taken from the pools, and no queue exceeds
/// its limits. While a packet is being routed, its block is in no queue.
static inline bool ground_backlog_is_consistent(const ground_backlog_t* backlog)
{
    bool is_within   = true;
    unsigned waiting = 0U;
    unsigned taken   = 0U;
    for (unsigned i = 0U; i < PUS_CLASSES; i++) {
        const backlog_queue_t* const queue = &backlog->queues[i];
        is_within = is_within && (queue->octets <= queue->limit) && (queue->span <= queue->capacity);
        for (unsigned k = 0U; k < queue->span; k++) {
            waiting += (queue->entries[(queue->head + k) % queue->capacity].block != NULL) ? 1U : 0U;
        }
    }
    for (unsigned i = 0U; i < GROUND_SIZES; i++) {
        taken += backlog->blocks.pools[i].stats.taken;
    }
    return is_within && (waiting == taken);
}

#endif // TEST_SUPPORT_CONSISTENT_GROUND_H
