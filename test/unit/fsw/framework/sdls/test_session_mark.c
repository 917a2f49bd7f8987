// SPDX-License-Identifier: Apache-2.0
// The session mark never decreases, whatever power cuts, damaged copies and failing disks occur.
#include "fsw/framework/sdls/session_mark.h"
#include "test/support/recorded_media.h"
#include "test/support/sealer.h"
#include "unity.h"

#include <string.h>

#define SESSIONS 6U

static const image_t empty[2];
static image_t media[2];
static sdls_session_mark_t mark;
static medium_t medium;
static uint8_t check[SESSION_MARK_CHECK];

void setUp(void)
{
    recorded_clear(empty);
    recorded.fail_from = 0U;
    medium             = recorded_medium(0U);
    sealer_key_check(sealer_key, check);
    sealer_make_mark(&medium, sealer_key, 0U);
}

void tearDown(void)
{
}

static void expect_session(const uint32_t expected)
{
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_open(&mark, &medium, check));
    TEST_ASSERT_EQUAL_UINT32(expected, mark.session);
}

static void numbers_survive_a_restart(void)
{
    expect_session(0U);
    for (uint32_t session = 1U; session <= SESSIONS; session++) {
        TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, session * 3U));
        expect_session(session * 3U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, UINT32_MAX));
    expect_session(UINT32_MAX);
}

/// While the mark stays open, each session number is written into both copies.
static void both_copies_are_updated(void)
{
    const uint8_t* const octets = recorded.image[0].octets;
    expect_session(0U);
    const size_t size = recorded.image[0].size;
    for (uint32_t session = 1U; session <= SESSIONS; session++) {
        TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, session));
        TEST_ASSERT_EQUAL_MEMORY(octets, &octets[SESSION_MARK_APART], SESSION_MARK_RECORD);
        TEST_ASSERT_EQUAL_UINT64(size, recorded.image[0].size);
    }
    expect_session(SESSIONS);
}

static void one_damaged_copy_is_repaired(void)
{
    expect_session(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, 5U));
    for (size_t octet = 0U; octet < (SESSION_MARK_APART + SESSION_MARK_RECORD); octet++) {
        recorded.image[0].octets[octet] ^= 0x10U;
        expect_session(5U); // Opening repairs the copy.
    }
    memset(recorded.image[0].octets, 0, SESSION_MARK_APART + SESSION_MARK_RECORD);
    TEST_ASSERT_EQUAL(STATUS_INVALID, sdls_session_mark_open(&mark, &medium, check));
}

static void missing_marks_and_marks_of_another_key_are_refused(void)
{
    check[0] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, sdls_session_mark_open(&mark, &medium, check));
    recorded_clear(empty);
    TEST_ASSERT_EQUAL(STATUS_INVALID, sdls_session_mark_open(&mark, &medium, check));
}

static void failures_of_the_disk_are_reported(void)
{
    expect_session(0U);
    uint32_t session = 0U;
    for (unsigned call = 1U; call <= 4U; call++) { // Write, sync, write, sync.
        recorded.calls      = 0U;
        recorded.fail_from  = call;
        recorded.fail_count = 1U;
        recorded.failure    = STATUS_IO;
        session++;
        TEST_ASSERT_EQUAL(STATUS_IO, sdls_session_mark_advance(&mark, session));
        TEST_ASSERT_TRUE(mark.session < session);
        recorded.fail_from = 0U;
        session++;
        TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, session));
        expect_session(session);
    }
    for (unsigned call = 1U; call <= 2U; call++) { // The two copies are read.
        recorded.calls     = 0U;
        recorded.fail_from = call;
        TEST_ASSERT_EQUAL(STATUS_IO, sdls_session_mark_open(&mark, &medium, check));
    }
    recorded.fail_from = 0U;
}

/// A possible state of the disk after a power cut: `size` octets of an operation are written.
static void cut(const size_t operation, const size_t size)
{
    for (size_t i = 0U; i < operation; i++) {
        recorded_apply(&recorded.operations[i], recorded.operations[i].size, media);
    }
    recorded_apply(&recorded.operations[operation], size, media);
}

/// After a power cut within any operation, the mark has the session number that was being stored, or the
/// number before it.
static void power_cuts_keep_a_valid_mark(void)
{
    static operation_t operations[OPERATIONS_MAX];
    static image_t start[2];
    static uint8_t data[4096];
    expect_session(0U);
    recorded_copy(start, recorded.image);
    recorded_clear(start);
    medium = recorded_medium(0U);
    for (uint32_t session = 1U; session <= SESSIONS; session++) {
        recorded.mark = session;
        TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_advance(&mark, session));
    }
    const size_t count = recorded.count;
    TEST_ASSERT_EQUAL(4U * SESSIONS, count);
    TEST_ASSERT_TRUE(recorded.data_size <= sizeof data);
    memcpy(operations, recorded.operations, count * sizeof operations[0]);
    memcpy(data, recorded.data, recorded.data_size);
    for (size_t at = 0U; at < count; at++) {
        for (size_t size = 0U; size <= operations[at].size; size++) {
            recorded_copy(media, start);
            memcpy(recorded.operations, operations, count * sizeof operations[0]);
            memcpy(recorded.data, data, sizeof data);
            cut(at, size);
            recorded_clear(media);
            const uint32_t begun = operations[at].mark;
            TEST_ASSERT_EQUAL(STATUS_OK, sdls_session_mark_open(&mark, &medium, check));
            TEST_ASSERT_TRUE((mark.session == begun) || (mark.session == (begun - 1U)));
            const uint32_t found = mark.session;
            memset(recorded.image[0].octets, 0,
                   SESSION_MARK_RECORD); // Either copy alone contains the number.
            expect_session(found);
            memset(&recorded.image[0].octets[SESSION_MARK_APART], 0, SESSION_MARK_RECORD);
            expect_session(found);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(numbers_survive_a_restart);
    RUN_TEST(both_copies_are_updated);
    RUN_TEST(one_damaged_copy_is_repaired);
    RUN_TEST(missing_marks_and_marks_of_another_key_are_refused);
    RUN_TEST(failures_of_the_disk_are_reported);
    RUN_TEST(power_cuts_keep_a_valid_mark);
    return UNITY_END();
}
