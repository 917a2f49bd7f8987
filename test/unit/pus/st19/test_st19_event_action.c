// SPDX-License-Identifier: Apache-2.0
// Event-action definitions: release of their requests, changes, reports and records. The numbers of requests
// and reports are subtypes; pus/catalogue/st19_event_action.txt has their names and fields.
#include "pus/st19/st19_event_action.h"

#include "test/unit/pus/fixtures/records.h"
#include "test/unit/pus/fixtures/reports.h"
#include "test/unit/pus/fixtures/schedules.h"
#include "unity.h"

#include <string.h>

#define DEFINITIONS 1000U
#define DEFINITION_BLOCKS 1200U
#define APID 33U
#define KEY(event) (((uint32_t)APID << 16U) | (event))

static pus_event_action_t actions;
static pus_event_action_config_t config;
static pus_event_action_definition_t
    definitions[DEFINITIONS + 1U]; // The last one does not belong to the service.
static uint16_t queue[DEFINITIONS];
static uint16_t buckets[1024];
static uint64_t storage[PUS_BLOCK_CHAIN_WORDS(DEFINITION_BLOCKS)];
static pool_slot_t slots[DEFINITION_BLOCKS];
static pus_block_chains_t chains;
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

static void start(const uint16_t count, const uint16_t blocks)
{
    pus_block_chains_init(&chains, storage, slots, blocks);
    config = (pus_event_action_config_t){.process          = &bench.process,
                                         .release          = released_port(),
                                         .persistence      = config.persistence,
                                         .definitions      = definitions,
                                         .definition_count = count,
                                         .queue            = queue,
                                         .buckets          = buckets,
                                         .bucket_count     = 1024U,
                                         .chains           = &chains};
    memset(definitions, 0xA5, sizeof definitions);
    memset(queue, 0xA5, sizeof queue);
    memset(buckets, 0xA5, sizeof buckets);
    memset(&actions, 0xA5, sizeof actions);
    pus_event_action_init(&actions, &config);
    bench_serve(pus_event_action_service(&actions));
}

void setUp(void)
{
    bench_start();
    released_clear();
    memset(&config, 0, sizeof config);
    start(DEFINITIONS, DEFINITION_BLOCKS);
}

void tearDown(void)
{
    records_start();
}

static void begin(const unsigned count)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, (uint8_t)count);
}

static void write_key(const uint16_t event)
{
    octet_write_u16(&writer, APID);
    octet_write_u16(&writer, event);
}

static void add(const uint16_t event, const uint16_t sequence, const size_t size)
{
    write_key(event);
    request_write(&writer, sequence, size);
}

static void request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, writer.position));
}

static void expect_done(const uint8_t subtype)
{
    request(subtype);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void command(const uint8_t subtype)
{
    writer = octet_writer(data, sizeof data);
    expect_done(subtype);
}

/// Send a request with one key.
static void command_key(const uint8_t subtype, const uint16_t event)
{
    begin(1U);
    write_key(event);
    request(subtype);
}

/// Define the requests 1..count for the events 1..count; enable them and the function.
static void define(const uint16_t count)
{
    for (uint16_t i = 1U; i <= count; i++) {
        begin(1U);
        add(i, i, 0U);
        expect_done(1U);
    }
    begin(0U);
    expect_done(4U);
    command(8U);
}

static void an_event_releases_its_request(void)
{
    define(3U);
    pus_event_action_observe(&actions, APID, 2U);
    EXPECT_RELEASED(2);
    pus_event_action_observe(&actions, APID + 1U, 2U);
    pus_event_action_observe(&actions, APID, 4U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    pus_event_action_observe(&actions, APID, 3U);
    pus_event_action_observe(&actions, APID, 3U);
    EXPECT_RELEASED(3, 3);
    TEST_ASSERT_EQUAL_UINT32(3U, actions.counters.observed);
    TEST_ASSERT_EQUAL_UINT32(3U, actions.counters.released);
    TEST_ASSERT_FALSE(pus_event_action_is_waiting(&actions));
}

static void function_and_definition_must_be_enabled(void)
{
    begin(1U);
    add(1U, 1U, 0U);
    expect_done(1U);
    pus_event_action_observe(&actions, APID, 1U);
    command(8U);
    pus_event_action_observe(&actions, APID, 1U); // A new definition is disabled.
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    command_key(4U, 1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    pus_event_action_observe(&actions, APID, 1U);
    EXPECT_RELEASED(1);
    command(9U);
    pus_event_action_observe(&actions, APID, 1U);
    command(8U);
    command_key(5U, 1U);
    pus_event_action_observe(&actions, APID, 1U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
}

static void a_definition_is_replaced_and_deleted_only_while_disabled(void)
{
    define(2U);
    begin(1U);
    add(1U, 11U, 0U);
    request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, KEY(1U));
    command_key(2U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 1U, KEY(1U));
    command_key(5U, 1U);
    begin(1U);
    add(1U, 11U, 200U);
    expect_done(1U);
    command_key(4U, 1U);
    pus_event_action_observe(&actions, APID, 1U);
    EXPECT_RELEASED(11);
    command_key(5U, 1U);
    begin(2U);
    write_key(1U);
    write_key(1U);
    request(2U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, KEY(1U));
    TEST_ASSERT_EQUAL_UINT16(1U, actions.count);
    TEST_ASSERT_EQUAL_UINT16(1U, chains.pool.stats.taken);
    command_key(4U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, KEY(1U));
}

static void each_faulty_definition_is_refused_alone(void)
{
    begin(7U);
    add(1U, 1U, 0U);
    const uint32_t apid = (uint32_t)writer.position;
    add(2U, 2U, 0U);
    octets_put_u16(&data[apid], 2047U);
    const uint32_t event = (uint32_t)writer.position;
    add(0U, 3U, 0U);
    const uint32_t checksum = (uint32_t)writer.position + 4U;
    add(4U, 4U, 0U);
    data[checksum + 12U] ^= 1U;
    add(5U, 5U, 0U);
    const uint32_t forged = (uint32_t)writer.position + 4U;
    add(6U, 6U, 0U);
    request_forge(&data[forged]);
    add(1U, 6U, 0U); // The definition is disabled, so it may be defined again.
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_OUT_OF_RANGE, 2U, apid);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, event);
    expect_failure(4U, 4U, PUS_FAILURE_EMBEDDED, 4U, checksum);
    expect_failure(5U, 4U, PUS_FAILURE_EMBEDDED, 6U, forged);
    TEST_ASSERT_EQUAL_UINT16(2U, actions.count);
    TEST_ASSERT_EQUAL_UINT32(4U, actions.counters.refused);
    begin(1U);
    add(9U, 1U, (PUS_EVENT_ACTION_REQUEST_MAX + 1U) - PUS_TC_MIN);
    request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_EMBEDDED, 1U, 5U);
    begin(1U);
    add(9U, 1U, PUS_EVENT_ACTION_REQUEST_MAX - PUS_TC_MIN);
    expect_done(1U);
    command_key(10U, 9U);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(2U).size);
}

static void definitions_beyond_the_table_or_the_blocks_are_refused(void)
{
    start(2U, 3U);
    begin(4U);
    add(1U, 1U, 100U); // The request takes three blocks.
    add(2U, 2U, 0U);
    add(3U, 3U, 0U);
    add(1U, 4U, 0U);
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 2U, 3U);
    start(2U, 3U);
    begin(4U);
    add(1U, 1U, 0U);
    add(2U, 2U, 0U);
    add(3U, 3U, 0U);
    add(1U, 4U, 0U);
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_TABLE_FULL, 3U, 2U);
}

static void requests_that_the_port_refuses_wait_in_order(void)
{
    define(3U);
    released.accepts  = 0U;
    released.refusals = 2U;
    pus_event_action_observe(&actions, APID, 2U);
    pus_event_action_observe(&actions, APID, 1U);
    pus_event_action_observe(&actions, APID, 2U);
    TEST_ASSERT_TRUE(pus_event_action_is_waiting(&actions));
    pus_event_action_step(&actions, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    TEST_ASSERT_EQUAL_UINT32(2U, actions.counters.deferred);
    pus_event_action_step(&actions, TEST_NOW_NS);
    EXPECT_RELEASED(2, 2, 1);
    TEST_ASSERT_FALSE(pus_event_action_is_waiting(&actions));
    TEST_ASSERT_EQUAL_UINT32(0U, actions.counters.dropped);
}

static void queued_requests_are_dropped_when_their_definition_is_disabled(void)
{
    define(3U);
    released.accepts  = 0U;
    released.refusals = 1U;
    for (uint16_t i = 1U; i <= 3U; i++) {
        pus_event_action_observe(&actions, APID, i);
    }
    command_key(5U, 2U);
    command_key(2U, 2U);
    begin(1U); // The definition of a queued request is deleted, and its slot is used again.
    add(7U, 7U, 0U);
    expect_done(1U);
    command_key(4U, 7U);
    pus_event_action_observe(&actions, APID, 7U);
    pus_event_action_step(&actions, TEST_NOW_NS);
    EXPECT_RELEASED(1, 7, 3);
    TEST_ASSERT_EQUAL_UINT32(1U, actions.counters.dropped);
    released.accepts  = 0U;
    released.refusals = 1U;
    pus_event_action_observe(&actions, APID, 1U);
    pus_event_action_observe(&actions, APID, 3U);
    command(9U);
    pus_event_action_step(&actions, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    TEST_ASSERT_EQUAL_UINT32(3U, actions.counters.dropped);
    TEST_ASSERT_FALSE(pus_event_action_is_waiting(&actions));
}

static void requests_beyond_the_queue_are_dropped(void)
{
    define(1U);
    released.accepts  = 0U;
    released.refusals = 1U;
    for (uint32_t i = 0U; i <= UINT16_MAX; i++) {
        pus_event_action_observe(&actions, APID, 1U);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, actions.counters.dropped);
    pus_event_action_step(&actions, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(PUS_EVENT_ACTION_RELEASES, released.count);
}

static void all_are_deleted_and_the_function_is_disabled(void)
{
    define(5U);
    released.accepts  = 0U;
    released.refusals = 1U;
    pus_event_action_observe(&actions, APID, 1U);
    command(3U);
    TEST_ASSERT_EQUAL_UINT16(0U, actions.count);
    TEST_ASSERT_FALSE(actions.is_enabled);
    TEST_ASSERT_EQUAL_UINT16(0U, chains.pool.stats.taken);
    pus_event_action_step(&actions, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
}

static void status_and_definitions_are_reported(void)
{
    // Two definitions: APID, event, enabled.
    static const uint8_t statuses[] = {0, 2, 0, APID, 0, 1, 1, 0, APID, 0, 2, 0};
    uint8_t packet[PUS_PACKET_MAX];
    const size_t size = request_make(2U, 0U, packet);
    define(2U);
    command_key(5U, 2U);
    writer = octet_writer(data, sizeof data);
    request(6U);
    EXPECT_MESSAGES(1, 1, 1, 3, 19, 7, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof statuses, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(statuses, bench_report(2U).data, sizeof statuses);
    begin(2U);
    write_key(9U);
    write_key(2U);
    request(10U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 19, 11, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, KEY(9U));
    octet_reader_t reader = bench_data(3U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(KEY(2U), octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, octet_read_octets(&reader, size), size);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    begin(0U);
    request(10U);
    reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    command_key(10U, 9U);
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void a_thousand_definitions_are_found_and_reported(void)
{
    for (uint16_t i = 0U; i < DEFINITIONS; i += 100U) {
        begin(100U);
        for (uint16_t k = 1U; k <= 100U; k++) {
            add((uint16_t)(i + k), (uint16_t)(i + k), 0U);
        }
        expect_done(1U);
    }
    begin(0U);
    expect_done(4U);
    command(8U);
    for (uint16_t i = DEFINITIONS; i >= 1U; i--) {
        pus_event_action_observe(&actions, APID, i);
        EXPECT_RELEASED(i);
    }
    begin(0U);
    request(10U);
    EXPECT_MESSAGES(1, 1, 1, 3, 19, 11, 19, 11, 19, 11, 19, 11);
    writer = octet_writer(data, sizeof data);
    bench_clear();
    request(6U); // While the report continues, a second one is refused.
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 11U);
    command_key(10U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 11U);
    bench_clear();
    TEST_ASSERT_TRUE(pus_event_action_is_waiting(&actions));
    bench.refusals = 1U;
    pus_event_action_step(&actions, TEST_NOW_NS);
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    pus_event_action_step(&actions, TEST_NOW_NS);
    EXPECT_MESSAGES(19, 11, 1, 7);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL_UINT16(1000U - (4U * 226U), octet_read_u16(&reader));
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_event_action_restore(self, key, octets, size);
}

static void restart(void)
{
    records_cut();
    config.persistence = records_port();
    bench_start();
    pus_dispatcher_persist(&bench.dispatcher, records_port());
    start(4U, 8U);
    (void)records_replay(PUS_SERVICE_EVENT_ACTION, restore, &actions);
}

static void acknowledged_changes_survive_a_power_cut(void)
{
    restart();
    define(3U);
    command_key(5U, 2U);
    begin(1U);
    add(2U, 22U, 30U);
    expect_done(1U);
    command_key(5U, 3U);
    command_key(2U, 3U);
    restart();
    TEST_ASSERT_EQUAL_UINT16(2U, actions.count);
    pus_event_action_observe(&actions, APID, 1U);
    pus_event_action_observe(&actions, APID, 2U);
    EXPECT_RELEASED(1);
    command_key(4U, 2U);
    restart();
    pus_event_action_observe(&actions, APID, 2U);
    EXPECT_RELEASED(22);
    command(9U);
    restart();
    pus_event_action_observe(&actions, APID, 2U);
    TEST_ASSERT_EQUAL_UINT64(0U, released.count);
    command(3U);
    restart();
    TEST_ASSERT_EQUAL_UINT16(0U, actions.count);
}

static void a_change_that_cannot_be_stored_is_not_acknowledged(void)
{
    restart();
    define(1U);
    records.put_status = STATUS_FULL;
    begin(1U);
    add(2U, 2U, 0U);
    request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    TEST_ASSERT_EQUAL_UINT16(1U, actions.count);
    command_key(5U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    begin(0U);
    request(5U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    writer = octet_writer(data, sizeof data);
    request(9U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    pus_event_action_observe(&actions, APID, 1U); // Function and definition are still enabled.
    EXPECT_RELEASED(1);
    records.put_status = STATUS_OK;
    command_key(5U, 1U);
    records.put_status = STATUS_IO;
    begin(1U);
    add(1U, 11U, 0U);
    request(1U);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT16(1U, chains.pool.stats.taken);
    records.put_status = STATUS_OK;
    command_key(4U, 1U);
    pus_event_action_observe(&actions, APID, 1U); // The request is still the old one.
    EXPECT_RELEASED(1);
    command_key(5U, 1U);
    records.erase_status = STATUS_IO;
    command_key(2U, 1U);
    expect_failure(1U, 4U, PUS_FAILURE_IO, 1U, STATUS_IO);
    writer = octet_writer(data, sizeof data);
    request(3U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    records.erase_status = STATUS_OK;
    records.put_status   = STATUS_IO;
    request(3U);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
    TEST_ASSERT_EQUAL_UINT16(0U, actions.count);
}

static void a_missing_record_counts_as_erased(void)
{
    restart();
    define(1U);
    begin(0U);
    expect_done(4U); // The definition is already enabled, so no record is written.
    command_key(5U, 1U);
    records_start();
    command_key(2U, 1U);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(0U, actions.count);
}

static void an_impossible_record_is_refused(void)
{
    uint8_t octets[200];
    octet_writer_t record = octet_writer(octets, sizeof octets);
    start(3U, 2U);
    octet_write_u32(&record, KEY(1U));
    octet_write_u8(&record, 1U);
    request_write(&record, 1U, 0U);
    const uint32_t key = 0x01000000U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_event_action_restore(&actions, 0U, octets, 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_event_action_restore(&actions, 1U, octets, 1U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED,
                      pus_event_action_restore(&actions, key | 3U, octets, record.position));
    for (size_t cut = 0U; cut < record.position; cut++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_event_action_restore(&actions, key, octets, cut));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_action_restore(&actions, key | 1U, octets, record.position));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, pus_event_action_restore(&actions, key, octets, record.position));
    octets[3] = 2U;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, pus_event_action_restore(&actions, key | 1U, octets, record.position));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_action_restore(&actions, key | 2U, octets, record.position));
    octets[3] = 3U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, pus_event_action_restore(&actions, key, octets, record.position));
    octets[0] = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_event_action_restore(&actions, 0U, octets, 1U));
    TEST_ASSERT_TRUE(actions.is_enabled);
}

static void definitions_with_the_same_hash_bucket_are_distinguished(void)
{
    config.bucket_count = 1U;
    memset(&actions, 0xA5, sizeof actions);
    pus_event_action_init(&actions, &config);
    define(5U);
    begin(1U);
    octet_write_u16(&writer, APID + 1U);
    octet_write_u16(&writer, 3U);
    request_write(&writer, 33U, 0U);
    expect_done(1U);
    command_key(5U, 2U);
    command_key(2U, 2U);
    for (uint16_t i = 1U; i <= 5U; i++) {
        pus_event_action_observe(&actions, APID, i);
    }
    EXPECT_RELEASED(1, 3, 4, 5);
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t key[] = {1, 0, APID, 0, 1};
    uint8_t octets[64];
    begin(2U);
    add(1U, 1U, 0U);
    add(2U, 2U, 3U);
    memcpy(octets, data, writer.position);
    expect_strict_format(1U, octets, writer.position);
    expect_strict_format(2U, key, sizeof key);
    expect_strict_format(4U, key, sizeof key);
    expect_strict_format(5U, key, sizeof key);
    expect_strict_format(10U, key, sizeof key);
    expect_strict_format(3U, key, 0U);
    expect_strict_format(6U, key, 0U);
    expect_strict_format(8U, key, 0U);
    expect_strict_format(9U, key, 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_event_releases_its_request);
    RUN_TEST(function_and_definition_must_be_enabled);
    RUN_TEST(a_definition_is_replaced_and_deleted_only_while_disabled);
    RUN_TEST(each_faulty_definition_is_refused_alone);
    RUN_TEST(definitions_beyond_the_table_or_the_blocks_are_refused);
    RUN_TEST(requests_that_the_port_refuses_wait_in_order);
    RUN_TEST(queued_requests_are_dropped_when_their_definition_is_disabled);
    RUN_TEST(requests_beyond_the_queue_are_dropped);
    RUN_TEST(all_are_deleted_and_the_function_is_disabled);
    RUN_TEST(status_and_definitions_are_reported);
    RUN_TEST(a_thousand_definitions_are_found_and_reported);
    RUN_TEST(acknowledged_changes_survive_a_power_cut);
    RUN_TEST(a_change_that_cannot_be_stored_is_not_acknowledged);
    RUN_TEST(a_missing_record_counts_as_erased);
    RUN_TEST(an_impossible_record_is_refused);
    RUN_TEST(definitions_with_the_same_hash_bucket_are_distinguished);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
