// SPDX-License-Identifier: Apache-2.0
#include "osal/common/lockstep_core.h"

#include "base/assertion.h"

void lockstep_use(osal_lockstep_t* const scheduler, const uint32_t participant)
{
    if (participant >= scheduler->used) {
        scheduler->used = participant + 1U;
    }
}

uint64_t lockstep_next_step_ns(const osal_lockstep_t* const scheduler)
{
    const uint64_t into_step = scheduler->now_ns % scheduler->step_ns;
    const uint64_t rest      = scheduler->step_ns - into_step;
    return (scheduler->now_ns < (OSAL_LOCKSTEP_NEVER - rest)) ? (scheduler->now_ns + rest)
                                                              : OSAL_LOCKSTEP_NEVER;
}

bool lockstep_is_turn_to_come(const osal_lockstep_t* const scheduler, const uint32_t participant)
{
    return (scheduler->last == NO_PARTICIPANT) || (participant > scheduler->last);
}

uint64_t lockstep_earlier(const uint64_t a_ns, const uint64_t b_ns)
{
    return (a_ns < b_ns) ? a_ns : b_ns;
}

uint64_t lockstep_pending_wake_ns(const osal_lockstep_t* const scheduler, const uint32_t participant)
{
    const uint64_t wake_ns = scheduler->participants[participant].wake_ns;
    const bool is_spent    = (scheduler->running == participant) && (wake_ns <= scheduler->now_ns);
    return is_spent ? OSAL_LOCKSTEP_NEVER : wake_ns;
}

/// Schedule the first turn of the participants that joined during the last grant. This happens at the end of
/// that grant, so that the wall-clock time at which they joined has no effect.
static void admit_new(osal_lockstep_t* const scheduler)
{
    if (scheduler->has_new == 0U) {
        return;
    }
    for (uint32_t i = 0U; i < scheduler->used; i++) {
        participant_t* const one = &scheduler->participants[i];
        if ((one->state == OSAL_LOCKSTEP_JOINED) && one->is_new) {
            if (one->wake_ns <= scheduler->now_ns) {
                one->wake_ns = lockstep_is_turn_to_come(scheduler, i) ? scheduler->now_ns
                                                                      : lockstep_next_step_ns(scheduler);
            }
            one->is_new = false;
        }
    }
    // This write comes last: if the caller dies before it, the next call admits the rest.
    __atomic_store_n(&scheduler->has_new, 0U, __ATOMIC_RELEASE);
}

void lockstep_schedule_wake(osal_lockstep_t* const scheduler, const uint32_t participant)
{
    participant_t* const one   = &scheduler->participants[participant];
    const uint64_t reported_ns = lockstep_is_turn_to_come(scheduler, participant)
                                     ? scheduler->now_ns
                                     : lockstep_next_step_ns(scheduler);
    one->wake_ns               = lockstep_not_before_begin(
                      one, lockstep_earlier(lockstep_pending_wake_ns(scheduler, participant), reported_ns));
}

void lockstep_cut_stream(osal_lockstep_t* const scheduler, const uint32_t participant)
{
    participant_t* const one = &scheduler->participants[participant];
    one->octets      = 0U; // The stream ends now in simulated time, even if octets are still in the socket.
    one->stream_port = 0U;
    lockstep_schedule_wake(scheduler, participant);
    // This write comes last: if the caller dies before it, lockstep_complete_leave finds the server and cuts
    // again.
    __atomic_store_n(&one->stream_server, 0U, __ATOMIC_RELEASE);
}

void lockstep_leave(osal_lockstep_t* const scheduler, const uint32_t participant)
{
    scheduler->left_life = scheduler->participants[participant].life;
    __atomic_store_n(&scheduler->leaving, participant, __ATOMIC_RELEASE);
    __atomic_thread_fence(__ATOMIC_SEQ_CST); // No following write takes effect before `leaving` is set.
    lockstep_complete_leave(scheduler);
}

void lockstep_complete_leave(osal_lockstep_t* const scheduler)
{
    const uint32_t participant = scheduler->leaving;
    if (participant == NO_PARTICIPANT) {
        return;
    }
    participant_t* const self = &scheduler->participants[participant];
    self->state               = OSAL_LOCKSTEP_ABSENT;
    self->incarnation++; // Ends the waits of this life; a repeated increment does no harm.
    self->wake_ns       = OSAL_LOCKSTEP_NEVER;
    self->stream_port   = 0U;
    self->stream_server = 0U;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        if (scheduler->participants[i].stream_server == (participant + 1U)) {
            lockstep_cut_stream(scheduler, i);
        }
    }
    if (self->succession_ns != 0U) {
        self->life     = scheduler->left_life + 1U;
        self->begin_ns = scheduler->now_ns + self->succession_ns;
        self->is_begun = false;
        self->state    = OSAL_LOCKSTEP_EXPECTED;
    } else {
        self->messages = 0U;
        self->octets   = 0U;
    }
    self->is_new       = false;
    self->is_failed    = false;
    self->is_suspended = false;
    if (scheduler->running == participant) {
        __atomic_store_n(&scheduler->running, NO_PARTICIPANT, __ATOMIC_RELEASE);
    }
    __atomic_store_n(&scheduler->leaving, NO_PARTICIPANT, __ATOMIC_RELEASE);
}

/// Returns the time of the participant's next turn: the start of its life if it is EXPECTED, and
/// OSAL_LOCKSTEP_NEVER if it is absent or suspended.
static uint64_t turn_ns(const participant_t* const one)
{
    if (one->state == OSAL_LOCKSTEP_EXPECTED) {
        return one->begin_ns;
    }
    return ((one->state == OSAL_LOCKSTEP_JOINED) && !one->is_suspended) ? one->wake_ns : OSAL_LOCKSTEP_NEVER;
}

/// Returns the participant whose next turn has the smallest (time, order), or NO_PARTICIPANT. *out_awaited:
/// an expected participant whose life begins at that time, or NO_PARTICIPANT. Its order does not matter,
/// because no participant may run at the instant at which a life begins until that life has joined.
static uint32_t first_turn(const osal_lockstep_t* const scheduler, uint32_t* const out_awaited)
{
    uint32_t chosen   = NO_PARTICIPANT;
    uint64_t least_ns = OSAL_LOCKSTEP_NEVER;
    *out_awaited      = NO_PARTICIPANT;
    for (uint32_t i = 0U; i < scheduler->used; i++) {
        const participant_t* const one = &scheduler->participants[i];
        const uint64_t time_ns         = turn_ns(one);
        if (time_ns < least_ns) {
            chosen       = i;
            least_ns     = time_ns;
            *out_awaited = NO_PARTICIPANT;
        }
        if ((time_ns == least_ns) && (*out_awaited == NO_PARTICIPANT) &&
            (one->state == OSAL_LOCKSTEP_EXPECTED)) {
            *out_awaited = i;
        }
    }
    return chosen;
}

void lockstep_grant_next(osal_lockstep_t* const scheduler)
{
    scheduler->awaited = NO_PARTICIPANT;
    if ((scheduler->running != NO_PARTICIPANT) || (scheduler->is_closed != 0U)) {
        return;
    }
    admit_new(scheduler);
    // Each round but the last ends a life whose process died before the life began.
    for (uint32_t round = 0U; round <= PARTICIPANTS; round++) {
        uint32_t awaited      = NO_PARTICIPANT;
        const uint32_t chosen = first_turn(scheduler, &awaited);
        const uint32_t first  = (awaited != NO_PARTICIPANT) ? awaited : chosen;
        if (first == NO_PARTICIPANT) {
            return;
        }
        participant_t* const one = &scheduler->participants[first];
        if (one->is_failed) {
            lockstep_leave(scheduler, first);
            continue;
        }
        if (awaited != NO_PARTICIPANT) {
            scheduler->awaited = awaited;
            return;
        }
        if (one->wake_ns > scheduler->now_ns) {
            __atomic_store_n(&scheduler->now_ns, one->wake_ns, __ATOMIC_RELEASE);
        }
        one->is_begun   = true;
        scheduler->last = first;
        scheduler->grants++;
        __atomic_store_n(&scheduler->running, first, __ATOMIC_RELEASE);
        return;
    }
}

uint64_t lockstep_not_before_begin(const participant_t* const one, const uint64_t wake_ns)
{
    return (!one->is_begun && (wake_ns < one->begin_ns)) ? one->begin_ns : wake_ns;
}

bool lockstep_end_turn(osal_lockstep_t* const scheduler, const uint32_t participant, const uint32_t life,
                       const uint64_t wake_ns)
{
    participant_t* const self = &scheduler->participants[participant];
    if ((life != OSAL_LOCKSTEP_ANY_LIFE) && ((self->life != life) || (self->state == OSAL_LOCKSTEP_ABSENT))) {
        return false;
    }
    if (self->state != OSAL_LOCKSTEP_JOINED) {
        const bool is_expected = (self->state == OSAL_LOCKSTEP_EXPECTED);
        if (!is_expected) {
            self->begin_ns = 0U;
        }
        self->wake_ns = lockstep_not_before_begin(
            self, lockstep_earlier(wake_ns, is_expected ? self->wake_ns : OSAL_LOCKSTEP_NEVER));
        self->is_new       = true;
        scheduler->has_new = 1U;
        lockstep_use(scheduler, participant);
        __atomic_store_n(&self->state, (uint32_t)OSAL_LOCKSTEP_JOINED, __ATOMIC_RELEASE);
        return true;
    }
    if (scheduler->running != participant) {
        return false; // The participant lost the grant when it was suspended, and has been resumed since.
    }
    const uint64_t delivered_ns = lockstep_pending_wake_ns(scheduler, participant);
    const uint64_t asked_ns     = (wake_ns > scheduler->now_ns) ? wake_ns : lockstep_next_step_ns(scheduler);
    self->wake_ns               = lockstep_earlier(asked_ns, delivered_ns);
    __atomic_store_n(&scheduler->running, NO_PARTICIPANT, __ATOMIC_RELEASE);
    return true;
}

void lockstep_add_saturating(uint32_t* const sum, const uint32_t more)
{
    *sum = (more < (UINT32_MAX - *sum)) ? (*sum + more) : UINT32_MAX;
}

void lockstep_take_grant(osal_lockstep_t* const scheduler, const uint32_t participant,
                         osal_grant_t* const out_grant)
{
    participant_t* const self = &scheduler->participants[participant];
    out_grant->now_ns         = scheduler->now_ns;
    out_grant->messages       = self->messages;
    out_grant->octets         = self->octets;
    self->messages            = 0U;
    self->octets              = 0U;
}
