// SPDX-License-Identifier: Apache-2.0
// Stores, the selection of their packets, and requests about them. The numbers of requests and reports are
// subtypes; pus/catalogue/st15_storage.txt has their names and fields.
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/stores.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    stores_begin();
}

void tearDown(void)
{
}

static octet_reader_t ask(const uint8_t subtype, const uint8_t expected)
{
    stores_begin_request();
    return stores_answer(subtype, expected);
}

static void a_new_store_is_disabled_and_stores_no_packets(void)
{
    octet_reader_t reader = ask(18U, 19U);
    TEST_ASSERT_EQUAL_UINT16(0U, octet_read_u16(&reader));
    stores_create_ring();
    reader = ask(22U, 23U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    expect_stores_name(&reader, "ring");
    TEST_ASSERT_EQUAL_UINT32(SIZE(3U), octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_UINT8(PUS_STORE_CIRCULAR, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(2U, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    reader = ask(18U, 19U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    expect_stores_name(&reader, "ring");
    TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(0U, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    stores_select_all(3U, "ring");
    stores_reports(1U, 1U); // The store is not enabled.
    expect_stores_summary("ring", 0U, 0U, 0U, 0U, 0U);
    stores_request_store(1U, "ring");
    stores_reports(2U, 3U);
    expect_stores_summary("ring", 2U, 3U, 0U, 17U, 17U); // 2 x 4014 of 49152 octets.
    stores_request_store(2U, "ring");
    stores_reports(4U, 4U);
    expect_stores_summary("ring", 2U, 3U, 0U, 17U, 17U);
    TEST_ASSERT_EQUAL_UINT32(0U, stores_storage.counters.lost);
}

static void bad_creation_requests_are_refused(void)
{
    stores_create_ring();
    stores_create("ring", SIZE(3U), 0U, 0U);
    expect_stores_refused(20U, PUS_FAILURE_EXISTS, 1U, stores_name_of("ring"));
    static const struct {
        const char* name;
        uint32_t size;
        uint8_t type;
        uint8_t channel;
    } wrong[] = {{"", SIZE(2U), 0U, 0U},     {"a b", SIZE(2U), 0U, 0U},
                 {"\x7F", SIZE(2U), 0U, 0U}, {"x", SIZE(2U) - 1U, 0U, 0U},
                 {"x", 0U, 0U, 0U},          {"x", SIZE(STORE_BLOCKS + 1U), 0U, 0U},
                 {"x", SIZE(2U), 2U, 0U},    {"x", SIZE(2U), 0U, STORE_CHANNELS},
                 {"x", UINT32_MAX, 0U, 0U}};
    for (size_t i = 0U; i < (sizeof wrong / sizeof wrong[0]); i++) {
        stores_create(wrong[i].name, wrong[i].size, wrong[i].type, wrong[i].channel);
        expect_stores_refused(20U, PUS_FAILURE_OUT_OF_RANGE, 1U, 15U);
    }
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    octet_write_octets(&stores_request, (const uint8_t*)"ab\0\0c\0\0\0",
                       PUS_NAME_SIZE); // The name is not padded with NUL.
    octet_write_u32(&stores_request, SIZE(2U));
    octet_write_u16(&stores_request, 0U);
    expect_stores_refused(20U, PUS_FAILURE_OUT_OF_RANGE, 1U, 15U);
    stores_create("eight888", SIZE(STORE_BLOCKS) + 1U, PUS_STORE_BOUNDED, STORE_CHANNELS - 1U);
    expect_stores_performed(20U);
    stores_create("third", SIZE(2U), 0U, 0U);
    expect_stores_refused(20U, PUS_FAILURE_TABLE_FULL, 1U, STORES);
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, stores_send_request(20U));
}

static void names_are_printable_characters_without_blanks(void)
{
    for (unsigned letter = 1U; letter < 256U; letter++) {
        for (unsigned end = 0U; end < 2U; end++) { // The letter is the first or the last character.
            char name[PUS_NAME_SIZE + 1U]    = "abcdefgh";
            name[end * (PUS_NAME_SIZE - 1U)] = (char)letter;
            stores_create(name, SIZE(2U), 0U, 0U);
            if ((letter > (unsigned)' ') && (letter <= (unsigned)'~')) {
                expect_stores_performed(20U);
                stores_request_store(21U, name);
            } else {
                expect_stores_refused(20U, PUS_FAILURE_OUT_OF_RANGE, 1U, 15U);
            }
        }
    }
}

static void unknown_stores_are_refused_alone(void)
{
    static const uint8_t lists[]   = {1U, 2U, 16U, 17U, 21U};
    static const uint8_t singles[] = {5U, 26U, 27U, 35U, 37U, 39U};
    stores_create_ring();
    for (size_t i = 0U; i < (sizeof lists / sizeof lists[0]); i++) {
        stores_begin_request();
        octet_write_u8(&stores_request, 2U);
        stores_put_name("none");
        stores_put_name("ring");
        TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(lists[i]));
        EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
        expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, stores_name_of("none"));
        expect_failure(3U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 1U);
    }
    for (size_t i = 0U; i < (sizeof singles / sizeof singles[0]); i++) {
        stores_begin_request();
        stores_put_name("none");
        expect_stores_refused(singles[i], PUS_FAILURE_UNKNOWN_ID, 0U, stores_name_of("none"));
    }
    stores_begin_request();
    stores_put_name("none");
    octet_write_u8(&stores_request, 0U);
    expect_stores_refused(28U, PUS_FAILURE_UNKNOWN_ID, 0U, stores_name_of("none"));
    expect_stores_refused(4U, PUS_FAILURE_UNKNOWN_ID, 0U, stores_name_of("none"));
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("none");
    octet_write_u8(&stores_request, 0U);
    stores_put_second(1U);
    stores_put_second(2U);
    expect_stores_refused(9U, PUS_FAILURE_UNKNOWN_ID, 1U, stores_name_of("none"));
}

static void summaries_of_some_or_of_all_stores_are_reported(void)
{
    stores_create_ring();
    stores_create("box", SIZE(2U), PUS_STORE_BOUNDED, 0U);
    expect_stores_performed(20U);
    octet_reader_t reader;
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    reader = stores_answer(12U, 13U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    stores_begin_request();
    octet_write_u8(&stores_request, 3U);
    stores_put_name("box");
    stores_put_name("none");
    stores_put_name("box");
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(12U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 4, 1, 4, 15, 13, 1, 8);
    expect_failure(2U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, stores_name_of("none"));
    expect_failure(3U, 4U, PUS_FAILURE_DUPLICATE, 3U, stores_name_of("box"));
    reader = bench_data(4U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    expect_stores_name(&reader, "box");
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("none");
    expect_stores_refused(12U, PUS_FAILURE_UNKNOWN_ID, 1U, stores_name_of("none"));
}

static void a_full_store_reports_that_it_is_full(void)
{
    stores_add("box", 2U, PUS_STORE_BOUNDED);
    stores_reports(1U, 8U);
    expect_stores_summary("box", 1U, 8U, 0U, 99U, 99U);
    stores_reports(9U, 9U);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.stores[0].log.counters.refused);
    stores_begin_request();
    stores_put_second(6U);
    octet_write_u8(&stores_request, 1U);
    stores_put_name("box");
    expect_stores_performed(14U);
    expect_stores_summary("box", 1U, 8U, 6U, 99U, 37U);
    stores_begin_request();
    stores_put_second(3U);
    octet_write_u8(&stores_request, 1U);
    stores_put_name("box");
    expect_stores_performed(11U);
    expect_stores_summary("box", 4U, 8U, 6U, 63U, 37U);
    stores_begin_request();
    stores_put_second(7U);
    octet_write_u8(&stores_request, 0U);
    expect_stores_performed(11U);
    expect_stores_summary("box", 8U, 8U, 6U, 13U, 13U); // The tagged packet was overwritten.
    stores_step(1U, 9U);
    stores_cut();
    expect_stores_summary("box", 8U, 8U, 6U, 13U, 13U);
}

static void an_enabled_store_keeps_its_size_and_type_and_is_not_deleted(void)
{
    static const uint8_t singles[] = {26U, 27U};
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    const uint32_t ring = stores_name_of("ring");
    for (size_t i = 0U; i < 2U; i++) { // Storage is enabled.
        stores_begin_request();
        stores_put_name("ring");
        expect_stores_refused(singles[i], PUS_FAILURE_STATE, 0U, ring);
    }
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_refused(21U, PUS_FAILURE_STATE, 1U, ring);
    octet_write_u32(&stores_request, SIZE(4U));
    expect_stores_refused(25U, PUS_FAILURE_STATE, 1U, ring);
    stores_begin_request();
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    expect_stores_performed(28U); // The virtual channel may change.
}

static void changes_wait_for_the_end_of_a_retrieval(void)
{
    static const uint8_t singles[] = {26U, 27U};
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    const uint32_t ring = stores_name_of("ring");
    stores_request_store(2U, "ring");
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 3U);
    expect_stores_performed(15U);
    for (size_t i = 0U; i < 2U; i++) { // A retrieval is in progress.
        stores_begin_request();
        stores_put_name("ring");
        expect_stores_refused(singles[i], PUS_FAILURE_STATE, 0U, ring);
    }
    stores_begin_request();
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    expect_stores_refused(28U, PUS_FAILURE_STATE, 0U, ring);
    stores_begin_request();
    stores_put_second(5U);
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_refused(11U, PUS_FAILURE_STATE, 1U, ring);
    expect_stores_refused(14U, PUS_FAILURE_STATE, 1U, ring);
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_refused(21U, PUS_FAILURE_STATE, 1U, ring);
    octet_write_u8(&stores_request, 0U);
    stores_put_second(1U);
    stores_put_second(2U);
    expect_stores_refused(9U, PUS_FAILURE_STATE, 1U, ring); // A retrieval of the other type is in progress.
    stores_begin_request();
    stores_put_second(5U);
    octet_write_u8(&stores_request, 0U); // The request applies to no store.
    expect_stores_performed(11U);
    stores_request_store(16U, "ring");
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    stores_put_second(1U);
    stores_put_second(2U);
    expect_stores_performed(9U);
    expect_stores_refused(9U, PUS_FAILURE_STATE, 1U, ring); // A retrieval of the same type is in progress.
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    expect_stores_refused(15U, PUS_FAILURE_STATE, 1U, ring);
}

static void wrong_times_are_refused(void)
{
    stores_create_ring();
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    stores_put_second(5U);
    stores_put_second(4U);
    expect_stores_refused(9U, PUS_FAILURE_OUT_OF_RANGE, 1U, 26U);
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    octet_write_u64(&stores_request, 0U); // The time has another format.
    stores_put_second(4U);
    expect_stores_refused(9U, PUS_FAILURE_OUT_OF_RANGE, 1U, 26U);
    stores_begin_request();
    octet_write_u64(&stores_request, 0U);
    octet_write_u8(&stores_request, 0U);
    expect_stores_refused(11U, PUS_FAILURE_OUT_OF_RANGE, 0U, 8U);
    expect_stores_refused(14U, PUS_FAILURE_OUT_OF_RANGE, 0U, 8U);
}

static void resize(const uint32_t size)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u32(&stores_request, size);
}

static void the_size_and_the_type_of_a_store_are_changed(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_reports(1U, 11U);
    stores_request_store(2U, "ring");
    resize(SIZE(3U) - 1U);
    expect_stores_refused(25U, PUS_FAILURE_OUT_OF_RANGE, 1U, 13U); // The stored packets would not fit.
    resize(SIZE(STORE_BLOCKS + 1U));
    expect_stores_refused(25U, PUS_FAILURE_OUT_OF_RANGE, 1U, 13U);
    resize(SIZE(4U));
    expect_stores_performed(25U);
    expect_stores_summary("ring", 1U, 11U, 0U, 69U, 69U);
    stores_begin_request();
    stores_put_name("ring");
    expect_stores_performed(27U);
    stores_request_all(1U);
    stores_reports(12U, 17U);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.counters.lost);
    stores_request_all(2U);
    stores_begin_request();
    stores_put_name("ring");
    expect_stores_performed(26U);
    stores_request_all(1U);
    stores_reports(18U, 18U);
    expect_stores_summary("ring", 5U, 18U, 0U, 82U, 82U);
    stores_step(1U, 18U);
    stores_cut();
    expect_stores_summary("ring", 5U, 18U, 0U, 82U, 82U);
    TEST_ASSERT_EQUAL_UINT32(SIZE(4U), stores_storage.stores[0].state.size);
    stores_begin_request();
    stores_put_name("ring");
    octet_write_u8(&stores_request, STORE_CHANNELS);
    expect_stores_refused(28U, PUS_FAILURE_OUT_OF_RANGE, 0U, 9U);
}

static void deletion_of_a_store_removes_all_of_its_records(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_reports(1U, 11U);
    stores_step(1U, 11U);
    stores_request_all(21U); // No store is deleted, because storage is enabled.
    TEST_ASSERT_TRUE(stores_storage.stores[0].state.is_there);
    stores_request_store(2U, "ring");
    stores_request_store(21U, "ring");
    TEST_ASSERT_TRUE(recorded.image[0].size > 0U);
    TEST_ASSERT_FALSE(stores_is_idle());
    recorded.calls     = 0U;
    recorded.fail_from = 1U;
    stores_step(2U, 11U); // The first attempt fails.
    TEST_ASSERT_EQUAL_UINT64(0U, recorded.image[0].size);
    TEST_ASSERT_TRUE(stores_is_idle());
    stores_cut();
    // The deleted store is not created again, although the configuration contains it.
    TEST_ASSERT_FALSE(stores_storage.stores[0].state.is_there);
    stores_create_ring();
    stores_request_store(1U, "ring");
    stores_reports(12U, 12U);
    expect_stores_summary("ring", 0U, 0U, 0U, 0U, 0U); // The selection of the store is also removed.
}

static void a_new_store_of_the_same_name_has_no_old_packets(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_reports(1U, 11U);
    stores_step(1U, 11U);
    stores_request_store(2U, "ring");
    stores_request_store(21U, "ring");
    stores_create_ring(); // The store is created again before a step could shorten the medium.
    stores_step(1U, 11U);
    TEST_ASSERT_TRUE(recorded.image[0].size > 0U);
    expect_stores_summary("ring", 0U, 0U, 0U, 0U, 0U);
    stores_cut();
    expect_stores_summary("ring", 0U, 0U, 0U, 0U, 0U);
    TEST_ASSERT_EQUAL_UINT16(0U, stores_storage.stores[0].selection.count);
}

static void selections_are_changed_by_requests(void)
{
    static const uint8_t adds[]    = {3U, 29U, 31U, 34U};
    static const uint8_t deletes[] = {4U, 30U, 32U, 33U};
    static const uint8_t asks[]    = {5U, 35U, 37U, 39U};
    stores_create_ring();
    for (size_t i = 0U; i < 4U; i++) {
        stores_select_all(adds[i], "ring");
        TEST_ASSERT_EQUAL_UINT16(1U, stores_storage.stores[0].selection.count);
        stores_begin_request();
        stores_put_name("ring");
        octet_reader_t reader = stores_answer(asks[i], (uint8_t)(asks[i] + 1U));
        expect_stores_name(&reader, "ring");
        TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(TEST_APID, octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT16(0U, octet_read_u16(&reader));
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
        stores_select_all(deletes[i], "ring");
        TEST_ASSERT_EQUAL_UINT16(0U, stores_storage.stores[0].selection.count);
    }
    stores_select_all(3U, "ring");
    stores_cut();
    TEST_ASSERT_EQUAL_UINT16(1U, stores_storage.stores[0].selection.count);
}

static void every_request_has_a_strict_format(void)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    octet_write_u8(&stores_request, 0U);
    stores_put_second(1U);
    stores_put_second(2U);
    expect_strict_format(9U, stores_request.octets, stores_request.position);
    stores_begin_request();
    octet_write_u8(&stores_request, 3U);
    stores_put_second(1U);
    stores_put_name("ring");
    stores_put_name("box");
    expect_strict_format(24U, stores_request.octets, stores_request.position);
    expect_strict_format(18U, NULL, 0U);
}

/// A damaged block makes the blocks before it invalid; this is reported at the start.
static void damaged_or_unreadable_stores_are_reported(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_add("box", 4U, PUS_STORE_BOUNDED);
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 9U);
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    recorded.image[1].octets[PUS_STORE_BLOCK + 4U] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_CHECKSUM, stores_restart());
    TEST_ASSERT_EQUAL_UINT32(0U, stores_storage.stores[0].log.counters.damaged);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.stores[1].log.counters.damaged);
    recorded.calls     = 0U;
    recorded.fail_from = 1U; // Also if the first store fails.
    TEST_ASSERT_EQUAL(STATUS_IO, stores_restart());
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.stores[1].log.counters.damaged);
}

static void start_without_stores(void)
{
    stores_config.store_count = 0U;
    (void)stores_restart();
}

static void calls_against_the_contract_are_asserted(void)
{
    TEST_ASSERT_TRUE(assertion_fails(start_without_stores));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_new_store_is_disabled_and_stores_no_packets);
    RUN_TEST(bad_creation_requests_are_refused);
    RUN_TEST(names_are_printable_characters_without_blanks);
    RUN_TEST(unknown_stores_are_refused_alone);
    RUN_TEST(summaries_of_some_or_of_all_stores_are_reported);
    RUN_TEST(a_full_store_reports_that_it_is_full);
    RUN_TEST(an_enabled_store_keeps_its_size_and_type_and_is_not_deleted);
    RUN_TEST(changes_wait_for_the_end_of_a_retrieval);
    RUN_TEST(wrong_times_are_refused);
    RUN_TEST(the_size_and_the_type_of_a_store_are_changed);
    RUN_TEST(deletion_of_a_store_removes_all_of_its_records);
    RUN_TEST(a_new_store_of_the_same_name_has_no_old_packets);
    RUN_TEST(selections_are_changed_by_requests);
    RUN_TEST(every_request_has_a_strict_format);
    RUN_TEST(damaged_or_unreadable_stores_are_reported);
    RUN_TEST(calls_against_the_contract_are_asserted);
    return UNITY_END();
}
