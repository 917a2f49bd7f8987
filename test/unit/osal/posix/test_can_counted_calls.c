// SPDX-License-Identifier: Apache-2.0
// The counted hand-over of frames over SocketCAN with a mocked controller: frames that are late, missing
// or unannounced, and a controller that is full or gone. The counts are in real shared memory.
#define _GNU_SOURCE
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/shm.h"
#include "osal/common/can_port.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char name[64];
static osal_can_t node;
static osal_can_t wire;
static bool is_virtual;
static uint64_t now_ns;
static uint64_t frame_ns;    // Time until a frame arrives.
#define QUIET_NS 50000000ULL // Without a frame for this time, no frame is under way.
static uint32_t id_to_come;
static osal_can_frame_t frame = {.id = 0x181U, .length = 8U};

status_t __wrap_osal_can_interface_look(const char* interface, osal_can_interface_t* out_seen)
{
    assert_string_equal("can7", interface);
    *out_seen = (osal_can_interface_t){.is_virtual = is_virtual};
    return mock_type(status_t);
}

uint64_t __wrap_osal_clock_monotonic_ns(void)
{
    return now_ns;
}

/// The lowest descriptor: a program whose standard input is closed gets it.
status_t __wrap_can_socket_open(osal_can_t* can, const char* interface)
{
    can->descriptor = 0;
    assert_string_equal("can7", interface);
    return mock_type(status_t);
}

status_t __wrap_can_socket_filter(osal_can_t* can)
{
    check_expected_ptr(can);
    return mock_type(status_t);
}

void __wrap_can_socket_close(osal_can_t* can)
{
    (void)can;
    function_called();
}

status_t __wrap_can_socket_send(osal_can_t* can, const osal_can_frame_t* sent)
{
    (void)sent;
    check_expected_ptr(can);
    return mock_type(status_t);
}

status_t __wrap_can_socket_receive(osal_can_t* can, osal_can_frame_t* out_frame)
{
    check_expected_ptr(can);
    *out_frame    = frame;
    out_frame->id = id_to_come;
    return mock_type(status_t);
}

/// Time advances to the end of an unsuccessful wait, or to the arrival of the frame.
bool __wrap_can_socket_wait(const osal_can_t* can, uint64_t until_ns)
{
    check_expected_ptr(can);
    const bool has_come = mock_type(bool);
    now_ns              = has_come ? (now_ns + frame_ns) : until_ns;
    return has_come;
}

static void will_send(const osal_can_t* can, const status_t status)
{
    expect_value(__wrap_can_socket_send, can, can);
    will_return(__wrap_can_socket_send, status);
}

static void will_receive(const osal_can_t* can, const status_t status)
{
    expect_value(__wrap_can_socket_receive, can, can);
    will_return(__wrap_can_socket_receive, status);
}

static void will_wait(const osal_can_t* can, const bool has_come)
{
    expect_value(__wrap_can_socket_wait, can, can);
    will_return(__wrap_can_socket_wait, has_come);
}

static void expect_counts(const uint32_t frames, const uint32_t late, const uint32_t lost,
                          const uint32_t external, const uint32_t cuts)
{
    osal_can_hand_over_t counts;
    assert_int_equal(STATUS_OK, can_counted_look(name, &counts));
    assert_int_equal(frames, counts.frames);
    assert_int_equal(late, counts.late);
    assert_int_equal(lost, counts.lost);
    assert_int_equal(external, counts.external);
    assert_int_equal(cuts, counts.cuts);
}

/// Returns the number of mappings of the counts in this process.
static unsigned mappings(void)
{
    char line[512];
    unsigned count   = 0U;
    FILE* const maps = fopen("/proc/self/maps", "r");
    assert_non_null(maps);
    while (fgets(line, sizeof line, maps) != NULL) {
        count += (strstr(line, name) != NULL) ? 1U : 0U;
    }
    (void)fclose(maps);
    return count;
}

static void create(const bool carries_errors)
{
    is_virtual = carries_errors;
    will_return(__wrap_osal_can_interface_look, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_create(name, "can7"));
    node = (osal_can_t){.end = OSAL_CAN_NODE};
    wire = (osal_can_t){.end = OSAL_CAN_WIRE};
    will_return_count(__wrap_can_socket_open, STATUS_OK, 2);
    assert_int_equal(STATUS_OK, can_counted_open(&node, name, "can7"));
    assert_int_equal(STATUS_OK, can_counted_open(&wire, name, "can7"));
}

static void destroy(void)
{
    expect_function_calls(__wrap_can_socket_close, 2);
    can_counted_close(&node);
    can_counted_close(&wire);
    assert_int_equal(STATUS_OK, osal_shm_remove(name));
    assert_int_equal(0U, mappings());
}

static int set_up(void** state)
{
    (void)state;
    (void)snprintf(name, sizeof name, "/osal-can-calls-%d", (int)getpid());
    (void)osal_shm_remove(name);
    now_ns     = 1000000000U;
    frame_ns   = 0U;
    id_to_come = frame.id;
    return 0;
}

static void a_bus_that_cannot_be_made_or_opened_is_reported(void** state)
{
    osal_can_hand_over_t counts;
    osal_can_t can = {.end = OSAL_CAN_NODE};
    osal_shm_t shm;
    (void)state;
    will_return(__wrap_osal_can_interface_look, STATUS_NOT_FOUND);
    assert_int_equal(STATUS_NOT_FOUND, can_counted_create(name, "can7"));
    assert_int_equal(STATUS_NOT_FOUND, can_counted_open(&can, name, "can7"));
    assert_int_equal(STATUS_NOT_FOUND, can_counted_look(name, &counts));
    // First too small, then without the mark of the counts.
    for (size_t octets = 8U; octets <= 4096U; octets += 4088U) {
        assert_int_equal(STATUS_OK, osal_shm_create(&shm, name, octets));
        osal_shm_close(&shm);
        assert_int_equal(STATUS_NOT_FOUND, can_counted_open(&can, name, "can7"));
        will_return(__wrap_osal_can_interface_look, STATUS_OK);
        assert_int_equal(STATUS_EXISTS, can_counted_create(name, "can7"));
        assert_int_equal(STATUS_OK, osal_shm_remove(name));
    }
    will_return(__wrap_osal_can_interface_look, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_create(name, "can7"));
    will_return(__wrap_can_socket_open, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, can_counted_open(&can, name, "can7"));
    assert_int_equal(STATUS_OK, can_counted_look(name, &counts));
    uint64_t mark = 0U;
    assert_int_equal(STATUS_OK, osal_shm_open(&shm, name));
    (void)memcpy(&mark, osal_shm_address(&shm), sizeof mark);
    const size_t whole = osal_shm_size(&shm);
    osal_shm_close(&shm);
    assert_int_equal(STATUS_OK, osal_shm_remove(name));
    assert_int_equal(STATUS_OK,
                     osal_shm_create(&shm, name, whole - 1U)); // Memory with the right mark, but too small.
    (void)memcpy(osal_shm_address(&shm), &mark, sizeof mark);
    osal_shm_close(&shm);
    assert_int_equal(STATUS_NOT_FOUND, can_counted_open(&can, name, "can7"));
    assert_int_equal(STATUS_OK, osal_shm_remove(name));
    assert_int_equal(0U, mappings()); // The refused attempts leave no mapping.
}

static void frames_are_counted_in_each_direction(void** state)
{
    osal_can_frame_t received;
    (void)state;
    create(false);
    for (uint32_t i = 1U; i <= 3U; i++) {
        will_send(&node, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
        will_receive(&wire, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_receive(&wire, &received));
        will_send(&wire, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_send(&wire, &frame));
        will_receive(&node, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_receive(&node, &received));
        expect_counts(2U * i, 0U, 0U, 0U, 0U);
    }
    will_receive(&node, STATUS_EMPTY); // No frame is announced: no wait.
    assert_int_equal(STATUS_EMPTY, can_counted_receive(&node, &received));
    will_receive(&node, STATUS_OK); // Another program sends on the interface.
    assert_int_equal(STATUS_OK, can_counted_receive(&node, &received));
    can_counted_add_external(&node, 4U);
    expect_counts(6U, 0U, 0U, 5U, 0U);
    destroy();
}

static void an_announced_frame_is_waited_for(void** state)
{
    osal_can_frame_t received;
    (void)state;
    create(false);
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    will_receive(&wire, STATUS_EMPTY);
    will_wait(&wire, true);
    will_receive(&wire, STATUS_EMPTY); // The filters of this end drop the frame.
    will_wait(&wire, true);
    will_receive(&wire, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_receive(&wire, &received));
    expect_counts(1U, 1U, 0U, 0U, 0U);
    for (unsigned i = 0U; i < 2U; i++) {
        will_send(&node, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    }
    will_receive(&wire, STATUS_EMPTY); // The frames never arrive.
    will_wait(&wire, false);
    const uint64_t before_ns = now_ns;
    assert_int_equal(STATUS_EMPTY, can_counted_receive(&wire, &received));
    assert_int_equal(OSAL_CAN_TIMEOUT_MS * 1000000ULL, now_ns - before_ns);
    expect_counts(1U, 1U, 2U, 0U, 0U);
    will_receive(&wire, STATUS_OK); // A frame that arrives later is not taken for one announced afterwards.
    assert_int_equal(STATUS_OK, can_counted_receive(&wire, &received));
    expect_counts(1U, 1U, 2U, 1U, 0U);
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    will_receive(&wire, STATUS_EMPTY);
    will_wait(&wire, true);
    will_receive(&wire, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, can_counted_receive(&wire, &received));
    expect_counts(1U, 1U, 2U, 1U, 1U);
    destroy();
}

static void frames_that_the_controller_refuses_are_counted(void** state)
{
    osal_can_frame_t received;
    (void)state;
    create(false);
    // A frame that the wire end cannot send is an overrun of the node; a frame of the node is not.
    will_send(&wire, STATUS_FULL);
    assert_int_equal(STATUS_FULL, can_counted_send(&wire, &frame));
    will_send(&node, STATUS_FULL);
    assert_int_equal(STATUS_FULL, can_counted_send(&node, &frame));
    node.kernel_overruns = 10U;
    will_receive(&node, STATUS_EMPTY);
    assert_int_equal(STATUS_EMPTY, can_counted_receive(&node, &received));
    assert_int_equal(11U, node.overruns);
    wire.kernel_overruns = 10U;
    will_receive(&wire, STATUS_EMPTY);
    assert_int_equal(STATUS_EMPTY, can_counted_receive(&wire, &received));
    assert_int_equal(0U, wire.overruns);
    will_send(&node, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, can_counted_send(&node, &frame));
    will_receive(&node, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, can_counted_receive(&node, &received));
    will_send(&node, STATUS_INVALID);
    assert_int_equal(STATUS_INVALID, can_counted_send(&node, &frame));
    expect_counts(0U, 0U, 0U, 0U, 2U);
    destroy();
}

static void at_most_a_ring_of_frames_is_under_way(void** state)
{
    osal_can_frame_t received;
    (void)state;
    create(false);
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        will_send(&node, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    }
    assert_int_equal(STATUS_FULL, can_counted_send(&node, &frame)); // The controller is not called.
    assert_int_equal(1U, node.refused);
    will_receive(&wire, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_receive(&wire, &received));
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    assert_int_equal(STATUS_FULL, can_counted_send(&node, &frame));
    assert_int_equal(2U, node.refused);
    destroy();
}

static void a_real_controller_reports_its_own_errors(void** state)
{
    const osal_can_frame_t error = {.id = OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF, .length = 8U};
    osal_can_frame_t received;
    (void)state;
    create(false);
    assert_int_equal(STATUS_UNSUPPORTED, can_counted_send(&wire, &error));
    id_to_come = error.id;
    will_receive(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_receive(&node, &received));
    expect_counts(0U, 0U, 0U, 0U, 0U); // The frames count neither as handed over nor as external.
    destroy();
    create(true); // A virtual interface has no error frames: the wire end makes them.
    will_send(&wire, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_send(&wire, &error));
    will_receive(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_receive(&node, &received));
    expect_counts(1U, 0U, 0U, 0U, 0U);
    destroy();
}

/// Frames that were sent while an end was not open are skipped when it opens, also those under way.
static void an_end_that_opens_late_skips_the_frames_sent_before(void** state)
{
    osal_can_frame_t received;
    (void)state;
    create(false);
    static const status_t answers[] = {STATUS_OK, STATUS_EMPTY, STATUS_CLOSED};
    for (unsigned ending = 0U; ending < 2U; ending++) {
        expect_function_call(__wrap_can_socket_close);
        can_counted_close(&wire);
        will_send(&node, STATUS_OK);
        assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
        will_return(__wrap_can_socket_open, STATUS_OK);
        // The wait ends because no frame arrives any more, or because the end is closed.
        for (unsigned i = 0U; i < (2U + ending); i++) {
            will_wait(&wire, true);
            will_receive(&wire, answers[i]);
        }
        if (ending == 0U) {
            will_wait(&wire, false);
        }
        const uint64_t before_ns = now_ns;
        assert_int_equal(STATUS_OK, can_counted_open(&wire, name, "can7"));
        assert_int_equal((ending == 0U) ? QUIET_NS : 0U, now_ns - before_ns);
    }
    expect_function_call(__wrap_can_socket_close); // Frames arrive all the time, so the limit ends the wait.
    can_counted_close(&wire);
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, can_counted_send(&node, &frame));
    frame_ns = (OSAL_CAN_TIMEOUT_MS * 1000000ULL) / 4U;
    will_return(__wrap_can_socket_open, STATUS_OK);
    for (unsigned i = 0U; i < 4U; i++) {
        will_wait(&wire, true);
        will_receive(&wire, STATUS_OK);
    }
    assert_int_equal(STATUS_OK, can_counted_open(&wire, name, "can7"));
    frame_ns = 0U;
    will_receive(&wire, STATUS_EMPTY); // No frame is announced.
    assert_int_equal(STATUS_EMPTY, can_counted_receive(&wire, &received));
    expect_counts(0U, 0U, 0U, 0U, 0U);
    destroy();
}

static void will_close(osal_can_t* can)
{
    expect_function_call(__wrap_can_socket_close);
    osal_can_close(can);
    assert_null(can->shared);
    assert_int_equal(-1, can->descriptor);
    osal_can_close(can); // A second call has no effect.
}

static void the_address_decides_whether_frames_are_counted(void** state)
{
    const osal_can_filter_t others = {.id = 0x701U, .mask = 0x7FFU};
    char address[80];
    osal_can_hand_over_t counts;
    osal_can_frame_t received;
    (void)state;
    (void)snprintf(address, sizeof address, "can:can7@%s", &name[1]);
    is_virtual = false;
    will_return(__wrap_osal_can_interface_look, STATUS_OK);
    assert_int_equal(STATUS_OK, osal_can_create(address));
    will_return_count(__wrap_can_socket_open, STATUS_OK, 3);
    assert_int_equal(STATUS_OK, osal_can_open(&node, address, OSAL_CAN_NODE));
    assert_int_equal(STATUS_OK, osal_can_open(&wire, address, OSAL_CAN_WIRE));
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, osal_can_send(&node, &frame));
    will_receive(&wire, STATUS_OK);
    assert_int_equal(STATUS_OK, osal_can_receive(&wire, &received));
    // The kernel passes all frames, so they count.
    assert_int_equal(STATUS_OK, osal_can_filter(&wire, &others, 1U));
    will_send(&node, STATUS_OK);
    assert_int_equal(STATUS_OK, osal_can_send(&node, &frame));
    will_receive(&wire, STATUS_OK);
    will_receive(&wire, STATUS_EMPTY);
    assert_int_equal(STATUS_EMPTY, osal_can_receive(&wire, &received));
    assert_int_equal(1U, wire.filtered);
    osal_can_add_external(&node, 3U);
    assert_int_equal(STATUS_OK, osal_can_hand_over(address, &counts));
    assert_int_equal(2U, counts.frames);
    assert_int_equal(3U, counts.external);
    will_close(&wire);
    osal_can_add_external(&wire, 1U); // A closed end counts nothing.
    assert_int_equal(STATUS_CLOSED, osal_can_send(&wire, &frame));
    assert_int_equal(STATUS_CLOSED, osal_can_receive(&wire, &received));
    assert_int_equal(STATUS_CLOSED, osal_can_filter(&wire, &others, 1U));

    assert_int_equal(STATUS_OK, osal_can_open(&wire, "can:can7", OSAL_CAN_NODE));
    osal_can_add_external(&wire, 1U);
    will_send(&wire, STATUS_FULL);
    assert_int_equal(STATUS_FULL, osal_can_send(&wire, &frame));
    expect_value(__wrap_can_socket_filter, can, &wire);
    will_return(__wrap_can_socket_filter, STATUS_IO);
    assert_int_equal(STATUS_IO, osal_can_filter(&wire, &others, 1U));
    will_receive(&wire, STATUS_OK);
    will_receive(&wire, STATUS_CLOSED);
    assert_int_equal(STATUS_CLOSED, osal_can_receive(&wire, &received));
    will_close(&wire);
    assert_int_equal(STATUS_OK, osal_can_hand_over(address, &counts));
    assert_int_equal(2U, counts.frames);
    assert_int_equal(3U, counts.external);
    assert_int_equal(STATUS_NOT_FOUND, osal_can_hand_over("can:can7", &counts));
    will_close(&node);
    assert_int_equal(0U, mappings());
    assert_int_equal(STATUS_OK, osal_can_destroy(address));
    assert_int_equal(STATUS_NOT_FOUND, osal_can_destroy(address));
    assert_int_equal(STATUS_NOT_FOUND, osal_can_hand_over(address, &counts));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_bus_that_cannot_be_made_or_opened_is_reported, set_up),
        cmocka_unit_test_setup(frames_are_counted_in_each_direction, set_up),
        cmocka_unit_test_setup(an_announced_frame_is_waited_for, set_up),
        cmocka_unit_test_setup(frames_that_the_controller_refuses_are_counted, set_up),
        cmocka_unit_test_setup(at_most_a_ring_of_frames_is_under_way, set_up),
        cmocka_unit_test_setup(a_real_controller_reports_its_own_errors, set_up),
        cmocka_unit_test_setup(an_end_that_opens_late_skips_the_frames_sent_before, set_up),
        cmocka_unit_test_setup(the_address_decides_whether_frames_are_counted, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
