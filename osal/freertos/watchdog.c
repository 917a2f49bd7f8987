// SPDX-License-Identifier: Apache-2.0
// The watchdog of the board counts down twice. At the end of the period it interrupts; at the end of a
// second, short count it resets the board.
#include "osal/include/osal/watchdog.h"

#include "osal/freertos/board.h"
#include "osal/freertos/port.h"
#include "osal/freertos/semihosting.h"

typedef struct { // CMSDK watchdog.
    volatile uint32_t load;
    volatile uint32_t value;
    volatile uint32_t control;
    volatile uint32_t clear; ///< Writing clears the interrupt, and counts from `load` again.
    volatile uint32_t raw_status;
    volatile uint32_t status;
    uint32_t reserved[762];
    volatile uint32_t lock; ///< At offset 0xC00.
} watchdog_t;

typedef char watchdog_has_its_registers[(offsetof(watchdog_t, lock) == 0xC00U) ? 1 : -1];

#define WATCHDOG ((watchdog_t*)BOARD_WATCHDOG)
#define INTERRUPTS_AND_RESETS 3U
#define UNLOCKED 0x1ACCE551U
#define CYCLES_PER_MS (BOARD_CLOCK_HZ / 1000U)
#define PERIOD_MAX_MS (UINT32_MAX / CYCLES_PER_MS)
#define NOTE 0x57444F47U // "WDOG"

/// Memory that a reset does not change. If the watchdog causes the reset, it contains NOTE and the
/// complement.
extern volatile uint32_t port_reset_note[2];

static bool has_reset;
static bool is_running;

void port_watchdog_take_note(void)
{
    has_reset          = (port_reset_note[0] == NOTE) && (port_reset_note[1] == ~NOTE);
    port_reset_note[0] = 0U;
}

/// Called by the non-maskable interrupt, so that it also runs when a section with disabled interrupts hangs.
void port_watchdog_interrupt(void)
{
    port_reset_note[0] = NOTE;
    port_reset_note[1] = ~NOTE;
    semihosting_print("the watchdog was not fed within its period: the board is reset\n");
    WATCHDOG->load = CYCLES_PER_MS; // Length of the second count: 1 ms.
    for (;;) {
    }
}

status_t osal_watchdog_start(const uint32_t period_ms)
{
    if ((period_ms == 0U) || (period_ms > PERIOD_MAX_MS)) {
        return STATUS_INVALID;
    }
    WATCHDOG->lock    = UNLOCKED;
    WATCHDOG->load    = period_ms * CYCLES_PER_MS;
    WATCHDOG->clear   = 1U;
    WATCHDOG->control = INTERRUPTS_AND_RESETS;
    is_running        = true;
    return STATUS_OK;
}

void osal_watchdog_feed(void)
{
    if (is_running) {
        WATCHDOG->clear = 1U;
    }
}

void osal_watchdog_stop(void)
{
    if (is_running) {
        WATCHDOG->control = 0U;
        WATCHDOG->clear   = 1U;
    }
    is_running = false;
}

bool osal_watchdog_has_reset(void)
{
    return has_reset;
}
