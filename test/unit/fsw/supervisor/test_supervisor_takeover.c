// SPDX-License-Identifier: Apache-2.0
// Everything that one life of the supervisor leaves to the next is restored before its first step.
#include "fsw/supervisor/supervisor.h"
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

static checkpoint_t checkpoint;
static supervisor_config_t configuration;
static supervisor_t former;
static const supervisor_t* const successor = &fixture.supervisor;

/// The endpoint returns a position for every index, as if it had more channels than there can be.
static bool has_endless_channels;

bool __real_message_position(const message_endpoint_t* endpoint, size_t index,
                             message_position_t* out_position);
bool __wrap_message_position(const message_endpoint_t* endpoint, size_t index,
                             message_position_t* out_position)
{
    TEST_ASSERT_TRUE(index < MESSAGE_PEERS_MAX);
    return __real_message_position(endpoint, has_endless_channels ? 0U : index, out_position);
}

static void configure(supervisor_config_t* config)
{
    config->checkpoint = &checkpoint;
    configuration      = *config;
}

/// ARM and HAND are being recommissioned; LONE answers no requests.
void setUp(void)
{
    (void)memset(&checkpoint, 0, sizeof checkpoint);
    fixture_configure = configure;
    fixture_open_up();
    fixture_link_up(STATE_OPERATIONAL);
    for (uint16_t i = 0U; i < fixture.supervisor.mission->subsystem_count; i++) {
        ((mission_subsystem_t*)fixture.supervisor.registry[i].mission)->is_recommissioned = true;
    }
    fixture.members[FIXTURE_ARM].is_running  = false;
    fixture.members[FIXTURE_LONE].is_passive = true;
    fixture.supervisor.orbit_period_ms       = 100U;
    fixture_run(10U);
}

void tearDown(void)
{
    fixture_close();
}

static void take_over(void)
{
    static message_slot_t inbox[sizeof fixture.inbox / sizeof fixture.inbox[0]];
    former = fixture.supervisor;
    osal_file_close(&fixture.supervisor.log.file); // The system closes the file of a dead process.
    (void)memset(&fixture.supervisor, 0, sizeof fixture.supervisor);
    message_open(&fixture.endpoint, SUPERVISOR_APID, 2U, fixture.endpoint.carrier, inbox,
                 sizeof inbox / sizeof inbox[0]);
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&fixture.endpoint, fixture.members[i].apid));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_init(&fixture.supervisor, &configuration));
}

static void the_tables_of_links_are_restored(void)
{
    fixture.supervisor.renewals[2]     = 2U;
    fixture.supervisor.wanted[2].depth = 9U;
    fixture.supervisor.accepted[2]     = (link_edge_t){.link = 3U, .ends = {ARM, 1U, LONE, 3U}};
    fixture_run(2U);
    take_over();
    TEST_ASSERT_TRUE((former.link_epoch > 0U) && (former.link_transaction > 0U) && (former.renewed > 0U));
    TEST_ASSERT_EQUAL_UINT32(former.link_epoch, successor->link_epoch);
    TEST_ASSERT_EQUAL_UINT32(former.link_transaction, successor->link_transaction);
    TEST_ASSERT_EQUAL_HEX32(former.renewed, successor->renewed);
    TEST_ASSERT_EQUAL_MEMORY(former.renewals, successor->renewals, sizeof former.renewals);
    TEST_ASSERT_EQUAL_MEMORY(former.wanted, successor->wanted, sizeof former.wanted);
    TEST_ASSERT_EQUAL_MEMORY(former.accepted, successor->accepted, sizeof former.accepted);
    TEST_ASSERT_EQUAL_MEMORY(&former.graph, &successor->graph, sizeof former.graph);
    TEST_ASSERT_EQUAL_MEMORY(former.sessions, successor->sessions, sizeof former.sessions);
}

static void requests_plans_and_counters_are_restored(void)
{
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture.supervisor.orbit_period_ms = 7000U;
    fixture.supervisor.mode            = MODE_SAFE;
    fixture_run(2U);
    take_over();
    TEST_ASSERT_EQUAL(1U, former.pending.count);
    TEST_ASSERT_TRUE(former.plans.runs[0].member_count > 0U); // The death of ARM has started this run.
    TEST_ASSERT_EQUAL_MEMORY(&former.plans, &successor->plans, sizeof former.plans);
    TEST_ASSERT_EQUAL_MEMORY(&former.pending, &successor->pending, sizeof former.pending);
    TEST_ASSERT_EQUAL_MEMORY(&former.counters, &successor->counters, sizeof former.counters);
    TEST_ASSERT_EQUAL_UINT32(7000U, successor->orbit_state.period_ms);
    TEST_ASSERT_TRUE((former.orbit_state.since_ns > 0U) && (former.orbit_state.position > 0U));
    TEST_ASSERT_EQUAL_UINT64(former.orbit_state.since_ns, successor->orbit_state.since_ns);
    TEST_ASSERT_EQUAL_UINT64(former.orbit_state.position, successor->orbit_state.position);
    TEST_ASSERT_EQUAL_UINT32(former.lives + 1U, successor->lives);
    TEST_ASSERT_EQUAL_UINT64(former.now_ns, successor->now_ns);
    TEST_ASSERT_EQUAL_UINT64(former.now_ns, subsystem_now_ns(&successor->subsystem));
    TEST_ASSERT_EQUAL(MODE_SAFE, successor->mode);
    TEST_ASSERT_TRUE(successor->is_continued);
    TEST_ASSERT_EQUAL_UINT64(former.log.next_number, successor->log.next_number);
    TEST_ASSERT_EQUAL_UINT64(former.log.written_number, successor->log.written_number);
    TEST_ASSERT_EQUAL(former.log.wanted, successor->log.wanted);
}

/// The next life sets its parameters to their initial values; what was counted before stays counted.
static void counters_continue_in_the_next_life(void)
{
    fixture.supervisor.counters.tc_forbidden = 1000U;
    fixture.supervisor.counters.tm_routed    = 2000U;
    fixture_run(2U);
    take_over();
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&successor->subsystem));
    TEST_ASSERT_EQUAL_UINT32(1000U, successor->counters.tc_forbidden);
    TEST_ASSERT_TRUE(successor->counters.tm_routed > 2000U);
}

static void expect_same_state(const registry_entry_t* before, const registry_entry_t* after)
{
    TEST_ASSERT_EQUAL(before->process, after->process);
    TEST_ASSERT_EQUAL(before->is_heard, after->is_heard);
    TEST_ASSERT_EQUAL(before->state, after->state);
    TEST_ASSERT_EQUAL(before->phase, after->phase);
    TEST_ASSERT_EQUAL(before->configuration, after->configuration);
    TEST_ASSERT_EQUAL(before->is_order_pending, after->is_order_pending);
    TEST_ASSERT_EQUAL(before->ordered, after->ordered);
    TEST_ASSERT_EQUAL(before->order_cause, after->order_cause);
    TEST_ASSERT_EQUAL(before->process == PROCESS_RUNNING, after->is_state_adopted);
    TEST_ASSERT_EQUAL(before->process == PROCESS_RUNNING, after->are_links_adopted);
}

static void the_data_of_members_are_restored(void)
{
    fixture.members[FIXTURE_HAND].interface_offset     = 1U;
    fixture.members[FIXTURE_HAND].configuration_offset = 2U;
    fixture_run(110U); // The member reports its status every 50 ticks.
    take_over();
    for (uint16_t i = 0U; i < former.mission->subsystem_count; i++) {
        const registry_entry_t* const before = &former.registry[i];
        const registry_entry_t* const after  = &successor->registry[i];
        TEST_ASSERT_EQUAL(before->deaths, after->deaths);
        if (before->mission->apid == SUPERVISOR_APID) {
            TEST_ASSERT_EQUAL(1U, after->restarts); // Of the supervisor itself.
            continue;                               // A restarted member begins in OFFLINE.
        }
        TEST_ASSERT_EQUAL(before->restarts, after->restarts);
        expect_same_state(before, after);
        TEST_ASSERT_EQUAL_UINT64(before->heard_ns, after->heard_ns);
        TEST_ASSERT_EQUAL_UINT64(before->started_ns, after->started_ns);
        TEST_ASSERT_EQUAL_HEX64(before->interface_hash, after->interface_hash);
        TEST_ASSERT_EQUAL_HEX64(before->configuration_hash, after->configuration_hash);
        TEST_ASSERT_EQUAL(before->is_interface_mismatched, after->is_interface_mismatched);
        TEST_ASSERT_EQUAL_UINT64(before->error_ns, after->error_ns);
        TEST_ASSERT_EQUAL(before->rested, after->rested);
        TEST_ASSERT_EQUAL(before->rested_with, after->rested_with);
        TEST_ASSERT_EQUAL(before->is_restarted, after->is_restarted);
        TEST_ASSERT_EQUAL(before->is_start_due, after->is_start_due);
        TEST_ASSERT_EQUAL_UINT64(before->restart_ns, after->restart_ns);
        TEST_ASSERT_EQUAL_MEMORY(&before->recommission, &after->recommission, sizeof before->recommission);
    }
    TEST_ASSERT_EQUAL(1U, successor->registry[0].restarts);
    TEST_ASSERT_TRUE(successor->registry[1].is_interface_mismatched);
}

/// Let LONE die, and tick until the supervisor has reacted.
static void lose_lone(void)
{
    fixture.members[FIXTURE_LONE].is_running = false;
    fixture_run(2U);
}

/// Over the whole flight LONE was started more often than its budget permits within the restart period.
static void a_start_that_was_due_is_performed_by_the_next_supervisor(void)
{
    mission_subsystem_t* const lone = (mission_subsystem_t*)fixture.supervisor.registry[2].mission;
    lone->restart_budget            = 2U;
    lone->restart_period_us         = 500000U;
    for (unsigned i = 0U; i < 3U; i++) {
        fixture_run(60U);
        lose_lone();
    }
    lose_lone(); // The second death within the period: the next start is due in 100 ms.
    const unsigned starts = fixture.starts;
    take_over();
    TEST_ASSERT_EQUAL(PROCESS_LOST, successor->registry[2].process);
    TEST_ASSERT_EQUAL(3U, successor->registry[2].restarts);
    TEST_ASSERT_EQUAL(2U, successor->registry[2].deaths);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(starts, fixture.starts);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(starts + 1U, fixture.starts);
    TEST_ASSERT_EQUAL(PROCESS_RUNNING, successor->registry[2].process);
}

static void a_start_that_failed_is_not_repeated_by_the_next_supervisor(void)
{
    mission_subsystem_t* const lone = (mission_subsystem_t*)fixture.supervisor.registry[2].mission;
    lone->restart_budget            = 2U;
    fixture.start_result            = STATUS_NOT_FOUND;
    lose_lone();
    fixture.start_result = STATUS_OK;
    take_over();
    TEST_ASSERT_EQUAL(PROCESS_LOST, successor->registry[2].process);
    const unsigned starts = fixture.starts;
    fixture_run(200U);
    TEST_ASSERT_EQUAL(starts, fixture.starts);
}

/// LONE has not answered the request for its status, so its known state may be older than its silence.
static void a_doubt_continues_and_the_status_is_requested_again(void)
{
    fixture_run(101U);
    fixture.supervisor.registry[2].doubt         = DOUBT_ASKED;
    fixture.supervisor.registry[2].asked.time_ns = fixture.now_ns;
    fixture_run(1U);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, fixture.supervisor.registry[2].doubt);
    take_over();
    TEST_ASSERT_TRUE(supervisor_doubt_exists(&successor->registry[2]));
    TEST_ASSERT_FALSE(supervisor_doubt_exists(&successor->registry[1]));
    fixture_forget();
    fixture_run(2U);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, successor->registry[2].doubt);
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.4"));
}

static const pus_token_t of_session  = {.request_id = 0x1801C001U, .source = 1U, .ack = PUS_ACK_ALL};
static const pus_token_t of_shutdown = {.request_id = 0x1801C002U, .source = 3U, .ack = PUS_ACK_ALL};

/// Returns true if a request of this source with this number continues after a takeover. Otherwise the next
/// supervisor must end it.
static bool goes_on(const uint32_t request_id, const uint16_t source)
{
    const pus_token_t token = {.request_id = request_id, .source = source, .ack = PUS_ACK_ALL};
    pus_token_t taken;
    supervisor_pending_init(&fixture.supervisor.own);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_pending_add(&fixture.supervisor.own, SUPERVISOR_APID, &token,
                                                        fixture.supervisor.now_ns));
    supervisor_adoption_commit(&fixture.supervisor);
    take_over();
    const bool is_left = supervisor_pending_take(&fixture.supervisor.left, SUPERVISOR_APID, &taken);
    TEST_ASSERT_EQUAL(is_left, !supervisor_pending_take(&fixture.supervisor.own, SUPERVISOR_APID, &taken));
    TEST_ASSERT_EQUAL_HEX32(request_id, taken.request_id);
    return !is_left;
}

static void only_the_requests_of_sessions_and_of_the_shutdown_continue(void)
{
    TEST_ASSERT_FALSE(goes_on(of_session.request_id, of_session.source));
    TEST_ASSERT_FALSE(goes_on(of_shutdown.request_id, of_shutdown.source));
    fixture.supervisor.sessions[1]        = (link_session_t){.step        = SESSION_CLOSING,
                                                             .link        = LINK_LONE_STATE,
                                                             .ends        = {ARM, 1U, LONE, 3U},
                                                             .token       = of_session,
                                                             .deadline_ns = fixture.now_ns + 1000000000U};
    fixture.supervisor.has_shutdown_token = true;
    fixture.supervisor.shutdown_token     = of_shutdown;
    TEST_ASSERT_TRUE(goes_on(of_session.request_id, of_session.source));
    TEST_ASSERT_TRUE(goes_on(of_shutdown.request_id, of_shutdown.source));
    // Each user numbers its own requests, so both the number and the user must be the same.
    TEST_ASSERT_FALSE(goes_on(of_session.request_id, of_shutdown.source));
    TEST_ASSERT_FALSE(goes_on(of_session.request_id + 9U, of_session.source));
    TEST_ASSERT_FALSE(goes_on(of_shutdown.request_id, of_session.source));
    TEST_ASSERT_FALSE(goes_on(of_shutdown.request_id + 9U, of_shutdown.source));
}

static void a_commit_keeps_no_more_channels_than_it_has_room_for(void)
{
    has_endless_channels = true;
    supervisor_adoption_commit(&fixture.supervisor);
    has_endless_channels = false;
    TEST_ASSERT_EQUAL_UINT16(MESSAGE_PEERS_MAX, fixture.supervisor.checkpoint_state.channel_count);
    supervisor_adoption_commit(&fixture.supervisor);
    TEST_ASSERT_EQUAL_UINT16(FIXTURE_MEMBERS, fixture.supervisor.checkpoint_state.channel_count);
}

static void reports_that_wait_for_the_ground_wait_again(void)
{
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 200U; i++) {
        fixture_report(FIXTURE_HAND, PUS_SERVICE_HOUSEKEEPING, 25U, "abc", 3U);
        fixture_run(1U);
    }
    take_over();
    for (size_t i = 0U; i < PUS_CLASSES; i++) {
        TEST_ASSERT_EQUAL(former.ground_backlog.queues[i].span, successor->ground_backlog.queues[i].span);
        TEST_ASSERT_EQUAL_UINT32(former.ground_backlog.queues[i].octets,
                                 successor->ground_backlog.queues[i].octets);
    }
    TEST_ASSERT_TRUE(successor->ground_backlog.queues[PUS_CLASS_BULK].span > 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reports_that_wait_for_the_ground_wait_again);
    RUN_TEST(the_tables_of_links_are_restored);
    RUN_TEST(requests_plans_and_counters_are_restored);
    RUN_TEST(counters_continue_in_the_next_life);
    RUN_TEST(the_data_of_members_are_restored);
    RUN_TEST(a_start_that_was_due_is_performed_by_the_next_supervisor);
    RUN_TEST(a_start_that_failed_is_not_repeated_by_the_next_supervisor);
    RUN_TEST(a_doubt_continues_and_the_status_is_requested_again);
    RUN_TEST(only_the_requests_of_sessions_and_of_the_shutdown_continue);
    RUN_TEST(a_commit_keeps_no_more_channels_than_it_has_room_for);
    return UNITY_END();
}
