// SPDX-License-Identifier: Apache-2.0
// Key and mark from their files: accepted files, and those refused with file, reason and next step.
#include "fsw/programs/ground_key.h"

#include "fsw/programs/file_medium.h"
#include "test/support/sealer.h"
#include "unity.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[64];
static char path[96];
static char mark[112];
static char error[GROUND_KEY_ERROR_MAX];
static ground_key_t key;

static void put(const char* const name, const void* const octets, const size_t size)
{
    (void)unlink(name);
    const int file = open(name, O_WRONLY | O_CREAT, 0600);
    TEST_ASSERT_EQUAL(size, write(file, octets, size));
    (void)close(file);
}

void setUp(void)
{
    osal_file_t file;
    (void)strcpy(directory, "/tmp/ground_key.XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    (void)snprintf(path, sizeof path, "%s/key", directory);
    (void)snprintf(mark, sizeof mark, "%s.received", path);
    put(path, sealer_key, SDLS_KEY_OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, mark));
    const medium_t medium = file_medium(&file);
    sealer_make_mark(&medium, sealer_key, 6U);
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(0, chmod(mark, 0600U));
}

void tearDown(void)
{
    (void)unlink(path);
    (void)unlink(mark);
    (void)rmdir(directory);
}

static void expect_opened(void)
{
    TEST_ASSERT_TRUE_MESSAGE(ground_key_open(&key, path, error), error);
    TEST_ASSERT_EQUAL_UINT32(6U, key.receiver.mark.session);
    ground_key_close(&key);
}

static void expect_refused(const char* const words)
{
    TEST_ASSERT_FALSE(ground_key_open(&key, path, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, path), error);
    TEST_ASSERT_FALSE(key.receiver.is_open);
}

static void a_key_file_may_contain_octets_or_digits(void)
{
    expect_opened();
    const char* const lower = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n";
    const char* const upper = "000102030405060708090A0B0C0D0E0F101112131415161718191A1B1C1D1E1F";
    put(path, lower, strlen(lower));
    expect_opened();
    put(path, lower, strlen(lower) - 1U);
    expect_opened();
    put(path, upper, strlen(upper));
    expect_opened();
}

static void a_path_without_room_for_the_path_of_the_mark_is_refused(void)
{
    static const char step[] = "/././././././././././././././././././././././././././././././././././././././"
                               "./././././././././././././././././././././././././././././././././././././.";
    char long_path[300];
    (void)snprintf(long_path, sizeof long_path, "%s%s/key", directory, step);
    while (strlen(long_path) < 247U) { // 256 with ".received" and the end: one too many.
        (void)memmove(&long_path[1], long_path, strlen(long_path) + 1U);
    }
    TEST_ASSERT_EQUAL(247U, strlen(long_path));
    TEST_ASSERT_FALSE(ground_key_open(&key, long_path, error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "key.received: the mark of the key is missing"), error);
    TEST_ASSERT_TRUE_MESSAGE(ground_key_open(&key, &long_path[1], error), error);
    ground_key_close(&key);
}

static void other_content_is_refused(void)
{
    static const char* const contents[] = {
        "",
        "000102030405060708090a0b0c0d0e0f",
        "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1g",
        "g00102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        "@00102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        "`00102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        "/00102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        ":00102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f",
        "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f0",
        "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n\n",
        "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n and more of it"};
    for (size_t i = 0U; i < (sizeof contents / sizeof contents[0]); i++) {
        if (strlen(contents[i]) != SDLS_KEY_OCTETS) {
            put(path, contents[i], strlen(contents[i]));
            expect_refused("not a key");
        }
    }
}

static void a_key_file_that_other_users_may_access_is_refused(void)
{
    static const mode_t modes[] = {0640U, 0604U, 0620U, 0602U, 0610U, 0644U};
    for (size_t i = 0U; i < (sizeof modes / sizeof modes[0]); i++) {
        TEST_ASSERT_EQUAL(0, chmod(path, modes[i]));
        expect_refused("chmod 600");
    }
    TEST_ASSERT_EQUAL(0, chmod(path, 0400U));
    expect_opened();
}

/// A program that can write the mark can set it back, and send recorded telecommands again.
static void a_mark_that_others_may_write_is_refused(void)
{
    static const mode_t modes[] = {0666U, 0660U, 0606U, 0620U, 0602U, 0644U};
    for (size_t i = 0U; i < (sizeof modes / sizeof modes[0]); i++) {
        TEST_ASSERT_EQUAL(0, chmod(mark, modes[i]));
        expect_refused(
            "key.received: other users than its owner have access to the mark of the key; run chmod 600");
    }
    TEST_ASSERT_EQUAL(0, chmod(mark, 0600U));
    expect_opened();
}

static void missing_files_are_not_made(void)
{
    TEST_ASSERT_EQUAL(0, unlink(mark));
    expect_refused("gse key make");
    TEST_ASSERT_FALSE(osal_file_exists(mark));
    TEST_ASSERT_EQUAL(0, unlink(path));
    expect_refused("gse key make");
}

static void marks_of_another_key_and_damaged_marks_are_refused(void)
{
    put(mark, "", 0U);
    expect_refused("damaged, or of another key");
    tearDown();
    setUp();
    const uint8_t other[SDLS_KEY_OCTETS] = {9U};
    put(path, other, sizeof other);
    expect_refused("damaged, or of another key");
}

static void a_receiver_that_was_open_is_closed_by_a_failure(void)
{
    expect_opened();
    TEST_ASSERT_FALSE(key.receiver.is_open);
    TEST_ASSERT_TRUE(ground_key_open(&key, path, error));
    osal_file_close(&key.mark);
    TEST_ASSERT_EQUAL(0, chmod(path, 0644U));
    expect_refused("chmod 600");
}

/// Static storage is zero when a program begins, and 0 is the descriptor of standard input.
static void a_key_that_was_never_opened_closes_no_descriptor(void)
{
    static ground_key_t fresh;
    TEST_ASSERT_EQUAL(0, unlink(path));
    const int standard_input = fcntl(STDIN_FILENO, F_GETFD);
    TEST_ASSERT_FALSE(ground_key_open(&fresh, path, error));
    TEST_ASSERT_EQUAL(standard_input, fcntl(STDIN_FILENO, F_GETFD));
    const int next = dup(STDOUT_FILENO);
    TEST_ASSERT_TRUE(next > STDERR_FILENO);
    (void)close(next);
}

static void a_key_is_used_by_one_flight_at_a_time(void)
{
    static ground_key_t first;
    TEST_ASSERT_TRUE(ground_key_open(&first, path, error));
    expect_refused("another flight");
    ground_key_close(&first);
    expect_opened();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_key_file_may_contain_octets_or_digits);
    RUN_TEST(a_path_without_room_for_the_path_of_the_mark_is_refused);
    RUN_TEST(other_content_is_refused);
    RUN_TEST(a_key_file_that_other_users_may_access_is_refused);
    RUN_TEST(a_mark_that_others_may_write_is_refused);
    RUN_TEST(missing_files_are_not_made);
    RUN_TEST(marks_of_another_key_and_damaged_marks_are_refused);
    RUN_TEST(a_receiver_that_was_open_is_closed_by_a_failure);
    RUN_TEST(a_key_that_was_never_opened_closes_no_descriptor);
    RUN_TEST(a_key_is_used_by_one_flight_at_a_time);
    return UNITY_END();
}
