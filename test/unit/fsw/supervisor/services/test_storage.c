// SPDX-License-Identifier: Apache-2.0
// Packet stores and time reports of the supervisor.
#include "test/support/recorded_media.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

#define RING "RING\0\0\0\0" // Padded with NUL.

static medium_t media[SPACECRAFT_STORES];

static void give_media(supervisor_config_t* config)
{
    config->store_media = media;
}

void setUp(void)
{
    static const image_t empty[2];
    recorded_clear(empty);
    for (unsigned i = 0U; i < SPACECRAFT_STORES; i++) {
        media[i] = recorded_medium((i == 0U) ? 0U : 1U);
    }
    fixture_configure = give_media;
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

static void request(const uint8_t subtype, const void* const data, const size_t size)
{
    fixture.ack = 0U;
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_STORAGE, subtype, data, size);
    fixture_run(1U);
}
#define REQUEST(subtype, octets) request((subtype), (octets), sizeof(octets) - 1U)

/// Create a circular store of 64 KiB that selects all diagnostic reports of ARM.
static void open_store(void)
{
    REQUEST(20U, "\1" RING "\0\1\0\0\0\0");
    REQUEST(3U, RING "\1\0\20\1\3\1\32"); // TM[3,26] of APID 16.
    REQUEST(31U, RING "\1\0\20\0");       // All structures.
    REQUEST(1U, "\1" RING);
    fixture_expect("");
}

static void report(const char* const text)
{
    fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 26U, text, strlen(text));
    fixture_run(1U);
}

static void stored_reports_are_sent_again(void)
{
    open_store();
    report("ab");
    report("cd");
    // The store does not select this report.
    fixture_report(FIXTURE_HAND, PUS_SERVICE_HOUSEKEEPING, 26U, "ef", 2U);
    fixture_run(1U);
    fixture_expect("G/16 3.26 6162\nG/16 3.26 6364\nG/17 3.26 6566\n");
    REQUEST(15U, "\1" RING "\0");
    fixture_run(1U);
    fixture_expect("G/16 3.26 6162\nG/16 3.26 6364\n");
    TEST_ASSERT_EQUAL_UINT32(2U, fixture.supervisor.spacecraft.storage.service.stores[0].log.counters.stored);
}

static void retrieved_reports_wait_for_credit_of_the_ground(void)
{
    open_store();
    report("ab");
    fixture_expect("G/16 3.26 6162\n");
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    for (unsigned i = 0U; i < 40U; i++) { // Until no credit is left and reports wait.
        fixture_report(FIXTURE_HAND, PUS_SERVICE_HOUSEKEEPING, 26U, "ef", 2U);
        fixture_step();
    }
    REQUEST(15U, "\1" RING "\0");
    TEST_ASSERT_TRUE(fixture.supervisor.spacecraft.storage.service.counters.refused > 0U);
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    fixture_run(5U);
    const char* const lines = fixture_look();
    const char* const again = strstr(lines, "G/16 3.26 6162\n");
    TEST_ASSERT_NOT_NULL(again);
    TEST_ASSERT_NULL(strstr(&again[1], "G/16")); // The report comes once, after all that waited.
    TEST_ASSERT_NULL(strstr(&again[1], "G/17"));
}

static void without_media_no_report_is_stored(void)
{
    fixture_close();
    fixture_configure = NULL;
    fixture_open_up();
    open_store();
    report("ab");
    fixture_expect("G/16 3.26 6162\n");
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.supervisor.spacecraft.storage.service.counters.lost);
    REQUEST(2U, "\0");  // Disable the storage in all packet stores,
    REQUEST(21U, "\0"); // and delete them.
    fixture_run(200U);
    TEST_ASSERT_FALSE(fixture.supervisor.spacecraft.storage.service.stores[0].state.is_there);
}

static void time_is_reported_at_the_commanded_rate(void)
{
    fixture.ack = 0U;
    fixture_run(200U);
    fixture_expect("");
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TIME, 1U, "\1", 1U);
    fixture_run(400U); // Four seconds; a report every 2^1 s.
    fixture_expect("G time 1\nG time 1\n");
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    fixture_run(1200U); // Until no credit is left and the supervisor refuses time reports.
    TEST_ASSERT_TRUE(fixture.supervisor.spacecraft.storage.time.counters.refused > 0U);
    fixture.members[FIXTURE_GROUND].takes_nothing = false;
    fixture_forget();
    fixture_run(600U);
    TEST_ASSERT_TRUE(fixture_has("G time 1"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(stored_reports_are_sent_again);
    RUN_TEST(retrieved_reports_wait_for_credit_of_the_ground);
    RUN_TEST(without_media_no_report_is_stored);
    RUN_TEST(time_is_reported_at_the_commanded_rate);
    return UNITY_END();
}
