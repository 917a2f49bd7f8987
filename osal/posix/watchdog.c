// SPDX-License-Identifier: Apache-2.0
// Launcher and supervisor watch the processes; the watchdog of the machine is not used.
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
