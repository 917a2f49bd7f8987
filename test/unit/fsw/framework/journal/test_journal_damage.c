// SPDX-License-Identifier: Apache-2.0
// Damage at every offset of the media of a journal between two lives: either all records are read, or the
// journal reports that it is damaged; no record is lost without a report. The damaged content is preserved
// before it is changed, and is reported once.
#include "fsw/framework/journal/journal.h"

#include "base/octets.h"
#include "fsw/framework/journal/journal_record.h"
#include "test/support/recorded_media.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CAPACITY 12U
#define KEPT_OCTETS 2048U
#define RANDOM_SHORT 2000U
#define RANDOM_LONG 400000U

static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static const image_t empty[2];
static image_t original[2];
static image_t work[2];
static uint8_t whole[KEPT_OCTETS]; // Content of the journal before the damage.
static size_t whole_size;
static uint8_t found[KEPT_OCTETS];
static size_t found_size;
static unsigned kept_calls;
static uint32_t moves;      // Value in the configuration.
static bool was_compacting; // The written journal has a compaction in progress.
static uint32_t random_state = 1U;
static unsigned long tried;
static unsigned long damage_reports;

static uint32_t random_below(const uint32_t bound)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (uint32_t)(((uint64_t)random_state * bound) >> 32U);
}

/// Preserve the damaged content; no call may have changed the media before.
static bool keep(void* const context)
{
    TEST_ASSERT_EQUAL_PTR(&journal, context);
    for (size_t i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_UINT64(work[i].size, recorded.image[i].size);
        TEST_ASSERT_EQUAL(0, memcmp(work[i].octets, recorded.image[i].octets, work[i].size));
    }
    kept_calls++;
    return true;
}

static void open_journal(void)
{
    const journal_configuration_t configuration = {.media        = {recorded_medium(0U), recorded_medium(1U)},
                                                   .limit        = 1500U,
                                                   .slack        = 200U,
                                                   .moves        = moves,
                                                   .slots        = slots,
                                                   .capacity     = CAPACITY,
                                                   .keep         = keep,
                                                   .keep_context = &journal};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
}

static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                 const size_t size)
{
    (void)context;
    TEST_ASSERT_TRUE((found_size + 2U + size) <= KEPT_OCTETS);
    found[found_size]      = table;
    found[found_size + 1U] = (uint8_t)key;
    memcpy(&found[found_size + 2U], octets, size);
    found_size += 2U + size;
}

static void replay(void)
{
    found_size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, NULL));
}

static void put(const uint32_t key, const uint8_t value, const size_t size)
{
    uint8_t octets[64];
    memset(octets, value, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 11U, key, octets, size));
}

static void commit(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
}

/// Content of the journal without damage.
static void remember(void)
{
    recorded_copy(original, recorded.image);
    recorded_clear(original);
    open_journal();
    TEST_ASSERT_FALSE(journal.damage.is_damaged);
    replay();
    memcpy(whole, found, found_size);
    whole_size = found_size;
    recorded_clear(original);
}

/// Write a journal with `commits` commits of two puts each, every fourth also of an erasure. A large number
/// of commits causes compactions.
static void write_journal(const unsigned commits)
{
    recorded_clear(empty);
    open_journal();
    for (unsigned i = 0U; i < commits; i++) {
        put(i % 5U, (uint8_t)i, 10U + (i % 20U));
        put(5U + (i % 3U), (uint8_t)(i + 100U), 5U);
        if ((i % 4U) == 3U) {
            TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, i % 5U));
        }
        commit();
    }
    was_compacting = journal.is_moving;
    remember();
}

static bool is_whole(void)
{
    return (found_size == whole_size) && (memcmp(found, whole, whole_size) == 0);
}

/// Open the damaged media in `work` and check the result.
static void judge(const char* const what, const size_t offset)
{
    char message[96];
    (void)snprintf(message, sizeof message, "%s at %lu", what, (unsigned long)offset);
    kept_calls = 0U;
    recorded_clear(work);
    open_journal();
    replay();
    const bool is_reported = journal.damage.is_damaged;
    TEST_ASSERT_TRUE_MESSAGE(is_reported || is_whole(), message);
    TEST_ASSERT_EQUAL_UINT_MESSAGE(is_reported ? 1U : 0U, kept_calls, message);
    TEST_ASSERT_TRUE_MESSAGE(is_reported || ((journal.damage.octets == 0U) && (journal.damage.records == 0U)),
                             message);
    tried++;
    damage_reports += is_reported ? 1U : 0U;
    if ((tried % 16U) == 0U) { // Check also that the journal can continue and reports the damage only once.
        const size_t left = found_size;
        recorded_copy(work, recorded.image);
        recorded_clear(work);
        open_journal();
        replay();
        TEST_ASSERT_FALSE_MESSAGE(journal.damage.is_damaged, message);
        TEST_ASSERT_EQUAL_UINT64_MESSAGE(left, found_size, message);
        put(9U, 9U, 3U);
        commit();
        recorded_copy(work, recorded.image);
        recorded_clear(work);
        open_journal();
        replay();
        TEST_ASSERT_FALSE_MESSAGE(journal.damage.is_damaged, message);
        TEST_ASSERT_EQUAL_UINT64_MESSAGE(left + 5U, found_size, message);
    }
}

static void damage_everywhere(void)
{
    static const size_t blocks[] = {2U, 7U, 16U, 64U, 512U};
    for (size_t medium = 0U; medium < 2U; medium++) {
        for (size_t i = 0U; i < original[medium].size; i++) {
            for (unsigned bit = 0U; bit < 8U; bit++) {
                recorded_copy(work, original);
                work[medium].octets[i] ^= (uint8_t)(1U << bit);
                judge("bit flipped", i);
            }
            recorded_copy(work, original);
            work[medium].size = i;
            memset(&work[medium].octets[i], 0, original[medium].size - i);
            judge("cut", i);
            for (size_t k = 0U; k < (sizeof blocks / sizeof blocks[0]); k++) {
                const size_t left = original[medium].size - i;
                const size_t size = (blocks[k] < left) ? blocks[k] : left;
                recorded_copy(work, original);
                memset(&work[medium].octets[i], 0, size);
                judge("zeros", i);
                recorded_copy(work, original);
                memset(&work[medium].octets[i], 0xFF, size);
                judge("ones", i);
            }
        }
        recorded_copy(work, original);
        memset(work[medium].octets, 0, work[medium].size);
        judge("all zeros", medium);
    }
}

void setUp(void)
{
    random_state   = 1U;
    tried          = 0U;
    damage_reports = 0U;
    moves          = 0U;
}

void tearDown(void)
{
}

static void damage_at_any_octet_is_reported_or_harmless(void)
{
    char text[96];
    write_journal(3U); // Without a compaction.
    damage_everywhere();
    write_journal(1U);
    damage_everywhere();
    write_journal(14U);
    TEST_ASSERT_TRUE(journal.stats.generation > 1U);
    damage_everywhere();
    TEST_ASSERT_TRUE((damage_reports > 1000U) && (damage_reports < tried));
    (void)snprintf(text, sizeof text, "%lu damages: %lu were reported, the others lost no record", tried,
                   damage_reports);
    UnityPrint(text);
    UNITY_PRINT_EOL();
}

/// While records are moved, the other medium must still show where the last commit ends.
static void a_cut_during_a_compaction_is_reported(void)
{
    unsigned cuts = 0U;
    moves         = 1U;
    for (unsigned commits = 1U; cuts < 3U; commits++) { // The first one has just begun the compaction.
        TEST_ASSERT_TRUE(commits < 100U);
        write_journal(commits);
        if (was_compacting) {
            recorded_copy(work, original);
            work[0].size -= JOURNAL_RECORD_SIZE(0U); // The last commit.
            judge("last commit", work[0].size);
            TEST_ASSERT_TRUE(journal.damage.is_damaged);
            cuts++;
        }
    }
    damage_everywhere();
}

/// Any two damaged offsets of one medium, in journals of different lengths; very many of them with LONG=1.
static void several_damaged_octets_are_reported_or_harmless(void)
{
    const unsigned count = (getenv("LONG") != NULL) ? RANDOM_LONG : RANDOM_SHORT;
    for (unsigned i = 0U; i < count; i++) {
        if ((i % 500U) == 0U) {
            moves = i % 3U;
            write_journal(1U + random_below(40U));
        }
        const size_t medium = random_below(2U);
        recorded_copy(work, original);
        for (unsigned k = 0U; k < 2U; k++) {
            const size_t offset = random_below((uint32_t)work[medium].size);
            const size_t left   = original[medium].size - offset;
            const size_t size   = 1U + random_below((uint32_t)left);
            switch (random_below(4U)) {
            case 0U:
                work[medium].octets[offset] ^= (uint8_t)(1U + random_below(255U));
                break;
            case 1U:
                memset(&work[medium].octets[offset], (random_below(2U) == 0U) ? 0 : 0xFF, size);
                break;
            case 2U:
                memmove(&work[medium].octets[offset],
                        &original[medium].octets[random_below((uint32_t)offset + 1U)], size);
                break;
            default:
                work[medium].size = (offset > 0U) ? offset : 1U;
                memset(&work[medium].octets[work[medium].size], 0, MEDIUM_MAX - work[medium].size);
                break;
            }
        }
        judge("many", i);
    }
}

/// Two typical damages: a flipped bit early in the file, and a file of zeros.
static void lost_transactions_are_counted(void)
{
    recorded_clear(empty);
    open_journal();
    TEST_ASSERT_FALSE(journal.damage.is_damaged); // This is the first start.
    for (uint32_t key = 1U; key <= 4U; key++) {
        put(key, 1U, 10U);
        commit();
    }
    was_compacting = journal.is_moving;
    remember();
    const size_t step = JOURNAL_RECORD_SIZE(10U) + JOURNAL_RECORD_SIZE(0U);
    recorded_copy(work, original);
    const size_t second = JOURNAL_HEAD_SIZE + step + 16U; // An octet of the second put.
    work[0].octets[second] ^= 1U;
    judge("second put", second);
    TEST_ASSERT_TRUE(journal.damage.is_damaged);
    // Transactions three and four are counted; the damaged second one is not a record any more.
    TEST_ASSERT_EQUAL_UINT32(2U, journal.damage.records);
    TEST_ASSERT_EQUAL_UINT64(3U * step, journal.damage.octets);
    TEST_ASSERT_EQUAL_UINT32(1U, journal.stats.records);
    recorded_copy(work, original);
    memset(work[0].octets, 0, work[0].size);
    judge("zeros", 0U);
    TEST_ASSERT_TRUE(journal.damage.is_damaged);
    TEST_ASSERT_EQUAL_UINT32(0U, journal.damage.records);
    TEST_ASSERT_EQUAL_UINT64(original[0].size, journal.damage.octets);
    uint8_t octets[JOURNAL_DAMAGE_SIZE];
    TEST_ASSERT_TRUE(journal_report_damage(&journal, 5U, octets));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0, 0, 0, 216, 0, 0, 0, 5, 1}), octets, sizeof octets);
    journal.damage = (journal_damage_t){.octets = 1ULL << 40U};
    TEST_ASSERT_FALSE(journal_report_damage(&journal, 0U, octets));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){255, 255, 255, 255, 0, 0, 0, 0, 0}), octets,
                                 sizeof octets);
    TEST_ASSERT_TRUE(journal_report_damage(&journal, 1U, octets));
}

/// A record without content at the end of the medium is found like any other record.
static void the_last_record_after_the_damage_is_counted(void)
{
    recorded_clear(empty);
    open_journal();
    for (uint32_t key = 1U; key <= 3U; key++) {
        put(key, 1U, 10U);
        commit();
    }
    TEST_ASSERT_EQUAL(STATUS_OK, journal_erase(&journal, 11U, 1U)); // This erasure has no commit.
    remember();
    recorded_copy(work, original);
    TEST_ASSERT_EQUAL_UINT64(
        JOURNAL_HEAD_SIZE + (3U * JOURNAL_RECORD_SIZE(10U)) + (4U * JOURNAL_RECORD_SIZE(0U)), work[0].size);
    work[0].octets[JOURNAL_HEAD_SIZE + 16U] ^= 1U;
    kept_calls = 0U;
    recorded_clear(work);
    open_journal();
    TEST_ASSERT_TRUE(journal.damage.is_damaged);
    TEST_ASSERT_EQUAL_UINT32(3U, journal.damage.records); // Two puts and the erasure of the first.
    recorded_copy(work, original);
    work[0].octets[work[0].size - (2U * JOURNAL_RECORD_SIZE(0U))] ^= 1U; // The last commit.
    recorded_clear(work);
    open_journal();
    TEST_ASSERT_TRUE(journal.damage.is_damaged);
    TEST_ASSERT_EQUAL_UINT32(1U, journal.damage.records);
}

/// If both media are damaged, their content shows the damage although there is no mark.
static void damage_of_both_media_is_reported(void)
{
    write_journal(3U);
    recorded_copy(work, original);
    work[1].size = 0U;
    // Damage at the end cannot be distinguished from a power cut in the last commit.
    const size_t first = JOURNAL_HEAD_SIZE + JOURNAL_RECORD_SIZE(10U) + JOURNAL_RECORD_SIZE(5U);
    for (size_t i = 0U; i < first; i++) {
        work[0].octets[i] ^= 0x40U;
        kept_calls = 0U;
        recorded_clear(work);
        open_journal();
        replay();
        TEST_ASSERT_TRUE(journal.damage.is_damaged);
        work[0].octets[i] ^= 0x40U;
    }
    memset(&work[0].octets, 0x55, work[0].size);
    recorded_clear(work);
    open_journal();
    TEST_ASSERT_TRUE(journal.damage.is_damaged);
}

/// Each call of a medium fails once while damaged media are opened.
static void errors_of_damaged_media_are_reported(void)
{
    write_journal(3U);
    const journal_configuration_t configuration = {.media    = {recorded_medium(0U), recorded_medium(1U)},
                                                   .limit    = 1500U,
                                                   .slots    = slots,
                                                   .capacity = CAPACITY};
    for (size_t offset = 3U; offset < 40U; offset += 17U) { // An offset in the head, then offsets in records.
        unsigned failures = 0U;
        status_t status   = STATUS_IO;
        for (unsigned i = 1U; (status != STATUS_OK) || (recorded.calls >= i); i++) {
            recorded_copy(work, original);
            work[0].octets[offset] ^= 1U;
            recorded_clear(work);
            recorded.fail_from = i;
            status             = journal_open(&journal, &configuration);
            TEST_ASSERT_TRUE((status == STATUS_IO) || ((status == STATUS_OK) && journal.damage.is_damaged));
            failures += (status == STATUS_IO) ? 1U : 0U;
        }
        TEST_ASSERT_TRUE(failures > 10U);
    }
}

static void a_damaged_journal_opens_without_a_preserving_callback(void)
{
    write_journal(3U);
    recorded_copy(work, original);
    work[0].octets[20] ^= 1U;
    recorded_clear(work);
    const journal_configuration_t configuration = {.media    = {recorded_medium(0U), recorded_medium(1U)},
                                                   .limit    = 1500U,
                                                   .slots    = slots,
                                                   .capacity = CAPACITY};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
    TEST_ASSERT_TRUE(journal.damage.is_damaged && !journal.damage.is_kept);
}

/// The format of journal_record.h: kind, table, size, number, key, check of the record before.
static void records_on_the_medium_have_consecutive_numbers(void)
{
    recorded_clear(empty);
    open_journal();
    const uint8_t* at = &recorded.image[0].octets[JOURNAL_HEAD_SIZE];
    put(7U, 0x5AU, 4U);
    put(8U, 0x5BU, 4U);
    commit();
    static const uint8_t kinds[] = {JOURNAL_PUT, JOURNAL_PUT, JOURNAL_COMMIT};
    const uint32_t first         = octets_u32_at(&at[4]);
    uint32_t check               = octets_u32_at(&at[12]);
    for (uint32_t i = 0U; i < 3U; i++) {
        const size_t size = (i < 2U) ? 4U : 0U;
        TEST_ASSERT_EQUAL_HEX8(kinds[i], at[0]);
        TEST_ASSERT_EQUAL_UINT16(size, octets_u16_at(&at[2]));
        TEST_ASSERT_EQUAL_UINT32(first + i, octets_u32_at(&at[4]));
        TEST_ASSERT_EQUAL_HEX32(check, octets_u32_at(&at[12]));
        check = octets_u32_at(&at[16U + size]);
        at += JOURNAL_RECORD_SIZE(size);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(records_on_the_medium_have_consecutive_numbers);
    RUN_TEST(damage_at_any_octet_is_reported_or_harmless);
    RUN_TEST(a_cut_during_a_compaction_is_reported);
    RUN_TEST(several_damaged_octets_are_reported_or_harmless);
    RUN_TEST(lost_transactions_are_counted);
    RUN_TEST(the_last_record_after_the_damage_is_counted);
    RUN_TEST(damage_of_both_media_is_reported);
    RUN_TEST(errors_of_damaged_media_are_reported);
    RUN_TEST(a_damaged_journal_opens_without_a_preserving_callback);
    return UNITY_END();
}
