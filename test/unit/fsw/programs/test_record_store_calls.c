// SPDX-License-Identifier: Apache-2.0
// A copy of damaged data is written, synced and closed; a copy is removed if one of these calls fails. The
// files are mocked.
#include "fsw/programs/record_store.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static run_state_t run;
static component_runtime_t runtime;

status_t __wrap_osal_file_open_read(osal_file_t* file, const char* path)
{
    (void)file;
    check_expected(path);
    return mock_type(status_t);
}

status_t __wrap_osal_file_create(osal_file_t* file, const char* path)
{
    check_expected(path);
    file->descriptor = 77;
    return mock_type(status_t);
}

status_t __wrap_osal_file_write(osal_file_t* file, const void* octets, size_t size)
{
    assert_int_equal(77, file->descriptor);
    assert_int_equal(3U, size);
    assert_memory_equal("xyz", octets, 3U);
    return mock_type(status_t);
}

status_t __wrap_osal_file_sync(osal_file_t* file)
{
    assert_int_equal(77, file->descriptor);
    return mock_type(status_t);
}

void __wrap_osal_file_close(osal_file_t* file)
{
    (void)file;
    function_called();
}

status_t __wrap_osal_file_remove(const char* path)
{
    check_expected(path);
    return STATUS_OK;
}

void __wrap_osal_console_print_error(const char* text)
{
    check_expected(text);
}

static int set_up(void** state)
{
    (void)state;
    runtime = (component_runtime_t){.run = &run};
    (void)strcpy(run.storage, "/s");
    (void)strcpy(run.components[0].name, "ARM");
    return 0;
}

static bool keep(void)
{
    return record_store_keep(&runtime, "kind", (const uint8_t*)"xyz", 3U);
}

static void expect_open(const char* path, status_t status)
{
    expect_string(__wrap_osal_file_open_read, path, path);
    will_return(__wrap_osal_file_open_read, status);
    if (status == STATUS_OK) {
        expect_function_call(__wrap_osal_file_close);
    }
}

static void expect_create(const char* path, status_t status)
{
    expect_string(__wrap_osal_file_create, path, path);
    will_return(__wrap_osal_file_create, status);
}

static void a_copy_is_whole_on_the_disk_before_it_is_reported(void** state)
{
    (void)state;
    expect_open("/s/ARM.kind.damaged.0", STATUS_NOT_FOUND);
    expect_create("/s/ARM.kind.damaged.0", STATUS_OK);
    will_return(__wrap_osal_file_write, STATUS_OK);
    will_return(__wrap_osal_file_sync, STATUS_OK);
    expect_function_call(__wrap_osal_file_close);
    expect_string(__wrap_osal_console_print_error, text,
                  "damaged: /s/ARM.kind; a copy is /s/ARM.kind.damaged.0");
    assert_true(keep());
}

static void a_copy_that_cannot_be_written_or_synced_is_removed(void** state)
{
    (void)state;
    for (unsigned failing = 0U; failing < 2U; failing++) {
        expect_open("/s/ARM.kind.damaged.0", STATUS_NOT_FOUND);
        expect_create("/s/ARM.kind.damaged.0", STATUS_OK);
        will_return(__wrap_osal_file_write, (failing == 0U) ? STATUS_IO : STATUS_OK);
        if (failing == 1U) { // A copy that could not be written is not synced.
            will_return(__wrap_osal_file_sync, STATUS_IO);
        }
        expect_function_call(__wrap_osal_file_close);
        expect_string(__wrap_osal_file_remove, path, "/s/ARM.kind.damaged.0");
        expect_string(__wrap_osal_console_print_error, text,
                      "damaged: /s/ARM.kind; no copy: input/output error");
        assert_false(keep());
    }
}

static void a_copy_that_cannot_be_made_is_reported(void** state)
{
    (void)state;
    expect_open("/s/ARM.kind.damaged.0", STATUS_NOT_FOUND);
    expect_create("/s/ARM.kind.damaged.0", STATUS_FULL);
    expect_string(__wrap_osal_console_print_error, text, "damaged: /s/ARM.kind; no copy: full");
    assert_false(keep());
}

static void earlier_copies_stay_and_the_last_one_is_replaced(void** state)
{
    static const char* const paths[RECORD_STORE_COPIES] = {"/s/ARM.kind.damaged.0", "/s/ARM.kind.damaged.1",
                                                           "/s/ARM.kind.damaged.2", "/s/ARM.kind.damaged.3"};
    static const char* const lines[RECORD_STORE_COPIES] = {
        "damaged: /s/ARM.kind; a copy is /s/ARM.kind.damaged.0",
        "damaged: /s/ARM.kind; a copy is /s/ARM.kind.damaged.1",
        "damaged: /s/ARM.kind; a copy is /s/ARM.kind.damaged.2",
        "damaged: /s/ARM.kind; a copy is /s/ARM.kind.damaged.3"};
    (void)state;
    for (size_t present = 0U; present <= RECORD_STORE_COPIES; present++) {
        const size_t made = (present < RECORD_STORE_COPIES) ? present : (RECORD_STORE_COPIES - 1U);
        for (size_t i = 0U; i < present; i++) {
            expect_open(paths[i], STATUS_OK);
        }
        if (present < RECORD_STORE_COPIES) {
            expect_open(paths[present], STATUS_NOT_FOUND);
        }
        expect_create(paths[made], STATUS_OK);
        will_return(__wrap_osal_file_write, STATUS_OK);
        will_return(__wrap_osal_file_sync, STATUS_OK);
        expect_function_call(__wrap_osal_file_close);
        expect_string(__wrap_osal_console_print_error, text, lines[made]);
        assert_true(keep());
    }
}

static void a_path_without_room_for_the_number_of_the_copy_is_refused(void** state)
{
    static char line[2U * RUN_PATH_MAX];
    (void)state;
    run.storage[0] = '/';
    (void)memset(&run.storage[1], 's', sizeof run.storage - 2U);
    run.storage[RUN_PATH_MAX - sizeof "/ARM.kind.damaged."] = '\0'; // The path has no room for the digit.
    (void)strcpy(line, "damaged: ");
    (void)strcat(line, run.storage);
    (void)strcat(line, "/ARM.kind; no copy: too large");
    expect_string(__wrap_osal_console_print_error, text, line);
    assert_false(keep());
}

static void the_longest_paths_have_room_on_the_line(void** state)
{
    static char path[2U * RUN_PATH_MAX];
    static char line[4U * RUN_PATH_MAX];
    (void)state;
    run.storage[0] = '/';
    (void)memset(&run.storage[1], 's', sizeof run.storage - 2U);
    run.storage[RUN_PATH_MAX - sizeof "/ARM.kind.damaged.0"] = '\0';
    (void)snprintf(path, sizeof path, "%s/ARM.kind.damaged.0", run.storage);
    (void)snprintf(line, sizeof line, "damaged: %s/ARM.kind; a copy is %s", run.storage, path);
    assert_int_equal(RUN_PATH_MAX - 1U, strlen(path));
    expect_open(path, STATUS_NOT_FOUND);
    expect_create(path, STATUS_OK);
    will_return(__wrap_osal_file_write, STATUS_OK);
    will_return(__wrap_osal_file_sync, STATUS_OK);
    expect_function_call(__wrap_osal_file_close);
    expect_string(__wrap_osal_console_print_error, text, line);
    assert_true(keep());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_copy_is_whole_on_the_disk_before_it_is_reported, set_up),
        cmocka_unit_test_setup(a_copy_that_cannot_be_written_or_synced_is_removed, set_up),
        cmocka_unit_test_setup(a_copy_that_cannot_be_made_is_reported, set_up),
        cmocka_unit_test_setup(earlier_copies_stay_and_the_last_one_is_replaced, set_up),
        cmocka_unit_test_setup(the_longest_paths_have_room_on_the_line, set_up),
        cmocka_unit_test_setup(a_path_without_room_for_the_number_of_the_copy_is_refused, set_up)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
