// SPDX-License-Identifier: Apache-2.0
// A component from its start to its end by telecommands: its reports, their order, and the actions of each
// cycle.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

void setUp(void)
{
    fixture_open(NULL);
}

void tearDown(void)
{
    fixture_close();
}

static void go_up_to_pre_operational(void)
{
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_expect("1.1 #0\n1.3 #0\n"
                   "129.2 0>1 ENTERING cause 0 code 0000 cfg 0\n1.5 #0 step 1\n");
    fixture_run(3U);
    fixture_expect("129.2 1>2 ENTERING cause 0 code 0000 cfg 0\n1.5 #0 step 2\n"
                   "129.2 2>3 UNCONFIGURED cause 0 code 0000 cfg 0\n1.5 #0 step 3\n1.7 #0\n");
}

static void a_subsystem_goes_from_offline_to_operational_and_back(void)
{
    go_up_to_pre_operational();
    (void)fixture_select(FIXTURE_ALONE);
    fixture_expect("1.1 #1\n1.3 #1\n129.2 3>3 CONFIGURING cause 0 code 0000 cfg 1\n");
    fixture_run(2U);
    fixture_expect("129.2 3>3 CONFIGURED cause 0 code 0000 cfg 1\n1.7 #1\n");
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_run(2U);
    fixture_expect("1.1 #2\n1.3 #2\n129.2 3>4 ENTERING cause 0 code 0000 cfg 1\n1.5 #2 step 4\n"
                   "129.2 4>4 IDLE cause 0 code 0000 cfg 1\n1.7 #2\n");
    (void)fixture_state(STATE_OPERATIONAL);
    fixture_run(2U);
    fixture_expect("1.1 #3\n1.3 #3\n129.2 4>5 ENTERING cause 0 code 0000 cfg 1\n1.5 #3 step 5\n"
                   "129.2 5>5 IDLE cause 0 code 0000 cfg 1\n1.7 #3\n");
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(8U);
    fixture_expect("1.1 #4\n1.3 #4\n129.2 5>4 ENTERING cause 0 code 0000 cfg 1\n1.5 #4 step 4\n"
                   "129.2 4>4 IDLE cause 0 code 0000 cfg 1\n129.2 4>4 LEAVING cause 0 code 0000 cfg 1\n"
                   "129.2 4>7 ENTERING cause 0 code 0000 cfg 1\n1.5 #4 step 7\n"
                   "129.2 7>8 ENTERING cause 0 code 0000 cfg 0\n1.5 #4 step 8\n"
                   "129.2 8>9 ENTERING cause 0 code 0000 cfg 0\n1.5 #4 step 9\n"
                   "129.2 9>0 IDLE cause 0 code 0000 cfg 0\n1.5 #4 step 0\n1.7 #4\n");
}

static void only_requested_verification_is_reported(void)
{
    fixture.ack = PUS_ACK_COMPLETION;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(3U);
    fixture_expect("129.2 0>1 ENTERING cause 0 code 0000 cfg 0\n129.2 1>2 ENTERING cause 0 code 0000 cfg 0\n"
                   "129.2 2>3 UNCONFIGURED cause 0 code 0000 cfg 0\n1.7 #0\n");
    fixture.ack = 0U;
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(5U);
    TEST_ASSERT_FALSE(fixture_has("1."));
    TEST_ASSERT_TRUE(fixture_has("129.2 9>0"));
    fixture_forget();
    (void)fixture_state(STATE_OPERATIONAL); // A refusal is always reported.
    fixture_expect("1.4 #2 0204 5\n");
}

static void refused_requests_change_nothing(void)
{
    static const state_t refused[] = {STATE_SOFTWARE_INIT,
                                      STATE_HARDWARE_INIT,
                                      STATE_SAFE_OPERATIONAL,
                                      STATE_OPERATIONAL,
                                      STATE_ERROR_OPERATIONAL,
                                      STATE_POST_OPERATIONAL,
                                      STATE_SOFTWARE_DEINIT,
                                      (state_t)10,
                                      (state_t)255};
    for (unsigned i = 0U; i < (sizeof refused / sizeof refused[0]); i++) {
        fixture.ack = 0U;
        (void)fixture_state(refused[i]);
        TEST_ASSERT_TRUE(fixture_has("1.4 #"));
        TEST_ASSERT_FALSE(fixture_has("129.2"));
        TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
        fixture_forget();
    }
    fixture.ack = PUS_ACK_ALL;
    (void)fixture_state(STATE_OFFLINE);
    fixture_expect("1.1 #9\n1.3 #9\n1.7 #9\n"); // The state is already reached.
    (void)fixture_select(FIXTURE_ALONE);
    fixture_expect("1.1 #10\n1.4 #10 0204 0\n");
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    (void)fixture_select(9U);
    fixture_expect("1.1 #0\n1.4 #0 0201 9\n");
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_expect("1.1 #1\n1.4 #1 0204 4\n");
}

static void malformed_requests_are_rejected(void)
{
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REQUEST_STATE, "ab", 2U);
    fixture_expect("1.2 #0 0108 1\n");
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_SELECT, "a", 1U);
    TEST_ASSERT_TRUE(fixture_has("1.2 #1 0108"));
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, 2U, NULL, 0U);
    fixture_expect("1.2 #2 0106 8102\n");
    (void)fixture_command(99U, 1U, NULL, 0U);
    fixture_expect("1.2 #3 0105 63\n");
    for (size_t size = 1U; size < 13U; size++) { // Truncated packets, of every length.
        static const uint8_t octets[13] = {0x18U, 0x10U, 0xC0U, 0x00U, 0x00U, 0x06U,
                                           0x2FU, 0x11U, 0x01U, 0x00U, 0x01U};
        fixture.source                  = PUS_USER_GROUND; // A request that is too short has no source.
        fixture_forget_ends();                             // The number of the first request is used again.
        fixture_accept(octets, size);
        TEST_ASSERT_EQUAL(size >= 4U, fixture_has("1.2 #0 0101"));
        fixture_forget();
    }
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
}

static void a_superseded_request_ends(void)
{
    fixture.delays[ACTION_HARDWARE_INIT] = 3U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_expect("1.1 #1\n1.4 #1 0204 3\n"); // The component is busy.
    (void)fixture_state(STATE_OFFLINE);
    fixture_expect(
        "1.1 #2\n1.8 #0 0405 0\n1.3 #2\n129.2 2>8 ENTERING cause 0 code 0000 cfg 0\n1.5 #2 step 8\n");
    fixture_run(3U);
    fixture_expect("129.2 8>9 ENTERING cause 0 code 0000 cfg 0\n1.5 #2 step 9\n"
                   "129.2 9>0 IDLE cause 0 code 0000 cfg 0\n1.5 #2 step 0\n1.7 #2\n");
}

static void a_request_that_an_error_interrupts_fails(void)
{
    fixture_bring(STATE_SAFE_OPERATIONAL, FIXTURE_ALONE);
    fixture.delays[ACTION_ENGAGE] = 3U;
    (void)fixture_state(STATE_OPERATIONAL);
    fixture_run(1U);
    fixture_forget();
    (void)subsystem_raise(&fixture.subsystem, FIXTURE_BROKEN, (const uint8_t*)"\x00\x07", 2U);
    fixture_expect("129.2 5>6 ENTERING cause 1 code 0001 cfg 1\n1.8 #0 0405 0\n5.4 event 1 aux 0007\n");
    fixture_run(1U);
    fixture_expect("129.2 6>6 SECURED cause 1 code 0000 cfg 1\n");
}

static void the_cause_of_a_transition_names_its_requester(void)
{
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE);
    fixture.source = FIXTURE_SUPERVISOR;
    fixture.ack    = 0U;
    (void)fixture_order(STATE_SAFE_OPERATIONAL, CAUSE_PLAN);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("129.2 5>4 ENTERING cause 3"));
    fixture_forget();
    (void)fixture_order(STATE_ERROR_OPERATIONAL, CAUSE_NETWORK);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("129.2 4>6 ENTERING cause 2"));
    fixture_forget();
    (void)fixture_order(STATE_OFFLINE, CAUSE_SHUTDOWN);
    TEST_ASSERT_TRUE(fixture_has("129.2 6>7 ENTERING cause 4"));
}

static void the_steps_of_a_cycle_have_a_fixed_order(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.shows_cycle   = true;
    fixture.shows_actions = true;
    fixture_run(1U);
    fixture_expect("* sense\n* control\n* emit\n");
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture.delays[ACTION_START_CONTROL] = 1U;
    fixture_forget();
    fixture_run(2U);
    fixture_expect(
        "* sense\n* start_control\n* control\n* emit\n"
        "* sense\n* start_control\n129.2 4>4 IDLE cause 0 code 0000 cfg 1\n1.7 #0\n* control\n* emit\n");
}

static void callbacks_are_called_with_hardware_only_and_control_with_a_configuration_only(void)
{
    fixture.shows_cycle = true;
    fixture_run(5U);
    fixture_expect(""); // In OFFLINE no callback is called.
    fixture.delays[ACTION_SOFTWARE_INIT] = 2U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_forget();
    fixture_run(2U);
    fixture_expect(""); // In SOFTWARE_INIT there is no hardware yet.
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("* sense"));
    TEST_ASSERT_TRUE(fixture_has("* emit"));
    TEST_ASSERT_FALSE(fixture_has("* control")); // Without a configuration there is nothing to control.
}

static void the_health_contains_each_counter_once(void)
{
    subsystem_t* const subsystem = &fixture.subsystem;
    subsystem_health_t health;
    subsystem->dispatcher.counters.rejected = 1U;
    subsystem->dispatcher.counters.refused  = 2U;
    subsystem->dispatcher.counters.ignored  = 4U;
    subsystem->dictionary.refusals          = (parameter_refusals_t){
                 .unknown = 1U, .read_only = 2U, .out_of_range = 4U, .malformed = 8U, .no_room = 16U};
    subsystem->process.counters.lost      = 1U;
    subsystem->process.counters.oversized = 2U;
    subsystem->loop_reports_lost          = 4U;
    subsystem_health(subsystem, &health);
    TEST_ASSERT_EQUAL_UINT32(7U, health.requests_refused);
    TEST_ASSERT_EQUAL_UINT32(31U, health.parameters_refused);
    TEST_ASSERT_EQUAL_UINT32(7U, health.reports_lost);
}

static bool has_hardware(state_t state)
{
    return (state >= STATE_HARDWARE_INIT) && (state <= STATE_HARDWARE_DEINIT);
}

/// The first cycle with hardware emits without sensing; the last one senses and emits.
static void a_cycle_emits_if_there_is_hardware_at_its_beginning_or_its_end(void)
{
    unsigned begins = 0U;
    unsigned ends   = 0U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture.shows_cycle = true;
    for (unsigned i = 0U; i < 40U; i++) {
        if (i == 20U) {
            (void)fixture_state(STATE_OFFLINE);
        }
        const bool before = has_hardware(subsystem_state(&fixture.subsystem));
        fixture_forget();
        fixture_run(1U);
        const bool after = has_hardware(subsystem_state(&fixture.subsystem));
        TEST_ASSERT_EQUAL(before, fixture_has("* sense"));
        TEST_ASSERT_EQUAL(before || after, fixture_has("* emit"));
        begins += (!before && after) ? 1U : 0U;
        ends += (before && !after) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(1U, begins);
    TEST_ASSERT_EQUAL(1U, ends);
}

static void an_action_runs_once_a_cycle(void)
{
    fixture.shows_actions                = true;
    fixture.delays[ACTION_SOFTWARE_INIT] = 1U;
    fixture.delays[ACTION_HARDWARE_INIT] = 2U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_forget();
    unsigned cycles = 0U;
    while ((subsystem_state(&fixture.subsystem) != STATE_PRE_OPERATIONAL) && (cycles < 20U)) {
        fixture_run(1U);
        cycles++;
    }
    TEST_ASSERT_EQUAL(5U, cycles);
    TEST_ASSERT_EQUAL(0U, fixture.delays[ACTION_HARDWARE_INIT]);
}

static struct {
    uint64_t now_ns;
    uint32_t cycle;
} seen;

static void note_time(void)
{
    TEST_ASSERT_TRUE(subsystem_now_ns(&fixture.subsystem) > seen.now_ns);
    seen.now_ns = subsystem_now_ns(&fixture.subsystem);
    seen.cycle  = subsystem_cycle(&fixture.subsystem);
}

static void callbacks_receive_the_time(void)
{
    seen.now_ns                          = 0U;
    fixture.in_sense                     = note_time;
    fixture.delays[ACTION_HARDWARE_INIT] = 2U;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    const uint32_t before = seen.cycle;
    fixture_run(7U);
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns - FIXTURE_PERIOD_NS, seen.now_ns);
    TEST_ASSERT_EQUAL_UINT32(before + 7U, seen.cycle);
    subsystem_set_time(&fixture.subsystem, fixture.now_ns + 5U);
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns + 5U, subsystem_now_ns(&fixture.subsystem));
}

static void the_period_of_the_cycle_follows_the_configuration(void)
{
    TEST_ASSERT_EQUAL(10000000U, subsystem_period_ns(&fixture.subsystem));
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    TEST_ASSERT_EQUAL(10000000U, subsystem_period_ns(&fixture.subsystem));
    TEST_ASSERT_NULL(subsystem_configuration(&fixture.subsystem));
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    TEST_ASSERT_EQUAL(FIXTURE_PERIOD_NS, subsystem_period_ns(&fixture.subsystem));
    TEST_ASSERT_EQUAL_STRING("ALONE", subsystem_configuration(&fixture.subsystem)->name);
    const uint32_t before = subsystem_cycle(&fixture.subsystem);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(before + 10U, subsystem_cycle(&fixture.subsystem));
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(6U);
    TEST_ASSERT_EQUAL(10000000U, subsystem_period_ns(&fixture.subsystem));
    TEST_ASSERT_NULL(subsystem_configuration(&fixture.subsystem));
}

static void a_component_wakes_when_something_is_due(void)
{
    // In OFFLINE the next status report is due.
    TEST_ASSERT_EQUAL(1000000000U, subsystem_step(&fixture.subsystem, 0U));
    fixture.now_ns = 123456789U;
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    const uint64_t wake_ns = subsystem_step(&fixture.subsystem, fixture.now_ns);
    TEST_ASSERT_TRUE(wake_ns > fixture.now_ns);
    TEST_ASSERT_TRUE((wake_ns - fixture.now_ns) <= FIXTURE_PERIOD_NS);
    TEST_ASSERT_EQUAL_MESSAGE(0U, wake_ns % FIXTURE_PERIOD_NS, "a cycle begins at a multiple of its period");
    const uint32_t cycle = subsystem_cycle(&fixture.subsystem);
    // A message wakes the component, but this is not a cycle.
    (void)subsystem_step(&fixture.subsystem, wake_ns - 1U);
    TEST_ASSERT_EQUAL(cycle, subsystem_cycle(&fixture.subsystem));
    (void)subsystem_step(&fixture.subsystem, wake_ns);
    TEST_ASSERT_EQUAL(cycle + 1U, subsystem_cycle(&fixture.subsystem));
}

static void status_is_reported_once_a_second_and_on_request(void)
{
    fixture.shows_status = true;
    fixture_run_until(2500000000ULL);
    fixture_expect(
        "129.5 0 IDLE target 0 cfg 0 epoch 3 cycle 0\n129.5 0 IDLE target 0 cfg 0 epoch 3 cycle 0\n"
        "129.5 0 IDLE target 0 cfg 0 epoch 3 cycle 0\n");
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REPORT_STATUS, NULL, 0U);
    fixture_expect("1.1 #0\n1.3 #0\n129.5 0 IDLE target 0 cfg 0 epoch 3 cycle 0\n1.7 #0\n");
    fixture.delays[ACTION_HARDWARE_INIT] = 1000U;
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REPORT_STATUS, NULL, 0U);
    fixture_expect("1.1 #2\n1.3 #2\n129.5 2 ENTERING target 3 cfg 0 epoch 3 cycle 2\n1.7 #2\n");
}

static void reconfiguring_revokes_the_old_configuration(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    TEST_ASSERT_EQUAL_DOUBLE(7.0, fixture.limit); // The initial value of the configuration.
    fixture.shows_actions = true;
    (void)fixture_select(FIXTURE_LINKED);
    fixture_run(2U);
    fixture_expect("1.1 #0\n1.3 #0\n129.2 3>3 CONFIGURING cause 0 code 0000 cfg 2\n* configure\n"
                   "129.2 3>3 CONFIGURED cause 0 code 0000 cfg 2\n1.7 #0\n");
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    (void)fixture_state(STATE_SAFE_OPERATIONAL);
    fixture_run(2U);
    fixture_forget();
    // The transition passes through POST_OPERATIONAL, which revokes the configuration.
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_run(4U);
    fixture_expect("1.1 #1\n1.3 #1\n129.2 4>4 LEAVING cause 0 code 0000 cfg 1\n* stop_control\n"
                   "129.2 4>7 ENTERING cause 0 code 0000 cfg 1\n1.5 #1 step 7\n* post\n"
                   "129.2 7>3 UNCONFIGURED cause 0 code 0000 cfg 0\n1.5 #1 step 3\n1.7 #1\n");
    TEST_ASSERT_NULL(subsystem_configuration(&fixture.subsystem));
}

static void a_refused_descriptor_keeps_the_component_offline(void)
{
    fixture_close();
    fixture_open_invalid();
    fixture.shows_status = true;
    fixture_run(1U);
    fixture_expect("129.5 0 INVALID target 0 cfg 0 epoch 3 cycle 0\n");
    (void)fixture_state(STATE_PRE_OPERATIONAL);
    fixture_expect("1.1 #0\n1.4 #0 0204 3\n");
    (void)fixture_command(PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_expect("1.1 #1\n1.3 #1\n17.2 \n1.7 #1\n"); // The component still answers.
    (void)fixture_function("MOVE", NULL, 0U);
    fixture_expect("1.1 #2\n1.4 #2 0201 4D4F5645\n");
}

static void every_start_of_a_process_but_the_first_is_a_restart(void)
{
    static const struct {
        uint32_t start_count;
        bool is_restarted;
    } rows[] = {{1U, false}, {2U, true}, {3U, true}, {UINT32_MAX, true}};
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        fixture.subsystem.config.start_count = rows[i].start_count;
        TEST_ASSERT_EQUAL(rows[i].is_restarted, subsystem_is_restarted(&fixture.subsystem));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_subsystem_goes_from_offline_to_operational_and_back);
    RUN_TEST(only_requested_verification_is_reported);
    RUN_TEST(refused_requests_change_nothing);
    RUN_TEST(malformed_requests_are_rejected);
    RUN_TEST(a_superseded_request_ends);
    RUN_TEST(a_request_that_an_error_interrupts_fails);
    RUN_TEST(the_cause_of_a_transition_names_its_requester);
    RUN_TEST(the_steps_of_a_cycle_have_a_fixed_order);
    RUN_TEST(callbacks_are_called_with_hardware_only_and_control_with_a_configuration_only);
    RUN_TEST(a_cycle_emits_if_there_is_hardware_at_its_beginning_or_its_end);
    RUN_TEST(the_health_contains_each_counter_once);
    RUN_TEST(an_action_runs_once_a_cycle);
    RUN_TEST(callbacks_receive_the_time);
    RUN_TEST(the_period_of_the_cycle_follows_the_configuration);
    RUN_TEST(a_component_wakes_when_something_is_due);
    RUN_TEST(status_is_reported_once_a_second_and_on_request);
    RUN_TEST(reconfiguring_revokes_the_old_configuration);
    RUN_TEST(a_refused_descriptor_keeps_the_component_offline);
    RUN_TEST(every_start_of_a_process_but_the_first_is_a_restart);
    return UNITY_END();
}
