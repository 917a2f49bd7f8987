// SPDX-License-Identifier: Apache-2.0
/// A task for each loop of services of a component, where time is real: its own rate and its own priority.
///
/// The tasks run from loop_tasks_start to loop_tasks_stop, whatever configuration is applied; a task without
/// a loop only checks periodically whether it has one. Each takes the priority that its configuration gives,
/// if permitted; otherwise it keeps the ordinary one and reports that on the console.
///
/// Ownership  The caller places loop_tasks_t; the component, initialised with `has_loop_tasks`, outlives the
///            tasks.
/// Context    Start and stop in one task.
#ifndef FSW_PROGRAMS_LOOP_TASKS_H
#define FSW_PROGRAMS_LOOP_TASKS_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/task.h"

typedef struct loop_tasks loop_tasks_t;

typedef struct { // Private.
    loop_tasks_t* all;
    uint8_t loop;
    osal_clock_t clock;
    osal_task_t task;
} loop_task_t;

struct loop_tasks { // Private.
    subsystem_t* component;
    bool is_over;
    loop_task_t tasks[SUBSYSTEM_LOOPS];
};

/// Start a task for each loop that a configuration may have; time 0 of the run is `origin_ns` of
/// osal_clock_monotonic_ns. STATUS_OK; STATUS_EXHAUSTED, STATUS_IO (no task is left running).
MUST_USE status_t loop_tasks_start(loop_tasks_t* tasks, subsystem_t* component, uint64_t origin_ns);
/// End them and wait until they have. Tasks that were never started, all zero, are no error.
void loop_tasks_stop(loop_tasks_t* tasks);

#endif // FSW_PROGRAMS_LOOP_TASKS_H
