// SPDX-License-Identifier: Apache-2.0
// The functions of lockstep_core.c change the state of the scheduler, for processes and for the image. A
// shared scheduler calls them under a robust lock. The grant passes directly from participant to participant:
// the participant that ends its turn chooses its successor and wakes it, without spinning and without a
// central process. The port has lock, wait and wake (lockstep_port.c).
//
// A participant may be killed at any instruction. Therefore the writes of every change have a fixed order:
// the write of one word, `running`, commits the change, and the writes before it can be repeated. The end of
// a life first writes which life ends (`leaving`); the process that gets the lock after its holder died
// completes it. If no end of a life was begun, that process continues from the present state.
// osal_lockstep_end, which is called for every death, chooses or wakes the successor again.
#include "osal/include/osal/lockstep_scheduler.h"

#include "base/assertion.h"
#include "osal/common/lockstep_core.h"

#include <string.h>

// ---- Shared form: lock and hand-over ----

static void lock(osal_lockstep_t* const scheduler)
{
    if (scheduler->is_shared != 0U) {
        lockstep_port_lock(scheduler);
        lockstep_complete_leave(scheduler);
    }
}

static void unlock(osal_lockstep_t* const scheduler)
{
    if (scheduler->is_shared != 0U) {
        lockstep_port_unlock(scheduler);
    }
}

static void wake(osal_lockstep_t* const scheduler, const uint32_t participant)
{
    uint32_t* const word = &scheduler->participants[participant].word;
    (void)__atomic_add_fetch(word, 1U, __ATOMIC_RELEASE);
    if (scheduler->is_shared != 0U) {
        lockstep_port_wake(word);
    }
}

/// Give the grant if it is free. The caller holds the lock. Returns the participant to wake after the unlock.
static uint32_t pass_on(osal_lockstep_t* const scheduler)
{
    if ((scheduler->is_shared != 0U) && (scheduler->running == NO_PARTICIPANT)) {
        lockstep_grant_next(scheduler);
        return scheduler->running;
    }
    return NO_PARTICIPANT;
}

/// After a change: give the grant if it is free, and unlock.
static void unlock_and_pass_on(osal_lockstep_t* const scheduler)
{
    const uint32_t next = pass_on(scheduler);
    unlock(scheduler);
    if (next != NO_PARTICIPANT) {
        wake(scheduler, next);
    }
}

/// Sleep until the participant has the grant. False if the run is over or its life has ended.
static bool sleep_until_granted(osal_lockstep_t* const scheduler, const uint32_t participant,
                                const uint32_t incarnation)
{
    // Read `word` before the checks: if a wake comes after them, it has changed `word`, and the wait of the
    // port returns.
    participant_t* const self = &scheduler->participants[participant];
    for (;;) {
        const uint32_t seen = __atomic_load_n(&self->word, __ATOMIC_ACQUIRE);
        if ((__atomic_load_n(&scheduler->is_closed, __ATOMIC_ACQUIRE) != 0U) ||
            (__atomic_load_n(&self->incarnation, __ATOMIC_ACQUIRE) != incarnation)) {
            return false;
        }
        if (__atomic_load_n(&scheduler->running, __ATOMIC_ACQUIRE) == participant) {
            return true;
        }
        lockstep_port_wait(&self->word, seen);
    }
}

// ---- Functions of osal/lockstep_scheduler.h ----

osal_lockstep_t* osal_lockstep_create(void* const storage, const uint64_t step_ns, const bool is_shared)
{
    FSW_ASSERT((storage != NULL) && (((uintptr_t)storage % 64U) == 0U) && (step_ns >= 1U));
    osal_lockstep_t* const scheduler = storage;
    (void)memset(scheduler, 0, sizeof *scheduler);
    scheduler->step_ns    = step_ns;
    scheduler->running    = NO_PARTICIPANT;
    scheduler->last       = NO_PARTICIPANT;
    scheduler->awaited    = NO_PARTICIPANT;
    scheduler->leaving    = NO_PARTICIPANT;
    scheduler->is_shared  = is_shared ? 1U : 0U;
    scheduler->timeout_ns = OSAL_LOCKSTEP_TIMEOUT_NS;
    if (is_shared && !lockstep_port_prepare(scheduler)) {
        return NULL;
    }
    __atomic_store_n(&scheduler->magic, LOCKSTEP_MAGIC, __ATOMIC_RELEASE);
    return scheduler;
}

void osal_lockstep_set_timeout(osal_lockstep_t* const scheduler, const uint64_t timeout_ns)
{
    FSW_ASSERT((scheduler != NULL) && (timeout_ns >= 2U));
    scheduler->timeout_ns = timeout_ns;
}

osal_lockstep_t* osal_lockstep_attach(void* const storage)
{
    FSW_ASSERT(storage != NULL);
    osal_lockstep_t* const scheduler = storage;
    return (__atomic_load_n(&scheduler->magic, __ATOMIC_ACQUIRE) == LOCKSTEP_MAGIC) ? scheduler : NULL;
}

void osal_lockstep_expect(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                          const uint64_t at_ns)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS) && (life != OSAL_LOCKSTEP_ANY_LIFE));
    lock(scheduler);
    participant_t* const one = &scheduler->participants[participant];
    if (one->state == OSAL_LOCKSTEP_ABSENT) {
        lockstep_use(scheduler, participant);
        one->wake_ns  = OSAL_LOCKSTEP_NEVER;
        one->life     = life;
        one->begin_ns = at_ns;
        one->is_begun = false;
        one->state    = OSAL_LOCKSTEP_EXPECTED;
    }
    unlock(scheduler);
}

static bool is_of_life(const participant_t* const one, const uint32_t life)
{
    return (life == OSAL_LOCKSTEP_ANY_LIFE) || (one->life == life);
}

/// End a life; wake the process that waits in that life and the new holder of the grant.
static void end_life(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                     const bool is_kill)
{
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if (is_of_life(one, life) && (one->state != OSAL_LOCKSTEP_ABSENT)) {
        one->killed_life = is_kill ? one->life : one->killed_life;
        lockstep_leave(scheduler, participant);
        (void)pass_on(scheduler);
    }
    const uint32_t running = scheduler->running;
    unlock(scheduler);
    wake(scheduler, participant);
    // The process may have died after it passed the grant on and before it woke the new holder.
    if (running != NO_PARTICIPANT) {
        wake(scheduler, running);
    }
}

void osal_lockstep_end(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    const bool is_to_begin = is_of_life(one, life) && (one->state != OSAL_LOCKSTEP_ABSENT) &&
                             !one->is_begun && (one->begin_ns > scheduler->now_ns);
    if (is_to_begin) { // The life ends when it would have begun, so that wall-clock time has no effect.
        one->is_failed = true;
        (void)pass_on(scheduler);
    }
    const uint32_t running = scheduler->running;
    unlock(scheduler);
    if (!is_to_begin) {
        end_life(scheduler, participant, life, false);
    } else if (running != NO_PARTICIPANT) {
        wake(scheduler, running);
    } else {
        // Another expected participant stops simulated time, so no participant has the grant.
    }
}

void osal_lockstep_dismiss(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    end_life(scheduler, participant, life, false);
}

void osal_lockstep_kill(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    end_life(scheduler, participant, life, true);
}

void osal_lockstep_set_succession(osal_lockstep_t* const scheduler, const unsigned participant,
                                  const uint64_t delay_ns)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    lock(scheduler);
    scheduler->participants[participant].succession_ns = delay_ns;
    unlock(scheduler);
}

void osal_lockstep_suspend(osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if ((one->state == OSAL_LOCKSTEP_JOINED) && (scheduler->now_ns >= one->begin_ns)) {
        one->is_suspended = true;
        if (scheduler->running == participant) {
            __atomic_store_n(&scheduler->running, NO_PARTICIPANT, __ATOMIC_RELEASE);
        }
    }
    unlock_and_pass_on(scheduler);
}

void osal_lockstep_resume(osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if (one->is_suspended) {
        one->is_suspended = false;
        if (one->wake_ns <= scheduler->now_ns) {
            one->wake_ns = lockstep_is_turn_to_come(scheduler, participant)
                               ? scheduler->now_ns
                               : lockstep_next_step_ns(scheduler);
        }
    }
    unlock_and_pass_on(scheduler);
}

void osal_lockstep_close(osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    __atomic_store_n(&scheduler->is_closed, 1U, __ATOMIC_RELEASE);
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        wake(scheduler, i);
    }
}

bool osal_lockstep_is_closed(const osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    return __atomic_load_n(&scheduler->is_closed, __ATOMIC_ACQUIRE) != 0U;
}

/// End the caller if its life was killed: it must do nothing after that instant of simulated time.
static void end_if_killed(const osal_lockstep_t* const scheduler, const uint32_t participant,
                          const uint32_t life)
{
    if ((life != OSAL_LOCKSTEP_ANY_LIFE) &&
        (__atomic_load_n(&scheduler->participants[participant].killed_life, __ATOMIC_ACQUIRE) == life)) {
        lockstep_port_end();
    }
}

status_t osal_lockstep_wait(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                            const uint64_t wake_ns, osal_grant_t* const out_grant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS) && (out_grant != NULL));
    FSW_ASSERT(scheduler->is_shared != 0U);
    if (osal_lockstep_is_closed(scheduler)) {
        return STATUS_CLOSED;
    }
    if ((life != OSAL_LOCKSTEP_ANY_LIFE) && !osal_lockstep_is_present(scheduler, participant)) {
        scheduler->participants[participant].process = lockstep_port_process();
    }
    lock(scheduler);
    const bool is_turn_over    = lockstep_end_turn(scheduler, participant, life, wake_ns);
    const uint32_t incarnation = scheduler->participants[participant].incarnation;
    const uint32_t next        = is_turn_over ? pass_on(scheduler) : NO_PARTICIPANT;
    unlock(scheduler);
    if ((next != NO_PARTICIPANT) && (next != participant)) {
        wake(scheduler, next);
    }
    if (!is_turn_over || !sleep_until_granted(scheduler, participant, incarnation)) {
        end_if_killed(scheduler, participant, life);
        return STATUS_CLOSED;
    }
    lock(scheduler);
    lockstep_take_grant(scheduler, participant, out_grant);
    unlock(scheduler);
    return STATUS_OK;
}

void osal_lockstep_done(osal_lockstep_t* const scheduler, const unsigned participant, const uint64_t wake_ns)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS) && (scheduler->is_shared == 0U));
    const bool is_turn_over = lockstep_end_turn(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE, wake_ns);
    FSW_ASSERT(is_turn_over); // Only the holder of the grant may call this function.
}

status_t osal_lockstep_next(osal_lockstep_t* const scheduler, unsigned* const out_participant,
                            osal_grant_t* const out_grant)
{
    FSW_ASSERT((scheduler != NULL) && (out_participant != NULL) && (out_grant != NULL));
    FSW_ASSERT((scheduler->is_shared == 0U) && (scheduler->running == NO_PARTICIPANT));
    if (scheduler->is_closed != 0U) {
        return STATUS_CLOSED;
    }
    lockstep_grant_next(scheduler);
    if (scheduler->awaited != NO_PARTICIPANT) {
        *out_participant = scheduler->awaited;
        return STATUS_BUSY;
    }
    if (scheduler->running == NO_PARTICIPANT) {
        return STATUS_EMPTY;
    }
    *out_participant = scheduler->running;
    lockstep_take_grant(scheduler, scheduler->running, out_grant);
    return STATUS_OK;
}

void osal_lockstep_deliver(osal_lockstep_t* const scheduler, const unsigned sender, const unsigned receiver,
                           const uint32_t life, const uint32_t messages, const uint32_t octets)
{
    FSW_ASSERT((scheduler != NULL) && (sender < PARTICIPANTS) && (receiver < PARTICIPANTS));
    lock(scheduler);
    participant_t* const one = &scheduler->participants[receiver];
    if ((one->state != OSAL_LOCKSTEP_ABSENT) && is_of_life(one, life)) {
        const bool is_still_now = (receiver > sender) && lockstep_is_turn_to_come(scheduler, receiver);
        lockstep_add_saturating(&one->messages, messages);
        lockstep_add_saturating(&one->octets, octets);
        const uint64_t reported_ns = is_still_now ? scheduler->now_ns : lockstep_next_step_ns(scheduler);
        one->wake_ns               = lockstep_not_before_begin(
                          one, lockstep_earlier(lockstep_pending_wake_ns(scheduler, receiver), reported_ns));
    }
    // The grant is free if all participants wait for a delivery; this delivery may come from outside of any
    // grant.
    unlock_and_pass_on(scheduler);
}

uint64_t osal_lockstep_now_ns(const osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    return __atomic_load_n(&scheduler->now_ns, __ATOMIC_ACQUIRE);
}

bool osal_lockstep_is_present(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    return __atomic_load_n(&scheduler->participants[participant].state, __ATOMIC_ACQUIRE) ==
           (uint32_t)OSAL_LOCKSTEP_JOINED;
}

uint64_t osal_lockstep_begin_ns(osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    const participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    const uint64_t begin_ns = (one->state == OSAL_LOCKSTEP_JOINED) ? one->begin_ns : OSAL_LOCKSTEP_NEVER;
    unlock(scheduler);
    return begin_ns;
}

osal_lockstep_presence_t osal_lockstep_presence(const osal_lockstep_t* const scheduler,
                                                const unsigned participant, uint32_t* const out_life)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS) && (out_life != NULL));
    const participant_t* const one = &scheduler->participants[participant];
    *out_life                      = __atomic_load_n(&one->life, __ATOMIC_ACQUIRE);
    return (osal_lockstep_presence_t)__atomic_load_n(&one->state, __ATOMIC_ACQUIRE);
}

unsigned osal_lockstep_awaited(const osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    const uint32_t awaited = __atomic_load_n(&scheduler->awaited, __ATOMIC_ACQUIRE);
    return (awaited != NO_PARTICIPANT) ? awaited : PARTICIPANTS;
}

void osal_lockstep_postpone(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                            const uint64_t at_ns)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if (is_of_life(one, life) && (one->state == OSAL_LOCKSTEP_EXPECTED) && (at_ns > one->begin_ns)) {
        one->begin_ns = at_ns;
    }
    unlock_and_pass_on(scheduler);
}

unsigned osal_lockstep_holder(osal_lockstep_t* const scheduler, uint32_t* const out_grants)
{
    FSW_ASSERT((scheduler != NULL) && (out_grants != NULL));
    lock(scheduler); // A watchdog calls this: `lock` then detects a holder of the lock that is stopped.
    const uint32_t running = scheduler->running;
    *out_grants            = scheduler->grants;
    unlock(scheduler);
    return (running != NO_PARTICIPANT) ? running : PARTICIPANTS;
}

void osal_lockstep_hold(osal_lockstep_t* const scheduler, const bool is_held)
{
    FSW_ASSERT(scheduler != NULL);
    __atomic_store_n(&scheduler->is_held, is_held ? 1U : 0U, __ATOMIC_RELEASE);
}

bool osal_lockstep_is_held(const osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    return __atomic_load_n(&scheduler->is_held, __ATOMIC_ACQUIRE) != 0U;
}

void osal_lockstep_note_loss(osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    __atomic_store_n(&scheduler->is_lossy, 1U, __ATOMIC_RELEASE);
}

bool osal_lockstep_is_lossy(const osal_lockstep_t* const scheduler)
{
    FSW_ASSERT(scheduler != NULL);
    return __atomic_load_n(&scheduler->is_lossy, __ATOMIC_ACQUIRE) != 0U;
}

void osal_lockstep_set_stream_port(osal_lockstep_t* const scheduler, const unsigned participant,
                                   const uint16_t port)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if (one->stream_port != port) {
        one->stream_server = 0U;
        __atomic_store_n(&one->stream_port, port, __ATOMIC_RELEASE);
    }
    unlock(scheduler);
}

void osal_lockstep_serve_stream(osal_lockstep_t* const scheduler, const unsigned participant,
                                const uint16_t port, const unsigned server)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS) && (server < PARTICIPANTS));
    participant_t* const one = &scheduler->participants[participant];
    lock(scheduler);
    if ((port != 0U) && (one->stream_port == port)) {
        one->stream_server = server + 1U;
        lockstep_schedule_wake(scheduler, participant);
    }
    unlock(scheduler);
}

void osal_lockstep_cut_stream(osal_lockstep_t* const scheduler, const unsigned participant,
                              const uint16_t port)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    lock(scheduler);
    if ((port != 0U) && (scheduler->participants[participant].stream_port == port)) {
        lockstep_cut_stream(scheduler, participant);
    }
    unlock(scheduler);
}

uint16_t osal_lockstep_served_port(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    const participant_t* const one = &scheduler->participants[participant];
    return (__atomic_load_n(&one->stream_server, __ATOMIC_ACQUIRE) != 0U)
               ? osal_lockstep_stream_port(scheduler, participant)
               : 0U;
}

uint16_t osal_lockstep_stream_port(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    FSW_ASSERT((scheduler != NULL) && (participant < PARTICIPANTS));
    return (uint16_t)__atomic_load_n(&scheduler->participants[participant].stream_port, __ATOMIC_ACQUIRE);
}
