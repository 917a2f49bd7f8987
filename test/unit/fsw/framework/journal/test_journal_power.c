// SPDX-License-Identifier: Apache-2.0
// A journal through many lives, each of which ends with a power cut at any write. After each cut the state
// must be that of the last acknowledged commit or of the commit in progress.
#include "fsw/framework/journal/journal.h"

#include "test/support/recorded_media.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define CAPACITY 12U
#define KEYS 8U
#define TABLES 2U
#define LIMIT 1500U
#define COMMITS_MAX 64U
#define LIVES 8U
#define TRANSACTIONS 22U
#define RANDOM_SUBSETS 4U
#define PENDING_MAX 512U

typedef struct {
    uint8_t table;
    uint32_t key;
    uint32_t version; // Determines size and octets of the record.
} kept_t;

/// Expected content of the journal, in the order in which it was put.
typedef struct {
    size_t count;
    kept_t kept[CAPACITY];
} state_t;

static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(CAPACITY)];
static state_t states[COMMITS_MAX]; // States after each commit of this life; the last commit is in progress.
static size_t state_count;
static state_t replayed;
static uint32_t moves; // Value in the configuration.
static bool is_content_right;
static bool is_power_cut; // A power cut is the only change of the media.
static uint32_t random_state = 1U;
static unsigned long cuts;
static image_t images[2];
static image_t durable[2];
static image_t chosen[2];

static uint32_t random_below(const uint32_t bound)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (uint32_t)(((uint64_t)random_state * bound) >> 32U);
}

static size_t content(const uint32_t version, uint8_t* const octets)
{
    const size_t size = (version * 29U) % 61U;
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (uint8_t)((version * 7U) + i);
    }
    return size;
}

static void open_journal(void)
{
    const journal_configuration_t configuration = {.media    = {recorded_medium(0U), recorded_medium(1U)},
                                                   .limit    = LIMIT,
                                                   .slack    = 60U,
                                                   .moves    = moves,
                                                   .slots    = slots,
                                                   .capacity = CAPACITY};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &configuration));
}

/// There are few versions, so that a record of an earlier life often occurs again, octet by octet.
static void take(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                 const size_t size)
{
    state_t* const state = context;
    uint8_t expected[64];
    for (uint32_t version = 0U; version < 4U; version++) {
        if ((content(version, expected) == size) && (memcmp(expected, octets, size) == 0)) {
            TEST_ASSERT_TRUE(state->count < CAPACITY);
            state->kept[state->count] = (kept_t){.table = table, .key = key, .version = version};
            state->count++;
            return;
        }
    }
    is_content_right = false;
}

static void replay(void)
{
    replayed         = (state_t){0};
    is_content_right = true;
    open_journal();
    TEST_ASSERT_EQUAL(STATUS_OK, journal_replay(&journal, take, &replayed));
    TEST_ASSERT_TRUE(is_content_right);
    TEST_ASSERT_FALSE(journal.damage.is_damaged && is_power_cut); // A power cut must not count as damage.
    TEST_ASSERT_EQUAL_UINT32(replayed.count, journal.stats.records);
}

static bool is_same(const state_t* const a, const state_t* const b)
{
    bool is_equal = (a->count == b->count);
    for (size_t i = 0U; is_equal && (i < a->count); i++) {
        is_equal = (a->kept[i].table == b->kept[i].table) && (a->kept[i].key == b->kept[i].key) &&
                   (a->kept[i].version == b->kept[i].version);
    }
    return is_equal;
}

static void model_erase(state_t* const state, const uint8_t table, const uint32_t key)
{
    size_t kept = 0U;
    for (size_t i = 0U; i < state->count; i++) {
        if ((state->kept[i].table != table) || (state->kept[i].key != key)) {
            state->kept[kept] = state->kept[i];
            kept++;
        }
    }
    state->count = kept;
}

/// One put or erasure, in the journal and in the expected state.
static void change(void)
{
    state_t* const state   = &states[state_count - 1U];
    const uint8_t table    = (uint8_t)random_below(TABLES);
    const uint32_t key     = random_below(KEYS);
    const uint32_t version = random_below(4U);
    const size_t before    = state->count;
    uint8_t octets[64];
    if (random_below(3U) == 0U) {
        model_erase(state, table, key);
        const status_t expected = (state->count < before) ? STATUS_OK : STATUS_NOT_FOUND;
        TEST_ASSERT_EQUAL(expected, journal_erase(&journal, table, key));
        return;
    }
    const status_t status = journal_put(&journal, table, key, octets, content(version, octets));
    if (status == STATUS_OK) {
        model_erase(state, table, key);
        state->kept[state->count] = (kept_t){.table = table, .key = key, .version = version};
        state->count++;
    } else {
        TEST_ASSERT_EQUAL(STATUS_FULL, status);
    }
}

/// Put and commit transactions. The recorded operations are marked: those of the changes of a transaction
/// with an even number, those of its commit with the next odd number.
static void run_transactions(void)
{
    for (unsigned i = 0U; i < TRANSACTIONS; i++) {
        const uint32_t changes = random_below((random_below(6U) == 0U) ? 24U : 5U);
        for (uint32_t k = 0U; k < changes; k++) {
            change();
        }
        recorded.mark++;
        TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
        recorded.mark++;
        states[state_count] = states[state_count - 1U];
        state_count++;
    }
}

/// After a cut, the media contain the state of one of two commits.
static void judge(const unsigned mark)
{
    recorded_t* const self = &recorded;
    const size_t last      = mark / 2U; // Index of the state of the last acknowledged commit.
    recorded_copy(self->image, images);
    const size_t count     = self->count;
    const size_t data_size = self->data_size;
    replay();
    self->count     = count; // The operations of opening do not belong to the tested life.
    self->data_size = data_size;
    cuts++;
    const bool is_acknowledged = is_same(&replayed, &states[last]);
    const bool is_under_way    = ((mark % 2U) == 1U) && is_same(&replayed, &states[last + 1U]);
    if (!is_acknowledged && !is_under_way) {
        TEST_FAIL_MESSAGE("neither the last acknowledged state nor that of the commit in progress");
    }
}

static size_t pending[PENDING_MAX]; // Operations that are not synced yet.
static size_t pending_count;

/// Effect of a cut on the pending operations: which of their octets are on the medium.
typedef struct {
    enum {
        ALL,
        NONE,
        ALL_BUT_ONE,
        ONLY_ONE,
        SOME
    } which;
    size_t one;
    size_t torn; // Octets of the last operation.
} choice_t;

static void cut(const choice_t* const choice, const unsigned mark)
{
    recorded_copy(images, durable);
    for (size_t i = 0U; i < pending_count; i++) {
        const operation_t* const operation = &recorded.operations[pending[i]];
        const bool is_last                 = (i + 1U) == pending_count;
        size_t size                        = operation->size;
        bool is_done                       = true;
        switch (choice->which) {
        case ALL:
            size = is_last ? choice->torn : size;
            break;
        case NONE:
            is_done = false;
            break;
        case ALL_BUT_ONE:
            is_done = (i != choice->one);
            break;
        case ONLY_ONE:
            is_done = (i == choice->one);
            break;
        case SOME:
        default:
            is_done = random_below(2U) == 0U;
            size    = (random_below(4U) == 0U) ? random_below((uint32_t)size + 1U) : size;
            break;
        }
        if (is_done) {
            recorded_apply(operation, size, images);
        }
    }
    judge(mark);
}

static void cut_in_all_ways(const size_t last)
{
    const operation_t* const operation = &recorded.operations[last];
    const unsigned mark                = operation->mark;
    for (size_t torn = 0U; torn <= operation->size; torn++) {
        cut(&(choice_t){.which = ALL, .torn = torn}, mark);
    }
    cut(&(choice_t){.which = NONE}, mark);
    for (size_t i = 0U; i < pending_count; i++) {
        cut(&(choice_t){.which = ALL_BUT_ONE, .one = i}, mark);
        cut(&(choice_t){.which = ONLY_ONE, .one = i}, mark);
    }
    for (unsigned i = 0U; i < RANDOM_SUBSETS; i++) {
        cut(&(choice_t){.which = SOME}, mark);
    }
}

/// A sync of one medium completes its operations; operations of the other medium stay pending.
static void sync_medium(const size_t medium)
{
    size_t kept = 0U;
    for (size_t i = 0U; i < pending_count; i++) {
        const operation_t* const operation = &recorded.operations[pending[i]];
        if (operation->medium == medium) {
            recorded_apply(operation, operation->size, durable);
        } else {
            pending[kept] = pending[i];
            kept++;
        }
    }
    pending_count = kept;
}

/// Cut the power at each operation of this life. The next life starts from one of these cuts.
static void die_everywhere(void)
{
    const size_t count      = recorded.count;
    const size_t chosen_one = random_below((uint32_t)count);
    recorded_copy(durable, recorded.durable);
    pending_count = 0U;
    for (size_t i = 0U; i < count; i++) {
        const operation_t* const operation = &recorded.operations[i];
        if (operation->kind == OPERATION_SYNC) {
            sync_medium(operation->medium);
        } else {
            TEST_ASSERT_TRUE(pending_count < PENDING_MAX);
            pending[pending_count] = i;
            pending_count++;
            cut_in_all_ways(i);
            if (i <= chosen_one) {
                recorded_copy(chosen, images);
            }
        }
    }
}

void setUp(void)
{
    random_state = 1U;
    cuts         = 0U;
    moves        = 0U;
    is_power_cut = false;
    memset(images, 0, sizeof images);
}

void tearDown(void)
{
}

static void every_power_cut_leaves_complete_transactions(void)
{
    unsigned long compactions = 0U;
    unsigned long full        = 0U;
    unsigned long discarded   = 0U;
    char text[120];
    is_power_cut = true;
    memset(chosen, 0, sizeof chosen);
    for (unsigned i = 0U; i < LIVES; i++) {
        recorded_clear(chosen);
        moves = i % 3U; // A commit compacts at once, or moves one or two records for each change.
        replay();
        discarded += (unsigned long)journal.stats.discarded;
        states[0]   = replayed;
        states[1]   = replayed;
        state_count = 2U;
        run_transactions();
        compactions += journal.stats.compactions;
        full += journal.stats.full;
        die_everywhere();
    }
    TEST_ASSERT_TRUE(compactions >= LIVES);
    TEST_ASSERT_TRUE((full > 0U) && (discarded > 0U));
    (void)snprintf(text, sizeof text, "%lu power cuts in %u lives with %lu compactions", cuts, LIVES,
                   compactions);
    UnityPrint(text);
    UNITY_PRINT_EOL();
}

/// A medium has octets that would be valid after a missing record. Emptying it first fails, then succeeds;
/// the record is written, and the power is cut. The journal must not accept the record together with the
/// octets after it.
static void an_area_whose_erasure_failed_is_erased_again(void)
{
    uint8_t octets[64];
    const size_t size = content(1U, octets);
    memset(chosen, 0, sizeof chosen);
    recorded_clear(chosen);
    open_journal();
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 0U, 1U, octets, size));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 0U, 2U, octets, size));
    TEST_ASSERT_EQUAL(STATUS_OK, journal_commit(&journal));
    recorded_copy(chosen, recorded.image);
    memset(&chosen[0].octets[JOURNAL_HEAD_SIZE], 0, JOURNAL_RECORD_SIZE(size));
    recorded_clear(chosen);
    const journal_configuration_t configuration = journal.configuration;
    for (unsigned i = 1U; (recorded.count == 0U) || // Until the failing call is the sync after the emptying.
                          (recorded.operations[recorded.count - 1U].kind != OPERATION_LOST) ||
                          (recorded.operations[recorded.count - 1U].medium != 0U);
         i++) {
        recorded_clear(chosen);
        recorded.fail_from = i;
        TEST_ASSERT_EQUAL(STATUS_IO, journal_open(&journal, &configuration));
    }
    open_journal();
    TEST_ASSERT_EQUAL(STATUS_OK, journal_put(&journal, 0U, 1U, octets, size));
    recorded_durable(images);
    const operation_t* const record = &recorded.operations[recorded.count - 1U];
    TEST_ASSERT_EQUAL(OPERATION_WRITE, record->kind);
    recorded_apply(record, record->size, images);
    recorded_clear(images);
    replay();
    TEST_ASSERT_EQUAL_UINT64(0U, replayed.count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_power_cut_leaves_complete_transactions);
    RUN_TEST(an_area_whose_erasure_failed_is_erased_again);
    return UNITY_END();
}
