// SPDX-License-Identifier: Apache-2.0
// Lines of the log and pcap records are compared octet by octet; the files must be complete.
#include "sim/logs/frame_log.h"
#include "unity.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static char directory[32];
static char path[128];

void setUp(void)
{
    (void)strcpy(directory, "/tmp/hirosco-log-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
}

static const char* file_name(const char* suffix)
{
    (void)snprintf(path, sizeof path, "%s/can-robot.%s", directory, suffix);
    return path;
}

void tearDown(void)
{
    (void)unlink(file_name("log"));
    (void)unlink(file_name("pcap"));
    (void)rmdir(directory);
}

static void expect_line(const osal_can_frame_t* frame, const char* wanted)
{
    char text[FRAME_LOG_LINE_MAX + 1U];
    const size_t size = frame_log_line(frame, "robot", text);
    TEST_ASSERT_LESS_OR_EQUAL_UINT(FRAME_LOG_LINE_MAX, size);
    text[size] = '\0';
    TEST_ASSERT_EQUAL_STRING(wanted, text);
}

static void lines_of_all_kinds_have_the_format_of_candump(void)
{
    const osal_can_frame_t classic = {
        .time_ns = 1234567891U, .id = 0x123U, .length = 3U, .data = {0x0AU, 0xBCU, 0xFFU}};
    expect_line(&classic, "(0000000001.234567) robot 123#0ABCFF\n");
    const osal_can_frame_t sync = {.time_ns = 999U, .id = 0x080U};
    expect_line(&sync, "(0000000000.000000) robot 080#\n");
    const osal_can_frame_t fd = {.time_ns = 95000000000U,
                                 .id      = 0x191U,
                                 .length  = 8U,
                                 .flags   = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS,
                                 .data    = {0x01U, 0x23U, 0x45U, 0x67U, 0x89U, 0xABU, 0xCDU, 0xEFU}};
    expect_line(&fd, "(0000000095.000000) robot 191##10123456789ABCDEF\n");
    const osal_can_frame_t extended = {
        .time_ns = 1000U, .id = 0x12ABCDEFU | OSAL_CAN_EXTENDED, .length = 5U, .data = {1U, 2U, 3U, 4U, 5U}};
    expect_line(&extended, "(0000000000.000001) robot 12ABCDEF#0102030405\n");
    const osal_can_frame_t remote = {.id = 0x7FFU | OSAL_CAN_REMOTE, .length = 4U};
    expect_line(&remote, "(0000000000.000000) robot 7FF#R4\n");
    const osal_can_frame_t error = {
        .id = OSAL_CAN_ERROR | 0x4U, .length = 8U, .data = {0U, 0x20U, 0U, 0U, 0U, 0U, 128U, 0U}};
    expect_line(&error, "(0000000000.000000) robot 20000004#0020000000008000\n");
    osal_can_frame_t longest = {.time_ns = UINT32_MAX * 1000000000ULL,
                                .id      = 1U,
                                .length  = 64U,
                                .flags   = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_ESI};
    char text[FRAME_LOG_LINE_MAX];
    TEST_ASSERT_EQUAL_UINT(20U + 6U + 3U + 3U + 128U + 1U, frame_log_line(&longest, "robot", text));
}

static void times_have_ten_digits_of_seconds_and_six_of_microseconds(void)
{
    static const uint32_t starts[] = {0U, 90U, 9990U, 99990U, 9999990U, 99999990U, 123456780U, 4294967286U};
    for (size_t i = 0U; i < (sizeof starts / sizeof starts[0]); i++) {
        for (uint32_t k = 0U; k < 10U; k++) {
            const uint32_t seconds       = starts[i] + k;
            const uint32_t time_us       = (starts[i] * 7U + k * 111111U) % 1000000U;
            const osal_can_frame_t frame = {.time_ns = (seconds * 1000000000ULL) + (time_us * 1000ULL),
                                            .id      = 1U};
            char wanted[FRAME_LOG_LINE_MAX];
            (void)snprintf(wanted, sizeof wanted, "(%010u.%06u) robot 001#\n", seconds, time_us);
            expect_line(&frame, wanted);
        }
    }
}

static void every_octet_is_written_as_two_hexadecimal_digits(void)
{
    for (unsigned value = 0U; value < 256U; value++) {
        osal_can_frame_t frame = {.id = 1U, .length = 8U};
        char text[FRAME_LOG_LINE_MAX];
        char wanted[20];
        memset(frame.data, (int)value, 8U);
        (void)snprintf(wanted, sizeof wanted, "%02X%02X%02X%02X%02X%02X%02X%02X", value, value, value, value,
                       value, value, value, value);
        (void)frame_log_line(&frame, "robot", text);
        TEST_ASSERT_EQUAL_MEMORY(wanted, strchr(text, '#') + 1, 16U);
    }
}

static void pcap_records_of_all_kinds_have_the_format_of_socketcan(void)
{
    uint8_t octets[FRAME_LOG_RECORD_MAX];
    const osal_can_frame_t fd = {.time_ns = 3000000005U,
                                 .id      = 0x191U,
                                 .length  = 2U,
                                 .flags   = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS,
                                 .data    = {0xAAU, 0xBBU}};
    // Seconds, nanoseconds and both lengths (little-endian); identifier (big-endian), length, flags; data.
    const uint8_t wanted[] = {3, 0, 0, 0, 5, 0,    0,    0, 10, 0, 0, 0,    10,
                              0, 0, 0, 0, 0, 0x01, 0x91, 2, 5,  0, 0, 0xAA, 0xBB};
    TEST_ASSERT_EQUAL_UINT(sizeof wanted, frame_log_record(&fd, octets));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(wanted, octets, sizeof wanted);
    const osal_can_frame_t error = {.id = OSAL_CAN_ERROR | 0x20U, .length = 8U};
    TEST_ASSERT_EQUAL_UINT(32U, frame_log_record(&error, octets));
    TEST_ASSERT_EQUAL_HEX8(0x20U, octets[16]);
    TEST_ASSERT_EQUAL_HEX8(0x20U, octets[19]);
    osal_can_frame_t longest = {.id = 1U, .length = 64U, .flags = OSAL_CAN_FLAG_FD};
    TEST_ASSERT_EQUAL_UINT(88U, frame_log_record(&longest, octets));
}

static long size_of(const char* suffix)
{
    FILE* file = fopen(file_name(suffix), "rb");
    TEST_ASSERT_NOT_NULL(file);
    (void)fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    (void)fclose(file);
    return size;
}

static void files_hold_every_frame(void)
{
    frame_log_t* log = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_open(directory, "robot", &log));
    const osal_can_frame_t frame = {.id = 0x123U, .length = 8U};
    for (unsigned i = 0U; i < 20000U; i++) { // More than the buffers hold.
        frame_log_write(log, &frame);
    }
    frame_log_flush(log, true);
    const long line = (long)strlen("(0000000000.000000) robot 123#0000000000000000\n");
    TEST_ASSERT_EQUAL_INT(20000 * line, size_of("log"));
    TEST_ASSERT_EQUAL_INT(24 + (20000 * 32), size_of("pcap"));
    frame_log_write(log, &frame);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_close(log));
    TEST_ASSERT_EQUAL_INT(20001 * line, size_of("log"));
}

static void the_pcap_header_names_socketcan_and_nanoseconds(void)
{
    // Magic of pcap with nanoseconds, version 2.4; largest packet 0x40000, link type 227 (SocketCAN).
    static const uint8_t wanted[24] = {0x4D, 0x3C, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0,  0,
                                       0,    0,    0,    0,    0, 0, 0, 4, 0, 227};
    uint8_t octets[24];
    frame_log_t* log = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_open(directory, "robot", &log));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_close(log));
    FILE* file = fopen(file_name("pcap"), "rb");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_UINT(24U, fread(octets, 1U, 24U, file));
    (void)fclose(file);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(wanted, octets, 24U);
}

static void a_log_that_cannot_be_written_is_reported(void)
{
    frame_log_t* log = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_IO, frame_log_open("/nowhere", "robot", &log));
    TEST_ASSERT_NULL(log);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, frame_log_open(directory, "a-name-of-17-char", &log));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_close(NULL));
    // Writing to /dev/full fails as on a full disk.
    (void)unlink(file_name("log"));
    if (symlink("/dev/full", file_name("log")) == 0) {
        const osal_can_frame_t frame = {.id = 1U};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_open(directory, "robot", &log));
        frame_log_write(log, &frame);
        TEST_ASSERT_EQUAL_INT(STATUS_IO, frame_log_close(log));
    }
}

static void a_full_disk_leaves_complete_lines_and_records(void)
{
    frame_log_t* log = NULL;
    struct rlimit limit;
    const osal_can_frame_t frame = {.id = 0x123U, .length = 8U};
    const long line              = (long)strlen("(0000000000.000000) robot 123#0000000000000000\n");
    TEST_ASSERT_EQUAL_INT(STATUS_OK, frame_log_open(directory, "robot", &log));
    frame_log_write(log, &frame);
    frame_log_flush(log, true);
    TEST_ASSERT_EQUAL_INT(0, getrlimit(RLIMIT_FSIZE, &limit));
    const rlim_t before = limit.rlim_cur;
    // Room for two lines and a part of a third; in pcap for the header, two records and a part. A flush that
    // fails is removed as a whole, so only what the first flush wrote stays.
    limit.rlim_cur = 110U;
    (void)signal(SIGXFSZ, SIG_IGN);
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
    for (unsigned i = 0U; i < 10U; i++) {
        frame_log_write(log, &frame);
    }
    frame_log_flush(log, true);
    limit.rlim_cur = before;
    TEST_ASSERT_EQUAL_INT(0, setrlimit(RLIMIT_FSIZE, &limit));
    // After a failure the log writes nothing more, because a reader could not detect the gap.
    frame_log_write(log, &frame);
    TEST_ASSERT_EQUAL_INT(STATUS_IO, frame_log_close(log));
    TEST_ASSERT_EQUAL_INT(line, size_of("log"));
    TEST_ASSERT_EQUAL_INT(24 + 32, size_of("pcap"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lines_of_all_kinds_have_the_format_of_candump);
    RUN_TEST(times_have_ten_digits_of_seconds_and_six_of_microseconds);
    RUN_TEST(every_octet_is_written_as_two_hexadecimal_digits);
    RUN_TEST(pcap_records_of_all_kinds_have_the_format_of_socketcan);
    RUN_TEST(files_hold_every_frame);
    RUN_TEST(the_pcap_header_names_socketcan_and_nanoseconds);
    RUN_TEST(a_log_that_cannot_be_written_is_reported);
    RUN_TEST(a_full_disk_leaves_complete_lines_and_records);
    return UNITY_END();
}
