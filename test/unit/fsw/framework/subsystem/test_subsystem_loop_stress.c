// SPDX-License-Identifier: Apache-2.0
// Loops run in tasks of their own while the component receives commands all the time. No report contains a
// partly updated structure, and each request is answered, or refused because a queue is full.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "osal/include/osal/task.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "test/support/consistent_parameter.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#define LOOPS 2U
#define ROUNDS 40000U
#define ROUND_NS 500000ULL
#define QUIET_ROUNDS 1000U ///< Last rounds, without commands: all answers arrive before the test ends.
#define STRUCTURE 101U     ///< Structure of SLOW that samples VALUES twice in 4 cycles.
#define FAST_STRUCTURE 102U

// Hexadecimal digits of a line.
#define VALUES_DIGITS 40U ///< VALUES: an INT32 and two DOUBLE.
#define ID_DIGITS 8U      ///< Identifier of a parameter.

typedef struct {
    uint8_t loop;
    osal_task_t task;
    uint32_t steps;
} looper_t;

static looper_t loopers[LOOPS];
static uint64_t present_ns; // Atomic: the tasks read it as the time.
static uint32_t is_over;
static uint32_t seed;
static uint32_t reports;
static uint32_t asked;    // Requests TC[17,1].
static uint32_t answered; // Reports TM[17,2], and refusals with PUS_FAILURE_TABLE_FULL (0205).
static uint32_t values;   // Reports TM[20,2].

void setUp(void)
{
    static const char loops[] = "<Loop name='SLOW' samplingTime='2ms' priority='5'/>"
                                "<Loop name='FAST' samplingTime='500us' priority='20'/>"
                                "<HKService id='101' interval='4' loop='SLOW'>"
                                "<SampledNREPTimes nrep='2'><ParamRef name='VALUES'/></SampledNREPTimes>"
                                "</HKService>"
                                "<HKService id='102' interval='1' loop='FAST'>"
                                "<SampledOnce><ParamRef name='VALUES'/></SampledOnce></HKService>";
    static char xml[8192];
    const char* const whole = fixture_descriptor();
    const char* const at    = strstr(whole, "<HKService id='100'");
    TEST_ASSERT_NOT_NULL(at);
    (void)snprintf(xml, sizeof xml, "%.*s%s%s", (int)(at - whole), whole, loops, at);
    fixture_open(xml);
    fixture.subsystem.config.has_loop_tasks = true;
}

void tearDown(void)
{
    fixture_close();
}

static void run_loop(void* context)
{
    looper_t* const self       = context;
    const struct timespec rest = {0, 30000};
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        (void)subsystem_loop_step(&fixture.subsystem, self->loop,
                                  __atomic_load_n(&present_ns, __ATOMIC_ACQUIRE));
        (void)subsystem_loop_priority(&fixture.subsystem, self->loop);
        (void)__atomic_add_fetch(&self->steps, 1U, __ATOMIC_ACQ_REL);
        (void)nanosleep(&rest, NULL);
    }
}

/// All three values of the structure have the same number.
static void update(void)
{
    parameter_lock(subsystem_dictionary(&fixture.subsystem));
    fixture.values.state++;
    fixture.values.position[0] = (double)fixture.values.state;
    fixture.values.position[1] = (double)fixture.values.state;
    parameter_unlock(subsystem_dictionary(&fixture.subsystem));
}

static void check_sample(const char* hex)
{
    char digits[17] = "";
    unsigned state  = 0U;
    for (unsigned i = 0U; i < 2U; i++) {
        union {
            unsigned long long bits;
            double number;
        } position;
        (void)memcpy(digits, &hex[8U + (16U * i)], 16U);
        TEST_ASSERT_EQUAL(1, sscanf(digits, "%16llX", &position.bits));
        TEST_ASSERT_EQUAL(1, sscanf(hex, "%8X", &state));
        const bool is_initial = (state == 0U) && (position.number == (double)(i + 1U));
        if (!is_initial) { // 1 and 2 are the initial values of the descriptor.
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE((double)state, position.number, hex);
        }
    }
}

static void check_reports(void)
{
    const char* const lines = fixture_look();
    answered += fixture_count(lines, "17.2 ") + fixture_count(lines, " 0205 ");
    for (const char* at = strstr(lines, "20.2 0001"); at != NULL; at = strstr(&at[1], "20.2 0001")) {
        check_sample(&at[strlen("20.2 0001") + ID_DIGITS]);
        values++;
    }
    for (const char* at = strstr(lines, "3.25 006"); at != NULL; at = strstr(&at[1], "3.25 006")) {
        if (strncmp(at, "3.25 0065", 9U) == 0) {
            check_sample(&at[9]);
            check_sample(&at[9U + VALUES_DIGITS]);
            reports++;
        } else if (strncmp(at, "3.25 0066", 9U) == 0) {
            check_sample(&at[9]);
            reports++;
        } else {
            // A structure that the component's own loop samples.
        }
    }
}

static unsigned chance(unsigned below)
{
    seed = (seed * 1664525U) + 1013904223U;
    return (seed >> 16U) % below;
}

static void housekeeping(uint8_t subtype)
{
    const uint8_t data[5] = {2U, 0U, STRUCTURE, 0U, FAST_STRUCTURE};
    (void)fixture_command(3U, subtype, data, sizeof data);
}

/// Send TC[20,1] for VALUES and TC[17,1].
static void ask(void)
{
    const uint8_t id[] = {1U, (uint8_t)(fixture_values_id >> 24U), (uint8_t)(fixture_values_id >> 16U),
                          (uint8_t)(fixture_values_id >> 8U), (uint8_t)fixture_values_id};
    (void)fixture_command(20U, 1U, id, sizeof id);
    (void)fixture_command(17U, 1U, NULL, 0U);
    asked++;
}

static void command(void)
{
    const uint8_t interval[] = {1U, 0U, STRUCTURE, 0U, 0U, 0U, (uint8_t)(2U + chance(6U))};
    switch (chance(24U)) {
    case 0U:
        housekeeping(6U);
        break;
    case 1U:
    case 2U:
        housekeeping(5U);
        break;
    case 3U:
        housekeeping(27U);
        break;
    case 4U:
        (void)fixture_command(3U, 31U, interval, sizeof interval);
        break;
    case 5U:
        housekeeping(3U);
        break;
    case 6U:
        (void)fixture_select(FIXTURE_LINKED);
        break;
    case 7U:
        (void)fixture_state(STATE_OFFLINE);
        break;
    case 8U:
    case 9U:
    case 10U:
    case 11U:
        (void)fixture_state(STATE_PRE_OPERATIONAL);
        break;
    default:
        (void)fixture_select(FIXTURE_ALONE);
        break;
    }
}

/// Wait until each task has run once.
static void let_the_tasks_run(void)
{
    const struct timespec rest = {0, 20000};
    for (uint8_t i = 0U; i < LOOPS; i++) {
        const uint32_t before = __atomic_load_n(&loopers[i].steps, __ATOMIC_ACQUIRE);
        for (unsigned k = 0U;
             (k < 100000U) && (__atomic_load_n(&loopers[i].steps, __ATOMIC_ACQUIRE) == before); k++) {
            (void)nanosleep(&rest, NULL);
        }
    }
}

static void every_sample_is_consistent_and_every_request_is_answered(void)
{
    fixture.in_sense = update;
    for (uint8_t i = 0U; i < LOOPS; i++) {
        loopers[i].loop = i;
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&loopers[i].task, run_loop, &loopers[i], 0));
    }
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.shows_status = true;
    for (unsigned round = 0U; round < ROUNDS; round++) {
        if ((chance(20U) == 0U) && (round < (ROUNDS - QUIET_ROUNDS))) {
            command();
            ask();
        }
        fixture.now_ns += ROUND_NS;
        __atomic_store_n(&present_ns, fixture.now_ns, __ATOMIC_RELEASE);
        (void)subsystem_step(&fixture.subsystem, fixture.now_ns);
        check_reports();
        fixture_forget();
        if ((round % 8U) == 0U) { // The simulated time must not pass faster than the tasks run.
            let_the_tasks_run();
        }
    }
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    for (uint8_t i = 0U; i < LOOPS; i++) {
        osal_task_join(&loopers[i].task);
        TEST_ASSERT_TRUE(loopers[i].steps > 100U);
    }
    TEST_ASSERT_TRUE(parameter_is_consistent(&fixture.subsystem.dictionary));
    (void)printf("%u reports, %u dropped\n", (unsigned)reports,
                 (unsigned)fixture.subsystem.housekeeping.counters.dropped);
    TEST_ASSERT_TRUE(reports > 1000U);
    TEST_ASSERT_EQUAL_UINT32(asked, answered);
    TEST_ASSERT_TRUE(values > 500U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_sample_is_consistent_and_every_request_is_answered);
    return UNITY_END();
}
