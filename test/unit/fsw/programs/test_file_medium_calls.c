// SPDX-License-Identifier: Apache-2.0
// The medium on a file passes each call on, and each status that base/medium.h states: the behaviour of a
// journal on a full or broken disk depends on that. The file is mocked.
#include "fsw/programs/file_medium.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define AT 123U
#define END 456U

static osal_file_t file;
static medium_t medium;
static uint8_t octets[7];

status_t __wrap_osal_file_read_at(osal_file_t* called, uint64_t offset, void* to, size_t size)
{
    assert_ptr_equal(&file, called);
    assert_int_equal(AT, offset);
    assert_ptr_equal(octets, to);
    assert_int_equal(sizeof octets, size);
    return mock_type(status_t);
}

status_t __wrap_osal_file_write_at(osal_file_t* called, uint64_t offset, const void* from, size_t size)
{
    assert_ptr_equal(&file, called);
    assert_int_equal(AT, offset);
    assert_ptr_equal(octets, from);
    assert_int_equal(sizeof octets, size);
    return mock_type(status_t);
}

status_t __wrap_osal_file_sync(osal_file_t* called)
{
    assert_ptr_equal(&file, called);
    return mock_type(status_t);
}

status_t __wrap_osal_file_size(osal_file_t* called, uint64_t* out_size)
{
    assert_ptr_equal(&file, called);
    *out_size = END;
    return mock_type(status_t);
}

status_t __wrap_osal_file_resize(osal_file_t* called, uint64_t size)
{
    assert_ptr_equal(&file, called);
    assert_int_equal(END, size);
    return mock_type(status_t);
}

static void a_failed_sync_of_the_file_is_an_error_of_the_medium(void** state)
{
    (void)state;
    medium = file_medium(&file);
    will_return(__wrap_osal_file_sync, STATUS_OK);
    assert_int_equal(STATUS_OK, medium.sync(medium.context));
    will_return(__wrap_osal_file_sync, STATUS_IO);
    assert_int_equal(STATUS_IO, medium.sync(medium.context));
    will_return(__wrap_osal_file_sync, STATUS_UNSUPPORTED);
    assert_int_equal(STATUS_IO, medium.sync(medium.context));
}

static void the_other_calls_pass_on_each_status_of_the_file(void** state)
{
    static const status_t answers[] = {STATUS_OK, STATUS_FULL, STATUS_TRUNCATED, STATUS_IO};
    (void)state;
    medium = file_medium(&file);
    for (size_t i = 0U; i < (sizeof answers / sizeof answers[0]); i++) {
        uint64_t end = 0U;
        will_return(__wrap_osal_file_read_at, answers[i]);
        assert_int_equal(answers[i], medium.read(medium.context, AT, octets, sizeof octets));
        will_return(__wrap_osal_file_write_at, answers[i]);
        assert_int_equal(answers[i], medium.write(medium.context, AT, octets, sizeof octets));
        will_return(__wrap_osal_file_size, answers[i]);
        assert_int_equal(answers[i], medium.size(medium.context, &end));
        assert_int_equal(END, end);
        will_return(__wrap_osal_file_resize, answers[i]);
        assert_int_equal(answers[i], medium.resize(medium.context, END));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_failed_sync_of_the_file_is_an_error_of_the_medium),
                                       cmocka_unit_test(the_other_calls_pass_on_each_status_of_the_file)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
