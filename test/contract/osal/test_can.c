// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/can.h"

#include "osal/include/osal/process.h"
#include "osal/include/osal/shm.h"

#include <stdio.h>
#include <string.h>

#include "unity.h"

static char address[64];
static osal_can_t node;
static osal_can_t wire;

void setUp(void)
{
    (void)snprintf(address, sizeof address, "shm:osal-can-test-%d", (int)osal_process_own_id());
    const status_t status = osal_can_create(address);
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this port has no bus in shared memory");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&wire, address, OSAL_CAN_WIRE));
}

void tearDown(void)
{
    osal_can_close(&node);
    osal_can_close(&wire);
    (void)osal_can_destroy(address);
}

static osal_can_frame_t frame_of(uint32_t id, uint8_t length, uint8_t flags)
{
    osal_can_frame_t frame = {.time_ns = 1000U + id, .id = id, .length = length, .flags = flags};
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
    TEST_ASSERT_EQUAL_UINT64(expected->time_ns, actual->time_ns);
    TEST_ASSERT_EQUAL_MEMORY(expected->data, actual->data, OSAL_CAN_DATA_MAX);
}

static void both_directions_keep_order_and_content(void)
{
    osal_can_frame_t out;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&wire, &out));
    for (uint32_t i = 0U; i < 50U; i++) {
        const osal_can_frame_t up   = frame_of(0x100U + i, (uint8_t)(i % 9U), 0U);
        const osal_can_frame_t down = frame_of(OSAL_CAN_EXTENDED | (0x12345U + i), 64U,
                                               OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &up));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &down));
    }
    for (uint32_t i = 0U; i < 50U; i++) {
        const osal_can_frame_t up   = frame_of(0x100U + i, (uint8_t)(i % 9U), 0U);
        const osal_can_frame_t down = frame_of(OSAL_CAN_EXTENDED | (0x12345U + i), 64U,
                                               OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
        assert_same(&up, &out);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
        assert_same(&down, &out);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&wire, &out));
}

static void error_and_remote_frames_pass_through(void)
{
    osal_can_frame_t out;
    osal_can_frame_t error =
        frame_of(OSAL_CAN_ERROR | OSAL_CAN_ERROR_CONTROLLER | OSAL_CAN_ERROR_BUS_OFF, 8U, 0U);
    error.data[1]                 = 0x20U;
    error.data[6]                 = 128U;
    error.data[7]                 = 96U;
    const osal_can_frame_t remote = frame_of(OSAL_CAN_REMOTE | 0x701U, 0U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &error));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &remote));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    assert_same(&error, &out);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    assert_same(&remote, &out);
}

static void lengths_that_no_frame_can_have_are_refused(void)
{
    static const uint8_t fd_lengths[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    osal_can_frame_t out;
    for (unsigned length = 0U; length <= 255U; length++) {
        osal_can_frame_t frame = {.id = 1U, .length = (uint8_t)length};
        TEST_ASSERT_EQUAL((length <= 8U) ? STATUS_OK : STATUS_INVALID, osal_can_send(&node, &frame));
        const bool is_fd = (memchr(fd_lengths, (int)length, sizeof fd_lengths) != NULL);
        frame.flags      = OSAL_CAN_FLAG_FD;
        TEST_ASSERT_EQUAL(is_fd ? STATUS_OK : STATUS_INVALID, osal_can_send(&node, &frame));
        while (osal_can_receive(&wire, &out) == STATUS_OK) {
            TEST_ASSERT_EQUAL_UINT8(length, out.length);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, node.refused);
}

static void a_full_ring_refuses_and_counts_frames_and_keeps_those_that_it_took(void)
{
    osal_can_frame_t out;
    for (uint32_t i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        const osal_can_frame_t frame = frame_of(i, 8U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    const osal_can_frame_t late = frame_of(0x7FFU, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_can_send(&node, &late));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_can_send(&wire, &late));
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_can_send(&wire, &late));
    TEST_ASSERT_EQUAL_UINT32(1U, node.refused);
    TEST_ASSERT_EQUAL_UINT32(2U, wire.refused);
    for (uint32_t i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        const osal_can_frame_t frame = frame_of(i, 8U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
        assert_same(&frame, &out);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
        assert_same(&frame, &out);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_UINT32(2U, node.overruns);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &late));
}

static void a_node_that_opens_has_received_nothing_and_its_sent_frames_remain(void)
{
    osal_can_frame_t out;
    const osal_can_frame_t frame = frame_of(0x181U, 8U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
    osal_can_close(&node);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_send(&node, &frame));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_receive(&node, &out));
    osal_can_close(&node); // A second close has no effect.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_open(&node, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
    assert_same(&frame, &out);
}

static void addresses_of_missing_buses_and_malformed_addresses_are_refused(void)
{
    osal_can_t other;
    char other_address[96];
    (void)snprintf(other_address, sizeof other_address, "shm:osal-can-none-%d", (int)osal_process_own_id());
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_can_create(address));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_open(&other, other_address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_destroy(other_address));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create("can:vcan0"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create("shm:"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create("shm:a/b"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create("robot"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&other, "robot", OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&other, "", OSAL_CAN_NODE));
    memset(other_address, 'a', sizeof other_address);
    memcpy(other_address, "shm:", 4U);
    other_address[95] = '\0';
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create(other_address));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_open(&other, other_address, OSAL_CAN_NODE));
    other_address[65] = '\0';
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_create(other_address));
    other_address[64] = '\0'; // The longest address that is accepted.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_create(other_address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_destroy(other_address));
}

static void a_frame_passes_if_it_matches_one_filter(void)
{
    osal_can_frame_t out;
    static const osal_can_filter_t filters[] = {{0x181U, 0x7FFU | OSAL_CAN_EXTENDED}, {0x011U, 0x07FU}};
    static const uint32_t ids[]              = {0x181U, 0x182U, 0x711U, OSAL_CAN_EXTENDED | 0x181U,
                                                OSAL_CAN_ERROR | 0x40U};
    osal_can_filter_t many[OSAL_CAN_FILTERS_MAX + 1U] = {{0U, 0U}};
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_can_filter(&node, many, OSAL_CAN_FILTERS_MAX + 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&node, many, OSAL_CAN_FILTERS_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&node, filters, 2U));
    for (size_t i = 0U; i < 5U; i++) {
        const osal_can_frame_t frame = {.id = ids[i]};
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    for (size_t i = 0U; i < 5U; i += 2U) { // The ids in between match no filter; error frames need none.
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
        TEST_ASSERT_EQUAL_HEX32(ids[i], out.id);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_UINT32(2U, node.filtered);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&node, NULL, 0U)); // Without filters only error frames pass.
    for (size_t i = 0U; i < 5U; i++) {
        const osal_can_frame_t frame = {.id = ids[i]};
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_HEX32(ids[4], out.id);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    osal_can_close(&node);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_can_filter(&node, NULL, 0U));
}

/// The test uses all bits of the identifier, also the bit of error frames.
static void a_mask_may_have_any_bit(void)
{
    osal_can_frame_t out;
    static const osal_can_filter_t filters[] = {{0x181U, UINT32_MAX}, {OSAL_CAN_ERROR | 0x182U, UINT32_MAX}};
    static const uint32_t ids[] = {0x181U, 0x182U, OSAL_CAN_EXTENDED | 0x181U, OSAL_CAN_ERROR | 0x40U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&node, filters, 2U));
    for (size_t i = 0U; i < 4U; i++) {
        const osal_can_frame_t frame = {.id = ids[i]};
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_HEX32(ids[0], out.id);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_HEX32(ids[3], out.id);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
}

static void removed_bus_stays_usable_for_open_ends(void)
{
    osal_can_frame_t out;
    osal_can_t other;
    const osal_can_frame_t frame = frame_of(5U, 3U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_destroy(address));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_open(&other, address, OSAL_CAN_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&node, &frame));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_receive(&wire, &out));
}

static void memory_of_another_kind_is_no_bus(void)
{
    char name[48];
    char shm_address[64];
    osal_shm_t shm;
    osal_can_t other;
    (void)snprintf(name, sizeof name, "/osal-can-other-%d", (int)osal_process_own_id());
    (void)snprintf(shm_address, sizeof shm_address, "shm:%s", &name[1]);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, name, 4096U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_can_open(&other, shm_address, OSAL_CAN_WIRE));
    osal_shm_close(&shm);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name));
}

/// A call reads as many frames as a ring has: then it returns, even if frames keep arriving.
static void one_call_skips_a_whole_ring_of_filtered_frames(void)
{
    const osal_can_filter_t filter = {.id = 0x7FFU, .mask = 0x7FFU};
    osal_can_frame_t out;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_can_filter(&node, &filter, 1U));
    for (uint32_t i = 0U; i < OSAL_CAN_RING_FRAMES; i++) {
        const osal_can_frame_t frame = frame_of(i, 8U, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_can_send(&wire, &frame));
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_can_receive(&node, &out));
    TEST_ASSERT_EQUAL_UINT32(OSAL_CAN_RING_FRAMES, node.filtered);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(both_directions_keep_order_and_content);
    RUN_TEST(error_and_remote_frames_pass_through);
    RUN_TEST(lengths_that_no_frame_can_have_are_refused);
    RUN_TEST(a_full_ring_refuses_and_counts_frames_and_keeps_those_that_it_took);
    RUN_TEST(a_node_that_opens_has_received_nothing_and_its_sent_frames_remain);
    RUN_TEST(addresses_of_missing_buses_and_malformed_addresses_are_refused);
    RUN_TEST(a_frame_passes_if_it_matches_one_filter);
    RUN_TEST(a_mask_may_have_any_bit);
    RUN_TEST(one_call_skips_a_whole_ring_of_filtered_frames);
    RUN_TEST(removed_bus_stays_usable_for_open_ends);
    RUN_TEST(memory_of_another_kind_is_no_bus);
    return UNITY_END();
}
