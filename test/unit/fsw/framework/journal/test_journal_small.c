// SPDX-License-Identifier: Apache-2.0
// A journal on a medium of 64 KiB, as the records of a program on a board: two areas of 32 KiB. The power is
// cut at each write of a script with compactions. The medium then has no octet, one half or all octets of
// that write, or it has lost all octets that were not synced. The test also runs on a board.
#include "fsw/framework/journal/journal.h"

#include "unity.h"

#include <string.h>

#define AREA 32768U
#define SLACK 4096U
#define MOVES 4U // As the programs: osal/freertos/capacities.h.
#define CAPACITY 64U
#define KEYS 6U
#define RECORD 1000U
#define TRANSACTIONS 32U
#define TABLE 9U
#define CUTS_MAX 1000U

typedef enum {
    CUT_BEFORE,
    CUT_INSIDE,
    CUT_BEHIND,
    CUT_UNSYNCED,
    CUTS
} cut_t;

typedef struct {
    uint8_t octets[AREA];
    uint8_t durable[AREA]; // Content at the last sync.
    size_t size;
    size_t durable_size;
    size_t first; // Octets that are not synced: [first, end).
    size_t end;
} area_t;

static area_t areas[2];
static unsigned writes; // Number of writes since the script was last started.
static unsigned cut_at; // Number of the write at which the power is cut; 0: none.
static cut_t kind;
static bool is_off;     // The power is cut: every call fails, and nothing changes.
static bool was_beyond; // A call went beyond the area.
static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static uint8_t record[RECORD];
// Version of each record; 0: the record does not exist.
static unsigned committed[KEYS]; // After the last acknowledged commit.
static unsigned intended[KEYS];  // After the commit in progress.
static unsigned found[KEYS];
static bool is_content_right;

// ---- The medium ----

static status_t read_area(void* const context, const uint64_t offset, uint8_t* const octets,
                          const size_t size)
{
    const area_t* const area = context;
    if (is_off) {
        return STATUS_IO;
    }
    if ((offset > area->size) || (size > (area->size - (size_t)offset))) {
        return STATUS_TRUNCATED;
    }
    (void)memcpy(octets, &area->octets[offset], size);
    return STATUS_OK;
}

static void store(area_t* const area, const size_t offset, const uint8_t* const octets, const size_t size)
{
    (void)memcpy(&area->octets[offset], octets, size);
    area->first = ((area->first == area->end) || (offset < area->first)) ? offset : area->first;
    area->end   = ((offset + size) > area->end) ? (offset + size) : area->end;
    area->size  = ((offset + size) > area->size) ? (offset + size) : area->size;
}

static void lose_unsynced(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        area_t* const area = &areas[i];
        (void)memcpy(&area->octets[area->first], &area->durable[area->first], area->end - area->first);
        area->size  = area->durable_size;
        area->first = 0U;
        area->end   = 0U;
    }
}

static status_t write_area(void* const context, const uint64_t offset, const uint8_t* const octets,
                           const size_t size)
{
    area_t* const area = context;
    if (is_off) {
        return STATUS_IO;
    }
    if ((offset + size) > AREA) {
        was_beyond = true;
        return STATUS_FULL;
    }
    writes++;
    if (writes != cut_at) {
        store(area, (size_t)offset, octets, size);
        return STATUS_OK;
    }
    is_off = true;
    if (kind == CUT_UNSYNCED) {
        lose_unsynced();
    } else if (kind != CUT_BEFORE) {
        store(area, (size_t)offset, octets, (kind == CUT_INSIDE) ? (size / 2U) : size);
    } else {
        // No octet of the write is stored.
    }
    return STATUS_IO;
}

static status_t sync_area(void* const context)
{
    area_t* const area = context;
    if (is_off) {
        return STATUS_IO;
    }
    (void)memcpy(&area->durable[area->first], &area->octets[area->first], area->end - area->first);
    area->durable_size = area->size;
    area->first        = 0U;
    area->end          = 0U;
    return STATUS_OK;
}

static status_t size_of_area(void* const context, uint64_t* const out_size)
{
    *out_size = ((const area_t*)context)->size;
    return is_off ? STATUS_IO : STATUS_OK;
}

static status_t resize_area(void* const context, const uint64_t size)
{
    area_t* const area = context;
    if (is_off || (size > AREA)) {
        was_beyond = was_beyond || (size > AREA);
        return is_off ? STATUS_IO : STATUS_FULL;
    }
    if (size > area->size) {
        static const uint8_t zeros[AREA];
        store(area, area->size, zeros, (size_t)size - area->size);
    }
    area->size = (size_t)size;
    return STATUS_OK;
}

static medium_t medium_of(const unsigned index)
{
    return (medium_t){.context = &areas[index],
                      .read    = read_area,
                      .write   = write_area,
                      .sync    = sync_area,
                      .size    = size_of_area,
                      .resize  = resize_area};
}

// ---- The records ----

static status_t open_journal(void)
{
    const journal_configuration_t configuration = {.media    = {medium_of(0U), medium_of(1U)},
                                                   .limit    = AREA,
                                                   .slack    = SLACK,
                                                   .moves    = MOVES,
                                                   .slots    = slots,
                                                   .capacity = CAPACITY};
    return journal_open(&journal, &configuration);
}

static void fill(const unsigned key, const unsigned version)
{
    for (size_t i = 0U; i < RECORD; i++) {
        record[i] = (uint8_t)((key * 31U) + (version * 7U) + i);
    }
    record[0] = (uint8_t)version;
}

static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                 const size_t size)
{
    (void)context;
    is_content_right = is_content_right && (table == TABLE) && (key < KEYS) && (size == RECORD);
    if (is_content_right) {
        fill(key, octets[0]);
        is_content_right = (memcmp(record, octets, RECORD) == 0);
        found[key]       = octets[0];
    }
}

static status_t change(const unsigned transaction)
{
    const unsigned key   = (transaction * 5U) % KEYS;
    const bool is_erased = ((transaction % 7U) == 6U) && (intended[key] != 0U);
    intended[key]        = is_erased ? 0U : (transaction + 1U);
    if (is_erased) {
        return journal_erase(&journal, TABLE, key);
    }
    fill(key, transaction + 1U);
    return journal_put(&journal, TABLE, key, record, RECORD);
}

/// Run the script until its end or until the power is cut. The journal must then have the records of
/// `committed` or of `intended`.
static void run_script(void)
{
    for (unsigned i = 0U; i < 2U; i++) { // Octets after the size are never read.
        areas[i].size         = 0U;
        areas[i].durable_size = 0U;
        areas[i].first        = 0U;
        areas[i].end          = 0U;
    }
    (void)memset(committed, 0, sizeof committed);
    (void)memset(intended, 0, sizeof intended);
    writes = 0U;
    is_off = false;
    if (open_journal() != STATUS_OK) {
        return;
    }
    for (unsigned transaction = 0U; (transaction < TRANSACTIONS) && !is_off; transaction++) {
        const status_t changed = change(transaction);
        if ((changed == STATUS_OK) && (journal_commit(&journal) == STATUS_OK)) {
            (void)memcpy(committed, intended, sizeof committed);
        }
    }
}

/// Switch the power on again. Expect the records of the last commit or of the commit in progress, no damage,
/// and that the journal accepts another commit.
static void expect_whole_transaction(void)
{
    is_off = false;
    cut_at = 0U;
    (void)memset(found, 0, sizeof found);
    is_content_right = true;
    TEST_ASSERT_EQUAL(STATUS_OK, open_journal());
    TEST_ASSERT_FALSE(journal.damage.is_damaged);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, NULL));
    TEST_ASSERT_TRUE(is_content_right);
    TEST_ASSERT_TRUE((memcmp(found, committed, sizeof found) == 0) ||
                     (memcmp(found, intended, sizeof found) == 0));
    fill(1U, 200U);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, TABLE, 1U, record, RECORD));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    found[1] = 200U;
    unsigned before[KEYS];
    (void)memcpy(before, found, sizeof before);
    (void)memset(found, 0, sizeof found);
    TEST_ASSERT_EQUAL(STATUS_OK, open_journal());
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, NULL));
    TEST_ASSERT_EQUAL_MEMORY(before, found, sizeof found);
}

void setUp(void)
{
    cut_at     = 0U;
    was_beyond = false;
}

void tearDown(void)
{
}

static void the_script_fits_the_medium_and_compacts(void)
{
    run_script();
    TEST_ASSERT_FALSE(is_off);
    TEST_ASSERT_FALSE(was_beyond);
    TEST_ASSERT_TRUE(journal.stats.compactions >= 2U);
    TEST_ASSERT_EQUAL_UINT32(TRANSACTIONS, journal.stats.commits);
    TEST_ASSERT_EQUAL_MEMORY(intended, committed, sizeof committed);
    expect_whole_transaction();
}

/// A service commits in a step of the main loop: a compaction must not make one commit much longer.
static void a_commit_writes_a_bounded_number_of_times(void)
{
    unsigned most = 0U;
    run_script();
    const uint32_t compactions = journal.stats.compactions;
    for (unsigned transaction = 0U; transaction < (2U * TRANSACTIONS); transaction++) {
        TEST_ASSERT_EQUAL(STATUS_OK, change(transaction));
        const unsigned before = writes;
        TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
        most = ((writes - before) > most) ? (writes - before) : most;
        // A file system that never overwrites octets copies all that follow the mark each time it writes the
        // mark.
        TEST_ASSERT_TRUE(journal.is_moving || (areas[1U - journal.active].size == JOURNAL_HEAD_SIZE));
    }
    TEST_ASSERT_TRUE(journal.stats.compactions >= (compactions + 3U));
    // Commit and mark; the moved records, and commit and mark of the new generation.
    TEST_ASSERT_TRUE(most <= (2U + MOVES + 2U));
}

static void put_and_commit(const uint32_t key)
{
    fill(key, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, TABLE, key, record, RECORD));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
}

static void a_record_erased_after_it_was_moved_stays_erased(void)
{
    run_script();
    for (uint32_t i = 0U; (i < KEYS) || journal.is_moving; i++) { // Record 0 is the oldest one.
        put_and_commit((i < KEYS) ? i : 1U);
    }
    const uint32_t compactions = journal.stats.compactions;
    for (unsigned i = 0U; !journal.is_moving || (journal.move.to.offset < RECORD);
         i++) { // Record 0 is moved first.
        TEST_ASSERT_TRUE(i < TRANSACTIONS);
        put_and_commit(1U);
    }
    TEST_ASSERT_EQUAL_UINT32(compactions, journal.stats.compactions);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, TABLE, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    while (journal.stats.compactions == compactions) {
        put_and_commit(1U);
    }
    (void)memset(found, 0, sizeof found);
    is_content_right = true;
    TEST_ASSERT_EQUAL(STATUS_OK, open_journal());
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, NULL));
    TEST_ASSERT_TRUE(is_content_right);
    TEST_ASSERT_EQUAL_UINT(0U, found[0]);
    TEST_ASSERT_EQUAL_UINT(1U, found[1]);
}

static void a_power_cut_at_any_write_leaves_a_whole_transaction(void)
{
    unsigned cuts = 0U;
    for (kind = CUT_BEFORE; kind < CUTS; kind++) {
        bool is_cut = true;
        for (unsigned write = 1U; is_cut; write++) {
            TEST_ASSERT_TRUE(write < CUTS_MAX);
            cut_at = write;
            run_script();
            is_cut = is_off;
            cuts += is_cut ? 1U : 0U;
            expect_whole_transaction();
        }
    }
    TEST_ASSERT_FALSE(was_beyond);
    TEST_ASSERT_TRUE(cuts > ((unsigned)CUTS * TRANSACTIONS));
}

static void a_full_medium_refuses_puts_and_keeps_its_records(void)
{
    status_t status = STATUS_OK;
    unsigned count  = 0U;
    run_script();
    for (unsigned key = KEYS; (key < CAPACITY) && (status == STATUS_OK); key++) {
        fill(key, 1U);
        status = journal_put(&journal, TABLE, key, record, RECORD);
        count += (status == STATUS_OK) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_TRUE(count >= 8U);
    TEST_ASSERT_FALSE(was_beyond);
    for (unsigned key = KEYS; key < (KEYS + count); key++) {
        TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, TABLE, key));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    expect_whole_transaction();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_script_fits_the_medium_and_compacts);
    RUN_TEST(a_commit_writes_a_bounded_number_of_times);
    RUN_TEST(a_record_erased_after_it_was_moved_stays_erased);
    RUN_TEST(a_power_cut_at_any_write_leaves_a_whole_transaction);
    RUN_TEST(a_full_medium_refuses_puts_and_keeps_its_records);
    return UNITY_END();
}
