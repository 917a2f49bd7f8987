// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
// Loops of services as tasks in real time: each keeps its own rate beside the component's cycle, follows the
// applied configuration, and ends on request.
#include "fsw/programs/loop_tasks.h"

#include "unity.h"

#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define APID 20U
#define CYCLE_NS 1000000ULL
#define MAX_CYCLES 5000U ///< Largest number of cycles that a test waits.
#define SLOW_REPORT 1U   ///< Every 20 ms.
#define FAST_REPORT 2U   ///< Every 2 ms.

static subsystem_t component;
static subsystem_descriptor_t descriptor;
static descriptor_loader_t loader;
static loop_tasks_t tasks;
static osal_clock_t clock_of_run;
static uint64_t origin_ns;
static uint16_t sequence;
static uint32_t ticks;
static struct {
    unsigned count;
    uint64_t taken_ns; ///< Packet time of the last report [ns after origin_ns].
    bool is_backwards;
} reports[3];

static const char document[] =
    "<Subsystem name='CLOCKWORK' id='20' samplingTime='1ms'>"
    "<Parameters><ParamRef name='TICKS' id='1' type='UINT32'/></Parameters>"
    "<Configuration name='TWO' id='1' priority='30' samplingTime='1ms'>"
    "<Loop name='SLOW' samplingTime='5ms' priority='10'/><Loop name='FAST' samplingTime='500us' "
    "priority='40'/>"
    "<HKService id='1' interval='4' loop='SLOW'><SampledOnce><ParamRef "
    "name='TICKS'/></SampledOnce></HKService>"
    "<HKService id='2' interval='4' loop='FAST'><SampledOnce><ParamRef "
    "name='TICKS'/></SampledOnce></HKService>"
    "</Configuration>"
    "<Configuration name='NONE' id='2' priority='30' samplingTime='1ms'/></Subsystem>";

static status_t software_init(void* self)
{
    static const parameter_field_t field             = {"TICKS", VALUE_UINT32, 1U, 0U};
    static const parameter_definition_t of_the_ticks = {
        "TICKS", PARAMETER_ID(APID, VALUE_UINT32, 1U), &field, 1U, 4U, 4U};
    (void)self;
    return subsystem_publish(&component, &of_the_ticks, &ticks);
}

static void sense(void* self)
{
    (void)self;
    parameter_lock(subsystem_dictionary(&component));
    ticks++;
    parameter_unlock(subsystem_dictionary(&component));
}

static status_t send(void* context, const uint8_t* packet, size_t size)
{
    pus_tm_t tm;
    pus_failure_t failure;
    (void)context;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
    TEST_ASSERT_EQUAL_UINT16(sequence, tm.sequence); // One counter numbers the reports of all loops.
    sequence = (uint16_t)((sequence + 1U) & 0x3FFFU);
    if ((tm.service == PUS_SERVICE_HOUSEKEEPING) && (tm.subtype == 25U)) {
        const unsigned id        = ((unsigned)tm.data[0] << 8U) | tm.data[1];
        const uint64_t time_ns   = tm.time_ns - component.process.epoch_ns;
        reports[id].is_backwards = reports[id].is_backwards || (time_ns < reports[id].taken_ns);
        reports[id].taken_ns     = time_ns;
        reports[id].count++;
    }
    return STATUS_OK;
}

void setUp(void)
{
    static const subsystem_callbacks_t callbacks = {.software_init = software_init, .sense = sense};
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "test", document, strlen(document), &descriptor),
        descriptor_error(&loader));
    const subsystem_config_t config = {.descriptor          = &descriptor,
                                       .is_descriptor_valid = true,
                                       .callbacks           = &callbacks,
                                       .self                = &component,
                                       .mission_epoch_s     = 1000U,
                                       .start_count         = 1U,
                                       .status_interval_ns  = SUBSYSTEM_STATUS_INTERVAL_NS,
                                       .port                = {&component, send},
                                       .has_loop_tasks      = true};
    sequence                        = 0U;
    ticks                           = 0U;
    (void)memset(reports, 0, sizeof reports);
    origin_ns = osal_clock_monotonic_ns();
    osal_clock_open_real(&clock_of_run, origin_ns);
    subsystem_init(&component, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, loop_tasks_start(&tasks, &component, origin_ns));
}

void tearDown(void)
{
    loop_tasks_stop(&tasks);
}

/// Run the component's own loop for this time.
static void run_for(uint64_t duration_ns)
{
    const uint64_t end_ns = osal_clock_now_ns(&clock_of_run) + duration_ns;
    uint64_t now_ns       = 0U;
    while ((now_ns = osal_clock_now_ns(&clock_of_run)) < end_ns) {
        const uint64_t wake_ns = subsystem_step(&component, now_ns);
        TEST_ASSERT_EQUAL(STATUS_OK,
                          osal_clock_wait(&clock_of_run, (wake_ns < end_ns) ? wake_ns : end_ns, NULL, 0U));
    }
}

static void run_until_a_report(void)
{
    for (unsigned i = 0U; (i < MAX_CYCLES) && (reports[FAST_REPORT].count == 0U); i++) {
        run_for(CYCLE_NS);
    }
    TEST_ASSERT_TRUE(reports[FAST_REPORT].count > 0U);
}

static void begin(uint16_t configuration)
{
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_request(&component, STATE_PRE_OPERATIONAL, CAUSE_REQUEST));
    for (unsigned i = 0U; (i < MAX_CYCLES) && (subsystem_state(&component) != STATE_PRE_OPERATIONAL); i++) {
        run_for(CYCLE_NS);
    }
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_select(&component, configuration));
}

static void each_loop_keeps_its_own_rate(void)
{
    begin(1U);
    run_for(400U * CYCLE_NS);
    // 400 ms contain 20 intervals of the slow report and 200 of the fast one. On a busy machine a task wakes
    // late and skips the cycles in between, so there are fewer reports; or the 400 ms end a little later.
    TEST_ASSERT_TRUE((reports[SLOW_REPORT].count >= 5U) && (reports[SLOW_REPORT].count <= 21U));
    TEST_ASSERT_TRUE((reports[FAST_REPORT].count >= 20U) && (reports[FAST_REPORT].count <= 206U));
    TEST_ASSERT_FALSE(reports[SLOW_REPORT].is_backwards || reports[FAST_REPORT].is_backwards);
    TEST_ASSERT_EQUAL_UINT32(0U, component.housekeeping.counters.dropped);
}

static void without_loops_in_the_configuration_the_tasks_do_not_run(void)
{
    begin(2U);
    run_for(60U * CYCLE_NS);
    TEST_ASSERT_EQUAL(0U, reports[SLOW_REPORT].count + reports[FAST_REPORT].count);
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_select(&component, 1U));
    run_until_a_report();
    TEST_ASSERT_EQUAL(ANSWER_STARTED, subsystem_request(&component, STATE_OFFLINE, CAUSE_REQUEST));
    for (unsigned i = 0U; (i < MAX_CYCLES) && (subsystem_state(&component) != STATE_OFFLINE); i++) {
        run_for(CYCLE_NS);
    }
    const unsigned before = reports[FAST_REPORT].count;
    run_for(40U * CYCLE_NS);
    TEST_ASSERT_EQUAL(before, reports[FAST_REPORT].count);
}

/// In a child process without privileges: a priority that is not permitted is reported, and the loops still
/// run.
static void a_priority_that_is_not_permitted_is_noted(void)
{
    int ends[2];
    char console_text[256] = "";
    if (geteuid() != 0U) {
        TEST_IGNORE_MESSAGE("only a privileged process can test the refusal");
    }
    loop_tasks_stop(&tasks);
    TEST_ASSERT_EQUAL(0, pipe(ends));
    const pid_t child = fork();
    if (child == 0) {
        const bool is_dropped =
            (dup2(ends[1], STDERR_FILENO) >= 0) && (setgid(65534) == 0) && (setuid(65534) == 0);
        setUp();
        begin(1U);
        run_until_a_report();
        loop_tasks_stop(&tasks);
        _exit(is_dropped ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
    (void)close(ends[1]);
    TEST_ASSERT_TRUE(read(ends[0], console_text, sizeof console_text - 1U) > 0);
    (void)close(ends[0]);
    TEST_ASSERT_NOT_NULL(
        strstr(console_text,
               "note: real-time priorities are not permitted here; run as root, or raise `ulimit -r`\n"));
}

static void tasks_end_only_on_request(void)
{
    begin(1U);
    run_until_a_report();
    const uint64_t asked_ns = osal_clock_now_ns(&clock_of_run);
    loop_tasks_stop(&tasks);
    TEST_ASSERT_TRUE((osal_clock_now_ns(&clock_of_run) - asked_ns) < 2000000000ULL);
    run_for(5U * CYCLE_NS); // The reports that are finished are still sent.
    const unsigned before = reports[FAST_REPORT].count;
    run_for(30U * CYCLE_NS);
    TEST_ASSERT_EQUAL(before, reports[FAST_REPORT].count);
    loop_tasks_stop(&tasks); // A second call, and a call for tasks that never ran.
    static loop_tasks_t none;
    loop_tasks_stop(&none);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_loop_keeps_its_own_rate);
    RUN_TEST(without_loops_in_the_configuration_the_tasks_do_not_run);
    RUN_TEST(a_priority_that_is_not_permitted_is_noted);
    RUN_TEST(tasks_end_only_on_request);
    return UNITY_END();
}
