// SPDX-License-Identifier: Apache-2.0
// Pulses on the lines of a power unit, and their effect on the nodes that the unit supplies.
#include "sim/devices/power_unit.h"
#include "sim/devices/node_internal.h"
#include "test/unit/sim/devices/master.h"
#include "unity.h"

#define UNIT 0x1FU
#define SHEET "descriptors/devices/joint-drive.eds"
#define NODES 2U

static master_t master;
static node_t* nodes[NODES];
static power_unit_t unit;

static void ignore(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
}

static void ignore_object(void* context, const object_t* object, uint64_t now_ns)
{
    (void)object;
    ignore(context, now_ns);
}

void setUp(void)
{
    static const node_application_t application = {
        .sample = ignore, .written = ignore_object, .connection_lost = ignore, .reset = ignore};
    char error[EDS_ERROR_MAX];
    master_open(&master, false);
    power_unit_init(&unit, UNIT);
    for (unsigned i = 0U; i < NODES; i++) {
        TEST_ASSERT_EQUAL_MESSAGE(
            STATUS_OK, node_create(master.bus, SHEET, (uint8_t)(0x11U + i), &application, &nodes[i], error),
            error);
        node_power_on(nodes[i]);
        power_unit_add(&unit, nodes[i]);
    }
}

void tearDown(void)
{
    for (unsigned i = 0U; i < NODES; i++) {
        node_destroy(nodes[i]);
    }
    master_close(&master);
}

static void pulse(uint32_t id, unsigned line, uint8_t exponent, uint8_t length)
{
    const osal_can_frame_t frame = {.id      = id,
                                    .length  = length,
                                    .data    = {(uint8_t)line, (uint8_t)(line >> 8U), exponent},
                                    .time_ns = bus_now_ns(master.bus)};
    power_unit_receive(&unit.port[NODE_CHANNEL_A], &frame);
}

static void wait(uint64_t ns)
{
    master_wait(&master, ns);
    power_unit_step(&unit, bus_now_ns(master.bus));
}

static void one_pulse_opens_a_relay_and_another_closes_it(void)
{
    pulse(0x200U + UNIT, 4U, 1U, 3U);
    wait(POWER_UNIT_LATCH_NS - 1U);
    TEST_ASSERT_TRUE(node_is_powered(nodes[1]));
    wait(1U);
    TEST_ASSERT_FALSE(node_is_powered(nodes[1]));
    TEST_ASSERT_TRUE(node_is_powered(nodes[0]));
    master_forget(&master);
    pulse(0x200U + UNIT, 3U, 7U, 3U);
    wait(POWER_UNIT_LATCH_NS);
    wait(5U * MASTER_MS);
    TEST_ASSERT_TRUE(node_is_powered(nodes[1]));
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x712U)); // The node boots.
}

static void a_closed_relay_stays_closed(void)
{
    wait(5U * MASTER_MS);
    pulse(0x200U + UNIT, 1U, 2U, 3U);
    master_forget(&master);
    wait(POWER_UNIT_LATCH_NS);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, nodes[0]->state); // The node has not booted again.
}

static void frames_that_are_not_a_pulse_of_the_unit_are_ignored(void)
{
    pulse(0x200U + UNIT, 2U, 0U, 3U); // Too short a pulse for the relay.
    pulse(0x200U + UNIT, 2U, 8U, 3U);
    pulse(0x200U + UNIT, 2U, 1U, 2U);
    pulse(0x200U + UNIT, 2U, 1U, 4U);
    pulse(0x200U + UNIT, 0U, 1U, 3U);
    pulse(0x200U + UNIT, 6U, 1U, 3U);
    pulse(0x200U + UNIT, 0x102U, 1U, 3U);
    pulse(0x300U + UNIT, 2U, 1U, 3U);
    pulse(OSAL_CAN_ERROR | 0x200U | UNIT, 2U, 1U, 3U);
    wait(POWER_UNIT_LATCH_NS);
    TEST_ASSERT_TRUE(node_is_powered(nodes[0]) && node_is_powered(nodes[1]));
}

/// The relays of a disconnected unit keep their state; disconnecting or resetting it cancels a pulse that has
/// begun.
static void a_disconnected_unit_ignores_pulses_and_keeps_its_relays(void)
{
    const osal_can_frame_t open = {.id = 0x200U + UNIT, .length = 3U, .data = {2U, 0U, 1U}};
    pulse(0x200U + UNIT, 2U, 1U, 3U);
    power_unit_plug(&unit, false);
    wait(POWER_UNIT_LATCH_NS);
    pulse(0x200U + UNIT, 2U, 1U, 3U);
    wait(POWER_UNIT_LATCH_NS);
    power_unit_plug(&unit, true);
    pulse(0x200U + UNIT, 2U, 1U, 3U);
    power_unit_reset(&unit);
    wait(POWER_UNIT_LATCH_NS);
    power_unit_cut(&unit, NODE_CHANNEL_A, true);
    pulse(0x200U + UNIT, 2U, 1U, 3U);
    wait(POWER_UNIT_LATCH_NS);
    TEST_ASSERT_TRUE(node_is_powered(nodes[0]));
    power_unit_receive(&unit.port[NODE_CHANNEL_B], &open); // The other channel is connected.
    wait(POWER_UNIT_LATCH_NS);
    TEST_ASSERT_FALSE(node_is_powered(nodes[0]));
    power_unit_cut(&unit, NODE_CHANNEL_A, false);
    pulse(0x200U + UNIT, 1U, 1U, 3U);
    wait(POWER_UNIT_LATCH_NS);
    TEST_ASSERT_TRUE(node_is_powered(nodes[0]));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(one_pulse_opens_a_relay_and_another_closes_it);
    RUN_TEST(a_closed_relay_stays_closed);
    RUN_TEST(frames_that_are_not_a_pulse_of_the_unit_are_ignored);
    RUN_TEST(a_disconnected_unit_ignores_pulses_and_keeps_its_relays);
    return UNITY_END();
}
