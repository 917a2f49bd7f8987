// SPDX-License-Identifier: Apache-2.0
// The packet log closes a file that it cannot continue, and removes an incomplete record before it continues
// a file. The files are mocked.
#include "fsw/supervisor/packet_log.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define DESCRIPTOR 77
#define SECOND_NS 1000000000ULL

static packet_log_t packets;
static const uint8_t ring[1];
/// An earlier run has written 100 octets of complete records.
static const packet_log_past_t past = {
    .next_number = 9U, .written_number = 8U, .sizes = {100U, 100U, 0U, 100U}, .ring = ring};

status_t __wrap_osal_file_append(osal_file_t* file, const char* path)
{
    assert_string_equal("/f/packets.ascii", path);
    file->descriptor = DESCRIPTOR;
    return mock_type(status_t);
}

status_t __wrap_osal_file_size(osal_file_t* file, uint64_t* out_size)
{
    assert_int_equal(DESCRIPTOR, file->descriptor);
    *out_size = mock_type(uint64_t);
    return mock_type(status_t);
}

status_t __wrap_osal_file_resize(osal_file_t* file, uint64_t size)
{
    assert_int_equal(DESCRIPTOR, file->descriptor);
    assert_int_equal(100U, size);
    return mock_type(status_t);
}

status_t __wrap_osal_file_write(osal_file_t* file, const void* octets, size_t size)
{
    (void)octets;
    assert_int_equal(DESCRIPTOR, file->descriptor);
    assert_true(size > 0U);
    return mock_type(status_t);
}

void __wrap_osal_file_close(osal_file_t* file)
{
    assert_int_equal(DESCRIPTOR, file->descriptor);
    function_called();
}

static void expect_append(uint64_t size, status_t status)
{
    will_return(__wrap_osal_file_append, STATUS_OK);
    will_return(__wrap_osal_file_size, size);
    will_return(__wrap_osal_file_size, status);
}

static void open_log(void)
{
    assert_int_equal(STATUS_OK, supervisor_packet_log_open(&packets, "/f", PACKET_LOG_ASCII, &past, 10U));
}

static void a_file_whose_size_is_unknown_is_closed_and_opened_again_later(void** state)
{
    (void)state;
    expect_append(0U, STATUS_IO);
    expect_function_call(__wrap_osal_file_close);
    open_log();
    assert_int_equal(PACKET_LOG_RING, packets.strategy);
    assert_int_equal(PACKET_LOG_ASCII, packets.wanted);
    supervisor_packet_log_step(&packets, SECOND_NS - 1U); // The delay is not over yet.
    expect_append(0U, STATUS_IO);
    expect_function_call(__wrap_osal_file_close);
    supervisor_packet_log_step(&packets, SECOND_NS);
    assert_int_equal(PACKET_LOG_RING, packets.strategy);
}

static void an_incomplete_record_is_removed_before_the_file_is_continued(void** state)
{
    (void)state;
    expect_append(101U, STATUS_OK);
    will_return(__wrap_osal_file_resize, STATUS_OK);
    open_log();
    assert_int_equal(PACKET_LOG_ASCII, packets.strategy);
    assert_int_equal(100U, packets.size);
    expect_function_call(__wrap_osal_file_close);
    supervisor_packet_log_abandon(&packets);
}

static void a_complete_or_shorter_file_is_continued_unchanged(void** state)
{
    (void)state;
    for (uint64_t size = 99U; size <= 100U; size++) {
        expect_append(size, STATUS_OK);
        open_log();
        assert_int_equal(PACKET_LOG_ASCII, packets.strategy);
        assert_int_equal(size, packets.size);
        expect_function_call(__wrap_osal_file_close);
        supervisor_packet_log_abandon(&packets);
    }
}

static void a_file_that_cannot_be_truncated_is_closed(void** state)
{
    (void)state;
    expect_append(101U, STATUS_OK);
    will_return(__wrap_osal_file_resize, STATUS_IO);
    expect_function_call(__wrap_osal_file_close);
    open_log();
    assert_int_equal(PACKET_LOG_RING, packets.strategy);
    supervisor_packet_log_abandon(&packets); // No file is open, so none is closed.
}

/// A failed write is undone, and the file is closed once.
static void a_file_that_accepts_no_more_is_truncated_and_closed(void** state)
{
    (void)state;
    expect_append(100U, STATUS_OK);
    open_log();
    supervisor_packet_log_append(&packets, 0U, true, (const uint8_t*)"x", 1U);
    will_return(__wrap_osal_file_write, STATUS_FULL);
    will_return(__wrap_osal_file_resize, STATUS_OK);
    expect_function_call(__wrap_osal_file_close);
    supervisor_packet_log_step(&packets, 0U);
    assert_int_equal(PACKET_LOG_RING, packets.strategy);
    assert_false(packets.is_cut[PACKET_LOG_ASCII]);
    supervisor_packet_log_abandon(&packets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_whose_size_is_unknown_is_closed_and_opened_again_later),
        cmocka_unit_test(an_incomplete_record_is_removed_before_the_file_is_continued),
        cmocka_unit_test(a_complete_or_shorter_file_is_continued_unchanged),
        cmocka_unit_test(a_file_that_cannot_be_truncated_is_closed),
        cmocka_unit_test(a_file_that_accepts_no_more_is_truncated_and_closed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
