// SPDX-License-Identifier: Apache-2.0
// Opening of files in a directory when system calls are interrupted or fail, and closing. The calls are
// mocked and return the lowest descriptor; test/contract/osal has the tests with real directories.
#define _GNU_SOURCE
#include "osal/include/osal/device.h"
#include "osal/include/osal/directory.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/socket.h"

#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#define ROOT 5
#define DESCRIPTOR 0 // Free if standard input is closed.
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

static const osal_directory_t root = {ROOT};

static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_openat(int directory, const char* name, int flags, mode_t mode)
{
    (void)mode;
    assert_int_equal(O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, flags & (O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    check_expected(directory);
    check_expected_ptr(name);
    return answer(mock_type(int));
}

int __wrap_fstatat(int directory, const char* name, struct stat* out_about, int flags)
{
    assert_int_equal(DESCRIPTOR, directory);
    assert_string_equal("file", name);
    assert_int_equal(AT_SYMLINK_NOFOLLOW, flags);
    *out_about = (struct stat){.st_mode = S_IFREG, .st_size = 12};
    return answer(mock_type(int));
}

int __wrap_fstat(int descriptor, struct stat* out_about)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    *out_about = (struct stat){.st_mode = mock_type(mode_t)};
    return answer(mock_type(int));
}

int __wrap_fallocate(int descriptor, int mode, off_t offset, off_t length)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(FALLOC_FL_KEEP_SIZE, mode);
    assert_int_equal(0, offset);
    check_expected(length);
    return answer(mock_type(int));
}

int __wrap_unlinkat(int directory, const char* name, int flags)
{
    assert_int_equal(DESCRIPTOR, directory);
    assert_string_equal("file", name);
    assert_int_equal(0, flags);
    function_called();
    return 0;
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if (descriptor != DESCRIPTOR) {
        return __real_close(descriptor); // A coverage build makes such calls itself.
    }
    function_called();
    return 0;
}

static void expect_open(const int directory, const char* const name, const int result)
{
    expect_value(__wrap_openat, directory, directory);
    expect_string(__wrap_openat, name, name);
    will_return(__wrap_openat, result);
}

static void an_interrupted_open_is_repeated_and_descriptor_0_is_valid(void** state)
{
    osal_directory_about_t about = {.size = 0U};
    (void)state;
    expect_open(ROOT, ".", -EINTR);
    expect_open(ROOT, ".", -EINTR);
    expect_open(ROOT, ".", DESCRIPTOR);
    will_return(__wrap_fstatat, 0);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_OK, osal_directory_describe(&root, "file", &about));
    assert_int_equal(12U, about.size);
    assert_false(about.is_directory);
}

static void a_directory_that_does_not_open_is_reported_and_none_stays_open(void** state)
{
    static const struct {
        int error;
        status_t status;
    } errors[] = {{ENOENT, STATUS_NOT_FOUND}, {ENOTDIR, STATUS_NOT_FOUND}, {ELOOP, STATUS_NOT_FOUND},
                  {ENXIO, STATUS_NOT_FOUND},  {EACCES, STATUS_DENIED},     {EROFS, STATUS_DENIED},
                  {EMFILE, STATUS_IO}};
    osal_directory_about_t about;
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        expect_open(ROOT, ".", -errors[i].error);
        assert_int_equal(errors[i].status, osal_directory_describe(&root, "file", &about));
        expect_open(ROOT, ".", DESCRIPTOR);
        expect_open(DESCRIPTOR, "directory", -errors[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(errors[i].status, osal_directory_describe(&root, "directory/file", &about));
    }
}

/// A disk can have no room for the name of a file although it has room for octets: no inode is left.
static void a_file_for_which_the_disk_has_no_room_is_not_created(void** state)
{
    static const struct {
        int error;
        status_t status;
    } errors[] = {{ENOSPC, STATUS_FULL}, {EDQUOT, STATUS_FULL}, {EEXIST, STATUS_EXISTS}, {EIO, STATUS_IO}};
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        expect_open(ROOT, ".", DESCRIPTOR);
        expect_open(DESCRIPTOR, "file", -errors[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(errors[i].status, osal_directory_create_file(&root, "file", 0U));
    }
}

static void a_file_without_the_whole_reserved_room_is_removed(void** state)
{
    static const uint64_t rooms[] = {1U, 4096U, INT64_MAX};
    (void)state;
    for (size_t i = 0U; i < COUNT(rooms); i++) {
        expect_open(ROOT, ".", DESCRIPTOR);
        expect_open(DESCRIPTOR, "file", DESCRIPTOR);
        expect_value(__wrap_fallocate, length, rooms[i]);
        will_return(__wrap_fallocate, -ENOSPC);
        expect_function_call(__wrap_close);
        expect_function_call(__wrap_unlinkat);
        expect_function_call(__wrap_close); // The directory.
        assert_int_equal(STATUS_FULL, osal_directory_create_file(&root, "file", rooms[i]));
    }
}

static void the_reason_why_a_file_cannot_be_described_is_reported(void** state)
{
    static const struct {
        int error;
        status_t status;
    } errors[] = {{ENOENT, STATUS_NOT_FOUND}, {EACCES, STATUS_DENIED}, {EIO, STATUS_IO}};
    osal_directory_about_t about;
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        expect_open(ROOT, ".", DESCRIPTOR);
        will_return(__wrap_fstatat, -errors[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(errors[i].status, osal_directory_describe(&root, "file", &about));
    }
}

/// Between its description and its opening another process can replace a file.
static void what_was_opened_and_is_no_file_is_closed(void** state)
{
    static const struct {
        mode_t mode;
        int result;
    } rows[] = {{S_IFIFO, 0}, {S_IFREG, -EIO}};
    (void)state;
    for (size_t i = 0U; i < COUNT(rows); i++) {
        expect_open(ROOT, ".", DESCRIPTOR);
        will_return(__wrap_fstatat, 0);
        expect_open(DESCRIPTOR, "file", DESCRIPTOR);
        expect_function_call(__wrap_close); // The directory.
        will_return(__wrap_fstat, rows[i].mode);
        will_return(__wrap_fstat, rows[i].result);
        expect_function_call(__wrap_close); // What was opened.
        assert_int_equal(STATUS_NOT_FOUND, osal_directory_sync(&root, "file"));
    }
}

static void each_kind_of_file_is_closed_once_also_descriptor_0(void** state)
{
    osal_directory_t directory = {DESCRIPTOR};
    osal_file_t file           = {DESCRIPTOR};
    osal_device_t device       = {DESCRIPTOR, false};
    osal_socket_t socket       = {.descriptor = DESCRIPTOR};
    (void)state;
    expect_function_calls(__wrap_close, 4);
    for (unsigned i = 0U; i < 2U; i++) { // In the second round they are already closed.
        osal_directory_close(&directory);
        osal_file_close(&file);
        osal_device_close(&device);
        osal_socket_close(&socket);
    }
    assert_int_equal(-4, directory.descriptor + file.descriptor + device.descriptor + socket.descriptor);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_interrupted_open_is_repeated_and_descriptor_0_is_valid),
        cmocka_unit_test(a_directory_that_does_not_open_is_reported_and_none_stays_open),
        cmocka_unit_test(a_file_for_which_the_disk_has_no_room_is_not_created),
        cmocka_unit_test(a_file_without_the_whole_reserved_room_is_removed),
        cmocka_unit_test(what_was_opened_and_is_no_file_is_closed),
        cmocka_unit_test(each_kind_of_file_is_closed_once_also_descriptor_0),
        cmocka_unit_test(the_reason_why_a_file_cannot_be_described_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
