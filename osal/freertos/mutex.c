// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/mutex.h"

#include "base/assertion.h"

#include <FreeRTOS.h>
#include <semphr.h>
#include <stddef.h>
#include <task.h>

#define NS_PER_TICK (1000000000ULL / configTICK_RATE_HZ)
#define MARK_WORD (OSAL_MUTEX_WORDS - 1U)
#define MARK 0x6D757465782E2E2EULL // "mutex..."

typedef char
    mutex_fits_before_the_mark[(sizeof(StaticSemaphore_t) <= (MARK_WORD * sizeof(uint64_t))) ? 1 : -1];

/// The handle of a static semaphore is the address of its storage.
static SemaphoreHandle_t native(const osal_mutex_t* const mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    return (SemaphoreHandle_t)(uintptr_t)mutex->storage;
}

status_t osal_mutex_create(osal_mutex_t* const mutex, const bool is_shared)
{
    FSW_ASSERT(mutex != NULL);
    (void)is_shared; // All tasks share one address space.
    const SemaphoreHandle_t made = xSemaphoreCreateMutexStatic((StaticSemaphore_t*)(void*)mutex->storage);
    FSW_ASSERT((void*)made == (void*)mutex->storage);
    mutex->storage[MARK_WORD] = MARK;
    return STATUS_OK;
}

status_t osal_mutex_lock(osal_mutex_t* const mutex)
{
    FSW_ASSERT(xSemaphoreGetMutexHolder(native(mutex)) != xTaskGetCurrentTaskHandle());
    const BaseType_t is_taken = xSemaphoreTake(native(mutex), portMAX_DELAY);
    FSW_ASSERT(is_taken == pdTRUE);
    return STATUS_OK;
}

status_t osal_mutex_lock_within(osal_mutex_t* const mutex, const uint64_t wait_ns)
{
    FSW_ASSERT(xSemaphoreGetMutexHolder(native(mutex)) != xTaskGetCurrentTaskHandle());
    // The kernel counts the present, partly passed tick as a whole one: add one tick, and one to round up.
    const uint64_t ticks = (wait_ns / NS_PER_TICK) + 2U;
    const TickType_t limit =
        (wait_ns == 0U) ? 0U : ((ticks < portMAX_DELAY) ? (TickType_t)ticks : (portMAX_DELAY - 1U));
    return (xSemaphoreTake(native(mutex), limit) == pdTRUE) ? STATUS_OK : STATUS_TIMEOUT;
}

int32_t osal_mutex_holder(const osal_mutex_t* const mutex)
{
    const TaskHandle_t holder = xSemaphoreGetMutexHolder(native(mutex));
    TaskStatus_t status;
    if (holder == NULL) {
        return 0;
    }
    // The state of the task is not used; with eInvalid the kernel would search for it.
    vTaskGetInfo(holder, &status, pdFALSE, eReady);
    return (int32_t)status.xTaskNumber;
}

void osal_mutex_unlock(osal_mutex_t* const mutex)
{
    FSW_ASSERT(xSemaphoreGetMutexHolder(native(mutex)) == xTaskGetCurrentTaskHandle());
    const BaseType_t is_given = xSemaphoreGive(native(mutex));
    FSW_ASSERT(is_given == pdTRUE);
}
