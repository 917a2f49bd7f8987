// SPDX-License-Identifier: Apache-2.0
// The services for the whole spacecraft use no more than the supervisor's descriptor grants.
#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "test/unit/fsw/supervisor/releases.h"
#include "unity.h"

#include <string.h>

#define GRANTED 2U
#define LATER_NS 60000000000ULL

static subsystem_descriptor_t granting;

static const uint8_t types[] = {
    PUS_SERVICE_TIME_SCHEDULE, PUS_SERVICE_STORAGE,   PUS_SERVICE_PROCEDURES, PUS_SERVICE_POSITION_SCHEDULE,
    PUS_SERVICE_EVENT_ACTION,  PUS_SERVICE_SEQUENCES, PUS_SERVICE_FILES};

/// Grant two entries to each service; the rest of the descriptor is not changed.
static void grant_little(supervisor_config_t* config)
{
    (void)memcpy(&granting, config->descriptor, sizeof granting);
    descriptor_subsystem_use_storage(&granting);
    for (size_t i = 0U; i < granting.service_count; i++) {
        granting.storage.services[i].capacity = granting.services[i].is_of_spacecraft ? GRANTED : 4U;
    }
    config->descriptor = &granting;
}

void setUp(void)
{
    fixture_configure = grant_little;
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

static void each_service_receives_its_capacity(void)
{
    for (size_t i = 0U; i < sizeof types; i++) {
        TEST_ASSERT_EQUAL_UINT16(GRANTED, spacecraft_capacity(&fixture.supervisor, types[i], 64U));
        // The result is at most the capacity that the caller has.
        TEST_ASSERT_EQUAL_UINT16(1U, spacecraft_capacity(&fixture.supervisor, types[i], 1U));
    }
    granting.service_count = 0U;
    TEST_ASSERT_EQUAL_UINT16(64U, spacecraft_capacity(&fixture.supervisor, PUS_SERVICE_FILES, 64U));
    TEST_ASSERT_EQUAL_UINT16(GRANTED,
                             fixture.supervisor.spacecraft.schedules.time.schedule.config.activity_count);
    TEST_ASSERT_EQUAL_UINT16(GRANTED,
                             fixture.supervisor.spacecraft.schedules.position.schedule.config.activity_count);
}

static void activities_above_the_capacity_are_refused(void)
{
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    for (uint16_t i = 0U; i < GRANTED; i++) {
        release_at(fixture.now_ns + LATER_NS, LONE, i);
    }
    fixture_run(1U);
    fixture_expect("");
    release_at(fixture.now_ns + LATER_NS, LONE, GRANTED);
    fixture_run(1U);
    fixture_expect("G 1.4 #6 0205 2\n"); // PUS_FAILURE_TABLE_FULL, and the granted number.
}

static void actions_above_the_capacity_are_refused(void)
{
    for (uint16_t i = 0U; i < GRANTED; i++) {
        release_on((uint16_t)(1U + i), LONE, i);
    }
    fixture_run(1U);
    fixture_expect("");
    release_on(1U + GRANTED, LONE, GRANTED);
    fixture_run(1U);
    fixture_expect("G 1.4 #6 0205 2\nG 1.4 #7 0201 100003\n"); // Without entries there is nothing to enable.
}

static uint16_t take_until_it_warns(pool_t* pool)
{
    uint16_t count = 0U;
    while (!pool->stats.warning) {
        TEST_ASSERT_NOT_NULL(pool_take(pool));
        count++;
    }
    return count;
}

/// Memory for requests and sequences: when three quarters of one are in use, an event is raised; the peaks
/// are parameters.
static void pools_of_requests_warn_and_are_reported(void)
{
    const supervisor_blocks_t* const blocks = &fixture.supervisor.blocks;
    const uint16_t requests = take_until_it_warns(&fixture.supervisor.spacecraft.schedules.chains.pool);
    TEST_ASSERT_EQUAL_UINT16((SPACECRAFT_REQUEST_BLOCKS * 3U) / 4U, requests);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 5.2 0005"));
    fixture_forget();
    fixture_run(50U);
    TEST_ASSERT_FALSE(fixture_has("G 5.2"));
    const uint16_t sequences = take_until_it_warns(&fixture.supervisor.spacecraft.sequences.chains.pool);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 5.2 0005"));
    while (pool_take(&fixture.supervisor.spacecraft.sequences.chains.pool) != NULL) {
        TEST_ASSERT_TRUE(sequences < SPACECRAFT_SEQUENCE_BLOCKS);
    }
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT16(requests, blocks->request_peak);
    TEST_ASSERT_EQUAL_UINT16(SPACECRAFT_SEQUENCE_BLOCKS, blocks->sequence_peak);
    TEST_ASSERT_EQUAL_UINT32(0U, blocks->request_refused);
    TEST_ASSERT_EQUAL_UINT32(1U, blocks->sequence_refused);
}

static void a_subsystem_after_the_last_one_of_the_mission_does_not_exist(void)
{
    const mission_descriptor_t* const mission = fixture.supervisor.mission;
    const uint16_t behind                     = mission->subsystem_count;
    TEST_ASSERT_TRUE(behind < MISSION_SUBSYSTEMS_MAX);
    mission_subsystem_t* const subsystem = (mission_subsystem_t*)&mission->subsystems[behind];
    const uint16_t apid                  = subsystem->apid;
    subsystem->apid                      = 99U;
    TEST_ASSERT_NULL(supervisor_registry_find(&fixture.supervisor, 99U));
    subsystem->apid = apid;
    TEST_ASSERT_EQUAL_PTR(
        &fixture.supervisor.registry[behind - 1U],
        supervisor_registry_find(&fixture.supervisor, mission->subsystems[behind - 1U].apid));
}

/// In a mission with the largest number of subsystems, the last one cannot be started.
static void a_failed_start_of_the_last_possible_subsystem_is_noticed(void)
{
    mission_descriptor_t* const mission = (mission_descriptor_t*)fixture.supervisor.mission;
    const uint16_t count                = mission->subsystem_count;
    mission_subsystem_t* const last = (mission_subsystem_t*)&mission->subsystems[MISSION_SUBSYSTEMS_MAX - 1U];
    registry_entry_t* const entry   = &fixture.supervisor.registry[MISSION_SUBSYSTEMS_MAX - 1U];
    mission->subsystem_count        = MISSION_SUBSYSTEMS_MAX;
    last->apid                      = 99U;
    entry->mission                  = last;
    entry->process                  = PROCESS_RUNNING;
    supervisor_output_commit_start(&fixture.supervisor, entry);
    TEST_ASSERT_FALSE(supervisor_output_commit_perform(&fixture.supervisor));
    TEST_ASSERT_EQUAL(PROCESS_LOST, entry->process); // The fixture has no such process.
    TEST_ASSERT_EQUAL(PROCESS_RUNNING, fixture.supervisor.registry[count - 1U].process);
    *last                    = (mission_subsystem_t){.apid = 0U};
    *entry                   = (registry_entry_t){.mission = NULL};
    mission->subsystem_count = count;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_service_receives_its_capacity);
    RUN_TEST(activities_above_the_capacity_are_refused);
    RUN_TEST(actions_above_the_capacity_are_refused);
    RUN_TEST(pools_of_requests_warn_and_are_reported);
    RUN_TEST(a_subsystem_after_the_last_one_of_the_mission_does_not_exist);
    RUN_TEST(a_failed_start_of_the_last_possible_subsystem_is_noticed);
    return UNITY_END();
}
