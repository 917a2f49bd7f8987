// SPDX-License-Identifier: Apache-2.0
// The state of a world with several robots in the truth log.
#include "sim/app/plant_log.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <lcm/eventlog.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static world_t world;
static plant_truth_t truth;
static char path[64];

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/plant-log-%ld.lcm", (long)getpid());
    world = rokviss()->world;
    memset(&truth, 0, sizeof truth);
}

void tearDown(void)
{
    (void)unlink(path);
}

static void write_log(void)
{
    truth_t* log = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_open(path, TRUTH_OCTETS_MAX, &log));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, plant_log_names(log, &world));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, plant_log_state(log, &world, &truth));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(log));
}

/// Check that the next event is of this channel with this number of entries. Returns its octets, valid until
/// the next call.
static const unsigned char* expect_event(lcm_eventlog_t* log, const char* channel, unsigned count)
{
    static unsigned char octets[1024];
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    TEST_ASSERT_NOT_NULL_MESSAGE(event, channel);
    TEST_ASSERT_EQUAL_STRING(channel, event->channel);
    memcpy(octets, event->data, (size_t)event->datalen);
    TEST_ASSERT_EQUAL_UINT8(count, octets[19]);
    lcm_eventlog_free_event(event);
    return octets;
}

static void everything_of_the_world_is_logged(void)
{
    world.robot_count      = 2U; // The same robot once again, with a free base.
    world.robot[1]         = world.robot[0];
    world.robot[1].is_free = true;
    (void)strcpy(world.robot[1].name, "twin");
    world.contact_count = 2U;
    world.contact[1]    = world.contact[0];
    world.wheel_count   = 1U;
    (void)strcpy(world.wheel[0].device.name, "WHEEL1");
    truth.joint_count = 4U;
    truth.base_count  = 1U;
    write_log();
    lcm_eventlog_t* log        = lcm_eventlog_create(path, "r");
    const unsigned char* names = expect_event(log, "WORLD", 4U);
    TEST_ASSERT_EQUAL_STRING("arm.joint1", (const char*)&names[24]);
    TEST_ASSERT_EQUAL_STRING("twin.joint1", (const char*)&names[24 + 2 * (11 + 4)]);
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    TEST_ASSERT_EQUAL_STRING("NAMES", event->channel);
    TEST_ASSERT_EQUAL_STRING("WHEEL", (const char*)event->data + 20);
    TEST_ASSERT_EQUAL_STRING("WHEEL1", (const char*)event->data + 34);
    lcm_eventlog_free_event(event);
    (void)expect_event(log, "JOINTS", 4U);
    (void)expect_event(log, "STICK", 2U);
    (void)expect_event(log, "CONTACT", 2U);
    (void)expect_event(log, "SPRING", 1U);
    (void)expect_event(log, "WHEEL", 1U);
    (void)expect_event(log, "BASE", 1U);
    TEST_ASSERT_NULL(lcm_eventlog_read_next_event(log));
    lcm_eventlog_destroy(log);
}

static void an_empty_world_has_names_only(void)
{
    memset(&world, 0, sizeof world);
    write_log();
    lcm_eventlog_t* log = lcm_eventlog_create(path, "r");
    (void)expect_event(log, "WORLD", 0U);
    TEST_ASSERT_NULL(lcm_eventlog_read_next_event(log));
    lcm_eventlog_destroy(log);
}

static void a_latch_is_logged_when_it_changes(void)
{
    bool is_closed[WORLD_LATCHES_MAX] = {false};
    truth_t* log                      = NULL;
    world.latch_count                 = 2U;
    (void)strcpy(world.latch[1].name, "DOCK");
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_open(path, TRUTH_OCTETS_MAX, &log));
    for (unsigned step = 0U; step < 6U; step++) {
        truth.time_ns       = step * 1000000U;
        truth.is_latched[1] = (step >= 2U) && (step < 4U);
        TEST_ASSERT_EQUAL_INT(STATUS_OK, plant_log_latches(log, &world, &truth, is_closed));
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(log));
    lcm_eventlog_t* read = lcm_eventlog_create(path, "r");
    for (unsigned i = 0U; i < 2U; i++) {
        lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(read);
        TEST_ASSERT_NOT_NULL(event);
        TEST_ASSERT_EQUAL_STRING("LATCH", event->channel);
        TEST_ASSERT_EQUAL_INT64((i == 0U) ? 2000 : 4000, event->timestamp);
        TEST_ASSERT_EQUAL_STRING("DOCK", (const char*)event->data + 20);
        TEST_ASSERT_EQUAL_UINT8((i == 0U) ? 1U : 0U, ((const uint8_t*)event->data)[event->datalen - 1]);
        lcm_eventlog_free_event(event);
    }
    TEST_ASSERT_NULL(lcm_eventlog_read_next_event(read));
    lcm_eventlog_destroy(read);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(everything_of_the_world_is_logged);
    RUN_TEST(an_empty_world_has_names_only);
    RUN_TEST(a_latch_is_logged_when_it_changes);
    return UNITY_END();
}
