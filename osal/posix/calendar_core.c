// SPDX-License-Identifier: Apache-2.0
#include "osal/posix/calendar_core.h"

#include "base/assertion.h"

uint64_t calendar_next_slot_ns(const osal_calendar_t* calendar)
{
    const uint64_t into_slot = calendar->now_ns % calendar->slot_ns;
    const uint64_t rest      = calendar->slot_ns - into_slot;
    return (calendar->now_ns < (OSAL_CALENDAR_NEVER - rest)) ? (calendar->now_ns + rest)
                                                             : OSAL_CALENDAR_NEVER;
}

bool calendar_is_turn_to_come(const osal_calendar_t* calendar, uint32_t participant)
{
    return (calendar->last == NOBODY) || (participant > calendar->last);
}

uint64_t calendar_earlier(uint64_t a_ns, uint64_t b_ns)
{
    return (a_ns < b_ns) ? a_ns : b_ns;
}

uint64_t calendar_pending_wake_ns(const osal_calendar_t* calendar, uint32_t participant)
{
    const uint64_t wake_ns = calendar->participants[participant].wake_ns;
    const bool is_spent    = (calendar->running == participant) && (wake_ns <= calendar->now_ns);
    return is_spent ? OSAL_CALENDAR_NEVER : wake_ns;
}

/// Fit those that joined during the last grant into the order, at one defined point: the end of that grant,
/// whenever within it, in wall-clock time, they came.
static void admit_new(osal_calendar_t* calendar)
{
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        participant_t* const one = &calendar->participants[i];
        if ((one->state == OSAL_CALENDAR_JOINED) && (one->is_new != 0U)) {
            if (one->wake_ns <= calendar->now_ns) {
                one->wake_ns = calendar_is_turn_to_come(calendar, i) ? calendar->now_ns
                                                                     : calendar_next_slot_ns(calendar);
            }
            one->is_new = 0U;
        }
    }
}

void calendar_rouse(osal_calendar_t* calendar, uint32_t participant)
{
    participant_t* const one = &calendar->participants[participant];
    const uint64_t told_ns =
        calendar_is_turn_to_come(calendar, participant) ? calendar->now_ns : calendar_next_slot_ns(calendar);
    one->wake_ns = calendar_not_before_begin(
        one, calendar_earlier(calendar_pending_wake_ns(calendar, participant), told_ns));
}

void calendar_cut_stream(osal_calendar_t* calendar, uint32_t participant)
{
    participant_t* const one = &calendar->participants[participant];
    one->octets              = 0U; // Whatever the system still holds of them: simulated time decides.
    one->stream_port         = 0U;
    one->stream_server       = 0U;
    calendar_rouse(calendar, participant);
}

void calendar_leave(osal_calendar_t* calendar, uint32_t participant)
{
    participant_t* const self = &calendar->participants[participant];
    self->state               = OSAL_CALENDAR_ABSENT;
    self->incarnation++;
    self->wake_ns       = OSAL_CALENDAR_NEVER;
    self->stream_port   = 0U;
    self->stream_server = 0U;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        if (calendar->participants[i].stream_server == (participant + 1U)) {
            calendar_cut_stream(calendar, i);
        }
    }
    if (self->succession_ns != 0U) {
        self->life++;
        self->begin_ns = calendar->now_ns + self->succession_ns;
        self->is_begun = 0U;
        self->state    = OSAL_CALENDAR_EXPECTED;
    } else {
        self->messages = 0U;
        self->octets   = 0U;
    }
    self->is_new       = 0U;
    self->is_failed    = 0U;
    self->is_suspended = 0U;
    if (calendar->running == participant) {
        __atomic_store_n(&calendar->running, NOBODY, __ATOMIC_RELEASE);
    }
}

/// When `participant` has its next turn, as far as it can have one: an expected one has it when its life
/// begins.
static uint64_t turn_ns(const participant_t* one)
{
    if (one->state == OSAL_CALENDAR_EXPECTED) {
        return one->begin_ns;
    }
    return ((one->state == OSAL_CALENDAR_JOINED) && (one->is_suspended == 0U)) ? one->wake_ns
                                                                               : OSAL_CALENDAR_NEVER;
}

/// The smallest (time, order) of the next turns, or NOBODY.
static uint32_t first_turn(const osal_calendar_t* calendar)
{
    uint32_t chosen   = NOBODY;
    uint64_t least_ns = OSAL_CALENDAR_NEVER;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        const uint64_t time_ns = turn_ns(&calendar->participants[i]);
        if (time_ns < least_ns) {
            chosen   = i;
            least_ns = time_ns;
        }
    }
    return chosen;
}

/// An expected participant whose life begins not later than the wake time of `chosen`, or NOBODY. Orders do
/// not matter: no participant runs at the instant at which a life begins before that life has joined.
static uint32_t awaited_before(const osal_calendar_t* calendar, uint32_t chosen)
{
    const uint64_t limit_ns =
        (chosen != NOBODY) ? turn_ns(&calendar->participants[chosen]) : OSAL_CALENDAR_NEVER;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        const participant_t* const one = &calendar->participants[i];
        if ((one->state == OSAL_CALENDAR_EXPECTED) && (one->begin_ns <= limit_ns)) {
            return i;
        }
    }
    return NOBODY;
}

void calendar_grant_next(osal_calendar_t* calendar)
{
    calendar->awaited = NOBODY;
    if ((calendar->running != NOBODY) || (calendar->is_closed != 0U)) {
        return;
    }
    admit_new(calendar);
    // Each round either ends a life that failed to begin, or is the last.
    for (uint32_t round = 0U; round <= PARTICIPANTS; round++) {
        const uint32_t chosen  = first_turn(calendar);
        const uint32_t awaited = awaited_before(calendar, chosen);
        const uint32_t first   = (awaited != NOBODY) ? awaited : chosen;
        if (first == NOBODY) {
            return;
        }
        participant_t* const one = &calendar->participants[first];
        if (one->is_failed != 0U) {
            calendar_leave(calendar, first);
            continue;
        }
        if (awaited != NOBODY) {
            calendar->awaited = awaited;
            return;
        }
        if (one->wake_ns > calendar->now_ns) {
            __atomic_store_n(&calendar->now_ns, one->wake_ns, __ATOMIC_RELEASE);
        }
        one->is_begun  = 1U;
        calendar->last = first;
        calendar->grants++;
        __atomic_store_n(&calendar->running, first, __ATOMIC_RELEASE);
        return;
    }
}

uint64_t calendar_not_before_begin(const participant_t* one, uint64_t wake_ns)
{
    return ((one->is_begun == 0U) && (wake_ns < one->begin_ns)) ? one->begin_ns : wake_ns;
}

bool calendar_rest(osal_calendar_t* calendar, uint32_t participant, uint32_t life, uint64_t wake_ns)
{
    participant_t* const self = &calendar->participants[participant];
    if ((life != OSAL_CALENDAR_ANY_LIFE) && ((self->life != life) || (self->state == OSAL_CALENDAR_ABSENT))) {
        return false;
    }
    if (self->state != OSAL_CALENDAR_JOINED) {
        const bool is_expected = (self->state == OSAL_CALENDAR_EXPECTED);
        if (!is_expected) {
            self->begin_ns = 0U;
        }
        self->wake_ns = calendar_not_before_begin(
            self, calendar_earlier(wake_ns, is_expected ? self->wake_ns : OSAL_CALENDAR_NEVER));
        self->is_new = 1U;
        self->incarnation++;
        __atomic_store_n(&self->state, (uint32_t)OSAL_CALENDAR_JOINED, __ATOMIC_RELEASE);
        return true;
    }
    if (calendar->running != participant) {
        return false; // It was suspended while it held the grant, and comes back.
    }
    const uint64_t delivered_ns = calendar_pending_wake_ns(calendar, participant);
    const uint64_t asked_ns     = (wake_ns > calendar->now_ns) ? wake_ns : calendar_next_slot_ns(calendar);
    self->wake_ns               = calendar_earlier(asked_ns, delivered_ns);
    __atomic_store_n(&calendar->running, NOBODY, __ATOMIC_RELEASE);
    return true;
}

void calendar_add_saturating(uint32_t* sum, uint32_t more)
{
    *sum = (more < (UINT32_MAX - *sum)) ? (*sum + more) : UINT32_MAX;
}

void calendar_take_grant(osal_calendar_t* calendar, uint32_t participant, osal_grant_t* out_grant)
{
    participant_t* const self = &calendar->participants[participant];
    out_grant->now_ns         = calendar->now_ns;
    out_grant->messages       = self->messages;
    out_grant->octets         = self->octets;
    self->messages            = 0U;
    self->octets              = 0U;
}
