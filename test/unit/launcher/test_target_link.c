// SPDX-License-Identifier: Apache-2.0
// The serving side of the wire to a board, with pipes and sockets of this machine. The test acts as the
// program.
#include "launcher/target_link.h"

#include "base/octets.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/task.h"
#include "test/support/directory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define TIMEOUT_MS 1000U
#define STRANGER 4321U ///< Number of a socket that the run has not given to the program.

static target_link_t link;
static run_state_t run;
static remote_endian_carrier_t carrier;
/// Inherited by the component; once the link has adopted it, the link closes it.
static osal_socket_t message;
static osal_socket_t partner; ///< Message socket of another component.
static uint8_t record[TARGET_WIRE_HEADER_OCTETS + TARGET_WIRE_CONTENT_MAX + 1U];

// A test expects each call of the mocked functions. If its status is STATUS_OK, the real function is called.
status_t __real_osal_udp_send(osal_socket_t* sock, osal_address_t to, const uint8_t* octets, size_t size);
status_t __wrap_osal_udp_send(osal_socket_t* sock, osal_address_t to, const uint8_t* octets, size_t size)
{
    const status_t status = mock_type(status_t);
    return (status == STATUS_OK) ? __real_osal_udp_send(sock, to, octets, size) : status;
}

status_t __real_osal_file_sync(osal_file_t* file);
status_t __wrap_osal_file_sync(osal_file_t* file)
{
    const status_t status = mock_type(status_t);
    return (status == STATUS_OK) ? __real_osal_file_sync(file) : status;
}

static int set_up(void** state)
{
    (void)state;
    const osal_address_t local = {OSAL_IPV4_LOOPBACK, 0U};
    (void)memset(&run, 0, sizeof run);
    assert_int_equal(STATUS_OK, osal_udp_open(&message, local, 0U));
    assert_int_equal(STATUS_OK, osal_udp_open(&partner, local, 0U));
    run.component_count                  = 1U;
    run.components[0].message_descriptor = osal_socket_descriptor(&message);
    run.computer_ipv4[0]                 = OSAL_IPV4_LOOPBACK;
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        run.link_descriptors[i] = -1;
    }
    assert_int_equal(STATUS_OK, target_link_open(&link, &run, 0U));
    assert_true((target_link_peer_in(&link) >= 0) && (target_link_peer_out(&link) >= 0));
    carrier = target_link_carrier(&link);
    return 0;
}

static int tear_down(void** state)
{
    (void)state;
    if (link.socket_count == 0U) {
        osal_socket_close(&message);
    }
    target_link_close(&link);
    assert_int_equal(0U, link.socket_count);
    target_link_close(&link); // Again: it must not close a socket that another user has opened since.
    osal_socket_close(&partner);
    return 0;
}

/// Write octets as the program.
static void put(const uint8_t* const octets, const size_t size)
{
    size_t sent = 0U;
    assert_int_equal(STATUS_OK, osal_device_write(&link.peer_out, octets, size, &sent));
    assert_int_equal(size, sent);
}

/// Write a record as the program, in two writes.
static void put_record(const uint8_t kind, const void* const content, const size_t size)
{
    octets_put_u32(record, (uint32_t)(size + 1U));
    record[4] = kind;
    (void)memcpy(&record[TARGET_WIRE_HEADER_OCTETS], content, size);
    put(record, 3U);
    put(&record[3], (TARGET_WIRE_HEADER_OCTETS + size) - 3U);
}

static void put_number(const uint8_t kind, const uint32_t number)
{
    uint8_t content[4];
    octets_put_u32(content, number);
    put_record(kind, content, sizeof content);
}

static void put_datagram(const uint32_t socket, const osal_address_t to, const char* const text)
{
    uint8_t content[64];
    octets_put_u32(content, socket);
    octets_put_u32(&content[4], to.ipv4);
    octets_put_u16(&content[8], to.port);
    (void)memcpy(&content[TARGET_WIRE_DATAGRAM_OCTETS], text, strlen(text));
    put_record(TARGET_WIRE_DATAGRAM, content, TARGET_WIRE_DATAGRAM_OCTETS + strlen(text));
}

/// Read exactly `size` octets, as the program.
static void get(uint8_t* const octets, const size_t size)
{
    size_t done = 0U;
    while (done < size) {
        size_t got = 0U;
        assert_int_equal(STATUS_OK, osal_device_wait_readable(&link.peer_in, TIMEOUT_MS));
        assert_int_equal(STATUS_OK, osal_device_read(&link.peer_in, &octets[done], size - done, &got));
        done += got;
    }
}

/// Read a record, as the program. Returns the octets of its content.
static size_t get_record(const uint8_t kind)
{
    get(record, TARGET_WIRE_HEADER_OCTETS);
    const size_t size = octets_u32_at(record) - 1U;
    assert_int_equal(kind, record[4]);
    assert_true(size <= TARGET_WIRE_CONTENT_MAX);
    get(record, size);
    return size;
}

static void get_datagram(const char* const text)
{
    osal_address_t sender = {0U, 0U};
    assert_int_equal(TARGET_WIRE_DATAGRAM_OCTETS + strlen(text), get_record(TARGET_WIRE_DATAGRAM));
    assert_int_equal(STATUS_OK, osal_socket_local_address(&partner, &sender));
    assert_int_equal(run.components[0].message_descriptor, (int32_t)octets_u32_at(record));
    assert_int_equal(sender.ipv4, octets_u32_at(&record[4]));
    assert_int_equal(sender.port, octets_u16_at(&record[8]));
    assert_memory_equal(text, &record[TARGET_WIRE_DATAGRAM_OCTETS], strlen(text));
}

static osal_address_t address_of(const osal_socket_t* const socket)
{
    osal_address_t local = {0U, 0U};
    assert_int_equal(STATUS_OK, osal_socket_local_address(socket, &local));
    return local;
}

/// Process the records that the program has sent; they contain no octets of the stream.
static status_t take(void)
{
    uint8_t octets[16];
    size_t size           = 0U;
    const status_t status = carrier.receive(carrier.context, octets, sizeof octets, &size);
    assert_int_equal(0U, size);
    return status;
}

static void adopt(void)
{
    put_number(TARGET_WIRE_ADOPT, (uint32_t)run.components[0].message_descriptor);
    assert_int_equal(STATUS_EMPTY, take());
}

/// Let a message to the program arrive.
static void send_to_program(const char* const text)
{
    const osal_address_t to = address_of(&message);
    assert_int_equal(STATUS_OK, __real_osal_udp_send(&partner, to, (const uint8_t*)text, strlen(text)));
}

static void octets_of_the_stream_arrive_in_both_directions(void** state)
{
    (void)state;
    uint8_t octets[16];
    size_t size = 0U;
    put_record(TARGET_WIRE_STREAM, "abcde", 5U);
    put_record(TARGET_WIRE_STREAM, "fg", 2U);
    assert_int_equal(STATUS_OK, carrier.wait_readable(carrier.context, TIMEOUT_MS));
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, octets, 3U, &size));
    assert_int_equal(3U, size);
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, &octets[3], 13U, &size));
    assert_int_equal(2U, size);
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, &octets[5], 11U, &size));
    assert_memory_equal("abcdefg", octets, 7U);
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(STATUS_TIMEOUT, carrier.wait_readable(carrier.context, 0U));

    static uint8_t many[TARGET_WIRE_STREAM_MAX + 100U]; // More than one record.
    for (size_t i = 0U; i < sizeof many; i++) {
        many[i] = (uint8_t)(i * 7U);
    }
    assert_int_equal(STATUS_OK, carrier.send(carrier.context, many, sizeof many, &size));
    assert_int_equal(sizeof many, size);
    assert_int_equal(TARGET_WIRE_STREAM_MAX, get_record(TARGET_WIRE_STREAM));
    assert_memory_equal(many, record, TARGET_WIRE_STREAM_MAX);
    assert_int_equal(100U, get_record(TARGET_WIRE_STREAM));
    assert_memory_equal(&many[TARGET_WIRE_STREAM_MAX], record, 100U);
}

#define PIECES 16U ///< Number of pieces, which together are more than a pipe holds.
#define PIECE_OCTETS (TARGET_WIRE_HEADER_OCTETS + TARGET_WIRE_STREAM_MAX)

static uint8_t pieces[PIECES * TARGET_WIRE_STREAM_MAX];
static uint8_t arrived[PIECES * PIECE_OCTETS];
static size_t arrived_count;

/// Read, as the program, until all pieces have arrived or no piece arrives for a while.
static void read_the_pieces(void* const context)
{
    (void)context;
    while ((arrived_count < sizeof arrived) &&
           (osal_device_wait_readable(&link.peer_in, TIMEOUT_MS) == STATUS_OK)) {
        size_t got = 0U;
        if (osal_device_read(&link.peer_in, &arrived[arrived_count], sizeof arrived - arrived_count, &got) !=
            STATUS_OK) {
            return;
        }
        arrived_count += got;
    }
}

/// The pipe accepts only a part of a record while the program does not read.
static void a_record_that_the_pipe_accepts_in_parts_arrives_whole(void** state)
{
    (void)state;
    osal_task_t task;
    size_t size = 0U;
    for (size_t i = 0U; i < sizeof pieces; i++) {
        pieces[i] = (uint8_t)((i * 7U) + (i / 251U));
    }
    arrived_count = 0U;
    assert_int_equal(STATUS_OK, osal_task_start(&task, read_the_pieces, NULL, 0));
    assert_int_equal(STATUS_OK, carrier.send(carrier.context, pieces, sizeof pieces, &size));
    osal_task_join(&task);
    assert_int_equal(sizeof pieces, size);
    assert_int_equal(sizeof arrived, arrived_count);
    for (size_t i = 0U; i < PIECES; i++) {
        const uint8_t* const one = &arrived[i * PIECE_OCTETS];
        assert_int_equal(TARGET_WIRE_STREAM_MAX + 1U, octets_u32_at(one));
        assert_int_equal(TARGET_WIRE_STREAM, one[4]);
        assert_memory_equal(&pieces[i * TARGET_WIRE_STREAM_MAX], &one[TARGET_WIRE_HEADER_OCTETS],
                            TARGET_WIRE_STREAM_MAX);
    }
}

static void a_record_that_is_not_whole_is_kept(void** state)
{
    (void)state;
    uint8_t octets[16];
    size_t size                  = 0U;
    static const uint8_t first[] = {0U, 0U, 0U, 4U, TARGET_WIRE_STREAM, 'x'};
    put(first, 2U);
    assert_int_equal(STATUS_EMPTY, take());
    put(&first[2], 4U);
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, octets, sizeof octets, &size));
    assert_int_equal(1U, size);
    assert_int_equal(STATUS_EMPTY, take());
    put((const uint8_t*)"yz", 2U);
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, octets, sizeof octets, &size));
    assert_memory_equal("yz", octets, 2U);
    static const uint8_t adoption[] = {0U, 0U, 0U, 5U, TARGET_WIRE_ADOPT, 0U, 0U};
    put(adoption, sizeof adoption);
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(0U, link.socket_count);
}

static void messages_that_have_arrived_reach_the_program_before_its_next_grant(void** state)
{
    (void)state;
    size_t size = 0U;
    adopt();
    send_to_program("one");
    send_to_program("two");
    assert_int_equal(STATUS_OK, carrier.send(carrier.context, (const uint8_t*)"grant", 5U, &size));
    get_datagram("one");
    get_datagram("two");
    assert_int_equal(5U, get_record(TARGET_WIRE_STREAM));
    assert_memory_equal("grant", record, 5U);
}

static void datagrams_of_the_program_leave_from_its_sockets(void** state)
{
    (void)state;
    osal_address_t from = {0U, 0U};
    uint8_t octets[16];
    size_t size = 0U;
    adopt();
    const osal_address_t own = address_of(&message);
    will_return_count(__wrap_osal_udp_send, STATUS_OK, 2);
    put_datagram((uint32_t)run.components[0].message_descriptor, address_of(&partner), "hello");
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(STATUS_OK, osal_socket_wait_readable(&partner, TIMEOUT_MS));
    assert_int_equal(STATUS_OK, osal_udp_receive(&partner, &from, octets, sizeof octets, &size));
    assert_int_equal(5U, size);
    assert_memory_equal("hello", octets, 5U);
    assert_int_equal(own.port, from.port);
    put_datagram(TARGET_WIRE_SENDER, address_of(&partner), "frame"); // A socket that only sends.
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(STATUS_OK, osal_socket_wait_readable(&partner, TIMEOUT_MS));
    assert_int_equal(STATUS_OK, osal_udp_receive(&partner, &from, octets, sizeof octets, &size));
    assert_memory_equal("frame", octets, 5U);
    assert_true(own.port != from.port);
}

static void a_wait_ends_with_a_datagram_or_with_its_time(void** state)
{
    (void)state;
    uint8_t content[8];
    adopt();
    octets_put_u32(content, (uint32_t)run.components[0].message_descriptor);
    octets_put_u32(&content[4], 1U);
    put_record(TARGET_WIRE_WAIT, content, sizeof content);
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(0U, get_record(TARGET_WIRE_WAITED));
    send_to_program("late");
    octets_put_u32(&content[4], TIMEOUT_MS);
    put_record(TARGET_WIRE_WAIT, content, sizeof content);
    assert_int_equal(STATUS_EMPTY, take());
    get_datagram("late");
    assert_int_equal(0U, get_record(TARGET_WIRE_WAITED));
}

static void a_socket_of_a_link_is_adopted_once(void** state)
{
    (void)state;
    run.link_descriptors[RUN_LINKS_MAX - 1U] = osal_socket_descriptor(&partner);
    adopt();
    put_number(TARGET_WIRE_ADOPT, (uint32_t)osal_socket_descriptor(&partner));
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(2U, link.socket_count);
    put_number(TARGET_WIRE_ADOPT, (uint32_t)run.components[0].message_descriptor);
    assert_int_equal(STATUS_IO, take());
    assert_int_equal(2U, link.socket_count);
    link.at = link.end;    // A proxy would end here; the test continues with the next record.
    osal_socket_t foreign; // Open in this process, but not given to the program.
    assert_int_equal(STATUS_OK, osal_udp_open(&foreign, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
    put_number(TARGET_WIRE_ADOPT, (uint32_t)osal_socket_descriptor(&foreign));
    assert_int_equal(STATUS_IO, take());
    assert_int_equal(2U, link.socket_count);
    osal_socket_close(&foreign);
    partner = (osal_socket_t)OSAL_SOCKET_CLOSED; // The link closes it.
}

static void a_datagram_that_is_lost_is_counted(void** state)
{
    (void)state;
    static const uint8_t long_text[TARGET_WIRE_DATAGRAM_MAX + 1U] = {1U};
    size_t size                                                   = 0U;
    adopt();
    assert_int_equal(0U, target_link_lost(&link));
    will_return(__wrap_osal_udp_send, STATUS_FULL);
    put_datagram(TARGET_WIRE_SENDER, address_of(&partner), "lost");
    assert_int_equal(STATUS_EMPTY, take()); // The program continues, like a native one.
    assert_int_equal(1U, target_link_lost(&link));
    will_return(__wrap_osal_udp_send, STATUS_OK);
    put_datagram(TARGET_WIRE_SENDER, address_of(&partner), "good");
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(1U, target_link_lost(&link));
    assert_int_equal(STATUS_OK,
                     __real_osal_udp_send(&partner, address_of(&message), long_text, sizeof long_text));
    send_to_program("next");
    assert_int_equal(STATUS_OK, carrier.send(carrier.context, (const uint8_t*)"grant", 5U, &size));
    assert_int_equal(2U, target_link_lost(&link));
    get_datagram("next");
}

static void put_sync(const uint8_t what, const char* const path)
{
    uint8_t content[TARGET_WIRE_PATH_MAX + 1U];
    content[0] = what;
    (void)memcpy(&content[1], path, strlen(path));
    put_record(TARGET_WIRE_SYNC, content, strlen(path) + 1U);
}

static void expect_synced(const uint8_t answer)
{
    assert_int_equal(STATUS_EMPTY, take());
    assert_int_equal(1U, get_record(TARGET_WIRE_SYNCED));
    assert_int_equal(answer, record[0]);
}

/// The program gets the answer that a file is on the disk only after the file was synced.
static void files_of_the_program_are_synced(void** state)
{
    (void)state;
    char path[64];
    osal_file_t file;
    (void)snprintf(path, sizeof path, "%s/target-link-%d", TEST_DIRECTORY, (int)osal_process_own_id());
    assert_int_equal(STATUS_OK, osal_file_create(&file, path));
    osal_file_close(&file);
    will_return(__wrap_osal_file_sync, STATUS_OK);
    put_sync(TARGET_WIRE_SYNC_CONTENT, path);
    expect_synced(1U);
    will_return(__wrap_osal_file_sync, STATUS_IO);
    put_sync(TARGET_WIRE_SYNC_CONTENT, path);
    expect_synced(0U);
    put_sync(TARGET_WIRE_SYNC_NAMES, path);
    expect_synced(1U);
    assert_int_equal(STATUS_OK, osal_file_remove(path));
    put_sync(TARGET_WIRE_SYNC_CONTENT, path);
    expect_synced(0U);
    put_sync(TARGET_WIRE_SYNC_NAMES, "/no/such/directory/file");
    expect_synced(0U);
}

static void refuse(const uint8_t kind, const void* const content, const size_t size)
{
    put_record(kind, content, size);
    assert_int_equal(STATUS_IO, take());
    link.at = link.end; // A proxy would end here; the test continues with the next record.
}

static void malformed_records_of_a_program_are_refused(void** state)
{
    (void)state;
    uint8_t content[16] = {0U};
    adopt();
    octets_put_u32(content, STRANGER);
    refuse(TARGET_WIRE_ADOPT, content, 4U); // The socket was not inherited.
    octets_put_u32(content, UINT32_MAX);
    refuse(TARGET_WIRE_ADOPT, content, 4U);
    refuse(TARGET_WIRE_ADOPT, content, 3U);
    octets_put_u32(content, STRANGER);
    refuse(TARGET_WIRE_DATAGRAM, content, TARGET_WIRE_DATAGRAM_OCTETS); // There is no such socket.
    refuse(TARGET_WIRE_DATAGRAM, content, TARGET_WIRE_DATAGRAM_OCTETS - 1U);
    refuse(TARGET_WIRE_WAIT, content, 8U); // The program cannot wait for that socket either.
    refuse(TARGET_WIRE_WAIT, content, 7U);
    refuse(TARGET_WIRE_WAITED, content, 0U); // Only the serving process may send this record.
    refuse(TARGET_WIRE_SYNCED, content, 1U);
    refuse(TARGET_WIRE_SYNC, "\0", 1U);       // No path.
    refuse(TARGET_WIRE_SYNC, "\2path", 5U);   // Neither the content nor the names.
    refuse(TARGET_WIRE_SYNC, "\0pa\0th", 6U); // A zero in the path.
    uint8_t long_path[TARGET_WIRE_PATH_MAX + 2U] = {TARGET_WIRE_SYNC_CONTENT};
    (void)memset(&long_path[1], 'p', sizeof long_path - 1U);
    refuse(TARGET_WIRE_SYNC, long_path, sizeof long_path);
    refuse(0U, content, 1U); // No kind of record.
    // A length of 0, which does not even include the kind; then a length beyond the largest.
    static const uint8_t empty[] = {0U, 0U, 0U, 0U, TARGET_WIRE_STREAM};
    put(empty, sizeof empty);
    assert_int_equal(STATUS_IO, take());
    link.at                                  = link.end;
    uint8_t large[TARGET_WIRE_HEADER_OCTETS] = {0U, 0U, 0U, 0U, TARGET_WIRE_STREAM};
    octets_put_u32(large, TARGET_WIRE_CONTENT_MAX + 2U);
    put(large, sizeof large);
    assert_int_equal(STATUS_IO, take());
}

static void the_end_of_the_program_is_seen(void** state)
{
    (void)state;
    uint8_t octets[4];
    size_t size = 0U;
    put_record(TARGET_WIRE_STREAM, "last", 4U);
    target_link_release_peer(&link);
    assert_int_equal(STATUS_OK, carrier.receive(carrier.context, octets, sizeof octets, &size));
    assert_memory_equal("last", octets, 4U);
    assert_int_equal(STATUS_CLOSED, carrier.receive(carrier.context, octets, sizeof octets, &size));
    assert_true(STATUS_OK != carrier.send(carrier.context, (const uint8_t*)"grant", 5U, &size));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(octets_of_the_stream_arrive_in_both_directions, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_record_that_the_pipe_accepts_in_parts_arrives_whole, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_record_that_is_not_whole_is_kept, set_up, tear_down),
        cmocka_unit_test_setup_teardown(messages_that_have_arrived_reach_the_program_before_its_next_grant,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(datagrams_of_the_program_leave_from_its_sockets, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_wait_ends_with_a_datagram_or_with_its_time, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_socket_of_a_link_is_adopted_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_datagram_that_is_lost_is_counted, set_up, tear_down),
        cmocka_unit_test_setup_teardown(files_of_the_program_are_synced, set_up, tear_down),
        cmocka_unit_test_setup_teardown(malformed_records_of_a_program_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_end_of_the_program_is_seen, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
