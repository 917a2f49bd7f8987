// SPDX-License-Identifier: Apache-2.0
// A tree of files, for each port with a file store. posix/test_directory.c tests links, special files and
// permissions.
#include "osal/include/osal/directory.h"

#include "osal/include/osal/file.h"
#include "osal/include/osal/process.h"
#include "test/support/directory.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define PATH_SIZE 512U
#define FILES 300U
#define LEVELS_MAX 8U

static char base[64]; // Contains the root.
static osal_directory_t root;
static osal_directory_about_t about;

static void put_file(const char* path, const char* text)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create_file(&root, path, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_write(&root, path, 0U, (const uint8_t*)text, strlen(text)));
}

/// Returns the path in the file system of an entry whose path begins at the root.
static const char* real(const char* path)
{
    static char whole[PATH_SIZE];
    (void)snprintf(whole, sizeof whole, "%s/root/%s", base, path);
    return whole;
}

/// Remove the directory `path` of `tree` with all that it contains.
static void clear(const osal_directory_t* tree, const char* path)
{
    char directories[LEVELS_MAX][PATH_SIZE];
    size_t level = 0U;
    (void)snprintf(directories[0], PATH_SIZE, "%s", path);
    for (;;) {
        osal_directory_entry_t entry;
        size_t count = 0U;
        char name[PATH_SIZE + OSAL_NAME_SIZE];
        TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_list(tree, directories[level], "", &entry, 1U, &count));
        (void)snprintf(name, sizeof name, "%s/%s", directories[level], entry.name);
        if (count == 0U) {
            TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(tree, directories[level]));
            if (level == 0U) {
                return;
            }
            level--;
        } else if (entry.is_directory) {
            TEST_ASSERT_TRUE((level + 1U < LEVELS_MAX) && (strlen(name) < PATH_SIZE));
            level++;
            memcpy(directories[level], name, PATH_SIZE);
        } else {
            TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove_file(tree, name));
        }
    }
}

void setUp(void)
{
    (void)snprintf(base, sizeof base, TEST_DIRECTORY "/osal-directory-contract-%d",
                   (int)osal_process_own_id());
    const status_t status = osal_file_create_directory(real(""));
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has no directories");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&root, real("")));
}

void tearDown(void)
{
    osal_directory_t above;
    osal_directory_close(&root);
    osal_directory_close(&root); // A second close has no effect.
    if (!osal_file_exists(real(""))) {
        return;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&above, TEST_DIRECTORY));
    clear(&above, &base[sizeof TEST_DIRECTORY "/" - 1U]);
    osal_directory_close(&above);
}

static void expect_content(const char* path, const char* expected)
{
    uint8_t content[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_read(&root, path, 0U, content, sizeof content, &size));
    TEST_ASSERT_EQUAL_UINT64(strlen(expected), size);
    TEST_ASSERT_EQUAL_MEMORY(expected, content, size);
}

static void files_are_made_written_read_and_removed(void)
{
    uint8_t content[8];
    size_t size = 9U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create_file(&root, "file", 100000U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_create_file(&root, "file", 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_describe(&root, "file", &about));
    TEST_ASSERT_FALSE(about.is_directory);
    TEST_ASSERT_EQUAL_UINT64(0U, about.size); // Reserved room is no content.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_read(&root, "file", 0U, content, 8U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_write(&root, "file", 0U, (const uint8_t*)"abcdef", 6U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_write(&root, "file", 6U, (const uint8_t*)"ghij", 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_sync(&root, "file"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_read(&root, "file", 4U, content, 4U, &size));
    TEST_ASSERT_EQUAL_UINT64(4U, size);
    TEST_ASSERT_EQUAL_MEMORY("efgh", content, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_read(&root, "file", 8U, content, 4U, &size));
    TEST_ASSERT_EQUAL_UINT64(2U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_read(&root, "file", 11U, content, 4U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_describe(&root, "file", &about));
    TEST_ASSERT_EQUAL_UINT64(10U, about.size);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_remove(&root, "file")); // It is not a directory.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove_file(&root, "file"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_remove_file(&root, "file"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_describe(&root, "file", &about));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_write(&root, "file", 0U, content, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_sync(&root, "file"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_read(&root, "file", 0U, content, 1U, &size));
}

static void more_room_than_the_disk_has_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_directory_create_file(&root, "file", 1ULL << 60U));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_directory_create_file(&root, "file", UINT64_MAX));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_describe(&root, "file", &about));
}

static void directories_are_made_and_removed_when_empty(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_describe(&root, "", &about));
    TEST_ASSERT_TRUE(about.is_directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a"));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_create(&root, "a"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_describe(&root, "a", &about));
    TEST_ASSERT_TRUE(about.is_directory);
    TEST_ASSERT_EQUAL_UINT64(0U, about.size);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_create(&root, "b/c"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a/b"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create_file(&root, "a/b/file", 0U));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_create_file(&root, "a/b", 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_create_file(&root, "a/b/file/x", 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_remove_file(&root, "a/b"));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, osal_directory_remove(&root, "a/b"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove_file(&root, "a/b/file"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(&root, "a/b"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove(&root, "a"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_remove(&root, "a"));
}

static void renaming_replaces_nothing(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "b"));
    put_file("a/file", "first");
    put_file("b/file", "second");
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_rename(&root, "a/file", "b/file"));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_rename(&root, "a", "b"));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_rename(&root, "a/file", "b"));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_rename(&root, "a/file", "a/file"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_rename(&root, "a/file", "b/other"));
    expect_content("b/other", "first");
    expect_content("b/file", "second");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_rename(&root, "a/file", "b/new"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_rename(&root, "b/other", "c/other"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_rename(&root, "b", "a/b"));
    expect_content("a/b/other", "first");
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_rename(&root, "a", "a/b/c"));
}

static unsigned number_of(const char* digits)
{
    unsigned number = 0U;
    for (const char* at = digits; *at != '\0'; at++) {
        number = (10U * number) + (unsigned)(*at - '0');
    }
    return number;
}

/// More entries than a system may report at once.
static void long_directories_are_listed_whole(void)
{
    static char after[OSAL_NAME_SIZE];
    osal_directory_entry_t entries[7];
    size_t count = 7U;
    unsigned all = 0U;
    for (unsigned i = 0U; i < FILES; i++) {
        char name[48];
        (void)snprintf(name, sizeof name, "a-name-of-some-length-%03u", (i * 7U) % FILES);
        put_file(name, "");
    }
    after[0] = '\0';
    while (count == 7U) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_list(&root, "", after, entries, 7U, &count));
        for (size_t i = 0U; i < count; i++) {
            TEST_ASSERT_EQUAL_UINT32(all, number_of(&entries[i].name[22]));
            all++;
        }
        memcpy(after, entries[(count > 0U) ? (count - 1U) : 0U].name, sizeof after);
    }
    TEST_ASSERT_EQUAL_UINT32(FILES, all);
}

/// Each call must refuse the path with this status.
static void expect_refused(const char* path, status_t expected)
{
    osal_directory_entry_t entries[2];
    uint8_t octet = 0U;
    size_t size   = 0U;
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_describe(&root, path, &about), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_read(&root, path, 0U, &octet, 1U, &size), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_write(&root, path, 0U, &octet, 1U), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_sync(&root, path), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_remove_file(&root, path), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_remove(&root, path), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_list(&root, path, "", entries, 2U, &size), path);
    TEST_ASSERT_EQUAL_MESSAGE(expected, osal_directory_rename(&root, path, "new"), path);
}

static void hostile_paths_are_refused(void)
{
    static const char* const hostile[] = {
        ".",      "..",      "../secret",      "/",       "//",  "/etc/passwd", "a/../../secret", "a/..",
        "a/.",    "./a",     "a//file",        "a/",      "/a",  "a/./file",    "..//secret",     "../",
        "a/../a", "a/b/../", "a/file/../file", "../root", ".//",
    };
    char longest[OSAL_NAME_SIZE + 1U];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a/b"));
    put_file("a/file", "x");
    for (size_t i = 0U; i < (sizeof hostile / sizeof hostile[0]); i++) {
        osal_directory_about_t unused;
        const status_t first = osal_directory_describe(&root, hostile[i], &unused);
        // A file in the place of a directory is detected before the dots after it.
        TEST_ASSERT_TRUE_MESSAGE((first == STATUS_INVALID) || (first == STATUS_NOT_FOUND), hostile[i]);
        expect_refused(hostile[i], first);
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_create(&root, hostile[i]));
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_create_file(&root, hostile[i], 0U));
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_rename(&root, "a/file", hostile[i]));
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_create(&root, ""));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_remove(&root, ""));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_create_file(&root, "", 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_rename(&root, "", "b"));
    memset(longest, 'n', sizeof longest);
    longest[OSAL_NAME_SIZE] = '\0';
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_create_file(&root, longest, 0U));
    longest[OSAL_NAME_SIZE - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create_file(&root, longest, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_remove_file(&root, longest));
}

static void a_missing_root_directory_is_reported(void)
{
    osal_directory_t other;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_open(&other, real("no")));
    put_file("file", "x");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_open(&other, real("file")));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(files_are_made_written_read_and_removed);
    RUN_TEST(more_room_than_the_disk_has_is_refused);
    RUN_TEST(directories_are_made_and_removed_when_empty);
    RUN_TEST(renaming_replaces_nothing);
    RUN_TEST(long_directories_are_listed_whole);
    RUN_TEST(hostile_paths_are_refused);
    RUN_TEST(a_missing_root_directory_is_reported);
    return UNITY_END();
}
