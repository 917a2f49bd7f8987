// SPDX-License-Identifier: Apache-2.0
// Conditions of the autostart and of the shutdown that never change in the missions of the other tests. Here
// each of them alone decides the result (make mcdc).
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#define UNKNOWN 99U
#define TO_OFFLINE 2U // Step of the shutdown in which all but communication go to OFFLINE.

static mission_subsystem_t* mission_of(const uint16_t apid)
{
    const registry_entry_t* const entry = supervisor_registry_find(&fixture.supervisor, apid);
    TEST_ASSERT_NOT_NULL(entry);
    return (mission_subsystem_t*)(uintptr_t)entry->mission; // Static storage of the fixture.
}

/// No member answers or reports a state, so the registry keeps the states that a test sets.
void setUp(void)
{
    fixture_open_up();
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        fixture.members[i].is_passive = true;
        fixture.members[i].is_silent  = true;
    }
}

void tearDown(void)
{
    fixture_close(); // The next setUp loads the mission again.
}

// ---- Autostart ----

/// Perform the autostart once, from its beginning. Returns true if it has ended.
static bool autostart(void)
{
    fixture.supervisor.autostart_step = 0U;
    fixture_forget();
    supervisor_sequence_autostart(&fixture.supervisor);
    return fixture.supervisor.autostart_step != 0U;
}

static void an_order_is_given_only_at_rest_and_only_for_the_next_state(void)
{
    static const struct {
        state_t state;
        state_phase_t phase;
        const char* order;
        bool is_up;
    } cases[] = {
        {STATE_OFFLINE, PHASE_IDLE, "16 TC 129.8 0300", false},
        {STATE_PRE_OPERATIONAL, PHASE_UNCONFIGURED, "16 TC 129.3 0001", false},
        {STATE_PRE_OPERATIONAL, PHASE_CONFIGURING, NULL, false},
        {STATE_PRE_OPERATIONAL, PHASE_CONFIGURED, "16 TC 129.8 0400", false},
        {STATE_SAFE_OPERATIONAL, PHASE_ENTERING, NULL, false},
        {STATE_SAFE_OPERATIONAL, PHASE_IDLE, "16 TC 129.8 0500", false},
        {STATE_OPERATIONAL, PHASE_LEAVING, NULL, false},
        {STATE_OPERATIONAL, PHASE_IDLE, NULL, true},
    };
    registry_entry_t* const arm   = supervisor_registry_find(&fixture.supervisor, ARM);
    mission_of(ARM)->is_autostart = true;
    for (unsigned i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        arm->state = cases[i].state;
        arm->phase = cases[i].phase;
        TEST_ASSERT_EQUAL(cases[i].is_up, autostart());
        fixture.supervisor.autostart_step = 1U; // The step gives no further order.
        fixture_step();
        TEST_ASSERT_EQUAL((cases[i].order != NULL), fixture_has("16 TC"));
        TEST_ASSERT_TRUE((cases[i].order == NULL) || fixture_has(cases[i].order));
    }
}

static void a_subsystem_without_configurations_is_not_started(void)
{
    registry_entry_t* const arm        = supervisor_registry_find(&fixture.supervisor, ARM);
    const uint16_t configuration_count = mission_of(ARM)->configuration_count;
    mission_of(ARM)->is_autostart      = true;
    arm->state                         = STATE_OFFLINE;
    TEST_ASSERT_FALSE(autostart());
    mission_of(ARM)->configuration_count = 0U;
    TEST_ASSERT_TRUE(autostart());
    mission_of(ARM)->configuration_count = configuration_count;
}

/// Returns true if an autostart that has ended begins again.
static bool begins_again(void)
{
    fixture.supervisor.autostart_step = 1U;
    supervisor_sequence_autostart(&fixture.supervisor);
    return fixture.supervisor.autostart_step == 0U;
}

static void the_autostart_begins_again_only_for_a_communication_that_the_mission_starts(void)
{
    mission_of(ARM)->is_autostart = true; // It is OFFLINE, so an autostart that begins does not end at once.
    mission_subsystem_t* const communication                                 = mission_of(COMMUNICATION_APID);
    supervisor_registry_find(&fixture.supervisor, COMMUNICATION_APID)->state = STATE_OFFLINE;
    TEST_ASSERT_TRUE(begins_again());
    communication->is_autostart = false;
    TEST_ASSERT_FALSE(begins_again());
    communication->is_autostart = true;
    communication->apid         = UNKNOWN; // A mission without communication.
    TEST_ASSERT_FALSE(begins_again());
}

// ---- Shutdown ----

static void a_mission_that_has_no_communication_shuts_down(void)
{
    supervisor_registry_find(&fixture.supervisor, COMMUNICATION_APID)->state = STATE_OFFLINE;
    mission_of(COMMUNICATION_APID)->apid                                     = UNKNOWN;
    fixture.is_stop_requested                                                = true;
    fixture_run(30U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static bool is_ordered_back(const uint16_t apid)
{
    registry_entry_t* const entry = supervisor_registry_find(&fixture.supervisor, apid);
    entry->ordered                = STATE_COUNT;
    supervisor_sequence_left_offline(&fixture.supervisor, entry);
    return entry->ordered == STATE_OFFLINE;
}

static void only_a_running_subsystem_except_communication_is_ordered_back_to_offline(void)
{
    fixture.supervisor.shutdown_step = TO_OFFLINE - 1U;
    TEST_ASSERT_FALSE(is_ordered_back(ARM));
    fixture.supervisor.shutdown_step = TO_OFFLINE;
    TEST_ASSERT_TRUE(is_ordered_back(ARM));
    TEST_ASSERT_FALSE(is_ordered_back(COMMUNICATION_APID)); // It goes to OFFLINE last.
    supervisor_registry_find(&fixture.supervisor, ARM)->process = PROCESS_STOPPED;
    TEST_ASSERT_FALSE(is_ordered_back(ARM));
    fixture.supervisor.shutdown_step = 0U;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_order_is_given_only_at_rest_and_only_for_the_next_state);
    RUN_TEST(a_subsystem_without_configurations_is_not_started);
    RUN_TEST(the_autostart_begins_again_only_for_a_communication_that_the_mission_starts);
    RUN_TEST(a_mission_that_has_no_communication_shuts_down);
    RUN_TEST(only_a_running_subsystem_except_communication_is_ordered_back_to_offline);
    return UNITY_END();
}
