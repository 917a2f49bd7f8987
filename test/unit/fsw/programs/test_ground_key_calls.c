// SPDX-License-Identifier: Apache-2.0
// Each copy of the key is wiped as a whole, whatever the files and the receiver of the link answer: both are
// mocked.
#include "fsw/programs/ground_key.h"

#include "test/support/sealer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define CONTENT_OCTETS 66U ///< Room for the content of a key file: digits, line end, and one octet more.
#define DIGITS "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f"

static ground_key_t key;
static char error[GROUND_KEY_ERROR_MAX];

status_t __wrap_osal_file_load_secret(const char* path, void* octets, size_t capacity, size_t* out_size)
{
    check_expected_ptr(path);
    const void* const content = mock_ptr_type(const void*);
    *out_size                 = mock_type(size_t);
    assert_true(*out_size <= capacity);
    (void)memcpy(octets, content, *out_size);
    return mock_type(status_t);
}

status_t __wrap_osal_file_update(osal_file_t* file, const char* path)
{
    assert_ptr_equal(&key.mark, file);
    assert_string_equal("k.received", path);
    return mock_type(status_t);
}

status_t __wrap_osal_file_lock(osal_file_t* file)
{
    assert_ptr_equal(&key.mark, file);
    return mock_type(status_t);
}

void __wrap_osal_file_close(osal_file_t* file)
{
    assert_ptr_equal(&key.mark, file);
    function_called();
}

status_t __wrap_sdls_open(sdls_receiver_t* receiver, const uint8_t* used, const medium_t* medium)
{
    assert_ptr_equal(&key.receiver, receiver);
    assert_memory_equal(sealer_key, used, SDLS_KEY_OCTETS);
    assert_ptr_equal(&key.mark, medium->context);
    return mock_type(status_t);
}

void __wrap_sdls_close(sdls_receiver_t* receiver)
{
    assert_ptr_equal(&key.receiver, receiver);
    function_called();
}

void __wrap_sdls_wipe(void* octets, size_t size)
{
    check_expected_ptr(octets);
    check_expected(size);
}

static void expect_load(const char* const path, const void* const content, const size_t size,
                        const status_t status)
{
    expect_string(__wrap_osal_file_load_secret, path, path);
    will_return(__wrap_osal_file_load_secret, content);
    will_return(__wrap_osal_file_load_secret, size);
    will_return(__wrap_osal_file_load_secret, status);
}

/// The content of the file is wiped with all of its room, then the key.
static void expect_wipes(const void* const content, const size_t size)
{
    expect_memory(__wrap_sdls_wipe, octets, content, size);
    expect_value(__wrap_sdls_wipe, size, CONTENT_OCTETS);
    expect_memory(__wrap_sdls_wipe, octets, sealer_key, SDLS_KEY_OCTETS);
    expect_value(__wrap_sdls_wipe, size, SDLS_KEY_OCTETS);
}

static void expect_close(void)
{
    expect_function_call(__wrap_sdls_close);
    expect_function_call(__wrap_osal_file_close);
}

static void expect_refused(const char* const words)
{
    assert_false(ground_key_open(&key, "k", error));
    assert_non_null(strstr(error, words));
}

static void copies_of_octets_and_of_digits_are_wiped(void** state)
{
    (void)state;
    const struct {
        const void* content;
        size_t size;
    } files[] = {{sealer_key, SDLS_KEY_OCTETS}, {DIGITS, 64U}, {DIGITS "\n", 65U}};
    for (unsigned i = 0U; i < (sizeof files / sizeof files[0]); i++) {
        expect_load("k", files[i].content, files[i].size, STATUS_OK);
        expect_wipes(files[i].content, files[i].size);
        expect_load("k.received", "", 0U, STATUS_TOO_LARGE); // Only the size of the file is queried.
        will_return(__wrap_osal_file_update, STATUS_OK);
        will_return(__wrap_osal_file_lock, STATUS_OK);
        will_return(__wrap_sdls_open, STATUS_OK);
        assert_true(ground_key_open(&key, "k", error));
    }
}

static void copies_are_wiped_if_the_mark_cannot_be_used(void** state)
{
    (void)state;
    static const struct {
        status_t looked;
        status_t opened;
        status_t locked;
        status_t read;
        const char* words;
    } rows[] = {
        {STATUS_NOT_FOUND, STATUS_OK, STATUS_OK, STATUS_OK, "k.received: the mark of the key is missing"},
        {STATUS_FORBIDDEN, STATUS_OK, STATUS_OK, STATUS_OK, "k.received: other users than its owner"},
        {STATUS_OK, STATUS_IO, STATUS_OK, STATUS_OK, "k.received: "},
        {STATUS_OK, STATUS_OK, STATUS_BUSY, STATUS_OK, "k.received: another flight uses this key"},
        {STATUS_OK, STATUS_OK, STATUS_OK, STATUS_INVALID, "k.received: damaged, or of another key"},
        {STATUS_OK, STATUS_OK, STATUS_OK, STATUS_IO, "k.received: "},
    };
    for (unsigned i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        expect_load("k", sealer_key, SDLS_KEY_OCTETS, STATUS_OK);
        expect_wipes(sealer_key, SDLS_KEY_OCTETS);
        expect_load("k.received", "", 0U, rows[i].looked);
        const bool has_mark = (rows[i].looked == STATUS_OK);
        const bool is_open  = has_mark && (rows[i].opened == STATUS_OK);
        if (has_mark) {
            will_return(__wrap_osal_file_update, rows[i].opened);
        }
        if (is_open) {
            will_return(__wrap_osal_file_lock, rows[i].locked);
        }
        if (is_open && (rows[i].locked == STATUS_OK)) {
            will_return(__wrap_sdls_open, rows[i].read);
        }
        expect_close();
        expect_refused(rows[i].words);
    }
}

/// The content of a file that is not a valid key may be part of a key.
static void content_that_is_no_key_is_wiped(void** state)
{
    (void)state;
    expect_load("k", DIGITS, 63U, STATUS_OK);
    expect_memory(__wrap_sdls_wipe, octets, DIGITS, 63U);
    expect_value(__wrap_sdls_wipe, size, CONTENT_OCTETS);
    expect_any(__wrap_sdls_wipe, octets);
    expect_value(__wrap_sdls_wipe, size, SDLS_KEY_OCTETS);
    expect_close();
    expect_refused("k: not a key; expected 32 octets or 64 hexadecimal digits");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_of_octets_and_of_digits_are_wiped),
        cmocka_unit_test(copies_are_wiped_if_the_mark_cannot_be_used),
        cmocka_unit_test(content_that_is_no_key_is_wiped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
