// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/file.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

static char folder[64];
static char path[96];

void setUp(void)
{
    (void)snprintf(folder, sizeof folder, "/tmp/osal-file-test-%d", (int)getpid());
    (void)snprintf(path, sizeof path, "%s/file", folder);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(folder));
}

void tearDown(void)
{
    (void)unlink(path);
    (void)rmdir(folder);
}

static void put(const char* text, status_t (*open_it)(osal_file_t* file, const char* path))
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, open_it(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync(&file));
    osal_file_close(&file);
    osal_file_close(&file); // A second close has no effect.
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
    struct stat about;
    put("first", osal_file_append); // Made if missing.
    put(" second", osal_file_append);
    assert_content("first second");
    put("new", osal_file_create);
    assert_content("new");
    TEST_ASSERT_EQUAL(0, stat(path, &about));
    TEST_ASSERT_EQUAL(0, about.st_mode & 0133); // 0644 at most.
}

static void read_in_parts_up_to_the_end(void)
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
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_read(&file, part, sizeof part, &size)); // Closed.
}

static void load_has_bounds(void)
{
    char content[10];
    size_t size = 7U;
    put("0123456789", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, 10U, &size)); // Fits exactly.
    TEST_ASSERT_EQUAL(10U, size);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_file_load(path, content, 9U, &size));
    TEST_ASSERT_EQUAL(0U, size);
    put("", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, 10U, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_load(folder, content, 10U, &size)); // A folder.
}

static void secrets_are_readable_by_their_owner_only(void)
{
    char content[10];
    size_t size = 0U;
    put("secret", osal_file_create);
    TEST_ASSERT_EQUAL(0, chmod(path, 0640));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, osal_file_load_secret(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(0, chmod(path, 0601));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, osal_file_load_secret(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(0, chmod(path, 0600));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load_secret(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(6U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_load_secret(path, content, sizeof content, &size));
}

static void operations_on_missing_files_report_not_found(void)
{
    char content[8];
    size_t size = 0U;
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_open_read(&file, path));
    TEST_ASSERT_EQUAL(-1, file.descriptor);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_remove(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_create(&file, "/tmp/no/such/folder/file"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_append(&file, "/tmp/no/such/folder/file"));
    put("x", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_open_read(&file, path));
}

static void full_disk_is_a_status(void)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&file, "/dev/full"));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_write(&file, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, "", 0U));
    osal_file_close(&file);
}

static void update_reads_and_writes_anywhere(void)
{
    char part[8];
    uint64_t size = 9U;
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path)); // Made.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync_names(path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync_names("file-of-this-folder"));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync_names("/tmp/no/such/folder/file"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, osal_file_read_at(&file, 0U, part, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, part, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 4U, "efgh", 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 1U, "bc", 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 1U, "", 0U));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path)); // Kept.
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
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_update(&file, "/tmp/no/such/folder/file"));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_update(&file, folder));
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
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, "/dev/full"));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_write_at(&file, 0U, "x", 1U));
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
    (void)snprintf(other, sizeof other, "%s/other", folder);
    put("old", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_rename(path, other));
    TEST_ASSERT_FALSE(osal_file_exists(path));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(path, other));
    put("new", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_rename(other, path));
    assert_content("old");
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(path, "/tmp/no/such/folder/file"));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_rename(path, folder));
    assert_content("old");
}

static void ignore_it(int number)
{
    (void)number;
}

/// A pipe takes a large block in small parts: the write must continue until all is written, despite
/// interrupts.
static void short_and_interrupted_writes_are_completed(void)
{
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    static char block[1000000];
    int ends[2];
    TEST_ASSERT_EQUAL(0, pipe(ends));
    const pid_t reader = fork();
    if (reader == 0) {
        size_t total = 0U;
        ssize_t size = 0;
        (void)close(ends[1]);
        (void)usleep(20000U); // The writer sleeps on the full pipe meanwhile.
        do {
            size = read(ends[0], block, 1000U);
            total += (size_t)((size > 0) ? size : 0);
        } while (size > 0);
        _exit((total == sizeof block) ? 0 : 1);
    }
    (void)close(ends[0]);
    osal_file_t file = {ends[1]};
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, block, sizeof block));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
    osal_file_close(&file);
    int how = -1;
    TEST_ASSERT_EQUAL(reader, waitpid(reader, &how, 0));
    TEST_ASSERT_EQUAL(0, how);
}

static void folders_with_parents(void)
{
    char deep[128];
    char beneath_file[128];
    struct stat about;
    (void)snprintf(deep, sizeof deep, "%s/a/b//c/", folder);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(deep));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_directory_create(deep)); // The folder exists.
    TEST_ASSERT_EQUAL(0, stat(deep, &about));
    TEST_ASSERT_TRUE(S_ISDIR(about.st_mode));
    put("x", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_directory_create(path)); // A file has this name.
    (void)snprintf(beneath_file, sizeof beneath_file, "%s/a", path);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_directory_create(beneath_file));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_directory_create(""));
    for (int i = 0; i < 3; i++) {
        static const char* const parts[] = {"a/b/c", "a/b", "a"};
        (void)snprintf(deep, sizeof deep, "%s/%s", folder, parts[i]);
        TEST_ASSERT_EQUAL(0, rmdir(deep));
    }
}

static void no_privilege_is_denied(void)
{
    if (geteuid() != 0U) {
        osal_file_t file;
        TEST_ASSERT_EQUAL(STATUS_DENIED, osal_file_append(&file, "/etc/passwd"));
        TEST_ASSERT_EQUAL(STATUS_DENIED, osal_directory_create("/osal-file-test"));
        return;
    }
    const pid_t child = fork(); // The same as a user without rights.
    if (child == 0) {
        osal_file_t file;
        const bool is_dropped = (setgid(65534) == 0) && (setuid(65534) == 0);
        const bool is_denied  = (osal_file_append(&file, "/etc/passwd") == STATUS_DENIED) &&
                               (osal_directory_create("/osal-file-test") == STATUS_DENIED) &&
                               (osal_file_remove("/etc/passwd") == STATUS_DENIED);
        _exit((is_dropped && is_denied) ? 0 : 1);
    }
    int how = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &how, 0));
    TEST_ASSERT_EQUAL(0, how);
}

static void reserved_room_can_be_written_to(void)
{
    osal_file_t file;
    uint64_t size = 0U;
    struct rlimit limit;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_reserve(&file, 10000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(10000U, size);
    struct stat about;
    TEST_ASSERT_EQUAL(0, stat(path, &about));
    TEST_ASSERT_TRUE((about.st_blocks * 512) >= 10000);
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_reserve(&file, UINT64_MAX));
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_FSIZE, &limit));
    const rlim_t before = limit.rlim_cur;
    limit.rlim_cur      = 20000U;
    (void)signal(SIGXFSZ, SIG_IGN);
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_FSIZE, &limit));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_reserve(&file, 30000U));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_write_at(&file, 20000U, "x", 1U));
    limit.rlim_cur = before;
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_FSIZE, &limit));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, "/dev/null"));
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, osal_file_reserve(&file, 1U));
    osal_file_close(&file);
}

static void file_without_a_name_is_known(void)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&file, path));
    TEST_ASSERT_TRUE(osal_file_is_named(&file));
    TEST_ASSERT_EQUAL(0, unlink(path));
    TEST_ASSERT_FALSE(osal_file_is_named(&file));
    osal_file_close(&file);
    TEST_ASSERT_FALSE(osal_file_is_named(&file));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(create_empties_a_file_and_append_adds_to_it);
    RUN_TEST(read_in_parts_up_to_the_end);
    RUN_TEST(load_has_bounds);
    RUN_TEST(secrets_are_readable_by_their_owner_only);
    RUN_TEST(operations_on_missing_files_report_not_found);
    RUN_TEST(update_reads_and_writes_anywhere);
    RUN_TEST(resize_cuts_and_extends_with_zeros);
    RUN_TEST(a_lock_keeps_others_out_until_the_file_is_closed);
    RUN_TEST(rename_replaces_the_target);
    RUN_TEST(full_disk_is_a_status);
    RUN_TEST(short_and_interrupted_writes_are_completed);
    RUN_TEST(folders_with_parents);
    RUN_TEST(reserved_room_can_be_written_to);
    RUN_TEST(file_without_a_name_is_known);
    RUN_TEST(no_privilege_is_denied);
    return UNITY_END();
}
