// SPDX-License-Identifier: Apache-2.0
// Retrieval, and its state after a power cut. The numbers of requests and reports are subtypes;
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

static void resume(const char* const name, const uint8_t priority)
{
    stores_begin_request();
    octet_write_u8(&stores_request, 1U);
    stores_put_name(name);
    octet_write_u8(&stores_request, priority);
    expect_stores_performed(15U);
}

static void change_tag(const char* const name, const unsigned second)
{
    stores_begin_request();
    stores_put_second(second);
    octet_write_u8(&stores_request, 1U);
    stores_put_name(name);
    expect_stores_performed(14U);
}

/// Expect the statuses of the first store: storage, open retrieval, retrieval by time range.
static void expect_status(const uint8_t enabled, const uint8_t open, const uint8_t range)
{
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(18U, NULL, 0U));
    octet_reader_t reader = bench_data(2U);
    (void)octet_read_octets(&reader, 2U + PUS_NAME_SIZE);
    TEST_ASSERT_EQUAL_UINT8(enabled, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(open, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT8(range, octet_read_u8(&reader));
}

static void an_open_retrieval_follows_incoming_packets(void)
{
    disable_the_other_store();
    stores_reports(1U, 4U);
    stores_step(2U, 5U);
    expect_stores_none_sent();
    resume("ring", 0U);
    expect_status(1U, 1U, 0U);
    stores_step(1U, 5U);
    expect_stores_sent(1U, 3U);
    stores_step(3U, 5U);
    expect_stores_sent(4U, 4U);
    TEST_ASSERT_TRUE(stores_is_idle());
    stores_reports(5U, 6U);
    TEST_ASSERT_FALSE(stores_is_idle());
    stores_step(1U, 6U);
    expect_stores_sent(5U, 6U);
    stores_request_store(16U, "ring");
    stores_reports(7U, 8U);
    stores_step(3U, 8U);
    expect_stores_none_sent();
    expect_status(1U, 0U, 0U);
    stores_request_store(16U, "ring"); // The retrieval is already suspended.
    resume("ring", 0U);
    resume("ring", 0U); // The retrieval is already in progress.
    stores_step(3U, 8U);
    expect_stores_sent(7U, 8U); // The retrieval continues exactly at its position.
    TEST_ASSERT_EQUAL_UINT32(8U, stores_storage.stores[0].sent);
    TEST_ASSERT_EQUAL_UINT8(1U, stores_sent.packets[0].channel);
}

static void an_open_retrieval_begins_at_its_tag(void)
{
    disable_the_other_store();
    stores_reports(1U, 9U);
    change_tag("ring", 6U);
    resume("ring", 0U);
    stores_step(4U, 9U);
    expect_stores_sent(6U, 9U);
    stores_request_store(16U, "ring");
    change_tag("ring", 3U); // The tag moves back.
    resume("ring", 0U);
    stores_step(4U, 9U);
    expect_stores_sent(3U, 9U);
    stores_request_store(16U, "ring");
    change_tag("ring", 14U); // Later than all packets.
    resume("ring", 0U);
    stores_reports(10U, 13U);
    stores_step(4U, 13U);
    expect_stores_none_sent();
    TEST_ASSERT_FALSE(stores_storage.stores[0].state.open_cursor >
                      pus_packet_store_head(&stores_storage.stores[0].log));
    stores_reports(14U, 15U);
    stores_step(2U, 15U);
    expect_stores_sent(14U, 15U);
    // The clock was set back: packets are stored and retrieved in the order of arrival.
    stores_report(16U, REPORT_SIZE, 2U);
    stores_step(1U, 2U);
    expect_stores_sent(16U, 16U);
}

static void a_retrieval_skips_blocks_that_were_overwritten(void)
{
    disable_the_other_store();
    stores_reports(1U, 4U);
    resume("ring", 0U);
    stores_step(1U, 4U);
    expect_stores_sent(1U, 3U);
    stores_reports(5U, 17U); // The store has three blocks: 4 .. 8 are overwritten.
    stores_step(9U, 17U);
    expect_stores_sent(9U, 17U);
}

static void a_range_is_sent_once_and_ends(void)
{
    disable_the_other_store();
    stores_reports(1U, 12U);
    stores_start_range("ring", 0U, 3U, 8U);
    expect_status(1U, 0U, 1U);
    TEST_ASSERT_FALSE(stores_is_idle());
    stores_step(1U, 12U);
    expect_stores_sent(3U, 5U);
    stores_report(13U, REPORT_SIZE, 7U); // Within the range, but later than the request.
    stores_step(2U, 12U);
    expect_stores_sent(6U, 8U);
    expect_status(1U, 0U, 0U);
    TEST_ASSERT_TRUE(records.commits > 0U);
    stores_start_range("ring", 0U, 90U, 99U); // No packet of that time.
    stores_step(1U, 12U);
    expect_stores_none_sent();
    expect_status(1U, 0U, 0U);
    stores_start_range("ring", 0U, 7U, 7U);
    stores_step(9U, 12U);
    TEST_ASSERT_EQUAL_UINT16(7U, stores_sent.packets[stores_sent.count - 2U].sequence);
    TEST_ASSERT_EQUAL_UINT16(13U, stores_sent.packets[stores_sent.count - 1U].sequence);
}

static void a_range_can_be_aborted(void)
{
    disable_the_other_store();
    stores_reports(1U, 8U);
    stores_start_range("ring", 0U, 0U, 100U);
    stores_step(1U, 8U);
    expect_stores_sent(1U, 3U);
    stores_request_store(16U, "ring"); // Suspends open retrievals only.
    stores_step(1U, 8U);
    expect_stores_sent(4U, 6U);
    stores_request_store(17U, "ring");
    stores_request_all(17U);
    stores_step(2U, 8U);
    expect_stores_none_sent();
    resume("ring", 0U);
    stores_request_store(17U, "ring"); // Aborts ranges only.
    expect_status(1U, 1U, 0U);
}

static void packets_that_the_port_refuses_are_sent_later(void)
{
    disable_the_other_store();
    stores_reports(1U, 5U);
    resume("ring", 0U);
    stores_sent.refusals = 4U;
    for (unsigned i = 1U; i <= 4U; i++) {
        stores_step(1U, 5U);
        expect_stores_none_sent();
        TEST_ASSERT_EQUAL_UINT32(i, stores_storage.counters.refused); // The port refuses once in each step.
        TEST_ASSERT_FALSE(stores_is_idle());
    }
    stores_step(2U, 5U);
    expect_stores_sent(1U, 5U);
}

static void classes_have_priorities_and_clients_are_served_in_turn(void)
{
    static const uint8_t turns[]  = {1U, 2U, 1U, 2U, 1U, 2U};
    static const uint8_t orders[] = {1U, 1U, 1U, 2U, 2U, 2U};
    stores_begin_request();
    octet_write_u8(&stores_request, 0U);
    expect_stores_performed(2U);
    stores_begin_request();
    stores_put_name("box");
    octet_write_u8(&stores_request, 2U);
    expect_stores_performed(28U);
    stores_request_all(1U);
    stores_reports(1U, 3U);
    resume("ring", 5U);
    resume("box", 5U);
    stores_step(3U, 3U);
    for (size_t i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL_UINT8(turns[(i + ((stores_sent.packets[0].channel == 1U) ? 0U : 1U)) % 6U],
                                stores_sent.packets[i].channel);
        TEST_ASSERT_EQUAL_UINT16((i / 2U) + 1U, stores_sent.packets[i].sequence);
    }
    stores_request_all(16U);
    resume("ring", 4U);
    resume("box", 5U);
    stores_reports(4U, 6U);
    stores_step(3U, 6U);
    for (size_t i = 0U; i < 6U; i++) {
        TEST_ASSERT_EQUAL_UINT8(orders[i], stores_sent.packets[6U + i].channel);
    }
    stores_request_all(16U);
    stores_request_all(15U); // All retrievals continue with the priority they had.
    TEST_ASSERT_EQUAL_UINT8(4U, stores_storage.stores[0].state.priority);
    TEST_ASSERT_EQUAL_UINT8(5U, stores_storage.stores[1].state.priority);
}

static void a_step_reads_at_most_the_permitted_number_of_packets(void)
{
    disable_the_other_store();
    stores_config.octets_per_step  = 2U * REPORT_SIZE;
    stores_config.packets_per_step = 100U;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_report(1U, 30U, 1U);
    stores_reports(2U, 8U);
    resume("ring", 0U);
    stores_step(1U, 8U);
    expect_stores_sent(1U, 3U);
    stores_step(1U, 8U);
    expect_stores_sent(4U, 5U);
    stores_start_range("box", 0U, 8U, 8U); // The store has no packets here, because it is not enabled.
    stores_step(2U, 8U);
    expect_stores_sent(6U, 8U);
}

static void skipped_packets_count_towards_the_limit_of_a_step(void)
{
    disable_the_other_store();
    stores_config.octets_per_step = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 3U);
    stores_report(4U, REPORT_SIZE, 90U);
    stores_start_range("ring", 0U, 80U, 99U);
    stores_step(3U, 4U);
    expect_stores_none_sent(); // A packet is read in each step.
    stores_step(1U, 4U);
    expect_stores_sent(4U, 4U);
    change_tag("ring", 50U);
    stores_storage.stores[0].state.open_cursor = 0U;
    stores_step(1U, 4U); // The range ends in this step.
    resume("ring", 0U);
    stores_step(3U, 4U);
    expect_stores_none_sent();
    stores_step(1U, 4U);
    expect_stores_sent(4U, 4U);
}

static void damaged_records_are_skipped(void)
{
    disable_the_other_store();
    stores_reports(1U, 9U);
    // In the second record of the first block: after the head of the block (56) and the first record (4014).
    recorded.image[0].octets[56U + 4014U + 99U] ^= 1U;
    resume("ring", 0U);
    stores_step(9U, 9U);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.stores[0].log.counters.damaged);
    TEST_ASSERT_EQUAL_UINT64(6U, stores_sent.count); // 1, and 5 .. 9 of the following blocks.
    TEST_ASSERT_EQUAL_UINT16(5U, stores_sent.packets[1].sequence);
}

static void a_medium_that_fails_is_read_again(void)
{
    disable_the_other_store();
    stores_reports(1U, 2U);
    resume("ring", 0U);
    stores_step(1U, 2U);
    expect_stores_sent(1U, 2U);
    stores_reports(3U, 4U);
    recorded.calls     = 0U;
    recorded.fail_from = 1U;
    stores_step(1U, 2U);
    expect_stores_none_sent();
    stores_step(1U, 2U);
    expect_stores_sent(3U, 4U);
}

// ---- Power cuts ----

static void a_retrieval_continues_after_a_restart(void)
{
    disable_the_other_store();
    stores_reports(1U, 12U);
    stores_step(1U, 12U); // This step syncs.
    change_tag("ring", 2U);
    resume("ring", 7U);
    stores_step(1U, 12U);
    expect_stores_sent(2U, 4U);
    stores_cut();
    expect_status(1U, 1U, 0U);
    stores_step(2U, 13U);
    expect_stores_sent(5U, 10U); // No packet is sent twice, since each step was recorded.
    stores_request_store(16U, "ring");
    stores_start_range("ring", 0U, 1U, 5U);
    stores_step(1U, 14U);
    expect_stores_sent(1U, 3U);
    stores_cut();
    expect_status(1U, 0U, 1U);
    stores_step(9U, 15U);
    expect_stores_sent(4U, 5U);
    stores_cut();
    expect_status(1U, 0U, 0U); // The end of the retrieval was recorded.
}

/// The time was set back: a retrieval that has found its tag sends all later packets, whatever their times.
static void a_retrieval_sends_packets_of_earlier_times_also_after_a_restart(void)
{
    disable_the_other_store();
    stores_reports(10U, 12U);
    stores_reports(4U, 5U);
    stores_step(1U, 13U); // This step syncs.
    change_tag("ring", 10U);
    resume("ring", 7U);
    stores_step(1U, 13U);
    expect_stores_sent(10U, 12U);
    stores_cut();
    stores_step(1U, 14U);
    expect_stores_sent(4U, 5U);
}

static void packets_retrieved_since_the_last_checkpoint_are_sent_again(void)
{
    disable_the_other_store();
    stores_config.checkpoint_interval_ns = 5000000000ULL;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 12U);
    stores_step(1U, 100U);
    resume("ring", 0U);
    const unsigned commits = records.commits;
    stores_step(1U, 101U);
    stores_step(3U, 102U);
    expect_stores_sent(1U, 12U);
    TEST_ASSERT_EQUAL_UINT(commits + 1U, records.commits); // The last checkpoint was long ago.
    TEST_ASSERT_FALSE(stores_is_idle());                   // A checkpoint is due.
    stores_cut();
    stores_step(3U, 103U);
    expect_stores_sent(4U, 12U);
}

static void the_end_of_a_range_is_stored_at_once_and_later_progress_after_the_interval(void)
{
    disable_the_other_store();
    stores_config.checkpoint_interval_ns = 5000000000ULL;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 12U);
    stores_step(1U, 100U);
    stores_request_store(16U, "ring");
    stores_start_range("ring", 0U, 1U, 5U);
    stores_step(4U, 101U);
    expect_stores_sent(1U, 5U);
    resume("ring", 0U);
    const unsigned commits = records.commits;
    stores_step(1U, 102U);
    expect_stores_sent(1U, 3U);
    TEST_ASSERT_EQUAL_UINT(commits, records.commits);
    stores_step(1U, 106U);
    TEST_ASSERT_EQUAL_UINT(commits + 1U, records.commits);
}

static void a_retrieval_does_not_wait_for_packets_that_a_power_cut_lost(void)
{
    disable_the_other_store();
    stores_config.sync_interval_ns = 5000000000ULL;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    stores_reports(1U, 2U);
    stores_step(1U, 10U); // This step syncs.
    stores_reports(3U, 4U);
    resume("ring", 0U);
    stores_step(2U, 11U); // Packets 3 and 4 are sent, but not synced.
    TEST_ASSERT_FALSE(stores_is_idle());
    expect_stores_sent(1U, 4U);
    stores_cut();
    stores_reports(5U, 6U); // Packets 5 and 6 are stored in the blocks of 3 and 4.
    stores_step(2U, 12U);
    expect_stores_sent(5U, 6U);
}

static void checkpoints_that_fail_are_tried_again(void)
{
    disable_the_other_store();
    stores_reports(1U, 5U);
    stores_step(1U, 5U);
    resume("ring", 0U);
    records.put_status = STATUS_FULL;
    stores_step(1U, 5U);
    TEST_ASSERT_EQUAL_UINT32(1U, stores_storage.counters.unkept);
    records.put_status    = STATUS_OK;
    records.commit_status = STATUS_IO;
    stores_step(1U, 5U);
    TEST_ASSERT_EQUAL_UINT32(2U, stores_storage.counters.unkept);
    expect_stores_sent(1U, 5U);
    records.commit_status = STATUS_OK;
    stores_step(1U, 5U);
    stores_cut();
    stores_step(3U, 5U);
    expect_stores_none_sent();
}

static void without_persistence_no_retrieval_is_recorded(void)
{
    stores_config.persistence = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, stores_restart());
    const unsigned puts = records.puts;
    stores_reports(1U, 3U);
    resume("ring", 0U);
    stores_step(2U, 3U);
    expect_stores_sent(1U, 3U);
    TEST_ASSERT_EQUAL_UINT(puts, records.puts);
    TEST_ASSERT_TRUE(stores_is_idle());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_open_retrieval_follows_incoming_packets);
    RUN_TEST(an_open_retrieval_begins_at_its_tag);
    RUN_TEST(a_retrieval_skips_blocks_that_were_overwritten);
    RUN_TEST(a_range_is_sent_once_and_ends);
    RUN_TEST(a_range_can_be_aborted);
    RUN_TEST(packets_that_the_port_refuses_are_sent_later);
    RUN_TEST(classes_have_priorities_and_clients_are_served_in_turn);
    RUN_TEST(a_step_reads_at_most_the_permitted_number_of_packets);
    RUN_TEST(skipped_packets_count_towards_the_limit_of_a_step);
    RUN_TEST(damaged_records_are_skipped);
    RUN_TEST(a_medium_that_fails_is_read_again);
    RUN_TEST(a_retrieval_continues_after_a_restart);
    RUN_TEST(a_retrieval_sends_packets_of_earlier_times_also_after_a_restart);
    RUN_TEST(packets_retrieved_since_the_last_checkpoint_are_sent_again);
    RUN_TEST(the_end_of_a_range_is_stored_at_once_and_later_progress_after_the_interval);
    RUN_TEST(a_retrieval_does_not_wait_for_packets_that_a_power_cut_lost);
    RUN_TEST(checkpoints_that_fail_are_tried_again);
    RUN_TEST(without_persistence_no_retrieval_is_recorded);
    return UNITY_END();
}
