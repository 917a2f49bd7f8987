// SPDX-License-Identifier: Apache-2.0
// osal/can.h over SocketCAN, on virtual interfaces that the test makes. If the kernel has no virtual
// interfaces or does not permit them, only the behaviour without them is tested; test/hil runs this program
// again on a kernel that has them.
#define _GNU_SOURCE
#include "osal/include/osal/can.h"

#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "unity.h"

#define LABEL "osal can test"
#define BOUND_NS 20000000000ULL
#define FLOOD_FRAMES 8000U // More frames than the receive buffer holds.
#define BURST_FRAMES 100U  // Divides FLOOD_FRAMES; less than the kernel queues before the sockets.
#define FD_FLAGS (OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS)

static char first[16];
static char second[16];
static char first_address[32];
static char second_address[32];
static char counted_address[64];
static char other_end[64];
static bool has_vcan;

void setUp(void)
{
    if (has_vcan) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(first, true, LABEL));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(second, false, LABEL));
    }
}

void tearDown(void)
{
    (void)osal_can_destroy(counted_address);
    (void)osal_can_interface_remove(first);
    (void)osal_can_interface_remove(second);
}

static osal_can_frame_t frame_of(uint32_t id, uint8_t length, uint8_t flags)
{
    osal_can_frame_t frame = {.id = id, .length = length, .flags = flags};
    for (uint8_t i = 0U; i < length; i++) {
        frame.data[i] = (uint8_t)(id + i);
    }
    return frame;
}

static void assert_same(const osal_can_frame_t* expected, const osal_can_frame_t* actual)
{
    TEST_ASSERT_EQUAL_HEX32(expected->id, actual->id);
    TEST_ASSERT_EQUAL_UINT8(expected->length, actual->length);
    TEST_ASSERT_EQUAL_HEX8(expected->flags, actual->flags);
    TEST_ASSERT_EQUAL_MEMORY(expected->data, actual->data, OSAL_CAN_DATA_MAX);
}

static status_t receive_within(osal_can_t* can, osal_can_frame_t* out_frame)
{
    const uint64_t end_ns = osal_clock_monotonic_ns() + BOUND_NS;
    status_t status       = STATUS_EMPTY;
    while ((status == STATUS_EMPTY) && (osal_clock_monotonic_ns() < end_ns)) {
        status = osal_can_receive(can, out_frame);
        (void)usleep(100U);
    }
    return status;
}

static void command(const char* verb, const char* interface, const char* arguments)
{
    char line[96];
    (void)snprintf(line, sizeof line, "ip link %s %s %s", verb, interface, arguments);
    TEST_ASSERT_EQUAL(0, system(line)); // NOLINT(cert-env33-c): runs the tool `ip`.
}

// ---- On any kernel ----

static void names_that_no_interface_can_have_are_refused(void)
{
    osal_can_interface_t seen;
    osal_can_claim_t claim;
    static const char* const names[] = {"", "sixteen-letters-", "a/b", "a b", ".", ".."};
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_interface_look(names[i], &seen));
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_interface_create(names[i], true, LABEL));
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_interface_remove(names[i]));
        TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_interface_claim(names[i], &claim));
        osal_can_interface_release(&claim); // The claim was not granted, so the release has no effect.
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      osal_can_interface_create(first, true, "a label of more characters than there may be"));
}

static void a_claim_has_one_holder(void)
{
    osal_can_claim_t one;
    osal_can_claim_t two;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_claim(first, &one));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_can_interface_claim(first, &two));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_claim(second, &two));
    osal_can_interface_release(&one);
    osal_can_interface_release(&one); // A second call has no effect.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_claim(first, &one));
    osal_can_interface_release(&one);
    osal_can_interface_release(&two);
}

static void a_missing_interface_is_reported(void)
{
    osal_can_interface_t seen;
    osal_can_t can;
    const status_t status = osal_can_interface_look("none0", &seen);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(status, osal_can_open(&can, "can:none0", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(status, osal_can_create("can:none0@osal-can-none"));
}

// ---- On kernels with vcan ----

static void interfaces_have_the_attributes_of_their_creation(void)
{
    osal_can_interface_t seen;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_look(first, &seen));
    TEST_ASSERT_TRUE(seen.is_virtual && seen.is_up && seen.carries_fd && !seen.is_bus_off);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.bit_rate);
    TEST_ASSERT_EQUAL_STRING(LABEL, seen.label);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_look(second, &seen));
    TEST_ASSERT_FALSE(seen.carries_fd);
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_can_interface_create(first, true, LABEL));
    command("set", first, "down");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_look(first, &seen));
    TEST_ASSERT_FALSE(seen.is_up);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(first));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_interface_look(first, &seen));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_interface_remove(first));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, osal_can_interface_look("lo", &seen));
}

static void frames_of_all_kinds_pass_and_a_sender_does_not_receive_its_own(void)
{
    osal_can_t one;
    osal_can_t two;
    osal_can_frame_t out;
    const osal_can_frame_t frames[] = {
        frame_of(0x181U, 8U, 0U), frame_of(0U, 0U, 0U), frame_of(OSAL_CAN_EXTENDED | 0x1234567U, 3U, 0U),
        frame_of(OSAL_CAN_REMOTE | 0x701U, 0U, 0U), frame_of(0x201U, 64U, FD_FLAGS | OSAL_CAN_FLAG_ESI)};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&one, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&two, first_address, OSAL_CAN_WIRE));
    TEST_ASSERT_TRUE(one.carries_fd);
    const uint64_t before_ns = osal_clock_monotonic_ns();
    for (size_t i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&one, &frames[i]));
    }
    for (size_t i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&two, &out));
        assert_same(&frames[i], &out);
        // The stamp of the kernel is of the wall clock; its conversion reads both clocks in turn, therefore
        // 1 ms is allowed.
        TEST_ASSERT_TRUE((out.time_ns + 1000000U) >= before_ns);
        TEST_ASSERT_TRUE(out.time_ns <= osal_clock_monotonic_ns());
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&one, &out));
    osal_can_close(&one);
    osal_can_close(&two);
}

static void a_classic_interface_refuses_fd(void)
{
    osal_can_t can;
    const osal_can_frame_t fd      = frame_of(0x201U, 8U, FD_FLAGS);
    const osal_can_frame_t classic = frame_of(0x201U, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&can, second_address, OSAL_CAN_NODE));
    TEST_ASSERT_FALSE(can.carries_fd);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_send(&can, &fd));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&can, &classic));
    osal_can_close(&can);
}

static void filters_hold_in_the_kernel_and_let_error_frames_through(void)
{
    osal_can_t one;
    osal_can_t two;
    osal_can_frame_t out;
    static const osal_can_filter_t filter = {0x181U, 0x7FFU | OSAL_CAN_EXTENDED};
    static const uint32_t ids[]           = {0x182U, OSAL_CAN_EXTENDED | 0x181U, 0x181U,
                                             OSAL_CAN_ERROR | OSAL_CAN_ERROR_LOST_ARBITRATION};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&one, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&two, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&two, &filter, 1U));
    for (size_t i = 0U; i < 4U; i++) {
        const osal_can_frame_t frame = frame_of(ids[i], 8U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&one, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&two, &out));
    TEST_ASSERT_EQUAL_HEX32(0x181U, out.id);
    TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&two, &out));
    TEST_ASSERT_EQUAL_HEX32(ids[3], out.id);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&two, &out));
    TEST_ASSERT_EQUAL_UINT32(0U, two.filtered); // The kernel has dropped the other frames.
    osal_can_close(&one);
    osal_can_close(&two);
}

/// A mask may also have the bit of error frames, which has another meaning for the kernel.
static void a_mask_may_have_any_bit(void)
{
    osal_can_t one;
    osal_can_t two;
    osal_can_frame_t out;
    static const osal_can_filter_t filters[] = {{0x181U, UINT32_MAX}, {OSAL_CAN_ERROR | 0x182U, UINT32_MAX}};
    static const uint32_t ids[]              = {0x182U, 0x181U, OSAL_CAN_EXTENDED | 0x181U,
                                                OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&one, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&two, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&two, filters, 2U));
    for (size_t i = 0U; i < 4U; i++) {
        const osal_can_frame_t frame = frame_of(ids[i], 8U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&one, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&two, &out));
    TEST_ASSERT_EQUAL_HEX32(0x181U, out.id);
    TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&two, &out));
    TEST_ASSERT_EQUAL_HEX32(ids[3], out.id);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&two, &out));
    osal_can_close(&one);
    osal_can_close(&two);
}

static void an_interface_that_goes_down_closes_the_end_until_it_is_up(void)
{
    osal_can_t can;
    const osal_can_frame_t frame = frame_of(1U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    command("set", first, "down");
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_send(&can, &frame));
    osal_can_close(&can);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    command("set", first, "up");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&can, &frame));
    osal_can_close(&can);
}

static void a_receiver_is_informed_that_its_interface_was_deleted(void)
{
    osal_can_t can;
    osal_can_frame_t out;
    const osal_can_frame_t frame = frame_of(1U, 1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(first));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, receive_within(&can, &out));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_send(&can, &frame));
    osal_can_close(&can);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_create(first, true, LABEL));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&can, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&can, &frame));
    osal_can_close(&can);
}

/// A socket from which no program reads drops frames when its buffer is full, and counts each. A second
/// receiver reads each burst before the next is sent: on a loaded machine the kernel's queue before the
/// sockets (1 000 frames) would drop frames that no socket can count.
static void overruns_are_counted(void)
{
    osal_can_t one;
    osal_can_t two;
    osal_can_t reader;
    osal_can_frame_t out;
    osal_can_frame_t frame = frame_of(0x123U, 8U, 0U);
    uint32_t received      = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&one, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&two, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&reader, first_address, OSAL_CAN_NODE));
    for (uint32_t sent = 0U; sent < FLOOD_FRAMES; sent += BURST_FRAMES) {
        for (uint32_t i = 0U; i < BURST_FRAMES; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&one, &frame));
        }
        for (uint32_t i = 0U; i < BURST_FRAMES; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&reader, &out));
        }
    }
    osal_can_close(&reader);
    while (osal_can_receive(&two, &out) == STATUS_OK) {
        received++;
    }
    frame.id = 0x7FFU; // The count comes with the next frame.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&one, &frame));
    while ((receive_within(&two, &out) == STATUS_OK) && (out.id != 0x7FFU)) {
        received++; // Frames that arrive late.
    }
    TEST_ASSERT_TRUE(received >= OSAL_CAN_RING_FRAMES);
    TEST_ASSERT_TRUE(two.overruns > 0U);
    TEST_ASSERT_EQUAL_UINT32(FLOOD_FRAMES, received + two.overruns);
    osal_can_close(&one);
    osal_can_close(&two);
}

// ---- Counted hand-over ----

static void counted_ends_receive_all_announced_frames(void)
{
    osal_can_t node;
    osal_can_t wire;
    osal_can_t stranger;
    osal_can_frame_t out;
    osal_can_hand_over_t counts;
    const osal_can_frame_t frame  = frame_of(0x181U, 8U, FD_FLAGS);
    const osal_can_frame_t report = frame_of(OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, counted_address, OSAL_CAN_WIRE));
    // No node has opened the bus, so no end receives the frame.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, counted_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    for (unsigned i = 0U; i < 100U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, (i == 50U) ? &report : &frame));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
    }
    for (unsigned i = 0U; i < 100U; i++) { // The test itself does not wait between the frames: the ends wait.
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
        assert_same((i == 50U) ? &report : &frame, &out);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&stranger, first_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&stranger, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, receive_within(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_hand_over(counted_address, &counts));
    TEST_ASSERT_EQUAL_UINT32(200U, counts.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, counts.lost);
    TEST_ASSERT_EQUAL_UINT32(1U, counts.external);
    osal_can_close(&stranger);
    osal_can_close(&node);
    osal_can_close(&wire);
}

static void counted_ends_that_are_full_refuse_as_rings_do(void)
{
    osal_can_t node;
    osal_can_t wire;
    osal_can_frame_t out;
    const osal_can_frame_t frame = frame_of(0x181U, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, counted_address, OSAL_CAN_WIRE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, counted_address, OSAL_CAN_NODE));
    for (uint32_t i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_can_send(&node, &frame));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL_UINT32(1U, node.refused);
    for (uint32_t i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_UINT32(1U, node.overruns);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
    osal_can_close(&node);
    osal_can_close(&wire);
}

static void failed_calls_of_counted_ends_without_interface_are_counted(void)
{
    osal_can_t node;
    osal_can_t wire;
    osal_can_frame_t out;
    osal_can_hand_over_t counts;
    const osal_can_frame_t frame = frame_of(0x181U, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, counted_address, OSAL_CAN_WIRE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, counted_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_interface_remove(first));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_hand_over(counted_address, &counts));
    TEST_ASSERT_EQUAL_UINT32(1U, counts.cuts);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, receive_within(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_hand_over(counted_address, &counts));
    TEST_ASSERT_EQUAL_UINT32(2U, counts.cuts);
    TEST_ASSERT_EQUAL_UINT32(0U, counts.lost + counts.external);
    osal_can_close(&node);
    osal_can_close(&wire);
}

/// Like a real controller, the interface delivers a frame some time after the program has sent it.
static void a_counted_end_does_not_receive_frames_sent_before_it_opened(void)
{
    char line[96];
    osal_can_t node;
    osal_can_t wire;
    osal_can_frame_t out;
    osal_can_hand_over_t counts;
    const osal_can_frame_t before = frame_of(0x711U, 1U, 0U);
    const osal_can_frame_t after  = frame_of(0x712U, 1U, 0U);
    (void)snprintf(line, sizeof line, "tc qdisc replace dev %s root netem delay 5ms", first);
    TEST_ASSERT_EQUAL(0, system(line)); // NOLINT(cert-env33-c): runs the tool `tc`.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, counted_address, OSAL_CAN_WIRE));
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &before));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, counted_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &after));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    assert_same(&after, &out);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_hand_over(counted_address, &counts));
    TEST_ASSERT_EQUAL_UINT32(1U, counts.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, counts.lost + counts.external);
    osal_can_close(&node);
    osal_can_close(&wire);
}

/// The ends are on interfaces that are not connected: announced frames never arrive.
static void an_announced_frame_that_does_not_arrive_is_counted_as_lost(void)
{
    osal_can_t node;
    osal_can_t wire;
    osal_can_frame_t out;
    osal_can_hand_over_t counts;
    const osal_can_frame_t frame = frame_of(0x181U, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(counted_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, counted_address, OSAL_CAN_WIRE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, other_end, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out)); // Returns after OSAL_CAN_TIMEOUT_MS.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out)); // Returns immediately.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_hand_over(counted_address, &counts));
    TEST_ASSERT_EQUAL_UINT32(2U, counts.lost);
    osal_can_close(&node);
    osal_can_close(&wire);
}

static bool can_make_vcan(void)
{
    const bool can = (osal_can_interface_create(first, true, LABEL) == STATUS_OK);
    (void)osal_can_interface_remove(first);
    return can;
}

int main(void)
{
    const unsigned number = (unsigned)getpid() % 1000000U;
    (void)snprintf(first, sizeof first, "vct-%u-a", number);
    (void)snprintf(second, sizeof second, "vct-%u-b", number);
    (void)snprintf(first_address, sizeof first_address, "can:%s", first);
    (void)snprintf(second_address, sizeof second_address, "can:%s", second);
    (void)snprintf(counted_address, sizeof counted_address, "can:%s@osal-can-test-%u", first, number);
    (void)snprintf(other_end, sizeof other_end, "can:%s@osal-can-test-%u", second, number);
    UNITY_BEGIN();
    RUN_TEST(names_that_no_interface_can_have_are_refused);
    RUN_TEST(a_claim_has_one_holder);
    RUN_TEST(a_missing_interface_is_reported);
    has_vcan = can_make_vcan();
    if (has_vcan) {
        RUN_TEST(interfaces_have_the_attributes_of_their_creation);
        RUN_TEST(frames_of_all_kinds_pass_and_a_sender_does_not_receive_its_own);
        RUN_TEST(a_classic_interface_refuses_fd);
        RUN_TEST(filters_hold_in_the_kernel_and_let_error_frames_through);
        RUN_TEST(a_mask_may_have_any_bit);
        RUN_TEST(an_interface_that_goes_down_closes_the_end_until_it_is_up);
        RUN_TEST(a_receiver_is_informed_that_its_interface_was_deleted);
        RUN_TEST(overruns_are_counted);
        RUN_TEST(counted_ends_receive_all_announced_frames);
        RUN_TEST(a_counted_end_does_not_receive_frames_sent_before_it_opened);
        RUN_TEST(counted_ends_that_are_full_refuse_as_rings_do);
        RUN_TEST(failed_calls_of_counted_ends_without_interface_are_counted);
        RUN_TEST(an_announced_frame_that_does_not_arrive_is_counted_as_lost);
    }
    return UNITY_END();
}
