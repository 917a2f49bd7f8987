// SPDX-License-Identifier: Apache-2.0
// Limits of time and power of the supervisor: each is tested exactly, and just below or above it.
#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define MS 1000000ULL
#define TICK FIXTURE_TICK_NS

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static registry_entry_t* entry_of(uint16_t apid)
{
    return supervisor_registry_find(&fixture.supervisor, apid);
}

/// Make one step at this time. All members but `silent_apid` count as heard just before.
static void step_at(uint64_t now_ns, uint16_t silent_apid)
{
    for (uint16_t i = 0U; i < fixture.supervisor.mission->subsystem_count; i++) {
        registry_entry_t* const entry = &fixture.supervisor.registry[i];
        entry->heard_ns               = (entry->mission->apid == silent_apid) ? entry->heard_ns : now_ns;
    }
    fixture.now_ns = now_ns;
    fixture_step();
}

/// True if this event of the supervisor, whose first value is an APID, was raised for `apid`.
static bool has_event(uint16_t event, uint16_t apid)
{
    bool is_there = false;
    for (unsigned severity = 1U; severity <= 4U; severity++) {
        char line[32];
        (void)snprintf(line, sizeof line, "G 5.%u %04X%04X", severity, event, apid);
        is_there = is_there || fixture_has(line);
    }
    return is_there;
}

static void a_member_is_silent_after_more_than_three_seconds(void)
{
    fixture.members[FIXTURE_LONE].is_silent = true;
    fixture_run(2U);
    const uint64_t heard_ns = entry_of(LONE)->heard_ns;
    step_at(heard_ns + (3000U * MS), LONE);
    TEST_ASSERT_FALSE(has_event(SUPERVISOR_EVENT_SUBSYSTEM_SILENT, LONE));
    step_at(heard_ns + (3000U * MS) + TICK, LONE);
    TEST_ASSERT_TRUE(has_event(SUPERVISOR_EVENT_SUBSYSTEM_SILENT, LONE));
    fixture_forget();
    step_at(heard_ns + (6000U * MS) + TICK, LONE); // The event is raised again after more than 3 s.
    TEST_ASSERT_FALSE(has_event(SUPERVISOR_EVENT_SUBSYSTEM_SILENT, LONE));
    step_at(heard_ns + (6000U * MS) + (2U * TICK), LONE);
    TEST_ASSERT_TRUE(has_event(SUPERVISOR_EVENT_SUBSYSTEM_SILENT, LONE));
}

static void a_state_is_in_doubt_after_a_second_and_a_half(void)
{
    fixture.members[FIXTURE_LONE].is_silent  = true;
    fixture.members[FIXTURE_LONE].is_passive = true;
    fixture_run(2U);
    const uint64_t heard_ns = entry_of(LONE)->heard_ns;
    step_at(heard_ns + (1500U * MS), LONE);
    TEST_ASSERT_EQUAL(DOUBT_NONE, entry_of(LONE)->doubt);
    step_at(heard_ns + (1500U * MS) + TICK, LONE);
    TEST_ASSERT_EQUAL(DOUBT_SILENT, entry_of(LONE)->doubt);
    const uint64_t back_ns = heard_ns + (1500U * MS) + (2U * TICK);
    const uint32_t asked   = fixture.supervisor.reactions.asked;
    // When the member is heard, its status is requested, and again after more than a second.
    step_at(back_ns, 0U);
    TEST_ASSERT_EQUAL(DOUBT_ASKED, entry_of(LONE)->doubt);
    TEST_ASSERT_EQUAL_UINT32(asked + 1U, fixture.supervisor.reactions.asked);
    step_at(back_ns + (1000U * MS), 0U);
    TEST_ASSERT_EQUAL_UINT32(asked + 1U, fixture.supervisor.reactions.asked);
    step_at(back_ns + (1000U * MS) + TICK, 0U);
    TEST_ASSERT_EQUAL_UINT32(asked + 2U, fixture.supervisor.reactions.asked);
}

static void a_process_is_killed_when_its_step_is_later_than_its_timeout(void)
{
    const uint64_t timeout_ns = (uint64_t)entry_of(LONE)->mission->hang_after_us * 1000U;
    fixture.late_apid         = LONE;
    fixture.promise_ns        = fixture.now_ns + (10U * TICK);
    step_at(fixture.promise_ns, 0U);
    step_at(fixture.promise_ns + timeout_ns, 0U);
    TEST_ASSERT_EQUAL(0U, fixture.kills);
    step_at(fixture.promise_ns + timeout_ns + TICK, 0U);
    TEST_ASSERT_EQUAL(1U, fixture.kills);
    TEST_ASSERT_TRUE(has_event(SUPERVISOR_EVENT_PROCESS_HUNG, LONE));
}

/// Let the process of ARM die; its death is detected at this time.
static void die_at(uint64_t now_ns)
{
    fixture.members[FIXTURE_ARM].is_running = false;
    step_at(now_ns, 0U);
}

static void a_restart_waits_for_its_pause(void)
{
    static const uint64_t pauses_ns[]                              = {0U, 100U * MS, 1000U * MS, 1000U * MS};
    ((mission_subsystem_t*)entry_of(ARM)->mission)->restart_budget = 4U;
    for (unsigned i = 0U; i < 4U; i++) {
        const uint64_t died_ns = fixture.now_ns + (5U * TICK);
        die_at(died_ns);
        if (pauses_ns[i] > 0U) {
            TEST_ASSERT_EQUAL(i, fixture.starts);
            step_at(died_ns + pauses_ns[i] - TICK, 0U);
            TEST_ASSERT_EQUAL(i, fixture.starts);
            step_at(died_ns + pauses_ns[i], 0U);
        }
        TEST_ASSERT_EQUAL(i + 1U, fixture.starts);
        TEST_ASSERT_EQUAL(i + 1U, entry_of(ARM)->restarts);
        fixture_run(3U);
    }
    die_at(fixture.now_ns);
    fixture_run(200U);
    TEST_ASSERT_EQUAL(4U, fixture.starts);
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
}

static void earlier_deaths_do_not_count_after_a_life_as_long_as_the_restart_period(void)
{
    mission_subsystem_t* const mission = (mission_subsystem_t*)entry_of(ARM)->mission;
    mission->restart_period_us         = 5000000U;
    for (unsigned i = 0U; i < 2U; i++) {
        const uint64_t started_ns = fixture.now_ns + TICK;
        entry_of(ARM)->deaths     = 1U;
        entry_of(ARM)->restart_ns = started_ns;
        die_at(started_ns + (5000U * MS) - ((i == 0U) ? TICK : 0U));
        TEST_ASSERT_EQUAL((i == 0U) ? 2U : 1U, entry_of(ARM)->deaths);
        fixture_run(30U); // ARM has been started again.
    }
}

static void a_negotiation_ends_at_its_deadline(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].ignores_links = true;
    fixture_run(1U);
    (void)fixture_request_link(LINK_ARM_STATE);
    fixture_step();
    const uint64_t deadline_ns = fixture.now_ns + (2000U * MS);
    TEST_ASSERT_EQUAL_UINT64(deadline_ns, fixture.supervisor.sessions[0].deadline_ns);
    step_at(deadline_ns - TICK, 0U);
    TEST_ASSERT_EQUAL(SESSION_ASK_PRODUCER, fixture.supervisor.sessions[0].step);
    step_at(deadline_ns, 0U);
    TEST_ASSERT_EQUAL(SESSION_FREE, fixture.supervisor.sessions[0].step);
}

static void a_request_waits_for_room_for_a_tenth_of_a_second(void)
{
    fixture_fill(FIXTURE_ARM);
    (void)fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_step();
    const uint64_t held_ns = fixture.supervisor.held_ns;
    TEST_ASSERT_EQUAL(ARM, fixture.supervisor.held_for);
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns, held_ns);
    fixture_forget();
    step_at(held_ns + (100U * MS) - 1U, 0U);
    TEST_ASSERT_FALSE(fixture_has("G 1.10"));
    TEST_ASSERT_FALSE(entry_of(ARM)->is_unresponsive);
    step_at(held_ns + (100U * MS), 0U);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G 1.10"));
    TEST_ASSERT_TRUE(entry_of(ARM)->is_unresponsive);
}

static void senders_wait_for_the_ground_for_a_second(void)
{
    supervisor_t* const supervisor        = &fixture.supervisor;
    static uint8_t packet[PUS_PACKET_MAX] = {0x08U, ARM, 0xC0U, 0U, 0U, 0U, 0x20U, 17U, 2U};
    while (supervisor_ground_backlog_put(&supervisor->ground_backlog, 0U, packet, 30U, NULL) == STATUS_OK) {
    }
    supervisor->ground_moved_ns = supervisor->now_ns - (1000U * MS);
    TEST_ASSERT_FALSE(supervisor_ground_accepts(supervisor, PUS_CLASS_PLAIN, 30U));
    supervisor->ground_moved_ns--;
    TEST_ASSERT_TRUE(supervisor_ground_accepts(supervisor, PUS_CLASS_PLAIN, 30U));
}

static void a_recommissioning_without_progress_ends_after_more_than_five_seconds(void)
{
    ((mission_subsystem_t*)entry_of(ARM)->mission)->is_recommissioned = true;
    fixture_link_up(STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(1U);
    fixture.members[FIXTURE_ARM].is_passive = true;
    fixture_run(200U);
    const recommission_t* const run = &entry_of(ARM)->recommission;
    TEST_ASSERT_TRUE(run->is_active);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, run->seen);
    const uint64_t since_ns = run->since_ns;
    step_at(since_ns + (5000U * MS), 0U);
    TEST_ASSERT_TRUE(run->is_active);
    step_at(since_ns + (5000U * MS) + 1U, 0U);
    TEST_ASSERT_FALSE(run->is_active);
    TEST_ASSERT_TRUE(has_event(SUPERVISOR_EVENT_RECOMMISSION_STOPPED, ARM));
}

/// ARM dies after HAND has entered ERROR_OPERATIONAL. Up to 0.1 s apart, both have the same cause and are
/// recommissioned; later, HAND counts as failed by itself.
static void a_partner_in_error_is_recommissioned_up_to_a_tenth_of_a_second(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        ((mission_subsystem_t*)entry_of(ARM)->mission)->is_recommissioned  = true;
        ((mission_subsystem_t*)entry_of(HAND)->mission)->is_recommissioned = true;
        fixture_link_up(STATE_OPERATIONAL);
        fixture_put_in_state(FIXTURE_HAND, STATE_ERROR_OPERATIONAL);
        die_at(entry_of(HAND)->error_ns + (100U * MS) + ((i == 0U) ? 0U : TICK));
        TEST_ASSERT_TRUE(entry_of(ARM)->recommission.is_active);
        TEST_ASSERT_EQUAL(i == 0U, entry_of(HAND)->recommission.is_active);
        tearDown();
        setUp();
    }
}

static void a_step_of_the_shutdown_ends_after_more_than_three_seconds(void)
{
    fixture_put_in_state(FIXTURE_LONE, STATE_OPERATIONAL);
    fixture.members[FIXTURE_LONE].is_passive = true;
    fixture.is_stop_requested                = true;
    fixture_run(2U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.shutdown_step);
    const uint64_t since_ns = fixture.supervisor.shutdown_ns;
    step_at(since_ns + (3000U * MS), 0U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.shutdown_step);
    step_at(since_ns + (3000U * MS) + TICK, 0U);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.shutdown_step);
}

static void a_request_that_is_not_accepted_ends_after_more_than_ten_seconds(void)
{
    fixture.members[FIXTURE_LONE].is_passive = true;
    fixture_run(1U);
    (void)fixture_tc(LONE, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_step();
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.pending.count);
    const uint64_t since_ns = fixture.now_ns;
    step_at(since_ns + (10000U * MS), 0U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.pending.count);
    step_at(since_ns + (10000U * MS) + TICK, 0U);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.pending.count);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0406 2710")); // 10000 ms.
}

/// A request is granted if all members together need exactly the available power in the states after it.
static void a_request_may_use_all_the_power_of_the_mission(void)
{
    mission_descriptor_t* const mission = (mission_descriptor_t*)fixture.supervisor.mission;
    const uint32_t available_w          = mission->power_available_w;
    const uint32_t needed_w = supervisor_registry_power_w(&fixture.supervisor, LONE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_EQUAL_UINT32(41U, needed_w);
    mission->power_available_w = needed_w - 1U;
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_FALSE(fixture_has("18 TC 129.1"));
    TEST_ASSERT_TRUE(has_event(SUPERVISOR_EVENT_RESOURCE_REFUSED, LONE));
    mission->power_available_w = needed_w;
    (void)fixture_request_state(LONE, STATE_PRE_OPERATIONAL);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("18 TC 129.1"));
    mission->power_available_w = available_w;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_member_is_silent_after_more_than_three_seconds);
    RUN_TEST(a_state_is_in_doubt_after_a_second_and_a_half);
    RUN_TEST(a_process_is_killed_when_its_step_is_later_than_its_timeout);
    RUN_TEST(a_restart_waits_for_its_pause);
    RUN_TEST(earlier_deaths_do_not_count_after_a_life_as_long_as_the_restart_period);
    RUN_TEST(a_negotiation_ends_at_its_deadline);
    RUN_TEST(a_request_waits_for_room_for_a_tenth_of_a_second);
    RUN_TEST(senders_wait_for_the_ground_for_a_second);
    RUN_TEST(a_recommissioning_without_progress_ends_after_more_than_five_seconds);
    RUN_TEST(a_partner_in_error_is_recommissioned_up_to_a_tenth_of_a_second);
    RUN_TEST(a_step_of_the_shutdown_ends_after_more_than_three_seconds);
    RUN_TEST(a_request_that_is_not_accepted_ends_after_more_than_ten_seconds);
    RUN_TEST(a_request_may_use_all_the_power_of_the_mission);
    return UNITY_END();
}
