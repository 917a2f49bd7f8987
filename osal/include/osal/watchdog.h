// SPDX-License-Identifier: Apache-2.0
/// The watchdog of the computer: if it is not fed for its period, it resets the computer. A system with
/// processes has none: there the launcher and the supervisor watch each process.
///
/// Context    The task whose loop is to be watched; one in a program.
#ifndef OSAL_WATCHDOG_H
#define OSAL_WATCHDOG_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/// Start it, or give it another period. STATUS_OK, STATUS_INVALID (0, or longer than it can count),
/// STATUS_UNSUPPORTED.
MUST_USE status_t osal_watchdog_start(uint32_t period_ms);
/// The period begins again. No effect if it does not run.
void osal_watchdog_feed(void);
void osal_watchdog_stop(void);
/// True if this start of the program follows a reset by the watchdog.
bool osal_watchdog_has_reset(void);

#endif // OSAL_WATCHDOG_H
