// SPDX-License-Identifier: Apache-2.0
// Each strategy in a directory of its own, changes of the strategy at any record, and a full disk.
#include "fsw/supervisor/packet_log.h"

#include "base/octets.h"
#include "pus/core/tailoring.h"
#include "unity.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_MAX 4194304U
#define RING_RECORDS 4096U

static const packet_log_past_t new_log = {.next_number = 1U};
static packet_log_t packets;
static char directory[64];
static uint8_t content[FILE_MAX];
static size_t content_size;

static const char* path_of(const char* name)
{
    static char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

void setUp(void)
{
    (void)snprintf(directory, sizeof directory, "/tmp/hirosco-log-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
}

void tearDown(void)
{
    static const char* const names[] = {"packets.ascii", "packets.spool", "packets.ring"};
    supervisor_packet_log_close(&packets);
    for (unsigned i = 0U; i < 3U; i++) {
        (void)unlink(path_of(names[i]));
        (void)rmdir(path_of(names[i]));
    }
    TEST_ASSERT_EQUAL(0, rmdir(directory));
}

static uint32_t random_state = 13U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static void open_log(packet_log_strategy_t strategy)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      supervisor_packet_log_open(&packets, directory, strategy, &new_log, RING_RECORDS));
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
    supervisor_packet_log_append(&packets, 0U, true, request, sizeof request);
    supervisor_packet_log_append(&packets, 93000500000ULL, false, report, sizeof report);
    TEST_ASSERT_EQUAL(3U, packets.next_number);
    expect_text("packets.ascii", ""); // Nothing is written before it is flushed.
    supervisor_packet_log_step(&packets, 0U);
    expect_text("packets.ascii", "1 0.000000000 TC 1810c0\n2 93.000500000 TM 08ff\n");
    supervisor_packet_log_close(&packets);
    const packet_log_past_t past = {.next_number = 3U, .written_number = 2U};
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_open(&packets, directory, PACKET_LOG_ASCII, &past,
                                                            RING_RECORDS)); // The log continues.
    supervisor_packet_log_append(&packets, 1U, true, request, 1U);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 1810c0\n2 93.000500000 TM 08ff\n3 0.000000001 TC 18\n");
}

/// A record: length, number, time, direction and packet (docs/packet-log.md).
static void spool_records_are_binary(void)
{
    static const uint8_t expected[] = {0U, 0U, 0U, 19U, 0U, 0U, 0U,    0U,    0U, 0U, 0U, 1U,  0U, 0U, 0U,
                                       0U, 0U, 0U, 1U,  2U, 0U, 0xAAU, 0xBBU, 0U, 0U, 0U, 18U, 0U, 0U, 0U,
                                       0U, 0U, 0U, 0U,  2U, 0U, 0U,    0U,    0U, 0U, 0U, 0U,  7U, 1U, 0xCCU};
    const uint8_t request[2]        = {0xAAU, 0xBBU};
    const uint8_t report[1]         = {0xCCU};
    open_log(PACKET_LOG_SQLITE);
    supervisor_packet_log_append(&packets, 258U, true, request, 2U);
    supervisor_packet_log_append(&packets, 7U, false, report, 1U);
    supervisor_packet_log_step(&packets, 0U);
    read_file("packets.spool");
    TEST_ASSERT_EQUAL(sizeof expected, content_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, content, sizeof expected);
}

static void the_ring_is_written_to_its_file_when_the_log_is_closed(void)
{
    const uint8_t packet[2] = {0x01U, 0x02U};
    open_log(PACKET_LOG_RING);
    supervisor_packet_log_append(&packets, 5U, false, packet, 2U);
    supervisor_packet_log_append(&packets, 6U, false, packet, 1U);
    supervisor_packet_log_step(&packets, 0U);
    expect_text("packets.ring", "");
    supervisor_packet_log_close(&packets);
    expect_text("packets.ring", "1 0.000000005 TM 0102\n2 0.000000006 TM 01\n");
}

/// Read the numbers of all lines of the open file in order. Returns how many there are.
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

static void the_ring_keeps_the_newest_records(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    static uint64_t numbers[1024];
    open_log(PACKET_LOG_RING);
    for (unsigned i = 0U; i < 600U; i++) {
        supervisor_packet_log_append(&packets, i, false, packet, 1024U + draw(3072U));
    }
    supervisor_packet_log_close(&packets);
    read_file("packets.ring");
    const char* const gap = strstr((const char*)content, " GAP\n"); // The records that are missing.
    TEST_ASSERT_NOT_NULL(gap);
    (void)memmove(content, &gap[5], strlen(&gap[5]) + 1U);
    const size_t count = line_numbers(numbers, 1024U);
    TEST_ASSERT_TRUE((count > 100U) && (count < 600U));
    for (size_t i = 0U; i < count; i++) { // The newest records, without a gap.
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

static void the_files_together_have_all_records(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    static const packet_log_strategy_t strategies[] = {PACKET_LOG_ASCII, PACKET_LOG_SQLITE, PACKET_LOG_RING};
    (void)memset(seen, 0, sizeof seen);
    open_log(PACKET_LOG_ASCII);
    for (unsigned i = 0U; i < 3000U; i++) {
        if (draw(20U) == 0U) {
            const packet_log_strategy_t next = strategies[draw(3U)];
            TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&packets, next));
            TEST_ASSERT_EQUAL(next, packets.strategy);
        }
        supervisor_packet_log_append(&packets, i, draw(2U) == 0U, packet, draw(300U));
        if (draw(10U) == 0U) {
            supervisor_packet_log_step(&packets, 0U);
        }
    }
    supervisor_packet_log_close(&packets);
    mark_lines("packets.ascii");
    mark_lines("packets.ring");
    mark_spool();
    for (unsigned number = 1U; number <= 3000U; number++) {
        TEST_ASSERT_EQUAL_MESSAGE(1U, seen[number], "a record is missing or duplicated");
    }
    TEST_ASSERT_EQUAL(3001U, packets.next_number);
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

static void an_unknown_log_strategy_is_refused(void)
{
    const uint8_t packet[1] = {0x18U};
    open_log(PACKET_LOG_ASCII);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, supervisor_packet_log_select(&packets, PACKET_LOG_POSTGRESQL));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, supervisor_packet_log_select(&packets, PACKET_LOG_STRATEGIES));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, supervisor_packet_log_select(&packets, (packet_log_strategy_t)255));
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    supervisor_packet_log_append(&packets, 0U, true, packet, 1U);
    supervisor_packet_log_close(&packets);
    TEST_ASSERT_EQUAL(
        STATUS_UNSUPPORTED,
        supervisor_packet_log_open(&packets, directory, PACKET_LOG_POSTGRESQL, &new_log, RING_RECORDS));
}

static void append(unsigned count)
{
    const uint8_t packet[1] = {0x18U};
    for (unsigned i = 0U; i < count; i++) {
        supervisor_packet_log_append(&packets, 0U, true, packet, 1U);
    }
}

static void a_strategy_that_cannot_open_leaves_the_old_one(void)
{
    // A directory has this name, so the file cannot be created.
    TEST_ASSERT_EQUAL(0, mkdir(path_of("packets.spool"), 0755));
    open_log(PACKET_LOG_ASCII);
    append(1U);
    TEST_ASSERT_EQUAL(STATUS_IO, supervisor_packet_log_select(&packets, PACKET_LOG_SQLITE));
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.wanted);
    append(1U);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 18\n2 0.000000000 TC 18\n");
}

static void records_of_the_ring_are_written_to_the_next_file(void)
{
    open_log(PACKET_LOG_ASCII);
    append(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&packets, PACKET_LOG_RING));
    append(2U);
    TEST_ASSERT_EQUAL(2U, packets.first_number);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&packets, PACKET_LOG_ASCII));
    TEST_ASSERT_EQUAL(2U, packets.first_number);
    append(1U);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 18\n2 0.000000000 TC 18\n3 0.000000000 TC 18\n"
                                 "4 0.000000000 TC 18\n");
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

static void the_mission_sets_the_number_of_records_in_the_ring(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      supervisor_packet_log_open(&packets, directory, PACKET_LOG_RING, &new_log, 3U));
    append(10U);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ring", "1 7 GAP\n8 0.000000000 TC 18\n9 0.000000000 TC 18\n10 0.000000000 TC 18\n");
    TEST_ASSERT_EQUAL(0U, packets.failures); // Lost records of a ring are not failures.
}

// ---- A disk that is full, read-only or gone ----

#define SECOND_NS 1000000000ULL

/// From now on the file of this name accepts no octets.
static void fill_disk(const char* name)
{
    TEST_ASSERT_EQUAL(0, symlink("/dev/full", path_of(name)));
}

/// Let files accept this many octets and no more.
static void limit_files(rlim_t octets)
{
    struct rlimit limit;
    (void)signal(SIGXFSZ, SIG_IGN);
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_FSIZE, &limit));
    limit.rlim_cur = octets;
    TEST_ASSERT_EQUAL(0, setrlimit(RLIMIT_FSIZE, &limit));
}

static void allow_large_files_again(void)
{
    struct rlimit limit;
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_FSIZE, &limit));
    limit_files(limit.rlim_max); // RLIM_INFINITY may be above the hard limit of the user.
}

static void opening_is_repeated_until_the_directory_exists(void)
{
    static char long_name[600];
    (void)memset(long_name, 'x', sizeof long_name - 1U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, supervisor_packet_log_open(&packets, long_name, PACKET_LOG_ASCII,
                                                                   &new_log, RING_RECORDS));
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_open(&packets, path_of("nowhere"), PACKET_LOG_ASCII,
                                                            &new_log, RING_RECORDS));
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.wanted);
    append(2U);
    TEST_ASSERT_EQUAL(0, mkdir(path_of("nowhere"), 0755));
    supervisor_packet_log_step(&packets, SECOND_NS - 1U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    supervisor_packet_log_step(&packets, SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(1U, packets.first_number);
    supervisor_packet_log_close(&packets);
    expect_text("nowhere/packets.ascii", "1 0.000000000 TC 18\n2 0.000000000 TC 18\n");
    (void)unlink(path_of("nowhere/packets.ascii"));
    (void)rmdir(path_of("nowhere"));
}

/// If the disk is full in the middle of a record, the incomplete record is removed. A record is a line of 20
/// octets or 22 octets of the spool, so the disk becomes full within the third to seventh record.
static void records_in_the_ring_survive_a_full_disk(void)
{
    static const packet_log_strategy_t strategies[] = {PACKET_LOG_ASCII, PACKET_LOG_SQLITE};
    for (size_t i = 0U; i < 2U; i++) {
        for (rlim_t room = 0U; room < 90U; room++) {
            (void)unlink(path_of("packets.ascii"));
            (void)unlink(path_of("packets.spool"));
            open_log(strategies[i]);
            append(2U);
            supervisor_packet_log_step(&packets, 0U);
            append(2U);
            limit_files(42U + room);
            supervisor_packet_log_step(&packets, 0U);
            append(3U);
            supervisor_packet_log_step(&packets, SECOND_NS);
            supervisor_packet_log_step(&packets, 3U * SECOND_NS);
            allow_large_files_again();
            supervisor_packet_log_step(&packets, 1000U * SECOND_NS);
            TEST_ASSERT_EQUAL(strategies[i], packets.strategy);
            append(1U);
            supervisor_packet_log_close(&packets);
            TEST_ASSERT_EQUAL(0U, packets.failures);
            (void)memset(seen, 0, sizeof seen);
            if (strategies[i] == PACKET_LOG_ASCII) {
                mark_lines("packets.ascii");
            } else {
                mark_spool();
            }
            for (unsigned number = 1U; number <= 8U; number++) {
                TEST_ASSERT_EQUAL_MESSAGE(1U, seen[number], "a record is missing or duplicated");
            }
        }
    }
}

static void packets_lost_in_the_ring_leave_a_gap_in_the_file(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      supervisor_packet_log_open(&packets, directory, PACKET_LOG_ASCII, &new_log, 2U));
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    limit_files(20U);
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    TEST_ASSERT_EQUAL(2U, packets.first_number);
    TEST_ASSERT_EQUAL(1U, packets.written_number);
    append(4U);
    allow_large_files_again();
    supervisor_packet_log_step(&packets, SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(5U, packets.first_number);
    TEST_ASSERT_EQUAL(3U, packets.failures);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ascii", "1 0.000000000 TC 18\n2 4 GAP\n5 0.000000000 TC 18\n6 0.000000000 TC 18\n");
}

/// The ring becomes full between two steps. The log then writes its records to the file; records that the
/// file does not accept are lost and counted.
static void more_records_than_the_ring_holds_are_written_between_two_steps(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    open_log(PACKET_LOG_ASCII);
    for (unsigned i = 0U; i < 140U; i++) {
        supervisor_packet_log_append(&packets, 0U, false, packet, sizeof packet);
    }
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(0U, packets.failures);
    supervisor_packet_log_close(&packets);
    TEST_ASSERT_EQUAL(140U, packets.written_number);
    fill_disk("packets.spool");
    open_log(PACKET_LOG_SQLITE);
    for (unsigned i = 0U; i < 140U; i++) {
        supervisor_packet_log_append(&packets, 5U * SECOND_NS, false, packet, sizeof packet);
    }
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    TEST_ASSERT_TRUE(packets.failures > 0U);
    TEST_ASSERT_EQUAL_UINT64(6U * SECOND_NS, packets.retry_ns); // 1 s after the packet.
    TEST_ASSERT_EQUAL(140U, packets.ring.blocks + packets.failures);
    fill_disk("packets.ring");
    supervisor_packet_log_close(&packets);
    TEST_ASSERT_EQUAL(140U, packets.failures); // The files accept none of the records that were in the ring.
}

/// The delays are 1 s, 2 s, 4 s and so on up to 32 s; after a minute without failure the first delay applies
/// again.
static void the_delay_between_retries_doubles_up_to_32_s(void)
{
    static const unsigned tries_s[] = {1U, 3U, 7U, 15U, 31U, 63U, 95U, 127U};
    fill_disk("packets.ascii");
    open_log(PACKET_LOG_ASCII);
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    for (size_t i = 0U; i < (sizeof tries_s / sizeof tries_s[0]); i++) {
        TEST_ASSERT_EQUAL_UINT64(tries_s[i] * SECOND_NS, packets.retry_ns);
        supervisor_packet_log_step(&packets, packets.retry_ns);
    }
    TEST_ASSERT_EQUAL(0, unlink(path_of("packets.ascii")));
    supervisor_packet_log_step(&packets, 159U * SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    limit_files(1U);
    append(1U);
    // A failure soon after has the same delay as before.
    supervisor_packet_log_step(&packets, 160U * SECOND_NS);
    TEST_ASSERT_EQUAL_UINT64(192U * SECOND_NS, packets.retry_ns);
    allow_large_files_again();
    supervisor_packet_log_step(&packets, 192U * SECOND_NS);
    limit_files(1U);
    append(1U);
    supervisor_packet_log_step(&packets, 252U * SECOND_NS);
    TEST_ASSERT_EQUAL_UINT64(253U * SECOND_NS, packets.retry_ns);
    allow_large_files_again();
}

static void a_file_that_was_removed_is_made_again(void)
{
    open_log(PACKET_LOG_ASCII);
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    supervisor_packet_log_step(&packets, 1U);
    (void)unlink(path_of("packets.ascii"));
    supervisor_packet_log_step(&packets, SECOND_NS - 1U);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    append(1U);
    supervisor_packet_log_step(&packets, SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    append(1U);
    supervisor_packet_log_step(&packets, 2U * SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(3U, packets.first_number); // packet-archive-sqlite merge reports 1 and 2 as missing.
    supervisor_packet_log_close(&packets);
    expect_text("packets.ascii", "3 0.000000000 TC 18\n");
}

/// A long ring is written to the file in several steps, while new records are added: 3500 lines of 20 to
/// 23 octets are more than one piece of PACKET_LOG_PIECE octets.
static void a_long_ring_is_written_in_portions(void)
{
    open_log(PACKET_LOG_ASCII);
    limit_files(0U);
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    append(3499U);
    allow_large_files_again();
    (void)memset(seen, 0, sizeof seen);
    for (unsigned step = 0U; step < 2U; step++) {
        TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
        supervisor_packet_log_step(&packets, SECOND_NS + step);
        append(1U);
    }
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_EQUAL(1U, packets.first_number);
    supervisor_packet_log_close(&packets);
    mark_lines("packets.ascii");
    for (unsigned number = 1U; number <= 3502U; number++) {
        TEST_ASSERT_EQUAL(1U, seen[number]);
    }
}

static void at_the_end_the_ring_is_written_to_the_disk(void)
{
    fill_disk("packets.ascii");
    open_log(PACKET_LOG_ASCII);
    append(2U);
    supervisor_packet_log_step(&packets, 0U);
    supervisor_packet_log_close(&packets);
    expect_text("packets.ring", "1 0.000000000 TC 18\n2 0.000000000 TC 18\n");
    TEST_ASSERT_EQUAL(0U, packets.failures);
    (void)unlink(path_of("packets.ring"));
    fill_disk("packets.ring");
    open_log(PACKET_LOG_ASCII);
    append(2U);
    supervisor_packet_log_close(&packets);
    TEST_ASSERT_EQUAL(2U, packets.failures);
}

static void a_file_that_cannot_be_truncated_is_truncated_later(void)
{
    fill_disk("packets.spool"); // The file can neither be written nor truncated.
    open_log(PACKET_LOG_SQLITE);
    append(1U);
    supervisor_packet_log_step(&packets, 0U);
    TEST_ASSERT_TRUE(packets.is_cut[PACKET_LOG_SQLITE]);
    TEST_ASSERT_EQUAL(0, unlink(path_of("packets.spool")));
    FILE* const file = fopen(path_of("packets.spool"), "wb");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL(3U, fwrite("abc", 1U, 3U, file)); // An incomplete record.
    (void)fclose(file);
    supervisor_packet_log_step(&packets, SECOND_NS);
    supervisor_packet_log_close(&packets);
    (void)memset(seen, 0, sizeof seen);
    mark_spool();
    TEST_ASSERT_EQUAL(1U, seen[1]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lines_are_numbered_and_timed);
    RUN_TEST(spool_records_are_binary);
    RUN_TEST(the_ring_is_written_to_its_file_when_the_log_is_closed);
    RUN_TEST(the_ring_keeps_the_newest_records);
    RUN_TEST(the_files_together_have_all_records);
    RUN_TEST(an_unknown_log_strategy_is_refused);
    RUN_TEST(a_strategy_that_cannot_open_leaves_the_old_one);
    RUN_TEST(records_of_the_ring_are_written_to_the_next_file);
    RUN_TEST(the_mission_sets_the_number_of_records_in_the_ring);
    RUN_TEST(opening_is_repeated_until_the_directory_exists);
    RUN_TEST(records_in_the_ring_survive_a_full_disk);
    RUN_TEST(packets_lost_in_the_ring_leave_a_gap_in_the_file);
    RUN_TEST(more_records_than_the_ring_holds_are_written_between_two_steps);
    RUN_TEST(the_delay_between_retries_doubles_up_to_32_s);
    RUN_TEST(a_file_that_was_removed_is_made_again);
    RUN_TEST(a_long_ring_is_written_in_portions);
    RUN_TEST(at_the_end_the_ring_is_written_to_the_disk);
    RUN_TEST(a_file_that_cannot_be_truncated_is_truncated_later);
    return UNITY_END();
}
