// SPDX-License-Identifier: Apache-2.0
// The calendar's state changes are plain functions over the structure ("core"), shared by both forms. In the
// process form they run under a robust lock and the grant is handed directly from participant to participant:
// the one that is done chooses its successor and wakes it by futex. Nobody spins, nobody stands in between.
//
// A participant may be killed at any instruction. Every change is therefore ordered so that `running`, one
// word, commits it, and what was written before can be written again: whoever finds the lock of a dead holder
// goes on from what is there, and osal_calendar_end, called for every death, chooses or wakes the successor
// once more.
#define _GNU_SOURCE
#include "osal/include/osal/calendar.h"

#include "fsw/framework/base/assertion.h"
#include "osal/include/osal/mutex.h"

#include <limits.h>
#include <linux/futex.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#define CALENDAR_MAGIC 0x63616C656E646172ULL // "calendar"
#define NOBODY UINT32_MAX
#define PARTICIPANTS OSAL_CALENDAR_PARTICIPANTS_MAX

typedef enum {
    PARTICIPANT_ABSENT = 0,
    PARTICIPANT_EXPECTED,
    PARTICIPANT_JOINED
} participant_state_t;

typedef struct {
    uint32_t word;        ///< Futex: changes whenever the participant has reason to look.
    uint32_t state;       ///< participant_state_t.
    uint64_t wake_ns;     ///< Earliest of what was asked for and what deliveries brought about.
    uint32_t messages;    ///< Deliveries not yet told.
    uint32_t octets;      ///< Octets not yet told.
    uint32_t incarnation; ///< Changes with each join and end: a waiter of an older one leaves.
    uint32_t is_new;      ///< Joined, and not yet fitted into the order of the present instant.
    uint32_t stream_port;
    uint32_t reserved[7];
} participant_t;

struct osal_calendar {
    uint64_t magic;
    uint64_t slot_ns;
    uint64_t now_ns;
    uint32_t running; ///< Holder of the grant, or NOBODY. Commits a hand-over.
    uint32_t last;    ///< Last holder: at the present instant only higher orders still have their turn.
    uint32_t is_closed;
    uint32_t is_shared;
    uint64_t reserved[3];
    osal_mutex_t mutex;
    participant_t participants[PARTICIPANTS];
};

typedef char calendar_fits_its_storage[(sizeof(osal_calendar_t) <= OSAL_CALENDAR_BYTES) ? 1 : -1];

// --- Core: state changes without waiting ---------------------------------------------------------------

static uint64_t next_slot_ns(const osal_calendar_t* calendar)
{
    const uint64_t into_slot = calendar->now_ns % calendar->slot_ns;
    const uint64_t rest      = calendar->slot_ns - into_slot;
    return (calendar->now_ns < (OSAL_CALENDAR_NEVER - rest)) ? (calendar->now_ns + rest)
                                                             : OSAL_CALENDAR_NEVER;
}

/// True if `participant` still has its turn at the present instant.
static bool is_turn_to_come(const osal_calendar_t* calendar, uint32_t participant)
{
    return (calendar->last == NOBODY) || (participant > calendar->last);
}

static uint64_t earlier(uint64_t a_ns, uint64_t b_ns)
{
    return (a_ns < b_ns) ? a_ns : b_ns;
}

/// When `participant` is to wake, as far as known. The wake time that brought it the grant it holds is not
/// after now, and spent; a later one is of a delivery to itself.
static uint64_t pending_wake_ns(const osal_calendar_t* calendar, uint32_t participant)
{
    const uint64_t wake_ns = calendar->participants[participant].wake_ns;
    const bool is_spent    = (calendar->running == participant) && (wake_ns <= calendar->now_ns);
    return is_spent ? OSAL_CALENDAR_NEVER : wake_ns;
}

static bool is_waited_for(const osal_calendar_t* calendar)
{
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        if (calendar->participants[i].state == PARTICIPANT_EXPECTED) {
            return true;
        }
    }
    return false;
}

/// Fit those that joined during the last grant into the order, at one defined point: the end of that grant,
/// whenever within it, in wall-clock time, they came.
static void admit_new(osal_calendar_t* calendar)
{
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        participant_t* const one = &calendar->participants[i];
        if ((one->state == PARTICIPANT_JOINED) && (one->is_new != 0U)) {
            if (one->wake_ns <= calendar->now_ns) {
                one->wake_ns = is_turn_to_come(calendar, i) ? calendar->now_ns : next_slot_ns(calendar);
            }
            one->is_new = 0U;
        }
    }
}

/// Hand the grant to the smallest (wake time, order). Leaves `running` at NOBODY if there is none, if an
/// expected participant has not joined, or if the run is over.
static void grant_next(osal_calendar_t* calendar)
{
    if ((calendar->running != NOBODY) || (calendar->is_closed != 0U) || is_waited_for(calendar)) {
        return;
    }
    admit_new(calendar);
    uint32_t chosen  = NOBODY;
    uint64_t wake_ns = OSAL_CALENDAR_NEVER;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        const participant_t* const one = &calendar->participants[i];
        if ((one->state == PARTICIPANT_JOINED) && (one->wake_ns < wake_ns)) {
            chosen  = i;
            wake_ns = one->wake_ns;
        }
    }
    if (chosen != NOBODY) {
        if (wake_ns > calendar->now_ns) {
            __atomic_store_n(&calendar->now_ns, wake_ns, __ATOMIC_RELEASE);
        }
        calendar->last = chosen;
        __atomic_store_n(&calendar->running, chosen, __ATOMIC_RELEASE);
    }
}

/// The participant is done (or joins): note when it wants to run again.
static void rest(osal_calendar_t* calendar, uint32_t participant, uint64_t wake_ns)
{
    participant_t* const self = &calendar->participants[participant];
    if (self->state != PARTICIPANT_JOINED) {
        const uint64_t delivered_ns =
            (self->state == PARTICIPANT_EXPECTED) ? self->wake_ns : OSAL_CALENDAR_NEVER;
        self->wake_ns = earlier(wake_ns, delivered_ns);
        self->is_new  = 1U;
        self->incarnation++;
        __atomic_store_n(&self->state, (uint32_t)PARTICIPANT_JOINED, __ATOMIC_RELEASE);
        return;
    }
    FSW_ASSERT(calendar->running == participant); // Only the holder of the grant can be done.
    const uint64_t delivered_ns = pending_wake_ns(calendar, participant);
    const uint64_t asked_ns     = (wake_ns > calendar->now_ns) ? wake_ns : next_slot_ns(calendar);
    self->wake_ns               = earlier(asked_ns, delivered_ns);
    __atomic_store_n(&calendar->running, NOBODY, __ATOMIC_RELEASE);
}

static void leave(osal_calendar_t* calendar, uint32_t participant)
{
    participant_t* const self = &calendar->participants[participant];
    self->state               = PARTICIPANT_ABSENT;
    self->incarnation++;
    self->wake_ns     = OSAL_CALENDAR_NEVER;
    self->messages    = 0U;
    self->octets      = 0U;
    self->stream_port = 0U;
    self->is_new      = 0U;
    if (calendar->running == participant) {
        __atomic_store_n(&calendar->running, NOBODY, __ATOMIC_RELEASE);
    }
}

static void add_saturating(uint32_t* sum, uint32_t more)
{
    *sum = (more < (UINT32_MAX - *sum)) ? (*sum + more) : UINT32_MAX;
}

static void take_grant(osal_calendar_t* calendar, uint32_t participant, osal_grant_t* out_grant)
{
    participant_t* const self = &calendar->participants[participant];
    out_grant->now_ns         = calendar->now_ns;
    out_grant->messages       = self->messages;
    out_grant->octets         = self->octets;
    self->messages            = 0U;
    self->octets              = 0U;
}

// --- Process form: lock and hand-over ------------------------------------------------------------------

static void lock(osal_calendar_t* calendar)
{
    if (calendar->is_shared != 0U) {
        // A holder that died inside leaves a state that can be gone on from: see the top of this file.
        (void)osal_mutex_lock(&calendar->mutex);
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

/// Under the lock: if nobody holds the grant, give it. Returns who is to be woken after the unlock.
static uint32_t pass_on(osal_calendar_t* calendar)
{
    if ((calendar->is_shared != 0U) && (calendar->running == NOBODY)) {
        grant_next(calendar);
        return calendar->running;
    }
    return NOBODY;
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
    calendar->slot_ns   = slot_ns;
    calendar->running   = NOBODY;
    calendar->last      = NOBODY;
    calendar->is_shared = is_shared ? 1U : 0U;
    for (uint32_t i = 0U; i < PARTICIPANTS; i++) {
        calendar->participants[i].wake_ns = OSAL_CALENDAR_NEVER;
    }
    if (is_shared && (osal_mutex_create(&calendar->mutex, true) != STATUS_OK)) {
        return NULL;
    }
    __atomic_store_n(&calendar->magic, CALENDAR_MAGIC, __ATOMIC_RELEASE);
    return calendar;
}

osal_calendar_t* osal_calendar_attach(void* storage)
{
    FSW_ASSERT(storage != NULL);
    osal_calendar_t* const calendar = storage;
    return (__atomic_load_n(&calendar->magic, __ATOMIC_ACQUIRE) == CALENDAR_MAGIC) ? calendar : NULL;
}

void osal_calendar_expect(osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    lock(calendar);
    participant_t* const one = &calendar->participants[participant];
    if (one->state == PARTICIPANT_ABSENT) {
        one->wake_ns = OSAL_CALENDAR_NEVER;
        one->state   = PARTICIPANT_EXPECTED;
    }
    unlock(calendar);
}

void osal_calendar_end(osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    lock(calendar);
    leave(calendar, participant);
    (void)pass_on(calendar);
    const uint32_t running = calendar->running;
    unlock(calendar);
    wake(calendar, participant);
    // Whoever ended may have died after it handed the grant over and before it woke the new holder.
    if (running != NOBODY) {
        wake(calendar, running);
    }
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

status_t osal_calendar_wait(osal_calendar_t* calendar, unsigned participant, uint64_t wake_ns,
                            osal_grant_t* out_grant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (out_grant != NULL));
    FSW_ASSERT(calendar->is_shared != 0U);
    if (osal_calendar_is_closed(calendar)) {
        return STATUS_CLOSED;
    }
    lock(calendar);
    rest(calendar, participant, wake_ns);
    const uint32_t incarnation = calendar->participants[participant].incarnation;
    const uint32_t next        = pass_on(calendar);
    unlock(calendar);
    if ((next != NOBODY) && (next != participant)) {
        wake(calendar, next);
    }
    if (!sleep_until_granted(calendar, participant, incarnation)) {
        return STATUS_CLOSED;
    }
    lock(calendar);
    take_grant(calendar, participant, out_grant);
    unlock(calendar);
    return STATUS_OK;
}

void osal_calendar_done(osal_calendar_t* calendar, unsigned participant, uint64_t wake_ns)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS) && (calendar->is_shared == 0U));
    rest(calendar, participant, wake_ns);
}

status_t osal_calendar_next(osal_calendar_t* calendar, unsigned* out_participant, osal_grant_t* out_grant)
{
    FSW_ASSERT((calendar != NULL) && (out_participant != NULL) && (out_grant != NULL));
    FSW_ASSERT((calendar->is_shared == 0U) && (calendar->running == NOBODY));
    if (calendar->is_closed != 0U) {
        return STATUS_CLOSED;
    }
    if (is_waited_for(calendar)) {
        return STATUS_BUSY;
    }
    grant_next(calendar);
    if (calendar->running == NOBODY) {
        return STATUS_EMPTY;
    }
    *out_participant = calendar->running;
    take_grant(calendar, calendar->running, out_grant);
    return STATUS_OK;
}

void osal_calendar_deliver(osal_calendar_t* calendar, unsigned sender, unsigned receiver, uint32_t messages,
                           uint32_t octets)
{
    FSW_ASSERT((calendar != NULL) && (sender < PARTICIPANTS) && (receiver < PARTICIPANTS));
    lock(calendar);
    participant_t* const one = &calendar->participants[receiver];
    uint32_t next            = NOBODY;
    if (one->state != PARTICIPANT_ABSENT) {
        const bool is_still_now = (receiver > sender) && is_turn_to_come(calendar, receiver);
        add_saturating(&one->messages, messages);
        add_saturating(&one->octets, octets);
        one->wake_ns = earlier(pending_wake_ns(calendar, receiver),
                               is_still_now ? calendar->now_ns : next_slot_ns(calendar));
        next = pass_on(calendar); // Only when all were waiting for a delivery: this one came from outside.
    }
    unlock(calendar);
    if (next != NOBODY) {
        wake(calendar, next);
    }
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
           (uint32_t)PARTICIPANT_JOINED;
}

void osal_calendar_set_stream_port(osal_calendar_t* calendar, unsigned participant, uint16_t port)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    __atomic_store_n(&calendar->participants[participant].stream_port, port, __ATOMIC_RELEASE);
}

uint16_t osal_calendar_stream_port(const osal_calendar_t* calendar, unsigned participant)
{
    FSW_ASSERT((calendar != NULL) && (participant < PARTICIPANTS));
    return (uint16_t)__atomic_load_n(&calendar->participants[participant].stream_port, __ATOMIC_ACQUIRE);
}
