// SPDX-License-Identifier: Apache-2.0
// Event reports: disabled events, events that wait, and the limiter of events. The numbers of requests and
// reports are subtypes; pus/catalogue/st05_events.txt has their names and fields.
#include "pus/st05/st05_events.h"

#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static const pus_event_definition_t definitions[] = {
    {.id = 1U, .severity = PUS_SEVERITY_HIGH, .aux_size = 3U},
    {.id = 2U, .severity = PUS_SEVERITY_MEDIUM},
    {.id = 300U, .severity = PUS_SEVERITY_LOW},
    {.id = 4U, .severity = PUS_SEVERITY_INFORMATIVE, .aux_size = 8U},
};
static pus_event_state_t states[4];
static pus_events_t events;

void setUp(void)
{
    bench_start();
    memset(states, 0xA5, sizeof states);
    memset(&events, 0xA5, sizeof events);
    pus_events_init(&events, &bench.process, definitions, states, 4U);
    bench_serve(pus_events_service(&events));
}

void tearDown(void)
{
}

static status_t raise_event(const uint16_t id, const size_t size)
{
    static const uint8_t aux[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    return pus_event_raise(&events, id, aux, size, TEST_NOW_NS);
}

static void severity_is_the_subtype_and_the_data_follows_the_id(void)
{
    static const uint8_t high[] = {0, 1, 1, 2, 3};
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(1U, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(2U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, 300U, NULL, 0U, TEST_NOW_NS));
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(4U, 8U));
    EXPECT_MESSAGES(5, 4, 5, 3, 5, 2, 5, 1);
    TEST_ASSERT_EQUAL_UINT64(5U, bench_report(0U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(high, bench_report(0U).data, 5U);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    TEST_ASSERT_EQUAL_UINT32(4U, events.counters.reported);
    TEST_ASSERT_EQUAL_UINT32(1U, states[2].raised);
}

static void unknown_ids_and_other_sizes_are_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, raise_event(3U, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, raise_event(1U, 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, raise_event(1U, 4U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL_UINT32(3U, events.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(0U, states[0].raised);
}

static void a_disabled_event_is_counted_and_only_the_supervisor_gets_a_notice(void)
{
    static const uint8_t two[]    = {2, 0, 1, 1, 44};
    static const uint8_t list[]   = {0, 2, 0, 1, 1, 44};
    static const uint8_t notice[] = {0, 1, PUS_SEVERITY_HIGH}; // A notice has no auxiliary data.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(6U, two, sizeof two));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(1U, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(300U, 0U));
    EXPECT_MESSAGES(129, 7, 129, 7);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_SUPERVISOR, bench_report(0U).destination);
    TEST_ASSERT_EQUAL_UINT64(sizeof notice, bench_report(0U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(notice, bench_report(0U).data, sizeof notice);
    TEST_ASSERT_EQUAL_UINT32(1U, states[0].raised);
    TEST_ASSERT_EQUAL_UINT32(2U, events.counters.disabled);
    TEST_ASSERT_EQUAL_UINT32(0U, events.counters.reported);
    bench_clear();

    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 5, 8, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof list, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(list, bench_report(2U).data, sizeof list);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(2U).destination);

    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(5U, two, sizeof two));
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(1U, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, NULL, 0U));
    EXPECT_MESSAGES(5, 4, 1, 1, 1, 3, 5, 8, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(3U).size); // The list is empty.
}

static pus_tm_t report_of(const uint8_t service, const uint8_t subtype, const uint8_t* const data,
                          const size_t size)
{
    return (pus_tm_t){.apid = 16U, .service = service, .subtype = subtype, .data = data, .size = size};
}

static void an_event_is_read_from_its_report_and_from_its_notice(void)
{
    static const uint8_t octets[] = {1, 44, PUS_SEVERITY_MEDIUM, 9, 9};
    pus_event_occurrence_t read;
    for (uint8_t subtype = 0U; subtype < 10U; subtype++) {
        const bool is_event = (subtype >= 1U) && (subtype <= 4U);
        const pus_tm_t tm   = report_of(PUS_SERVICE_EVENTS, subtype, octets, sizeof octets);
        TEST_ASSERT_EQUAL(is_event ? STATUS_OK : STATUS_NOT_FOUND, pus_event_occurrence_read(&tm, &read));
        const pus_tm_t other = report_of(PUS_SERVICE_MANAGEMENT, subtype, octets, 3U);
        TEST_ASSERT_EQUAL((subtype == 7U) ? STATUS_OK : STATUS_NOT_FOUND,
                          pus_event_occurrence_read(&other, &read));
    }
    pus_tm_t tm = report_of(PUS_SERVICE_EVENTS, 4U, octets, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_occurrence_read(&tm, &read));
    TEST_ASSERT_EQUAL_UINT16(16U, read.apid);
    TEST_ASSERT_EQUAL_UINT16(300U, read.event);
    TEST_ASSERT_EQUAL_UINT8(PUS_SEVERITY_HIGH, read.severity);
    tm.size = 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_event_occurrence_read(&tm, &read));
    for (size_t size = 0U; size <= sizeof octets; size++) {
        tm = report_of(PUS_SERVICE_MANAGEMENT, 7U, octets, size);
        TEST_ASSERT_EQUAL((size == 3U) ? STATUS_OK : STATUS_INVALID, pus_event_occurrence_read(&tm, &read));
    }
    for (uint8_t severity = 0U; severity < 6U; severity++) {
        const uint8_t notice[] = {1, 44, severity};
        tm                     = report_of(PUS_SERVICE_MANAGEMENT, 7U, notice, sizeof notice);
        TEST_ASSERT_EQUAL(((severity >= 1U) && (severity <= 4U)) ? STATUS_OK : STATUS_INVALID,
                          pus_event_occurrence_read(&tm, &read));
    }
}

static void unknown_instructions_are_refused_alone(void)
{
    static const uint8_t three[] = {3, 0, 9, 0, 1, 0, 8}; // Events 9, 1 and 8.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(6U, three, sizeof three));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 4, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 9U);
    expect_failure(3U, 4U, PUS_FAILURE_UNKNOWN_ID, 3U, 8U);
    expect_failure(4U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 2U);
    TEST_ASSERT_TRUE(states[0].is_disabled);
}

static void an_event_waits_while_the_port_refuses(void)
{
    bench.refusals = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(1U, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, raise_event(2U, 0U));
    EXPECT_MESSAGES(5, 4, 5, 3);
    unsigned raised = 0U;
    bench_clear();
    do {
        bench.refusals = 1U;
        raised++;
    } while (raise_event(4U, 8U) == STATUS_OK);
    TEST_ASSERT_EQUAL_UINT32(raised, states[3].raised);
    TEST_ASSERT_EQUAL_UINT32(1U, events.counters.refused);
    bench.refusals = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT64(raised - 1U, bench.count);
}

// ---- Limiter ----

#define SUPPRESSED 9U
#define MS 1000000ULL

enum {
    NOISE,
    OTHER
};

static const pus_event_definition_t limited[] = {
    {.id = 1U, .severity = PUS_SEVERITY_LOW, .burst = PUS_EVENT_BURST, .interval_ms = PUS_EVENT_INTERVAL_MS},
    {.id = 2U, .severity = PUS_SEVERITY_MEDIUM, .burst = 3U, .interval_ms = 1U},
    {.id = 3U, .severity = PUS_SEVERITY_HIGH},
    {.id          = SUPPRESSED,
     .severity    = PUS_SEVERITY_LOW,
     .burst       = 20U,
     .aux_size    = PUS_SUPPRESSED_AUX,
     .interval_ms = 100U}};

static void limit(void)
{
    memset(&events, 0xA5, sizeof events);
    pus_events_init(&events, &bench.process, limited, states, 4U);
    pus_events_report_suppressed_by(&events, SUPPRESSED);
}

/// Raise an event this number of times at one time. Returns the number of events that were reported.
static unsigned count_reported_of(const uint16_t id, const unsigned times, const uint64_t now_ns)
{
    const uint32_t before = events.counters.reported;
    for (unsigned i = 0U; i < times; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, id, NULL, 0U, now_ns));
    }
    return events.counters.reported - before;
}

static void a_burst_is_reported_and_then_events_at_the_configured_rate(void)
{
    // The last value is just before the milliseconds wrap.
    static const uint64_t begins_ms[] = {0U, 5000U, UINT32_MAX - 150U};
    for (unsigned i = 0U; i < 3U; i++) {
        const uint64_t begin = begins_ms[i] * MS;
        bench_clear();
        limit();
        if (i == 2U) {
            TEST_ASSERT_EQUAL(1U, count_reported_of(1U, 1U, begin - (5000U * MS)));
        }
        TEST_ASSERT_EQUAL(20U, count_reported_of(1U, 100U, begin));
        TEST_ASSERT_EQUAL(0U, count_reported_of(1U, 10U, begin + (99U * MS)));
        TEST_ASSERT_EQUAL(1U, count_reported_of(1U, 10U, begin + (100U * MS)));
        TEST_ASSERT_EQUAL(0U, count_reported_of(1U, 10U, begin + (199U * MS)));
        TEST_ASSERT_EQUAL(3U, count_reported_of(1U, 10U, begin + (400U * MS)));
        // 1.9 s later all occurrences of the burst except one are permitted again.
        TEST_ASSERT_EQUAL(19U, count_reported_of(1U, 50U, begin + (2300U * MS)));
        TEST_ASSERT_EQUAL(20U, count_reported_of(1U, 50U, begin + (90000U * MS)));
        TEST_ASSERT_EQUAL(3U, count_reported_of(2U, 5U, begin)); // Each event has a limit of its own.
        TEST_ASSERT_EQUAL(1U, count_reported_of(2U, 5U, begin + MS));
        TEST_ASSERT_EQUAL_UINT32(events.states[NOISE].raised + events.states[OTHER].raised,
                                 events.counters.reported + events.counters.suppressed);
    }
}

static void an_event_without_a_rate_always_passes(void)
{
    TEST_ASSERT_EQUAL(100U, count_reported_of(300U, 100U, 0U));
    TEST_ASSERT_EQUAL_UINT32(0U, events.counters.suppressed);
}

static uint32_t count_reported(const size_t index, const uint16_t id)
{
    octet_reader_t reader = bench_data(index);
    TEST_ASSERT_EQUAL_UINT16(SUPPRESSED, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT16(id, octet_read_u16(&reader));
    return octet_read_u32(&reader);
}

static void suppressed_events_are_reported_once_a_second(void)
{
    limit();
    TEST_ASSERT_FALSE(pus_events_step(&events, 0U));
    (void)count_reported_of(1U, 25U, MS);
    (void)count_reported_of(2U, 5U, MS);
    bench_clear();
    TEST_ASSERT_TRUE(pus_events_step(&events, MS)); // The events are reported in turn, one per step.
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    TEST_ASSERT_EQUAL_UINT32(2U, count_reported(0U, 2U));
    (void)count_reported_of(2U, 4U, 2U * MS);
    (void)count_reported_of(1U, 7U, 2U * MS);
    bench_clear();
    TEST_ASSERT_TRUE(pus_events_step(&events, 1000U * MS));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count); // The interval has not ended yet.
    TEST_ASSERT_TRUE(pus_events_step(&events, 1001U * MS));
    TEST_ASSERT_EQUAL_UINT32(12U, count_reported(0U, 1U));
    TEST_ASSERT_FALSE(pus_events_step(&events, 2001U * MS));
    TEST_ASSERT_EQUAL_UINT32(3U, count_reported(1U, 2U));
    TEST_ASSERT_FALSE(pus_events_step(&events, 9000U * MS));
    TEST_ASSERT_EQUAL_UINT64(2U, bench.count);
}

static void the_number_of_suppressed_events_is_reported_later_if_there_is_no_room(void)
{
    limit();
    (void)count_reported_of(1U, 30U, MS);
    bench_clear();
    while (raise_event(SUPPRESSED, 6U) == STATUS_OK) { // Fill the queue of reports.
        bench.refusals   = 1000U;
        states[3].due_ms = 0U;
    }
    TEST_ASSERT_TRUE(pus_events_step(&events, 2000U * MS));
    bench.refusals = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    bench_clear();
    TEST_ASSERT_FALSE(pus_events_step(&events, 3000U * MS));
    TEST_ASSERT_EQUAL_UINT32(10U, count_reported(0U, 1U));
}

static void without_an_event_for_them_suppressed_events_are_only_counted(void)
{
    limit();
    pus_events_report_suppressed_by(&events, 0U);
    (void)count_reported_of(1U, 30U, MS);
    TEST_ASSERT_FALSE(pus_events_step(&events, 2000U * MS));
    TEST_ASSERT_EQUAL_UINT32(10U, events.counters.suppressed);
}

static void a_high_event_is_sent_unless_an_earlier_one_still_waits(void)
{
    for (unsigned is_notice = 0U; is_notice < 2U; is_notice++) {
        bench_clear();
        limit();
        states[2].is_disabled = (is_notice == 1U);
        bench.accepts         = 1U;
        for (unsigned i = 0U; i < 50U; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, 3U, NULL, 0U, MS));
        }
        TEST_ASSERT_EQUAL_UINT32(48U, events.counters.suppressed); // One event was sent, and one waits.
        TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, 2U, NULL, 0U, MS));
        bench.accepts = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
        TEST_ASSERT_EQUAL_UINT64(3U, bench.count);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, 3U, NULL, 0U, MS));
        TEST_ASSERT_EQUAL_UINT64(4U, bench.count);
        TEST_ASSERT_EQUAL_UINT32(48U, events.counters.suppressed);
    }
}

/// 100 events in each millisecond for 60 s: the sum of the reported numbers is the number of all events.
static void all_occurrences_of_a_frequent_event_are_reported_or_counted(void)
{
    uint32_t sum = 0U;
    limit();
    for (uint64_t ms = 0U; ms < 60000U; ms++) {
        (void)count_reported_of(1U, 100U, ms * MS);
        (void)pus_events_step(&events, ms * MS);
        for (size_t i = 0U; i < bench.count; i++) {
            sum += (bench_report(i).data[1] == SUPPRESSED) ? count_reported(i, 1U) : 1U;
        }
        bench_clear();
    }
    TEST_ASSERT_EQUAL_UINT32(6000000U, states[NOISE].raised);
    TEST_ASSERT_EQUAL_UINT32(6000000U, sum + states[NOISE].suppressed);
    TEST_ASSERT_EQUAL_UINT32(20U + 599U, states[NOISE].raised - events.counters.suppressed);
}

static void the_largest_auxiliary_data_fits_and_the_next_does_not(void)
{
    static uint8_t aux[PUS_TM_DATA_MAX];
    static const pus_event_definition_t large[] = {
        {.id = 1U, .severity = PUS_SEVERITY_LOW, .aux_size = PUS_TM_DATA_MAX - 2U},
        {.id = 2U, .severity = PUS_SEVERITY_LOW, .aux_size = PUS_TM_DATA_MAX - 1U}};
    memset(&events, 0xA5, sizeof events);
    pus_events_init(&events, &bench.process, large, states, 2U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_raise(&events, 1U, aux, PUS_TM_DATA_MAX - 2U, TEST_NOW_NS));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_event_raise(&events, 2U, aux, PUS_TM_DATA_MAX - 1U, TEST_NOW_NS));
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
}

static void more_disabled_events_than_a_report_holds_are_refused(void)
{
    static pus_event_definition_t many[2100];
    static pus_event_state_t many_states[2100];
    const unsigned room = (PUS_TM_DATA_MAX - 2U) / 2U;
    for (uint16_t i = 0U; i < 2100U; i++) {
        many[i] = (pus_event_definition_t){.id = i, .severity = PUS_SEVERITY_LOW};
    }
    memset(&events, 0xA5, sizeof events);
    pus_events_init(&events, &bench.process, many, many_states, 2100U);
    for (unsigned i = 0U; i <= room; i++) {
        many_states[i].is_disabled = true;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, NULL, 0U));
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, room);
    many_states[0].is_disabled = false;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 5, 8, 1, 7);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t two[] = {2, 0, 1, 0, 2};
    expect_strict_format(5U, two, sizeof two);
    expect_strict_format(6U, two, sizeof two);
    expect_strict_format(7U, NULL, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(5U, "\0", 1U));
    for (uint8_t subtype = 0U; subtype < 5U; subtype++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, two, sizeof two));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(severity_is_the_subtype_and_the_data_follows_the_id);
    RUN_TEST(unknown_ids_and_other_sizes_are_refused);
    RUN_TEST(a_disabled_event_is_counted_and_only_the_supervisor_gets_a_notice);
    RUN_TEST(an_event_is_read_from_its_report_and_from_its_notice);
    RUN_TEST(unknown_instructions_are_refused_alone);
    RUN_TEST(an_event_waits_while_the_port_refuses);
    RUN_TEST(a_burst_is_reported_and_then_events_at_the_configured_rate);
    RUN_TEST(an_event_without_a_rate_always_passes);
    RUN_TEST(suppressed_events_are_reported_once_a_second);
    RUN_TEST(the_number_of_suppressed_events_is_reported_later_if_there_is_no_room);
    RUN_TEST(without_an_event_for_them_suppressed_events_are_only_counted);
    RUN_TEST(a_high_event_is_sent_unless_an_earlier_one_still_waits);
    RUN_TEST(all_occurrences_of_a_frequent_event_are_reported_or_counted);
    RUN_TEST(the_largest_auxiliary_data_fits_and_the_next_does_not);
    RUN_TEST(more_disabled_events_than_a_report_holds_are_refused);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
