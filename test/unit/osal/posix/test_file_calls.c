// SPDX-License-Identifier: Apache-2.0
// Reaction of the file port to answers of the kernel that a healthy disk does not give: interrupted calls,
// partial transfers, full disks, errors. The system calls are mocked; test/contract/osal/posix/test_file.c
// has the tests with a real disk.
#define _GNU_SOURCE
#include "osal/include/osal/file.h"

#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define DESCRIPTOR 0 // The lowest descriptor: free if standard input is closed.
#define AT 1000U
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    int error;
    status_t status;
} error_case_t;

static osal_file_t file;
static char octets[100];
static size_t size;

/// Give a mocked call its outcome: it succeeds with `result`, or fails with the error number -`result`.
static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __real_open(const char* path, int flags, ...);
int __wrap_open(const char* path, int flags, ...)
{
    if (strncmp(path, "mocked", 6U) != 0) {
        return __real_open(path, flags, 0644); // A coverage build makes such calls itself.
    }
    check_expected(flags);
    return answer(mock_type(int));
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if (descriptor != DESCRIPTOR) {
        return __real_close(descriptor);
    }
    function_called();
    return 0;
}

ssize_t __real_write(int descriptor, const void* from, size_t count);
ssize_t __wrap_write(int descriptor, const void* from, size_t count)
{
    if (descriptor != DESCRIPTOR) {
        return __real_write(descriptor, from, count);
    }
    check_expected_ptr(from);
    check_expected(count);
    return answer(mock_type(int));
}

ssize_t __real_read(int descriptor, void* to, size_t count);
ssize_t __wrap_read(int descriptor, void* to, size_t count)
{
    if (descriptor != DESCRIPTOR) {
        return __real_read(descriptor, to, count);
    }
    check_expected(count);
    return answer(mock_type(int));
}

ssize_t __wrap_pwrite(int descriptor, const void* from, size_t count, off_t offset)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected_ptr(from);
    check_expected(count);
    check_expected(offset);
    return answer(mock_type(int));
}

ssize_t __wrap_pread(int descriptor, void* to, size_t count, off_t offset)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected_ptr(to);
    check_expected(count);
    check_expected(offset);
    return answer(mock_type(int));
}

int __wrap_fstat(int descriptor, struct stat* about)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    *about = (struct stat){.st_size = 77, .st_mode = S_IFREG | S_IRUSR, .st_nlink = 0};
    return answer(mock_type(int));
}

int __wrap_ftruncate(int descriptor, off_t length)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected(length);
    return answer(mock_type(int));
}

int __wrap_posix_fallocate(int descriptor, off_t offset, off_t length)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(0, offset);
    check_expected(length);
    return mock_type(int); // The function returns the error number itself.
}

int __wrap_fsync(int descriptor)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    return answer(mock_type(int));
}

int __wrap_flock(int descriptor, int operation)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    (void)operation;
    return answer(mock_type(int));
}

int __wrap_rename(const char* path, const char* new_path)
{
    assert_string_equal("mocked/a", path);
    assert_string_equal("mocked2/b", new_path);
    return answer(mock_type(int));
}

static int set_up(void** state)
{
    (void)state;
    file.descriptor = DESCRIPTOR;
    size            = 0U;
    return 0;
}

// ---- Opening ----

static void an_interrupted_opening_is_repeated(void** state)
{
    (void)state;
    expect_value_count(__wrap_open, flags, O_RDWR | O_CREAT | O_CLOEXEC, 3);
    will_return_count(__wrap_open, -EINTR, 2);
    will_return(__wrap_open, DESCRIPTOR);
    assert_int_equal(STATUS_OK, osal_file_update(&file, "mocked"));
    assert_int_equal(DESCRIPTOR, file.descriptor);
}

static void the_reason_why_a_file_does_not_open_is_reported(void** state)
{
    static const error_case_t errors[] = {{ENOENT, STATUS_NOT_FOUND}, {ENOTDIR, STATUS_NOT_FOUND},
                                          {EACCES, STATUS_DENIED},    {EPERM, STATUS_DENIED},
                                          {EROFS, STATUS_DENIED},     {EMFILE, STATUS_IO}};
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        expect_value(__wrap_open, flags, O_RDONLY | O_CLOEXEC);
        will_return(__wrap_open, -errors[i].error);
        assert_int_equal(errors[i].status, osal_file_open_read(&file, "mocked"));
        assert_int_equal(-1, file.descriptor);
    }
}

// ---- Writing ----

static const error_case_t write_errors[] = {
    {ENOSPC, STATUS_FULL}, {EDQUOT, STATUS_FULL}, {EFBIG, STATUS_FULL}, {EIO, STATUS_IO}};

static void expect_write(const size_t done, const int result)
{
    expect_value(__wrap_write, from, &octets[done]);
    expect_value(__wrap_write, count, sizeof octets - done);
    will_return(__wrap_write, result);
}

static void partial_writes_are_continued_to_the_end(void** state)
{
    (void)state;
    expect_write(0U, -EINTR);
    expect_write(0U, 30);
    expect_write(30U, -EINTR);
    expect_write(30U, 70);
    assert_int_equal(STATUS_OK, osal_file_write(&file, octets, sizeof octets));
    for (size_t i = 0U; i < COUNT(write_errors); i++) {
        expect_write(0U, 99);
        expect_write(99U, -write_errors[i].error);
        assert_int_equal(write_errors[i].status, osal_file_write(&file, octets, sizeof octets));
    }
    // The kernel writes nothing and reports no error: the port must not retry without end.
    expect_write(0U, 0);
    assert_int_equal(STATUS_IO, osal_file_write(&file, octets, sizeof octets));
}

static void expect_write_at(const size_t done, const int result)
{
    expect_value(__wrap_pwrite, from, &octets[done]);
    expect_value(__wrap_pwrite, count, sizeof octets - done);
    expect_value(__wrap_pwrite, offset, AT + done);
    will_return(__wrap_pwrite, result);
}

static void partial_writes_at_an_offset_are_continued_to_the_end(void** state)
{
    (void)state;
    expect_write_at(0U, -EINTR);
    expect_write_at(0U, 1);
    expect_write_at(1U, 99);
    assert_int_equal(STATUS_OK, osal_file_write_at(&file, AT, octets, sizeof octets));
    for (size_t i = 0U; i < COUNT(write_errors); i++) {
        expect_write_at(0U, 99);
        expect_write_at(99U, -write_errors[i].error);
        assert_int_equal(write_errors[i].status, osal_file_write_at(&file, AT, octets, sizeof octets));
    }
    expect_write_at(0U, 0);
    assert_int_equal(STATUS_IO, osal_file_write_at(&file, AT, octets, sizeof octets));
}

static void the_reason_why_a_file_does_not_grow_is_reported(void** state)
{
    (void)state;
    for (size_t i = 0U; i < COUNT(write_errors); i++) {
        expect_value_count(__wrap_ftruncate, length, 500, 2);
        will_return(__wrap_ftruncate, -EINTR);
        will_return(__wrap_ftruncate, -write_errors[i].error);
        assert_int_equal(write_errors[i].status, osal_file_resize(&file, 500U));
        expect_value_count(__wrap_posix_fallocate, length, 500, 2);
        will_return(__wrap_posix_fallocate, EINTR);
        will_return(__wrap_posix_fallocate, write_errors[i].error);
        assert_int_equal(write_errors[i].status, osal_file_reserve(&file, 500U));
    }
    static const int unsupported[] = {EOPNOTSUPP, EINVAL};
    for (size_t i = 0U; i < COUNT(unsupported); i++) {
        expect_value(__wrap_posix_fallocate, length, 500);
        will_return(__wrap_posix_fallocate, unsupported[i]);
        assert_int_equal(STATUS_UNSUPPORTED, osal_file_reserve(&file, 500U));
    }
    // The port refuses the size without a call of the kernel.
    assert_int_equal(STATUS_FULL, osal_file_resize(&file, (uint64_t)INT64_MAX + 1U));
    assert_int_equal(STATUS_FULL, osal_file_reserve(&file, (uint64_t)INT64_MAX + 1U));
    expect_value(__wrap_ftruncate, length, INT64_MAX);
    will_return(__wrap_ftruncate, 0);
    assert_int_equal(STATUS_OK, osal_file_resize(&file, (uint64_t)INT64_MAX));
}

static void a_failed_sync_is_reported(void** state)
{
    (void)state;
    will_return(__wrap_fsync, -EIO);
    assert_int_equal(STATUS_IO, osal_file_sync(&file));
    // The port opens the directory that contains the name.
    expect_value(__wrap_open, flags, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    will_return(__wrap_open, DESCRIPTOR);
    will_return(__wrap_fsync, -EIO);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_IO, osal_file_sync_names("mocked/name"));
    expect_value(__wrap_open, flags, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    will_return(__wrap_open, -ENOENT);
    assert_int_equal(STATUS_IO, osal_file_sync_names("mocked/name"));
}

static void a_new_name_is_on_the_disk_before_the_old_one_is_gone(void** state)
{
    (void)state;
    will_return(__wrap_rename, -EACCES);
    assert_int_equal(STATUS_DENIED, osal_file_rename("mocked/a", "mocked2/b"));
    will_return(__wrap_rename, 0);
    expect_value(__wrap_open, flags, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    will_return(__wrap_open, DESCRIPTOR);
    will_return(__wrap_fsync, -EIO); // The new name may not be on the disk: the old one is kept.
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_IO, osal_file_rename("mocked/a", "mocked2/b"));
    will_return(__wrap_rename, 0);
    expect_value_count(__wrap_open, flags, O_RDONLY | O_DIRECTORY | O_CLOEXEC, 2);
    will_return_count(__wrap_open, DESCRIPTOR, 2);
    will_return(__wrap_fsync, 0);
    will_return(__wrap_fsync, -EIO);
    expect_function_calls(__wrap_close, 2);
    assert_int_equal(STATUS_IO, osal_file_rename("mocked/a", "mocked2/b"));
}

// ---- Reading ----

static void expect_read_at(const size_t done, const int result)
{
    expect_value(__wrap_pread, to, &octets[done]);
    expect_value(__wrap_pread, count, sizeof octets - done);
    expect_value(__wrap_pread, offset, AT + done);
    will_return(__wrap_pread, result);
}

static void partial_reads_are_continued_to_the_end(void** state)
{
    (void)state;
    expect_read_at(0U, -EINTR);
    expect_read_at(0U, 40);
    expect_read_at(40U, 60);
    assert_int_equal(STATUS_OK, osal_file_read_at(&file, AT, octets, sizeof octets));
    expect_read_at(0U, 99);
    expect_read_at(99U, 0);
    assert_int_equal(STATUS_TRUNCATED, osal_file_read_at(&file, AT, octets, sizeof octets));
    expect_read_at(0U, -EIO);
    assert_int_equal(STATUS_IO, osal_file_read_at(&file, AT, octets, sizeof octets));
    expect_value_count(__wrap_read, count, sizeof octets, 2);
    will_return(__wrap_read, -EINTR);
    will_return(__wrap_read, 40);
    assert_int_equal(STATUS_OK, osal_file_read(&file, octets, sizeof octets, &size));
    assert_int_equal(40U, size);
    expect_value(__wrap_read, count, sizeof octets);
    will_return(__wrap_read, -EIO);
    assert_int_equal(STATUS_IO, osal_file_read(&file, octets, sizeof octets, &size));
    assert_int_equal(0U, size);
}

static void a_file_that_fails_while_it_is_loaded_is_closed(void** state)
{
    (void)state;
    expect_value_count(__wrap_open, flags, O_RDONLY | O_CLOEXEC, 2);
    will_return_count(__wrap_open, DESCRIPTOR, 2);
    expect_value(__wrap_read, count, sizeof octets);
    will_return(__wrap_read, 40);
    expect_value(__wrap_read, count, sizeof octets - 40U);
    will_return(__wrap_read, -EIO);
    expect_function_calls(__wrap_close, 2);
    assert_int_equal(STATUS_IO, osal_file_load("mocked", octets, sizeof octets, &size));
    assert_int_equal(0U, size);
    will_return(__wrap_fstat, -EIO); // The port cannot know whether other users may read the secret.
    assert_int_equal(STATUS_IO, osal_file_load_secret("mocked", octets, sizeof octets, &size));
}

// ---- Properties of a file ----

static void a_failed_inquiry_about_a_file_is_reported(void** state)
{
    uint64_t end = 5U;
    (void)state;
    will_return(__wrap_fstat, -EIO);
    assert_int_equal(STATUS_IO, osal_file_size(&file, &end));
    assert_int_equal(0U, end);
    will_return(__wrap_fstat, 0);
    assert_int_equal(STATUS_OK, osal_file_size(&file, &end));
    assert_int_equal(77U, end);
    will_return(__wrap_fstat, -EIO);
    assert_false(osal_file_is_named(&file));
    will_return(__wrap_fstat, 0);
    assert_false(osal_file_is_named(&file)); // The file has no link left.
    will_return(__wrap_flock, -EWOULDBLOCK);
    assert_int_equal(STATUS_BUSY, osal_file_lock(&file));
    will_return(__wrap_flock, -ENOLCK);
    assert_int_equal(STATUS_IO, osal_file_lock(&file));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(an_interrupted_opening_is_repeated, set_up),
        cmocka_unit_test_setup(the_reason_why_a_file_does_not_open_is_reported, set_up),
        cmocka_unit_test_setup(partial_writes_are_continued_to_the_end, set_up),
        cmocka_unit_test_setup(partial_writes_at_an_offset_are_continued_to_the_end, set_up),
        cmocka_unit_test_setup(the_reason_why_a_file_does_not_grow_is_reported, set_up),
        cmocka_unit_test_setup(a_failed_sync_is_reported, set_up),
        cmocka_unit_test_setup(a_new_name_is_on_the_disk_before_the_old_one_is_gone, set_up),
        cmocka_unit_test_setup(partial_reads_are_continued_to_the_end, set_up),
        cmocka_unit_test_setup(a_file_that_fails_while_it_is_loaded_is_closed, set_up),
        cmocka_unit_test_setup(a_failed_inquiry_about_a_file_is_reported, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
