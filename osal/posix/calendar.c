// SPDX-License-Identifier: Apache-2.0
// The calendar's state changes are plain functions over the structure ("core"), shared by both forms. In the
// process form they run under a robust lock and the grant is handed directly from participant to participant:
// the participant that is done chooses its successor and wakes it by futex, without spinning and without a
// central process.
//
// A participant may be killed at any instruction. Every change is therefore ordered so that `running`, one
// word, commits it, and earlier writes can be repeated: the next process that gets the lock of a dead holder
// continues from the present state, and osal_calendar_end, called for every death, chooses or wakes the
// successor again.
#define _GNU_SOURCE
#include "osal/include/osal/calendar.h"

#include "base/assertion.h"
#include "osal/posix/calendar_core.h"
#include "osal/posix/process_state.h"

#include <limits.h>
#include <linux/futex.h>
#include <signal.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

// --- Process form: lock and hand-over ------------------------------------------------------------------

/// A later process takes part with its own life.
static bool has_life(const osal_calendar_t* calendar, int32_t process)
{
    bool is_found = false;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        is_found = is_found || (calendar->participants[i].process == process);
    }
    return is_found && (process != 0);
}

/// The holder of the lock if it is stopped by a signal and may be killed; else 0.
static int32_t stopped_inside(const osal_calendar_t* calendar)
{
    const int32_t process = osal_mutex_holder(&calendar->mutex);
    return (has_life(calendar, process) && (osal_process_state(process) == 'T')) ? process : 0;
}

/// The next process can continue from the state of a holder that died inside: see the top of this file. A
/// holder that is stopped inside is killed. It is checked twice, because a terminal may continue it together
/// with the caller, a moment later.
static void lock(osal_calendar_t* calendar)
{
    int32_t seen = 0;
    if (calendar->is_shared == 0U) {
        return;
    }
    while (osal_mutex_lock_within(&calendar->mutex, calendar->patience_ns / 2U) == STATUS_TIMEOUT) {
        const int32_t stopped = stopped_inside(calendar);
        if ((stopped != 0) && (stopped == seen)) {
            (void)kill((pid_t)stopped, SIGKILL);
        }
        seen = stopped;
    }
}

static void unlock(osal_calendar_t* calendar)
{
    if (calendar->is_shared != 0U) {
        osal_mutex_unlock(&calendar->mutex);
    }
}

static void wake(osal_calendar_t* calendar, uint32_t participant)
{
    uint32_t* const word = &calendar->participants[participant].word;
    (void)__atomic_add_fetch(word, 1U, __ATOMIC_RELEASE);
    if (calendar->is_shared != 0U) {
        (void)syscall(SYS_futex, word, FUTEX_WAKE, INT_MAX, NULL, NULL, 0);
    }
}

/// Under the lock: if the grant is free, give it. Returns the participant to wake after the unlock.
static uint32_t pass_on(osal_calendar_t* calendar)
{
    if ((calendar->is_shared != 0U) && (calendar->running == NOBODY)) {
        calendar_grant_next(calendar);
        return calendar->running;
    }
    return NOBODY;
}

/// After a change: give the grant if it is free, and unlock.
static void unlock_and_pass_on(osal_calendar_t* calendar)
{
    const uint32_t next = pass_on(calendar);
    unlock(calendar);
    if (next != NOBODY) {
        wake(calendar, next);
    }
}

/// Sleep until the grant has come. False if the run is over or the participant was ended.
static bool sleep_until_granted(osal_calendar_t* calendar, uint32_t participant, uint32_t incarnation)
{
    participant_t* const self = &calendar->participants[participant];
    for (;;) {
        const uint32_t seen = __atomic_load_n(&self->word, __ATOMIC_ACQUIRE);
        if ((__atomic_load_n(&calendar->is_closed, __ATOMIC_ACQUIRE) != 0U) ||
            (__atomic_load_n(&self->incarnation, __ATOMIC_ACQUIRE) != incarnation)) {
            return false;
        }
        if (__atomic_load_n(&calendar->running, __ATOMIC_ACQUIRE) == participant) {
            return true;
        }
        (void)syscall(SYS_futex, &self->word, FUTEX_WAIT, seen, NULL, NULL, 0);
    }
}

// --- The contract --------------------------------------------------------------------------------------

osal_calendar_t* osal_calendar_create(void* storage, uint64_t slot_ns, bool is_shared)
{
    FSW_ASSERT((storage != NULL) && (((uintptr_t)storage % 64U) == 0U) && (slot_ns >= 1U));
    osal_calendar_t* const calendar = storage;
    (void)memset(calendar, 0, sizeof(*calendar));
    calendar->slot_ns     = slot_ns;
    calendar->running     = NOBODY;
    calendar->last        = NOBODY;
    calendar->awaited     = NOBODY;
    calendar->is_shared   = is_shared ? 1U : 0U;
    calendar->patience_ns = OSAL_CALENDAR_PATIENCE_NS;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        calendar->participants[i].wake_ns = OSAL_CALENDAR_NEVER;
    }
    if (is_shared && (osal_mutex_create(&calendar->mutex, true) != STATUS_OK)) {
        return NULL;
    }
    __atomic_store_n(&calendar->magic, CALENDAR_MAGIC, __ATOMIC_RELEASE);
    return calendar;
}

void osal_calendar_set_patience(osal_calendar_t* calendar, uint64_t patience_ns)
{
    FSW_ASSERT((calendar != NULL) && (patience_ns >= 2U));
    calendar->patience_ns = patience_ns;
}

osal_calendar_t* osal_calendar_attach(void* storage)
{
    FSW_ASSERT(storage != NULL);
    osal_calendar_t* const calendar = storage;
    return (__atomic_load_n(&calendar->magic, __ATOMIC_ACQUIRE) == CALENDAR_MAGIC) ? calendar : NULL;
}

void osal_calendar_expect(osal_calendar_t* calendar, unsigned participant, uint32_t life, uint64_t at_ns)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (life != OSAL_CALENDAR_ANY_LIFE));
    lock(calendar);
    participant_t* const one = &calendar->participants[participant];
    if (one->state == OSAL_CALENDAR_ABSENT) {
        one->wake_ns  = OSAL_CALENDAR_NEVER;
        one->life     = life;
        one->begin_ns = at_ns;
        one->is_begun = 0U;
        one->state    = OSAL_CALENDAR_EXPECTED;
    }
    unlock(calendar);
}

static bool is_of_life(const participant_t* one, uint32_t life)
{
    return (life == OSAL_CALENDAR_ANY_LIFE) || (one->life == life);
}

/// End a life, wake the process that waits in it, and the new holder of the grant.
static void end_life(osal_calendar_t* calendar, unsigned participant, uint32_t life, bool is_kill)
{
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if (is_of_life(one, life) && (one->state != OSAL_CALENDAR_ABSENT)) {
        one->killed_life = is_kill ? one->life : one->killed_life;
        calendar_leave(calendar, participant);
        (void)pass_on(calendar);
    }
    const uint32_t running = calendar->running;
    unlock(calendar);
    wake(calendar, participant);
    // The process may have died after it passed the grant on and before it woke the new holder.
    if (running != NOBODY) {
        wake(calendar, running);
    }
}

void osal_calendar_end(osal_calendar_t* calendar, unsigned participant, uint32_t life)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    const bool is_to_begin = is_of_life(one, life) && (one->state != OSAL_CALENDAR_ABSENT) &&
                             (one->is_begun == 0U) && (one->begin_ns > calendar->now_ns);
    if (is_to_begin) { // When in wall-clock time it died must not show: it ends when it would have begun.
        one->is_failed = 1U;
        (void)pass_on(calendar);
    }
    const uint32_t running = calendar->running;
    unlock(calendar);
    if (!is_to_begin) {
        end_life(calendar, participant, life, false);
    } else if (running != NOBODY) {
        wake(calendar, running);
    } else {
        // Another one is expected, too.
    }
}

void osal_calendar_dismiss(osal_calendar_t* calendar, unsigned participant, uint32_t life)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    end_life(calendar, participant, life, false);
}

void osal_calendar_kill(osal_calendar_t* calendar, unsigned participant, uint32_t life)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    end_life(calendar, participant, life, true);
}

void osal_calendar_succeed(osal_calendar_t* calendar, unsigned participant, uint64_t delay_ns)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    lock(calendar);
    calendar->participants[participant].succession_ns = delay_ns;
    unlock(calendar);
}

void osal_calendar_suspend(osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if ((one->state == OSAL_CALENDAR_JOINED) && (calendar->now_ns >= one->begin_ns)) {
        one->is_suspended = 1U;
        if (calendar->running == participant) {
            __atomic_store_n(&calendar->running, NOBODY, __ATOMIC_RELEASE);
        }
    }
    unlock_and_pass_on(calendar);
}

void osal_calendar_resume(osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if (one->is_suspended != 0U) {
        one->is_suspended = 0U;
        if (one->wake_ns <= calendar->now_ns) {
            one->wake_ns = calendar_is_turn_to_come(calendar, participant) ? calendar->now_ns
                                                                           : calendar_next_slot_ns(calendar);
        }
    }
    unlock_and_pass_on(calendar);
}

void osal_calendar_close(osal_calendar_t* calendar)
{
    FSW_ASSERT(calendar != NULL);
    __atomic_store_n(&calendar->is_closed, 1U, __ATOMIC_RELEASE);
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        wake(calendar, i);
    }
}

bool osal_calendar_is_closed(const osal_calendar_t* calendar)
{
    FSW_ASSERT(calendar != NULL);
    return __atomic_load_n(&calendar->is_closed, __ATOMIC_ACQUIRE) != 0U;
}

/// A process killed at an instant of simulated time does nothing after it, as if the kernel had killed it at
/// once.
static void obey_kill(const osal_calendar_t* calendar, uint32_t participant, uint32_t life)
{
    if ((life != OSAL_CALENDAR_ANY_LIFE) &&
        (__atomic_load_n(&calendar->participants[participant].killed_life, __ATOMIC_ACQUIRE) == life)) {
        (void)raise(SIGKILL);
    }
}

status_t osal_calendar_wait(osal_calendar_t* calendar, unsigned participant, uint32_t life, uint64_t wake_ns,
                            osal_grant_t* out_grant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (out_grant != NULL));
    FSW_ASSERT(calendar->is_shared != 0U);
    if (osal_calendar_is_closed(calendar)) {
        return STATUS_CLOSED;
    }
    if ((life != OSAL_CALENDAR_ANY_LIFE) && !osal_calendar_is_present(calendar, participant)) {
        calendar->participants[participant].process = (int32_t)getpid();
    }
    lock(calendar);
    const bool is_resting      = calendar_rest(calendar, participant, life, wake_ns);
    const uint32_t incarnation = calendar->participants[participant].incarnation;
    const uint32_t next        = is_resting ? pass_on(calendar) : NOBODY;
    unlock(calendar);
    if ((next != NOBODY) && (next != participant)) {
        wake(calendar, next);
    }
    if (!is_resting || !sleep_until_granted(calendar, participant, incarnation)) {
        obey_kill(calendar, participant, life);
        return STATUS_CLOSED;
    }
    lock(calendar);
    calendar_take_grant(calendar, participant, out_grant);
    unlock(calendar);
    return STATUS_OK;
}

void osal_calendar_done(osal_calendar_t* calendar, unsigned participant, uint64_t wake_ns)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (calendar->is_shared == 0U));
    const bool is_resting = calendar_rest(calendar, participant, OSAL_CALENDAR_ANY_LIFE, wake_ns);
    FSW_ASSERT(is_resting); // Only the holder of the grant can be done.
}

status_t osal_calendar_next(osal_calendar_t* calendar, unsigned* out_participant, osal_grant_t* out_grant)
{
    FSW_ASSERT((calendar != NULL) && (out_participant != NULL) && (out_grant != NULL));
    FSW_ASSERT((calendar->is_shared == 0U) && (calendar->running == NOBODY));
    if (calendar->is_closed != 0U) {
        return STATUS_CLOSED;
    }
    calendar_grant_next(calendar);
    if (calendar->awaited != NOBODY) {
        *out_participant = calendar->awaited;
        return STATUS_BUSY;
    }
    if (calendar->running == NOBODY) {
        return STATUS_EMPTY;
    }
    *out_participant = calendar->running;
    calendar_take_grant(calendar, calendar->running, out_grant);
    return STATUS_OK;
}

void osal_calendar_deliver(osal_calendar_t* calendar, unsigned sender, unsigned receiver, uint32_t life,
                           uint32_t messages, uint32_t octets)
{
    FSW_ASSERT((calendar != NULL) && (sender < PARTICIPANTS) && (receiver < PARTICIPANTS));
    lock(calendar);
    participant_t* const one = &calendar->participants[receiver];
    if ((one->state != OSAL_CALENDAR_ABSENT) && is_of_life(one, life)) {
        const bool is_still_now = (receiver > sender) && calendar_is_turn_to_come(calendar, receiver);
        calendar_add_saturating(&one->messages, messages);
        calendar_add_saturating(&one->octets, octets);
        const uint64_t told_ns = is_still_now ? calendar->now_ns : calendar_next_slot_ns(calendar);
        one->wake_ns           = calendar_not_before_begin(
                      one, calendar_earlier(calendar_pending_wake_ns(calendar, receiver), told_ns));
    }
    unlock_and_pass_on(calendar); // Only when all were waiting for a delivery: this one came from outside.
}

uint64_t osal_calendar_now_ns(const osal_calendar_t* calendar)
{
    FSW_ASSERT(calendar != NULL);
    return __atomic_load_n(&calendar->now_ns, __ATOMIC_ACQUIRE);
}

bool osal_calendar_is_present(const osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    return __atomic_load_n(&calendar->participants[participant].state, __ATOMIC_ACQUIRE) ==
           (uint32_t)OSAL_CALENDAR_JOINED;
}

uint64_t osal_calendar_begin_ns(osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    const participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    const uint64_t begin_ns = (one->state == OSAL_CALENDAR_JOINED) ? one->begin_ns : OSAL_CALENDAR_NEVER;
    unlock(calendar);
    return begin_ns;
}

osal_calendar_presence_t osal_calendar_presence(const osal_calendar_t* calendar, unsigned participant,
                                                uint32_t* out_life)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (out_life != NULL));
    const participant_t* const one = &calendar->participants[participant];
    *out_life                      = __atomic_load_n(&one->life, __ATOMIC_ACQUIRE);
    return (osal_calendar_presence_t)__atomic_load_n(&one->state, __ATOMIC_ACQUIRE);
}

unsigned osal_calendar_awaited(const osal_calendar_t* calendar)
{
    FSW_ASSERT(calendar != NULL);
    const uint32_t awaited = __atomic_load_n(&calendar->awaited, __ATOMIC_ACQUIRE);
    return (awaited != NOBODY) ? awaited : PARTICIPANTS;
}

void osal_calendar_postpone(osal_calendar_t* calendar, unsigned participant, uint32_t life, uint64_t at_ns)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if (is_of_life(one, life) && (one->state == OSAL_CALENDAR_EXPECTED) && (at_ns > one->begin_ns)) {
        one->begin_ns = at_ns;
    }
    unlock_and_pass_on(calendar);
}

unsigned osal_calendar_holder(osal_calendar_t* calendar, uint32_t* out_grants)
{
    FSW_ASSERT((calendar != NULL) && (out_grants != NULL));
    lock(calendar); // A watchdog calls this, and so detects a holder that is stopped inside.
    const uint32_t running = calendar->running;
    *out_grants            = calendar->grants;
    unlock(calendar);
    return (running != NOBODY) ? running : PARTICIPANTS;
}

void osal_calendar_set_stream_port(osal_calendar_t* calendar, unsigned participant, uint16_t port)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if (one->stream_port != port) {
        one->stream_server = 0U;
        __atomic_store_n(&one->stream_port, port, __ATOMIC_RELEASE);
    }
    unlock(calendar);
}

void osal_calendar_serve_stream(osal_calendar_t* calendar, unsigned participant, uint16_t port,
                                unsigned server)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (server < PARTICIPANTS));
    participant_t* const one = &calendar->participants[participant];
    lock(calendar);
    if ((port != 0U) && (one->stream_port == port)) {
        one->stream_server = server + 1U;
        calendar_rouse(calendar, participant);
    }
    unlock(calendar);
}

void osal_calendar_cut_stream(osal_calendar_t* calendar, unsigned participant, uint16_t port)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    lock(calendar);
    if ((port != 0U) && (calendar->participants[participant].stream_port == port)) {
        calendar_cut_stream(calendar, participant);
    }
    unlock(calendar);
}

uint16_t osal_calendar_served_port(const osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    const participant_t* const one = &calendar->participants[participant];
    return (__atomic_load_n(&one->stream_server, __ATOMIC_ACQUIRE) != 0U)
               ? osal_calendar_stream_port(calendar, participant)
               : 0U;
}

uint16_t osal_calendar_stream_port(const osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    return (uint16_t)__atomic_load_n(&calendar->participants[participant].stream_port, __ATOMIC_ACQUIRE);
}
