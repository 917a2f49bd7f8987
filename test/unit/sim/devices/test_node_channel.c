// SPDX-License-Identifier: Apache-2.0
// A node on a bus with two channels: it follows the master's heartbeat, searches for it, and stays on the
// channel where it found it.
#include "sim/devices/node.h"
#include "sim/devices/node_internal.h"
#include "unity.h"

#include <string.h>

#define ID 0x11U
#define SHEET "descriptors/devices/joint-drive.eds"
#define MS 1000000U
#define HEARTBEAT_TIME (60U * MS)   // 0x1016:01
#define DWELL (2U * HEARTBEAT_TIME) // Ttoggle heartbeat times
#define A NODE_CHANNEL_A
#define B NODE_CHANNEL_B

static bus_t* bus[NODE_CHANNELS];
static unsigned master[NODE_CHANNELS];
static node_t* node;
static char error[EDS_ERROR_MAX];
static unsigned heard[NODE_CHANNELS];    // Heartbeats of the node.
static uint64_t heard_ns[NODE_CHANNELS]; // Time of the last heartbeat.
static unsigned boots[NODE_CHANNELS];
static unsigned losses; // Number of times that the node reported the loss of the master.
static uint64_t present_ns;
static const unsigned channels[NODE_CHANNELS] = {A, B};

static void hear(void* context, const osal_can_frame_t* frame)
{
    const unsigned channel = *(const unsigned*)context;
    if (frame->id == (0x700U + ID)) {
        heard[channel]++;
        heard_ns[channel] = frame->time_ns;
        boots[channel] += (frame->data[0] == 0U) ? 1U : 0U;
    }
}

static void do_nothing(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
}

static void written(void* context, const object_t* object, uint64_t now_ns)
{
    (void)context;
    (void)object;
    (void)now_ns;
}

static void lost(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
    losses++;
}

static const node_application_t application = {
    .sample = do_nothing, .written = written, .connection_lost = lost, .reset = do_nothing};

static uint64_t value(uint8_t subindex)
{
    return node_object(node, 0x2000U, subindex)->value;
}

static void set(uint8_t subindex, int64_t number)
{
    object_set(node_object(node, 0x2000U, subindex), number);
}

/// Simulate both channels for this time in the steps of the simulator.
static void wait(uint64_t ns)
{
    const uint64_t end_ns = present_ns + ns;
    while (present_ns < end_ns) {
        present_ns += MS / 2U;
        bus_run_until(bus[A], present_ns);
        bus_run_until(bus[B], present_ns);
    }
}

static void send_on(unsigned channel, uint32_t id, const uint8_t* octets, uint8_t length)
{
    osal_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, octets, length);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(bus[channel], master[channel], &frame, present_ns));
}

/// Send the master's heartbeat every 20 ms on a channel.
static void send_heartbeats(unsigned channel, uint64_t ns)
{
    const uint8_t state = 5U;
    for (uint64_t done = 0U; done < ns; done += 20U * MS) {
        send_on(channel, 0x701U, &state, 1U);
        wait(20U * MS);
    }
}

static void forget(void)
{
    memset(heard, 0, sizeof heard);
    memset(boots, 0, sizeof boots);
    losses = 0U;
}

void setUp(void)
{
    const bus_config_t config = {.nominal_bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
    present_ns                = 0U;
    for (unsigned i = 0U; i < NODE_CHANNELS; i++) {
        const bus_callbacks_t callbacks = {.on_frame = hear, .context = (void*)(uintptr_t)&channels[i]};
        bus[i]                          = bus_create(&config);
        TEST_ASSERT_NOT_NULL(bus[i]);
        TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus[i], &callbacks, &master[i]));
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, node_create(bus[A], SHEET, ID, &application, &node, error),
                                  error);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, node_add_channel(node, bus[B]));
    forget();
    node_power_on(node);
}

void tearDown(void)
{
    node_destroy(node);
    bus_destroy(bus[A]);
    bus_destroy(bus[B]);
}

static void a_node_begins_on_bdefault_and_stays_on_the_channel_of_its_master(void)
{
    wait(5U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, boots[A]);
    send_heartbeats(A, 2000U * MS);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    TEST_ASSERT_EQUAL_UINT64(0U, value(4U));
    TEST_ASSERT_EQUAL_UINT(0U, heard[B]);
    TEST_ASSERT_EQUAL_UINT(0U, losses);
}

static void without_a_master_a_node_searches_from_power_on(void)
{
    wait(DWELL - (2U * MS));
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    wait(6U * MS);
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    TEST_ASSERT_EQUAL_UINT64(1U, value(4U));
    wait(DWELL);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    TEST_ASSERT_EQUAL_UINT64(2U, value(4U));
}

static void after_a_loss_the_node_changes_channels_every_ttoggle_heartbeat_times(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS); // The last heartbeat was 20 ms ago.
    forget();
    wait(HEARTBEAT_TIME - (25U * MS));
    TEST_ASSERT_EQUAL_UINT(0U, losses);
    wait(10U * MS);
    // The application learns of the loss at once; the channel changes later.
    TEST_ASSERT_EQUAL_UINT(1U, losses);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    wait(HEARTBEAT_TIME - (10U * MS));
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    TEST_ASSERT_EQUAL_UINT(0U, heard[B]);
    wait(10U * MS);
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    TEST_ASSERT_EQUAL_UINT(1U, heard[B]); // Its first heartbeat on the channel.
}

static void the_master_is_heard_on_the_other_channel_within_ttoggle_heartbeat_times(void)
{
    for (unsigned phase = 0U; phase < 24U; phase++) {
        tearDown();
        setUp();
        wait(5U * MS);
        send_heartbeats(A, 100U * MS);
        // The node searches; `phase` varies where it is in its sequence.
        wait(200U * MS + (phase * 10U * MS));
        forget();
        const uint64_t begin_ns = present_ns;
        while (heard[B] == 0U) {
            send_heartbeats(B, 20U * MS);
            TEST_ASSERT_TRUE((present_ns - begin_ns) <= (DWELL + (20U * MS)));
        }
        TEST_ASSERT_TRUE(heard_ns[B] <= (begin_ns + DWELL + MS));
        send_heartbeats(B, 1000U * MS);
        TEST_ASSERT_EQUAL_UINT(B, node->active);
        TEST_ASSERT_EQUAL_UINT64(0U, value(4U)); // The received heartbeat has reset the count.
        TEST_ASSERT_EQUAL_UINT64(B, value(1U));  // This channel is the default from now on.
    }
}

static void the_search_ends_after_ntoggle_changes(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    set(3U, 3);
    wait(10U * DWELL);
    TEST_ASSERT_EQUAL_UINT64(3U, value(4U));
    TEST_ASSERT_EQUAL_UINT(B, node->active); // An odd number of changes ends on the other channel.
    send_heartbeats(A, 500U * MS);
    TEST_ASSERT_EQUAL_UINT(B, node->active); // The node stays on B although the master is on channel A.
    send_heartbeats(B, 40U * MS);
    TEST_ASSERT_EQUAL_UINT64(0U, value(4U)); // A heartbeat on channel B resets the count.
    wait(DWELL + (5U * MS));
    TEST_ASSERT_EQUAL_UINT(A, node->active); // The node searches again when it loses that heartbeat.
}

static void an_ntoggle_or_ttoggle_of_zero_disables_the_search(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    set(3U, 0);
    wait(10U * DWELL);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    send_heartbeats(A, 100U * MS);
    set(3U, 10);
    set(2U, 0);
    wait(10U * DWELL);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
}

static void a_reset_keeps_the_channel_and_a_power_cycle_does_not(void)
{
    const uint8_t reset[] = {0x81U, ID};
    wait(DWELL + (10U * MS));
    send_heartbeats(B, 100U * MS);
    forget();
    send_on(B, 0U, reset, 2U);
    send_heartbeats(B, 100U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, boots[B]);
    TEST_ASSERT_EQUAL_UINT(0U, boots[A]);
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    node_unplug(node);
    wait(10U * MS);
    node_plug(node);
    wait(10U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, boots[A]);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    send_heartbeats(B, DWELL + (40U * MS)); // The master is on B, so the node changes to B.
    TEST_ASSERT_EQUAL_UINT(B, node->active);
}

static void a_master_that_comes_back_is_found_on_either_channel(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    wait(DWELL + (10U * MS));
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    send_heartbeats(A, DWELL + (20U * MS));
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    send_heartbeats(A, 500U * MS);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
}

static void a_cut_channel_is_silent_and_the_other_works(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    node_cut(node, A, true);
    TEST_ASSERT_TRUE(node_is_plugged(node));
    forget();
    send_heartbeats(B, DWELL + (40U * MS));
    TEST_ASSERT_EQUAL_UINT(0U, heard[A]);
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    TEST_ASSERT_EQUAL_UINT(1U, losses);
}

static void a_node_without_channels_is_silent_until_one_is_restored(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    node_cut(node, A, true);
    wait(50U * MS); // The second channel is cut before the loss of the first is detected.
    node_cut(node, B, true);
    forget();
    wait(7U * DWELL);
    TEST_ASSERT_EQUAL_UINT(0U, heard[A]);
    TEST_ASSERT_EQUAL_UINT(0U, heard[B]);
    TEST_ASSERT_EQUAL_UINT64(7U, value(4U));
    node_cut(node, B, false);
    send_heartbeats(B, DWELL + (20U * MS));
    TEST_ASSERT_EQUAL_UINT(B, node->active);
    TEST_ASSERT_GREATER_THAN_UINT(0U, heard[B]);
}

static void a_cut_during_the_change_of_channel_does_not_end_the_search(void)
{
    wait(5U * MS);
    send_heartbeats(A, 100U * MS);
    node_cut(node, A, true);
    send_heartbeats(B, DWELL); // The node is about to find the master on B, or has just found it.
    node_cut(node, B, true);
    node_cut(node, A, false); // B is cut and the first channel is restored.
    forget();
    send_heartbeats(A, (2U * DWELL) + (20U * MS));
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    TEST_ASSERT_GREATER_THAN_UINT(0U, heard[A]);
}

/// Replace the node of setUp by a node that has channel A only.
static void make_single(void)
{
    bus_remove_node(bus[A], node_bus_index(node, A));
    bus_remove_node(bus[B], node_bus_index(node, B));
    node_destroy(node);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, node_create(bus[A], SHEET, ID, &application, &node, error));
}

static void without_channel_b_nothing_changes(void)
{
    make_single();
    TEST_ASSERT_EQUAL_UINT(BUS_NODES_MAX, node_bus_index(node, B));
    forget();
    node_power_on(node);
    wait(20U * DWELL);
    TEST_ASSERT_EQUAL_UINT(A, node->active);
    TEST_ASSERT_EQUAL_UINT64(0U, value(4U));
}

static void a_full_bus_has_no_room_for_channel_b(void)
{
    const bus_callbacks_t silent = {.context = NULL};
    unsigned index               = 0U;
    make_single();
    while (bus_add_node(bus[B], &silent, &index) == STATUS_OK) {
    }
    TEST_ASSERT_EQUAL_INT(STATUS_EXHAUSTED, node_add_channel(node, bus[B]));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_node_begins_on_bdefault_and_stays_on_the_channel_of_its_master);
    RUN_TEST(without_a_master_a_node_searches_from_power_on);
    RUN_TEST(after_a_loss_the_node_changes_channels_every_ttoggle_heartbeat_times);
    RUN_TEST(the_master_is_heard_on_the_other_channel_within_ttoggle_heartbeat_times);
    RUN_TEST(the_search_ends_after_ntoggle_changes);
    RUN_TEST(an_ntoggle_or_ttoggle_of_zero_disables_the_search);
    RUN_TEST(a_reset_keeps_the_channel_and_a_power_cycle_does_not);
    RUN_TEST(a_master_that_comes_back_is_found_on_either_channel);
    RUN_TEST(a_cut_channel_is_silent_and_the_other_works);
    RUN_TEST(a_node_without_channels_is_silent_until_one_is_restored);
    RUN_TEST(a_cut_during_the_change_of_channel_does_not_end_the_search);
    RUN_TEST(without_channel_b_nothing_changes);
    RUN_TEST(a_full_bus_has_no_room_for_channel_b);
    return UNITY_END();
}
