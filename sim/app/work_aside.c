// SPDX-License-Identifier: Apache-2.0
#include "sim/app/work_aside.h"

#define WITHOUT_LIMIT UINT32_MAX
#define PAUSE_MIN 64U
#define PAUSE_MAX 16384U
#define RECOVERY                                                                                             \
    64U // A task that is late less often than once in about so many offers gets nearly all of them.

typedef enum {
    STAGE_NONE,
    STAGE_OFFERED,
    STAGE_BEGUN,  // The task performs the work.
    STAGE_AWAITED // The task performs the work, and the caller waits for it.
} stage_t;

/// Change the stage if it is `from`. Returns false if the other task has changed it.
static bool change(work_aside_t* const aside, const stage_t from, const stage_t to)
{
    uint32_t expected = from;
    return __atomic_compare_exchange_n(&aside->stage, &expected, (uint32_t)to, false, __ATOMIC_ACQ_REL,
                                       __ATOMIC_ACQUIRE);
}

static void serve(void* const context)
{
    work_aside_t* aside = context;
    osal_task_unpin();
    aside->begin();
    for (;;) {
        while (osal_event_wait(&aside->offered, WITHOUT_LIMIT) != STATUS_OK) {
        }
        if (change(aside, STAGE_OFFERED, STAGE_BEGUN)) {
            aside->work(aside->context);
            if (!change(aside, STAGE_BEGUN, STAGE_NONE)) {
                (void)change(aside, STAGE_AWAITED, STAGE_NONE);
                osal_event_signal(&aside->finished);
            }
        } else if (__atomic_load_n(&aside->is_ending, __ATOMIC_ACQUIRE)) {
            return;
        } else {
            // The caller has performed the work.
        }
    }
}

void work_aside_open(work_aside_t* const aside, void (*const work)(void* context), void* const context)
{
    *aside = (work_aside_t){.work = work, .context = context, .stage = STAGE_NONE, .pause = PAUSE_MIN};
    osal_event_create(&aside->offered);
    osal_event_create(&aside->finished);
}

void work_aside_start_task(work_aside_t* const aside, void (*const begin)(void))
{
    aside->begin    = begin;
    aside->has_task = osal_task_start(&aside->task, serve, aside, 0) == STATUS_OK;
}

void work_aside_offer(work_aside_t* const aside)
{
    if (!aside->has_task) {
        aside->work(aside->context);
        return;
    }
    aside->is_offered = true;
    __atomic_store_n(&aside->stage, (uint32_t)STAGE_OFFERED, __ATOMIC_RELEASE);
    aside->is_passed = (aside->to_keep == 0U);
    if (aside->is_passed) {
        osal_event_signal(&aside->offered);
    } else {
        aside->to_keep--;
    }
}

bool work_aside_is_pending(const work_aside_t* const aside)
{
    return aside->is_offered;
}

/// Wait until the task has performed the work that it has begun. Returns false if it had done so before.
static bool wait_for_task(work_aside_t* const aside, const uint32_t patience_ms)
{
    if (!change(aside, STAGE_BEGUN, STAGE_AWAITED)) {
        return false;
    }
    const status_t status = osal_event_wait(&aside->finished, patience_ms);
    (void)status; // A wait without limit ends with the event.
    return true;
}

/// Decide how many of the next offers are passed to the task.
static void note_service(work_aside_t* const aside, const bool is_late)
{
    if (is_late) {
        aside->to_keep = aside->pause;
        aside->pause   = (aside->pause < PAUSE_MAX) ? (2U * aside->pause) : PAUSE_MAX;
    } else {
        const unsigned shorter = aside->pause - (aside->pause / RECOVERY);
        aside->pause           = (shorter > PAUSE_MIN) ? shorter : PAUSE_MIN;
    }
}

void work_aside_finish(work_aside_t* const aside)
{
    if (!aside->is_offered) {
        return;
    }
    const bool is_left = change(aside, STAGE_OFFERED, STAGE_NONE);
    if (is_left) {
        aside->work(aside->context);
    }
    const bool is_late = is_left || wait_for_task(aside, WITHOUT_LIMIT);
    if (aside->is_passed) {
        note_service(aside, is_late);
    }
    aside->is_offered = false;
}

void work_aside_withdraw(work_aside_t* const aside)
{
    if (!change(aside, STAGE_OFFERED, STAGE_NONE)) {
        (void)wait_for_task(aside, WORK_ASIDE_PATIENCE_MS);
    }
}

void work_aside_close(work_aside_t* const aside)
{
    work_aside_finish(aside);
    if (aside->has_task) {
        __atomic_store_n(&aside->is_ending, true, __ATOMIC_RELEASE);
        osal_event_signal(&aside->offered);
        osal_task_join(&aside->task);
        aside->has_task = false;
    }
}
