// SPDX-License-Identifier: Apache-2.0
// Records between a proxy and its remote-endian program: contents as octets, independent of the byte order
// of this machine, and the refusal of all other contents.
#include "fsw/programs/remote_endian_wire.h"

#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unity.h"

#define TIMEOUT_MS 10000U
#define HEAD_OCTETS 5U ///< Length field and kind of a record.

static remote_endian_wire_t one;
static remote_endian_wire_t other;

void setUp(void)
{
    one   = (remote_endian_wire_t){.received = 0U};
    other = (remote_endian_wire_t){.received = 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_local_pair(&one.socket, &other.socket));
}

void tearDown(void)
{
    osal_socket_close(&one.socket);
    osal_socket_close(&other.socket);
}

static run_state_t sample_run(void)
{
    run_state_t run   = {.identity          = "hirosco-1",
                         .is_stepped        = true,
                         .computer_count    = 1U,
                         .computer_ipv4     = {OSAL_IPV4_LOOPBACK},
                         .link_methods      = 4U,
                         .mission_path      = "descriptors/missions/rokviss.xml",
                         .mission_hash      = 0x0123456789ABCDEFULL,
                         .directory         = "runs/x",
                         .storage           = "runs/x/storage",
                         .ground_descriptor = -1,
                         .component_count   = 2U};
    run.components[0] = (run_component_t){
        .apid = 1U, .name = "SUPERVISOR", .message_descriptor = 7, .message_port = 40001U, .life = 1U};
    run.components[1] = (run_component_t){.apid               = 16U,
                                          .name               = "MANIPULATOR",
                                          .message_descriptor = 8,
                                          .message_port       = 40002U,
                                          .message_window     = 8192U,
                                          .life               = 3U,
                                          .link_floor         = 5U};
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        run.link_descriptors[i] = -1;
    }
    run.link_descriptors[1] = 12;
    run.link_ports[1]       = 40100U;
    return run;
}

static void the_run_state_passes_the_wire_unchanged(void)
{
    const run_state_t run = sample_run();
    static run_state_t heard;
    unsigned component    = 0U;
    octet_reader_t reader = octet_reader(NULL, 0U);
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_RUN);
    remote_endian_write_run(&writer, &run, 1U, run.storage);
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&one, &writer));
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_RUN, TIMEOUT_MS, &reader));
    TEST_ASSERT_TRUE(remote_endian_read_run(&reader, &heard, &component));
    TEST_ASSERT_EQUAL_UINT(1U, component);
    TEST_ASSERT_TRUE(heard.is_stepped);
    TEST_ASSERT_EQUAL_STRING(run.identity, heard.identity);
    TEST_ASSERT_EQUAL_STRING(run.mission_path, heard.mission_path);
    TEST_ASSERT_EQUAL_HEX64(run.mission_hash, heard.mission_hash);
    TEST_ASSERT_EQUAL_STRING(run.directory, heard.directory);
    TEST_ASSERT_EQUAL_STRING(run.storage, heard.storage);
    TEST_ASSERT_EQUAL_HEX8(4U, heard.link_methods);
    TEST_ASSERT_EQUAL_HEX32(OSAL_IPV4_LOOPBACK, heard.computer_ipv4[0]);
    TEST_ASSERT_EQUAL_UINT16(2U, heard.component_count);
    TEST_ASSERT_EQUAL(RUN_TRANSPORT_UDP, heard.transport);
    TEST_ASSERT_EQUAL_UINT8(1U, heard.computer_count);
    TEST_ASSERT_EQUAL_INT(-1, heard.ground_descriptor);
    TEST_ASSERT_EQUAL_STRING("SUPERVISOR", heard.components[0].name);
    TEST_ASSERT_EQUAL_UINT16(1U, heard.components[0].apid);
    TEST_ASSERT_EQUAL_INT(7, heard.components[0].message_descriptor);
    TEST_ASSERT_EQUAL_UINT16(40001U, heard.components[0].message_port);
    TEST_ASSERT_EQUAL_UINT32(1U, heard.components[0].life);
    TEST_ASSERT_EQUAL_UINT32(0U, heard.components[0].link_floor);
    TEST_ASSERT_EQUAL_STRING("MANIPULATOR", heard.components[1].name);
    TEST_ASSERT_EQUAL_UINT16(16U, heard.components[1].apid);
    TEST_ASSERT_EQUAL_INT(8, heard.components[1].message_descriptor);
    TEST_ASSERT_EQUAL_UINT16(40002U, heard.components[1].message_port);
    TEST_ASSERT_EQUAL_UINT32(0U, heard.components[0].message_window);
    TEST_ASSERT_EQUAL_UINT32(8192U, heard.components[1].message_window);
    TEST_ASSERT_EQUAL_UINT32(3U, heard.components[1].life);
    TEST_ASSERT_EQUAL_UINT32(5U, heard.components[1].link_floor);
    TEST_ASSERT_EQUAL_INT_ARRAY(run.link_descriptors, heard.link_descriptors, RUN_LINKS_MAX);
    TEST_ASSERT_EQUAL_UINT16_ARRAY(run.link_ports, heard.link_ports, RUN_LINKS_MAX);
}

#define MANY 200U // Number of records; together they exceed the buffer of a socket.

/// The largest content of a record, many times; the sender waits while the socket is full.
static void the_largest_records_arrive_completely(void)
{
    octet_reader_t reader = octet_reader(NULL, 0U);
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
    const size_t size     = sizeof one.octets - writer.position;
    uint8_t* const space  = octet_write_space(&writer, size);
    TEST_ASSERT_NOT_NULL(space);
    for (size_t i = 0U; i < size; i++) {
        space[i] = (uint8_t)((i * 7U) >> 3U);
    }
    const pid_t sender = fork();
    if (sender == 0) {
        status_t status = STATUS_OK;
        for (unsigned i = 0U; (i < MANY) && (status == STATUS_OK); i++) {
            status = remote_endian_send(&one, &writer);
        }
        _exit((status == STATUS_OK) ? 0 : 1);
    }
    for (unsigned i = 0U; i < MANY; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_DONE, TIMEOUT_MS, &reader));
        TEST_ASSERT_EQUAL(size, octet_reader_left(&reader));
        TEST_ASSERT_EQUAL_MEMORY(space, octet_read_octets(&reader, size), size);
    }
    int result = -1;
    TEST_ASSERT_EQUAL(sender, waitpid(sender, &result, 0));
    TEST_ASSERT_EQUAL(0, result);
}

static void a_truncated_run_state_or_one_out_of_bounds_is_refused(void)
{
    run_state_t run = sample_run();
    static run_state_t heard;
    unsigned component    = 0U;
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_RUN);
    remote_endian_write_run(&writer, &run, 1U, run.storage);
    const size_t size = writer.position - HEAD_OCTETS;
    for (size_t cut = 0U; cut < size; cut++) {
        octet_reader_t reader = octet_reader(&one.octets[HEAD_OCTETS], cut);
        TEST_ASSERT_FALSE(remote_endian_read_run(&reader, &heard, &component));
    }
    octet_reader_t longer = octet_reader(&one.octets[HEAD_OCTETS], size + 1U);
    TEST_ASSERT_FALSE(remote_endian_read_run(&longer, &heard, &component));
    // The component's index follows after identity, mission path and directories, each with its length in
    // front, and after the hash.
    const size_t index = HEAD_OCTETS + 8U + 8U + strlen(run.identity) + strlen(run.mission_path) +
                         strlen(run.directory) + strlen(run.storage);
    octets_put_u32(&one.octets[index], 2U);
    octet_reader_t beyond = octet_reader(&one.octets[HEAD_OCTETS], size);
    TEST_ASSERT_FALSE(remote_endian_read_run(&beyond, &heard, &component));
}

static void numbers_are_big_endian(void)
{
    static run_state_t other_run;
    other_run                       = sample_run();
    static const uint8_t expected[] = {0x00, 0x00, 0x00, 0x21, 0x03, 0x01, 0x02, 0x03, 0x04, 0x05,
                                       0x06, 0x07, 0x08, 0x00, 0x00, 0x00, 0x09, 0x0A, 0x0B, 0x0C,
                                       0x0D, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,
                                       0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x07};
    const osal_grant_t grant        = {0x0102030405060708U, 9U, 0x0A0B0C0DU};
    octet_writer_t writer           = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    octet_reader_t reader           = octet_reader(NULL, 0U);
    osal_grant_t heard              = {0U, 0U, 0U};
    run_state_t run                 = sample_run();
    run.components[0].life          = 1U;
    run.components[1].life          = 3U;
    run.components[1].link_floor    = 7U;
    remote_endian_write_grant(&writer, &grant, &run);
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&one, &writer));
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_GRANT, TIMEOUT_MS, &reader));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, other.octets, sizeof expected);
    TEST_ASSERT_TRUE(remote_endian_read_grant(&reader, &heard, &other_run));
    TEST_ASSERT_EQUAL_UINT32(3U, other_run.components[1].life);
    TEST_ASSERT_EQUAL_UINT32(7U, other_run.components[1].link_floor);
    TEST_ASSERT_EQUAL_HEX64(grant.now_ns, heard.now_ns);
    TEST_ASSERT_EQUAL_UINT32(9U, heard.messages);
    TEST_ASSERT_EQUAL_HEX32(grant.octets, heard.octets);
}

static void a_done_record_carries_its_values(void)
{
    remote_endian_done_t done = {.wake_ns = OSAL_LOCKSTEP_NEVER, .opened = 5U, .is_lossy = true};
    remote_endian_done_t heard;
    done.deliveries.lives[1]    = 4U;
    done.deliveries.messages[1] = 2U;
    done.deliveries.octets[15]  = 300U;
    octet_writer_t writer       = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
    remote_endian_write_done(&writer, &done);
    octet_reader_t reader = octet_reader(&one.octets[HEAD_OCTETS], writer.position - HEAD_OCTETS);
    TEST_ASSERT_TRUE(remote_endian_read_done(&reader, &heard));
    TEST_ASSERT_EQUAL_HEX64(done.wake_ns, heard.wake_ns);
    TEST_ASSERT_EQUAL_HEX32(5U, heard.opened);
    TEST_ASSERT_TRUE(heard.is_lossy);
    TEST_ASSERT_EQUAL_UINT32(4U, heard.deliveries.lives[1]);
    TEST_ASSERT_EQUAL_UINT32(2U, heard.deliveries.messages[1]);
    TEST_ASSERT_EQUAL_UINT32(300U, heard.deliveries.octets[15]);
    octet_reader_t cut = octet_reader(&one.octets[HEAD_OCTETS], writer.position - HEAD_OCTETS - 1U);
    TEST_ASSERT_FALSE(remote_endian_read_done(&cut, &heard));
    done.is_lossy = false;
    writer        = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
    remote_endian_write_done(&writer, &done);
    reader = octet_reader(&one.octets[HEAD_OCTETS], writer.position - HEAD_OCTETS);
    TEST_ASSERT_TRUE(remote_endian_read_done(&reader, &heard));
    TEST_ASSERT_FALSE(heard.is_lossy);
}

static void receive_refuses(const uint8_t* const octets, const size_t size, const status_t expected)
{
    size_t sent = 0U;
    octet_reader_t reader;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&one.socket, octets, size, &sent));
    TEST_ASSERT_EQUAL(size, sent);
    TEST_ASSERT_EQUAL(expected, remote_endian_receive(&other, REMOTE_ENDIAN_GRANT, 0U, &reader));
}

static void invalid_records_are_refused(void)
{
    static const uint8_t empty[]      = {0U, 0U, 0U, 0U};
    static const uint8_t huge[]       = {0xFFU, 0xFFU, 0xFFU, 0xFFU};
    static const uint8_t other_kind[] = {0U, 0U, 0U, 1U, REMOTE_ENDIAN_DONE};
    receive_refuses(empty, sizeof empty, STATUS_INVALID);
    tearDown();
    setUp();
    receive_refuses(huge, sizeof huge, STATUS_INVALID);
    tearDown();
    setUp();
    receive_refuses(other_kind, sizeof other_kind, STATUS_INVALID);
}

static void a_record_may_arrive_in_pieces(void)
{
    static const uint8_t octets[] = {0U, 0U, 0U, 2U, REMOTE_ENDIAN_GRANT, 0x5AU};
    octet_reader_t reader         = octet_reader(NULL, 0U);
    for (size_t i = 0U; i < (sizeof octets - 1U); i++) {
        receive_refuses(&octets[i], 1U, STATUS_TIMEOUT);
    }
    size_t sent = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&one.socket, &octets[5], 1U, &sent));
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_GRANT, TIMEOUT_MS, &reader));
    TEST_ASSERT_EQUAL_HEX8(0x5AU, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

/// Each end sends and receives in turn, several times, over the same memory.
static void records_follow_each_other_in_both_directions(void)
{
    for (uint8_t turn = 0U; turn < 3U; turn++) {
        octet_reader_t reader = octet_reader(NULL, 0U);
        octet_writer_t done   = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
        octet_write_u8(&done, turn);
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&one, &done));
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_DONE, TIMEOUT_MS, &reader));
        TEST_ASSERT_EQUAL_UINT8(turn, octet_read_u8(&reader));
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
        octet_writer_t grant = remote_endian_begin(&other, REMOTE_ENDIAN_GRANT);
        octet_write_u32(&grant, 100U + turn);
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&other, &grant));
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&one, REMOTE_ENDIAN_GRANT, TIMEOUT_MS, &reader));
        TEST_ASSERT_EQUAL_UINT32(100U + turn, octet_read_u32(&reader));
        TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    }
    octet_reader_t nothing = octet_reader((const uint8_t*)"x", 1U);
    octet_writer_t empty   = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&one, &empty)); // A record of a kind without content.
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_DONE, TIMEOUT_MS, &nothing));
    TEST_ASSERT_TRUE(octet_reader_is_done(&nothing));
    for (uint8_t i = 0U; i < 2U; i++) { // Two records in one direction.
        octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_DONE);
        octet_write_u8(&writer, i);
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send(&one, &writer));
    }
    for (uint8_t i = 0U; i < 2U; i++) {
        octet_reader_t reader = octet_reader(NULL, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_DONE, TIMEOUT_MS, &reader));
        TEST_ASSERT_EQUAL_UINT8(i, octet_read_u8(&reader));
    }
}

static void the_end_of_the_peer_is_detected(void)
{
    octet_reader_t reader;
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    osal_socket_close(&other.socket);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, remote_endian_receive(&one, REMOTE_ENDIAN_DONE, TIMEOUT_MS, &reader));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, remote_endian_send(&one, &writer));
}

static void a_receiver_does_not_wait_longer_than_it_may(void)
{
    octet_reader_t reader;
    for (uint32_t timeout_ms = 0U; timeout_ms <= 3U; timeout_ms++) {
        TEST_ASSERT_EQUAL(STATUS_TIMEOUT,
                          remote_endian_receive(&one, REMOTE_ENDIAN_GRANT, timeout_ms, &reader));
    }
}

/// A peer that sends when it should read does not follow the protocol.
static void a_peer_that_does_not_read_its_record_is_detected(void)
{
    static const uint8_t octets[4096];
    size_t sent           = 0U;
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    while (osal_stream_send(&one.socket, octets, sizeof octets, &sent) == STATUS_OK) {
        // Until the socket is full.
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_stream_send(&other.socket, octets, 1U, &sent));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, remote_endian_send(&one, &writer));
}

static void a_record_that_does_not_fit_is_not_sent(void)
{
    octet_reader_t reader;
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    TEST_ASSERT_NULL(octet_write_space(&writer, REMOTE_ENDIAN_RECORD_MAX));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, remote_endian_send(&one, &writer));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, remote_endian_receive(&other, REMOTE_ENDIAN_GRANT, 0U, &reader));
}

/// Open both ends of a bus in this process.
static void open_bus(char* const address, const char* const name, osal_can_t* const computer,
                     osal_can_t* const wire)
{
    char digits[16];
    long number  = (long)getpid();
    size_t count = 0U;
    for (; number > 0; number /= 10) {
        digits[count++] = (char)('0' + (number % 10));
    }
    digits[count] = '\0';
    (void)strcpy(address, "shm:hirosco-test.");
    (void)strcat(address, digits);
    (void)strcat(address, name);
    (void)osal_can_destroy(address);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(computer, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(wire, address, OSAL_CAN_WIRE));
}

/// Read frames until the last record that continues their list. Returns the number of records.
static unsigned take_frames(remote_endian_buses_t* const to)
{
    unsigned count = 0U;
    bool has_more  = true;
    while (has_more) {
        octet_reader_t reader = octet_reader(NULL, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_receive(&other, REMOTE_ENDIAN_GRANT, TIMEOUT_MS, &reader));
        TEST_ASSERT_TRUE(remote_endian_read_frames(&reader, to, &has_more));
        count++;
    }
    return count;
}

/// Full rings need more than one record; each frame arrives once and in its order.
static void full_buses_are_handed_over(void)
{
    static remote_endian_buses_t from;
    static remote_endian_buses_t to;
    osal_can_t senders[2];
    osal_can_t receivers[2];
    char addresses[4][64];
    from = (remote_endian_buses_t){.open = 0x81U};
    to   = (remote_endian_buses_t){.open = 0x81U};
    open_bus(addresses[0], ".a", &senders[0], &from.ends[0]);
    open_bus(addresses[1], ".b", &senders[1], &from.ends[7]);
    open_bus(addresses[2], ".c", &to.ends[0], &receivers[0]);
    open_bus(addresses[3], ".d", &to.ends[7], &receivers[1]);
    osal_can_frame_t frame = {
        .time_ns = 0x1122334455667788U, .length = OSAL_CAN_DATA_MAX, .flags = OSAL_CAN_FLAG_FD};
    for (unsigned i = 0U; i < (2U * OSAL_CAN_RING_FRAMES); i++) {
        frame.id      = i;
        frame.data[0] = (uint8_t)(i & 0xFFU);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&senders[i % 2U], &frame));
    }
    octet_writer_t writer = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send_frames(&one, &writer, &from));
    const unsigned records = take_frames(&to);
    TEST_ASSERT_GREATER_THAN_UINT32(
        (2U * OSAL_CAN_RING_FRAMES * REMOTE_ENDIAN_FRAME_OCTETS) / REMOTE_ENDIAN_RECORD_MAX, records);
    TEST_ASSERT_EQUAL_UINT32(0U, to.refused);
    // The next record finds no frames at the ends; its rings are full, and refuse one more.
    writer = remote_endian_begin(&one, REMOTE_ENDIAN_GRANT);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&senders[0], &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, remote_endian_send_frames(&one, &writer, &from));
    TEST_ASSERT_EQUAL(1U, take_frames(&to));
    TEST_ASSERT_EQUAL_UINT32(1U, to.refused);
    for (unsigned i = 0U; i < (2U * OSAL_CAN_RING_FRAMES); i++) {
        osal_can_frame_t got;
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&receivers[i % 2U], &got));
        TEST_ASSERT_EQUAL_UINT32(i, got.id);
        TEST_ASSERT_EQUAL_HEX64(frame.time_ns, got.time_ns);
        TEST_ASSERT_EQUAL_UINT8(OSAL_CAN_FLAG_FD, got.flags);
        TEST_ASSERT_EQUAL_UINT8(OSAL_CAN_DATA_MAX, got.length);
        TEST_ASSERT_EQUAL_HEX8(i & 0xFFU, got.data[0]);
    }
    octet_reader_t closed = octet_reader(&one.octets[HEAD_OCTETS], writer.position - HEAD_OCTETS);
    to.open               = 0x80U; // The frame is for bus 0.
    bool has_more         = false;
    TEST_ASSERT_FALSE(remote_endian_read_frames(&closed, &to, &has_more));
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_destroy(addresses[i]));
    }
    osal_can_close(&senders[0]);
    osal_can_close(&senders[1]);
    osal_can_close(&receivers[0]);
    osal_can_close(&receivers[1]);
    osal_can_close(&from.ends[0]);
    osal_can_close(&from.ends[7]);
    osal_can_close(&to.ends[0]);
    osal_can_close(&to.ends[7]);
}

static void invalid_frames_are_refused(void)
{
    static remote_endian_buses_t buses; // No bus is open.
    static const uint8_t nothing[]  = {0xFFU};
    static const uint8_t trailing[] = {0xFFU, 0U};
    static const uint8_t no_bus[]   = {8U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0xFFU};
    static const uint8_t more[]     = {0xFEU};
    bool has_more                   = true;
    octet_reader_t reader           = octet_reader(nothing, sizeof nothing);
    TEST_ASSERT_TRUE(remote_endian_read_frames(&reader, &buses, &has_more));
    TEST_ASSERT_FALSE(has_more);
    reader = octet_reader(more, sizeof more);
    TEST_ASSERT_TRUE(remote_endian_read_frames(&reader, &buses, &has_more));
    TEST_ASSERT_TRUE(has_more);
    reader = octet_reader(trailing, sizeof trailing);
    TEST_ASSERT_FALSE(remote_endian_read_frames(&reader, &buses, &has_more));
    reader = octet_reader(no_bus, sizeof no_bus);
    TEST_ASSERT_FALSE(remote_endian_read_frames(&reader, &buses, &has_more));
    reader = octet_reader(no_bus, 0U);
    TEST_ASSERT_FALSE(remote_endian_read_frames(&reader, &buses, &has_more));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_run_state_passes_the_wire_unchanged);
    RUN_TEST(the_largest_records_arrive_completely);
    RUN_TEST(a_truncated_run_state_or_one_out_of_bounds_is_refused);
    RUN_TEST(numbers_are_big_endian);
    RUN_TEST(a_done_record_carries_its_values);
    RUN_TEST(invalid_records_are_refused);
    RUN_TEST(a_record_may_arrive_in_pieces);
    RUN_TEST(records_follow_each_other_in_both_directions);
    RUN_TEST(the_end_of_the_peer_is_detected);
    RUN_TEST(a_receiver_does_not_wait_longer_than_it_may);
    RUN_TEST(a_peer_that_does_not_read_its_record_is_detected);
    RUN_TEST(a_record_that_does_not_fit_is_not_sent);
    RUN_TEST(full_buses_are_handed_over);
    RUN_TEST(invalid_frames_are_refused);
    return UNITY_END();
}
