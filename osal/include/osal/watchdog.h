// SPDX-License-Identifier: Apache-2.0
/// The watchdog of the computer: if no program feeds it for one period, it resets the computer. A system with
/// processes has none: there the launcher and the supervisor watch each process.
///
/// Context    The task whose loop is watched; one task in a program. It feeds only while the tasks of
///            lower priority make progress, because the watchdog itself detects only what keeps this task
///            from running.
#ifndef OSAL_WATCHDOG_H
#define OSAL_WATCHDOG_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/// Start the watchdog, or change its period. STATUS_OK, STATUS_INVALID (period_ms is 0, or longer than the
/// watchdog can count), STATUS_UNSUPPORTED.
MUST_USE status_t osal_watchdog_start(uint32_t period_ms);
/// Begin the period again. No effect if the watchdog does not run.
void osal_watchdog_feed(void);
void osal_watchdog_stop(void);
/// True if this start of the program follows a reset by the watchdog.
bool osal_watchdog_has_reset(void);

#endif // OSAL_WATCHDOG_H
