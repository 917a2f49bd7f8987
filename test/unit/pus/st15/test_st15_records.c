// SPDX-License-Identifier: Apache-2.0
// Changes that cannot be stored, and the start of the stores from records and media. The numbers of requests
// and reports are subtypes; pus/catalogue/st15_storage.txt has their names and fields.
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

static void a_change_that_cannot_be_stored_is_not_made(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    records.put_status = STATUS_FULL;
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_refused(2U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    TEST_ASSERT_TRUE(stores_storage.stores[0].state.is_enabled);
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(2U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_IO, 0U, STATUS_FULL);
    TEST_ASSERT_TRUE(stores_storage.stores[0].state.is_enabled);
    stores_create("box", SIZE(2U), 0U, 0U);
    // The record of the selection cannot be stored.
    expect_stores_refused(20U, PUS_FAILURE_IO, 1U, STATUS_FULL);
    records.refuse_after = 1U;
    stores_create("box", SIZE(2U), 0U, 0U);
    expect_stores_refused(20U, PUS_FAILURE_IO, 1U, STATUS_FULL); // The record of the state cannot be stored.
    TEST_ASSERT_FALSE(stores_storage.stores[1].state.is_there);
}

static void media_that_fail_at_the_start_are_reported(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_reports(1U, 3U);
    stores_step(1U, 3U);
    recorded.calls     = 0U;
    recorded.fail_from = 1U;
    TEST_ASSERT_EQUAL(STATUS_IO, stores_restart());
    stores_reports(4U, 4U);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.counters.lost);
    expect_stores_summary("ring", 0U, 0U, 0U, 0U, 0U);
    stores_begin_request(); // The deletion of its content is performed, without an effect.
    stores_put_second(9U);
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_performed(11U);
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("ring");
    stores_put_name("ring");
    expect_stores_refused(24U, PUS_FAILURE_STATE, 0U, stores_name_of("ring"));
    recorded.fail_from = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    expect_stores_summary("ring", 1U, 3U, 0U, 25U, 25U);
}

static void a_failed_store_cannot_be_the_target_of_a_copy(void)
{
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_add("box", 3U, PUS_STORE_CIRCULAR);
    recorded.calls     = 0U;
    recorded.fail_from = 2U; // Reading the size of the second medium fails.
    TEST_ASSERT_EQUAL(STATUS_IO, stores_restart());
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("ring");
    stores_put_name("box");
    expect_stores_refused(24U, PUS_FAILURE_STATE, 0U, stores_name_of("box"));
    stores_request_all(2U);
    stores_request_store(21U, "box");
    stores_create("box", SIZE(2U), 0U, 0U);
    expect_stores_performed(20U); // A new store can be used.
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("ring");
    stores_put_name("box");
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(24U));
    EXPECT_MESSAGES(1, 1, 1, 3);
}

static void bad_records_are_refused(void)
{
    uint8_t record[PUS_RECORD_MAX];
    size_t size = 0U;
    stores_create_ring();
    const uint8_t* const kept = records_find(PUS_SERVICE_STORAGE, 0U, &size);
    memcpy(record, kept, size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_storage_restore(&stores_storage, 0U, record, size));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_storage_restore(&stores_storage, 0U, record, size - 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_storage_restore(&stores_storage, 0U, record, size + 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_storage_restore(&stores_storage, STORES, record, size));
    // Keys are in use up to the selection of the last store.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      pus_storage_restore(&stores_storage, 2U * PUS_STORE_SELECTION_KEY, record, size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      pus_storage_restore(&stores_storage, PUS_STORE_SELECTION_KEY + STORES, record, size));
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      pus_storage_restore(&stores_storage, PUS_STORE_SELECTION_KEY, record, size));
    record[13] = 2U; // Type.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_storage_restore(&stores_storage, 0U, record, size));
    record[13] = 0U;
    record[16] = 3U; // Retrieval.
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_storage_restore(&stores_storage, 0U, record, size));
    record[0] = 0U; // The store does not exist, so all other fields are ignored.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_storage_restore(&stores_storage, 0U, record, size));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_change_that_cannot_be_stored_is_not_made);
    RUN_TEST(media_that_fail_at_the_start_are_reported);
    RUN_TEST(a_failed_store_cannot_be_the_target_of_a_copy);
    RUN_TEST(bad_records_are_refused);
    return UNITY_END();
}
