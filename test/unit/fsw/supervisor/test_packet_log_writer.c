// SPDX-License-Identifier: Apache-2.0
// The packet log with a task of its own, for a disk that is slow, does not respond, or fails.
#define _GNU_SOURCE
#include "fsw/supervisor/packet_log.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_MAX 4194304U
#define RING_RECORDS 4096U
#define PIPE_OCTETS 4096
#define RECORD_AROUND 21U ///< Octets that a record has in the ring beside its packet.
#define SECOND_NS 1000000000ULL

static const packet_log_past_t new_log = {.next_number = 1U};
static packet_log_t packets;
static char directory[64];
static char content[FILE_MAX];
static size_t content_size;
static int pipe_end = -1; // Read end of the pipe that replaces the file.
static osal_task_t reader;

static const char* path_of(const char* name)
{
    static char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void close_pipe(void)
{
    if (pipe_end >= 0) {
        (void)close(pipe_end);
        pipe_end = -1;
    }
}

void setUp(void)
{
    (void)snprintf(directory, sizeof directory, "/tmp/hirosco-log-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
}

void tearDown(void)
{
    close_pipe(); // A write that waits for the pipe ends.
    supervisor_packet_log_close(&packets);
    (void)unlink(path_of("packets.ascii"));
    (void)unlink(path_of("packets.spool"));
    (void)unlink(path_of("packets.ring"));
    TEST_ASSERT_EQUAL(0, rmdir(directory));
}

static void append(unsigned count)
{
    const uint8_t packet[1] = {0x18U};
    for (unsigned i = 0U; i < count; i++) {
        supervisor_packet_log_append(&packets, 0U, true, packet, 1U);
    }
}

static uint32_t draw(uint32_t below)
{
    static uint32_t state = 13U;
    state                 = (state * 1664525U) + 1013904223U;
    return (state >> 8U) % below;
}

/// The file is a pipe: a write ends when the test has read enough of it.
static void open_slow_log(uint32_t ring_records)
{
    (void)signal(SIGPIPE, SIG_IGN);
    TEST_ASSERT_EQUAL(0, mkfifo(path_of("packets.ascii"), 0644));
    pipe_end = open(path_of("packets.ascii"), O_RDONLY | O_NONBLOCK);
    TEST_ASSERT_TRUE(pipe_end >= 0);
    TEST_ASSERT_TRUE(fcntl(pipe_end, F_SETPIPE_SZ, PIPE_OCTETS) >= 0);
    TEST_ASSERT_EQUAL(
        STATUS_OK, supervisor_packet_log_open(&packets, directory, PACKET_LOG_ASCII, &new_log, ring_records));
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_start_writer(&packets));
    content_size = 0U;
}

static void read_pipe(void)
{
    const ssize_t size = read(pipe_end, &content[content_size], FILE_MAX - 1U - content_size);
    content_size += (size > 0) ? (size_t)size : 0U;
    content[content_size] = '\0';
}

/// Read the pipe until the writer is done, then step the log at this time.
static void finish_writing(uint64_t now_ns)
{
    while (__atomic_load_n(&packets.is_busy, __ATOMIC_ACQUIRE)) {
        read_pipe();
    }
    supervisor_packet_log_step(&packets, now_ns);
}

static void read_until_closed(void* context)
{
    (void)context;
    ssize_t size = 1;
    TEST_ASSERT_EQUAL(0, fcntl(pipe_end, F_SETFL, 0));
    while (size > 0) {
        size = read(pipe_end, &content[content_size], FILE_MAX - 1U - content_size);
        content_size += (size > 0) ? (size_t)size : 0U;
    }
    content[content_size] = '\0';
}

/// The writer may still wait: the log can be closed only while the pipe is read.
static void close_slow_log(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&reader, read_until_closed, NULL, 0));
    supervisor_packet_log_close(&packets);
    osal_task_join(&reader);
    close_pipe();
}

static void read_file(const char* name)
{
    FILE* const file = fopen(path_of(name), "rb");
    TEST_ASSERT_NOT_NULL(file);
    content_size          = fread(content, 1U, FILE_MAX - 1U, file);
    content[content_size] = '\0';
    (void)fclose(file);
}

/// Expect the lines of these records. Returns the place after them.
static const char* expect_records(const char* line, uint64_t first, uint64_t last)
{
    for (uint64_t number = first; number <= last; number++) {
        TEST_ASSERT_EQUAL_UINT64(number, strtoull(line, NULL, 10));
        line = strchr(line, '\n');
        TEST_ASSERT_NOT_NULL(line);
        line++;
    }
    return line;
}

static void expect_numbers(uint64_t first, uint64_t last)
{
    TEST_ASSERT_EQUAL_STRING("", expect_records(content, first, last));
}

/// The pipe is not read: a step that waited for the disk would not return.
static void a_slow_disk_does_not_delay_the_supervisor(void)
{
    open_slow_log(RING_RECORDS);
    append(300U); // More than the pipe holds.
    supervisor_packet_log_step(&packets, 0U);
    append(1U);
    supervisor_packet_log_step(&packets, SECOND_NS - 1U);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy); // The disk does not count as slow yet.
    TEST_ASSERT_EQUAL(0U, packets.written_number);
    supervisor_packet_log_step(&packets, SECOND_NS);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.wanted);
    TEST_ASSERT_EQUAL(1U, packets.first_number);
    append(300U);
    supervisor_packet_log_step(&packets, 5U * SECOND_NS);
    TEST_ASSERT_EQUAL(0U, packets.written_number);
    finish_writing(6U * SECOND_NS); // The first piece is written; the next one begins.
    TEST_ASSERT_EQUAL(300U, packets.written_number);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    finish_writing(6U * SECOND_NS);
    TEST_ASSERT_EQUAL(601U, packets.written_number);
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    TEST_ASSERT_TRUE(packets.slowest_ns > 0U);
    append(1U);
    supervisor_packet_log_step(&packets, 6U * SECOND_NS);
    close_slow_log();
    expect_numbers(1U, 602U);
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

/// Each piece takes longer than a second: the ring stays selected, and the file still gets everything that it
/// accepts.
static void the_ring_stays_selected_while_the_disk_is_slow(void)
{
    open_slow_log(RING_RECORDS);
    append(300U);
    supervisor_packet_log_step(&packets, 0U);
    supervisor_packet_log_step(&packets, SECOND_NS);
    for (unsigned i = 1U; i <= 5U; i++) {
        append(300U);
        finish_writing(((i * 2U) * SECOND_NS));
        TEST_ASSERT_EQUAL(i * 300U, packets.written_number);
        TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    }
    close_slow_log();
    expect_numbers(1U, 1800U);
}

/// The piece that is being written is not lost, even if the ring needs its place.
static void the_ring_overflows_while_the_disk_is_slow(void)
{
    open_slow_log(100U);
    append(300U);
    supervisor_packet_log_step(&packets, 0U);
    append(100U);
    supervisor_packet_log_step(&packets, SECOND_NS); // From now on the ring keeps 100 records.
    append(100U);
    TEST_ASSERT_EQUAL(400U, packets.failures);
    finish_writing(SECOND_NS);
    TEST_ASSERT_EQUAL(100U, packets.failures);
    close_slow_log();
    TEST_ASSERT_EQUAL(100U, packets.failures);
    TEST_ASSERT_NOT_NULL(strstr(content, "\n300 0.000000000 TC 18\n301 400 GAP\n401 0.000000000 "));
    TEST_ASSERT_NOT_NULL(strstr(content, "\n500 0.000000000 TC 18\n"));
}

/// More records than the ring holds come before the disk is reported as slow: the file has those of the
/// piece, then a gap, then the newest ones.
static void records_beyond_the_ring_are_counted_while_the_disk_is_slow(void)
{
    static uint8_t packet[PUS_PACKET_MAX];
    const uint32_t lost = 140U - (PACKET_LOG_RING_OCTETS / (RECORD_AROUND + PUS_PACKET_MAX));
    char gap[32];
    open_slow_log(RING_RECORDS);
    append(300U);
    supervisor_packet_log_step(&packets, 0U);
    for (unsigned i = 0U; i < 140U; i++) {
        supervisor_packet_log_append(&packets, 0U, false, packet, sizeof packet);
    }
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    const uint32_t overwritten = packets.failures; // Those of the piece included.
    close_slow_log();
    TEST_ASSERT_EQUAL(300U + lost, overwritten);
    TEST_ASSERT_EQUAL(lost, packets.failures);
    const char* const place = expect_records(content, 1U, 300U);
    const int length        = snprintf(gap, sizeof gap, "301 %u GAP\n", 300U + lost);
    TEST_ASSERT_EQUAL_STRING_LEN(gap, place, length);
    TEST_ASSERT_EQUAL_STRING("", expect_records(&place[length], 301U + lost, 440U));
}

static void a_strategy_is_selected_while_the_disk_is_slow(void)
{
    open_slow_log(RING_RECORDS);
    append(300U);
    supervisor_packet_log_step(&packets, 0U);
    append(2U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, supervisor_packet_log_select(&packets, PACKET_LOG_SQLITE));
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.wanted);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&packets, PACKET_LOG_RING));
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.wanted);
    finish_writing(0U);
    TEST_ASSERT_EQUAL(300U, packets.written_number); // The piece in progress is in the file.
    TEST_ASSERT_FALSE(packets.is_open);
    read_pipe();
    expect_numbers(1U, 300U);
    close_pipe();
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&packets, PACKET_LOG_SQLITE));
    TEST_ASSERT_EQUAL(301U, packets.first_number);
    append(1U);
    supervisor_packet_log_close(&packets);
    TEST_ASSERT_EQUAL(303U, packets.written_number);
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

/// The disk fails during a write of the task; the log retries as without a task.
static void a_disk_that_fails_during_a_write_is_retried(void)
{
    open_slow_log(RING_RECORDS);
    append(300U);
    supervisor_packet_log_step(&packets, 0U);
    close_pipe();
    while (__atomic_load_n(&packets.is_busy, __ATOMIC_ACQUIRE)) {
    }
    supervisor_packet_log_step(&packets, 0U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, packets.strategy);
    TEST_ASSERT_EQUAL_UINT64(SECOND_NS, packets.retry_ns);
    TEST_ASSERT_EQUAL_UINT64(0U, packets.whole[PACKET_LOG_ASCII]); // A pipe cannot be truncated.
    TEST_ASSERT_EQUAL(0, unlink(path_of("packets.ascii")));
    for (unsigned i = 0U; (packets.strategy == PACKET_LOG_RING) && (i < 100000U); i++) {
        supervisor_packet_log_step(&packets, SECOND_NS);
        (void)usleep(100U);
    }
    TEST_ASSERT_EQUAL(PACKET_LOG_ASCII, packets.strategy);
    supervisor_packet_log_close(&packets);
    read_file("packets.ascii");
    expect_numbers(1U, 300U);
    TEST_ASSERT_EQUAL(0U, packets.failures);
}

/// The program is killed at any moment of a write: its successor has each record once, whatever the file has
/// received.
static void after_a_kill_during_a_write_the_log_has_each_record_once(void)
{
    static uint8_t ring[PACKET_LOG_RING_OCTETS];
    for (unsigned round = 0U; round < 50U; round++) {
        (void)unlink(path_of("packets.ascii"));
        TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_open(&packets, directory, PACKET_LOG_ASCII,
                                                                &new_log, RING_RECORDS));
        TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_start_writer(&packets));
        append(100U);
        supervisor_packet_log_step(&packets, 0U);
        append(draw(100U));
        for (unsigned i = draw(3U); i > 0U; i--) {
            supervisor_packet_log_step(&packets, 0U);
        }
        const size_t octets          = message_ring_copy(&packets.ring, ring, sizeof ring);
        const packet_log_past_t past = {.next_number    = packets.next_number,
                                        .written_number = packets.written_number,
                                        .sizes          = {packets.whole[PACKET_LOG_ASCII]},
                                        .ring           = ring,
                                        .ring_octets    = octets};
        supervisor_packet_log_close(&packets); // These records were written after the last commit.
        TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_open(&packets, directory, PACKET_LOG_ASCII, &past,
                                                                RING_RECORDS));
        append(1U);
        supervisor_packet_log_close(&packets);
        read_file("packets.ascii");
        expect_numbers(1U, past.next_number);
    }
}

int main(void)
{
    (void)alarm(120U); // A write to a disk that accepts no octets does not end.
    UNITY_BEGIN();
    RUN_TEST(a_slow_disk_does_not_delay_the_supervisor);
    RUN_TEST(the_ring_stays_selected_while_the_disk_is_slow);
    RUN_TEST(the_ring_overflows_while_the_disk_is_slow);
    RUN_TEST(records_beyond_the_ring_are_counted_while_the_disk_is_slow);
    RUN_TEST(a_strategy_is_selected_while_the_disk_is_slow);
    RUN_TEST(a_disk_that_fails_during_a_write_is_retried);
    RUN_TEST(after_a_kill_during_a_write_the_log_has_each_record_once);
    return UNITY_END();
}
