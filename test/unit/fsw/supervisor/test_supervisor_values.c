// SPDX-License-Identifier: Apache-2.0
// Values that the supervisor publishes: in every cycle each value is read from its source.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void the_status_counts_members_links_networks_requests_and_records(void)
{
    const supervisor_status_t* const status = &fixture.supervisor.status;
    TEST_ASSERT_EQUAL(MODE_NOMINAL, status->mode);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, status->log_strategy);
    TEST_ASSERT_EQUAL(5U, status->subsystems);
    TEST_ASSERT_EQUAL(0U, status->links);
    TEST_ASSERT_EQUAL(0U, status->networks);
    TEST_ASSERT_EQUAL(0U, status->pending);
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_LONE].is_passive = true;
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(2U, status->links);
    TEST_ASSERT_EQUAL(1U, status->networks); // Both links connect the same members.
    TEST_ASSERT_EQUAL(2U, status->pending);
    TEST_ASSERT_EQUAL_UINT64(fixture.supervisor.log.next_number - 1U, status->records);
    const link_edge_t edge = {.link = LINK_LONE_STATE, .ends = {LONE, 1U, 99U, 1U}};
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_link_graph_add(&fixture.supervisor.graph, &edge));
    fixture_run(1U);
    TEST_ASSERT_EQUAL(3U, status->links);
    TEST_ASSERT_EQUAL(2U, status->networks);
}

/// A message of an ended life is counted as stale, but an empty message is always counted as malformed.
static void an_empty_message_from_any_sender_is_malformed(void)
{
    const uint32_t malformed               = fixture.supervisor.counters.tm_malformed;
    const uint32_t stale                   = fixture.endpoint.counters.stale;
    fixture.supervisor.registry[0].process = PROCESS_LOST;
    fixture_send(FIXTURE_ARM, (const uint8_t*)"", 0U);
    fixture_send(FIXTURE_ARM, (const uint8_t*)"\x08", 1U);
    fixture_step();
    TEST_ASSERT_EQUAL_UINT32(malformed + 1U, fixture.supervisor.counters.tm_malformed);
    TEST_ASSERT_EQUAL_UINT32(stale + 1U, fixture.endpoint.counters.stale);
}

static void packets_are_counted_by_their_outcome(void)
{
    const supervisor_counters_t* const counters = &fixture.supervisor.counters;
    const supervisor_counters_t before          = *counters;
    fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 26U, "abc", 3U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(before.tm_routed + 1U, counters->tm_routed);
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(before.tc_routed + 1U, counters->tc_routed);
    // Three more reports: those about the request.
    TEST_ASSERT_EQUAL_UINT32(before.tm_routed + 4U, counters->tm_routed);
    fixture_send(FIXTURE_ARM, (const uint8_t*)"", 0U); // An empty message,
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(before.tm_malformed + 1U, counters->tm_malformed);
    fixture_send(FIXTURE_ARM, (const uint8_t*)"\x08", 1U); // a packet that is too short,
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(before.tm_malformed + 2U, counters->tm_malformed);
    TEST_ASSERT_EQUAL_UINT32(before.tm_routed + 4U, counters->tm_routed);
    TEST_ASSERT_EQUAL_UINT32(before.tc_malformed, counters->tc_malformed);
    const uint64_t records = fixture.supervisor.log.next_number;
    fixture_send(FIXTURE_GROUND, (const uint8_t*)"\x18", 1U); // a request that is too short.
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(before.tc_malformed + 1U, counters->tc_malformed);
    TEST_ASSERT_EQUAL_UINT32(before.tm_malformed + 2U, counters->tm_malformed);
    TEST_ASSERT_EQUAL_UINT64(records + 1U, fixture.supervisor.log.next_number);
    TEST_ASSERT_EQUAL_UINT32(before.tc_unroutable, counters->tc_unroutable);
    TEST_ASSERT_EQUAL_UINT32(before.tc_forbidden, counters->tc_forbidden);
    (void)fixture_tc(99U, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(before.tc_unroutable + 1U, counters->tc_unroutable);
    TEST_ASSERT_EQUAL_UINT32(before.tc_forbidden, counters->tc_forbidden);
}

static void figures_of_the_parts_of_the_supervisor_are_published(void)
{
    supervisor_t* const supervisor          = &fixture.supervisor;
    spacecraft_services_t* const spacecraft = &supervisor->spacecraft;
    subsystem_health_t health;
    supervisor->subsystem.call_tokens.stats.peak    = 41U;
    supervisor->subsystem.call_tokens.stats.refused = 42U;
    spacecraft->schedules.chains.pool.stats.peak    = 43U;
    spacecraft->schedules.chains.pool.stats.refused = 44U;
    spacecraft->sequences.chains.pool.stats.peak    = 45U;
    spacecraft->sequences.chains.pool.stats.refused = 46U;
    fixture.endpoint.counters.lost                  = 47U;
    fixture.endpoint.counters.stale                 = 48U;
    fixture.endpoint.counters.malformed             = 49U;
    fixture.endpoint.counters.overruns              = 50U;
    fixture.endpoint.counters.abandoned             = 51U;
    fixture.endpoint.counters.syncs                 = 52U;
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT32(41U, supervisor->counters.pool_peak);
    TEST_ASSERT_EQUAL_UINT32(42U, supervisor->counters.pool_refused);
    TEST_ASSERT_EQUAL_UINT16(43U, supervisor->blocks.request_peak);
    TEST_ASSERT_EQUAL_UINT32(44U, supervisor->blocks.request_refused);
    TEST_ASSERT_EQUAL_UINT16(45U, supervisor->blocks.sequence_peak);
    TEST_ASSERT_EQUAL_UINT32(46U, supervisor->blocks.sequence_refused);
    TEST_ASSERT_EQUAL_UINT32(47U, supervisor->messages.lost);
    TEST_ASSERT_EQUAL_UINT32(48U, supervisor->messages.stale);
    TEST_ASSERT_EQUAL_UINT32(49U, supervisor->messages.malformed);
    TEST_ASSERT_EQUAL_UINT32(50U, supervisor->messages.overruns);
    TEST_ASSERT_EQUAL_UINT32(51U, supervisor->messages.abandoned);
    TEST_ASSERT_EQUAL_UINT32(52U, supervisor->messages.syncs);
    subsystem_health(&supervisor->subsystem, &health);
    TEST_ASSERT_EQUAL_UINT32(health.events_suppressed, supervisor->counters.events_suppressed);
    TEST_ASSERT_EQUAL_UINT32(health.reports_lost, supervisor->counters.reports_lost);
}

static void a_pool_that_runs_short_raises_one_event(void)
{
    static bool* const news[] = {&fixture.supervisor.spacecraft.schedules.chains.pool.is_unpolled,
                                 &fixture.supervisor.spacecraft.sequences.chains.pool.is_unpolled};
    for (unsigned i = 0U; i < 2U; i++) {
        *news[i] = true;
        fixture_run(2U);
        TEST_ASSERT_FALSE(*news[i]);
        TEST_ASSERT_TRUE(fixture_has("G 5.2 "));
        fixture_forget();
        fixture_run(2U);
        TEST_ASSERT_FALSE(fixture_has("G 5.2 "));
    }
}

static uint64_t orbit_position(void)
{
    return ((uint64_t)fixture.supervisor.orbit.number << 16U) | fixture.supervisor.orbit.angle;
}

static void the_position_on_the_orbit_follows_its_period(void)
{
    fixture.supervisor.orbit_period_ms = 1000U;
    fixture_run(2U);
    const uint64_t before = orbit_position();
    fixture_run(150U); // One and a half orbits later.
    TEST_ASSERT_EQUAL_UINT64(before + 98304U, orbit_position());
    fixture.supervisor.orbit_period_ms = 2000U;
    fixture_run(1U);
    const uint64_t slower = orbit_position();
    fixture_run(100U);
    TEST_ASSERT_EQUAL_UINT64(slower + 32768U, orbit_position());
}

static void reports_that_wait_for_the_ground_are_counted_in_octets(void)
{
    const supervisor_ground_t* const ground = &fixture.supervisor.ground;
    TEST_ASSERT_EQUAL_UINT32(0U, ground->waiting_firm + ground->waiting_plain + ground->waiting_bulk);
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 200U; i++) {
        fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 25U, "abcdef", 6U);
        fixture_report(FIXTURE_ARM, PUS_SERVICE_TEST, 2U, NULL, 0U);
        fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, BROKEN);
        fixture_run(1U);
    }
    const ground_backlog_t* const backlog = &fixture.supervisor.ground_backlog;
    TEST_ASSERT_TRUE(ground->waiting_firm > 0U);
    TEST_ASSERT_TRUE(ground->waiting_plain > 0U);
    TEST_ASSERT_TRUE(ground->waiting_bulk > 0U);
    TEST_ASSERT_EQUAL_UINT32(backlog->queues[PUS_CLASS_FIRM].octets, ground->waiting_firm);
    TEST_ASSERT_EQUAL_UINT32(backlog->queues[PUS_CLASS_PLAIN].octets, ground->waiting_plain);
    TEST_ASSERT_EQUAL_UINT32(backlog->queues[PUS_CLASS_BULK].octets, ground->waiting_bulk);
    uint32_t peak    = 0U;
    uint32_t refused = 0U;
    for (size_t i = 0U; i < GROUND_SIZES; i++) {
        peak += backlog->blocks.pools[i].stats.peak;
        refused += backlog->blocks.pools[i].stats.refused;
    }
    TEST_ASSERT_TRUE(peak > 100U);
    TEST_ASSERT_EQUAL_UINT32(peak, ground->block_peak);
    TEST_ASSERT_EQUAL_UINT32(refused, ground->block_refused);
}

/// UNSECURED, the last phase, is accepted. It is no phase at rest, so its state is not recorded as rested.
static void the_last_phase_is_accepted_and_is_not_at_rest(void)
{
    const registry_entry_t* const lone = &fixture.supervisor.registry[2];
    const uint32_t malformed           = fixture.supervisor.counters.tm_malformed;
    TEST_ASSERT_EQUAL(LONE, lone->mission->apid);
    fixture.members[FIXTURE_LONE].state = STATE_ERROR_OPERATIONAL;
    fixture.members[FIXTURE_LONE].phase = PHASE_UNSECURED;
    fixture_run(60U);
    TEST_ASSERT_EQUAL(PHASE_UNSECURED, lone->phase);
    TEST_ASSERT_EQUAL_UINT32(malformed, fixture.supervisor.counters.tm_malformed);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, lone->rested);
    fixture.members[FIXTURE_LONE].state = STATE_OPERATIONAL;
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, lone->state);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, lone->rested);
    fixture.members[FIXTURE_LONE].phase = PHASE_IDLE;
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, lone->rested);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_last_phase_is_accepted_and_is_not_at_rest);
    RUN_TEST(the_status_counts_members_links_networks_requests_and_records);
    RUN_TEST(an_empty_message_from_any_sender_is_malformed);
    RUN_TEST(packets_are_counted_by_their_outcome);
    RUN_TEST(figures_of_the_parts_of_the_supervisor_are_published);
    RUN_TEST(a_pool_that_runs_short_raises_one_event);
    RUN_TEST(the_position_on_the_orbit_follows_its_period);
    RUN_TEST(reports_that_wait_for_the_ground_are_counted_in_octets);
    return UNITY_END();
}
