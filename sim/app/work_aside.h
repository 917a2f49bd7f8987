// SPDX-License-Identifier: Apache-2.0
/// Work aside: the caller offers a piece of work and continues, and a task performs it on another processor.
/// When the caller needs the result, it performs the work itself if the task has not begun it. So it waits
/// only for work that is being performed, and never for a processor.
///
/// Ownership  The caller has the storage and the context of `work`; both exist until work_aside_close.
/// Context    One task calls; work_aside_withdraw may also be called from the signal handler of a program
///            that crashes. `work` runs in the task of the caller or in that of the structure, never in both
///            at once; after work_aside_finish the caller sees all that it has written.
/// Time       An offer costs one system call. When the task has been late, because it got no processor, the
///            next offers are not passed to it, so that a loaded machine loses little time by them.
#ifndef SIM_APP_WORK_ASIDE_H
#define SIM_APP_WORK_ASIDE_H

#include "osal/include/osal/event.h"
#include "osal/include/osal/task.h"

#include <stdbool.h>
#include <stdint.h>

#define WORK_ASIDE_PATIENCE_MS 10000U

typedef struct { // Private.
    void (*begin)(void);
    void (*work)(void* context);
    void* context;
    osal_task_t task;
    osal_event_t offered;  ///< For the task: there is work, or it must end.
    osal_event_t finished; ///< For the caller that waits.
    uint32_t stage;        ///< Of the work that was offered last.
    bool has_task;
    bool is_ending;   ///< The task must end.
    bool is_offered;  ///< The caller has not finished the work yet.
    bool is_passed;   ///< The task has been woken for it.
    unsigned to_keep; ///< Number of next offers that are not passed to the task.
    unsigned pause;   ///< Number of offers to keep when the task is late the next time.
} work_aside_t;

/// Without a task, work_aside_offer performs the work.
void work_aside_open(work_aside_t* aside, void (*work)(void* context), void* context);
/// Start the task, which calls `begin` once. It may run on another processor if the program is pinned to one
/// (osal_task_unpin). If it cannot be started, there is none.
void work_aside_start_task(work_aside_t* aside, void (*begin)(void));
/// Offer a piece of work. The one before must be finished.
void work_aside_offer(work_aside_t* aside);
/// True from an offer to a task until work_aside_finish.
bool work_aside_is_pending(const work_aside_t* aside);
/// Return when the offered work, if there is any, is done.
void work_aside_finish(work_aside_t* aside);
/// Drop the offered work, or wait until it is done if the task has begun it, WORK_ASIDE_PATIENCE_MS at most.
void work_aside_withdraw(work_aside_t* aside);
/// Finish the work and end the task.
void work_aside_close(work_aside_t* aside);

#endif // SIM_APP_WORK_ASIDE_H
