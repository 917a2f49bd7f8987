// SPDX-License-Identifier: Apache-2.0
// Every strategy in a folder of its own, changes of strategy at any record, and a disk that is full.
#include "fsw/supervisor/packet_log.h"

#include "fsw/framework/base/octets.h"
#include "pus/tailoring.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_MAX 4194304U

static packet_log_t packets;
static char folder[64];
static uint8_t content[FILE_MAX];
static size_t content_size;

static const char* path_of(const char* name)
{
    static char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

void setUp(void)
{
    (void)snprintf(folder, sizeof folder, "/tmp/hirosco-log-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
}

void tearDown(void)
{
    static const char* const names[] = {"packets.ascii", "packets.spool", "packets.ring"};
    packet_log_close(&packets);
    for (unsigned i = 0U; i < 3U; i++) {
        (void)unlink(path_of(names[i]));
        (void)rmdir(path_of(names[i]));
    }
    TEST_ASSERT_EQUAL(0, rmdir(folder));
}

static uint32_t random_state = 13U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static void open_log(packet_log_strategy_t strategy)
{
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_open(&packets, folder, strategy, 1U));
}

static void read_file(const char* name)
{
    content_size     = 0U;
    FILE* const file = fopen(path_of(name), "rb");
    if (file != NULL) {
        content_size = fread(content, 1U, FILE_MAX - 1U, file);
        (void)fclose(file);
    }
    content[content_size] = 0U;
}

static void expect_text(const char* name, const char* text)
{
    read_file(name);
    TEST_ASSERT_EQUAL_STRING(text, (const char*)content);
}

// ---- Strategies ----

static void lines_are_numbered_and_timed(void)
{
    const uint8_t request[3] = {0x18U, 0x10U, 0xC0U};
    const uint8_t report[2]  = {0x08U, 0xFFU};
    open_log(PACKET_LOG_ASCII);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 0U, true, request, sizeof request));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 93000500000ULL, false, report, sizeof report));
    TEST_ASSERT_EQUAL(3U, packets.next_number);
    expect_text("packets.ascii", ""); // Nothing is written before it is flushed.
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    expect_text("packets.ascii", "1 0.000000000 TC 1810c0\n2 93.000500000 TM 08ff\n");
    packet_log_close(&packets);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_open(&packets, folder, PACKET_LOG_ASCII, 3U)); // It goes on.
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 1U, true, request, 1U));
    packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 1810c0\n2 93.000500000 TM 08ff\n3 0.000000001 TC 18\n");
}

static void spool_records_are_binary(void)
{
    static const uint8_t expected[] = {0U, 0U, 0U, 19U, 0U, 0U, 0U,    0U,    0U, 0U, 0U, 1U,  0U, 0U, 0U,
                                       0U, 0U, 0U, 1U,  2U, 0U, 0xAAU, 0xBBU, 0U, 0U, 0U, 18U, 0U, 0U, 0U,
                                       0U, 0U, 0U, 0U,  2U, 0U, 0U,    0U,    0U, 0U, 0U, 0U,  7U, 1U, 0xCCU};
    const uint8_t request[2]        = {0xAAU, 0xBBU};
    const uint8_t report[1]         = {0xCCU};
    open_log(PACKET_LOG_SQLITE);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 258U, true, request, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 7U, false, report, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    read_file("packets.spool");
    TEST_ASSERT_EQUAL(sizeof expected, content_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, content, sizeof expected);
}

static void the_ring_is_written_when_it_is_left(void)
{
    const uint8_t packet[2] = {0x01U, 0x02U};
    open_log(PACKET_LOG_RING);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 5U, false, packet, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 6U, false, packet, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    expect_text("packets.ring", "");
    packet_log_close(&packets);
    expect_text("packets.ring", "1 0.000000005 TM 0102\n2 0.000000006 TM 01\n");
}

/// Number of each line, in order, from the file at hand; returns how many.
static size_t line_numbers(uint64_t* numbers, size_t capacity)
{
    size_t count = 0U;
    for (const char* line = (const char*)content; line[0] != '\0'; line = strchr(line, '\n') + 1) {
        TEST_ASSERT_TRUE(count < capacity);
        numbers[count++] = strtoull(line, NULL, 10);
        TEST_ASSERT_NOT_NULL(strchr(line, '\n'));
    }
    return count;
}

static void the_ring_keeps_the_newest(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    static uint64_t numbers[1024];
    open_log(PACKET_LOG_RING);
    for (unsigned i = 0U; i < 600U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, i, false, packet, 1024U + draw(3072U)));
    }
    packet_log_close(&packets);
    read_file("packets.ring");
    const size_t count = line_numbers(numbers, 1024U);
    TEST_ASSERT_TRUE((count > 100U) && (count < 600U));
    for (size_t i = 0U; i < count; i++) { // The last ones, without a gap.
        TEST_ASSERT_EQUAL(600U - count + 1U + i, numbers[i]);
    }
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

// ---- Changes ----

static uint8_t seen[4096];

static void mark(uint64_t number)
{
    TEST_ASSERT_TRUE((number >= 1U) && (number < sizeof seen));
    seen[number]++;
}

static void mark_lines(const char* name)
{
    static uint64_t numbers[4096];
    read_file(name);
    const size_t count = line_numbers(numbers, 4096U);
    for (size_t i = 0U; i < count; i++) {
        mark(numbers[i]);
    }
}

static void mark_spool(void)
{
    read_file("packets.spool");
    octet_reader_t reader = octet_reader(content, content_size);
    while (octet_reader_left(&reader) > 0U) {
        const uint32_t size = octet_read_u32(&reader);
        mark(octet_read_u64(&reader));
        TEST_ASSERT_NOT_NULL(octet_read_octets(&reader, size - 8U));
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void all_parts_together_are_the_whole(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    static const packet_log_strategy_t strategies[] = {PACKET_LOG_ASCII, PACKET_LOG_SQLITE, PACKET_LOG_RING};
    (void)memset(seen, 0, sizeof seen);
    open_log(PACKET_LOG_ASCII);
    for (unsigned i = 0U; i < 3000U; i++) {
        if (draw(20U) == 0U) {
            const packet_log_strategy_t next = strategies[draw(3U)];
            TEST_ASSERT_EQUAL(STATUS_OK, packet_log_select(&packets, next));
            TEST_ASSERT_EQUAL(next, packets.strategy);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, i, draw(2U) == 0U, packet, draw(300U)));
        if (draw(10U) == 0U) {
            TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
        }
    }
    packet_log_close(&packets);
    mark_lines("packets.ascii");
    mark_lines("packets.ring");
    mark_spool();
    for (unsigned number = 1U; number <= 3000U; number++) {
        TEST_ASSERT_EQUAL_MESSAGE(1U, seen[number], "a record is missing or doubled");
    }
    TEST_ASSERT_EQUAL(3001U, packets.next_number);
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

static void what_no_build_has_is_refused(void)
{
    const uint8_t packet[1] = {0x18U};
    open_log(PACKET_LOG_ASCII);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, packet_log_select(&packets, PACKET_LOG_POSTGRESQL));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, packet_log_select(&packets, PACKET_LOG_STRATEGIES));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, packet_log_select(&packets, (packet_log_strategy_t)255));
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 0U, true, packet, 1U));
    packet_log_close(&packets);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, packet_log_open(&packets, folder, PACKET_LOG_POSTGRESQL, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, packet_log_append(&packets, 0U, true, packet, 1U));
    TEST_ASSERT_EQUAL(1U, packets.failures);
}

static void a_strategy_that_cannot_open_leaves_the_old_one(void)
{
    const uint8_t packet[1] = {0x18U};
    TEST_ASSERT_EQUAL(0, mkdir(path_of("packets.spool"), 0755)); // No file can be made in its place.
    open_log(PACKET_LOG_ASCII);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 0U, true, packet, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, packet_log_select(&packets, PACKET_LOG_SQLITE));
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 0U, true, packet, 1U));
    packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 18\n2 0.000000000 TC 18\n");
}

static void a_folder_that_is_not_there_is_told(void)
{
    static char long_name[600];
    (void)memset(long_name, 'x', sizeof long_name - 1U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, packet_log_open(&packets, path_of("nowhere"), PACKET_LOG_ASCII, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, packet_log_open(&packets, long_name, PACKET_LOG_ASCII, 1U));
}

// ---- A disk that is full ----

/// From now on the file of that name takes nothing.
static void fill_disk(const char* name)
{
    TEST_ASSERT_EQUAL(0, symlink("/dev/full", path_of(name)));
}

static void append(unsigned count)
{
    const uint8_t packet[1] = {0x18U};
    for (unsigned i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, packet_log_append(&packets, 0U, true, packet, 1U));
    }
}

static void every_lost_record_is_counted(void)
{
    fill_disk("packets.ascii");
    open_log(PACKET_LOG_ASCII);
    append(7U);
    TEST_ASSERT_EQUAL(STATUS_FULL, packet_log_flush(&packets));
    TEST_ASSERT_EQUAL(7U, packets.failures);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets)); // Nothing is left to be lost.
    append(3U);
    TEST_ASSERT_EQUAL(STATUS_FULL, packet_log_flush(&packets));
    TEST_ASSERT_EQUAL(10U, packets.failures);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_select(&packets, PACKET_LOG_SQLITE)); // Another file has room.
    append(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    TEST_ASSERT_EQUAL(10U, packets.failures);
    TEST_ASSERT_EQUAL(13U, packets.next_number); // The numbers show what is missing.
}

static void a_full_buffer_tells_of_the_full_disk(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    status_t status = STATUS_OK;
    fill_disk("packets.spool");
    open_log(PACKET_LOG_SQLITE);
    for (unsigned i = 0U; (i < 64U) && (status == STATUS_OK); i++) {
        status = packet_log_append(&packets, 0U, false, packet, sizeof packet);
    }
    TEST_ASSERT_TRUE(status != STATUS_OK);
    TEST_ASSERT_EQUAL(packets.next_number - 1U, packets.failures);
}

static void lines_behind_a_cut_one_stand_alone(void)
{
    open_log(PACKET_LOG_ASCII);
    append(1U);
    osal_file_t good = packets.file;
    osal_file_t full = {-1};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&full, "/dev/full"));
    packets.file = full;
    TEST_ASSERT_EQUAL(STATUS_FULL, packet_log_flush(&packets));
    packets.file = good; // There is room again, behind half a line.
    osal_file_close(&full);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&good, "1 0.00000", 9U));
    append(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    expect_text("packets.ascii", "1 0.00000\n2 0.000000000 TC 18\n3 0.000000000 TC 18\n");
}

static void a_cut_spool_is_not_written_to_again(void)
{
    fill_disk("packets.spool");
    open_log(PACKET_LOG_SQLITE);
    append(1U);
    TEST_ASSERT_EQUAL(STATUS_FULL, packet_log_flush(&packets));
    const uint8_t packet[1] = {0x18U};
    TEST_ASSERT_EQUAL(STATUS_IO, packet_log_append(&packets, 0U, true, packet, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, packet_log_append(&packets, 0U, true, packet, 1U));
    TEST_ASSERT_EQUAL(3U, packets.failures);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_select(&packets, PACKET_LOG_ASCII));
    TEST_ASSERT_EQUAL(STATUS_IO, packet_log_select(&packets, PACKET_LOG_SQLITE));
    append(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, packet_log_flush(&packets));
    expect_text("packets.ascii", "4 0.000000000 TC 18\n");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lines_are_numbered_and_timed);
    RUN_TEST(spool_records_are_binary);
    RUN_TEST(the_ring_is_written_when_it_is_left);
    RUN_TEST(the_ring_keeps_the_newest);
    RUN_TEST(all_parts_together_are_the_whole);
    RUN_TEST(what_no_build_has_is_refused);
    RUN_TEST(a_strategy_that_cannot_open_leaves_the_old_one);
    RUN_TEST(a_folder_that_is_not_there_is_told);
    RUN_TEST(every_lost_record_is_counted);
    RUN_TEST(a_full_buffer_tells_of_the_full_disk);
    RUN_TEST(lines_behind_a_cut_one_stand_alone);
    RUN_TEST(a_cut_spool_is_not_written_to_again);
    return UNITY_END();
}
