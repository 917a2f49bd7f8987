// SPDX-License-Identifier: Apache-2.0
// The supervisor from start to shutdown, and service 131.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void setUp(void)
{
}

void tearDown(void)
{
    fixture_close();
}

static uint16_t mission_tc(uint8_t subtype, const void* data, size_t size)
{
    return fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, subtype, data, size);
}

static uint16_t process_tc(uint8_t subtype, uint16_t apid)
{
    const uint8_t data[2] = {(uint8_t)(apid >> 8U), (uint8_t)apid};
    return mission_tc(subtype, data, sizeof data);
}

// ---- Autostart ----

static void supervisor_and_communication_start_without_a_request(void)
{
    fixture_open();
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    const char* const text            = fixture_look();
    static const char* const orders[] = {"2 TC 129.8 0300 from 8001", "2 TC 129.3 0001 from 8001",
                                         "2 TC 129.8 0400 from 8001", "2 TC 129.8 0500 from 8001"};
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, orders[i]));
    }
    TEST_ASSERT_EQUAL(4U, fixture_count_lines(text, "2 TC"));
    TEST_ASSERT_EQUAL(0U, fixture_count_lines(text, "16 TC") + fixture_count_lines(text, "17 TC") +
                              fixture_count_lines(text, "18 TC"));
    fixture_run(500U);
    fixture_expect("");
}

static void no_subsystem_gets_an_order_before_its_first_report(void)
{
    fixture_open();
    fixture.members[FIXTURE_GROUND].is_silent = true;
    fixture_run(60U);
    TEST_ASSERT_FALSE(fixture_has("2 TC"));
    fixture.members[FIXTURE_GROUND].is_silent = false;
    fixture_run(120U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
}

static void an_autostart_subsystem_at_the_first_position_of_the_table_starts(void)
{
    fixture_open();
    mission_subsystem_t* const first = (mission_subsystem_t*)fixture.supervisor.registry[0].mission;
    TEST_ASSERT_EQUAL_UINT16(16U, first->apid);
    first->is_autostart = true;
    fixture_run(50U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "16 TC 129.8 03"));
}

static void communication_is_started_again_after_a_command_to_offline(void)
{
    fixture_open_up();
    (void)fixture_request_state(COMMUNICATION_APID, STATE_OFFLINE);
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
}

static void expect_heartbeats(unsigned count)
{
    for (unsigned i = FIXTURE_ARM; i < FIXTURE_MEMBERS; i++) {
        fixture.members[i].heartbeats = 0U;
    }
    fixture_run(1000U);
    for (unsigned i = FIXTURE_ARM; i < FIXTURE_MEMBERS; i++) {
        TEST_ASSERT_EQUAL(count, fixture.members[i].heartbeats);
    }
}

static void members_get_a_heartbeat_once_a_second(void)
{
    fixture_open_up();
    expect_heartbeats(10U);
}

static void make_impatient(supervisor_config_t* config)
{
    static mission_descriptor_t mission;
    mission = *config->mission;
    descriptor_mission_use_storage(&mission);
    mission.storage.subsystems[1].supervisor_timeout_us = 1500000U;
    mission.storage.subsystems[2].supervisor_timeout_us = 600000U;
    config->mission                                     = &mission;
}

/// A subsystem that stays OPERATIONAL without the supervisor for only a short time gets three heartbeats in
/// that time.
static void the_subsystem_with_the_shortest_time_out_sets_the_interval(void)
{
    fixture_configure = make_impatient;
    fixture_open_up();
    fixture_configure = NULL;
    expect_heartbeats(50U);
}

// ---- Shutdown ----

static const char* at(const char* text, const char* line)
{
    const char* const found = strstr(text, line);
    TEST_ASSERT_NOT_NULL_MESSAGE(found, line);
    return found;
}

static void check_order_of_shutdown(const char* text, bool has_request)
{
    const char* const safe    = at(text, "16 TC 129.8 0404 from 8001");
    const char* const offline = at(text, "16 TC 129.8 0004 from 8001");
    const char* const ground  = at(text, "2 TC 129.8 0004 from 8001");
    (void)at(text, "17 TC 129.8 0404 from 8001");
    (void)at(text, "17 TC 129.8 0004 from 8001");
    TEST_ASSERT_TRUE(safe < offline);
    TEST_ASSERT_TRUE(at(text, "18 TC 129.8 0004 from 8001") > safe);
    TEST_ASSERT_NULL(strstr(text, "18 TC 129.8 04")); // LONE was not operational.
    TEST_ASSERT_TRUE(offline < ground);
    if (has_request) {
        const char* const done = at(text, "G 1.7 #");
        // The connection to the ground is still open.
        TEST_ASSERT_TRUE((offline < done) && (done < ground));
    }
}

static void a_mission_shuts_down_with_communication_last(void)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture_forget();
    const uint8_t mode[1] = {MODE_SAFE};
    (void)mission_tc(PUS_MISSION_SET_MODE, mode, 1U);
    fixture_run(2U);
    fixture_forget();
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U); // Permitted in every mode, without a rule.
    fixture_run(30U);
    check_order_of_shutdown(fixture_look(), true);
    TEST_ASSERT_TRUE(fixture.is_finished);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.supervisor.subsystem));
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        TEST_ASSERT_EQUAL(STATE_OFFLINE, fixture.members[i].state);
    }
    // The log is complete, including the last record.
    const char* const log = fixture_log_file("packets.ascii");
    TEST_ASSERT_EQUAL(fixture.supervisor.log.next_number - 1U, fixture_count_lines(log, ""));
}

/// The request was lost on its way to a running subsystem.
static void the_shutdown_ends_unanswered_requests(void)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].is_passive = true;
    const uint16_t number                    = fixture_tc(17U, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture.members[FIXTURE_HAND].is_passive = false;
    fixture_forget();
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(30U);
    TEST_ASSERT_TRUE(fixture.is_finished);
    const char* const text = fixture_look();
    char line[32];
    (void)snprintf(line, sizeof line, "G 1.8 #%u 0406", number);
    const char* const lost = at(text, line);
    // The connection to the ground is still open.
    TEST_ASSERT_TRUE(lost < at(text, "2 TC 129.8 0004 from 8001"));
}

static void a_stop_request_shuts_the_mission_down(void)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_LONE, STATE_PRE_OPERATIONAL);
    fixture_forget();
    fixture.is_stop_requested = true;
    fixture_run(30U);
    check_order_of_shutdown(fixture_look(), false);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static void a_stop_request_right_after_the_start_is_obeyed(void)
{
    fixture_open();
    fixture.is_stop_requested = true;
    fixture_run(30U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

/// Shut the mission down while a member answers no request: each step of the shutdown waits three seconds for
/// it.
static void shut_down_with_hanging_member(const unsigned member, const char* const order_to_offline)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[member].is_passive = true;
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(250U);
    TEST_ASSERT_FALSE(fixture_has(order_to_offline));
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture_has(order_to_offline));
    TEST_ASSERT_FALSE(fixture_has("2 TC 129.8 00"));
    fixture_run(230U);
    TEST_ASSERT_FALSE(fixture_has("2 TC 129.8 00"));
    fixture_run(90U);
    TEST_ASSERT_TRUE(fixture_has("2 TC 129.8 00"));
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static void the_shutdown_waits_a_limited_time_for_the_first_member(void)
{
    shut_down_with_hanging_member(FIXTURE_ARM, "16 TC 129.8 00");
}

static void the_shutdown_waits_a_limited_time_for_any_member(void)
{
    shut_down_with_hanging_member(FIXTURE_HAND, "17 TC 129.8 00");
}

static void the_mission_shuts_down_without_communication(void)
{
    fixture_open_up();
    fixture.start_result                       = STATUS_NOT_FOUND; // Communication cannot be started again.
    fixture.members[FIXTURE_GROUND].is_running = false;
    fixture_run(100U);
    TEST_ASSERT_EQUAL(PROCESS_LOST,
                      supervisor_registry_find(&fixture.supervisor, COMMUNICATION_APID)->process);
    fixture.is_stop_requested = true;
    fixture_run(30U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static void a_second_shutdown_is_refused(void)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].is_passive = true;
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(5U);
    fixture_forget();
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0204 0\n"));
}

static void no_recovery_plan_starts_during_the_shutdown(void)
{
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    fixture.members[FIXTURE_HAND].is_passive = true; // The shutdown waits for this member.
    (void)mission_tc(PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(5U);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_run(2U);
    // The network is secured without a plan and without a restart.
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 06"));
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(20U);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.counters.plans_started);
    TEST_ASSERT_EQUAL(0U, fixture.starts);
    TEST_ASSERT_EQUAL(MODE_NOMINAL, fixture.supervisor.mode);
}

// ---- Modes ----

static void modes_are_set_and_reported(void)
{
    fixture_open_up();
    const uint8_t safe[1]    = {MODE_SAFE};
    const uint8_t unknown[1] = {7U};
    (void)mission_tc(PUS_MISSION_SET_MODE, safe, 1U);
    fixture_run(2U);
    fixture_expect("G 1.1 #0\nG 131.2 010000\nG 5.1 00040100\nG 1.3 #0\nG 1.7 #0\n");
    (void)mission_tc(PUS_MISSION_SET_MODE, safe, 1U);
    fixture_run(2U);
    fixture_expect("G 1.1 #1\nG 1.3 #1\nG 1.7 #1\n");
    (void)mission_tc(PUS_MISSION_SET_MODE, unknown, 1U);
    fixture_run(2U);
    fixture_expect("G 1.1 #2\nG 1.4 #2 0201 7\n");
}

// ---- Packet log ----

static void select_log(uint8_t strategy)
{
    (void)mission_tc(PUS_MISSION_SELECT_LOG, &strategy, 1U);
    fixture_run(2U);
}

static void the_log_is_switched_at_a_record(void)
{
    fixture_open_up();
    select_log(PACKET_LOG_SQLITE);
    const char* const line = at(fixture_look(), "G 131.4 0001");
    // TM[131,4]: both strategies (00, 01), the number of the first record, a failure code of 16 bits.
    const uint64_t first = strtoull(line + strlen("G 131.4 0001"), NULL, 16) >> 16U;
    TEST_ASSERT_EQUAL(PACKET_LOG_SQLITE, fixture.supervisor.log.strategy);
    select_log(PACKET_LOG_ASCII);
    TEST_ASSERT_TRUE(fixture_has("G 1.1 #1"));
    const char* const log = fixture_log_file("packets.ascii");
    char last_before[32];
    char first_after[32];
    (void)snprintf(last_before, sizeof last_before, "\n%llu ", (unsigned long long)(first - 1U));
    (void)snprintf(first_after, sizeof first_after, "\n%llu ", (unsigned long long)first);
    TEST_ASSERT_NOT_NULL(strstr(log, last_before));
    TEST_ASSERT_NULL(strstr(log, first_after));
}

static void unknown_strategies_are_refused(void)
{
    fixture_open_up();
    select_log(PACKET_LOG_POSTGRESQL);
    fixture_expect("G 1.1 #0\nG 1.4 #0 0201 2\n");
    select_log(4U);
    fixture_expect("G 1.1 #1\nG 1.4 #1 0203 0\n");
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, fixture.supervisor.log.strategy);
}

static void a_log_that_fails_is_reported_once_and_continues_in_the_ring(void)
{
    char path[160];
    fixture_open_up();
    (void)snprintf(path, sizeof path, "%s/packets.spool", fixture_directory());
    TEST_ASSERT_EQUAL(0, symlink("/dev/full", path));
    select_log(PACKET_LOG_SQLITE);
    fixture_run(300U);
    const char* const reported = fixture_look();
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(reported, "G 5.4 000801")); // LOG_FAILED, strategy 1.
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(reported, "G 131.4 0103")); // The ring replaces the strategy.
    TEST_ASSERT_NOT_NULL(strstr(reported, "0404"));                       // The cause is PUS_FAILURE_IO.
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.log.failures);
    select_log(PACKET_LOG_ASCII);
    TEST_ASSERT_TRUE(fixture_has("G 131.4 0300"));
}

static void a_log_that_can_be_written_again_is_reported(void)
{
    char path[160];
    fixture_open_up();
    (void)snprintf(path, sizeof path, "%s/packets.spool", fixture_directory());
    TEST_ASSERT_EQUAL(0, symlink("/dev/full", path));
    select_log(PACKET_LOG_SQLITE);
    fixture_run(2U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, fixture.supervisor.log.strategy);
    TEST_ASSERT_EQUAL(0, unlink(path));
    // The log is selected again one second after the failure, without a request.
    fixture_run(90U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, fixture.supervisor.log.strategy);
    fixture_run(20U);
    TEST_ASSERT_EQUAL(PACKET_LOG_SQLITE, fixture.supervisor.log.strategy);
    fixture_run(1390U);
    TEST_ASSERT_EQUAL(PACKET_LOG_SQLITE, fixture.supervisor.log.strategy);
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(fixture_look(), "G 131.4 0301"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.log.failures);
}

// ---- Tables and processes ----

static void subsystems_are_listed(void)
{
    fixture_open_up();
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL);
    fixture_forget();
    (void)mission_tc(PUS_MISSION_REPORT_SUBSYSTEMS, NULL, 0U);
    fixture_run(2U);
    // {APID, process, state, phase, configuration, restarts}, in the order of the mission.
    fixture_expect("G 1.1 #0\nG 1.3 #0\nG 131.9 0005"
                   "0010010400000200"
                   "0011010000000000"
                   "0012010000000000"
                   "0001010500000100"
                   "0002010500000100\nG 1.7 #0\n");
    (void)mission_tc(PUS_MISSION_REPORT_NETWORKS, NULL, 0U);
    fixture_run(2U);
    fixture_expect("G 1.1 #1\nG 1.3 #1\nG 131.11 0000\nG 1.7 #1\n");
}

static void processes_are_stopped_and_started(void)
{
    fixture_open_up();
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    fixture_run(2U);
    fixture_expect("G 1.1 #0\nG 1.3 #0\nG 1.7 #0\n");
    TEST_ASSERT_EQUAL(1U, fixture.stops);
    fixture_run(500U);
    fixture_expect(""); // The process is not reported as lost, because a command has stopped it.
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_expect("G 1.10 #1 0002 12\n");
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    (void)process_tc(PUS_MISSION_START_PROCESS, LONE);
    fixture_run(2U);
    fixture_expect("G 1.1 #2\nG 1.4 #2 0204 12\nG 1.1 #3\nG 1.3 #3\nG 1.7 #3\n");
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    fixture_run(100U);
    fixture_forget();
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("18 TC 17.1"));
}

static void a_request_to_start_or_stop_is_refused_where_it_is_not_permitted(void)
{
    fixture_open_up();
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_forget();
    (void)process_tc(PUS_MISSION_STOP_PROCESS, ARM); // The subsystem is not OFFLINE.
    (void)process_tc(PUS_MISSION_STOP_PROCESS, SUPERVISOR_APID);
    (void)process_tc(PUS_MISSION_STOP_PROCESS, 99U);
    (void)process_tc(PUS_MISSION_START_PROCESS, ARM); // The process is already running.
    (void)process_tc(PUS_MISSION_START_PROCESS, SUPERVISOR_APID);
    (void)process_tc(PUS_MISSION_START_PROCESS, 99U);
    fixture_run(2U);
    fixture_expect("G 1.1 #0\nG 1.4 #0 0204 10\nG 1.1 #1\nG 1.4 #1 0204 1\nG 1.1 #2\nG 1.4 #2 0201 63\n"
                   "G 1.1 #3\nG 1.4 #3 0204 10\nG 1.1 #4\nG 1.4 #4 0204 1\nG 1.1 #5\nG 1.4 #5 0201 63\n");
    TEST_ASSERT_EQUAL(0U, fixture.starts + fixture.stops);
}

static void requests_to_a_stopped_process_end(void)
{
    fixture_open_up();
    fixture.members[FIXTURE_LONE].is_passive = true;
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_forget();
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0408 12"));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.pending.count);
}

/// Requests to LONE are in progress; its answers come after the command in the inboxes of the supervisor.
static void end_life_before_the_answers(bool is_started_again)
{
    fixture_open_up();
    fixture.members[FIXTURE_LONE].is_passive = true;
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    fixture_verify(FIXTURE_LONE, 1U, 0U);
    fixture_verify(FIXTURE_LONE, 7U, 0U);
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    if (is_started_again) {
        (void)process_tc(PUS_MISSION_START_PROCESS, LONE);
    }
    fixture_verify(FIXTURE_LONE, 1U, 1U);
    fixture_verify(FIXTURE_LONE, 7U, 1U);
    fixture_forget();
    fixture_step();
}

static void a_request_that_has_ended_is_not_answered(void)
{
    end_life_before_the_answers(false);
    fixture_expect("G/18 1.1 #0\nG/18 1.7 #0\nG 1.1 #2\nG 1.8 #1 0408 12\nG 1.3 #2\nG 1.7 #2\n");
    TEST_ASSERT_EQUAL(2U, fixture.endpoint.counters.stale);
    fixture_verify(FIXTURE_LONE, 7U, 1U); // The process has not ended yet.
    fixture_run(2U);
    fixture_expect("");
    TEST_ASSERT_EQUAL(3U, fixture.endpoint.counters.stale);
}

static void reports_of_a_dead_life_do_not_count_for_the_next(void)
{
    end_life_before_the_answers(true);
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0408 12"));
    TEST_ASSERT_FALSE(fixture_has("G/18 1.7 #1"));
    TEST_ASSERT_EQUAL(2U, fixture.endpoint.counters.stale);
    TEST_ASSERT_FALSE(fixture.supervisor.registry[2].is_heard);
    fixture_run(100U);
    TEST_ASSERT_TRUE(fixture.supervisor.registry[2].is_heard);
}

static void a_report_of_a_previous_life_is_dropped(void)
{
    fixture_open_up();
    fixture_report(FIXTURE_GROUND, PUS_SERVICE_TEST, 2U, NULL, 0U);
    message_take_control(&fixture.endpoint); // The report waits in the inbox.
    message_set_life(&fixture.endpoint, COMMUNICATION_APID, 9U);
    fixture_step();
    fixture_expect("");
    TEST_ASSERT_EQUAL(1U, fixture.endpoint.counters.stale);
}

static void a_start_that_fails_is_reported(void)
{
    fixture_open_up();
    (void)process_tc(PUS_MISSION_STOP_PROCESS, LONE);
    fixture_run(2U);
    fixture_forget();
    fixture.start_result = STATUS_NOT_FOUND;
    (void)process_tc(PUS_MISSION_START_PROCESS, LONE);
    fixture_run(2U);
    fixture_expect("G 1.1 #1\nG 1.3 #1\nG 1.7 #1\nG 131.2 010001\nG 5.1 00040100\n");
    TEST_ASSERT_EQUAL(PROCESS_LOST, fixture.supervisor.registry[2].process);
}

// ---- Reports of members about themselves ----

static void reports_of_unknown_states_are_ignored(void)
{
    static const uint8_t states[] = {10U, 11U, 128U, 255U};
    fixture_open_up();
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL);
    for (unsigned i = 0U; i < sizeof states; i++) {
        const pus_transition_t made         = {.state = states[i], .phase = 0U};
        const pus_subsystem_status_t status = {.state = states[i], .phase = 0U};
        const pus_transition_t phase        = {.state = 3U, .phase = states[i]};
        (void)pus_transition_report(&fixture.members[FIXTURE_ARM].process, &made, fixture.now_ns);
        (void)pus_subsystem_status_report(&fixture.members[FIXTURE_ARM].process, PUS_USER_GROUND, &status,
                                          fixture.now_ns);
        (void)pus_transition_report(&fixture.members[FIXTURE_ARM].process, &phase, fixture.now_ns);
        fixture_step();
        TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, fixture.supervisor.registry[0].state);
        // The permission adds up the power of all subsystems in their states, which index a table.
        (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
        fixture_run(2U);
    }
}

static void the_supervisors_counters_are_parameters(void)
{
    fixture_open_up();
    fixture_link_up(STATE_PRE_OPERATIONAL);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_PARAMETERS, 1U, "\1\0\x38\0\0", 5U);
    fixture_run(3U);
    // Mode 1, log 0, 5 subsystems, 1 network, 2 links, 0 pending.
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), "G 20.2 00010038000001000005000100020000"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(supervisor_and_communication_start_without_a_request);
    RUN_TEST(no_subsystem_gets_an_order_before_its_first_report);
    RUN_TEST(an_autostart_subsystem_at_the_first_position_of_the_table_starts);
    RUN_TEST(communication_is_started_again_after_a_command_to_offline);
    RUN_TEST(members_get_a_heartbeat_once_a_second);
    RUN_TEST(the_subsystem_with_the_shortest_time_out_sets_the_interval);
    RUN_TEST(a_mission_shuts_down_with_communication_last);
    RUN_TEST(a_stop_request_shuts_the_mission_down);
    RUN_TEST(a_stop_request_right_after_the_start_is_obeyed);
    RUN_TEST(the_shutdown_waits_a_limited_time_for_the_first_member);
    RUN_TEST(the_shutdown_waits_a_limited_time_for_any_member);
    RUN_TEST(the_mission_shuts_down_without_communication);
    RUN_TEST(the_shutdown_ends_unanswered_requests);
    RUN_TEST(a_second_shutdown_is_refused);
    RUN_TEST(no_recovery_plan_starts_during_the_shutdown);
    RUN_TEST(modes_are_set_and_reported);
    RUN_TEST(the_log_is_switched_at_a_record);
    RUN_TEST(unknown_strategies_are_refused);
    RUN_TEST(a_log_that_fails_is_reported_once_and_continues_in_the_ring);
    RUN_TEST(a_log_that_can_be_written_again_is_reported);
    RUN_TEST(subsystems_are_listed);
    RUN_TEST(processes_are_stopped_and_started);
    RUN_TEST(a_request_to_start_or_stop_is_refused_where_it_is_not_permitted);
    RUN_TEST(requests_to_a_stopped_process_end);
    RUN_TEST(a_request_that_has_ended_is_not_answered);
    RUN_TEST(reports_of_a_dead_life_do_not_count_for_the_next);
    RUN_TEST(a_report_of_a_previous_life_is_dropped);
    RUN_TEST(a_start_that_fails_is_reported);
    RUN_TEST(reports_of_unknown_states_are_ignored);
    RUN_TEST(the_supervisors_counters_are_parameters);
    return UNITY_END();
}
