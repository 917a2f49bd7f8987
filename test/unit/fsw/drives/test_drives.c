// SPDX-License-Identifier: Apache-2.0
// Drives on a scripted bus: commissioning, channels, activities, counters, mismatches with the descriptor.
#include "fsw/drives/drives_counters.h"
#include "fsw/drives/drives_fitting.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

static const char document[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Subsystem name=\"ARM\" id=\"20\" samplingTime=\"500us\">\n"
    "  <Parameters/>\n"
    "  <Events>\n"
    "    <Event name=\"DEVICE_LOST\" id=\"1\" severity=\"HIGH\"><ParamRef name=\"NODE\" "
    "type=\"UINT8\"/></Event>\n"
    "    <Event name=\"DRIVE_FAULT\" id=\"2\" severity=\"HIGH\">\n"
    "      <ParamRef name=\"NODE\" type=\"UINT8\"/><ParamRef name=\"CODE\" type=\"UINT16\"/></Event>\n"
    "    <Event name=\"BUS_WARNING\" id=\"4\" severity=\"LOW\"/>\n"
    "    <Event name=\"CHANNEL_SELECTED\" id=\"5\" severity=\"INFORMATIVE\"><ParamRef name=\"CHANNEL\" "
    "type=\"UINT8\"/></Event>\n"
    "    <Event name=\"DEVICE_REFUSED\" id=\"3\" severity=\"LOW\">\n"
    "      <ParamRef name=\"NODE\" type=\"UINT8\"/><ParamRef name=\"REASON\" type=\"UINT8\"/>\n"
    "      <ParamRef name=\"OBJECT\" type=\"UINT32\"/><ParamRef name=\"DETAIL\" type=\"UINT32\"/></Event>\n"
    "  </Events>\n"
    "  <Functions/>\n"
    "  <Configuration name=\"ONE\" id=\"1\" priority=\"80\" samplingTime=\"500us\">\n"
    "    <Devices>\n"
    "      <Device name=\"A\" type=\"joint-drive\">\n"
    "        <Setting object=\"0x6060:00\" type=\"INT8\" value=\"-3\"/>\n"
    "        <Endnode type=\"CAN\" bus=\"robot\" node=\"0x11\"/>\n"
    "      </Device>\n"
    "    </Devices>\n"
    "  </Configuration>\n"
    "  <Configuration name=\"TWO\" id=\"2\" priority=\"80\" samplingTime=\"500us\">\n"
    "    <Devices>\n"
    "      <Device name=\"B\" type=\"joint-drive\">\n"
    "        <Setting object=\"0x6065:00\" type=\"UINT32\" value=\"0x12345678\"/>\n"
    "        <Endnode type=\"CAN\" bus=\"robot\" node=\"0x12\"/>\n"
    "      </Device>\n"
    "      <Device name=\"A\" type=\"joint-drive\">\n"
    "        <Setting object=\"0x1400:05\" type=\"UINT16\" value=\"2\"/>\n"
    "        <Endnode type=\"CAN\" bus=\"robot\" node=\"0x11\"/>\n"
    "      </Device>\n"
    "    </Devices>\n"
    "  </Configuration>\n"
    "</Subsystem>\n";

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t bus;
static scripted_node_t* nodes[2];
static subsystem_t generic;
static drives_t drives;

static status_t software_init(void* const self)
{
    (void)self;
    return STATUS_OK;
}

static const subsystem_callbacks_t callbacks = {
    .software_init = software_init, .sense = drives_sense, .emit = drives_emit, .secure = drives_secure};
static unsigned abandoned;

static void abandon(void* const self)
{
    TEST_ASSERT_EQUAL_PTR(&drives, self);
    abandoned++;
}

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    if (strcmp(name, "robot") != 0) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

static bool has_channel_b;
static const flow_resolver_t resolver = {NULL, resolve};

static void load(void)
{
    static char text[sizeof document + 256U];
    size_t length = 0U; // With a channel B, each end node also has the attribute redundantBus.
    for (const char* at = document; *at != '\0'; at++) {
        text[length++] = *at;
        if (has_channel_b && (at >= &document[11]) && (at[0] == ' ') &&
            (strncmp(&at[-11], "bus=\"robot\"", 11U) == 0)) {
            length += (size_t)sprintf(&text[length], "redundantBus=\"robot-b\" ");
        }
    }
    const status_t status = descriptor_parse_subsystem(&loader, "test", text, length, &descriptor);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
}

void setUp(void)
{
    load();
    scripted_bus_open(&bus, "test-drives");
    nodes[0] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    nodes[1] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x12U);
    double_init(&generic, &descriptor, &callbacks, &drives);
    abandoned = 0U;
    drives_init(&drives, &generic, &resolver, abandon);
}

void tearDown(void)
{
    drives_release(&drives);
    scripted_bus_close(&bus);
}

typedef status_t (*action_t)(void* self);

static status_t cycle(const action_t action)
{
    const status_t status = double_cycle(&generic, action, false);
    scripted_bus_run(&bus);
    generic.now_ns += generic.period_ns;
    if ((generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
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

static void select(const uint16_t id)
{
    generic.configuration = descriptor_find_configuration(&descriptor, id);
}

static void devices_of_all_configurations_are_brought_up_once(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL_UINT8(2U, drives.device_count);
    TEST_ASSERT_NULL(drives_device(&drives, 0U));
    TEST_ASSERT_FALSE(drives_are_running(&drives));
    TEST_ASSERT_EQUAL_UINT(1U, nodes[0]->boots);
    TEST_ASSERT_EQUAL_UINT(1U, nodes[1]->boots);
}

/// If master and devices run on separate clocks, each side waits for the other for the time that the mission
/// sets.
static void a_deadline_of_the_mission_holds_at_both_ends(void)
{
    static const struct {
        uint64_t deadline_ns;
        uint32_t syncs; // Deadline in periods of 0.5 ms.
        uint32_t event_ms;
    } cases[] = {{0U, 3U, 2U},
                 {1000000U, 3U, 2U},
                 {2100000U, 5U, 3U},
                 {10000000U, 20U, 10U},
                 {600000000U, 1200U, 600U}};
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        generic.device_deadline_ns = cases[i].deadline_ns;
        select(2U);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
        TEST_ASSERT_EQUAL_UINT32(cases[i].syncs, drives.buses[0].network.config.lost_after_syncs);
        TEST_ASSERT_EQUAL_UINT32(cases[i].event_ms, scripted_object(nodes[0], 0x1400U, 5U)->value);
        select(1U);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    }
}

static void devices_are_identified_by_their_position_in_the_configuration(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_TRUE(drives_are_running(&drives));
    TEST_ASSERT_EQUAL_HEX8(0x12U, drives_device(&drives, 0U)->node);
    TEST_ASSERT_EQUAL_HEX8(0x11U, drives_device(&drives, 1U)->node);
    TEST_ASSERT_NULL(drives_device(&drives, 2U));
    TEST_ASSERT_EQUAL_HEX32(0x12345678U, scripted_object(nodes[1], 0x6065U, 0U)->value);
    select(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL_HEX8(0x11U, drives_device(&drives, 0U)->node);
    TEST_ASSERT_NULL(drives_device(&drives, 1U));
    TEST_ASSERT_EQUAL_HEX32(0xFDU, scripted_object(nodes[0], 0x6060U, 0U)->value); // The octet of -3.
    TEST_ASSERT_EQUAL_INT(-3,
                          drives_mode(&descriptor, &descriptor.devices[generic.configuration->first_device]));
    select(2U);
    TEST_ASSERT_EQUAL_INT(0,
                          drives_mode(&descriptor, &descriptor.devices[generic.configuration->first_device]));
    TEST_ASSERT_EQUAL(STATUS_OK, drives_post(&drives));
    TEST_ASSERT_NULL(drives_device(&drives, 0U));
    TEST_ASSERT_EQUAL_UINT32(0U, drives_missed(&drives, 0U));
}

static void an_unknown_class_and_no_device_at_all_are_refused(void)
{
    descriptor.storage.devices[1].type = "toaster";
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, cycle(drives_hardware_init));
    descriptor.device_count = 0U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, cycle(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, NETWORK_CHANNEL_B));
}

static void a_device_that_was_not_brought_up_cannot_be_configured(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(1U);
    descriptor.storage.endnodes[generic.configuration->first_device].node = 0x33U; // One end node per device.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_action(configure));
}

static void a_configuration_that_timed_out_starts_again(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    nodes[1]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    }
    nodes[1]->is_pdo_mute = false; // From here on the caller has given up.
    for (unsigned i = 0U; i < 100U; i++) {
        (void)cycle(NULL); // Some time passes.
    }
    const unsigned syncs = bus.syncs;
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_UINT(syncs, bus.syncs); // The network has stopped.
    TEST_ASSERT_EQUAL_HEX8(0x7FU, nodes[0]->nmt);
    const unsigned writes = nodes[1]->writes;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure)); // The operator tries again.
    TEST_ASSERT_EQUAL_UINT(writes + 1U, nodes[1]->writes);
}

static void a_drive_that_leaves_operation_raises_an_event_with_its_statusword(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_engage));
    generic.state                 = STATE_OPERATIONAL;
    nodes[0]->status[0]           = 0x0218U;
    const uint8_t expected_data[] = {0x11U, 0x02U, 0x18U};
    (void)cycle(NULL);
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 2U));
    TEST_ASSERT_EQUAL_UINT64(3U, generic.events[0].size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected_data, generic.events[0].octets, 3U);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, generic.state);
    TEST_ASSERT_EQUAL_HEX16(0x0002U, nodes[1]->control[0]); // The other drive brakes in the same cycle.
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_secure));
}

/// Expect only the event DEVICE_REFUSED: node, reason, object (index << 8 | subindex) and detail.
static void expect_refusal(const uint8_t expected_data[10])
{
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 3U));
    TEST_ASSERT_EQUAL_UINT64(10U, double_last_event(&generic, 3U)->size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected_data, double_last_event(&generic, 3U)->octets, 10U);
    generic.event_count = 0U;
}

static void the_reason_for_a_failed_commissioning_is_reported_as_an_event(void)
{
    scripted_object(nodes[1], 0x1000U, 0U)->value = 0x00010192U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_action(drives_hardware_init)); // Raises the event at once.
    expect_refusal((const uint8_t[]){0x12U, REFUSAL_VALUE, 0U, 0x10U, 0U, 0U, 0U, 0x01U, 0x01U, 0x92U});
    scripted_object(nodes[1], 0x1000U, 0U)->value = 0x00020192U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    scripted_object(nodes[1], 0x6065U, 0U)->abort_code = 0x08000022U;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, run_action(configure));
    expect_refusal((const uint8_t[]){0x12U, REFUSAL_ABORTED, 0U, 0x60U, 0x65U, 0U, 0x08U, 0U, 0U, 0x22U});
    scripted_object(nodes[1], 0x6065U, 0U)->abort_code = 0U;
    nodes[0]->is_pdo_mute                              = true;
    for (unsigned i = 0U; i < 400U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    }
    expect_refusal((const uint8_t[]){0x11U, REFUSAL_SILENT, 0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U});
    nodes[0]->is_pdo_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

static void an_event_that_the_descriptor_does_not_define_is_not_raised(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    scripted_bus_emergency(&bus, 0x11U, 0x4310U); // The descriptor does not define DRIVE_WARNING.
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

static void the_hardware_is_deinitialised_at_any_time(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(drives_hardware_deinit));
    for (unsigned i = 0U; i < 20U; i++) { // The first cycles of commissioning.
        (void)cycle(drives_hardware_init);
        if (i == 10U) {
            TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(drives_hardware_deinit));
            TEST_ASSERT_EQUAL(STATUS_OK, cycle(drives_hardware_deinit));
        }
    }
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    nodes[0]->is_plugged = false;
    nodes[1]->is_plugged = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
    nodes[0]->is_plugged = true;
    nodes[1]->is_plugged = true;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
}

static void channel_b_can_only_be_selected_if_the_bus_has_one(void)
{
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_select_channel(&drives, 2U));
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
    TEST_ASSERT_EQUAL(STATUS_OK, drives_select_channel(&drives, 0U));
    TEST_ASSERT_EQUAL_UINT8(0U, double_last_event(&generic, 5U)->octets[0]);
}

static void the_selected_channel_is_the_one_that_is_opened(void)
{
    has_channel_b = true;
    load();
    has_channel_b = false;
    TEST_ASSERT_EQUAL(STATUS_OK, drives_select_channel(&drives, 1U));
    TEST_ASSERT_EQUAL_UINT8(1U, double_last_event(&generic, 5U)->octets[0]);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_action(drives_hardware_init)); // The run has no bus of this name.
    TEST_ASSERT_EQUAL(STATUS_OK, drives_select_channel(&drives, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init)); // Channel A alone is sufficient.
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL_UINT64(0U, double_last_event(&generic, 4U)->size);     // Reports the missing channel B.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_select_channel(&drives, 1U)); // It cannot be selected.
}

static void limited_commands_of_all_axes_are_summed(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL_UINT32(0U, drives_limited(&drives));
    uint32_t next = 1U;
    uint32_t sum  = 0U;
    for (uint8_t device = 0U; device < NETWORK_DEVICES_MAX; device++) {
        for (uint8_t axis = 0U; axis < PROFILE_AXES_MAX; axis++) {
            // Powers of two: each counter occurs in the sum exactly once.
            drives.devices[device].device.axes[axis].limited = next;
            sum += (device < drives.device_count) ? next : 0U;
            next *= 2U;
        }
    }
    TEST_ASSERT_EQUAL_UINT(2U, drives.device_count);
    TEST_ASSERT_EQUAL_UINT32(sum, drives_limited(&drives));
}

/// Each change of activity abandons a command once; a higher activity begins when the axes have reached it.
static void each_change_of_activity_abandons_a_command_once(void)
{
    static const struct {
        action_t action;
        drives_activity_t before; // The activity while the axes move.
        drives_activity_t after;
    } steps[] = {{drives_start_control, DRIVES_RESTING, DRIVES_PREPARED},
                 {drives_engage, DRIVES_PREPARED, DRIVES_ENGAGED},
                 {drives_disengage, DRIVES_PREPARED, DRIVES_PREPARED},
                 {drives_engage, DRIVES_PREPARED, DRIVES_ENGAGED},
                 {drives_stop_control, DRIVES_RESTING, DRIVES_RESTING},
                 {drives_start_control, DRIVES_RESTING, DRIVES_PREPARED},
                 {drives_secure, DRIVES_RESTING, DRIVES_RESTING},
                 {drives_start_control, DRIVES_RESTING, DRIVES_PREPARED},
                 {drives_post, DRIVES_RESTING, DRIVES_RESTING}};
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL_UINT(0U, abandoned);
    for (size_t i = 0U; i < (sizeof steps / sizeof steps[0]); i++) {
        (void)cycle(steps[i].action);
        TEST_ASSERT_EQUAL(steps[i].before, drives.activity);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(steps[i].action));
        TEST_ASSERT_EQUAL(steps[i].after, drives.activity);
        TEST_ASSERT_EQUAL_UINT(i + 1U, abandoned);
    }
    drives_init(&drives, &generic, &resolver, NULL); // Without a callback no command is abandoned.
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
    TEST_ASSERT_EQUAL(DRIVES_PREPARED, drives.activity);
}

/// The descriptor determines which counters exist and in which order.
static void counters_are_published_where_the_descriptor_names_them(void)
{
    static const parameter_field_t fields[] = {
        {"FRAMES_SENT", VALUE_UINT32, 1U, 4U}, {"PDO_MISSED", VALUE_UINT32, 2U, 8U},
        {"CYCLES", VALUE_UINT32, 1U, 16U},     {"COMMAND_LIMITED", VALUE_UINT32, 1U, 20U},
        {"CHANNEL", VALUE_UINT8, 1U, 24U},     {"TEMPERATURE", VALUE_UINT32, 1U, 28U}};
    static const parameter_definition_t definition = {"COUNTERS", 1U, fields, 6U, 32U, 32U};
    static const parameter_definition_t none       = {"COUNTERS", 1U, fields, 0U, 32U, 32U};
    uint32_t storage[9];
    memset(storage, 0xA5, sizeof storage);
    const uint32_t untouched = storage[0];
    drives_counters_bind(&drives, &definition, storage);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    drives.devices[0].missed                       = 11U;
    drives.devices[1].missed                       = 12U; // Node 0x12 is the first of configuration 2.
    drives.devices[0].device.axes[0].limited       = 3U;
    drives.buses[0].network.flows[0].counters.sent = 1000U;
    drives.buses[0].network.flows[NETWORK_CHANNEL_B].counters.sent = 1U;
    drives_counters_publish(&drives, 4U);
    const uint32_t expected[9] = {untouched, 1001U,     12U,       11U,      generic.cycle,
                                  7U,        untouched, untouched, untouched};
    TEST_ASSERT_EQUAL_HEX32_ARRAY(expected, storage, 9U);
    drives_counters_bind(&drives, &none, storage);
    drives.buses[0].network.flows[0].counters.sent = 2000U;
    drives_counters_publish(&drives, 5U);
    TEST_ASSERT_EQUAL_HEX32_ARRAY(expected, storage, 9U);
}

/// At the end of the process drives_release closes the bus without a frame; a second call has no effect.
static void a_release_closes_the_bus_without_a_reset(void)
{
    static drives_t unused; // Released without having been used.
    drives_release(&unused);
    TEST_ASSERT_NULL(unused.buses[0].network.flow);
    drives_release(&drives); // There is no bus yet.
    TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    TEST_ASSERT_TRUE(flow_can_is_open(drives.buses[0].network.flow));
    const unsigned boots = nodes[0]->boots;
    for (unsigned i = 0U; i < 2U; i++) {
        drives_release(&drives);
        TEST_ASSERT_FALSE(flow_can_is_open(drives.buses[0].network.flow));
    }
    scripted_bus_run(&bus);
    TEST_ASSERT_EQUAL_UINT(boots, nodes[0]->boots); // An orderly end would send a reset.
    TEST_ASSERT_EQUAL(STATUS_OK, drives_hardware_deinit(&drives));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init)); // The hardware can be initialised again.
}

/// A configuration is aborted 20 ms after the last call of drives_configure.
static void a_configuration_is_aborted_after_20_ms_without_a_call(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    nodes[1]->is_pdo_mute = true;
    for (unsigned i = 0U; i < 50U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    }
    const unsigned writes = nodes[1]->writes;
    for (unsigned i = 0U; i < 39U; i++) {
        (void)cycle(NULL);
    }
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure)); // Exactly 20 ms are allowed.
    TEST_ASSERT_EQUAL_UINT(writes, nodes[1]->writes);
    for (unsigned i = 0U; i < 41U; i++) {
        TEST_ASSERT_NOT_NULL(drives_device(&drives, 0U));
        (void)cycle(NULL);
    }
    TEST_ASSERT_NULL(drives_device(&drives, 0U));
    nodes[1]->is_pdo_mute = false;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL_UINT(writes + 1U, nodes[1]->writes);
    for (unsigned i = 0U; i < 200U; i++) { // A complete configuration is not aborted.
        (void)cycle(NULL);
    }
    TEST_ASSERT_TRUE(drives_are_running(&drives));
    TEST_ASSERT_NOT_NULL(drives_device(&drives, 0U));
}

static void an_active_configuration_can_be_applied_again(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    const unsigned writes = nodes[1]->writes;
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(configure));
    TEST_ASSERT_FALSE(drives_are_running(&drives));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL_UINT(writes + 1U, nodes[1]->writes);
}

static void a_failed_configuration_leaves_no_device_and_no_process_data(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    scripted_object(nodes[1], 0x6065U, 0U)->abort_code = 0x08000022U;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, run_action(configure));
    TEST_ASSERT_NULL(drives_device(&drives, 0U));
    TEST_ASSERT_FALSE(drives_are_running(&drives));
    scripted_object(nodes[1], 0x6065U, 0U)->abort_code = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_deinit));
    TEST_ASSERT_NULL(drives_device(&drives, 0U));
    TEST_ASSERT_FALSE(drives_are_running(&drives));
}

/// The first call commands the goal; its result is valid from the next cycle on.
static void a_goal_is_commanded_again_after_each_stop(void)
{
    static const action_t stops[] = {drives_post, drives_secure};
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    for (size_t i = 0U; i < (sizeof stops / sizeof stops[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
        TEST_ASSERT_EQUAL_HEX16(0x0233U, nodes[0]->status[0]);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(stops[i]));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
        TEST_ASSERT_EQUAL_HEX16(0x0233U, nodes[0]->status[0]);
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_post));
    }
}

/// drives_start_control resets the fault of a drive; drives_engage does not.
static void a_fault_is_reset_by_starting_the_control_only(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    select(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    nodes[0]->status[0] = 0x0218U;
    for (unsigned i = 0U; i < 20U; i++) {
        (void)cycle(drives_engage);
    }
    TEST_ASSERT_EQUAL_HEX16(0x0218U, nodes[0]->status[0]);
    generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_start_control));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, nodes[0]->status[0]);
}

/// Subindex 5 of 0x1400 to 0x15FF is the event timer of an RPDO; other settings are written as they are.
static void the_deadline_changes_event_timers_of_rpdos_only(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t written;
    } cases[] = {
        {0x13FFU, 5U, 2U}, {0x1400U, 5U, 10U}, {0x15FFU, 5U, 10U}, {0x1600U, 5U, 2U}, {0x1400U, 4U, 2U}};
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(drives_hardware_init));
    generic.device_deadline_ns = 10000000U;
    select(2U);
    const descriptor_device_t* const device = &descriptor.devices[generic.configuration->first_device + 1U];
    descriptor_setting_t* const setting     = &descriptor.storage.settings[device->first_setting];
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        setting->index    = cases[i].index;
        setting->subindex = cases[i].subindex;
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
        TEST_ASSERT_EQUAL_UINT32(cases[i].written,
                                 scripted_object(nodes[0], cases[i].index, cases[i].subindex)->value);
    }
}

int main(void)
{
    descriptor_loader_init(&loader);
    UNITY_BEGIN();
    RUN_TEST(devices_of_all_configurations_are_brought_up_once);
    RUN_TEST(a_deadline_of_the_mission_holds_at_both_ends);
    RUN_TEST(devices_are_identified_by_their_position_in_the_configuration);
    RUN_TEST(limited_commands_of_all_axes_are_summed);
    RUN_TEST(an_unknown_class_and_no_device_at_all_are_refused);
    RUN_TEST(a_device_that_was_not_brought_up_cannot_be_configured);
    RUN_TEST(a_configuration_that_timed_out_starts_again);
    RUN_TEST(a_drive_that_leaves_operation_raises_an_event_with_its_statusword);
    RUN_TEST(the_reason_for_a_failed_commissioning_is_reported_as_an_event);
    RUN_TEST(an_event_that_the_descriptor_does_not_define_is_not_raised);
    RUN_TEST(channel_b_can_only_be_selected_if_the_bus_has_one);
    RUN_TEST(the_selected_channel_is_the_one_that_is_opened);
    RUN_TEST(the_hardware_is_deinitialised_at_any_time);
    RUN_TEST(each_change_of_activity_abandons_a_command_once);
    RUN_TEST(counters_are_published_where_the_descriptor_names_them);
    RUN_TEST(a_release_closes_the_bus_without_a_reset);
    RUN_TEST(a_configuration_is_aborted_after_20_ms_without_a_call);
    RUN_TEST(an_active_configuration_can_be_applied_again);
    RUN_TEST(a_failed_configuration_leaves_no_device_and_no_process_data);
    RUN_TEST(a_goal_is_commanded_again_after_each_stop);
    RUN_TEST(a_fault_is_reset_by_starting_the_control_only);
    RUN_TEST(the_deadline_changes_event_timers_of_rpdos_only);
    return UNITY_END();
}
