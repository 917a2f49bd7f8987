// SPDX-License-Identifier: Apache-2.0
/// Quota: a limit on the number of system objects in use, such as sockets, connections and open devices. They
/// are counted like the blocks of a pool, with the same warning before a take is refused.
///
/// Ownership  The caller provides quota_t. It contains only numbers: the caller that takes a unit returns it.
/// Context    One loop.
/// Time       O(1), never blocks.
/// Errors     Each function lists its statuses; a limit of 0, or null where it is not allowed, is a coding
///            error.
#ifndef BASE_QUOTA_H
#define BASE_QUOTA_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private, except `stats`: read-only, for housekeeping telemetry.
    uint16_t limit;
    uint16_t warn_at;
    uint16_t clear_at;
    bool is_unpolled;
    struct {
        uint16_t used;     ///< Units taken now [0..limit].
        uint16_t peak;     ///< Largest `used` since quota_init.
        bool warning;      ///< `used` is at or above the threshold (with hysteresis).
        uint32_t warnings; ///< Number of times that `warning` became true [wraps].
        uint32_t refused;  ///< Takes refused because all units were taken [calls, wraps].
    } stats;
} quota_t;

/// Make all units free and clear the counters. limit >= 1; the thresholds are those of pools
/// (POOL_WARN_PERCENT, POOL_CLEAR_PERCENT).
void quota_init(quota_t* quota, uint16_t limit);
/// Take one unit. Null means no quota: STATUS_OK, and nothing is counted. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t quota_take(quota_t* quota);
/// Return one unit; null: no effect. Returning more than was taken is a coding error.
void quota_give(quota_t* quota);
/// True if `warning` has become true since the last call.
bool quota_poll_warning(quota_t* quota);

#endif // BASE_QUOTA_H
