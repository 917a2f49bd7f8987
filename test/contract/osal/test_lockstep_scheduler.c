// SPDX-License-Identifier: Apache-2.0
// The rules of the scheduler one by one, and the invariants when participants end, are killed at any moment,
// or the run is closed. test_lockstep_scheduler_forms.c shows that all forms give one sequence.
#define _GNU_SOURCE
#include "osal/include/osal/lockstep_scheduler.h"

#include "osal/include/osal/clock.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define STEP_NS 500U
#define PARTICIPANTS 6U
#define DELIVERIES 60U ///< In one grant: most of its time then passes under the lock.
#define PATIENCE_NS 20000000000ULL

void setUp(void)
{
}

void tearDown(void)
{
}

static uint64_t scramble(uint64_t value)
{
    value += 0x9E3779B97F4A7C15ULL;
    value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    value = (value ^ (value >> 27U)) * 0x94D049BB133111EBULL;
    return value ^ (value >> 31U);
}

static void* shared_memory(size_t size)
{
    void* const memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(memory != MAP_FAILED);
    return memory;
}

// ---- Single rules ----

static uint64_t table_storage[OSAL_LOCKSTEP_BYTES / 8U] __attribute__((aligned(64)));

static osal_lockstep_t* table(unsigned participants)
{
    osal_lockstep_t* const scheduler = osal_lockstep_create(table_storage, STEP_NS, false);
    for (unsigned i = 0U; i < participants; i++) {
        osal_lockstep_done(scheduler, i, 0U);
    }
    return scheduler;
}

static osal_grant_t next_is(osal_lockstep_t* scheduler, unsigned expected, uint64_t now_ns)
{
    unsigned participant = UINT32_MAX;
    osal_grant_t grant   = {0U, 0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(expected, participant);
    TEST_ASSERT_EQUAL_UINT64(now_ns, grant.now_ns);
    TEST_ASSERT_EQUAL_UINT64(now_ns, osal_lockstep_now_ns(scheduler));
    return grant;
}

static void without_a_wake_time_next_is_empty(void)
{
    unsigned participant = 0U;
    osal_grant_t grant;
    osal_lockstep_t* const scheduler = table(0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_done(scheduler, 3U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_TRUE(osal_lockstep_is_present(scheduler, 3U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_close(scheduler);
    TEST_ASSERT_TRUE(osal_lockstep_is_closed(scheduler));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_lockstep_next(scheduler, &participant, &grant));
}

static void delivery_wakes_later_participants_now_and_earlier_ones_in_the_next_time_step(void)
{
    osal_lockstep_t* const scheduler = table(3U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 0U);
    osal_lockstep_deliver(scheduler, 1U, 2U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 7U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 5U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_grant_t grant = next_is(scheduler, 2U, 0U);
    TEST_ASSERT_EQUAL_UINT32(1U, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(7U, grant.octets);
    osal_lockstep_deliver(scheduler, 2U, 2U, OSAL_LOCKSTEP_ANY_LIFE, 1U,
                          0U); // To itself: in the next time step, before its requested wake time.
    osal_lockstep_done(scheduler, 2U, 10U * STEP_NS);
    grant = next_is(scheduler, 0U, STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(3U, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(5U, grant.octets);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    grant = next_is(scheduler, 2U, STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(1U, grant.messages);
    osal_lockstep_done(scheduler, 2U, 10U * STEP_NS);
    grant = next_is(scheduler, 2U, 10U * STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(0U, grant.messages);
}

static void next_time_step_is_on_the_grid_when_now_is_not(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 2U * STEP_NS + 123U);
    (void)next_is(scheduler, 1U, 2U * STEP_NS + 123U);
    osal_lockstep_deliver(scheduler, 1U, 0U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 1U); // Long past.
    (void)next_is(scheduler, 0U, 3U * STEP_NS);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 1U, 3U * STEP_NS);
}

static void expected_participant_holds_time_until_it_joins_or_ends(void)
{
    unsigned participant = 0U;
    osal_grant_t grant;
    osal_lockstep_t* const scheduler = table(2U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U); // Present: no effect.
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_expect(scheduler, 5U, 1U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 5U, OSAL_LOCKSTEP_ANY_LIFE, 4U, 0U);
    osal_lockstep_done(scheduler, 0U, STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_FALSE(osal_lockstep_is_present(scheduler, 5U));
    osal_lockstep_done(scheduler, 5U, 7U * STEP_NS);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_EQUAL_UINT32(4U, next_is(scheduler, 5U, 0U).messages);
    osal_lockstep_expect(scheduler, 6U, 1U, 0U);
    osal_lockstep_done(scheduler, 5U, 7U * STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    osal_lockstep_end(scheduler, 6U, OSAL_LOCKSTEP_ANY_LIFE);
    (void)next_is(scheduler, 0U, STEP_NS);
}

static void deliveries_to_absent_or_ended_participants_are_dropped(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 9U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 1U);
    osal_lockstep_set_stream_port(scheduler, 1U, 4711U);
    TEST_ASSERT_EQUAL_UINT16(4711U, osal_lockstep_stream_port(scheduler, 1U));
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 3U, 3U);
    osal_lockstep_end(scheduler, 1U, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_FALSE(osal_lockstep_is_present(scheduler, 1U));
    TEST_ASSERT_EQUAL_UINT16(0U, osal_lockstep_stream_port(scheduler, 1U));
    osal_lockstep_done(scheduler, 1U, 0U); // Joins again.
    osal_lockstep_done(scheduler, 9U, 0U);
    osal_lockstep_end(scheduler, 0U, OSAL_LOCKSTEP_ANY_LIFE); // While it holds the grant.
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(scheduler, 1U, 0U).messages);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_EQUAL_UINT32(0U, next_is(scheduler, 9U, 0U).messages);
}

static void late_joiner_of_a_lower_order_waits_for_the_next_time_step(void)
{
    osal_lockstep_t* const scheduler = table(0U);
    osal_lockstep_done(scheduler, 4U, 0U);
    (void)next_is(scheduler, 4U, 0U);
    osal_lockstep_done(scheduler, 2U, 0U);
    osal_lockstep_done(scheduler, 7U, 0U);
    osal_lockstep_done(scheduler, 4U, STEP_NS);
    (void)next_is(scheduler, 7U, 0U);
    osal_lockstep_done(scheduler, 7U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 2U, STEP_NS);
}

static void counts_saturate(void)
{
    osal_lockstep_t* const scheduler = table(2U);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, UINT32_MAX, UINT32_MAX - 1U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 1U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER);
    const osal_grant_t grant = next_is(scheduler, 1U, 0U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, grant.messages);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, grant.octets);
}

static void end_of_time_is_not_passed(void)
{
    osal_lockstep_t* const scheduler = table(1U);
    unsigned participant             = 0U;
    osal_grant_t grant;
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, OSAL_LOCKSTEP_NEVER - 1U);
    (void)next_is(scheduler, 0U, OSAL_LOCKSTEP_NEVER - 1U);
    osal_lockstep_done(scheduler, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_lockstep_next(scheduler, &participant, &grant));
}

static void a_hold_is_seen_by_all_and_ended_by_anyone(void)
{
    static uint64_t storage[OSAL_LOCKSTEP_BYTES / 8U] __attribute__((aligned(64)));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 1U, true);
    osal_lockstep_t* const other     = osal_lockstep_attach(storage);
    TEST_ASSERT_FALSE(osal_lockstep_is_held(scheduler));
    osal_lockstep_hold(scheduler, true);
    TEST_ASSERT_TRUE(osal_lockstep_is_held(other));
    osal_lockstep_hold(other, false);
    TEST_ASSERT_FALSE(osal_lockstep_is_held(scheduler));
}

static void attach_needs_a_scheduler(void)
{
    static uint64_t storage[OSAL_LOCKSTEP_BYTES / 8U] __attribute__((aligned(64)));
    TEST_ASSERT_NULL(osal_lockstep_attach(storage));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 1U, true);
    TEST_ASSERT_NOT_NULL(scheduler);
    TEST_ASSERT_EQUAL_PTR(scheduler, osal_lockstep_attach(storage));
}

// ---- Death and end with processes ----

static pid_t child(void (*entry)(osal_lockstep_t* scheduler, unsigned participant),
                   osal_lockstep_t* scheduler, unsigned participant)
{
    const pid_t id = fork();
    TEST_ASSERT_TRUE(id >= 0);
    if (id == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        entry(scheduler, participant);
        _exit(9);
    }
    return id;
}

static int exit_code(pid_t id)
{
    int how = 0;
    TEST_ASSERT_EQUAL(id, waitpid(id, &how, 0));
    return WIFEXITED(how) ? WEXITSTATUS(how) : -WTERMSIG(how);
}

static void sleep_for_ever(osal_lockstep_t* scheduler, unsigned participant)
{
    osal_grant_t grant;
    _exit((osal_lockstep_wait(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE, OSAL_LOCKSTEP_NEVER, &grant) ==
           STATUS_CLOSED)
              ? 42
              : 1);
}

static void await_presence(const osal_lockstep_t* scheduler, unsigned participant)
{
    for (int i = 0; (i < 5000) && !osal_lockstep_is_present(scheduler, participant); i++) {
        (void)usleep(1000U);
    }
    TEST_ASSERT_TRUE(osal_lockstep_is_present(scheduler, participant));
}

static void close_and_end_release_sleepers(void)
{
    void* const storage              = shared_memory(OSAL_LOCKSTEP_BYTES);
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    const pid_t ended                = child(sleep_for_ever, scheduler, 1U);
    const pid_t closed               = child(sleep_for_ever, scheduler, 2U);
    osal_grant_t grant;
    await_presence(scheduler, 1U);
    await_presence(scheduler, 2U);
    osal_lockstep_end(scheduler, 1U, OSAL_LOCKSTEP_ANY_LIFE);
    TEST_ASSERT_EQUAL(42, exit_code(ended));
    osal_lockstep_close(scheduler);
    TEST_ASSERT_EQUAL(42, exit_code(closed));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_lockstep_wait(scheduler, 3U, OSAL_LOCKSTEP_ANY_LIFE, 0U, &grant));
    (void)munmap(storage, OSAL_LOCKSTEP_BYTES);
}

static void delivery_from_outside_wakes_a_sleeping_run(void)
{
    void* const storage              = shared_memory(OSAL_LOCKSTEP_BYTES);
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    const pid_t sleeper              = child(sleep_for_ever, scheduler, 1U);
    await_presence(scheduler, 1U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    TEST_ASSERT_EQUAL(1, exit_code(sleeper)); // It got the grant.
    (void)munmap(storage, OSAL_LOCKSTEP_BYTES);
}

typedef struct {
    uint64_t grants[PARTICIPANTS];
    uint64_t last_ns;
    uint32_t inside;
    uint32_t faults;
} record_t;

static record_t* record;

/// Calls the scheduler as often as possible, so that a kill finds it anywhere: asleep, in the lock, between.
static void hammer(osal_lockstep_t* scheduler, unsigned participant)
{
    osal_grant_t grant;
    uint64_t wake_ns = 0U;
    while (osal_lockstep_wait(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE, wake_ns, &grant) == STATUS_OK) {
        record->inside = participant;
        if (grant.now_ns < record->last_ns) {
            record->faults++;
        }
        record->last_ns = grant.now_ns;
        for (unsigned i = 0U; i < DELIVERIES; i++) {
            osal_lockstep_deliver(scheduler, participant, i % PARTICIPANTS, OSAL_LOCKSTEP_ANY_LIFE, 1U, 1U);
        }
        wake_ns = grant.now_ns + STEP_NS;
        record->grants[participant]++;
        if (record->inside != participant) {
            record->faults++;
        }
    }
    _exit(0);
}

/// True when every participant has been granted after this call began.
static bool goes_on(void)
{
    uint64_t before[PARTICIPANTS];
    memcpy(before, record->grants, sizeof before);
    const uint64_t until_ns = osal_clock_monotonic_ns() + PATIENCE_NS;
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        while (__atomic_load_n(&record->grants[i], __ATOMIC_ACQUIRE) == before[i]) {
            if (osal_clock_monotonic_ns() > until_ns) {
                return false;
            }
            (void)usleep(200U);
        }
    }
    return true;
}

static void a_kill_at_any_moment_never_stops_time(void)
{
    void* const storage              = shared_memory(OSAL_LOCKSTEP_BYTES);
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    pid_t ids[PARTICIPANTS];
    bool is_going = true;
    record        = shared_memory(sizeof *record);
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        osal_lockstep_expect(scheduler, i, 1U, 0U);
    }
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        ids[i] = child(hammer, scheduler, i);
    }
    for (uint64_t round = 0U; (round < 1500U) && is_going; round++) {
        const uint64_t dice = scramble(round);
        (void)usleep((useconds_t)((dice >> 8U) % 1000U));
        // Half of them while they hold the grant.
        const unsigned running = __atomic_load_n(&record->inside, __ATOMIC_RELAXED);
        const unsigned victim  = ((dice % 2U) == 0U) ? running : (unsigned)(scramble(dice) % PARTICIPANTS);
        (void)kill(ids[victim], SIGKILL);
        (void)exit_code(ids[victim]);
        osal_lockstep_end(scheduler, victim, OSAL_LOCKSTEP_ANY_LIFE);
        if (((dice >> 32U) % 2U) == 0U) {
            osal_lockstep_expect(scheduler, victim, 1U, 0U);
        }
        ids[victim] = child(hammer, scheduler, victim);
        is_going    = ((round % 20U) != 0U) || goes_on();
    }
    is_going = is_going && goes_on();
    osal_lockstep_close(scheduler);
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        if (!is_going) {
            (void)kill(ids[i], SIGKILL);
        }
        (void)exit_code(ids[i]);
    }
    TEST_ASSERT_TRUE(is_going);
    TEST_ASSERT_EQUAL_UINT32(0U, record->faults);
    (void)munmap(record, sizeof *record);
    (void)munmap(storage, OSAL_LOCKSTEP_BYTES);
}

// Deliveries not reported to the ended life go to the next one; no participant is granted in between, and
// time waits for it.
static void a_succession_is_one_operation(void)
{
    unsigned participant             = UINT32_MAX;
    uint32_t life                    = 0U;
    osal_grant_t grant               = {0U, 0U, 0U};
    osal_lockstep_t* const scheduler = table(1U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, 0U);
    osal_lockstep_set_succession(scheduler, 1U, 10U * STEP_NS);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_done(scheduler, 0U, STEP_NS);
    (void)next_is(scheduler, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    (void)next_is(scheduler, 0U, STEP_NS);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 2U, 0U);
    osal_lockstep_kill(scheduler, 1U, 1U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_EXPECTED, osal_lockstep_presence(scheduler, 1U, &life));
    TEST_ASSERT_EQUAL_UINT32(2U, life);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 3U, 0U);
    osal_lockstep_end(scheduler, 1U, 1U); // Its process was seen to die: known already.
    osal_lockstep_done(scheduler, 0U, 20U * STEP_NS);
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
    TEST_ASSERT_EQUAL_UINT(1U, participant);
    osal_lockstep_done(scheduler, 1U, 0U);
    grant = next_is(scheduler, 1U, 11U * STEP_NS);
    TEST_ASSERT_EQUAL_UINT32(5U, grant.messages);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_lockstep_set_succession(scheduler, 1U, 0U); // From here on an end counts.
    (void)next_is(scheduler, 0U, 20U * STEP_NS);
    osal_lockstep_kill(scheduler, 1U, 2U);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, osal_lockstep_presence(scheduler, 1U, &life));
}

static void a_succession_that_is_given_up_ends_when_it_would_begin(void)
{
    uint32_t life                    = 0U;
    osal_lockstep_t* const scheduler = table(1U);
    osal_lockstep_expect(scheduler, 1U, 1U, 0U);
    osal_lockstep_done(scheduler, 1U, OSAL_LOCKSTEP_NEVER);
    osal_lockstep_set_succession(scheduler, 1U, 10U * STEP_NS);
    (void)next_is(scheduler, 0U, 0U);
    osal_lockstep_kill(scheduler, 1U, 1U);
    osal_lockstep_set_succession(scheduler, 1U, 0U);
    osal_lockstep_end(scheduler, 1U, 2U);
    osal_lockstep_done(scheduler, 0U, 20U * STEP_NS);
    (void)next_is(scheduler, 0U, 20U * STEP_NS);
    TEST_ASSERT_EQUAL(OSAL_LOCKSTEP_ABSENT, osal_lockstep_presence(scheduler, 1U, &life));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(without_a_wake_time_next_is_empty);
    RUN_TEST(delivery_wakes_later_participants_now_and_earlier_ones_in_the_next_time_step);
    RUN_TEST(next_time_step_is_on_the_grid_when_now_is_not);
    RUN_TEST(expected_participant_holds_time_until_it_joins_or_ends);
    RUN_TEST(deliveries_to_absent_or_ended_participants_are_dropped);
    RUN_TEST(late_joiner_of_a_lower_order_waits_for_the_next_time_step);
    RUN_TEST(counts_saturate);
    RUN_TEST(end_of_time_is_not_passed);
    RUN_TEST(a_hold_is_seen_by_all_and_ended_by_anyone);
    RUN_TEST(attach_needs_a_scheduler);
    RUN_TEST(a_succession_is_one_operation);
    RUN_TEST(a_succession_that_is_given_up_ends_when_it_would_begin);
    RUN_TEST(close_and_end_release_sleepers);
    RUN_TEST(delivery_from_outside_wakes_a_sleeping_run);
    RUN_TEST(a_kill_at_any_moment_never_stops_time);
    return UNITY_END();
}
