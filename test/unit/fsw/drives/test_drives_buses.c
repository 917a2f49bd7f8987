// SPDX-License-Identifier: Apache-2.0
// Devices of one subsystem on one to four buses: they are commissioned, operated and secured together.
#include "fsw/drives/drives_access.h"
#include "fsw/drives/drives_fitting.h"
#include "fsw/drives/drives_supply.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

#define FIRST_NODE 0x11U

typedef status_t (*action_t)(void* self);

static char document[16384];
static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t buses[DRIVES_BUSES_MAX];
static unsigned bus_count;
static scripted_node_t* nodes[DRIVES_DEVICES_MAX];
static unsigned node_count;
static unsigned absent_bus; // Index of a bus that cannot be opened, plus one.
static subsystem_t generic;
static drives_t drives;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    const unsigned bus = (unsigned)(name[0] - 'a');
    if ((bus >= bus_count) || ((bus + 1U) == absent_bus)) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, buses[bus].address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static bool fits(void)
{
    static const int modes[]               = {10, 0};
    static const drives_need_t drives_need = {1U, false, "type", 0U, "count", modes, "mode", false};
    subsystem_misfit_t misfit              = {0U, "", 0U};
    return drives_fit(&descriptor, &drives_need, &misfit);
}

/// Load a descriptor of `count` drives on `on` buses: device i is on bus i mod `on`. The channels B are the
/// buses from number `on`.
static void make(const unsigned on, const unsigned count, const bool has_channel_b)
{
    size_t length = 0U;
    length +=
        (size_t)sprintf(&document[length],
                        "<Subsystem name='ARM' id='20'><Parameters/><Events>"
                        "<Event name='DEVICE_LOST' id='1' severity='LOW'>"
                        "<ParamRef name='NODE' type='UINT8'/></Event>"
                        "<Event name='BUS_WARNING' id='2' severity='LOW'><ParamRef name='NODE' type='UINT8'/>"
                        "<ParamRef name='CODE' type='UINT16'/></Event></Events><Functions/>"
                        "<Configuration name='C' id='1' priority='80' samplingTime='500us'><Devices>");
    for (unsigned i = 0U; i < count; i++) {
        const unsigned bus = i % on;
        char channel_b[24] = "";
        if (has_channel_b) {
            (void)sprintf(channel_b, "redundantBus='%c'", (char)('a' + (char)(on + bus)));
        }
        length += (size_t)sprintf(&document[length],
                                  "<Device name='D%u' type='joint-drive'>"
                                  "<Setting object='0x6060:00' type='INT8' value='10'/>"
                                  "<Supply unit='%u' on='1' off='2'/>"
                                  "<Endnode type='CAN' bus='%c' node='%u' %s/></Device>",
                                  i, 100U + bus, (char)('a' + (char)bus), FIRST_NODE + i, channel_b);
    }
    (void)sprintf(&document[length],
                  "</Devices></Configuration>"
                  "<Configuration name='LESS' id='2' priority='80' samplingTime='500us'><Devices>"
                  "<Device name='D0' type='joint-drive'><Setting object='0x6060:00' type='INT8' value='10'/>"
                  "<Endnode type='CAN' bus='a' node='%u' %s/></Device></Devices></Configuration></Subsystem>",
                  FIRST_NODE, has_channel_b ? (on == 1U ? "redundantBus='b'" : "redundantBus='c'") : "");
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "test", document, strlen(document), &descriptor),
        descriptor_error(&loader));
    TEST_ASSERT_TRUE(fits());
    bus_count  = on;
    node_count = count;
    for (unsigned i = 0U; i < on; i++) {
        char name[32];
        (void)snprintf(name, sizeof name, "test-buses-%u", i);
        scripted_bus_open(&buses[i], name);
    }
    for (unsigned i = 0U; i < count; i++) {
        nodes[i] = scripted_bus_add(&buses[i % on], SCRIPTED_DRIVE, (uint8_t)(FIRST_NODE + i));
    }
    static const subsystem_callbacks_t callbacks = {
        .sense = drives_sense, .emit = drives_emit, .secure = drives_secure};
    double_init(&generic, &descriptor, &callbacks, &drives);
    generic.configuration = &descriptor.configurations[0];
    drives_init(&drives, &generic, &resolver, NULL);
}

void setUp(void)
{
    bus_count  = 0U;
    absent_bus = 0U;
}

void tearDown(void)
{
    drives_release(&drives);
    for (unsigned i = 0U; i < bus_count; i++) {
        scripted_bus_close(&buses[i]);
    }
}

static status_t cycle(const action_t action)
{
    const status_t status = double_cycle(&generic, action, false);
    generic.now_ns += generic.period_ns;
    for (unsigned i = 0U; i < bus_count; i++) {
        scripted_bus_run(&buses[i]);
        if ((generic.now_ns % 20000000U) == 0U) {
            scripted_bus_heartbeat(&buses[i]);
        }
    }
    return status;
}

static status_t run_action(const action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 1000U); i++) {
        status = cycle(action);
    }
    return status;
}

static status_t configure(void* const self)
{
    return drives_configure(self, generic.configuration);
}

static void engage(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_engage));
}

static void expect_status(const unsigned node, const uint16_t status)
{
    TEST_ASSERT_EQUAL_HEX16(status, nodes[node]->status[0] & 0x006FU);
}

/// Commission `count` drives on `on` buses, exchange process data with each, and secure them.
static void operate(const unsigned on, const unsigned count)
{
    make(on, count, false);
    engage();
    for (unsigned i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL_HEX8(FIRST_NODE + i, drives_device(&drives, (uint16_t)i)->node);
        nodes[i]->position[0] = 100 + (int32_t)i;
        canopen_cia402_axis_command_position(&drives_device(&drives, (uint16_t)i)->axes[0], 1e-6 * (double)i,
                                             0.0);
    }
    (void)cycle(NULL);
    (void)cycle(NULL);
    for (unsigned i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL_INT32(100 + (int32_t)i, drives_device(&drives, (uint16_t)i)->axes[0].position);
        TEST_ASSERT_EQUAL_INT32((int32_t)i, nodes[i]->target_position);
        TEST_ASSERT_EQUAL_UINT32(0U, drives_missed(&drives, (uint16_t)i));
        expect_status(i, 0x27U);
    }
    for (unsigned i = 1U; i < on; i++) { // The first SYNC of all buses comes in the same cycle.
        TEST_ASSERT_EQUAL_UINT(buses[0].syncs, buses[i].syncs);
    }
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_secure));
    for (unsigned i = 0U; i < count; i++) {
        expect_status(i, 0x40U);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
}

static void six_drives_operate_on_one_bus(void)
{
    operate(1U, 6U);
}

static void seven_drives_operate_on_one_bus(void)
{
    operate(1U, 7U);
}

static void seven_drives_operate_on_two_buses(void)
{
    operate(2U, 7U);
}

static void drives_operate_on_full_buses(void)
{
    operate(2U, 2U * NETWORK_DEVICES_MAX);
}

static void all_devices_operate_on_all_buses(void)
{
    operate(DRIVES_BUSES_MAX, DRIVES_DEVICES_MAX);
}

/// The settings of the mode belong to another configuration, so the device must not move.
static void a_device_of_another_configuration_is_not_enabled(void)
{
    make(2U, 3U, false);
    engage();
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_disengage));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_stop_control));
    for (unsigned configuration = 2U; configuration > 0U; configuration--) {
        generic.configuration = &descriptor.configurations[configuration - 1U];
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_engage));
        expect_status(0U, 0x27U);
        expect_status(1U, (configuration == 2U) ? 0x40U : 0x27U);
        expect_status(2U, (configuration == 2U) ? 0x40U : 0x27U);
    }
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

/// One drive is on a bus, and two are on the other. With BEFORE_COMMANDS no bus waits for its commands.
static void sync_precedes_the_commands_of_all_buses_if_the_descriptor_says_so(void)
{
    make(2U, 3U, false);
    engage();
    for (unsigned is_first = 0U; is_first <= 1U; is_first++) {
        descriptor.is_sync_first = (is_first != 0U);
        (void)cycle(NULL);
        for (unsigned i = 0U; i < 2U; i++) {
            const unsigned commands = (i == 0U) ? 2U : 1U;
            unsigned at             = 0U;
            while ((at < buses[i].seen_count) && (buses[i].seen[at].id != 0x080U)) {
                at++;
            }
            TEST_ASSERT_EQUAL_UINT(1U, scripted_bus_count(&buses[i], 0x080U));
            TEST_ASSERT_TRUE(buses[i].seen_count > commands);
            TEST_ASSERT_TRUE((is_first != 0U) ? (at == 0U) : (at >= commands));
        }
    }
}

static void sync_begins_on_all_buses_in_the_same_cycle(void)
{
    make(2U, 4U, false);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 100U); i++) {
        status = cycle(configure);
        TEST_ASSERT_EQUAL_UINT(buses[0].syncs, buses[1].syncs);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_TRUE(buses[1].syncs > 0U);
}

/// All buses wait for a bus that is commissioned later; the other buses are not commissioned again.
static void the_slowest_bus_determines_the_end_of_a_step(void)
{
    make(2U, 2U, false);
    nodes[1]->is_boot_mute = true;
    for (unsigned i = 0U; i < 200U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_hardware_init));
    }
    nodes[1]->is_boot_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL_UINT(1U, nodes[0]->boots);
    nodes[0]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    }
    TEST_ASSERT_FALSE(drives_are_running(&drives));
    const unsigned writes = nodes[1]->writes;
    nodes[0]->is_pdo_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_TRUE(drives_are_running(&drives));
    TEST_ASSERT_EQUAL_UINT(writes, nodes[1]->writes);
    // Both buses are commissioned from the beginning.
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL_UINT(2U, nodes[0]->boots);
}

/// All buses are secured without waiting for each other; a second call acts on all of them again.
static void no_bus_waits_for_another_to_be_secured(void)
{
    for (unsigned stuck = 0U; stuck < 2U; stuck++) {
        const unsigned other = 1U - stuck;
        make(2U, 2U, false);
        engage();
        nodes[stuck]->is_stuck = true;
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_secure));
        TEST_ASSERT_EQUAL_HEX16(0x0002U, nodes[0]->control[0]);
        TEST_ASSERT_EQUAL_HEX16(0x0002U, nodes[1]->control[0]);
        for (unsigned i = 0U; i < 450U; i++) {
            TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_secure));
        }
        expect_status(other, 0x40U);
        nodes[stuck]->is_stuck = false;
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_secure));
        expect_status(stuck, 0x40U);
        // The aborted call has no effect on the next one.
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_engage));
        nodes[stuck]->is_stuck = true;
        for (unsigned i = 0U; i < 450U; i++) {
            TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_secure));
        }
        nodes[stuck]->is_stuck = false;
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_engage));
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_secure));
        TEST_ASSERT_EQUAL_HEX16(0x0002U, nodes[other]->control[0]);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_secure));
        tearDown();
    }
    bus_count = 0U;
}

static void a_bus_that_cannot_be_opened_leaves_none_open(void)
{
    make(2U, 2U, false);
    absent_bus = 2U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, cycle(drives_hardware_init));
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
    absent_bus = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
}

/// The failure of one bus ends the step on all buses; the next call starts from the beginning.
static void a_failure_on_one_bus_ends_the_step(void)
{
    make(2U, 2U, false);
    scripted_object(nodes[1], 0x1018U, 2U)->value ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(drives_hardware_init));
    scripted_object(nodes[1], 0x1018U, 2U)->value ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
}

/// The failure is returned even if another bus is still busy, whichever has the lower number.
static void a_failure_is_returned_while_another_bus_is_busy(void)
{
    for (unsigned failing = 0U; failing < 2U; failing++) {
        make(2U, 2U, false);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
        nodes[1U - failing]->is_sdo_mute                         = true;
        scripted_object(nodes[failing], 0x6060U, 0U)->abort_code = 0x06090030U;
        const uint64_t begin_ns                                  = generic.now_ns;
        TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, run_action(configure));
        TEST_ASSERT_TRUE((generic.now_ns - begin_ns) < 20000000U); // The other bus has not timed out yet.
        tearDown();
        setUp();
    }
}

static void the_code_of_an_event_names_its_bus(void)
{
    make(3U, 3U, false);
    engage();
    for (unsigned i = 0U; i < 3U; i++) {
        scripted_bus_error(&buses[i], OSAL_CAN_ERROR_CONTROLLER, 0x04U);
        (void)cycle(NULL);
        (void)cycle(NULL);
        const double_event_t* const event = double_last_event(&generic, 2U);
        const uint8_t expected[3] = {0U, (uint8_t)(i * (DRIVES_BUS_CODE >> 8)), NETWORK_BUS_ERROR_WARNING};
        TEST_ASSERT_NOT_NULL(event);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, event->octets, 3U);
    }
    TEST_ASSERT_EQUAL_UINT(3U, double_events(&generic, 2U));
    nodes[2]->is_plugged = false;
    for (unsigned i = 0U; i < 8U; i++) {
        (void)cycle(NULL);
    }
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 1U));
    TEST_ASSERT_EQUAL_HEX8(FIRST_NODE + 2U, double_last_event(&generic, 1U)->octets[0]);
}

static void a_channel_is_selected_on_every_bus_or_on_none(void)
{
    make(2U, 2U, false);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, NETWORK_CHANNEL_B));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, NETWORK_CHANNEL_B));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, drives_select_channel(&drives, NETWORK_CHANNEL_A));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_A, drives.buses[0].network.channel);
}

static void each_bus_has_its_own_channel_b(void)
{
    make(2U, 2U, true);
    scripted_bus_open(&buses[2], "test-buses-2");
    scripted_bus_open(&buses[3], "test-buses-3");
    bus_count = 3U; // The last bus does not exist.
    engage();
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_select_channel(&drives, NETWORK_CHANNEL_B));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_A, drives.buses[0].network.channel);
    bus_count = 4U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
    TEST_ASSERT_EQUAL(STATUS_OK, drives_select_channel(&drives, NETWORK_CHANNEL_B));
    (void)scripted_bus_add(&buses[2], SCRIPTED_DRIVE, FIRST_NODE);
    (void)scripted_bus_add(&buses[3], SCRIPTED_DRIVE, FIRST_NODE + 1U);
    engage();
    TEST_ASSERT_TRUE(buses[2].syncs == buses[3].syncs);
    TEST_ASSERT_TRUE(buses[2].syncs > 0U);
}

/// The process before may have left the devices on channel B. They return to the channel on which they last
/// heard the master, so they hear it on this channel before they are reset.
static void devices_of_a_restarted_subsystem_hear_the_master_before_their_reset(void)
{
    for (unsigned i = 0U; i < 4U; i++) {
        const bool is_restarted  = (i & 1U) != 0U;
        const bool has_channel_b = (i & 2U) != 0U;
        make(1U, 1U, has_channel_b);
        if (has_channel_b) {
            scripted_bus_open(&buses[1], "test-buses-b");
            bus_count = 2U;
        }
        generic.is_restarted = is_restarted;
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_hardware_init));
        TEST_ASSERT_EQUAL(is_restarted && has_channel_b, drives.buses[0].network.is_channel_new);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
        TEST_ASSERT_FALSE(drives.buses[0].network.is_channel_new);
        tearDown();
        setUp();
    }
}

static void pulses_and_accesses_reach_the_bus_of_the_device(void)
{
    make(2U, 2U, false);
    engage();
    const pus_device_port_t port = drives_access_port(&drives);
    pus_device_result_t result   = {.detail = 0U};
    const unsigned counts[2] = {scripted_bus_count(&buses[0], 0x265U), scripted_bus_count(&buses[1], 0x265U)};
    const pus_device_action_t pulse = {.kind = PUS_DEVICE_SWITCH, .device = (101U << 8) | 2U};
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &pulse));
    TEST_ASSERT_EQUAL(STATUS_OK, port.begin(port.context, 0U, &pulse, &result));
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_UINT(counts[0], scripted_bus_count(&buses[0], 0x265U));
    TEST_ASSERT_EQUAL_UINT(counts[1] + 1U, scripted_bus_count(&buses[1], 0x265U));
    const pus_device_action_t read                = {.kind    = PUS_DEVICE_DUMP_REGISTER,
                                                     .address = ((FIRST_NODE + 1U) << 24) | (0x6076U << 8)};
    scripted_object(nodes[1], 0x6076U, 0U)->value = 12345U;
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &read));
    TEST_ASSERT_EQUAL(STATUS_OK, port.begin(port.context, 1U, &read, &result));
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 10U); i++) {
        (void)cycle(NULL);
        status = port.poll(port.context, 1U, &result);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    const uint8_t expected[4] = {0x00U, 0x00U, 0x30U, 0x39U};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, result.data, 4U);
}

/// A device without such settings has no mapping of its own, also when the devices are commissioned again.
static void only_devices_with_settings_of_a_mapping_have_one_of_their_own(void)
{
    make(2U, 4U, false);
    descriptor.storage.settings[descriptor.storage.devices[2].first_setting].index = 0x1A01U;
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
        TEST_ASSERT_EQUAL_UINT8(1U, drives.mapping_count);
        TEST_ASSERT_NULL(drives.devices[0].device.mapping);
        TEST_ASSERT_EQUAL_PTR(&drives.mappings[0], drives.devices[2].device.mapping);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
    }
}

static void more_settings_than_a_device_has_room_for_are_refused(void)
{
    make(1U, 1U, false);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    descriptor.storage.devices[0].setting_count = NETWORK_SETTINGS_MAX + 2U;
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, run_action(configure));
}

/// A device on a stream is none of the drives: another library operates it.
static void a_device_without_a_bus_is_not_brought_up(void)
{
    make(1U, 2U, false);
    descriptor.storage.devices[1].type = DESCRIPTOR_STREAM_TYPE;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL_UINT8(1U, drives.device_count);
}

/// The number of a drive does not count devices on streams before it.
static void drives_are_numbered_without_devices_on_streams(void)
{
    make(1U, 2U, false);
    descriptor.storage.devices[0].type = DESCRIPTOR_STREAM_TYPE;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    drives_note_devices(&drives, &descriptor.configurations[0]);
    TEST_ASSERT_NULL(drives_device(&drives, 0U)); // The configuration is not applied yet.
    drives.configuration = &descriptor.configurations[0];
    TEST_ASSERT_NOT_NULL(drives_device(&drives, 0U));
    TEST_ASSERT_EQUAL_UINT(FIRST_NODE + 1U, drives_device(&drives, 0U)->node);
    TEST_ASSERT_NULL(drives_device(&drives, 1U));
}

/// The time since the last call counts, even if no cycle in between could abort the configuration.
static void a_configuration_starts_again_after_a_gap_without_cycles(void)
{
    make(1U, 1U, false);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    nodes[0]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    }
    TEST_ASSERT_TRUE(drives.is_written);
    generic.now_ns = drives.called_ns + 20000000U;
    TEST_ASSERT_EQUAL(STATUS_BUSY, configure(&drives));
    TEST_ASSERT_TRUE(drives.is_written);
    generic.now_ns += 20000001U;
    TEST_ASSERT_EQUAL(STATUS_BUSY, configure(&drives));
    TEST_ASSERT_FALSE(drives.is_written);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(six_drives_operate_on_one_bus);
    RUN_TEST(seven_drives_operate_on_one_bus);
    RUN_TEST(seven_drives_operate_on_two_buses);
    RUN_TEST(drives_operate_on_full_buses);
    RUN_TEST(all_devices_operate_on_all_buses);
    RUN_TEST(only_devices_with_settings_of_a_mapping_have_one_of_their_own);
    RUN_TEST(a_device_of_another_configuration_is_not_enabled);
    RUN_TEST(sync_begins_on_all_buses_in_the_same_cycle);
    RUN_TEST(sync_precedes_the_commands_of_all_buses_if_the_descriptor_says_so);
    RUN_TEST(the_slowest_bus_determines_the_end_of_a_step);
    RUN_TEST(no_bus_waits_for_another_to_be_secured);
    RUN_TEST(a_bus_that_cannot_be_opened_leaves_none_open);
    RUN_TEST(a_failure_on_one_bus_ends_the_step);
    RUN_TEST(a_failure_is_returned_while_another_bus_is_busy);
    RUN_TEST(the_code_of_an_event_names_its_bus);
    RUN_TEST(a_channel_is_selected_on_every_bus_or_on_none);
    RUN_TEST(each_bus_has_its_own_channel_b);
    RUN_TEST(devices_of_a_restarted_subsystem_hear_the_master_before_their_reset);
    RUN_TEST(pulses_and_accesses_reach_the_bus_of_the_device);
    RUN_TEST(a_device_without_a_bus_is_not_brought_up);
    RUN_TEST(drives_are_numbered_without_devices_on_streams);
    RUN_TEST(more_settings_than_a_device_has_room_for_are_refused);
    RUN_TEST(a_configuration_starts_again_after_a_gap_without_cycles);
    return UNITY_END();
}
