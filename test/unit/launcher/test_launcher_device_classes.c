// SPDX-License-Identifier: Apache-2.0
// The data sheets of descriptors/devices are those of the build. Files are mocked: all have the same content.
#include "launcher/launcher_internal.h"

#include "fsw/canopen/device_profile.h"
#include "osal/include/osal/file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define CHANGED "[FileInfo]\n"
#define CHANGED_HASH "0x63159F287543B5B7" // FNV-1a of CHANGED.

static launcher_t launcher;
static bool is_at_end;

// ---- Mocked functions ----

status_t __wrap_osal_file_open_read(osal_file_t* file, const char* path)
{
    assert_non_null(file);
    check_expected_ptr(path);
    is_at_end = false;
    return mock_type(status_t);
}

status_t __wrap_osal_file_read(osal_file_t* file, void* octets, size_t capacity, size_t* out_size)
{
    assert_non_null(file);
    assert_true(capacity >= strlen(CHANGED));
    *out_size = is_at_end ? 0U : strlen(CHANGED);
    (void)memcpy(octets, CHANGED, *out_size);
    is_at_end = true;
    return mock_type(status_t);
}

void __wrap_osal_file_close(osal_file_t* file)
{
    assert_non_null(file);
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    return 0;
}

static void missing_sheets_are_no_error(void** state)
{
    (void)state;
    size_t count = 0U;
    while (canopen_device_profile_at(count) != NULL) {
        count++;
    }
    assert_true(count > 2U);
    expect_any_count(__wrap_osal_file_open_read, path, (int)count);
    will_return_count(__wrap_osal_file_open_read, STATUS_NOT_FOUND, (int)count);
    assert_true(launcher_check_device_classes(&launcher));
}

static void a_changed_sheet_is_refused_with_both_hashes(void** state)
{
    (void)state;
    char compiled[32];
    char path[64];
    const canopen_device_profile_t* const first = canopen_device_profile_at(0U);
    text_t text                                 = text_in(compiled, sizeof compiled);
    text_add_hex(&text, first->sheet_hash, 16U);
    (void)text_join(path, sizeof path,
                    (const char* const[]){"descriptors/devices/", first->type, ".eds", NULL});
    expect_string(__wrap_osal_file_open_read, path, path);
    will_return(__wrap_osal_file_open_read, STATUS_OK);
    will_return_count(__wrap_osal_file_read, STATUS_OK, 2);
    assert_false(launcher_check_device_classes(&launcher));
    assert_non_null(strstr(launcher.reason, path));
    assert_non_null(strstr(launcher.reason, compiled));
    assert_non_null(strstr(launcher.reason, CHANGED_HASH));
    assert_non_null(strstr(launcher.reason, "run make"));
}

static void a_sheet_that_cannot_be_read_is_reported(void** state)
{
    (void)state;
    expect_any(__wrap_osal_file_open_read, path);
    will_return(__wrap_osal_file_open_read, STATUS_OK);
    will_return(__wrap_osal_file_read, STATUS_IO);
    assert_false(launcher_check_device_classes(&launcher));
    assert_non_null(strstr(launcher.reason, "cannot read the data sheet descriptors/devices/"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(missing_sheets_are_no_error, set_up),
        cmocka_unit_test_setup(a_changed_sheet_is_refused_with_both_hashes, set_up),
        cmocka_unit_test_setup(a_sheet_that_cannot_be_read_is_reported, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
