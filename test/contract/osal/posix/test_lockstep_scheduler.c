// SPDX-License-Identifier: Apache-2.0
// The rules of the scheduler when participants end, are killed at any moment, or the run is closed; each
// participant has a process of its own. test_lockstep_scheduler_forms.c shows that all forms give the same
// sequence of grants.
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
/// Deliveries in one grant. With this number, the grant spends most of its time under the lock.
#define DELIVERIES 60U
#define TIMEOUT_NS 20000000000ULL

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
    int exit_status = 0;
    TEST_ASSERT_EQUAL(id, waitpid(id, &exit_status, 0));
    return WIFEXITED(exit_status) ? WEXITSTATUS(exit_status) : -WTERMSIG(exit_status);
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
    void* const storage              = shared_memory(OSAL_LOCKSTEP_OCTETS);
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
    (void)munmap(storage, OSAL_LOCKSTEP_OCTETS);
}

static void delivery_from_outside_wakes_a_sleeping_run(void)
{
    void* const storage              = shared_memory(OSAL_LOCKSTEP_OCTETS);
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    const pid_t sleeper              = child(sleep_for_ever, scheduler, 1U);
    await_presence(scheduler, 1U);
    osal_lockstep_deliver(scheduler, 0U, 1U, OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    TEST_ASSERT_EQUAL(1, exit_code(sleeper)); // The sleeper got the grant.
    (void)munmap(storage, OSAL_LOCKSTEP_OCTETS);
}

typedef struct {
    uint64_t grants[PARTICIPANTS];
    uint64_t last_ns;
    uint32_t inside;
    uint32_t faults;
} record_t;

static record_t* record;

/// Calls the scheduler as often as possible, so that a kill meets it at any point: asleep, inside the lock,
/// or between.
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
    const uint64_t until_ns = osal_clock_monotonic_ns() + TIMEOUT_NS;
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
    void* const storage              = shared_memory(OSAL_LOCKSTEP_OCTETS);
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
        // Kill half of them while they hold the grant.
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
    (void)munmap(storage, OSAL_LOCKSTEP_OCTETS);
}

static void a_loss_that_one_process_notes_is_seen_by_all(void)
{
    static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 1U, true);
    TEST_ASSERT_FALSE(osal_lockstep_is_lossy(scheduler));
    osal_lockstep_note_loss(osal_lockstep_attach(storage));
    TEST_ASSERT_TRUE(osal_lockstep_is_lossy(scheduler));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(close_and_end_release_sleepers);
    RUN_TEST(delivery_from_outside_wakes_a_sleeping_run);
    RUN_TEST(a_kill_at_any_moment_never_stops_time);
    RUN_TEST(a_loss_that_one_process_notes_is_seen_by_all);
    return UNITY_END();
}
