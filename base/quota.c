// SPDX-License-Identifier: Apache-2.0
#include "base/quota.h"

#include "base/assertion.h"
#include "base/pool.h"
#include "base/take_check.h"

#include <stddef.h>

static void update_warning(quota_t* const quota)
{
    if (!quota->stats.warning && (quota->stats.used >= quota->warn_at)) {
        quota->stats.warning = true;
        quota->stats.warnings++;
        quota->is_unpolled = true;
    } else if (quota->stats.warning && (quota->stats.used <= quota->clear_at)) {
        quota->stats.warning = false;
    }
}

void quota_init(quota_t* const quota, const uint16_t limit)
{
    FSW_ASSERT((quota != NULL) && (limit >= 1U));
    *quota = (quota_t){.limit    = limit,
                       .warn_at  = (uint16_t)((((uint32_t)limit * POOL_WARN_PERCENT) + 99U) / 100U),
                       .clear_at = (uint16_t)(((uint32_t)limit * POOL_CLEAR_PERCENT) / 100U)};
}

status_t quota_take(quota_t* const quota)
{
    if (quota == NULL) {
        return STATUS_OK;
    }
    if ((quota->stats.used >= quota->limit) || take_check_is_refused(quota)) {
        quota->stats.refused++;
        return STATUS_EXHAUSTED;
    }
    quota->stats.used++;
    if (quota->stats.used > quota->stats.peak) {
        quota->stats.peak = quota->stats.used;
    }
    update_warning(quota);
    return STATUS_OK;
}

void quota_give(quota_t* const quota)
{
    if (quota == NULL) {
        return;
    }
    FSW_ASSERT(quota->stats.used > 0U);
    quota->stats.used--;
    update_warning(quota);
}

bool quota_poll_warning(quota_t* const quota)
{
    FSW_ASSERT(quota != NULL);
    const bool is_unpolled = quota->is_unpolled;
    quota->is_unpolled     = false;
    return is_unpolled;
}
