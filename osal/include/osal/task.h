// SPDX-License-Identifier: Apache-2.0
/// Tasks (threads). Priority 1..99 as SCHED_FIFO where permitted; 0 is the system's ordinary scheduling.
///
/// Memory   The port has the storage of stacks: each has OSAL_TASK_STACK_OCTETS or more. A port that has only
///          static memory has a fixed number of them.
#ifndef OSAL_TASK_H
#define OSAL_TASK_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

#define OSAL_TASK_STACK_OCTETS 8192U

typedef struct { // Private.
    uint64_t handle;
    void (*entry)(void* context);
    void* context;
    bool is_running;
} osal_task_t;

/// Start a task. The structure must exist until the task has returned. STATUS_OK, STATUS_EXHAUSTED,
/// STATUS_IO.
MUST_USE status_t osal_task_start(osal_task_t* task, void (*entry)(void* context), void* context,
                                  int priority);
/// Wait until the task has returned.
void osal_task_join(osal_task_t* task);
/// Set the priority of the calling task. STATUS_OK, STATUS_DENIED (the priority is unchanged).
status_t osal_task_set_priority(int priority);
/// Let the calling task run on all processors that the parent of the program may use, even if the program was
/// started pinned to one of them (osal_process_start_t).
void osal_task_unpin(void);

#endif // OSAL_TASK_H
