// SPDX-License-Identifier: Apache-2.0
/// Tasks for the loops of services of a component in real time, each with its own rate and priority.
///
/// The tasks run from loop_tasks_start to loop_tasks_stop, for any applied configuration; a task without a
/// loop only checks periodically whether it has one. Each task sets the priority that the configuration
/// defines for its loop. If the system does not permit this, it keeps the normal priority and reports that
/// on the console.
///
/// Ownership  The caller provides loop_tasks_t; the component, initialised with `has_loop_tasks`, outlives
///            the tasks.
/// Context    Start and stop in one task.
#ifndef FSW_PROGRAMS_LOOP_TASKS_H
#define FSW_PROGRAMS_LOOP_TASKS_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/task.h"

/// A task that has begun no turn for this time counts as hanging; a task that runs begins one every 20 ms or
/// earlier.
#define LOOP_TASKS_TIMEOUT_MS 500U

typedef struct loop_tasks loop_tasks_t;

typedef struct { // Private.
    loop_tasks_t* all;
    uint8_t loop;
    osal_clock_t clock;
    osal_task_t task;
    uint32_t turn_ms; // Time of the run at which the last turn began; it wraps.
} loop_task_t;

struct loop_tasks {         // Private.
    subsystem_t* component; // Null: never started.
    bool is_over;
    loop_task_t tasks[SUBSYSTEM_LOOPS];
};

/// Start a task for each loop that a configuration may have; time 0 of the run is `origin_ns` of
/// osal_clock_monotonic_ns. STATUS_OK; STATUS_EXHAUSTED, STATUS_IO (then no task runs).
MUST_USE status_t loop_tasks_start(loop_tasks_t* tasks, subsystem_t* component, uint64_t origin_ns);
/// True if each task has begun a turn within the LOOP_TASKS_TIMEOUT_MS before `now_ns`, a time of the run,
/// or if the tasks were never started. False: a task hangs, or others leave it no processor time.
bool loop_tasks_are_alive(const loop_tasks_t* tasks, uint64_t now_ns);
/// End the tasks, and wait until they have ended. A structure whose tasks were never started (all zero) is
/// permitted.
void loop_tasks_stop(loop_tasks_t* tasks);

#endif // FSW_PROGRAMS_LOOP_TASKS_H
