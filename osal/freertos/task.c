// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/task.h"

#include "base/assertion.h"
#include "osal/freertos/port.h"

#include <FreeRTOS.h>
#include <task.h>

#define PRIORITY_MAX 99

typedef struct {
    StaticTask_t block;
    StackType_t stack[OSAL_TASK_STACK_OCTETS / sizeof(StackType_t)] __attribute__((aligned(8)));
    uint64_t tls[PORT_TLS_MAX / sizeof(uint64_t)];
    bool is_taken;
    bool has_ended;
    TaskHandle_t joiner;
} slot_t;

static slot_t slots[PORT_STARTED_MAX];

/// Priorities 1..99 share 2..31 of the kernel; priority 0 is that of main(), 1 in the kernel.
static UBaseType_t native_priority(const int priority)
{
    const unsigned highest = configMAX_PRIORITIES - 1U;
    return (priority == 0) ? 1U : (UBaseType_t)(2U + (((unsigned)priority * (highest - 2U)) / PRIORITY_MAX));
}

static void run(void* const context)
{
    osal_task_t* const task = context;
    slot_t* const slot      = &slots[task->handle - 1U];
    task->entry(task->context);
    // In one critical section, as in osal_task_join: either the joiner sees that the task has ended, or this
    // task sees the joiner and notifies it.
    taskENTER_CRITICAL();
    slot->has_ended           = true;
    const TaskHandle_t joiner = slot->joiner;
    taskEXIT_CRITICAL();
    if (joiner != NULL) {
        (void)xTaskNotifyGiveIndexed(joiner, PORT_NOTIFY_END);
    }
    vTaskSuspend(NULL); // The task must not return; osal_task_join deletes it.
}

static slot_t* take_slot(void)
{
    slot_t* found = NULL;
    taskENTER_CRITICAL();
    for (unsigned i = 0U; (i < PORT_STARTED_MAX) && (found == NULL); i++) {
        if (!slots[i].is_taken) {
            found            = &slots[i];
            found->is_taken  = true;
            found->has_ended = false;
            found->joiner    = NULL;
        }
    }
    taskEXIT_CRITICAL();
    return found;
}

status_t osal_task_start(osal_task_t* const task, void (*entry)(void* context), void* const context,
                         const int priority)
{
    FSW_ASSERT((task != NULL) && (entry != NULL) && (priority >= 0) && (priority <= PRIORITY_MAX));
    *task              = (osal_task_t){.entry = entry, .context = context};
    slot_t* const slot = take_slot();
    if (slot == NULL) {
        return STATUS_EXHAUSTED;
    }
    task->handle     = (uint64_t)(slot - slots) + 1U;
    task->is_running = true;
    vTaskSuspendAll(); // The task must not run before it has its thread-local variables.
    const TaskHandle_t made = xTaskCreateStatic(run, "task", sizeof slot->stack / sizeof slot->stack[0], task,
                                                native_priority(priority), slot->stack, &slot->block);
    port_tls_give(made, slot->tls);
    (void)xTaskResumeAll();
    return STATUS_OK;
}

void osal_task_join(osal_task_t* const task)
{
    FSW_ASSERT(task != NULL);
    if (!task->is_running) {
        return;
    }
    slot_t* const slot = &slots[task->handle - 1U];
    taskENTER_CRITICAL();
    slot->joiner   = xTaskGetCurrentTaskHandle();
    bool has_ended = slot->has_ended;
    taskEXIT_CRITICAL();
    while (!has_ended) {
        (void)ulTaskNotifyTakeIndexed(PORT_NOTIFY_END, pdTRUE, portMAX_DELAY);
        taskENTER_CRITICAL();
        has_ended = slot->has_ended;
        taskEXIT_CRITICAL();
    }
    // The kernel frees the block and the stack of another task at once; those of a task that deletes itself
    // would be in use until the idle task runs.
    vTaskDelete((TaskHandle_t)&slot->block);
    taskENTER_CRITICAL();
    slot->is_taken = false;
    taskEXIT_CRITICAL();
    task->is_running = false;
}

status_t osal_task_set_priority(const int priority)
{
    FSW_ASSERT((priority >= 0) && (priority <= PRIORITY_MAX));
    vTaskPrioritySet(NULL, native_priority(priority));
    return STATUS_OK;
}

void osal_task_unpin(void)
{
    // There is one processor.
}
