// SPDX-License-Identifier: Apache-2.0
// ST[12] and ST[04] of a subsystem with its own parameters, events and time.
#include "fsw/framework/subsystem/monitoring_service.h"
#include "fsw/framework/subsystem/statistics_service.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <string.h>

#define PMONS 2U
#define STATISTICS 2U
#define FIXTURE_CROSSED 20U // Event of a PMON: 16 octets of auxiliary data.
#define FIXTURE_FAILED 21U  // Event of an FMON: 4 octets of auxiliary data.
#define TICKS_PER_S 16777216U

static struct {
    monitoring_service_t monitoring;
    pus_pmon_t pmons[PMONS];
    uint16_t order[PMONS];
    uint16_t positions[PMONS];
    pus_due_t due[PMONS];
    pus_fmon_t fmons[1];
    uint16_t touched[1];
    pus_fmon_member_t members[MONITORING_FMON_MEMBERS];
    statistics_service_t statistics;
    pus_statistic_t entries[STATISTICS];
    pus_due_t samples[STATISTICS];
    uint16_t sample_positions[STATISTICS];
} storage;
static struct {
    unsigned puts;
    unsigned commits;
    uint8_t table;
    uint32_t key;
    uint8_t octets[PUS_RECORD_MAX];
    size_t size;
} kept;
static uint8_t data[64];
static octet_writer_t writer;

static status_t put(void* context, uint8_t table, uint32_t key, const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&kept, context);
    TEST_ASSERT_TRUE(size <= sizeof kept.octets);
    kept.puts++;
    kept.table = table;
    kept.key   = key;
    kept.size  = size;
    (void)memcpy(kept.octets, octets, size);
    return STATUS_OK;
}

static status_t commit(void* context)
{
    TEST_ASSERT_EQUAL_PTR(&kept, context);
    kept.commits++;
    return STATUS_OK;
}

static const pus_persistence_t persistence = {.context = &kept, .put = put, .commit = commit};

static void add_services(void* context, subsystem_t* subsystem)
{
    TEST_ASSERT_EQUAL_PTR(&storage, context);
    const monitoring_room_t room     = {.pmons      = storage.pmons,
                                        .order      = storage.order,
                                        .positions  = storage.positions,
                                        .due        = storage.due,
                                        .capacity   = PMONS,
                                        .fmons      = storage.fmons,
                                        .touched    = storage.touched,
                                        .members    = storage.members,
                                        .functional = 1U};
    const statistics_room_t sampling = {.statistics = storage.entries,
                                        .due        = storage.samples,
                                        .positions  = storage.sample_positions,
                                        .capacity   = STATISTICS};
    subsystem_monitoring_service_add(subsystem, &storage.monitoring, &room);
    subsystem_statistics_service_add(subsystem, &storage.statistics, &sampling);
}

static void begin(const pus_persistence_t* where)
{
    (void)memset(&storage, 0xA5, sizeof storage);
    (void)memset(&kept, 0, sizeof kept);
    subsystem_config_t config = fixture.subsystem.config;
    config.optional           = (subsystem_services_t){&storage, add_services};
    config.persistence        = where;
    fixture_begin(&config);
}

void setUp(void)
{
    fixture_open_with(
        "<Event name='INFO' id='4' severity='INFORMATIVE'/>",
        "<Event name='INFO' id='4' severity='INFORMATIVE'/>"
        "<Event name='CROSSED' id='20' severity='LOW'><ParamRef name='WHAT' type='UINT8' "
        "count='16'/></Event><Event name='FAILED' id='21' severity='LOW'>"
        "<ParamRef name='FMON' type='UINT16'/><ParamRef name='FAILING' type='UINT16'/></Event>");
    begin(NULL);
}

void tearDown(void)
{
    fixture_close();
}

static void request(uint8_t service, uint8_t subtype)
{
    (void)fixture_command(service, subtype, data, writer.position);
    writer = octet_writer(data, sizeof data);
}

/// Send a request and expect that it is completed.
static void expect_completed(uint8_t service, uint8_t subtype)
{
    fixture_forget();
    request(service, subtype);
    TEST_ASSERT_TRUE(fixture_has("1.7 #"));
    fixture_forget();
}

/// Restore the only record in a component that starts again; a truncated record is refused.
static void restore_the_record(uint8_t service)
{
    static uint8_t record[sizeof kept.octets];
    const uint32_t key = kept.key;
    const size_t size  = kept.size;
    TEST_ASSERT_EQUAL_UINT(1U, kept.puts);
    TEST_ASSERT_TRUE(kept.commits > 0U);
    TEST_ASSERT_EQUAL_UINT8(service, kept.table);
    (void)memcpy(record, kept.octets, size);
    begin(NULL);
    TEST_ASSERT_EQUAL(STATUS_INVALID, subsystem_restore(&fixture.subsystem, service, key, record, size - 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_restore(&fixture.subsystem, service, key, record, size));
}

// ---- ST[12] ----

/// TC[12,5]: a PMON with limits 10..20 on COUNT, sampled in each cycle.
static void write_pmon(uint16_t id, uint16_t low_event, uint16_t high_event)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, 1U);
    octet_write_u16(&writer, id);
    octet_write_u32(&writer, fixture_count_id);
    octet_write_u32(&writer, 0U); // No validity condition.
    octet_write_u16(&writer, 0U);
    octet_write_u32(&writer, 1U);
    octet_write_u16(&writer, 1U);
    octet_write_u8(&writer, PUS_CHECK_LIMIT);
    octet_write_u16(&writer, 10U);
    octet_write_u16(&writer, low_event);
    octet_write_u16(&writer, 20U);
    octet_write_u16(&writer, high_event);
}

static void write_id(uint16_t id)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, 1U);
    octet_write_u16(&writer, id);
}

/// In PRE_OPERATIONAL, add PMON `id` on COUNT, enable it and the monitoring function, and run one cycle.
static void monitor_count(uint16_t id, uint16_t low_event, uint16_t high_event)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.count = 15U;
    write_pmon(id, low_event, high_event);
    expect_completed(12U, 5U);
    write_id(id);
    expect_completed(12U, 1U);
    expect_completed(12U, 15U);
    fixture_run(1U);
    fixture_forget();
}

/// Auxiliary data: PMON id, parameter id, check type (limit), status (above the high limit), value 21 as
/// double.
static void an_event_carries_the_values_of_its_monitor(void)
{
    monitor_count(1U, 0U, FIXTURE_CROSSED);
    fixture.count = 21U;
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.2 event 20 aux 0001"
                                 "02010002"
                                 "01"
                                 "04"
                                 "4035000000000000\n"));
}

static void an_event_of_another_size_contains_the_parameters_of_its_definition(void)
{
    monitor_count(1U, FIXTURE_NOTE, FIXTURE_LINK_STALE);
    fixture.limit = 1.0;
    fixture.count = 9U;
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.2 event 3 aux 3FF0000000000000\n"));
    fixture.count = 21U;
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.4 event 6 aux \n"));
    // The event has the effect of an event that the subsystem raises.
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, subsystem_state(&fixture.subsystem));
}

/// The monitor does not have the values of these events, and must not report zeros instead. The refusal is
/// PUS_FAILURE_ACCESS, 0x0206, with the id of the event.
static void an_event_with_values_that_a_monitor_does_not_have_is_refused(void)
{
    static const uint16_t events[][2] = {{FIXTURE_BROKEN, 0U}, {0U, FIXTURE_BROKEN}, {FIXTURE_FAILED, 0U}};
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    for (unsigned i = 0U; i < 3U; i++) {
        fixture_forget();
        write_pmon(1U, events[i][0], events[i][1]);
        request(12U, 5U);
        const char* const lines = fixture_look();
        TEST_ASSERT_NOT_NULL(strstr(lines, (i < 2U) ? " 0206 1 in 1\n" : " 0206 15 in 1\n"));
        TEST_ASSERT_NULL(strstr(lines, "1.7 #"));
    }
}

static void only_events_of_the_descriptor_are_accepted(void)
{
    write_pmon(1U, 0U, 999U);
    fixture_forget();
    request(12U, 5U);
    TEST_ASSERT_FALSE(fixture_has("1.7 #"));
    TEST_ASSERT_EQUAL_UINT32(1U, storage.monitoring.monitoring.counters.refused);
}

static void an_event_that_a_new_descriptor_does_not_have_is_not_raised(void)
{
    static subsystem_descriptor_t without;
    monitor_count(1U, 0U, FIXTURE_CROSSED);
    TEST_ASSERT_TRUE(fixture_parse(fixture_descriptor(), &without));
    fixture.next_descriptor = &without;
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    (void)fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_RELOAD, NULL, 0U);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture.count = 21U;
    fixture_run(1U);
    TEST_ASSERT_FALSE(fixture_has("5."));
    TEST_ASSERT_EQUAL_UINT16(PUS_CHECK_HIGH, storage.pmons[storage.order[0]].status);
}

static status_t find_nothing(void* context, uint32_t parameter_id, uint16_t* out_handle, uint16_t* out_size)
{
    (void)context;
    (void)parameter_id;
    (void)out_handle;
    (void)out_size;
    return STATUS_NOT_FOUND;
}

static pus_parameter_port_t watch_nothing(void* self)
{
    TEST_ASSERT_EQUAL_PTR(&fixture, self);
    return (pus_parameter_port_t){.context = self, .find = find_nothing};
}

static void a_callback_of_the_subsystem_selects_the_monitored_parameters(void)
{
    static subsystem_callbacks_t others;
    subsystem_config_t config = fixture.subsystem.config;
    others                    = *config.callbacks;
    others.watched            = watch_nothing;
    config.callbacks          = &others;
    config.optional           = (subsystem_services_t){&storage, add_services};
    fixture_begin(&config);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    write_pmon(1U, 0U, 0U);
    fixture_forget();
    request(12U, 5U);
    TEST_ASSERT_FALSE(fixture_has("1.7 #"));
    TEST_ASSERT_EQUAL_UINT32(1U, storage.monitoring.monitoring.counters.refused);
}

static void functional_monitoring_raises_events_too(void)
{
    monitor_count(1U, 0U, 0U);
    octet_write_u8(&writer, 1U);
    octet_write_u16(&writer, 5U); // FMON 5, without a validity condition.
    octet_write_u32(&writer, 0U);
    octet_write_u16(&writer, 0U);
    octet_write_u16(&writer, FIXTURE_FAILED);
    octet_write_u16(&writer, 1U);
    octet_write_u8(&writer, 1U);
    octet_write_u16(&writer, 1U);
    expect_completed(12U, 23U);
    write_id(5U);
    expect_completed(12U, 19U);
    expect_completed(12U, 17U);
    fixture.count = 21U;
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture_has("5.2 event 21 aux 00050001\n"));
}

static void parameters_that_are_absent_are_not_checked(void)
{
    monitor_count(1U, FIXTURE_CROSSED, FIXTURE_CROSSED);
    (void)fixture_state(STATE_OFFLINE);
    fixture_run(10U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_INVALID, storage.pmons[storage.order[0]].status);
    fixture.count = 21U;
    fixture_run(10U);
    TEST_ASSERT_FALSE(fixture_has("5."));
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE); // The parameters exist again.
    fixture.count = 21U;
    fixture_run(1U);
    TEST_ASSERT_EQUAL_UINT8(PUS_CHECK_HIGH, storage.pmons[storage.order[0]].status);
}

static void a_definition_is_restored_from_its_record(void)
{
    begin(&persistence);
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    write_pmon(7U, FIXTURE_NOTE, FIXTURE_CROSSED);
    expect_completed(12U, 5U);
    restore_the_record(12U);
    TEST_ASSERT_EQUAL_UINT16(1U, storage.monitoring.monitoring.pmon_count);
}

// ---- ST[04] ----

/// TC[4,6]: COUNT, every given number of milliseconds.
static void write_statistic(uint32_t interval_ms)
{
    const uint64_t ticks = (((uint64_t)interval_ms * TICKS_PER_S) + 999U) / 1000U;
    writer               = octet_writer(data, sizeof data);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, fixture_count_id);
    octet_write_u8(&writer, 0U);
    octet_write_u16(&writer, 0U);
    octet_write_u32(&writer, (uint32_t)ticks);
}

static uint32_t samples(void)
{
    return storage.statistics.statistics.counters.samples;
}

static void intervals_are_measured_in_time_and_not_in_cycles(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture_run(1U);
    write_statistic(5U);
    expect_completed(4U, 6U);
    fixture_run(100U); // 100 cycles of 1 ms.
    TEST_ASSERT_EQUAL_UINT32(20U, samples());
    (void)fixture_state(STATE_OFFLINE);
    fixture_run_until(fixture.now_ns + 100000000U);
    fixture_run(1U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    const uint32_t missing = storage.statistics.statistics.counters.missing;
    fixture_run(10U); // In OFFLINE a cycle has 10 ms: one step in each cycle, although two were due.
    TEST_ASSERT_EQUAL_UINT32(missing + 10U, storage.statistics.statistics.counters.missing);
}

static void no_interval_is_shorter_than_a_millisecond(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    write_statistic(0U);
    request(4U, 6U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #"));
    write_statistic(1U);
    expect_completed(4U, 6U);
    fixture_run(10U);
    TEST_ASSERT_EQUAL_UINT32(10U, samples());
}

static void a_statistic_is_restored_from_its_record(void)
{
    begin(&persistence);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    write_statistic(1U);
    expect_completed(4U, 6U);
    restore_the_record(4U);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture_run(10U);
    TEST_ASSERT_TRUE(samples() >= 10U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_event_carries_the_values_of_its_monitor);
    RUN_TEST(an_event_of_another_size_contains_the_parameters_of_its_definition);
    RUN_TEST(an_event_with_values_that_a_monitor_does_not_have_is_refused);
    RUN_TEST(only_events_of_the_descriptor_are_accepted);
    RUN_TEST(an_event_that_a_new_descriptor_does_not_have_is_not_raised);
    RUN_TEST(a_callback_of_the_subsystem_selects_the_monitored_parameters);
    RUN_TEST(functional_monitoring_raises_events_too);
    RUN_TEST(parameters_that_are_absent_are_not_checked);
    RUN_TEST(a_definition_is_restored_from_its_record);
    RUN_TEST(intervals_are_measured_in_time_and_not_in_cycles);
    RUN_TEST(no_interval_is_shorter_than_a_millisecond);
    RUN_TEST(a_statistic_is_restored_from_its_record);
    return UNITY_END();
}
