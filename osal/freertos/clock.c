// SPDX-License-Identifier: Apache-2.0
// Two timers of the board with a resolution of one clock cycle: timer 0 runs freely and gives the monotonic
// time, timer 1 wakes the tasks that wait for a time. The tick of the kernel is too coarse for loops of 0.5
// ms.
#include "osal/include/osal/clock.h"

#include "base/assertion.h"
#include "osal/freertos/board.h"
#include "osal/freertos/port.h"

#include <FreeRTOS.h>
#include <task.h>

typedef struct { // CMSDK timer: counts down, interrupts at 0, begins again at `reload`.
    volatile uint32_t control;
    volatile uint32_t value;
    volatile uint32_t reload;
    volatile uint32_t interrupt;
} timer_t;

typedef struct sleeper {
    uint64_t until_ns;
    TaskHandle_t task;
    struct sleeper* next;
} sleeper_t;

#define FREE_TIMER ((timer_t*)BOARD_FREE_TIMER)
#define ALARM_TIMER ((timer_t*)BOARD_ALARM_TIMER)
#define TIMER_RUNS 1U
#define TIMER_INTERRUPTS 8U
#define INTERRUPT_ENABLE ((volatile uint32_t*)0xE000E100U)
#define INTERRUPT_PRIORITY ((volatile uint8_t*)0xE000E400U)
#define HALF 0x80000000U
#define CYCLES_MAX HALF // Longest time between two alarms.

static uint32_t wraps;      // Number of wraps of the free-running timer.
static sleeper_t* sleepers; // List of the waiting tasks. Each entry is a variable of its task.

void port_free_interrupt(void);
void port_alarm_interrupt(void);

static void enable_interrupt(const uint32_t number)
{
    INTERRUPT_PRIORITY[number] = BOARD_TIMER_PRIORITY;
    INTERRUPT_ENABLE[0]        = 1U << number;
}

void port_clock_start(void)
{
    FREE_TIMER->reload  = UINT32_MAX;
    FREE_TIMER->value   = UINT32_MAX;
    FREE_TIMER->control = TIMER_RUNS | TIMER_INTERRUPTS;
    enable_interrupt(BOARD_FREE_TIMER_IRQ);
    ALARM_TIMER->reload = 0U;
    enable_interrupt(BOARD_ALARM_TIMER_IRQ);
}

void port_free_interrupt(void)
{
    const uint32_t mask   = (uint32_t)portSET_INTERRUPT_MASK_FROM_ISR();
    FREE_TIMER->interrupt = 1U;
    wraps++;
    portCLEAR_INTERRUPT_MASK_FROM_ISR(mask);
}

uint64_t osal_clock_monotonic_ns(void)
{
    const uint32_t mask   = (uint32_t)portSET_INTERRUPT_MASK_FROM_ISR();
    const uint32_t passed = UINT32_MAX - FREE_TIMER->value;
    // If the timer has wrapped, but its interrupt has not run, `wraps` does not count this yet.
    const bool has_wrapped = ((FREE_TIMER->interrupt & 1U) != 0U) && (passed < HALF);
    const uint64_t counted = (uint64_t)wraps + (has_wrapped ? 1U : 0U);
    portCLEAR_INTERRUPT_MASK_FROM_ISR(mask);
    return ((counted << 32U) + passed) * BOARD_CLOCK_NS;
}

/// Set the alarm timer for the sleeper with the earliest time. The caller has masked the interrupts of the
/// timers.
static void set_alarm(const uint64_t now_ns)
{
    uint64_t first_ns = OSAL_CLOCK_NEVER;
    for (const sleeper_t* one = sleepers; one != NULL; one = one->next) {
        first_ns = (one->until_ns < first_ns) ? one->until_ns : first_ns;
    }
    ALARM_TIMER->control = 0U;
    if (first_ns == OSAL_CLOCK_NEVER) {
        return;
    }
    const uint64_t rest  = (first_ns > now_ns) ? (((first_ns - now_ns) / BOARD_CLOCK_NS) + 1U) : 1U;
    ALARM_TIMER->value   = (rest < CYCLES_MAX) ? (uint32_t)rest : CYCLES_MAX;
    ALARM_TIMER->control = TIMER_RUNS | TIMER_INTERRUPTS;
}

void port_alarm_interrupt(void)
{
    BaseType_t is_switch_due = pdFALSE;
    const uint32_t mask      = (uint32_t)portSET_INTERRUPT_MASK_FROM_ISR();
    const uint64_t now_ns    = osal_clock_monotonic_ns();
    ALARM_TIMER->interrupt   = 1U;
    sleeper_t** link         = &sleepers;
    while (*link != NULL) {
        sleeper_t* const one = *link;
        if (one->until_ns <= now_ns) {
            *link = one->next;
            vTaskNotifyGiveIndexedFromISR(one->task, PORT_NOTIFY_ALARM, &is_switch_due);
        } else {
            link = &one->next;
        }
    }
    set_alarm(now_ns);
    portCLEAR_INTERRUPT_MASK_FROM_ISR(mask);
    portYIELD_FROM_ISR(is_switch_due);
}

static void sleep_until(const uint64_t until_ns)
{
    sleeper_t self = {.until_ns = until_ns, .task = xTaskGetCurrentTaskHandle()};
    if (osal_clock_monotonic_ns() >= until_ns) {
        return;
    }
    taskENTER_CRITICAL();
    self.next = sleepers;
    sleepers  = &self;
    set_alarm(osal_clock_monotonic_ns());
    taskEXIT_CRITICAL();
    // `self` must leave the list before this function returns: the interrupt removes it and then notifies.
    (void)ulTaskNotifyTakeIndexed(PORT_NOTIFY_ALARM, pdTRUE, portMAX_DELAY);
}

void osal_clock_open_real(osal_clock_t* const clock, const uint64_t origin_ns)
{
    FSW_ASSERT(clock != NULL);
    // This system swaps no memory, and the alarm timer wakes each task at its own time.
    *clock = (osal_clock_t){.mode = OSAL_CLOCK_REAL, .origin_ns = origin_ns, .is_memory_locked = true};
}

status_t osal_clock_wait(osal_clock_t* const clock, const uint64_t wake_ns,
                         osal_socket_t* const* const sockets, const size_t socket_count)
{
    FSW_ASSERT((clock != NULL) && (socket_count <= OSAL_CLOCK_SOCKETS_MAX) &&
               ((sockets != NULL) || (socket_count == 0U)));
    if (clock->mode == OSAL_CLOCK_STEPPED) {
        FSW_ASSERT(clock->scheduler != NULL);
        return osal_lockstep_wait(clock->scheduler, clock->participant, clock->life, wake_ns, &clock->grant);
    }
    if (socket_count > 0U) {
        return STATUS_UNSUPPORTED; // Datagrams arrive only while a call of a socket reads the wire (wire.c).
    }
    const bool is_limited = (wake_ns < (OSAL_CLOCK_NEVER - clock->origin_ns));
    sleep_until(is_limited ? (clock->origin_ns + wake_ns) : OSAL_CLOCK_NEVER);
    return STATUS_OK;
}
