// SPDX-License-Identifier: Apache-2.0
// Persistent records of the supervisor's services: their state after a power cut, and the reports about lost
// records.
#include "fsw/supervisor/supervisor_internal.h"
#include "test/support/recorded_media.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "test/unit/fsw/supervisor/releases.h"
#include "unity.h"

#include <string.h>

#define RECORDS 256U
#define LONE_REACHED "18 TC 17.1 from 1\n"
// Reports of events, up to the event number; fields of the event follow.
#define REFUSED "G 5.2 000B"     ///< RECORD_REFUSED: table, key, reason.
#define IN_DOUBT "G 5.2 000C"    ///< RELEASE_IN_DOUBT: source, APID, sequence count.
#define INTERRUPTED "G 5.2 0017" ///< FLIGHT_INTERRUPTED: mode, since.
#define DAMAGED "G 5.4 005A"     ///< JOURNAL_DAMAGED.
#define MS 1000000ULL

static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(RECORDS)];
static medium_t media[SPACECRAFT_STORES];
static image_t images[2];
static bool has_store; // A packet store on `media`.

static void open_journal(void)
{
    const journal_configuration_t configuration = {.media    = {recorded_medium(0U), recorded_medium(1U)},
                                                   .limit    = MEDIUM_MAX,
                                                   .slack    = 16384U,
                                                   .slots    = slots,
                                                   .capacity = RECORDS};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
}

static void give_journal(supervisor_config_t* const config)
{
    config->journal     = &journal;
    config->store_media = has_store ? media : NULL;
}

void setUp(void)
{
    static const image_t empty[2];
    recorded_clear(empty);
    has_store         = false;
    fixture_configure = give_journal;
    open_journal();
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

/// Restore the power; the media are as they are in `images`.
static void restore_power(void)
{
    fixture_close();
    recorded_clear(images);
    open_journal();
    fixture_open();
    fixture_run(60U);
}

static void power_cut(void)
{
    recorded_durable(images);
    restore_power();
}

static void set_mode(uint8_t mode)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SET_MODE, &mode, 1U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT8(mode, fixture.supervisor.mode);
}

static void shut_down(void)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SHUT_DOWN, NULL, 0U);
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static void definitions_of_each_service_are_restored(void)
{
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    schedule_enable(PUS_SERVICE_POSITION_SCHEDULE);
    release_at(3600000U * MS, LONE, 0U);
    release_where(100U * (uint64_t)PUS_POSITION_TICKS, LONE, 1U);
    release_on(4U, LONE, 2U);
    release_in_sequence(LONE, 3U);
    REQUEST(PUS_SERVICE_FORWARDING, 1U, "\1\0\20\1\3\1\31"); // TM[3,25] of APID 16.
    REQUEST(PUS_SERVICE_TIME, 1U, "\7");
    // The component performs TC[3,29] of a structure.
    REQUEST(PUS_SERVICE_HOUSEKEEPING, 29U, "\1\0\1\1");
    fixture_forget();
    power_cut();
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.spacecraft.refused);
    set_mode(MODE_NOMINAL);
    const spacecraft_services_t* const spacecraft = &fixture.supervisor.spacecraft;
    TEST_ASSERT_EQUAL_UINT32(1U, spacecraft->schedules.time.schedule.count);
    TEST_ASSERT_EQUAL_UINT32(1U, spacecraft->schedules.position.schedule.count);
    TEST_ASSERT_EQUAL_UINT8(7U, spacecraft->storage.time.exponent);
    REQUEST(PUS_SERVICE_SEQUENCES, 4U, "SEQ\0\0\0\0\0");
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_LOW, NOTE);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
}

static void a_record_of_no_service_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 99U, 0x12345678U, (const uint8_t*)"a", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, PUS_SERVICE_STORAGE, 5U, (const uint8_t*)"a", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, PUS_SERVICE_TEST, 6U, (const uint8_t*)"a", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    power_cut();
    TEST_ASSERT_EQUAL_UINT32(3U, fixture.supervisor.spacecraft.refused);
    TEST_ASSERT_TRUE(fixture_has(REFUSED "6312345678"));
    TEST_ASSERT_TRUE(fixture_has(REFUSED "0F00000005"));
    TEST_ASSERT_TRUE(fixture_has(REFUSED "1100000006")); // ST[17] has no records.
}

/// A flipped bit early in the file loses schedules and procedures. The supervisor reports this once and
/// starts in mode SAFE.
static void a_damaged_journal_is_reported(void)
{
    TEST_ASSERT_NOT_EQUAL(0U, fixture.supervisor.mode);
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(3600000U * MS, LONE, 0U);
    fixture_forget();
    recorded_durable(images);
    images[0].octets[60] ^= 1U;
    restore_power();
    TEST_ASSERT_TRUE(fixture_has(DAMAGED));
    TEST_ASSERT_EQUAL_UINT8(0U, fixture.supervisor.mode);
    TEST_ASSERT_EQUAL_UINT32(0U, fixture.supervisor.spacecraft.schedules.time.schedule.count);
    fixture_forget();
    fixture_run(20U);
    TEST_ASSERT_FALSE(fixture_has(DAMAGED));
    shut_down();
    power_cut();
    TEST_ASSERT_FALSE(fixture_has(DAMAGED));
    TEST_ASSERT_NOT_EQUAL(0U, fixture.supervisor.mode);
}

// ---- The mode ----

static void after_a_power_cut_the_spacecraft_starts_in_the_fallback_mode(void)
{
    TEST_ASSERT_EQUAL_UINT8(MODE_NOMINAL, fixture.supervisor.mode);
    power_cut();
    TEST_ASSERT_EQUAL_UINT8(MODE_SAFE, fixture.supervisor.mode);
    TEST_ASSERT_TRUE(fixture_has(INTERRUPTED "010000000000000000\n")); // Mode 1 since time 0.
    TEST_ASSERT_TRUE(fixture_has("G 131.2 010001\n"));
    fixture_forget();
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(INTERRUPTED "000000000000000000\n"));
    TEST_ASSERT_FALSE(fixture_has("G 131.2 0000"));
    fixture_run(40U);
    set_mode(MODE_NOMINAL);
    fixture_forget();
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(INTERRUPTED "01000000003B9ACA00\n")); // Mode 1 since 1 s.
    fixture_forget();
    fixture_run(20U);
    TEST_ASSERT_FALSE(fixture_has(INTERRUPTED));
}

static void after_a_shutdown_the_spacecraft_starts_in_the_initial_mode(void)
{
    set_mode(MODE_SAFE);
    shut_down();
    power_cut();
    TEST_ASSERT_EQUAL_UINT8(MODE_NOMINAL, fixture.supervisor.mode);
    TEST_ASSERT_FALSE(fixture_has("G 5."));
}

/// If the record of an interrupted flight cannot be erased, the next flight starts in the fallback mode.
static void the_record_of_the_mode_is_kept_if_the_disk_refuses_to_erase_it(void)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_SHUT_DOWN, NULL, 0U);
    recorded.failure    = STATUS_IO;
    recorded.fail_from  = recorded.calls + 1U;
    recorded.fail_count = 1000U;
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture.is_finished);
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(INTERRUPTED));
}

static void fall_back_to_nominal(supervisor_config_t* const config)
{
    static mission_descriptor_t mission;
    give_journal(config);
    mission = *config->mission;
    descriptor_mission_use_storage(&mission);
    mission.fallback_mode = MODE_NOMINAL;
    mission.initial_mode  = MODE_SAFE;
    config->mission       = &mission;
}

static void the_mission_defines_the_fallback_mode(void)
{
    fixture_configure = fall_back_to_nominal;
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(INTERRUPTED));
    TEST_ASSERT_EQUAL_UINT8(MODE_NOMINAL, fixture.supervisor.mode);
}

static void a_record_that_contains_no_mode_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, PUS_SERVICE_MISSION, 0U, (const uint8_t*)"a", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(REFUSED "8300000000"));
    TEST_ASSERT_FALSE(fixture_has(INTERRUPTED));
    TEST_ASSERT_EQUAL_UINT8(MODE_NOMINAL, fixture.supervisor.mode);
}

static void the_mode_changes_although_the_disk_refuses_the_record(void)
{
    for (unsigned failing = 1U; failing <= 2U; failing++) { // The write and the sync of the record.
        recorded.failure    = STATUS_IO;
        recorded.fail_from  = recorded.calls + failing;
        recorded.fail_count = 1U;
        fixture_forget();
        supervisor_mode_fall_back(&fixture.supervisor);
        fixture_run(1U);
        TEST_ASSERT_EQUAL_UINT8(MODE_SAFE, fixture.supervisor.mode);
        TEST_ASSERT_TRUE(fixture_has(REFUSED "8300000000"));
        set_mode(MODE_NOMINAL);
    }
}

static void a_journal_that_cannot_be_read_is_reported(void)
{
    REQUEST(PUS_SERVICE_TIME, 1U, "\7");
    fixture_close();
    recorded.failure    = STATUS_IO;
    recorded.fail_from  = recorded.calls + 1U;
    recorded.fail_count = 1U;
    fixture_open();
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture_has(REFUSED "0000000000"));
    TEST_ASSERT_EQUAL_UINT8(PUS_TIME_NO_REPORTS, fixture.supervisor.spacecraft.storage.time.exponent);
}

static status_t fail_to_read(void* const context, const uint64_t offset, uint8_t* const octets,
                             const size_t size)
{
    (void)context;
    (void)offset;
    (void)octets;
    (void)size;
    return STATUS_IO;
}

static status_t fail_to_report_size(void* const context, uint64_t* const out_size)
{
    (void)context;
    *out_size = 0U;
    return STATUS_IO;
}

static void a_service_that_cannot_begin_is_reported(void)
{
    for (unsigned i = 0U; i < SPACECRAFT_STORES; i++) {
        media[i]      = recorded_medium(1U);
        media[i].read = fail_to_read;
        media[i].size = fail_to_report_size;
    }
    REQUEST(PUS_SERVICE_STORAGE, 20U, "\1RING\0\0\0\0\0\1\0\0\0\0"); // Circular, 64 KiB.
    has_store = true;
    power_cut();
    TEST_ASSERT_TRUE(fixture_has(REFUSED "0F00000000"));
    TEST_ASSERT_EQUAL_UINT32(1U, fixture.supervisor.spacecraft.refused);
}

/// Returns what the restarted supervisor does: 0: it releases the request; 1: it reports that the result is
/// in doubt; 2: nothing, because the release was complete.
static unsigned outcome(void)
{
    const bool is_reached  = fixture_has(LONE_REACHED);
    const bool is_reported = fixture_has(IN_DOUBT "000100120005");
    TEST_ASSERT_FALSE(is_reached && is_reported);
    return is_reached ? 0U : (is_reported ? 1U : 2U);
}

/// The power is cut after each operation on the media in turn. The restarted supervisor releases a request
/// that was not released; it reports, and does not repeat, a request that may have been released.
static void a_power_cut_neither_repeats_a_release_nor_loses_it_without_a_report(void)
{
    static image_t before[2];
    unsigned seen[3] = {0U};
    unsigned last    = 0U;
    bool is_all      = false;
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    release_at(700U * MS, LONE, 5U);
    recorded_durable(before);
    for (size_t cut = 0U; !is_all; cut++) {
        recorded_copy(images, before);
        restore_power();
        const size_t start = recorded.count;
        fixture_run(20U);
        TEST_ASSERT_TRUE(fixture_has(LONE_REACHED));
        is_all = (start + cut) == recorded.count;
        recorded_copy(images, before);
        for (size_t i = 0U; i < (start + cut); i++) {
            recorded_apply(&recorded.operations[i], recorded.operations[i].size, images);
        }
        restore_power();
        fixture_run(20U);
        const unsigned now = outcome();
        TEST_ASSERT_TRUE(now >= last);
        seen[now]++;
        last = now;
    }
    TEST_ASSERT_TRUE((seen[0] > 0U) && (seen[1] > 0U) && (seen[2] > 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(definitions_of_each_service_are_restored);
    RUN_TEST(a_record_of_no_service_is_reported);
    RUN_TEST(a_damaged_journal_is_reported);
    RUN_TEST(after_a_power_cut_the_spacecraft_starts_in_the_fallback_mode);
    RUN_TEST(after_a_shutdown_the_spacecraft_starts_in_the_initial_mode);
    RUN_TEST(the_record_of_the_mode_is_kept_if_the_disk_refuses_to_erase_it);
    RUN_TEST(the_mission_defines_the_fallback_mode);
    RUN_TEST(a_record_that_contains_no_mode_is_reported);
    RUN_TEST(the_mode_changes_although_the_disk_refuses_the_record);
    RUN_TEST(a_journal_that_cannot_be_read_is_reported);
    RUN_TEST(a_service_that_cannot_begin_is_reported);
    RUN_TEST(a_power_cut_neither_repeats_a_release_nor_loses_it_without_a_report);
    return UNITY_END();
}
