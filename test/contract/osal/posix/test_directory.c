// SPDX-License-Identifier: Apache-2.0
// Order of names, symbolic links, special files and missing permissions.
#define _GNU_SOURCE
#include "osal/include/osal/directory.h"

#include "osal/include/osal/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define PATH_SIZE 512U

static char base[64];    // Directory that contains the root and, outside of it, a secret file.
static char outside[96]; // Path of the secret file.
static osal_directory_t root;
static osal_directory_about_t about;

static void put_file(const char* path, const char* text)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    osal_file_close(&file);
}

/// Returns the path by which other programs reach an entry below the root.
static const char* real(const char* path)
{
    static char whole[PATH_SIZE];
    (void)snprintf(whole, sizeof whole, "%s/root/%s", base, path);
    return whole;
}

void setUp(void)
{
    (void)snprintf(base, sizeof base, "/tmp/osal-directory-test-%d", (int)getpid());
    (void)snprintf(outside, sizeof outside, "%s/secret", base);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(real("")));
    put_file(outside, "secret");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_open(&root, real("")));
}

void tearDown(void)
{
    char command[128];
    osal_directory_close(&root);
    osal_directory_close(&root); // A second close has no effect.
    (void)snprintf(command, sizeof command, "rm -rf %s", base);
    TEST_ASSERT_EQUAL(0, system(command)); // NOLINT: a fixed command.
}

static void names_are_returned_in_order_and_in_parts(void)
{
    static const char* const names[] = {"B", "a", "a.b", "a1", "b", "z"};
    osal_directory_entry_t entries[8];
    size_t count = 9U;
    char long_name[OSAL_NAME_SIZE + 1U];
    memset(long_name, 'y', sizeof long_name);
    long_name[OSAL_NAME_SIZE] = '\0'; // One octet too long.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_list(&root, "", "", entries, 8U, &count));
    TEST_ASSERT_EQUAL_UINT64(0U, count);
    for (size_t i = 6U; i > 0U; i--) {
        put_file(real(names[i - 1U]), "x");
    }
    put_file(real(".hidden"), "x");
    put_file(real(long_name), "x");
    TEST_ASSERT_EQUAL(0, symlink("a", real("link")));
    TEST_ASSERT_EQUAL(0, mkfifo(real("pipe"), 0600));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "directory"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_list(&root, "", "", entries, 8U, &count));
    TEST_ASSERT_EQUAL_UINT64(7U, count);
    TEST_ASSERT_EQUAL_STRING("b", entries[4].name);
    TEST_ASSERT_EQUAL_STRING("directory", entries[5].name);
    TEST_ASSERT_TRUE(entries[5].is_directory);
    TEST_ASSERT_EQUAL_STRING("z", entries[6].name);
    TEST_ASSERT_FALSE(entries[6].is_directory);
    const char* after = "";
    for (size_t i = 0U; i < 4U; i++) { // Read two entries with each call.
        static char last[OSAL_NAME_SIZE];
        TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_list(&root, "", after, entries, 2U, &count));
        TEST_ASSERT_EQUAL_UINT64((i < 3U) ? 2U : 1U, count);
        if (i < 2U) {
            TEST_ASSERT_EQUAL_STRING(names[i * 2U], entries[0].name);
            TEST_ASSERT_EQUAL_STRING(names[(i * 2U) + 1U], entries[1].name);
        }
        memcpy(last, entries[count - 1U].name, sizeof last);
        after = last;
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_list(&root, "no", "", entries, 2U, &count));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_directory_list(&root, "a", "", entries, 2U, &count));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_directory_list(&root, "..", "", entries, 2U, &count));
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

static void links_and_special_files_are_treated_as_absent(void)
{
    osal_file_t file;
    char content[16];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "a"));
    put_file(real("a/file"), "x");
    TEST_ASSERT_EQUAL(0, symlink("../secret", real("out")));
    TEST_ASSERT_EQUAL(0, symlink(outside, real("absolute")));
    TEST_ASSERT_EQUAL(0, symlink("a", real("directory")));
    TEST_ASSERT_EQUAL(0, symlink("..", real("up")));
    TEST_ASSERT_EQUAL(0, symlink("nothing", real("dangling")));
    TEST_ASSERT_EQUAL(0, mkfifo(real("pipe"), 0600));
    static const char* const hostile[] = {
        "out",       "absolute", "directory",      "up",    "dangling", "pipe",
        "up/secret", "up/root",  "directory/file", "pipe/x"};
    for (size_t i = 0U; i < (sizeof hostile / sizeof hostile[0]); i++) {
        expect_refused(hostile[i], STATUS_NOT_FOUND);
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_create(&root, hostile[i]));
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_create_file(&root, hostile[i], 0U));
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_directory_rename(&root, "a/file", hostile[i]));
    }
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_directory_create_file(&root, "dangling", 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_open_read(&file, outside));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read(&file, content, sizeof content, &size));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL_UINT64(6U, size); // The file outside of the root has not changed.
    TEST_ASSERT_EQUAL_MEMORY("secret", content, 6U);
}

static void access_without_permission_is_denied(void)
{
    put_file(real("file"), "x");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(&root, "closed"));
    TEST_ASSERT_EQUAL(0, chmod(real("closed"), 0700));
    const pid_t child = fork();
    if (child == 0) {
        const bool is_dropped = (geteuid() != 0U)
                                    ? (chmod(real(""), 0500) == 0) && (chmod(real("closed"), 0) == 0)
                                    : ((setgid(65534) == 0) && (setuid(65534) == 0));
        const bool is_denied  = (osal_directory_create(&root, "new") == STATUS_DENIED) &&
                               (osal_directory_create_file(&root, "new", 0U) == STATUS_DENIED) &&
                               (osal_directory_remove_file(&root, "file") == STATUS_DENIED) &&
                               (osal_directory_rename(&root, "file", "other") == STATUS_DENIED) &&
                               (osal_directory_describe(&root, "closed/x", &about) == STATUS_DENIED);
        _exit((is_dropped && is_denied) ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, chmod(real(""), 0755));
    TEST_ASSERT_EQUAL(0, chmod(real("closed"), 0755));
    TEST_ASSERT_EQUAL(0, exit_status);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(names_are_returned_in_order_and_in_parts);
    RUN_TEST(links_and_special_files_are_treated_as_absent);
    RUN_TEST(access_without_permission_is_denied);
    return UNITY_END();
}
