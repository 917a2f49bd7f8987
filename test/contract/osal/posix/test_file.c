// SPDX-License-Identifier: Apache-2.0
// Permissions of files, full disks and interruptions by signals.
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

static char directory[64];
static char path[96];

void setUp(void)
{
    (void)snprintf(directory, sizeof directory, "/tmp/osal-file-test-%d", (int)getpid());
    (void)snprintf(path, sizeof path, "%s/file", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(directory));
}

void tearDown(void)
{
    (void)unlink(path);
    (void)rmdir(directory);
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

static void a_new_file_is_written_by_its_owner_only(void)
{
    struct stat about;
    put("first", osal_file_append);
    TEST_ASSERT_EQUAL(0, stat(path, &about));
    TEST_ASSERT_EQUAL(0, about.st_mode & 0133); // 0644 at most.
    put("new", osal_file_create);
    TEST_ASSERT_EQUAL(0, stat(path, &about));
    TEST_ASSERT_EQUAL(0, about.st_mode & 0133);
}

static void a_link_replaces_an_earlier_link_but_no_file(void)
{
    char target[8] = "";
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_link("first", path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_link("second", path));
    TEST_ASSERT_EQUAL(6, readlink(path, target, sizeof target));
    TEST_ASSERT_EQUAL_STRING("second", target);
    TEST_ASSERT_EQUAL(0, unlink(path));
    put("file", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_file_link("third", path));
}

static void a_name_without_a_directory_is_in_the_working_directory(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_sync_names("file-of-this-directory"));
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

static void a_full_disk_is_reported_as_a_status(void)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&file, "/dev/full"));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_write(&file, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, "", 0U));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, "/dev/full"));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_file_write_at(&file, 0U, "x", 1U));
    osal_file_close(&file);
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
    int exit_status = -1;
    TEST_ASSERT_EQUAL(reader, waitpid(reader, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
}

static void directories_are_made_with_their_parents(void)
{
    char deep[128];
    char beneath_file[128];
    struct stat about;
    (void)snprintf(deep, sizeof deep, "%s/a/b//c/", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(deep));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create_directory(deep)); // The directory exists.
    TEST_ASSERT_EQUAL(0, stat(deep, &about));
    TEST_ASSERT_TRUE(S_ISDIR(about.st_mode));
    put("x", osal_file_create);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create_directory(path)); // A file has this name.
    (void)snprintf(beneath_file, sizeof beneath_file, "%s/a", path);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create_directory(beneath_file));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create_directory(""));
    for (int i = 0; i < 3; i++) {
        static const char* const parts[] = {"a/b/c", "a/b", "a"};
        (void)snprintf(deep, sizeof deep, "%s/%s", directory, parts[i]);
        TEST_ASSERT_EQUAL(0, rmdir(deep));
    }
}

static void access_without_permission_is_denied(void)
{
    if (geteuid() != 0U) {
        osal_file_t file;
        TEST_ASSERT_EQUAL(STATUS_DENIED, osal_file_append(&file, "/etc/passwd"));
        TEST_ASSERT_EQUAL(STATUS_DENIED, osal_file_create_directory("/osal-file-test"));
        return;
    }
    const pid_t child = fork(); // The child gives up its privilege and tries the same.
    if (child == 0) {
        osal_file_t file;
        const bool is_dropped = (setgid(65534) == 0) && (setuid(65534) == 0);
        const bool is_denied  = (osal_file_append(&file, "/etc/passwd") == STATUS_DENIED) &&
                               (osal_file_create_directory("/osal-file-test") == STATUS_DENIED) &&
                               (osal_file_remove("/etc/passwd") == STATUS_DENIED);
        _exit((is_dropped && is_denied) ? 0 : 1);
    }
    int exit_status = -1;
    TEST_ASSERT_EQUAL(child, waitpid(child, &exit_status, 0));
    TEST_ASSERT_EQUAL(0, exit_status);
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_new_file_is_written_by_its_owner_only);
    RUN_TEST(a_link_replaces_an_earlier_link_but_no_file);
    RUN_TEST(a_name_without_a_directory_is_in_the_working_directory);
    RUN_TEST(secrets_are_readable_by_their_owner_only);
    RUN_TEST(a_full_disk_is_reported_as_a_status);
    RUN_TEST(short_and_interrupted_writes_are_completed);
    RUN_TEST(directories_are_made_with_their_parents);
    RUN_TEST(reserved_room_can_be_written_to);
    RUN_TEST(access_without_permission_is_denied);
    return UNITY_END();
}
