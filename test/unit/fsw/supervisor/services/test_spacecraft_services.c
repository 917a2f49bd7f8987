// SPDX-License-Identifier: Apache-2.0
// Requests that services of the supervisor release: the time of release, and what happens without room.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "test/unit/fsw/supervisor/releases.h"
#include "unity.h"

#include <string.h>

#define LONE_REACHED "18 TC 17.1 from 1\n"
#define MS 1000000ULL

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void a_request_is_released_at_its_time(void)
{
    const uint64_t due_ns = fixture.now_ns + (25U * MS);
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(due_ns, LONE, 0U);
    fixture_run(2U);
    fixture_expect("");
    // The time is between two ticks.
    const uint64_t wake_ns = supervisor_step(&fixture.supervisor, fixture.now_ns);
    TEST_ASSERT_TRUE((wake_ns <= due_ns) && (wake_ns > (due_ns - 100U)));
    fixture.now_ns = due_ns;
    fixture_run(1U);
    fixture_expect(LONE_REACHED);
    fixture_run(10U);
    fixture_expect("");
}

static void a_request_is_released_at_its_position(void)
{
    const uint64_t here = pus_position_schedule_now(&fixture.supervisor.spacecraft.schedules.position);
    schedule_enable(PUS_SERVICE_POSITION_SCHEDULE);
    release_where(here + 3U, LONE, 0U);
    fixture_run(10U);
    fixture_expect("");
    fixture_run(20U); // The angle changes every 85 ms.
    fixture_expect(LONE_REACHED);
}

static void a_request_is_released_by_its_event(void)
{
    release_on(NOTE, LONE, 0U);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE + 1U);
    fixture_event(FIXTURE_HAND, PUS_SEVERITY_LOW, NOTE);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_EVENTS, 2U, "\4", 1U);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_EVENTS, 8U, "\0\4", 2U); // A list of disabled events.
    fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 26U, "\0\4", 2U);
    fixture_run(3U);
    TEST_ASSERT_FALSE(fixture_has(LONE_REACHED));
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
}

static void a_request_is_released_by_its_sequence(void)
{
    release_in_sequence(LONE, 0U);
    fixture_run(1U);
    fixture_expect(LONE_REACHED);
}

// ---- Without room ----

static void a_request_that_waits_for_its_addressee_delays_the_requests_after_it(void)
{
    fixture_fill(FIXTURE_LONE);
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(fixture.now_ns + (5U * MS), LONE, 0U);
    release_at(fixture.now_ns + (6U * MS), HAND, 1U);
    fixture_run(5U);
    fixture_expect("");
    fixture.members[FIXTURE_LONE].takes_nothing = false;
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
    TEST_ASSERT_TRUE(fixture_has("17 TC 17.1 from 1"));
    TEST_ASSERT_FALSE(fixture_has("G 1.10"));
}

static void a_request_that_has_waited_too_long_is_refused(void)
{
    fixture_fill(FIXTURE_LONE);
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(fixture.now_ns + (5U * MS), LONE, 3U);
    release_at(fixture.now_ns + (6U * MS), HAND, 1U);
    fixture_run((unsigned)(SPACECRAFT_CREDIT_TIMEOUT_NS / FIXTURE_TICK_NS));
    fixture_expect("");
    fixture_run(3U);
    fixture_expect("G 1.10 #3 0109 12\n17 TC 17.1 from 1\n");
}

static void a_malformed_request_delays_no_other(void)
{
    static const uint8_t nonsense[] = "This is not a telecommand.";
    const uint32_t before           = fixture.supervisor.counters.tc_malformed;
    TEST_ASSERT_EQUAL(STATUS_OK, spacecraft_release(&fixture.supervisor, nonsense, sizeof nonsense));
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(fixture.now_ns + (5U * MS), LONE, 0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
    TEST_ASSERT_EQUAL_UINT32(before + 1U, fixture.supervisor.counters.tc_malformed);
}

/// Fill the queue of released requests with requests to LONE, which has no credit.
static void fill_queue(void)
{
    static const uint8_t data[400];
    uint8_t packet[512];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid    = LONE,
                         .service = PUS_SERVICE_TEST,
                         .subtype = 1U,
                         .source  = FIXTURE_USER,
                         .data    = data,
                         .size    = sizeof data};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &size));
    fixture_fill(FIXTURE_LONE);
    fixture_step();
    while (spacecraft_release(&fixture.supervisor, packet, size) == STATUS_OK) {
    }
    const message_ring_t* const queue = &fixture.supervisor.spacecraft.released;
    // The remaining room is too small for another request; truncated requests fill it to the last octet.
    while (spacecraft_release(&fixture.supervisor, packet, message_ring_room(queue)) == STATUS_OK) {
    }
}

static void expect_retried(void)
{
    const uint64_t wake_ns = supervisor_step(&fixture.supervisor, fixture.now_ns);
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns + SPACECRAFT_RETRY_NS, wake_ns);
    fixture_forget();
}

static void a_service_that_finds_the_queue_full_tries_again(void)
{
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(fixture.now_ns + (25U * MS), LONE, 0U);
    fill_queue();
    fixture.now_ns += 25U * MS;
    expect_retried();
    TEST_ASSERT_TRUE(pus_schedule_is_waiting(&fixture.supervisor.spacecraft.schedules.time.schedule));
}

static void an_event_that_finds_the_queue_full_is_kept(void)
{
    release_on(NOTE, LONE, 0U);
    fill_queue();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE);
    expect_retried();
    TEST_ASSERT_TRUE(pus_event_action_is_waiting(&fixture.supervisor.spacecraft.schedules.actions));
}

static void a_sequence_that_finds_the_queue_full_waits(void)
{
    fill_queue();
    release_in_sequence(LONE, 0U);
    expect_retried();
    TEST_ASSERT_TRUE(pus_sequences_next_ns(&fixture.supervisor.spacecraft.sequences.service) <=
                     fixture.now_ns);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_is_released_at_its_time);
    RUN_TEST(a_request_is_released_at_its_position);
    RUN_TEST(a_request_is_released_by_its_event);
    RUN_TEST(a_request_is_released_by_its_sequence);
    RUN_TEST(a_request_that_waits_for_its_addressee_delays_the_requests_after_it);
    RUN_TEST(a_request_that_has_waited_too_long_is_refused);
    RUN_TEST(a_malformed_request_delays_no_other);
    RUN_TEST(a_service_that_finds_the_queue_full_tries_again);
    RUN_TEST(an_event_that_finds_the_queue_full_is_kept);
    RUN_TEST(a_sequence_that_finds_the_queue_full_waits);
    return UNITY_END();
}
