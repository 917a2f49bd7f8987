// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/journal/journal.h"
#include "fsw/framework/journal/journal_record.h"

#include "test/support/assertion.h"
#include "test/support/recorded_media.h"
#include "unity.h"

#include <string.h>

#define CAPACITY 300U
#define LIMIT 30000U
#define KEPT_MAX 400U
#define COMMIT_SIZE JOURNAL_RECORD_SIZE(0U)

typedef struct {
    uint8_t table;
    uint32_t key;
    size_t size;
    uint8_t first; // Value of the first octet; the others follow from it.
} kept_t;

static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static journal_configuration_t configuration;
static kept_t kept[KEPT_MAX];
static size_t kept_count;
static const image_t empty[2];
static image_t saved[2];
static uint8_t octets[JOURNAL_RECORD_MAX + 1U];

void setUp(void)
{
    recorded_clear(empty);
    configuration = (journal_configuration_t){.media    = {recorded_medium(0U), recorded_medium(1U)},
                                              .limit    = LIMIT,
                                              .slack    = LIMIT,
                                              .slots    = slots,
                                              .capacity = CAPACITY};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
}

void tearDown(void)
{
}

static status_t put(const uint32_t key, const size_t size, const uint8_t first)
{
    memset(octets, first, sizeof octets);
    return journal_put(&journal, 11U, key, octets, size);
}

static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const content,
                 const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&kept_count, context);
    TEST_ASSERT_TRUE(kept_count < KEPT_MAX);
    for (size_t i = 1U; i < size; i++) {
        TEST_ASSERT_EQUAL_UINT8(content[0], content[i]);
    }
    kept[kept_count] =
        (kept_t){.table = table, .key = key, .size = size, .first = (size > 0U) ? content[0] : 0U};
    kept_count++;
}

static void replay(void)
{
    kept_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, &kept_count));
    TEST_ASSERT_EQUAL_UINT32(journal.stats.records, kept_count);
}

static void reopen(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
    replay();
}

/// Cut the power, which loses everything that was not synced, and open the journal again.
static void reopen_durable(void)
{
    static image_t sure[2];
    recorded_durable(sure);
    recorded_clear(sure);
    reopen();
}

static void commit(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
}

static void expect_kept(const size_t index, const uint32_t key, const size_t size, const uint8_t first)
{
    TEST_ASSERT_TRUE(index < kept_count);
    TEST_ASSERT_EQUAL_UINT32(key, kept[index].key);
    TEST_ASSERT_EQUAL_UINT64(size, kept[index].size);
    TEST_ASSERT_EQUAL_UINT8(first, kept[index].first);
}

static void records_are_replayed_in_the_order_of_their_last_put(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(UINT32_MAX, JOURNAL_RECORD_MAX, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 12U, 1U, NULL, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 5U, 4U));
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(4U, kept_count);
    expect_kept(0U, 2U, 0U, 0U);
    expect_kept(1U, UINT32_MAX, JOURNAL_RECORD_MAX, 3U);
    TEST_ASSERT_EQUAL_UINT8(12U, kept[2].table);
    expect_kept(3U, 1U, 5U, 4U);
    TEST_ASSERT_EQUAL_UINT8(11U, kept[3].table);
    TEST_ASSERT_EQUAL_UINT32(JOURNAL_RECORD_SIZE(0U) * 2U + JOURNAL_RECORD_SIZE(JOURNAL_RECORD_MAX) +
                                 JOURNAL_RECORD_SIZE(5U),
                             journal.stats.live);
}

static void an_erased_record_is_removed_and_a_missing_one_reports_not_found(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, journal_erase(&journal, 11U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, journal_erase(&journal, 12U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, journal_erase(&journal, 11U, 1U));
    TEST_ASSERT_EQUAL_UINT32(3U, journal.stats.unknown);
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(0U, kept_count);
}

static void uncommitted_records_are_lost_at_reopening(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    reopen(); // All records were written, but not committed.
    TEST_ASSERT_EQUAL_UINT64(0U, kept_count);
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, 1U));
    reopen();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
    expect_kept(0U, 1U, 10U, 1U);
    TEST_ASSERT_EQUAL_UINT64(JOURNAL_RECORD_SIZE(10U) + JOURNAL_RECORD_SIZE(0U), journal.stats.discarded);
}

static void a_commit_without_changes_touches_no_medium(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    const unsigned calls = recorded.calls;
    commit();
    TEST_ASSERT_EQUAL_UINT32(calls, recorded.calls);
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.commits);
}

static void a_full_index_refuses_new_records_only(void)
{
    for (uint32_t i = 0U; i < CAPACITY; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(i * 7U, 1U, 1U));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, put(1U, 1U, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.full);
    TEST_ASSERT_EQUAL(STATUS_OK, put(7U, 1U, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 1U));
    commit();
    reopen();
    TEST_ASSERT_EQUAL_UINT64(CAPACITY, kept_count);
    expect_kept(CAPACITY - 1U, 1U, 1U, 1U);
    expect_kept(CAPACITY - 2U, 7U, 1U, 2U);
    configuration.capacity = CAPACITY - 1U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, journal_open(&journal, &configuration));
}

static void too_large_a_record_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, put(1U, JOURNAL_RECORD_MAX + 1U, 2U));
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.full);
    commit();
    reopen();
    expect_kept(0U, 1U, 10U, 1U);
}

/// A put is refused while erasures of all existing records still fit.
static void a_full_medium_refuses_puts_and_still_erases(void)
{
    uint32_t count = 0U;
    commit();
    while (put(count, 1000U, (uint8_t)count) == STATUS_OK) {
        count++;
    }
    TEST_ASSERT_TRUE((count > 25U) && (count < 30U));
    TEST_ASSERT_EQUAL(STATUS_FULL, put(count, 1000U, 0U));
    commit();
    TEST_ASSERT_EQUAL(STATUS_FULL, put(0U, 1000U, 0U));
    TEST_ASSERT_EQUAL_UINT32(3U, journal.stats.full);
    for (uint32_t i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, i));
    }
    commit();
    TEST_ASSERT_TRUE((recorded.image[0].size <= LIMIT) && (recorded.image[1].size <= LIMIT));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1000U, 1U)); // This put compacts the journal.
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
}

static void a_commit_drops_octets_of_replaced_records(void)
{
    uint64_t most       = 0U;
    configuration.slack = 1044U; // One put and its commit fill the slack to its last octet.
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
    TEST_ASSERT_TRUE((put(77U, 10U, 9U) == STATUS_OK) && (put(78U, 10U, 8U) == STATUS_OK));
    for (uint32_t i = 0U; i < 1000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 80U, (uint8_t)i));
        commit();
        most = (journal.stats.used > most) ? journal.stats.used : most;
    }
    TEST_ASSERT_EQUAL_UINT64((2U * (journal.stats.live + 16U)) + 1044U, most);
    TEST_ASSERT_EQUAL_UINT32(journal.stats.compactions + 1U, journal.stats.generation);
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(3U, kept_count);
    expect_kept(0U, 77U, 10U, 9U);
    expect_kept(1U, 78U, 10U, 8U);
    expect_kept(2U, 1U, 80U, (uint8_t)999U);
}

/// A transaction that would fill both media must not change the medium with the last commit.
static void a_transaction_larger_than_a_medium_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 8000U, 1U));
    commit();
    status_t status = STATUS_OK;
    for (uint32_t i = 0U; (status == STATUS_OK) && (i < 100U); i++) {
        status = put(1U, 8000U, 2U);
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.compactions);
    recorded_copy(saved, recorded.image);
    commit();
    reopen_durable();
    expect_kept(0U, 1U, 8000U, 2U);
    recorded_clear(saved); // Same content as after a power cut before the commit.
    reopen();
    expect_kept(0U, 1U, 8000U, 1U);
}

/// Life 1 writes A, B and a commit, and A is lost. Life 2 writes A again: then B and the old commit after it
/// could be taken for valid.
static void a_stale_tail_is_not_accepted(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    recorded_copy(saved, recorded.image);
    const size_t first = recorded.count;
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 10U, 2U));
    commit();
    for (size_t i = first + 1U; i < (recorded.count - 1U); i++) { // Omit the mark of the commit.
        recorded_apply(&recorded.operations[i], recorded.operations[i].size, saved);
    }
    recorded_clear(saved);
    reopen();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
    TEST_ASSERT_TRUE((journal.stats.discarded > 0U) && !journal.damage.is_damaged);
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 2U));
    reopen();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
    expect_kept(0U, 1U, 10U, 1U);
}

/// Two compactions start the same generation with an equal first record. Power cuts lose this record of the
/// first one, then the unsynced emptying by the second one: old records after it could be taken for valid.
static void a_stale_generation_is_not_accepted(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    for (uint32_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 8000U, (uint8_t)i));
    }
    commit();
    recorded_copy(saved, recorded.image);
    const size_t first = recorded.count;
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 8000U, 50U)); // Compaction: emptying, sync, head, first record
    commit();
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.compactions);
    for (size_t i = first; i < (recorded.count - 2U); i++) { // Omit the mark and its resize.
        if (i != (first + 3U)) {
            recorded_apply(&recorded.operations[i], recorded.operations[i].size, saved);
        }
    }
    recorded_clear(saved);
    reopen();
    expect_kept(1U, 2U, 8000U, 2U);
    const size_t second = recorded.count;
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 8000U, 60U)); // This put compacts the journal.
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.compactions);
    for (size_t i = second; i < (second + 4U); i++) { // The operations up to the first record.
        const bool is_sure = (i > second) || (recorded.operations[second + 1U].kind == OPERATION_SYNC);
        if (is_sure) {
            recorded_apply(&recorded.operations[i], recorded.operations[i].size, saved);
        }
    }
    recorded_clear(saved);
    reopen();
    TEST_ASSERT_EQUAL_UINT64(2U, kept_count);
    expect_kept(1U, 2U, 8000U, 2U);
}

/// Records with the correct numbers that follow other records than those before which they were written.
static void a_record_of_another_sequence_of_records_is_not_accepted(void)
{
    static image_t other[2];
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    const size_t end = recorded.image[0].size;
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 10U, 1U));
    commit();
    recorded_copy(other, recorded.image);
    recorded_clear(empty);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 7U));
    commit();
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 10U, 7U));
    commit();
    memcpy(&recorded.image[0].octets[end], &other[0].octets[end], other[0].size - end);
    reopen();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
    expect_kept(0U, 1U, 10U, 7U);
}

/// The journal ends before a damaged octet; no wrong record is read, and the journal can continue after the
/// damage.
static void any_damaged_octet_is_detected(void)
{
    for (uint8_t i = 1U; i <= 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(i, 10U, i));
        commit();
    }
    recorded_copy(saved, recorded.image);
    const size_t step = JOURNAL_RECORD_SIZE(10U) + COMMIT_SIZE;
    const size_t size = saved[0].size;
    for (size_t k = 0U; k < (size * 2U); k++) {
        const size_t i     = k / 2U;
        const uint8_t mask = ((k % 2U) == 0U) ? 0x10U : 0x80U;
        saved[0].octets[i] ^= mask;
        recorded_clear(saved);
        saved[0].octets[i] ^= mask;
        reopen();
        const size_t expected = (i < JOURNAL_HEAD_SIZE) ? 0U : ((i - JOURNAL_HEAD_SIZE) / step);
        TEST_ASSERT_EQUAL_UINT64(expected, kept_count);
        for (size_t n = 0U; n < kept_count; n++) {
            expect_kept(n, (uint32_t)n + 1U, 10U, (uint8_t)(n + 1U));
        }
        TEST_ASSERT_EQUAL(STATUS_OK, put(9U, 10U, 9U));
        commit();
        reopen_durable();
        TEST_ASSERT_EQUAL_UINT64(expected + 1U, kept_count);
    }
}

/// The journal never writes such a record, but the reader must be able to skip it.
static void erasing_a_missing_record_is_skipped(void)
{
    const medium_t medium       = recorded_medium(1U);
    journal_position_t position = journal_first_position(9U);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_write_head(&medium, 9U));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      journal_write_record(&medium, &position,
                                           &(journal_record_t){.kind = JOURNAL_ERASE, .key = 5U}, octets));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_write_record(&medium, &position,
                                                      &(journal_record_t){.kind = JOURNAL_COMMIT}, octets));
    reopen();
    TEST_ASSERT_EQUAL_UINT64(0U, kept_count);
    TEST_ASSERT_EQUAL_UINT32(9U, journal.stats.generation);
}

static void octets_that_are_not_a_journal_are_replaced(void)
{
    memset(saved[0].octets, 'P', MEDIUM_MAX);
    memset(saved[1].octets, 'C', MEDIUM_MAX);
    saved[0].size = MEDIUM_MAX;
    saved[1].size = 5U;
    recorded_clear(saved);
    reopen();
    TEST_ASSERT_EQUAL_UINT64(0U, kept_count);
    TEST_ASSERT_EQUAL(STATUS_OK, put(9U, 10U, 9U));
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
}

// ---- Errors of the media ----

#define SCRIPT_KEYS 6U
static uint8_t expected_first[SCRIPT_KEYS]; // 0: the record does not exist.

/// Puts, erasures, commits, compactions by puts and commits; a refused call leaves the expected state.
static void run_script(void)
{
    for (uint32_t i = 0U; i < 14U; i++) {
        const uint32_t key    = i % SCRIPT_KEYS;
        const uint8_t first   = (uint8_t)(i + 1U);
        const status_t status = put(key, 60U, first);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_IO) || (status == STATUS_FULL));
        expected_first[key] = (status == STATUS_OK) ? first : expected_first[key];
        if ((i % 3U) == 2U) {
            if (journal_erase(&journal, 11U, key) == STATUS_OK) {
                expected_first[key] = 0U;
            }
            (void)journal_commit(&journal);
        }
    }
}

static void expect_script(void)
{
    size_t expected = 0U;
    for (uint32_t key = 0U; key < SCRIPT_KEYS; key++) {
        if (expected_first[key] != 0U) {
            size_t found = 0U;
            while ((found < kept_count) && (kept[found].key != key)) {
                found++;
            }
            expect_kept(found, key, 60U, expected_first[key]);
            expected++;
        }
    }
    TEST_ASSERT_EQUAL_UINT64(expected, kept_count);
}

static void start_script(const unsigned fail_from, const unsigned fail_count, const status_t failure,
                         const size_t torn)
{
    recorded_clear(empty);
    memset(expected_first, 0, sizeof expected_first);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
    recorded.calls      = 0U;
    recorded.fail_from  = fail_from;
    recorded.fail_count = fail_count;
    recorded.failure    = failure;
    recorded.torn       = torn;
}

/// Each call of a medium fails, alone or with the next three; the commit that finally succeeds keeps
/// everything that was accepted.
static void fail_everywhere(const uint32_t limit, const uint32_t slack)
{
    static const status_t failures[] = {STATUS_IO, STATUS_FULL};
    configuration.limit              = limit;
    configuration.slack              = slack;
    start_script(0U, 0U, STATUS_OK, 0U);
    run_script();
    const unsigned calls = recorded.calls;
    TEST_ASSERT_TRUE(journal.stats.compactions >= 1U);
    for (unsigned i = 0U; i < (calls * 8U); i++) {
        start_script(1U + (i / 8U), ((i & 1U) != 0U) ? 1U : 4U, failures[(i >> 1U) & 1U],
                     ((i & 4U) != 0U) ? 23U : 0U);
        run_script();
        recorded.fail_from = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
        TEST_ASSERT_TRUE((journal.stats.failed + journal.stats.full + journal.stats.unmarked) > 0U);
        replay();
        expect_script();
        reopen_durable();
        expect_script();
    }
}

static void a_commit_that_failed_is_repeated(void)
{
    fail_everywhere(900U, 900U); // Puts compact the journal.
    fail_everywhere(3000U, 0U);  // Commits compact the journal.
}

/// The remains of a failed write are cut off before anything else is written.
static void a_torn_record_is_overwritten_completely_by_the_next_one(void)
{
    recorded.calls     = 0U;
    recorded.fail_from = 1U;
    recorded.torn      = 500U;
    TEST_ASSERT_EQUAL(STATUS_IO, put(1U, 600U, 1U));
    TEST_ASSERT_TRUE(recorded.image[0].size > 500U);
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 2U));
    TEST_ASSERT_EQUAL_UINT64(journal.stats.used, recorded.image[0].size);
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(0U, journal.stats.discarded);
    expect_kept(0U, 1U, 10U, 2U);
}

static void a_medium_that_fails_permanently_keeps_the_last_commit(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    recorded.calls      = 0U;
    recorded.fail_from  = 1U;
    recorded.fail_count = 1000U;
    TEST_ASSERT_EQUAL(STATUS_IO, put(2U, 10U, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, journal_erase(&journal, 11U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal)); // No record was accepted.
    TEST_ASSERT_EQUAL(STATUS_IO, journal_replay(&journal, take, &kept_count));
    TEST_ASSERT_EQUAL_UINT32(3U, journal.stats.failed);
    recorded.fail_from = 0U;
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(1U, kept_count);
}

/// After a failed sync, data that cannot be read any more cannot be written again.
static void a_commit_fails_as_long_as_its_records_cannot_be_read(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    commit();
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 10U, 1U));
    recorded.calls      = 0U;
    recorded.fail_from  = 2U; // The sync.
    recorded.fail_count = 1U;
    TEST_ASSERT_EQUAL(STATUS_IO, journal_commit(&journal));
    const size_t offset = JOURNAL_HEAD_SIZE + JOURNAL_RECORD_SIZE(10U) + COMMIT_SIZE + 3U;
    recorded.image[0].octets[offset] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_IO, journal_commit(&journal));
    recorded.image[0].octets[offset] ^= 1U;
    commit();
    reopen_durable();
    TEST_ASSERT_EQUAL_UINT64(2U, kept_count);
}

static void every_error_at_open_is_reported(void)
{
    for (unsigned k = 0U; k < 3U; k++) { // Never used; without a commit; with an incomplete transaction.
        recorded_copy(saved, recorded.image);
        unsigned tries = 0U;
        for (status_t status = STATUS_IO; status != STATUS_OK; tries++) {
            recorded_clear((k == 0U) ? empty : saved);
            recorded.fail_from = tries + 1U;
            status             = journal_open(&journal, &configuration);
            TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_IO));
        }
        TEST_ASSERT_EQUAL_UINT(((const unsigned[]){9U, 14U, 20U})[k], tries);
        recorded_clear((k == 0U) ? empty : saved);
        TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
        TEST_ASSERT_EQUAL(STATUS_OK, put(k, 10U, 1U));
        if (k == 1U) {
            commit();
            TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 10U, 1U));
        }
    }
    recorded_clear(empty);
    recorded.failure   = STATUS_FULL;
    recorded.fail_from = 7U; // The head of an empty journal fails.
    TEST_ASSERT_EQUAL(STATUS_FULL, journal_open(&journal, &configuration));
}

static void call_back(void* const context, const uint8_t table, const uint32_t key,
                      const uint8_t* const content, const size_t size)
{
    (void)context;
    (void)journal_put(&journal, table, key, content, size);
}

static void put_while_replaying(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, call_back, NULL));
}

static void a_callback_that_calls_the_journal_is_a_coding_error(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 10U, 1U));
    TEST_ASSERT_TRUE(assertion_fails(put_while_replaying));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(records_are_replayed_in_the_order_of_their_last_put);
    RUN_TEST(an_erased_record_is_removed_and_a_missing_one_reports_not_found);
    RUN_TEST(uncommitted_records_are_lost_at_reopening);
    RUN_TEST(a_commit_without_changes_touches_no_medium);
    RUN_TEST(a_full_index_refuses_new_records_only);
    RUN_TEST(too_large_a_record_is_refused);
    RUN_TEST(a_full_medium_refuses_puts_and_still_erases);
    RUN_TEST(a_commit_drops_octets_of_replaced_records);
    RUN_TEST(a_transaction_larger_than_a_medium_is_refused);
    RUN_TEST(a_stale_tail_is_not_accepted);
    RUN_TEST(a_stale_generation_is_not_accepted);
    RUN_TEST(a_record_of_another_sequence_of_records_is_not_accepted);
    RUN_TEST(any_damaged_octet_is_detected);
    RUN_TEST(erasing_a_missing_record_is_skipped);
    RUN_TEST(octets_that_are_not_a_journal_are_replaced);
    RUN_TEST(a_commit_that_failed_is_repeated);
    RUN_TEST(a_torn_record_is_overwritten_completely_by_the_next_one);
    RUN_TEST(a_medium_that_fails_permanently_keeps_the_last_commit);
    RUN_TEST(a_commit_fails_as_long_as_its_records_cannot_be_read);
    RUN_TEST(every_error_at_open_is_reported);
    RUN_TEST(a_callback_that_calls_the_journal_is_a_coding_error);
    return UNITY_END();
}
