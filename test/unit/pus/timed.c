// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/timed.h"

#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"
#include "test/unit/pus/schedules.h"
#include "unity.h"

timed_t timed;

void timed_begin(void)
{
    timed.writer = octet_writer(timed.data, sizeof(timed.data));
}

status_t timed_request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(timed.writer.failed);
    return bench_request(subtype, timed.data, timed.writer.position);
}

void timed_expect_done(const uint8_t subtype)
{
    TEST_ASSERT_EQUAL(STATUS_OK, timed_request(subtype));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

void timed_command(const uint8_t subtype)
{
    timed_begin();
    timed_expect_done(subtype);
}

void timed_command_ids(const uint8_t subtype, const unsigned count, const uint8_t* const ids)
{
    timed_begin();
    octet_write_u8(&timed.writer, (uint8_t)count);
    octet_write_octets(&timed.writer, ids, count);
    (void)timed_request(subtype);
}

void timed_create_group(const uint8_t group, const uint8_t status)
{
    timed_begin();
    octet_write_u8(&timed.writer, 1U);
    octet_write_u8(&timed.writer, group);
    octet_write_u8(&timed.writer, status);
    timed_expect_done(22U);
}

void timed_write_time(const uint64_t time_ns)
{
    pus_time_write(&timed.writer, (TEST_EPOCH_S * S) + time_ns);
}

void timed_write_offset(const int64_t milliseconds)
{
    const int64_t ticks = (milliseconds * (int64_t)PUS_TIME_TICKS_PER_S) / 1000;
    for (int shift = 48; shift >= 0; shift -= 8) {
        octet_write_u8(&timed.writer, (uint8_t)(((uint64_t)ticks >> shift) & 0xFFU));
    }
}

void timed_begin_insert(const uint8_t sub_schedule, const unsigned count)
{
    timed_begin();
    octet_write_u8(&timed.writer, sub_schedule);
    octet_write_u8(&timed.writer, (uint8_t)count);
}

void timed_add(const uint8_t group, const uint64_t time_ns, const uint16_t sequence, const size_t size)
{
    octet_write_u8(&timed.writer, group);
    timed_write_time(time_ns);
    request_write(&timed.writer, sequence, size);
}

void timed_insert(const uint8_t sub_schedule, const uint8_t group, const uint64_t time_ns,
                  const uint16_t sequence)
{
    timed_begin_insert(sub_schedule, 1U);
    timed_add(group, time_ns, sequence, 0U);
    timed_expect_done(4U);
}

void timed_write_id(const uint16_t sequence)
{
    octet_write_u16(&timed.writer, RELEASE_SOURCE);
    octet_write_u16(&timed.writer, RELEASE_APID);
    octet_write_u16(&timed.writer, sequence);
}

void timed_begin_ids(const unsigned count)
{
    timed_begin();
    octet_write_u8(&timed.writer, (uint8_t)count);
}

void timed_write_filter_all(void)
{
    octet_write_u8(&timed.writer, 0U);
    octet_write_u8(&timed.writer, 0U);
    octet_write_u8(&timed.writer, 0U);
}

void timed_expect_schedule(const int* const sequences)
{
    timed_begin();
    TEST_ASSERT_EQUAL(STATUS_OK, timed_request(17U));
    EXPECT_MESSAGES(1, 1, 1, 3, 11, 13, 1, 7);
    octet_reader_t reader = bench_data(2U);
    const uint16_t count  = octet_read_u16(&reader);
    for (uint16_t i = 0U; i < count; i++) {
        (void)octet_read_octets(&reader, 14U);
        TEST_ASSERT_TRUE(sequences[i] >= 0);
        TEST_ASSERT_EQUAL_UINT16(sequences[i], octet_read_u16(&reader));
    }
    TEST_ASSERT_EQUAL_INT(-1, sequences[count]);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

void timed_expect_empty(void)
{
    timed_expect_schedule((const int[]){-1});
}

void timed_start(void)
{
    pus_time_schedule_init(&timed.schedule, TEST_EPOCH_S, &timed.config);
    bench_serve(pus_time_schedule_service(&timed.schedule));
}

void timed_enable_all(void)
{
    static const uint8_t ids[] = {SS};
    timed_create_group(G, 1U);
    timed_insert(SS, G, 5U * S, 9999U);
    timed_command_ids(20U, 1U, ids);
    timed_begin_ids(1U);
    timed_write_id(9999U);
    timed_expect_done(5U);
    timed_command(1U);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_time_schedule_restore(self, key, octets, size);
}

void timed_restart(void)
{
    records_cut();
    timed.config             = schedule_config(timed.config.activity_count, 400U);
    timed.config.persistence = records_port();
    bench_start();
    pus_dispatcher_persist(&bench.dispatcher, records_port());
    timed_start();
    (void)records_replay(PUS_SERVICE_TIME_SCHEDULE, restore, &timed.schedule);
}

void timed_start_with_records(void)
{
    records_start();
    timed_restart();
}

void timed_set_up(void)
{
    bench_start();
    released_clear();
    timed.config = schedule_config(600U, 4000U);
    timed_start();
}

void timed_insert_ten(void)
{
    for (uint8_t i = 0U; i < 3U; i++) {
        timed_create_group((uint8_t)(G + i), 1U);
    }
    for (uint16_t i = 0U; i < 10U; i++) {
        timed_insert((uint8_t)(i % 2U), (uint8_t)(G + (i % 3U)), (2U + i) * S, i);
    }
}

void timed_write_window(const uint8_t type, const uint64_t from_ns, const uint64_t to_ns)
{
    octet_write_u8(&timed.writer, type);
    if ((type == 1U) || (type == 2U)) {
        timed_write_time(from_ns);
    }
    if ((type == 1U) || (type == 3U)) {
        timed_write_time(to_ns);
    }
}
