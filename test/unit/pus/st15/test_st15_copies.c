// SPDX-License-Identifier: Apache-2.0
// Copies of packets from one store to another. The numbers of requests and reports are subtypes;
// pus/catalogue/st15_storage.txt has their names and fields.
#include "test/unit/pus/fixtures/stores.h"
#include "unity.h"

void setUp(void)
{
    stores_begin();
    stores_add("ring", 3U, PUS_STORE_CIRCULAR);
    stores_add("box", 4U, PUS_STORE_BOUNDED);
}

void tearDown(void)
{
}

/// Disable the storage function of the other store.
static void disable_the_other_store(void)
{
    stores_request_store(2U, "box");
}

static void copy(const uint8_t type, const unsigned from, const unsigned to)
{
    stores_begin_request();
    octet_write_u8(&stores_request, type);
    if ((type == 1U) || (type == 2U)) {
        stores_put_second(from);
    }
    if ((type == 1U) || (type == 3U)) {
        stores_put_second(to);
    }
    stores_put_name("ring");
    stores_put_name("box");
    TEST_ASSERT_EQUAL(STATUS_OK, stores_send_request(24U));
}

static void delete_content_of_box(void)
{
    stores_begin_request();
    stores_put_second(1000U);
    octet_write_u8(&stores_request, 1U);
    stores_put_name("box");
    expect_stores_performed(11U);
}

static void packets_are_copied_by_time_window(void)
{
    static const struct {
        uint8_t type;
        uint16_t first;
        uint16_t last;
    } windows[] = {{0U, 1U, 8U}, {1U, 3U, 6U}, {2U, 3U, 8U}, {3U, 1U, 6U}};
    disable_the_other_store();
    stores_reports(1U, 8U);
    for (size_t i = 0U; i < 4U; i++) {
        copy(windows[i].type, 3U, 6U);
        EXPECT_MESSAGES(1, 1, 1, 3);
        TEST_ASSERT_FALSE(stores_is_idle());
        bench_clear();
        stores_step(1U, 8U);
        EXPECT_MESSAGES(0); // Three packets are copied, and no more.
        TEST_ASSERT_EQUAL_UINT32(3U, stores_storage.copy.copied);
        if (i == 3U) {
            stores_report(20U, 30U, 1U); // The packet is later than the request.
        }
        stores_step(5U, 8U);
        EXPECT_MESSAGES(1, 7);
        stores_start_range("box", 0U, 0U, 1000U);
        stores_step(5U, 8U);
        expect_stores_sent(windows[i].first, windows[i].last); // The packets have their original times.
        delete_content_of_box();
    }
}

static void a_copy_that_does_not_fit_fails(void)
{
    disable_the_other_store();
    stores_reports(1U, 12U);
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("box");
    octet_write_u32(&stores_request, 2U * PUS_STORE_BLOCK);
    expect_stores_performed(25U);
    copy(0U, 0U, 0U);
    bench_clear();
    stores_step(5U, 12U);
    EXPECT_MESSAGES(1, 8);
    expect_failure(0U, 8U, PUS_FAILURE_TABLE_FULL, 0U, 8U);
    TEST_ASSERT_FALSE(stores_storage.copy.is_active);
}

static void a_copy_from_a_failing_medium_fails(void)
{
    disable_the_other_store();
    stores_reports(1U, 2U);
    copy(0U, 0U, 0U);
    bench_clear();
    stores_step(1U, 2U); // The step also syncs.
    delete_content_of_box();
    for (unsigned call = 1U; call <= 7U; call++) {
        copy(0U, 0U, 0U);
        bench_clear();
        recorded.calls = 0U;
        // The calls in their order: read; close a block, sync, write a head, sync, write the record; read the
        // second packet; after them come its record and a sync.
        recorded.fail_from = call;
        stores_step(1U, 2U);
        recorded.fail_from = 0U;
        stores_step(1U, 2U);
        TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
        if (bench_report(0U).subtype == 8U) {
            expect_failure(0U, 8U, PUS_FAILURE_IO, 0U, STATUS_IO);
        }
        TEST_ASSERT_FALSE(stores_storage.copy.is_active);
        delete_content_of_box();
    }
}

static void a_copy_skips_damaged_records(void)
{
    disable_the_other_store();
    stores_config.octets_per_step = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 5U);
    recorded.image[0].octets[56U + 99U] ^= 1U;
    copy(0U, 0U, 0U);
    bench_clear();
    stores_step(2U, 5U);
    EXPECT_MESSAGES(0); // One block or one packet is copied in each step.
    stores_step(1U, 5U);
    EXPECT_MESSAGES(1, 7);
    stores_start_range("box", 0U, 0U, 1000U);
    stores_step(3U, 5U);
    expect_stores_sent(5U, 5U);
    stores_storage.copy = (pus_store_copy_t){.is_active = true, .source = 1U, .target = 1U};
    stores_request_store(2U, "ring");
    stores_request_store(21U, "ring"); // The store takes part in no copy.
}

static void copies_are_refused(void)
{
    disable_the_other_store();
    stores_reports(1U, 5U);
    copy(1U, 5U, 4U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 0U, 17U);
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("ring");
    stores_put_name("none");
    expect_stores_refused(24U, PUS_FAILURE_UNKNOWN_ID, 0U, stores_name_of("none"));
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("no");
    stores_put_name("box");
    expect_stores_refused(24U, PUS_FAILURE_UNKNOWN_ID, 0U, stores_name_of("no"));
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("box");
    stores_put_name("box");
    expect_stores_refused(24U, PUS_FAILURE_STATE, 0U, stores_name_of("box"));
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    stores_put_name("box");
    stores_put_name("ring");
    expect_stores_refused(24U, PUS_FAILURE_STATE, 0U, stores_name_of("ring")); // The target is not empty.
    stores_begin_request();
    octet_write_u8(&stores_request, 4U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, stores_send_request(24U)); // This type of window does not exist.
    stores_begin_request();
    octet_write_u8(&stores_request, 2U);
    octet_write_u64(&stores_request, 0U); // The time has another format.
    stores_put_name("ring");
    stores_put_name("box");
    expect_stores_refused(24U, PUS_FAILURE_OUT_OF_RANGE, 0U, 9U);
    copy(0U, 0U, 0U);
    copy(0U, 0U, 0U); // Only one copy may be in progress.
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, stores_name_of("box"));
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("box");
    expect_stores_refused(21U, PUS_FAILURE_STATE, 1U, stores_name_of("box"));
    stores_request_store(2U, "ring");
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name("ring");
    expect_stores_refused(21U, PUS_FAILURE_STATE, 1U, stores_name_of("ring"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(packets_are_copied_by_time_window);
    RUN_TEST(a_copy_that_does_not_fit_fails);
    RUN_TEST(a_copy_from_a_failing_medium_fails);
    RUN_TEST(a_copy_skips_damaged_records);
    RUN_TEST(copies_are_refused);
    return UNITY_END();
}
