// SPDX-License-Identifier: Apache-2.0
// The same random actions of participants are run three times: by a plain model of the rules in this file, by
// the scheduler with one process for all participants, and by the scheduler with a process for each. The
// three sequences of grants must be the same.
#define _GNU_SOURCE
#include "osal/include/osal/lockstep_scheduler.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define STEP_NS 500U
#define PARTICIPANTS 6U
#define TRACE_MAX 600U
#define DELIVERIES_MAX 3U

typedef struct {
    uint32_t participant;
    uint32_t messages;
    uint32_t octets;
    uint64_t now_ns;
} step_t;

typedef struct { // Shared by the processes of a run. Written only within a grant.
    uint32_t length;
    uint32_t is_gone[PARTICIPANTS]; ///< The participant has ended, and may be started again.
    step_t steps[TRACE_MAX];
} trace_t;

typedef struct {
    uint64_t wake_ns;
    unsigned delivery_count;
    struct {
        unsigned receiver;
        uint32_t messages;
        uint32_t octets;
    } deliveries[DELIVERIES_MAX];
    bool is_end;
    unsigned restarted; ///< Participant that is started again; 0: none.
} decision_t;

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

static uint64_t wake_for(uint64_t dice, unsigned participant, uint64_t now_ns)
{
    switch (dice % 8U) {
    case 0U:
        return 0U;
    case 1U:
        return now_ns;
    case 2U:
        return now_ns + (dice % 3000U); // This time is not a multiple of the time step.
    case 3U:
        return (participant == 0U) ? (now_ns + STEP_NS) : OSAL_LOCKSTEP_NEVER;
    default:
        return (((now_ns / STEP_NS) + 1U + (dice % 3U)) * STEP_NS);
    }
}

/// The actions of a participant in a grant depend only on what the grant reports.
static decision_t decide(uint64_t seed, const trace_t* trace, unsigned participant, const osal_grant_t* grant)
{
    uint64_t dice           = scramble(seed ^ ((uint64_t)participant << 56U) ^ grant->now_ns);
    dice                    = scramble(dice ^ ((uint64_t)grant->messages << 32U) ^ grant->octets);
    dice                    = scramble(dice ^ trace->length);
    decision_t decision     = {.wake_ns = wake_for(dice >> 8U, participant, grant->now_ns)};
    decision.delivery_count = (unsigned)((dice >> 16U) % (DELIVERIES_MAX + 1U));
    for (unsigned i = 0U; i < decision.delivery_count; i++) {
        dice                            = scramble(dice);
        decision.deliveries[i].receiver = (unsigned)(dice % PARTICIPANTS);
        decision.deliveries[i].messages = (uint32_t)((dice >> 8U) % 3U);
        decision.deliveries[i].octets   = (uint32_t)((dice >> 16U) % 100U);
    }
    dice            = scramble(dice);
    decision.is_end = (participant != 0U) && ((dice % 29U) == 0U);
    if (participant == 0U) {
        const unsigned candidate = 1U + (unsigned)((dice >> 8U) % (PARTICIPANTS - 1U));
        decision.restarted       = (trace->is_gone[candidate] != 0U) ? candidate : 0U;
    }
    return decision;
}

static uint64_t first_wake(uint64_t seed, unsigned participant)
{
    return (scramble(seed + participant) % 5U) * STEP_NS;
}

static void note(trace_t* trace, unsigned participant, const osal_grant_t* grant)
{
    trace->steps[trace->length] = (step_t){participant, grant->messages, grant->octets, grant->now_ns};
    trace->length++;
}

// ---- The rules as a plain model ----

typedef struct {
    bool is_here;
    bool is_counting; ///< The participant is expected or has joined.
    bool is_joining;
    uint64_t asked_ns;
    uint64_t called_ns; ///< Time at which a delivery wakes the participant.
    uint32_t messages;
    uint32_t octets;
} slot_t;

typedef struct {
    slot_t slots[PARTICIPANTS];
    uint64_t now_ns;
    int last;
} model_t;

static uint64_t model_slot_after(uint64_t now_ns)
{
    uint64_t step_ns = 0U;
    while (step_ns <= now_ns) {
        step_ns += STEP_NS;
    }
    return step_ns;
}

static void model_join(model_t* model, unsigned participant, uint64_t wake_ns)
{
    slot_t* const slot = &model->slots[participant];
    slot->is_here      = true;
    slot->is_joining   = true;
    slot->asked_ns     = wake_ns;
}

static void model_expect(model_t* model, unsigned participant)
{
    model->slots[participant] =
        (slot_t){.is_counting = true, .asked_ns = OSAL_LOCKSTEP_NEVER, .called_ns = OSAL_LOCKSTEP_NEVER};
}

static void model_deliver(model_t* model, unsigned sender, unsigned receiver, uint32_t messages,
                          uint32_t octets)
{
    slot_t* const slot     = &model->slots[receiver];
    const uint64_t call_ns = (receiver > sender) ? model->now_ns : model_slot_after(model->now_ns);
    if (slot->is_counting) {
        slot->messages += messages;
        slot->octets += octets;
        slot->called_ns = (call_ns < slot->called_ns) ? call_ns : slot->called_ns;
    }
}

static unsigned model_next(model_t* model, osal_grant_t* out_grant)
{
    int best         = -1;
    uint64_t best_ns = OSAL_LOCKSTEP_NEVER;
    for (int i = 0; i < (int)PARTICIPANTS; i++) {
        slot_t* const slot = &model->slots[i];
        uint64_t wake_ns   = (slot->asked_ns < slot->called_ns) ? slot->asked_ns : slot->called_ns;
        if (slot->is_joining && (wake_ns <= model->now_ns)) {
            wake_ns         = (i > model->last) ? model->now_ns : model_slot_after(model->now_ns);
            slot->asked_ns  = wake_ns;
            slot->called_ns = OSAL_LOCKSTEP_NEVER;
        }
        slot->is_joining = false;
        if (slot->is_here && (wake_ns < best_ns)) {
            best    = i;
            best_ns = wake_ns;
        }
    }
    TEST_ASSERT_TRUE(best >= 0);
    slot_t* const slot = &model->slots[best];
    model->now_ns      = best_ns;
    model->last        = best;
    *out_grant         = (osal_grant_t){best_ns, slot->messages, slot->octets};
    slot->messages     = 0U;
    slot->octets       = 0U;
    slot->called_ns    = OSAL_LOCKSTEP_NEVER;
    return (unsigned)best;
}

static void run_model(uint64_t seed, uint32_t length, trace_t* trace)
{
    model_t model = {.last = -1};
    osal_grant_t grant;
    memset(trace, 0, sizeof *trace);
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        model_expect(&model, i);
        model_join(&model, i, first_wake(seed, i));
    }
    while (trace->length < length) {
        const unsigned participant = model_next(&model, &grant);
        note(trace, participant, &grant);
        const decision_t decision = decide(seed, trace, participant, &grant);
        for (unsigned i = 0U; i < decision.delivery_count; i++) {
            model_deliver(&model, participant, decision.deliveries[i].receiver,
                          decision.deliveries[i].messages, decision.deliveries[i].octets);
        }
        if (decision.restarted != 0U) {
            trace->is_gone[decision.restarted] = 0U;
            model_expect(&model, decision.restarted);
            model_join(&model, decision.restarted, first_wake(seed, decision.restarted));
        }
        if (decision.is_end) {
            trace->is_gone[participant] = 1U;
            model.slots[participant] =
                (slot_t){.asked_ns = OSAL_LOCKSTEP_NEVER, .called_ns = OSAL_LOCKSTEP_NEVER};
        } else {
            const bool is_later               = (decision.wake_ns > model.now_ns);
            model.slots[participant].asked_ns = is_later ? decision.wake_ns : model_slot_after(model.now_ns);
        }
    }
}

// ---- The scheduler with one process for all participants ----

static void act(osal_lockstep_t* scheduler, unsigned participant, const decision_t* decision)
{
    for (unsigned i = 0U; i < decision->delivery_count; i++) {
        osal_lockstep_deliver(scheduler, participant, decision->deliveries[i].receiver,
                              OSAL_LOCKSTEP_ANY_LIFE, decision->deliveries[i].messages,
                              decision->deliveries[i].octets);
    }
    if (decision->restarted != 0U) {
        osal_lockstep_expect(scheduler, decision->restarted, 1U, 0U);
    }
}

static void run_single(uint64_t seed, uint32_t length, trace_t* trace)
{
    static uint64_t storage[OSAL_LOCKSTEP_OCTETS / 8U] __attribute__((aligned(64)));
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, false);
    osal_grant_t grant;
    unsigned participant = 0U;
    memset(trace, 0, sizeof *trace);
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        osal_lockstep_expect(scheduler, i, 1U, 0U);
    }
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, osal_lockstep_next(scheduler, &participant, &grant));
        osal_lockstep_done(scheduler, PARTICIPANTS - 1U - i, first_wake(seed, PARTICIPANTS - 1U - i));
    }
    while (trace->length < length) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_lockstep_next(scheduler, &participant, &grant));
        note(trace, participant, &grant);
        const decision_t decision = decide(seed, trace, participant, &grant);
        act(scheduler, participant, &decision);
        if (decision.restarted != 0U) {
            trace->is_gone[decision.restarted] = 0U;
            osal_lockstep_done(scheduler, decision.restarted, first_wake(seed, decision.restarted));
        }
        if (decision.is_end) {
            trace->is_gone[participant] = 1U;
            osal_lockstep_end(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
        } else {
            osal_lockstep_done(scheduler, participant, decision.wake_ns);
        }
    }
}

// ---- The scheduler with a process per participant ----

static void* shared_memory(size_t size)
{
    void* const memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(memory != MAP_FAILED);
    return memory;
}

static void run_participant(uint64_t seed, uint32_t length, trace_t* trace, osal_lockstep_t* scheduler,
                            unsigned participant, int launcher)
{
    uint64_t wake_ns = first_wake(seed, participant);
    osal_grant_t grant;
    // The participants join in any order of wall-clock time.
    (void)usleep((useconds_t)(scramble((uint64_t)getpid()) % 400U));
    while (osal_lockstep_wait(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE, wake_ns, &grant) == STATUS_OK) {
        if (trace->length == length) {
            osal_lockstep_close(scheduler);
            break;
        }
        note(trace, participant, &grant);
        const decision_t decision = decide(seed, trace, participant, &grant);
        act(scheduler, participant, &decision);
        if (decision.restarted != 0U) {
            const uint8_t order                = (uint8_t)decision.restarted;
            trace->is_gone[decision.restarted] = 0U;
            if (write(launcher, &order, 1U) != 1) {
                _exit(1);
            }
        }
        if (decision.is_end) {
            trace->is_gone[participant] = 1U;
            osal_lockstep_end(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
            _exit(0);
        }
        wake_ns = decision.wake_ns;
    }
    _exit(0);
}

static void run_processes(uint64_t seed, uint32_t length, trace_t* trace)
{
    void* const storage              = shared_memory(OSAL_LOCKSTEP_OCTETS);
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, STEP_NS, true);
    int request[2];
    TEST_ASSERT_EQUAL(0, pipe(request));
    memset(trace, 0, sizeof *trace);
    uint8_t order = 0U;
    for (unsigned i = 0U; i < PARTICIPANTS; i++) {
        osal_lockstep_expect(scheduler, i, 1U, 0U);
    }
    // The first six starts are ordered like every restart.
    for (order = 0U; order < PARTICIPANTS; order++) {
        TEST_ASSERT_EQUAL(1, write(request[1], &order, 1U));
    }
    for (int started = 1; read(request[0], &order, 1U) == 1; started++) {
        if (fork() == 0) {
            (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
            (void)close(request[0]);
            if (order != 0U) {
                (void)close(request[1]); // Only participant 0 orders restarts: when it ends, the pipe ends.
            }
            run_participant(seed, length, trace, scheduler, order, request[1]);
        }
        if (started == (int)PARTICIPANTS) {
            (void)close(request[1]);
        }
    }
    (void)close(request[0]);
    while (wait(NULL) > 0) {
        // Wait for all participants.
    }
    (void)munmap(storage, OSAL_LOCKSTEP_OCTETS);
}

static void assert_same(const trace_t* expected, const trace_t* actual, uint64_t seed)
{
    char text[64];
    TEST_ASSERT_EQUAL_UINT32(expected->length, actual->length);
    for (uint32_t i = 0U; i < expected->length; i++) {
        (void)snprintf(text, sizeof text, "seed %llu step %u", (unsigned long long)seed, i);
        TEST_ASSERT_EQUAL_UINT64_MESSAGE(expected->steps[i].now_ns, actual->steps[i].now_ns, text);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected->steps[i].participant, actual->steps[i].participant, text);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected->steps[i].messages, actual->steps[i].messages, text);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected->steps[i].octets, actual->steps[i].octets, text);
    }
}

static void one_process_gives_the_sequence_of_the_model(void)
{
    static trace_t model;
    static trace_t single;
    for (uint64_t seed = 1U; seed <= 500U; seed++) {
        run_model(seed, TRACE_MAX, &model);
        run_single(seed, TRACE_MAX, &single);
        assert_same(&model, &single, seed);
    }
}

static void several_processes_give_the_sequence_of_one_process(void)
{
    static trace_t single;
    trace_t* const processes = shared_memory(sizeof(trace_t));
    for (uint64_t seed = 1U; seed <= 25U; seed++) {
        run_single(seed, TRACE_MAX, &single);
        run_processes(seed, TRACE_MAX, processes);
        assert_same(&single, processes, seed);
    }
    (void)munmap(processes, sizeof(trace_t));
}

static void time_never_goes_back_and_participants_of_an_instant_are_granted_in_order(void)
{
    static trace_t trace;
    uint32_t ends = 0U;
    for (uint64_t seed = 1000U; seed < 1100U; seed++) {
        run_single(seed, TRACE_MAX, &trace);
        for (uint32_t i = 1U; i < trace.length; i++) {
            const step_t* const before = &trace.steps[i - 1U];
            const step_t* const step   = &trace.steps[i];
            TEST_ASSERT_TRUE(step->now_ns >= before->now_ns);
            TEST_ASSERT_TRUE((step->now_ns > before->now_ns) || (step->participant > before->participant));
        }
        ends += trace.is_gone[1];
    }
    TEST_ASSERT_TRUE(ends > 0U); // The random actions contain ends of participants.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(one_process_gives_the_sequence_of_the_model);
    RUN_TEST(time_never_goes_back_and_participants_of_an_instant_are_granted_in_order);
    RUN_TEST(several_processes_give_the_sequence_of_one_process);
    return UNITY_END();
}
