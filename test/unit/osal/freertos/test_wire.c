// SPDX-License-Identifier: Apache-2.0
// The program's side of the wire, on the board. The pipes are mocked: the test records what is read and
// written.
#include "osal/freertos/wire.h"

#include "base/octets.h"
#include "osal/freertos/semihosting.h"
#include "osal/include/osal/target_wire.h"

#include "unity.h"

#include <string.h>

#define IN 7
#define OUT 8
#define ARRIVING_OCTETS 131072U
#define NUMBER 40U
#define LINE_MAX 128U

static uint8_t arriving[ARRIVING_OCTETS];
static size_t arriving_size;
static size_t arriving_at;
static char paths[2][32];
static uint8_t written[256]; ///< Octets of the last records that were sent.
static size_t written_size;
static unsigned opened;
static unsigned lines;
static char line[LINE_MAX]; ///< The line that was printed last.

int __wrap_semihosting_open(const char* path, semihosting_mode_t mode);
void __wrap_semihosting_close(int handle);
int __wrap_semihosting_read(int handle, void* octets, size_t capacity);
bool __wrap_semihosting_write(int handle, const void* octets, size_t size);
void __wrap_osal_console_print_error(const char* text);

int __wrap_semihosting_open(const char* const path, const semihosting_mode_t mode)
{
    TEST_ASSERT_EQUAL((opened == 0U) ? SEMIHOSTING_READ : SEMIHOSTING_WRITE, mode);
    TEST_ASSERT_TRUE((opened < 2U) && (strlen(path) < sizeof paths[0]));
    (void)memcpy(paths[opened], path, strlen(path) + 1U);
    opened++;
    return (opened == 1U) ? IN : OUT;
}

void __wrap_semihosting_close(const int handle)
{
    TEST_ASSERT_TRUE((handle == IN) || (handle == OUT));
}

int __wrap_semihosting_read(const int handle, void* const octets, const size_t capacity)
{
    const size_t rest = arriving_size - arriving_at;
    const size_t size = (rest < capacity) ? rest : capacity;
    TEST_ASSERT_EQUAL(IN, handle);
    (void)memcpy(octets, &arriving[arriving_at], size);
    arriving_at += size;
    return (int)size;
}

bool __wrap_semihosting_write(const int handle, const void* const octets, const size_t size)
{
    TEST_ASSERT_EQUAL(OUT, handle);
    TEST_ASSERT_TRUE((octets != NULL) && (size > 0U));
    written_size = (size < sizeof written) ? size : sizeof written;
    (void)memcpy(written, octets, written_size);
    return true;
}

void __wrap_osal_console_print_error(const char* const text)
{
    lines++;
    TEST_ASSERT_TRUE(strlen(text) < sizeof line);
    (void)memcpy(line, text, strlen(text) + 1U);
}

void setUp(void)
{
    arriving_size = 0U;
    arriving_at   = 0U;
    opened        = 0U;
    lines         = 0U;
    line[0]       = '\0';
}

void tearDown(void)
{
    uint8_t octet;
    size_t size = 0U;
    if (wire_is_open()) { // Read what the test has left.
        while (wire_stream_receive(&octet, 1U, &size) == STATUS_OK) {
        }
    }
    wire_close();
}

static void open_wire(void)
{
    TEST_ASSERT_TRUE(wire_set("3:4"));
    TEST_ASSERT_EQUAL(STATUS_OK, wire_open());
}

static void arrive(const uint8_t kind, const void* const content, const size_t size)
{
    TEST_ASSERT_TRUE((TARGET_WIRE_HEADER_OCTETS + size) <= (ARRIVING_OCTETS - arriving_size));
    octets_put_u32(&arriving[arriving_size], (uint32_t)(size + 1U));
    arriving[arriving_size + 4U] = kind;
    (void)memcpy(&arriving[arriving_size + TARGET_WIRE_HEADER_OCTETS], content, size);
    arriving_size += TARGET_WIRE_HEADER_OCTETS + size;
}

static void arrive_datagram(const size_t size)
{
    static uint8_t content[TARGET_WIRE_DATAGRAM_OCTETS + TARGET_WIRE_DATAGRAM_MAX];
    octets_put_u32(content, NUMBER);
    octets_put_u32(&content[4], 0x7F000001U);
    octets_put_u16(&content[8], 9U);
    (void)memset(&content[TARGET_WIRE_DATAGRAM_OCTETS], (int)(size & 0xFFU), size);
    arrive(TARGET_WIRE_DATAGRAM, content, TARGET_WIRE_DATAGRAM_OCTETS + size);
}

static void descriptors_up_to_the_largest_number_are_accepted(void)
{
    TEST_ASSERT_TRUE(wire_set("100000:2147483647"));
    TEST_ASSERT_EQUAL(STATUS_OK, wire_open());
    TEST_ASSERT_EQUAL_STRING("/dev/fd/100000", paths[0]);
    TEST_ASSERT_EQUAL_STRING("/dev/fd/2147483647", paths[1]);
    wire_close();
    opened = 0U;
    TEST_ASSERT_TRUE(wire_set("0:12"));
    TEST_ASSERT_EQUAL(STATUS_OK, wire_open());
    TEST_ASSERT_EQUAL_STRING("/dev/fd/0", paths[0]);
    TEST_ASSERT_EQUAL_STRING("/dev/fd/12", paths[1]);
}

static void an_argument_that_is_not_two_numbers_is_refused(void)
{
    static const char* const bad[] = {"",     ":",   "3",   "3:",           ":4",
                                      "3:4x", "3-4", "a:4", "2147483648:4", "3:99999999999"};
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(wire_set(bad[i]), bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, wire_open(), bad[i]);
    }
}

static void a_datagram_without_room_is_counted_and_reported(void)
{
    osal_address_t from = {0U, 0U};
    static uint8_t octets[TARGET_WIRE_DATAGRAM_MAX];
    size_t size = 0U;
    open_wire();
    const uint32_t before = wire_lost();
    for (unsigned i = 0U; i < 10U; i++) { // The store of the port has 64 KiB.
        arrive_datagram(TARGET_WIRE_DATAGRAM_MAX);
    }
    arrive(TARGET_WIRE_WAITED, "", 0U);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, wire_datagram_wait(NUMBER + 1U, 0U)); // The call takes all records.
    unsigned received = 0U;
    while (wire_datagram_receive(NUMBER, &from, octets, sizeof octets, &size) == STATUS_OK) {
        TEST_ASSERT_EQUAL_UINT(TARGET_WIRE_DATAGRAM_MAX, size);
        TEST_ASSERT_EQUAL_UINT16(9U, from.port);
        received++;
    }
    TEST_ASSERT_TRUE(received < 10U);
    TEST_ASSERT_EQUAL_UINT32(10U - received, wire_lost() - before);
    TEST_ASSERT_EQUAL_UINT(1U, lines);
    TEST_ASSERT_EQUAL_STRING("wire: datagrams lost because there was no room for them: 1", line);
    wire_close();
    TEST_ASSERT_EQUAL_UINT(2U, lines);
    TEST_ASSERT_EQUAL_STRING("wire: datagrams lost because there was no room for them: 3", line);
}

static void expect_refused(const uint8_t kind, const size_t size, const char* const message)
{
    static const uint8_t content[TARGET_WIRE_DATAGRAM_OCTETS] = {0U};
    uint8_t octet                                             = 0U;
    size_t got                                                = 0U;
    setUp();
    open_wire();
    arrive(kind, content, size);
    arrive(TARGET_WIRE_STREAM, "x", 1U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, wire_stream_receive(&octet, 1U, &got));
    TEST_ASSERT_EQUAL_UINT(1U, lines);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, message), line);
    tearDown();
}

static void malformed_records_of_the_serving_process_are_refused_and_reported(void)
{
    expect_refused(TARGET_WIRE_DATAGRAM, TARGET_WIRE_DATAGRAM_OCTETS - 1U, "kind 2, octets 10");
    expect_refused(TARGET_WIRE_DATAGRAM, 0U, "kind 2, octets 1");
    expect_refused(TARGET_WIRE_ADOPT, 4U, "kind 3, octets 5");
    expect_refused(TARGET_WIRE_WAITED, 1U, "kind 5, octets 2");
    expect_refused(TARGET_WIRE_SYNC, 2U, "kind 6, octets 3");
    expect_refused(TARGET_WIRE_SYNCED, 0U, "kind 7, octets 1");
    expect_refused(TARGET_WIRE_SYNCED, 2U, "kind 7, octets 3");
    expect_refused(99U, 0U, "kind 99");
}

static void a_record_of_a_wrong_size_is_refused_and_reported(void)
{
    uint8_t octet = 0U;
    size_t got    = 0U;
    open_wire();
    octets_put_u32(arriving, TARGET_WIRE_CONTENT_MAX + 2U);
    arriving[4]   = TARGET_WIRE_STREAM;
    arriving_size = TARGET_WIRE_HEADER_OCTETS;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, wire_stream_receive(&octet, 1U, &got));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, "kind 1, octets 16386"), line);
}

/// The answer of the serving process is the result of the sync, of a file or of the names in its directory.
static void a_sync_has_the_result_of_the_serving_process(void)
{
    static const uint8_t of_file[]  = {0U,  0U,  0U,  6U, TARGET_WIRE_SYNC, TARGET_WIRE_SYNC_CONTENT,
                                       'a', '/', 'b', 'c'};
    static const uint8_t of_names[] = {0U, 0U, 0U, 3U, TARGET_WIRE_SYNC, TARGET_WIRE_SYNC_NAMES, 'd'};
    open_wire();
    arrive_datagram(20U); // A datagram may arrive before the answer.
    arrive(TARGET_WIRE_SYNCED, "\1", 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, wire_sync("a/bc", false));
    TEST_ASSERT_EQUAL(sizeof of_file, written_size);
    TEST_ASSERT_EQUAL_MEMORY(of_file, written, sizeof of_file);
    arrive(TARGET_WIRE_SYNCED, "\0", 1U);
    TEST_ASSERT_EQUAL(STATUS_IO, wire_sync("d", true));
    TEST_ASSERT_EQUAL(sizeof of_names, written_size);
    TEST_ASSERT_EQUAL_MEMORY(of_names, written, sizeof of_names);
    arrive(TARGET_WIRE_SYNCED, "\2", 1U); // Neither success (1) nor failure (0).
    TEST_ASSERT_EQUAL(STATUS_CLOSED, wire_sync("d", true));
}

static void a_path_that_does_not_fit_is_not_synced(void)
{
    static char path[TARGET_WIRE_PATH_MAX + 2U];
    (void)memset(path, 'p', sizeof path - 1U);
    open_wire();
    TEST_ASSERT_EQUAL(STATUS_IO, wire_sync(path, false));
    TEST_ASSERT_EQUAL(STATUS_IO, wire_sync("", false));
    path[TARGET_WIRE_PATH_MAX] = '\0';
    arrive(TARGET_WIRE_SYNCED, "\1", 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, wire_sync(path, false));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(descriptors_up_to_the_largest_number_are_accepted);
    RUN_TEST(an_argument_that_is_not_two_numbers_is_refused);
    RUN_TEST(malformed_records_of_the_serving_process_are_refused_and_reported);
    RUN_TEST(a_record_of_a_wrong_size_is_refused_and_reported);
    RUN_TEST(a_datagram_without_room_is_counted_and_reported);
    RUN_TEST(a_sync_has_the_result_of_the_serving_process);
    RUN_TEST(a_path_that_does_not_fit_is_not_synced);
    return UNITY_END();
}
