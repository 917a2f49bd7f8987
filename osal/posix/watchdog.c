// SPDX-License-Identifier: Apache-2.0
// Processes are watched by the launcher and by the supervisor; the watchdog of the machine is not theirs.
#include "osal/include/osal/watchdog.h"

status_t osal_watchdog_start(const uint32_t period_ms)
{
    (void)period_ms;
    return STATUS_UNSUPPORTED;
}

void osal_watchdog_feed(void)
{
}

void osal_watchdog_stop(void)
{
}

bool osal_watchdog_has_reset(void)
{
    return false;
}
