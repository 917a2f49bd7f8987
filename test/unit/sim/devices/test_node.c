// SPDX-License-Identifier: Apache-2.0
// A node on the bus: boot-up, NMT, heartbeats, SYNC, PDOs with their types and deadlines, emergencies,
// configuration.
#include "sim/devices/node.h"
#include "sim/devices/node_internal.h"
#include "test/unit/sim/devices/master.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define ID 0x11U
#define SHEET "descriptors/devices/joint-drive.eds"
#define FEWER_PDOS "build/test/node-with-fewer-pdos.eds"

static master_t master;
static node_t* node;
static const char* sheet = SHEET;
static char error[EDS_ERROR_MAX];

/// Calls of the application, in order: s sample, w written, l connection lost, r reset.
static char calls[4096];
static size_t calls_length;
static uint16_t controlword_at_sample;

static void note(char what)
{
    if (calls_length < (sizeof calls - 1U)) {
        calls[calls_length++] = what;
        calls[calls_length]   = '\0';
    }
}

static void on_sample(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
    controlword_at_sample = (uint16_t)node_object(node, 0x6040U, 0U)->value;
    object_set(node_object(node, 0x6041U, 0U), controlword_at_sample);
    note('s');
}

static void on_written(void* context, const object_t* object, uint64_t now_ns)
{
    (void)context;
    (void)object;
    (void)now_ns;
    note('w');
}

static void on_lost(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
    note('l');
}

static void on_reset(void* context, uint64_t now_ns)
{
    (void)context;
    (void)now_ns;
    note('r');
}

static const node_application_t application = {
    .sample = on_sample, .written = on_written, .connection_lost = on_lost, .reset = on_reset};

static void forget_received(void)
{
    calls_length = 0U;
    calls[0]     = '\0';
    master_forget(&master);
}

void setUp(void)
{
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, node_create(master.bus, sheet, ID, &application, &node, error));
    forget_received();
    node_power_on(node);
    master_wait(&master, 2U * MASTER_MS);
}

void tearDown(void)
{
    node_destroy(node);
    master_close(&master);
}

static void start(void)
{
    master_nmt(&master, 1U, ID);
    TEST_ASSERT_EQUAL_INT(NODE_OPERATIONAL, node->state);
    forget_received();
}

static void send_rpdo(uint16_t controlword)
{
    const uint8_t data[8] = {(uint8_t)controlword, (uint8_t)(controlword >> 8)};
    master_send(&master, 0x200U + ID, data, 8U);
}

static void power_on_sends_one_boot_up_and_leads_to_pre_operational(void)
{
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x711U));
    const osal_can_frame_t* boot_up = master_last(&master, 0x711U);
    TEST_ASSERT_EQUAL_UINT8(1U, boot_up->length);
    TEST_ASSERT_EQUAL_HEX8(0x00U, boot_up->data[0]);
    TEST_ASSERT_UINT64_WITHIN(60000U, 1000000U + (ID * 10000U) + 30000U, boot_up->time_ns);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
    TEST_ASSERT_EQUAL_STRING("r", calls);
}

static void the_heartbeat_reports_the_state_every_20_ms(void)
{
    master_forget(&master);
    master_wait(&master, 100U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(5U, master_heard(&master, 0x711U));
    TEST_ASSERT_EQUAL_HEX8(0x7FU, master_last(&master, 0x711U)->data[0]);
    TEST_ASSERT_UINT64_WITHIN(2000U, 20U * MASTER_MS, master.heard[1].time_ns - master.heard[0].time_ns);
    master_nmt(&master, 1U, 0U);
    master_wait(&master, 20U * MASTER_MS);
    TEST_ASSERT_EQUAL_HEX8(0x05U, master_last(&master, 0x711U)->data[0]);
    master_nmt(&master, 2U, ID);
    master_wait(&master, 20U * MASTER_MS);
    TEST_ASSERT_EQUAL_HEX8(0x04U, master_last(&master, 0x711U)->data[0]);
    master_nmt(&master, 128U, ID);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1017U, 0U, 5U, 2U));
    master_forget(&master);
    master_wait(&master, 50U * MASTER_MS);
    TEST_ASSERT_UINT_WITHIN(1U, 10U, master_heard(&master, 0x711U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1017U, 0U, 0U, 2U));
    master_forget(&master);
    master_wait(&master, 50U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x711U));
}

static void nmt_commands_to_other_nodes_and_malformed_ones_are_ignored(void)
{
    master_nmt(&master, 1U, ID + 1U);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
    master_nmt(&master, 77U, ID);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
    const uint8_t short_command[] = {1U};
    master_send(&master, 0U, short_command, 1U);
    master_wait(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
}

static void a_reset_restores_the_defaults_and_boots_again(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1017U, 0U, 7U, 2U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6065U, 0U, 123U, 4U));
    forget_received();
    master_nmt(&master, 130U, ID); // Reset communication.
    master_wait(&master, 2U * MASTER_MS);
    TEST_ASSERT_EQUAL_HEX8(0U, master_last(&master, 0x711U)->data[0]);
    TEST_ASSERT_EQUAL_UINT64(20U, node_object(node, 0x1017U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT64(123U, node_object(node, 0x6065U, 0U)->value);
    TEST_ASSERT_EQUAL_STRING("l", calls);
    forget_received();
    master_nmt(&master, 129U, 0U);
    master_wait(&master, 2U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x711U));
    TEST_ASSERT_EQUAL_UINT64(50000U, node_object(node, 0x6065U, 0U)->value);
    TEST_ASSERT_EQUAL_STRING("r", calls);
}

static void at_sync_a_node_applies_outputs_then_samples_then_sends(void)
{
    start();
    send_rpdo(0x1234U);
    master_wait(&master, 200U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("", calls); // The RPDO is received, but not applied before SYNC.
    TEST_ASSERT_EQUAL_HEX64(0U, node_object(node, 0x6040U, 0U)->value);
    master_sync(&master, 300U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("wwws", calls); // Three mapped objects, then the sample.
    TEST_ASSERT_EQUAL_HEX16(0x1234U, controlword_at_sample);
    // The TPDO already shows the effect of the RPDO.
    const osal_can_frame_t* tpdo = master_last(&master, 0x191U);
    TEST_ASSERT_NOT_NULL(tpdo);
    TEST_ASSERT_EQUAL_UINT8(8U, tpdo->length);
    TEST_ASSERT_EQUAL_HEX8(OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, tpdo->flags);
    TEST_ASSERT_EQUAL_HEX16(0x1234U, octets_u16(tpdo->data));
    forget_received();
    master_sync(&master, 300U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("s", calls); // No new RPDO has come.
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
}

static void the_last_rpdo_before_sync_is_applied(void)
{
    start();
    send_rpdo(1U);
    send_rpdo(2U);
    master_wait(&master, 300U * MASTER_US);
    master_sync(&master, 300U * MASTER_US);
    TEST_ASSERT_EQUAL_HEX16(2U, controlword_at_sample);
    TEST_ASSERT_EQUAL_STRING("wwws", calls);
}

static void no_pdo_is_exchanged_outside_of_operational(void)
{
    forget_received();
    send_rpdo(0x0FU);
    master_sync(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("", calls);
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x191U));
    start();
    master_nmt(&master, 2U, ID);
    TEST_ASSERT_EQUAL_STRING("l", calls); // The application is informed that the node leaves operational.
    master_sync(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x191U));
    uint32_t value = 0U;
    // A stopped node serves no SDO.
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, master_read(&master, ID, 0x1000U, 0U, &value));
}

static void a_tpdo_of_type_20_is_sent_with_every_20th_sync(void)
{
    start();
    for (unsigned i = 1U; i <= 60U; i++) {
        master_sync(&master, 400U * MASTER_US);
        TEST_ASSERT_EQUAL_UINT(i, master_heard(&master, 0x191U));
        TEST_ASSERT_EQUAL_UINT(i / 20U, master_heard(&master, 0x291U));
    }
}

static void a_tpdo_of_type_0_is_sent_with_sync_after_a_change(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 2U, 0U, 1U));
    start();
    master_sync(&master, 400U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x191U));
    send_rpdo(5U);
    master_wait(&master, 100U * MASTER_US);
    master_sync(&master, 400U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
    master_sync(&master, 400U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
}

static void event_driven_pdos_are_sent_at_events_and_after_their_timer(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 2U, 255U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 5U, 0U, 2U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1400U, 2U, 254U, 1U));
    forget_received();
    master_nmt(&master, 1U, ID);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U)); // Sent when the node enters OPERATIONAL.
    forget_received();
    send_rpdo(9U); // Applied at once.
    master_wait(&master, 200U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("www", calls);
    object_set(node_object(node, 0x6041U, 0U), 0x77);
    node_event(node, bus_now_ns(master.bus));
    node_event(node, bus_now_ns(master.bus));
    master_wait(&master, 200U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 5U, 3U, 2U)); // Event timer 3 ms.
    node_event(node, bus_now_ns(master.bus));
    object_set(node_object(node, 0x6041U, 0U), 0x78);
    node_event(node, bus_now_ns(master.bus));
    forget_received();
    master_wait(&master, 30U * MASTER_MS);
    TEST_ASSERT_UINT_WITHIN(1U, 10U, master_heard(&master, 0x191U));
}

static void a_missed_rpdo_deadline_is_reported_once_and_cleared(void)
{
    start();
    master_wait(&master, 10U * MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("", calls); // The deadline starts with the first RPDO.
    send_rpdo(1U);
    master_wait(&master, 100U * MASTER_US);
    const uint64_t received_ns = bus_now_ns(master.bus);
    master_wait(&master, 10U * MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("l", calls);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x091U));
    const osal_can_frame_t* emergency = master_last(&master, 0x091U);
    TEST_ASSERT_EQUAL_HEX16(0x8250U, octets_u16(emergency->data));
    TEST_ASSERT_EQUAL_HEX8(0x11U, emergency->data[2]); // Generic and communication.
    TEST_ASSERT_UINT64_WITHIN(250000U, received_ns + (2U * MASTER_MS), emergency->time_ns);
    send_rpdo(1U);
    master_wait(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_HEX64(0U, node_object(node, 0x1001U, 0U)->value);
    uint32_t history = 0U;
    TEST_ASSERT_EQUAL_UINT32(0U, master_read(&master, ID, 0x1003U, 1U, &history));
    TEST_ASSERT_EQUAL_HEX32(0x8250U, history & 0xFFFFU);
    // Clearing the history: only by zero.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1003U, 0U, 1U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1003U, 0U, 0U, 1U));
    TEST_ASSERT_EQUAL_UINT64(0U, node_object(node, 0x1003U, 1U)->value);
}

static void a_deadline_of_zero_never_expires(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1400U, 5U, 0U, 2U));
    start();
    send_rpdo(1U);
    master_wait(&master, 50U * MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("", calls);
}

static void a_lost_master_heartbeat_is_reported(void)
{
    const uint8_t operational[] = {5U};
    start();
    master_wait(&master, 200U * MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("", calls); // The deadline starts with the first heartbeat.
    for (unsigned i = 0U; i < 5U; i++) {
        master_send(&master, 0x701U, operational, 1U);
        master_wait(&master, 50U * MASTER_MS);
    }
    TEST_ASSERT_EQUAL_STRING("", calls);
    master_wait(&master, 30U * MASTER_MS);
    TEST_ASSERT_EQUAL_STRING("l", calls);
    TEST_ASSERT_EQUAL_HEX16(0x8130U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_HEX8(1U, master_last(&master, 0x091U)->data[4]);
    TEST_ASSERT_EQUAL_INT(NODE_OPERATIONAL, node->state); // The error behaviour 0x1029 = 1 keeps the state.
    master_send(&master, 0x701U, operational, 1U);
    master_wait(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1029U, 1U, 0U, 1U));
    master_wait(&master, 100U * MASTER_MS);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
}

static void a_pdo_that_is_too_short_is_reported_and_a_longer_one_is_applied(void)
{
    const uint8_t data[8] = {1U};
    start();
    master_send(&master, 0x211U, data, 7U);
    master_wait(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_HEX16(0x8210U, octets_u16(master_last(&master, 0x091U)->data));
    master_sync(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("s", calls); // Not applied.
    const osal_can_frame_t longer = {
        .id = 0x211U, .length = 12U, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, .data = {7U}};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(master.bus, master.node, &longer, 0U));
    master_wait(&master, 200U * MASTER_US);
    master_sync(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("swwws", calls);
    TEST_ASSERT_EQUAL_HEX16(7U, controlword_at_sample);
}

static void a_sync_without_its_counter_is_reported_once_and_applied(void)
{
    const uint8_t count[] = {1U};
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_STATE, master_write(&master, ID, 0x1019U, 0U, 240U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1006U, 0U, 0U, 4U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1019U, 0U, 1U, 1U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_TOO_HIGH, master_write(&master, ID, 0x1019U, 0U, 241U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1019U, 0U, 240U, 1U));
    start();
    master_send(&master, 0x080U, count, 1U);
    master_wait(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x091U));
    master_sync(&master, 500U * MASTER_US); // Without its counter: reported once, and still applied.
    master_sync(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(3U, master_heard(&master, 0x191U));
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x091U));
    TEST_ASSERT_EQUAL_HEX16(0x8240U, octets_u16(master_last(&master, 0x091U)->data));
}

static void the_sync_start_value_delays_a_pdo(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1006U, 0U, 0U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1019U, 0U, 10U, 1U));
    // The PDO is still valid.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_STATE, master_write(&master, ID, 0x1800U, 6U, 4U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 1U, 0x80000191U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 6U, 4U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 1U, 0x191U, 4U));
    start();
    for (uint8_t i = 1U; i <= 6U; i++) {
        master_send(&master, 0x080U, &i, 1U);
        master_wait(&master, 500U * MASTER_US);
        TEST_ASSERT_EQUAL_UINT((i < 4U) ? 0U : (i - 3U), master_heard(&master, 0x191U));
    }
}

static void a_mapping_is_changed_only_in_the_order_of_the_standard(void)
{
    const uint32_t velocity = 0x606C0020U;
    // The PDO is still valid.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_STATE, master_write(&master, ID, 0x1A00U, 0U, 0U, 1U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_STATE, master_write(&master, ID, 0x1800U, 1U, 0x1A0U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 1U, 0x80000191U, 4U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_STATE, master_write(&master, ID, 0x1A00U, 1U, velocity, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1A00U, 0U, 0U, 1U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_NOT_MAPPABLE, master_write(&master, ID, 0x1A00U, 1U, 0x50000010U, 4U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_NOT_MAPPABLE, master_write(&master, ID, 0x1A00U, 1U, 0x606C0010U, 4U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_NOT_MAPPABLE, master_write(&master, ID, 0x1A00U, 1U, 0x10180420U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1A00U, 1U, velocity, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1A00U, 2U, 0x60640020U, 4U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_PDO_LENGTH,
                            master_write(&master, ID, 0x1A00U, 0U, 3U, 1U)); // The PDO would have 10 octets.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1A00U, 0U, 9U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1A00U, 0U, 2U, 1U));
    // An identifier of 29 bits.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1800U, 1U, 0x20000191U, 4U));
    // The identifier of SYNC.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1800U, 1U, 0x00000080U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1800U, 1U, 0x1A0U, 4U));
    // Transmission on remote request.
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x1800U, 2U, 252U, 1U));
    start();
    object_set(node_object(node, 0x606CU, 0U), -2);
    object_set(node_object(node, 0x6064U, 0U), 7);
    master_sync(&master, 500U * MASTER_US);
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x191U));
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFEU, octets_u32(master_last(&master, 0x1A0U)->data));
    TEST_ASSERT_EQUAL_HEX32(7U, octets_u32(&master_last(&master, 0x1A0U)->data[4]));
}

static void a_mapping_can_be_switched_from_csp_to_cst(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1400U, 1U, 0x80000211U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1401U, 1U, 0x00000311U, 4U));
    start();
    const uint8_t data[8] = {0x0FU, 0U, 0xE8U, 0x03U};
    send_rpdo(0x55U); // RPDO1 is no longer valid.
    master_send(&master, 0x311U, data, 8U);
    master_wait(&master, 300U * MASTER_US);
    master_sync(&master, 300U * MASTER_US);
    TEST_ASSERT_EQUAL_HEX16(0x0FU, controlword_at_sample);
    TEST_ASSERT_EQUAL_UINT64(1000U, node_object(node, 0x6071U, 0U)->value);
}

static void a_node_without_power_is_silent_and_boots_when_powered(void)
{
    start();
    send_rpdo(1U);
    master_wait(&master, 200U * MASTER_US);
    node_power_off(node);
    forget_received();
    master_wait(&master, 100U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(0U, master.count);
    TEST_ASSERT_EQUAL_STRING("", calls); // No deadline is active that could expire.
    node_unplug(node);
    node_plug(node);
    master_wait(&master, 5U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(0U, master.count); // Plugging in does not switch the power on.
    TEST_ASSERT_FALSE(node_is_powered(node));
    node_power_on(node);
    master_wait(&master, 5U * MASTER_MS);
    TEST_ASSERT_TRUE(node_is_powered(node));
    TEST_ASSERT_EQUAL_HEX8(0U, master_last(&master, 0x711U)->data[0]);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
    TEST_ASSERT_EQUAL_HEX64(0U, node_object(node, 0x6040U, 0U)->value);
}

static void an_unplugged_node_is_silent_and_boots_when_plugged(void)
{
    start();
    send_rpdo(1U);
    master_wait(&master, 200U * MASTER_US);
    node_unplug(node);
    forget_received();
    master_wait(&master, 100U * MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(0U, master.count);
    TEST_ASSERT_EQUAL_STRING("l", calls); // The master's heartbeat has expired in the meantime.
    TEST_ASSERT_FALSE(node_is_plugged(node));
    forget_received();
    node_plug(node);
    master_wait(&master, 5U * MASTER_MS);
    TEST_ASSERT_EQUAL_HEX8(0U, master_last(&master, 0x711U)->data[0]);
    TEST_ASSERT_EQUAL_INT(NODE_PRE_OPERATIONAL, node->state);
    TEST_ASSERT_EQUAL_STRING("r", calls);
    TEST_ASSERT_EQUAL_HEX64(0U, node_object(node, 0x6040U, 0U)->value);
}

static void emergencies_set_the_error_register_and_the_error_history(void)
{
    const uint64_t now_ns = bus_now_ns(master.bus);
    forget_received();
    node_raise(node, EMERGENCY_DRIVE_TEMPERATURE, 1U, -5, now_ns);
    // The same error again: no second emergency.
    node_raise(node, EMERGENCY_DRIVE_TEMPERATURE, 1U, -5, now_ns);
    node_raise(node, EMERGENCY_UNDER_VOLTAGE, 0U, 0, now_ns);
    master_wait(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(2U, master_heard(&master, 0x091U));
    TEST_ASSERT_EQUAL_HEX8(0x0DU, master_last(&master, 0x091U)->data[2]); // Generic, voltage, temperature.
    TEST_ASSERT_EQUAL_HEX8(1U, master.heard[0].data[3]);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFBU, octets_u32(&master.heard[0].data[4]));
    node_clear(node, EMERGENCY_DRIVE_TEMPERATURE, 1U, now_ns);
    master_wait(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_UINT(2U, master_heard(&master, 0x091U)); // One error is left.
    node_clear(node, EMERGENCY_UNDER_VOLTAGE, 0U, now_ns);
    master_wait(&master, MASTER_MS);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_UINT64(2U, node_object(node, 0x1003U, 0U)->value);
    TEST_ASSERT_EQUAL_HEX64(0x3220U, node_object(node, 0x1003U, 1U)->value & 0xFFFFU);
    TEST_ASSERT_EQUAL_HEX64(0x4310U, node_object(node, 0x1003U, 2U)->value & 0xFFFFU);
}

static void sdo_responses_take_200_us_and_contain_present_values(void)
{
    uint8_t answer[8];
    const uint8_t request[8] = {0x40U, 0x64U, 0x60U, 0x00U};
    forget_received();
    TEST_ASSERT_TRUE(master_request(&master, ID, request, answer));
    TEST_ASSERT_EQUAL_STRING("s", calls);
    // Request and response take about 110 us each; the server takes 200 us between them.
    const uint64_t taken_ns = master.heard[0].time_ns - (bus_now_ns(master.bus) - (2U * MASTER_MS));
    TEST_ASSERT_UINT64_WITHIN(40000U, 430000U, taken_ns);
}

static void a_missing_data_sheet_is_refused(void)
{
    node_t* none = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND,
                          node_create(master.bus, "nowhere.eds", 3U, &application, &none, error));
    TEST_ASSERT_NULL(none);
}

/// Copy the data sheet; its objects whose index begins with the three digits `digits` get an index that
/// CiA 301 reserves: "180" are the communication parameters of the TPDOs, "140" those of the RPDOs.
static void copy_sheet_without(const char* digits)
{
    char line[512];
    FILE* const from = fopen(SHEET, "r");
    FILE* const to   = fopen(FEWER_PDOS, "w");
    while (fgets(line, (int)sizeof line, from) != NULL) {
        if ((line[0] == '[') && (strncmp(&line[1], digits, 3U) == 0)) {
            line[1] = '0';
        }
        (void)fputs(line, to);
    }
    TEST_ASSERT_EQUAL_INT(0, fclose(from) + fclose(to));
}

/// A device that only measures.
static void a_node_without_rpdos_sends_its_tpdos(void)
{
    copy_sheet_without("140");
    tearDown();
    sheet = FEWER_PDOS;
    setUp();
    sheet = SHEET;
    start();
    send_rpdo(0x0FU);
    master_wait(&master, 200U * MASTER_US);
    master_sync(&master, 300U * MASTER_US);
    TEST_ASSERT_EQUAL_STRING("s", calls); // The sample, and no written object.
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x191U));
    TEST_ASSERT_EQUAL_UINT(0U, master_heard(&master, 0x091U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(power_on_sends_one_boot_up_and_leads_to_pre_operational);
    RUN_TEST(the_heartbeat_reports_the_state_every_20_ms);
    RUN_TEST(nmt_commands_to_other_nodes_and_malformed_ones_are_ignored);
    RUN_TEST(a_reset_restores_the_defaults_and_boots_again);
    RUN_TEST(at_sync_a_node_applies_outputs_then_samples_then_sends);
    RUN_TEST(the_last_rpdo_before_sync_is_applied);
    RUN_TEST(no_pdo_is_exchanged_outside_of_operational);
    RUN_TEST(a_tpdo_of_type_20_is_sent_with_every_20th_sync);
    RUN_TEST(a_tpdo_of_type_0_is_sent_with_sync_after_a_change);
    RUN_TEST(event_driven_pdos_are_sent_at_events_and_after_their_timer);
    RUN_TEST(a_missed_rpdo_deadline_is_reported_once_and_cleared);
    RUN_TEST(a_deadline_of_zero_never_expires);
    RUN_TEST(a_lost_master_heartbeat_is_reported);
    RUN_TEST(a_pdo_that_is_too_short_is_reported_and_a_longer_one_is_applied);
    RUN_TEST(a_sync_without_its_counter_is_reported_once_and_applied);
    RUN_TEST(the_sync_start_value_delays_a_pdo);
    RUN_TEST(a_mapping_is_changed_only_in_the_order_of_the_standard);
    RUN_TEST(a_mapping_can_be_switched_from_csp_to_cst);
    RUN_TEST(a_node_without_power_is_silent_and_boots_when_powered);
    RUN_TEST(an_unplugged_node_is_silent_and_boots_when_plugged);
    RUN_TEST(emergencies_set_the_error_register_and_the_error_history);
    RUN_TEST(sdo_responses_take_200_us_and_contain_present_values);
    RUN_TEST(a_missing_data_sheet_is_refused);
    RUN_TEST(a_node_without_rpdos_sends_its_tpdos);
    return UNITY_END();
}
