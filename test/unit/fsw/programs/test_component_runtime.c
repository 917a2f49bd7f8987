// SPDX-License-Identifier: Apache-2.0
// What the run determines: the windows of messages between components, the sockets of links, the receiver to
// which a frame of a link is announced, the promises of components.
#include "fsw/programs/component_runtime.h"

#include "unity.h"

#include <string.h>

#define ARM 16U

static run_state_t run;
static mission_descriptor_t mission;
static message_ring_carrier_t ring_carrier;
static component_runtime_t runtimes[2];
static message_slot_t slots[2];
static unsigned udp_opened, tipc_opened; // Sockets that the runtime has opened.
static unsigned received;                // Attempts to receive a sample. None has arrived.
static unsigned waits[2];                // Waits for each socket of links.
static unsigned other_waits;

status_t __wrap_osal_udp_open(osal_socket_t* socket, osal_address_t local, size_t receive_bytes)
{
    (void)socket;
    (void)local;
    (void)receive_bytes;
    udp_opened++;
    return STATUS_OK;
}

status_t __wrap_osal_tipc_open(osal_socket_t* socket, osal_tipc_kind_t kind, const osal_tipc_name_t* name,
                               osal_tipc_scope_t scope)
{
    (void)socket;
    (void)kind;
    (void)name;
    (void)scope;
    tipc_opened++;
    return STATUS_OK;
}

status_t __wrap_osal_udp_receive(osal_socket_t* socket, osal_address_t* out_from, uint8_t* octets,
                                 size_t capacity, size_t* out_size)
{
    (void)socket;
    (void)out_from;
    (void)octets;
    (void)capacity;
    *out_size = 0U;
    received++;
    return STATUS_EMPTY;
}

status_t __wrap_osal_socket_wait_readable(osal_socket_t* socket, uint32_t timeout_ms)
{
    const bool is_first = (socket == &runtimes[1].link_sockets[0]);
    unsigned* const of  = is_first ? &waits[0] : &waits[1];
    if (is_first || (socket == &runtimes[1].link_sockets[1])) {
        (*of)++;
    } else {
        other_waits++;
    }
    TEST_ASSERT_EQUAL_UINT32(50U, timeout_ms); // The sockets share the time of a wait.
    return STATUS_TIMEOUT;
}

static void ignore(void* const context, const uint16_t to)
{
    (void)context;
    (void)to;
}

void setUp(void)
{
    run = (run_state_t){.component_count = 2U,
                        .components      = {{.apid = SUPERVISOR_APID, .name = "SUPERVISOR", .life = 1U},
                                            {.apid = ARM, .name = "ARM", .life = 1U}}};
    message_ring_carrier_init(&ring_carrier, (message_delivery_notice_t){NULL, ignore});
    for (unsigned i = 0U; i < 2U; i++) {
        runtimes[i] = (component_runtime_t){.run          = &run,
                                            .mission      = &mission,
                                            .component    = i,
                                            .apid         = run.components[i].apid,
                                            .life         = 1U,
                                            .ring_carrier = &ring_carrier};
    }
}

void tearDown(void)
{
}

static status_t open_inbox(const unsigned index)
{
    return component_runtime_open_inbox(&runtimes[index], &slots[index], 1U);
}

static uint32_t send_largest(const unsigned from, const uint16_t to)
{
    static const uint8_t block[MESSAGE_PAYLOAD_MAX];
    uint32_t sent = 0U;
    while (message_send(&runtimes[from].endpoint, to, block, sizeof block) == STATUS_OK) {
        sent++;
    }
    return sent;
}

static void both_ends_use_the_window_of_the_run(void)
{
    run.components[1].message_window = MESSAGE_SMALL_WINDOW_OCTETS;
    TEST_ASSERT_EQUAL(STATUS_OK, open_inbox(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, open_inbox(1U));
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_SMALL_WINDOW_OCTETS / MESSAGE_FRAME_MAX, send_largest(0U, ARM));
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX, send_largest(1U, SUPERVISOR_APID));
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_SMALL_WINDOW_OCTETS, runtimes[1].endpoint.window);
    TEST_ASSERT_EQUAL_UINT32(MESSAGE_WINDOW_OCTETS, runtimes[0].endpoint.window);
}

static void a_window_for_which_there_is_no_room_is_refused_with_a_message(void)
{
    run.components[1].message_window = MESSAGE_ROOM_OCTETS + 1U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, open_inbox(1U));
    TEST_ASSERT_EQUAL_STRING_LEN("ARM: too many peers, or a window too large: ", runtimes[1].error, 44U);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, open_inbox(0U));
    TEST_ASSERT_NOT_NULL(strstr(runtimes[0].error, "SUPERVISOR: too many peers"));
}

/// With TIME=free there is no scheduler. A component that has not made a step yet has promised none.
static void without_a_scheduler_the_last_beat_contains_the_promise(void)
{
    run_state_beat(&run, 1U, 0U, OSAL_LOCKSTEP_NEVER);
    TEST_ASSERT_EQUAL_UINT64(OSAL_LOCKSTEP_NEVER, component_runtime_promise_ns(&runtimes[0], NULL, 1U));
    run_state_beat(&run, 1U, 5U, 7U);
    TEST_ASSERT_EQUAL_UINT64(7U, component_runtime_promise_ns(&runtimes[0], NULL, 1U));
}

/// Take the runtime of the arm with real-time links of this method; it must open one socket to send.
static void take_with(const rtlink_method_t method)
{
    static subsystem_descriptor_t own;
    static const component_descriptors_t descriptors;
    const component_runtime_surroundings_t surroundings = {
        .run = &run, .mission = &mission, .descriptors = &descriptors, .ring_carrier = &ring_carrier};
    udp_opened       = 0U;
    tipc_opened      = 0U;
    run.link_methods = (uint8_t)(1U << (unsigned)method);
    TEST_ASSERT_EQUAL(STATUS_OK, component_runtime_take(&runtimes[1], &surroundings, &own, 1U));
}

static void samples_are_sent_by_the_method_of_the_links(void)
{
    take_with(RTLINK_METHOD_UDP);
    TEST_ASSERT_EQUAL_UINT(1U, udp_opened);
    TEST_ASSERT_EQUAL_UINT(0U, tipc_opened);
    take_with(RTLINK_METHOD_TIPC);
    TEST_ASSERT_EQUAL_UINT(0U, udp_opened);
    TEST_ASSERT_EQUAL_UINT(1U, tipc_opened);
}

/// Announce a frame of link 3 of the arm to the supervisor, in the given epoch. Returns what was announced.
static const osal_deliveries_t* deliver_frame(const uint32_t epoch)
{
    static const mission_link_t link         = {.number = 3U, .consumer_apid = SUPERVISOR_APID};
    static const mission_descriptor_t linked = {.link_count = 1U, .links = &link};
    run.is_stepped                           = true;
    take_with(RTLINK_METHOD_UDP);
    runtimes[1].mission             = &linked;
    runtimes[1].peers[0].link_floor = 7U;
    runtimes[1].links.delivered(runtimes[1].links.context, 3U, epoch);
    return &runtimes[1].deliveries;
}

static void a_frame_is_announced_once_and_to_its_next_receiver_only(void)
{
    const unsigned consumer         = run_participant(0U);
    const unsigned relay            = run_relay(&run);
    const osal_deliveries_t* direct = deliver_frame(8U);
    TEST_ASSERT_EQUAL_UINT32(1U, direct->messages[consumer]);
    TEST_ASSERT_EQUAL_UINT32(0U, direct->messages[relay]);
    // The link belongs to an earlier life of the consumer.
    TEST_ASSERT_EQUAL_UINT32(0U, deliver_frame(7U)->messages[consumer]);
    run.relay.delay_us               = 1U;
    const osal_deliveries_t* relayed = deliver_frame(8U);
    TEST_ASSERT_EQUAL_UINT32(1U, relayed->messages[relay]);
    TEST_ASSERT_EQUAL_UINT32(OSAL_LOCKSTEP_ANY_LIFE, relayed->lives[relay]);
    TEST_ASSERT_EQUAL_UINT32(0U, relayed->octets[relay]);
    TEST_ASSERT_EQUAL_UINT32(0U, relayed->messages[consumer]);
    // The scheduler does not wait for the frames of a network.
    run.relay.is_network = true;
    TEST_ASSERT_EQUAL_UINT32(0U, deliver_frame(8U)->messages[relay]);
    TEST_ASSERT_EQUAL_UINT32(0U, runtimes[1].deliveries.messages[consumer]);
}

/// Each link with a relay has a play-out buffer of its own, and keeps it.
static void a_link_keeps_its_play_out_buffer(void)
{
    static component_play_outs_t play_outs;
    rtlink_play_out_t* buffer = NULL;
    take_with(RTLINK_METHOD_UDP);
    runtimes[1].play_outs                = &play_outs;
    const rtlink_resolver_t* const links = &runtimes[1].links;
    TEST_ASSERT_EQUAL(STATUS_OK, links->play_out(links->context, 1U, &buffer));
    TEST_ASSERT_NULL(buffer); // No relay.
    run.relay.delay_us  = 20U;
    run.relay.jitter_us = 3U;
    for (uint16_t round = 0U; round < 2U; round++) {
        for (uint16_t i = 0U; i < COMPONENT_PLAY_OUTS_MAX; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, links->play_out(links->context, i + 5U, &buffer));
            TEST_ASSERT_EQUAL_PTR(&play_outs.buffers[i], buffer);
            TEST_ASSERT_EQUAL_UINT32(20U, buffer->delay_us);
            TEST_ASSERT_EQUAL_UINT32(3U, buffer->budget_us);
        }
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, links->play_out(links->context, 4U, &buffer));
    TEST_ASSERT_NULL(buffer);
}

static void refuse_datagram(void* const context, const uint8_t* const octets, const size_t size)
{
    (void)context;
    (void)octets;
    (void)size;
    TEST_FAIL_MESSAGE("no datagram has arrived");
}

/// Receive in an intake of the arm, which consumes two links. Returns the attempts to receive a sample.
static unsigned pump(const uint32_t intake, const uint32_t announced)
{
    component_runtime_t* const arm = &runtimes[1];
    arm->clock.mode                = OSAL_CLOCK_STEPPED;
    arm->message_socket.descriptor = -1;
    arm->topology.descriptor       = -1;
    arm->link_socket_count         = 2U;
    arm->peers[0].life             = 1U;
    arm->peers[1].life             = 1U;
    arm->pumps                     = intake;
    received                       = 0U;
    other_waits                    = 0U;
    (void)memset(waits, 0, sizeof waits);
    component_runtime_pump(arm, announced, refuse_datagram, NULL);
    return received;
}

static void without_announced_datagrams_the_sockets_are_read_in_few_intakes(void)
{
    TEST_ASSERT_EQUAL_UINT(0U, pump(1U, 0U));
    TEST_ASSERT_EQUAL_UINT(0U, pump(15U, 0U));
    TEST_ASSERT_EQUAL_UINT(2U, pump(16U, 0U));
    run.relay.is_network = true;
    TEST_ASSERT_EQUAL_UINT(2U, pump(1U, 0U));
    run.relay.is_network    = false;
    runtimes[1].outstanding = 1U;
    TEST_ASSERT_EQUAL_UINT(2U, pump(1U, 0U));
    TEST_ASSERT_EQUAL_UINT(0U, waits[0] + waits[1] + other_waits);
    TEST_ASSERT_EQUAL_UINT(0U, run.is_lossy);
}

static void announced_datagrams_are_awaited_at_each_socket(void)
{
    TEST_ASSERT_EQUAL_UINT(2U * 51U, pump(1U, 1U));
    TEST_ASSERT_EQUAL_UINT(50U, waits[0]);
    TEST_ASSERT_EQUAL_UINT(50U, waits[1]);
    TEST_ASSERT_EQUAL_UINT(0U, other_waits);
    TEST_ASSERT_EQUAL_UINT32(1U, runtimes[1].outstanding);
    TEST_ASSERT_EQUAL_UINT(1U, run.is_lossy);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(both_ends_use_the_window_of_the_run);
    RUN_TEST(a_window_for_which_there_is_no_room_is_refused_with_a_message);
    RUN_TEST(without_a_scheduler_the_last_beat_contains_the_promise);
    RUN_TEST(samples_are_sent_by_the_method_of_the_links);
    RUN_TEST(a_frame_is_announced_once_and_to_its_next_receiver_only);
    RUN_TEST(a_link_keeps_its_play_out_buffer);
    RUN_TEST(without_announced_datagrams_the_sockets_are_read_in_few_intakes);
    RUN_TEST(announced_datagrams_are_awaited_at_each_socket);
    return UNITY_END();
}
