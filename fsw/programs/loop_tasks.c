// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/loop_tasks.h"

#include "base/assertion.h"
#include "osal/include/osal/console.h"

/// Longest time after which a task checks again whether it has a loop, or must end.
#define LOOK_NS 20000000ULL
#define NS_PER_MS 1000000ULL

static void follow_priority(loop_task_t* const self, uint8_t* const priority)
{
    const uint8_t wanted = subsystem_loop_priority(self->all->component, self->loop);
    if (wanted == *priority) {
        return;
    }
    *priority = wanted;
    if ((osal_task_set_priority((int)wanted) != STATUS_OK) && (wanted > 0U)) {
        osal_console_print_error(
            "loop of services: note: real-time priorities are not permitted here; run as root, or raise "
            "`ulimit -r`");
    }
}

static void note_turn(loop_task_t* const self, const uint64_t now_ns)
{
    __atomic_store_n(&self->turn_ms, (uint32_t)(now_ns / NS_PER_MS), __ATOMIC_RELAXED);
}

static void run(void* const context)
{
    loop_task_t* const self = (loop_task_t*)context;
    uint8_t priority        = 0U;
    status_t status         = STATUS_OK;
    while ((status == STATUS_OK) && !__atomic_load_n(&self->all->is_over, __ATOMIC_ACQUIRE)) {
        follow_priority(self, &priority);
        const uint64_t now_ns = osal_clock_now_ns(&self->clock);
        note_turn(self, now_ns);
        const uint64_t wake_ns = subsystem_loop_step(self->all->component, self->loop, now_ns);
        const uint64_t look_ns = now_ns + LOOK_NS;
        status = osal_clock_wait(&self->clock, (wake_ns < look_ns) ? wake_ns : look_ns, NULL, 0U);
    }
}

status_t loop_tasks_start(loop_tasks_t* const tasks, subsystem_t* const component, const uint64_t origin_ns)
{
    FSW_ASSERT((tasks != NULL) && (component != NULL));
    *tasks          = (loop_tasks_t){.component = component};
    status_t status = STATUS_OK;
    for (uint8_t i = 0U; (i < SUBSYSTEM_LOOPS) && (status == STATUS_OK); i++) {
        loop_task_t* const task = &tasks->tasks[i];
        task->all               = tasks;
        task->loop              = i;
        osal_clock_open_real(&task->clock, origin_ns);
        note_turn(task, osal_clock_now_ns(&task->clock));
        status = osal_task_start(&task->task, run, task, 0);
    }
    if (status != STATUS_OK) {
        loop_tasks_stop(tasks);
    }
    return status;
}

bool loop_tasks_are_alive(const loop_tasks_t* const tasks, const uint64_t now_ns)
{
    FSW_ASSERT(tasks != NULL);
    bool are_alive = true;
    for (uint8_t i = 0U; (i < SUBSYSTEM_LOOPS) && (tasks->component != NULL); i++) {
        const uint32_t turn_ms = __atomic_load_n(&tasks->tasks[i].turn_ms, __ATOMIC_RELAXED);
        const uint32_t age_ms  = (uint32_t)(now_ns / NS_PER_MS) - turn_ms;
        // The turn may have begun after now_ns.
        are_alive = are_alive && ((age_ms <= LOOP_TASKS_TIMEOUT_MS) || (age_ms > (UINT32_MAX / 2U)));
    }
    return are_alive;
}

void loop_tasks_stop(loop_tasks_t* const tasks)
{
    FSW_ASSERT(tasks != NULL);
    __atomic_store_n(&tasks->is_over, true, __ATOMIC_RELEASE);
    for (uint8_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        osal_task_join(&tasks->tasks[i].task);
    }
}
