// SPDX-License-Identifier: Apache-2.0
// Properties of positions; test_st11_*.c tests the part that time and position schedules share. The numbers
// of requests and reports are subtypes; pus/catalogue/st22_position_schedule.txt has their names and fields.
#include "pus/st22/st22_position_schedule.h"

#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "unity.h"

#include <string.h>

#define ORBIT ((uint64_t)PUS_POSITION_TICKS)

static pus_position_schedule_t schedule;
static pus_schedule_config_t config;
static uint64_t position; // Position that the source returns.
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

static uint64_t read_position(void* const context)
{
    (void)context;
    return position;
}

static void start(void)
{
    const pus_position_port_t port = {.read = read_position};
    memset(&schedule, 0xA5, sizeof schedule);
    pus_position_schedule_init(&schedule, &port, &config);
    bench_serve(pus_position_schedule_service(&schedule));
}

void setUp(void)
{
    bench_start();
    released_clear();
    config   = schedule_config(100U, 200U);
    position = 10U * ORBIT;
    start();
}

void tearDown(void)
{
    records_start();
}

static void begin(void)
{
    writer = octet_writer(data, sizeof data);
}

static void request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, writer.position));
}

static void expect_done(const uint8_t subtype)
{
    request(subtype);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void send(const uint8_t subtype, const void* const octets, const size_t size)
{
    begin();
    octet_write_octets(&writer, octets, size);
    expect_done(subtype);
}
#define SEND(subtype, ...)                                                                                   \
    send(subtype, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

static void write_position(const uint64_t tag)
{
    octet_write_u32(&writer, (uint32_t)(tag / ORBIT));
    octet_write_u16(&writer, (uint16_t)(tag % ORBIT));
}

static void insert(const uint64_t tag, const uint16_t sequence)
{
    begin();
    octet_write_u8(&writer, 1U);
    octet_write_u8(&writer, 1U);
    octet_write_u8(&writer, 2U);
    write_position(tag);
    request_write(&writer, sequence, 0U);
    request(4U);
}

/// Group 2 and sub-schedule 1 exist, and all is enabled.
static void enable_all(void)
{
    SEND(22U, 1, 2, 1);
    insert(90U * ORBIT, 900U);
    SEND(20U, 0);
    begin();
    expect_done(1U);
    SEND(5U, 1, 0, RELEASE_SOURCE, 0, RELEASE_APID, 900U >> 8U, 900U & 0xFFU);
}

static void step_at(const uint64_t tag)
{
    position = tag;
    pus_position_schedule_step(&schedule, TEST_NOW_NS);
}

static void set_orbit(const uint32_t number)
{
    begin();
    octet_write_u32(&writer, number);
    expect_done(28U);
}

static void an_activity_is_released_at_its_position(void)
{
    enable_all();
    insert((12U * ORBIT) + 0x8000U, 1U);
    insert((12U * ORBIT) + 0x7FFFU, 2U);
    insert(13U * ORBIT, 3U);
    step_at((12U * ORBIT) + 0x7FFEU);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    step_at((12U * ORBIT) + 0x7FFFU);
    step_at((12U * ORBIT) + 0x7FFFU); // The position does not change.
    EXPECT_RELEASED(2);
    step_at((12U * ORBIT) + 0x8000U);
    EXPECT_RELEASED(1);
    step_at(11U * ORBIT); // The position goes back, and then far ahead.
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    step_at(100U * ORBIT);
    EXPECT_RELEASED(3);
    insert(100U * ORBIT, 4U); // The present position.
    step_at(100U * ORBIT);
    EXPECT_RELEASED(4);
    insert((100U * ORBIT) - 1U, 5U);
    expect_failure(1U, 4U, PUS_FAILURE_PAST, 1U, 0U);
}

static void positions_are_reported_and_shifted_across_orbits(void)
{
    static const uint8_t expected[] = {0, 1, 1, 2, 0, 0, 0, 12, 0xFF, 0xFE, 0, 9, 0, 17, 0, 1};
    enable_all();
    insert((13U * ORBIT) + 1U, 1U);
    SEND(15U, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFD); // Back by 3 of 2^-16 orbits.
    begin();
    request(17U);
    EXPECT_MESSAGES(1, 1, 1, 3, 22, 13, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    SEND(15U, 0, 0, 0, 1, 0, 3); // Forward by one orbit and 3 of 2^-16 orbits.
    TEST_ASSERT_EQUAL_UINT64((14U * ORBIT) + 1U, pus_schedule_next(&schedule.schedule));
    begin();
    octet_write_octets(&writer, (const uint8_t[]){0x80, 0, 0, 0, 0, 0}, 6U);
    request(15U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    // A window with both ends, which are included.
    SEND(8U, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 14, 0, 1, 0, 0, 0, 14, 0, 1, 0, 0);
    TEST_ASSERT_EQUAL_UINT64((15U * ORBIT) + 1U, pus_schedule_next(&schedule.schedule));
}

static void the_last_position_is_the_largest(void)
{
    enable_all();
    insert((1ULL << 48U) - 1U, 1U);
    TEST_ASSERT_EQUAL_UINT64((1ULL << 48U) - 1U, pus_schedule_next(&schedule.schedule));
    begin();
    octet_write_octets(&writer, (const uint8_t[]){0, 0, 0, 0, 0, 1}, 6U);
    request(15U);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 0U);
    step_at((1ULL << 48U) - 1U);
    EXPECT_RELEASED(1);
}

static void an_orbit_number_applies_from_the_next_orbit_on(void)
{
    enable_all();
    insert(1000U * ORBIT, 1U);
    step_at((10U * ORBIT) + 5U);
    set_orbit(1000U);
    TEST_ASSERT_EQUAL_UINT64((10U * ORBIT) + 5U, pus_position_schedule_now(&schedule));
    step_at((10U * ORBIT) + 0xFFFFU);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    step_at(11U * ORBIT);
    EXPECT_RELEASED(1);
    TEST_ASSERT_EQUAL_UINT64(1000U * ORBIT, pus_position_schedule_now(&schedule));
    step_at((15U * ORBIT) + 1U);
    TEST_ASSERT_EQUAL_UINT64((1004U * ORBIT) + 1U, pus_position_schedule_now(&schedule));
    set_orbit(0U);        // A smaller orbit number.
    step_at(18U * ORBIT); // The position has skipped orbits 16 and 17.
    TEST_ASSERT_EQUAL_UINT64(2U * ORBIT, pus_position_schedule_now(&schedule));
    set_orbit(500U);
    step_at(12U * ORBIT); // The source goes back: the next orbit is 13.
    TEST_ASSERT_EQUAL_UINT64(((1ULL << 32U) - 4U) * ORBIT, pus_position_schedule_now(&schedule));
    step_at(13U * ORBIT);
    TEST_ASSERT_EQUAL_UINT64(500U * ORBIT, pus_position_schedule_now(&schedule));
}

/// The process makes no step between the start of the orbit and the next request.
static void an_orbit_number_is_in_force_before_the_next_one_is_set(void)
{
    position = 20U * ORBIT;
    set_orbit(700U);
    position = 21U * ORBIT;
    set_orbit(900U);
    TEST_ASSERT_EQUAL_UINT64(700U * ORBIT, pus_position_schedule_now(&schedule));
    position = 22U * ORBIT;
    TEST_ASSERT_EQUAL_UINT64(900U * ORBIT, pus_position_schedule_now(&schedule));
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_position_schedule_restore(self, key, octets, size);
}

static void the_orbit_number_outlives_a_power_cut(void)
{
    for (unsigned has_begun = 0U; has_begun < 2U; has_begun++) {
        records_start();
        config.persistence = records_port();
        bench_start();
        pus_dispatcher_persist(&bench.dispatcher, records_port());
        position = 10U * ORBIT;
        start();
        enable_all();
        insert(1001U * ORBIT, 1U);
        set_orbit(1000U);
        step_at((10U + has_begun) * ORBIT);
        records_cut();
        config             = schedule_config(100U, 200U);
        config.persistence = records_port();
        start();
        TEST_ASSERT_EQUAL_UINT64(3U, records_replay(PUS_SERVICE_POSITION_SCHEDULE, restore, &schedule));
        TEST_ASSERT_EQUAL_UINT64((has_begun == 1U) ? (1000U * ORBIT) : (10U * ORBIT),
                                 pus_position_schedule_now(&schedule));
        step_at(12U * ORBIT);
        EXPECT_RELEASED(1);
    }
    static const uint8_t octets[13] = {0};
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_position_schedule_restore(&schedule, PUS_SCHEDULE_KEY_OWN, octets, 11U));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_position_schedule_restore(&schedule, PUS_SCHEDULE_KEY_OWN, octets, 13U));
}

static void an_orbit_number_that_is_not_kept_is_not_acknowledged(void)
{
    config.persistence = records_port();
    start();
    set_orbit(6U);
    records.put_status = STATUS_FULL;
    begin();
    octet_write_u32(&writer, 7U);
    request(28U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    position = 11U * ORBIT;
    TEST_ASSERT_EQUAL_UINT64(6U * ORBIT, pus_position_schedule_now(&schedule)); // The number set before.
    begin();
    octet_write_u32(&writer, 9U);
    request(28U);
    position = 12U * ORBIT;
    TEST_ASSERT_EQUAL_UINT64(7U * ORBIT, pus_position_schedule_now(&schedule)); // Number 6 and one orbit.
}

static void each_request_of_the_service_is_declared(void)
{
    static const uint8_t subtypes[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  11, 12, 14,
                                       15, 16, 17, 18, 20, 21, 22, 23, 24, 25, 26, 28};
    const pus_service_t service     = pus_position_schedule_service(&schedule);
    TEST_ASSERT_EQUAL_UINT8(PUS_SERVICE_POSITION_SCHEDULE, service.type);
    TEST_ASSERT_EQUAL_UINT8(sizeof subtypes, service.subtype_count);
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        TEST_ASSERT_EQUAL_UINT8(subtypes[i], service.subtypes[i].subtype);
    }
    static const uint8_t octets[32] = {0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 2, 0, 1, 0, 0};
    expect_strict_format(28U, octets, 4U);
    expect_strict_format(15U, octets, 6U);
    expect_strict_format(8U, octets, 21U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_activity_is_released_at_its_position);
    RUN_TEST(positions_are_reported_and_shifted_across_orbits);
    RUN_TEST(the_last_position_is_the_largest);
    RUN_TEST(an_orbit_number_applies_from_the_next_orbit_on);
    RUN_TEST(an_orbit_number_is_in_force_before_the_next_one_is_set);
    RUN_TEST(the_orbit_number_outlives_a_power_cut);
    RUN_TEST(an_orbit_number_that_is_not_kept_is_not_acknowledged);
    RUN_TEST(each_request_of_the_service_is_declared);
    return UNITY_END();
}
