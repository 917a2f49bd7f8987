// SPDX-License-Identifier: Apache-2.0
// Lock, wait and wake of the scheduler for the tasks of one program. No other processor shares its memory: a
// program of this port takes part in a flight through a granted clock (osal/clock.h).
#include "osal/common/lockstep_core.h"

#include "osal/freertos/port.h"

#include <FreeRTOS.h>
#include <stddef.h>
#include <task.h>

typedef struct {
    TaskHandle_t task; ///< Null: the slot is free.
    const uint32_t* word;
} waiter_t;

static waiter_t waiters[PORT_STARTED_MAX + 1U]; // One for each task, and one for main().

bool lockstep_port_prepare(osal_lockstep_t* const scheduler)
{
    return osal_mutex_create(&scheduler->mutex, true) == STATUS_OK;
}

void lockstep_port_lock(osal_lockstep_t* const scheduler)
{
    (void)osal_mutex_lock(&scheduler->mutex);
}

void lockstep_port_unlock(osal_lockstep_t* const scheduler)
{
    osal_mutex_unlock(&scheduler->mutex);
}

/// In one critical section, check `word` and note that the task waits. Null: `word` has changed.
static waiter_t* begin_wait(const uint32_t* const word, const uint32_t seen)
{
    waiter_t* own = NULL;
    taskENTER_CRITICAL();
    for (size_t i = 0U; (i < (sizeof waiters / sizeof waiters[0])) && (own == NULL) && (*word == seen); i++) {
        own = (waiters[i].task == NULL) ? &waiters[i] : NULL;
    }
    if (own != NULL) {
        *own = (waiter_t){xTaskGetCurrentTaskHandle(), word};
    }
    taskEXIT_CRITICAL();
    return own;
}

void lockstep_port_wait(uint32_t* const word, const uint32_t seen)
{
    waiter_t* const own = begin_wait(word, seen);
    if (own != NULL) {
        (void)ulTaskNotifyTakeIndexed(PORT_NOTIFY_GRANT, pdTRUE, portMAX_DELAY);
        taskENTER_CRITICAL();
        own->task = NULL;
        taskEXIT_CRITICAL();
    }
}

void lockstep_port_wake(uint32_t* const word)
{
    taskENTER_CRITICAL();
    for (size_t i = 0U; i < (sizeof waiters / sizeof waiters[0]); i++) {
        if ((waiters[i].task != NULL) && (waiters[i].word == word)) {
            (void)xTaskNotifyGiveIndexed(waiters[i].task, PORT_NOTIFY_GRANT);
        }
    }
    taskEXIT_CRITICAL();
}

/// This system has no signals that could stop a task inside a call of the scheduler, so no task is killed.
int32_t lockstep_port_process(void)
{
    return 0;
}

void lockstep_port_end(void)
{
    vTaskSuspend(NULL);
}
