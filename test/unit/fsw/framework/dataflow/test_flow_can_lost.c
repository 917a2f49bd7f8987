// SPDX-License-Identifier: Apache-2.0
// A CAN interface that is lost and comes back. The functions of osal/can.h are mocked, so that the test runs
// on any kernel; test_flow_can_socket.c has the same test on a virtual interface.
#include "fsw/framework/dataflow/flow_can.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define MS 1000000U

static flow_can_t flow;
static bool is_there;
static bool has_fd;
static bool is_fd_wanted;
static status_t filter_status;
static unsigned attempts; // Attempts to open the interface.
static int open_count;
static unsigned left; // Frames in the queue.
static uint32_t id;   // Id of each frame.

status_t __wrap_osal_can_open(osal_can_t* can, const char* address, osal_can_end_t end)
{
    assert_string_equal("can:can7", address);
    assert_int_equal(OSAL_CAN_NODE, end);
    attempts++;
    if (!is_there) {
        return STATUS_NOT_FOUND;
    }
    open_count++;
    *can = (osal_can_t){.descriptor = 0, .carries_fd = has_fd, .overruns = 3U};
    return STATUS_OK;
}

void __wrap_osal_can_close(osal_can_t* can)
{
    (void)can;
    open_count--;
}

status_t __wrap_osal_can_filter(osal_can_t* can, const osal_can_filter_t* filters, size_t count)
{
    (void)can;
    assert_int_equal(1U, count);
    assert_int_equal(0U, filters[0].id);
    assert_int_equal(OSAL_CAN_EXTENDED, filters[0].mask); // Standard frames only.
    return filter_status;
}

status_t __wrap_osal_can_send(osal_can_t* can, const osal_can_frame_t* frame)
{
    (void)can;
    (void)frame;
    return is_there ? STATUS_OK : STATUS_CLOSED;
}

status_t __wrap_osal_can_receive(osal_can_t* can, osal_can_frame_t* out_frame)
{
    (void)can;
    *out_frame = (osal_can_frame_t){.id = id, .length = 8U};
    if (!is_there) {
        return STATUS_CLOSED;
    }
    if (left == 0U) {
        return STATUS_EMPTY;
    }
    left--;
    return STATUS_OK;
}

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    assert_int_equal(ENDNODE_CAN, kind);
    assert_string_equal("robot", name);
    (void)strcpy(out_address->address, "can:can7");
    out_address->is_fd = is_fd_wanted;
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static int set_up(void** state)
{
    (void)state;
    is_there      = true;
    has_fd        = false;
    is_fd_wanted  = false;
    filter_status = STATUS_OK;
    attempts      = 0U;
    open_count    = 0;
    left          = 0U;
    id            = 0x711U;
    flow_can_init(&flow);
    return 0;
}

static void lose_and_find(const bool by_sending)
{
    osal_can_frame_t frame;
    uint64_t now_ns = 0U;
    assert_int_equal(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    flow_can_attend(&flow, now_ns);
    assert_int_equal(1U, attempts);
    is_there = false;
    const status_t status =
        by_sending ? flow_can_send(&flow, 0x080U, NULL, 0U) : flow_can_receive(&flow, &frame);
    assert_int_equal(STATUS_CLOSED, status);
    assert_int_equal(0, open_count);
    assert_int_equal(FLOW_CAN_BUS_OFF, flow.health.state);
    assert_true(flow_can_is_open(&flow)); // To its user the flow looks like a bus without other nodes.
    assert_int_equal(STATUS_CLOSED, flow_can_send(&flow, 0x080U, NULL, 0U));
    assert_int_equal(STATUS_CLOSED, flow_can_receive(&flow, &frame));
    for (unsigned i = 0U; i < 1000U; i++) { // Half a second at 2 kHz needs a few attempts, not a thousand.
        now_ns += MS / 2U;
        flow_can_attend(&flow, now_ns);
    }
    assert_int_equal(1U, flow.counters.lost);
    assert_int_equal(0U, flow.counters.reopened);
    assert_in_range(attempts, 4U, 11U);
    assert_int_equal(attempts - 1U, flow.counters.failed);
    is_there                  = true;
    left                      = 5U; // Frames left from before the loss.
    const unsigned in_advance = attempts;
    for (unsigned i = 0U; (i < 4000U) && (attempts == in_advance); i++) {
        now_ns += MS / 2U;
        flow_can_attend(&flow, now_ns);
    }
    assert_int_equal(1U, flow.counters.reopened);
    assert_int_equal(1U, flow.counters.lost);
    assert_int_equal(in_advance - 1U, flow.counters.failed);
    assert_int_equal(1, open_count);
    assert_int_equal(0U, left);
    assert_int_equal(FLOW_CAN_ACTIVE, flow.health.state);
    assert_int_equal(STATUS_OK, flow_can_send(&flow, 0x080U, NULL, 0U));
    flow_can_attend(&flow, now_ns + (10000U * (uint64_t)MS));
    assert_int_equal(in_advance + 1U, attempts); // The interface is open, so no further attempt is made.
    now_ns += 10000U * (uint64_t)MS;
    is_there = false;
    assert_int_equal(STATUS_CLOSED, flow_can_send(&flow, 0x080U, NULL, 0U));
    flow_can_attend(&flow, now_ns);
    assert_int_equal(in_advance + 1U, attempts); // After the next loss the first delay applies again.
    is_there = true;
    flow_can_attend(&flow, now_ns + (1000U * (uint64_t)MS));
    assert_int_equal(2U, flow.counters.reopened);
    flow_can_close(&flow);
    flow_can_close(&flow);
    assert_int_equal(0, open_count);
    flow_can_attend(&flow, now_ns + (20000U * (uint64_t)MS));
    assert_int_equal(in_advance + 2U, attempts);
}

static void an_interface_lost_while_sending_is_opened_again(void** state)
{
    (void)state;
    lose_and_find(true);
}

static void an_interface_lost_while_receiving_is_opened_again(void** state)
{
    (void)state;
    lose_and_find(false);
}

static void an_interface_that_opens_only_in_part_is_closed(void** state)
{
    (void)state;
    is_fd_wanted = true;
    assert_int_equal(STATUS_UNSUPPORTED, flow_can_open(&flow, &resolver, "robot"));
    assert_int_equal(0, open_count);
    has_fd        = true;
    filter_status = STATUS_IO;
    assert_int_equal(STATUS_IO, flow_can_open(&flow, &resolver, "robot"));
    assert_int_equal(0, open_count);
    is_there = false;
    assert_int_equal(STATUS_NOT_FOUND, flow_can_open(&flow, &resolver, "robot"));
    assert_int_equal(3U, flow.counters.failed);
    assert_false(flow_can_is_open(&flow));
    is_there      = true;
    filter_status = STATUS_OK;
    left          = 100000U; // A sender that never pauses does not delay the opening.
    assert_int_equal(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    assert_int_equal(100000U - OSAL_CAN_RING_FRAMES, left);
    assert_int_equal(STATUS_EXISTS, flow_can_open(&flow, &resolver, "robot"));
    assert_int_equal(1, open_count);
    flow_can_close(&flow);
    assert_int_equal(0, open_count);
}

/// A controller that reports errors without end does not block its user.
static void a_flood_of_error_frames_is_received_in_pieces(void** state)
{
    osal_can_frame_t frame;
    (void)state;
    assert_int_equal(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    id   = OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS;
    left = 2U * OSAL_CAN_RING_FRAMES;
    assert_int_equal(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    assert_int_equal(OSAL_CAN_RING_FRAMES, left);
    assert_int_equal(STATUS_EMPTY, flow_can_receive(&flow, &frame));
    assert_int_equal(0U, left);
    assert_int_equal(2U * OSAL_CAN_RING_FRAMES, flow.errors.bus_errors);
    flow_can_close(&flow);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(an_interface_lost_while_sending_is_opened_again, set_up),
        cmocka_unit_test_setup(an_interface_lost_while_receiving_is_opened_again, set_up),
        cmocka_unit_test_setup(an_interface_that_opens_only_in_part_is_closed, set_up),
        cmocka_unit_test_setup(a_flood_of_error_frames_is_received_in_pieces, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
