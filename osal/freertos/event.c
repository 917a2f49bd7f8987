// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/event.h"

#include "base/assertion.h"
#include "osal/freertos/port.h"
#include "osal/include/osal/clock.h"

#include <FreeRTOS.h>
#include <task.h>

#define NS_PER_MS 1000000ULL
#define NS_PER_TICK (1000000000ULL / configTICK_RATE_HZ)

void osal_event_create(osal_event_t* const event)
{
    FSW_ASSERT(event != NULL);
    *event = (osal_event_t){.word = 0U};
}

void osal_event_signal(osal_event_t* const event)
{
    FSW_ASSERT(event != NULL);
    taskENTER_CRITICAL();
    event->word               = 1U;
    const TaskHandle_t waiter = (TaskHandle_t)event->waiter;
    if (waiter != NULL) {
        (void)xTaskNotifyGiveIndexed(waiter, PORT_NOTIFY_EVENT);
    }
    taskEXIT_CRITICAL();
}

/// Clear the event. True if it was signalled; otherwise the next signal notifies the calling task.
static bool take(osal_event_t* const event)
{
    taskENTER_CRITICAL();
    const bool is_signalled = (event->word != 0U);
    event->word             = 0U;
    event->waiter           = is_signalled ? 0U : (uintptr_t)xTaskGetCurrentTaskHandle();
    taskEXIT_CRITICAL();
    return is_signalled;
}

status_t osal_event_wait(osal_event_t* const event, const uint32_t timeout_ms)
{
    FSW_ASSERT(event != NULL);
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    while (!take(event)) {
        TickType_t limit      = portMAX_DELAY;
        const uint64_t now_ns = osal_clock_monotonic_ns();
        if (timeout_ms != UINT32_MAX) {
            if (now_ns >= until_ns) {
                taskENTER_CRITICAL();
                event->waiter = 0U;
                taskEXIT_CRITICAL();
                return STATUS_TIMEOUT;
            }
            limit = (TickType_t)(((until_ns - now_ns) / NS_PER_TICK) + 1U);
        }
        // The notification may belong to an earlier signal; only `word` decides, which take() reads.
        (void)ulTaskNotifyTakeIndexed(PORT_NOTIFY_EVENT, pdTRUE, limit);
    }
    return STATUS_OK;
}
