// SPDX-License-Identifier: Apache-2.0
// Files, for each port with a file store. posix/test_file.c tests permissions, full disks and signals.
#include "osal/include/osal/file.h"

#include "osal/include/osal/directory.h"
#include "osal/include/osal/process.h"
#include "test/support/directory.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static char directory[64];
static bool has_directories;
static char path[96];
static char nowhere[96]; // A path in a directory that does not exist.

void setUp(void)
{
    (void)snprintf(directory, sizeof directory, TEST_DIRECTORY "/osal-file-contract-%d",
                   (int)osal_process_own_id());
    const status_t status = osal_file_create_directory(directory);
    has_directories       = (status != STATUS_UNSUPPORTED);
    TEST_ASSERT_EQUAL(has_directories ? STATUS_OK : STATUS_UNSUPPORTED, status);
    (void)snprintf(path, sizeof path, "%s%sfile", directory, has_directories ? "/" : "-");
    (void)snprintf(nowhere, sizeof nowhere, "%s/no/such/file", directory);
    (void)osal_file_remove(path);
}

void tearDown(void)
{
    osal_directory_t above;
    (void)osal_file_remove(path);
    if (has_directories) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&above, TEST_DIRECTORY));
        TEST_ASSERT_EQUAL(STATUS_OK,
                          osal_directory_remove(&above, &directory[sizeof(TEST_DIRECTORY "/") - 1U]));
        osal_directory_close(&above);
    }
}

/// A port that cannot force a file to its medium returns STATUS_UNSUPPORTED.
static void expect_forced(const status_t status)
{
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_UNSUPPORTED));
}

static void put(const char* text, status_t (*open_it)(osal_file_t* file, const char* path))
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, open_it(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    expect_forced(osal_file_sync(&file));
    osal_file_close(&file);
    osal_file_close(&file); // A second close has no effect.
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync(&file));
}

static void assert_content(const char* expected)
{
    char content[64] = "";
    size_t size      = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(strlen(expected), size);
    TEST_ASSERT_EQUAL_MEMORY(expected, content, size);
}

static void create_empties_a_file_and_append_adds_to_it(void)
{
    put("first", osal_file_append); // Made if missing.
    put(" second", osal_file_append);
    assert_content("first second");
    put("new", osal_file_create);
    assert_content("new");
}

static void a_file_is_read_in_parts_up_to_its_end(void)
{
    char part[4];
    size_t size = 0U;
    osal_file_t file;
    put("0123456789", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_open_read(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read(&file, part, sizeof part, &size));
    TEST_ASSERT_EQUAL(4U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read(&file, part, sizeof part, &size));
    TEST_ASSERT_EQUAL_MEMORY("4567", part, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read(&file, part, sizeof part, &size));
    TEST_ASSERT_EQUAL(2U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read(&file, part, sizeof part, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_write(&file, "x", 1U)); // Open for reading only.
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_read(&file, part, sizeof part, &size)); // The file is closed.
}

static void a_file_is_loaded_only_if_it_fits(void)
{
    char content[10];
    size_t size = 7U;
    put("0123456789", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, 10U, &size)); // The content fits exactly.
    TEST_ASSERT_EQUAL(10U, size);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_file_load(path, content, 9U, &size));
    TEST_ASSERT_EQUAL(0U, size);
    put("", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, 10U, &size));
    TEST_ASSERT_EQUAL(0U, size);
    if (has_directories) {
        TEST_ASSERT_EQUAL(STATUS_IO, osal_file_load(directory, content, 10U, &size));
    }
}

static void operations_on_missing_files_report_not_found(void)
{
    char content[8];
    size_t size = 0U;
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_open_read(&file, path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_remove(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_create(&file, nowhere));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_append(&file, nowhere));
    put("x", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_open_read(&file, path));
}

static void update_reads_and_writes_anywhere(void)
{
    char part[8];
    uint64_t size = 9U;
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path)); // The file is made.
    expect_forced(osal_file_sync_names(path));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync_names(nowhere));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, osal_file_read_at(&file, 0U, part, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, part, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 4U, "efgh", 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 1U, "bc", 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 1U, "", 0U));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path)); // The content is kept.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(8U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, part, 8U));
    TEST_ASSERT_EQUAL_MEMORY("\0bc\0efgh", part, 8U);
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, osal_file_read_at(&file, 5U, part, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 5U, part, 3U));
    TEST_ASSERT_EQUAL_MEMORY("fgh", part, 3U);
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_read_at(&file, 0U, part, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_write_at(&file, 0U, part, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_resize(&file, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_update(&file, nowhere));
    if (has_directories) {
        TEST_ASSERT_EQUAL(STATUS_IO, osal_file_update(&file, directory));
    }
}

static void resize_cuts_and_extends_with_zeros(void)
{
    osal_file_t file;
    put("abcdef", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, 3U));
    assert_content("abc");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, 5U));
    char part[5];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, part, 5U));
    TEST_ASSERT_EQUAL_MEMORY("abc\0\0", part, 5U);
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_resize(&file, UINT64_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, 0U));
    uint64_t size = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    osal_file_close(&file);
}

static void a_lock_keeps_others_out_until_the_file_is_closed(void)
{
    osal_file_t first;
    osal_file_t second;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&first, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&second, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_lock(&first));
    TEST_ASSERT_EQUAL(STATUS_BUSY, osal_file_lock(&second));
    osal_file_close(&first);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_lock(&second));
    osal_file_close(&second);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_lock(&second));
}

static void rename_replaces_the_target(void)
{
    char other[128];
    (void)snprintf(other, sizeof other, "%s%sother", directory, has_directories ? "/" : "-");
    put("old", osal_file_create);
    expect_forced(osal_file_rename(path, other));
    TEST_ASSERT_FALSE(osal_file_exists(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(path, other));
    put("new", osal_file_create);
    expect_forced(osal_file_rename(other, path));
    assert_content("old");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(path, nowhere));
    if (has_directories) {
        TEST_ASSERT_EQUAL(STATUS_IO, osal_file_rename(path, directory));
    }
    assert_content("old");
}

static void a_file_reports_whether_it_still_has_a_name(void)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&file, path));
    TEST_ASSERT_TRUE(osal_file_is_named(&file));
    TEST_ASSERT_GREATER_OR_EQUAL_INT(0, osal_file_descriptor(&file));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
    TEST_ASSERT_FALSE(osal_file_is_named(&file));
    osal_file_close(&file);
    TEST_ASSERT_FALSE(osal_file_is_named(&file));
    TEST_ASSERT_EQUAL_INT(-1, osal_file_descriptor(&file));
}

static void directories_are_made_with_their_parents(void)
{
    char deep[128];
    osal_directory_t root;
    if (!has_directories) {
        TEST_IGNORE_MESSAGE("this port has no directories");
    }
    (void)snprintf(deep, sizeof deep, "%s/a/b//c/", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(deep));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(deep)); // The directory exists.
    (void)snprintf(deep, sizeof deep, "%s/a/b/c", directory);
    TEST_ASSERT_TRUE(osal_file_exists(deep));
    put("x", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create_directory(path)); // A file has this name.
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create_directory(""));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&root, directory));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(&root, "a/b/c"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(&root, "a/b"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(&root, "a"));
    osal_directory_close(&root);
}

static void reserved_room_is_part_of_the_file(void)
{
    osal_file_t file;
    uint64_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path));
    const status_t status = osal_file_reserve(&file, 1000U);
    if (status == STATUS_UNSUPPORTED) {
        osal_file_close(&file);
        TEST_IGNORE_MESSAGE("this store cannot reserve room");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(1000U, size);
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_reserve(&file, UINT64_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 999U, "x", 1U));
    osal_file_close(&file);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(create_empties_a_file_and_append_adds_to_it);
    RUN_TEST(a_file_is_read_in_parts_up_to_its_end);
    RUN_TEST(a_file_is_loaded_only_if_it_fits);
    RUN_TEST(operations_on_missing_files_report_not_found);
    RUN_TEST(update_reads_and_writes_anywhere);
    RUN_TEST(resize_cuts_and_extends_with_zeros);
    RUN_TEST(a_lock_keeps_others_out_until_the_file_is_closed);
    RUN_TEST(rename_replaces_the_target);
    RUN_TEST(a_file_reports_whether_it_still_has_a_name);
    RUN_TEST(directories_are_made_with_their_parents);
    RUN_TEST(reserved_room_is_part_of_the_file);
    return UNITY_END();
}
