// SPDX-License-Identifier: Apache-2.0
/// Quota: so many of something that the system lends - sockets, connections, open devices - and no more.
/// Counted like the blocks of a pool, with the same warning before anything fails.
///
/// Ownership  The caller places quota_t. It holds nothing but numbers: who takes one gives it back.
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
    bool is_news;
    struct {
        uint16_t used;     ///< Lent now [0..limit].
        uint16_t peak;     ///< Largest `used` since quota_init.
        bool warning;      ///< Use is at or above the threshold (with hysteresis).
        uint32_t warnings; ///< Times the warning has risen [wraps].
        uint32_t refused;  ///< Takes refused because all were lent [calls, wraps].
    } stats;
} quota_t;

/// None lent. limit >= 1; the thresholds are those of pools (POOL_WARN_PERCENT, POOL_CLEAR_PERCENT).
void quota_init(quota_t* quota, uint16_t limit);
/// Null is no quota: nothing is counted, and nothing refused. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t quota_take(quota_t* quota);
/// One less is used; of null nothing. Giving back what was never taken is a coding error.
void quota_give(quota_t* quota);
/// True once each time the warning has risen since the last call.
bool quota_poll_warning(quota_t* quota);

#endif // BASE_QUOTA_H
