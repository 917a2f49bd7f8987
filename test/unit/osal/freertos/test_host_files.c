// SPDX-License-Identifier: Apache-2.0
// Files of the machine that runs the emulator, by semihosting, in the directory in which it was started. The
// contract tests of files run on the EEPROM.
#include "osal/freertos/file_system.h"
#include "osal/include/osal/file.h"

#include "unity.h"

#include <string.h>

#define PATH "./file"
#define OTHER "other"
#define LONG_OCTETS 1300U

void setUp(void)
{
    (void)osal_file_remove(PATH);
    (void)osal_file_remove(OTHER);
}

void tearDown(void)
{
}

static void put(const char* const path, const char* const text)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_file_sync(&file)); // There is no wire to the other machine.
    osal_file_close(&file);
}

static void expect(const char* const path, const char* const text)
{
    char content[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(strlen(text), size);
    TEST_ASSERT_EQUAL_MEMORY(text, content, size);
}

static void files_are_made_extended_and_emptied(void)
{
    char content[8];
    size_t size = 0U;
    osal_file_t file;
    put(PATH, "first");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, " second", 7U));
    osal_file_close(&file);
    expect(PATH, "first second");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, OTHER)); // Made.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 3U, "x", 1U));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(OTHER, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(4U, size);
    TEST_ASSERT_EQUAL_MEMORY("\0\0\0x", content, 4U);
}

static void a_file_is_cut_and_extended(void)
{
    static uint8_t content[LONG_OCTETS];
    osal_file_t file;
    uint64_t size = 0U;
    (void)memset(content, 0x5A, sizeof content);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, content, sizeof content));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, 1100U)); // Copied in three pieces.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, LONG_OCTETS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(LONG_OCTETS, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, content, sizeof content));
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, content, 1100U);
    TEST_ASSERT_EACH_EQUAL_HEX8(0U, &content[1100], LONG_OCTETS - 1100U);
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_resize(&file, UINT64_MAX));
    TEST_ASSERT_TRUE(osal_file_is_named(&file));
    osal_file_close(&file);
    TEST_ASSERT_FALSE(osal_file_exists(PATH ".cut"));
}

static void files_are_renamed_and_removed(void)
{
    put(PATH, "old");
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_file_rename(PATH, OTHER));
    TEST_ASSERT_FALSE(osal_file_exists(PATH));
    expect(OTHER, "old");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(PATH, OTHER));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_rename(OTHER, STORED_FILES "file")); // Another medium.
    expect(OTHER, "old");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(OTHER));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_remove(OTHER));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_file_sync_names(PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync_names("no/such/file"));
}

static void missing_files_and_too_long_paths_are_refused(void)
{
    char path[400];
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_open_read(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_create(&file, "no/such/file"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_update(&file, "no/such/file"));
    (void)memset(path, 'n', sizeof path);
    path[sizeof path - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create(&file, path));
    path[FILE_SYSTEM_PATH_OCTETS - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create(&file, path)); // No room for the name of a copy.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, PATH)); // The entry is free again.
    osal_file_close(&file);
}

static void a_file_that_is_open_for_reading_is_not_written(void)
{
    osal_file_t file;
    put(PATH, "kept");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_open_read(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_write(&file, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_resize(&file, 0U));
    osal_file_close(&file);
    expect(PATH, "kept");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(files_are_made_extended_and_emptied);
    RUN_TEST(a_file_is_cut_and_extended);
    RUN_TEST(files_are_renamed_and_removed);
    RUN_TEST(missing_files_and_too_long_paths_are_refused);
    RUN_TEST(a_file_that_is_open_for_reading_is_not_written);
    return UNITY_END();
}
