// SPDX-License-Identifier: Apache-2.0
/// Checks whether the reports that wait for the ground are consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_GROUND_H
#define TEST_SUPPORT_CONSISTENT_GROUND_H

#include "fsw/supervisor/ground_backlog.h"

/// True if the number of blocks in the lines equals the number taken from the pools, and no line exceeds its
/// limits. While a packet is being routed, its block is in no line.
static inline bool ground_backlog_is_consistent(const ground_backlog_t* backlog)
{
    bool is_within   = true;
    unsigned waiting = 0U;
    unsigned taken   = 0U;
    for (unsigned i = 0U; i < PUS_CLASSES; i++) {
        const ground_line_t* const line = &backlog->lines[i];
        is_within = is_within && (line->octets <= line->limit) && (line->span <= line->capacity);
        for (unsigned k = 0U; k < line->span; k++) {
            waiting += (line->entries[(line->head + k) % line->capacity].block != NULL) ? 1U : 0U;
        }
    }
    for (unsigned i = 0U; i < GROUND_SIZES; i++) {
        taken += backlog->blocks.pools[i].stats.taken;
    }
    return is_within && (waiting == taken);
}

#endif // TEST_SUPPORT_CONSISTENT_GROUND_H
