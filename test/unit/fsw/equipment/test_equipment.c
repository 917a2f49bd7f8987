// SPDX-License-Identifier: Apache-2.0
// A drive on CAN and three stream devices of one subsystem; the test acts as the devices.
#include "fsw/equipment/equipment.h"
#include "test/support/scripted_bus.h"
#include "test/support/shm_device.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MS_NS 1000000U
#define RECORD_OCTETS 2U
#define COMMAND_OCTETS 1U
#define ALL 7U ///< Bits of all stream devices.
#define SAFE 7U
#define STATUSWORD_OPERATION_ENABLED 0x27U
#define STATUSWORD_MASK 0x6FU
#define SECURE_CYCLES 300U ///< More than a quick stop may take.
#define STREAMS 3U

#define STREAM(name, end)                                                                                    \
    "<Device name='" name "' type='stream'>"                                                                 \
    "<Field name='VALUE' direction='IN' type='INT16'/>"                                                      \
    "<Field name='ENABLE' direction='OUT' type='UINT8' safe='7'/>\n"                                         \
    "<Endnode type='SHM' name='" end "' silence='20ms' retry='1ms' retryLongest='2ms'/></Device>\n"
#define DRIVE(mode, extra)                                                                                   \
    "<Device name='MOTOR' type='joint-drive'><Setting object='0x6060:00' type='INT8' value='" mode           \
    "'/>\n<Endnode type='CAN' bus='robot' node='0x11'/></Device>\n" extra
#define EVENTS                                                                                               \
    "<Event name='DEVICE_LOST' id='1' severity='HIGH'><ParamRef name='NODE' type='UINT8'/></Event>"          \
    "<Event name='STREAM_LOST' id='2' severity='MEDIUM'><ParamRef name='D' type='UINT8'/>"                   \
    "<ParamRef name='C' type='UINT8'/></Event>"                                                              \
    "<Event name='DEVICE_RETURNED' id='3' severity='LOW'><ParamRef name='D' type='UINT8'/></Event>"
#define CONFIGURATION(name, id)                                                                              \
    "<Configuration name='" name "' id='" id "' priority='60' samplingTime='1ms'><Devices>\n"
#define END_CONFIGURATION "</Devices></Configuration>\n"
#define BEGIN "<Subsystem name='DOG' id='40' samplingTime='1ms'>\n<Events>" EVENTS "</Events>\n"
#define END "</Subsystem>\n"
// The drive is between the stream devices. The second configuration has one device of each kind.
#define BOTH                                                                                                 \
    BEGIN CONFIGURATION("ONE", "1") STREAM("A", "a") DRIVE("8", "") STREAM("B", "b")                         \
        END_CONFIGURATION CONFIGURATION("TWO", "2") DRIVE("8", "") STREAM("C", "c") END_CONFIGURATION END

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t bus;
static scripted_node_t* node;
static subsystem_t generic;
static equipment_t equipment;
static flow_shm_t to_flight[STREAMS];
static flow_shm_t to_device[STREAMS];
static bool do_devices_read;
static uint8_t commands[STREAMS]; ///< Last command of each stream device.
static bool has_command[STREAMS];

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if (kind == ENDNODE_CAN) {
        (void)strcpy(out_address->address, bus.address);
    } else {
        (void)snprintf(out_address->address, ENDNODE_ADDRESS_MAX, "/test-equipment-%d.%.20s", (int)getpid(),
                       name);
    }
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static bool fits(subsystem_misfit_t* const out_misfit)
{
    static const int modes[]                   = {8, 0};
    static const char* const in[]              = {"VALUE", NULL};
    static const char* const out[]             = {"ENABLE", NULL};
    static const drives_need_t drives          = {.axes            = 1U,
                                                  .permits_streams = true,
                                                  .reason_type     = "wrong type",
                                                  .count           = 1U,
                                                  .reason_count    = "wrong count",
                                                  .modes           = modes,
                                                  .reason_mode     = "wrong mode"};
    static const stream_devices_need_t streams = {.in             = in,
                                                  .out            = out,
                                                  .reason_in      = "wrong in",
                                                  .reason_out     = "wrong out",
                                                  .most           = 3U,
                                                  .reason_most    = "wrong most",
                                                  .permits_drives = true};
    return equipment_fit(&descriptor, &drives, &streams, out_misfit);
}

static void load(const char* const document)
{
    const status_t status =
        descriptor_parse_subsystem(&loader, "test", document, strlen(document), &descriptor);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
}

static void plug(const unsigned index)
{
    static const char* const in[]  = {"a.in", "b.in", "c.in"};
    static const char* const out[] = {"a.out", "b.out", "c.out"};
    TEST_ASSERT_EQUAL(STATUS_OK,
                      shm_device_open(&to_flight[index], (shm_device_end_t){in[index], RECORD_OCTETS},
                                      &to_device[index], (shm_device_end_t){out[index], COMMAND_OCTETS},
                                      &resolver, generic.now_ns));
}

static void unplug(const unsigned index)
{
    flow_shm_close(&to_flight[index]);
    flow_shm_close(&to_device[index]);
}

static const subsystem_callbacks_t callbacks = {
    .sense = equipment_sense, .emit = equipment_emit, .secure = equipment_secure};

static void begin(const char* const document)
{
    load(document);
    double_init(&generic, &descriptor, &callbacks, &equipment);
    generic.now_ns    = MS_NS;
    generic.period_ns = MS_NS;
    equipment_init(&equipment, &generic, &resolver, NULL);
}

void setUp(void)
{
    descriptor_loader_init(&loader);
    scripted_bus_open(&bus, "test-equipment");
    node = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    begin(BOTH);
    do_devices_read = true;
    (void)memset(has_command, 0, sizeof has_command);
    plug(0U);
    plug(1U);
    plug(2U);
}

void tearDown(void)
{
    equipment_release(&equipment);
    unplug(0U);
    unplug(1U);
    unplug(2U);
    scripted_bus_close(&bus);
}

typedef status_t (*action_t)(void* self);

/// The stream devices read their commands.
static void read_commands(void)
{
    for (unsigned i = 0U; i < STREAMS; i++) {
        (void)flow_shm_step(&to_device[i], generic.now_ns);
        while (flow_shm_read(&to_device[i], &commands[i]) == STATUS_OK) {
            has_command[i] = true;
        }
    }
}

/// True if a stream device has received a command since the last call; *out_command is the last one.
static bool last_command(const unsigned index, uint8_t* const out_command)
{
    const bool has_any = has_command[index];
    *out_command       = commands[index];
    has_command[index] = false;
    return has_any;
}

/// Run a cycle of 1 ms in which the stream devices in `senders` (one bit each) send a record.
static status_t cycle(const action_t action, const unsigned senders)
{
    for (unsigned i = 0U; i < STREAMS; i++) {
        const uint8_t record[RECORD_OCTETS] = {0U, 5U};
        if ((((senders >> i) & 1U) != 0U) && (flow_shm_step(&to_flight[i], generic.now_ns) == STATUS_OK)) {
            (void)!flow_shm_write(&to_flight[i], record);
        }
    }
    const status_t status = double_cycle(&generic, action, false);
    scripted_bus_run(&bus);
    if (do_devices_read) {
        read_commands();
    }
    generic.now_ns += generic.period_ns;
    if ((generic.now_ns % (20U * MS_NS)) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    return status;
}

/// Run cycles until the action ends, at most this number. Returns the status of the action.
static status_t run_cycles(const action_t action, const unsigned senders, const unsigned most)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (i < most) && (status == STATUS_BUSY); i++) {
        status = cycle(action, senders);
        status = (action != NULL) ? status : STATUS_BUSY;
    }
    return status;
}

static status_t configure(void* const self)
{
    return equipment_configure(self, generic.configuration);
}

static void bring_up(const uint16_t id)
{
    generic.configuration = descriptor_find_configuration(&descriptor, id);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_hardware_init, ALL, 1000U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configure, ALL, 1000U));
}

static void both_kinds_are_brought_up_and_counted_separately(void)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_TRUE_MESSAGE(fits(&misfit), misfit.reason);
    bring_up(1U);
    TEST_ASSERT_EQUAL_HEX8(0x11U, drives_device(&equipment.drives, 0U)->node);
    TEST_ASSERT_NULL(drives_device(&equipment.drives, 1U));
    TEST_ASSERT_EQUAL_STRING("A", stream_devices_at(&equipment.streams, 0U)->name);
    TEST_ASSERT_EQUAL_STRING("B", stream_devices_at(&equipment.streams, 1U)->name);
    TEST_ASSERT_EQUAL_STRING("C", stream_devices_at(&equipment.streams, 2U)->name);
    TEST_ASSERT_NULL(stream_devices_at(&equipment.streams, 3U));
    TEST_ASSERT_EQUAL_UINT(1U, node->boots);
    (void)run_cycles(NULL, ALL, 5U);
    TEST_ASSERT_TRUE(stream_device_value(stream_devices_at(&equipment.streams, 1U), 0U) == 5.0);
    TEST_ASSERT_TRUE(equipment_has_drives(&equipment));
    TEST_ASSERT_FALSE(equipment_is_engaged(&equipment));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_start_control, ALL, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_engage, ALL, 100U));
    TEST_ASSERT_TRUE(equipment_is_engaged(&equipment));
    TEST_ASSERT_EQUAL_HEX16(STATUSWORD_OPERATION_ENABLED, node->status[0] & STATUSWORD_MASK);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_disengage, ALL, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_stop_control, ALL, 100U));
    TEST_ASSERT_FALSE(equipment_is_engaged(&equipment));
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

/// The node is booted once, although a stream device keeps the commissioning waiting.
static void the_drive_waits_for_the_streams(void)
{
    unplug(1U);
    generic.configuration = descriptor_find_configuration(&descriptor, 1U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(equipment_hardware_init, 5U, 400U));
    TEST_ASSERT_EQUAL_UINT(0U, node->boots);
    plug(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_hardware_init, ALL, 1000U));
    TEST_ASSERT_EQUAL_UINT(1U, node->boots);
}

static void a_configuration_has_its_devices_of_both_kinds(void)
{
    uint8_t command = 0U;
    bring_up(2U);
    TEST_ASSERT_EQUAL_HEX8(0x11U, drives_device(&equipment.drives, 0U)->node);
    TEST_ASSERT_NULL(drives_device(&equipment.drives, 1U));
    TEST_ASSERT_EQUAL_UINT16(2U, equipment.streams.first_started);
    TEST_ASSERT_EQUAL_UINT16(1U, equipment.streams.started_count);
    (void)last_command(0U, &command);
    (void)run_cycles(NULL, ALL, 7U);
    TEST_ASSERT_FALSE(last_command(0U, &command)); // A is not in the configuration.
    TEST_ASSERT_TRUE(last_command(2U, &command));
}

/// While a device of the old configuration has no room for its safe command, the drive is not commissioned.
static void the_drive_is_configured_after_the_streams(void)
{
    bring_up(1U);
    generic.configuration = descriptor_find_configuration(&descriptor, 2U);
    do_devices_read       = false;
    (void)run_cycles(NULL, ALL, FLOW_DEPTH + 2U); // All queues are full.
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(configure, ALL, 100U));
    TEST_ASSERT_EQUAL_PTR(descriptor_find_configuration(&descriptor, 1U), equipment.drives.configuration);
    do_devices_read = true;
    read_commands();
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(configure, ALL, 1000U));
    TEST_ASSERT_EQUAL_PTR(generic.configuration, equipment.drives.configuration);
}

static void both_kinds_are_secured_at_once(void)
{
    uint8_t command = 0U;
    bring_up(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_start_control, ALL, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_engage, ALL, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_device_set(stream_devices_at(&equipment.streams, 0U), 0U, 1.0));
    (void)run_cycles(NULL, ALL, 1U);
    TEST_ASSERT_TRUE(last_command(0U, &command));
    TEST_ASSERT_EQUAL_UINT8(1U, command);
    const uint16_t control = node->control[0];
    TEST_ASSERT_EQUAL(STATUS_BUSY, cycle(equipment_secure, ALL)); // The drive brakes.
    (void)cycle(equipment_secure, ALL);
    TEST_ASSERT_TRUE((node->control[0]) != control);
    TEST_ASSERT_TRUE(last_command(0U, &command));
    TEST_ASSERT_EQUAL_UINT8(SAFE, command);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_secure, ALL, SECURE_CYCLES));
    TEST_ASSERT_TRUE((node->status[0] & STATUSWORD_MASK) != STATUSWORD_OPERATION_ENABLED);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_post, ALL, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_hardware_deinit, ALL, 10U));
    TEST_ASSERT_NULL(stream_devices_at(&equipment.streams, 0U));
}

/// A full stream does not delay the drive, and the subsystem waits for both.
static void a_full_stream_delays_the_end_of_securing_but_not_the_drive(void)
{
    uint8_t command = 0U;
    bring_up(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_start_control, ALL, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, run_cycles(equipment_engage, ALL, 100U));
    do_devices_read = false;
    (void)run_cycles(NULL, ALL, FLOW_DEPTH + 2U); // All queues are full.
    TEST_ASSERT_EQUAL(STATUS_BUSY, run_cycles(equipment_secure, ALL, SECURE_CYCLES));
    TEST_ASSERT_TRUE((node->status[0] & STATUSWORD_MASK) != STATUSWORD_OPERATION_ENABLED);
    do_devices_read = true;
    read_commands();
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_secure, ALL)); // The drives are not secured again.
    TEST_ASSERT_TRUE(last_command(0U, &command));
    TEST_ASSERT_EQUAL_UINT8(SAFE, command);
}

static void each_kind_has_its_own_events(void)
{
    bring_up(1U);
    unplug(1U);
    (void)run_cycles(NULL, 5U, 5U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 2U));
    TEST_ASSERT_EQUAL_UINT8(1U, double_last_event(&generic, 2U)->octets[0]);
    TEST_ASSERT_EQUAL_UINT8(STREAM_CAUSE_CLOSED, double_last_event(&generic, 2U)->octets[1]);
    plug(1U);
    (void)run_cycles(NULL, ALL, 10U);
    // With drives, the event of a stream device is STREAM_RETURNED, which this descriptor does not define.
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, 3U));
    node->is_plugged = false;
    (void)run_cycles(NULL, ALL, 10U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, 1U));
    TEST_ASSERT_EQUAL_UINT(1U, double_last_event(&generic, 1U)->size);
    TEST_ASSERT_EQUAL_HEX8(0x11U, double_last_event(&generic, 1U)->octets[0]);
}

static void streams_alone_need_no_bus(void)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    begin(BEGIN CONFIGURATION("ONE", "1") STREAM("A", "a") STREAM("B", "b") END_CONFIGURATION END);
    TEST_ASSERT_TRUE_MESSAGE(fits(&misfit), misfit.reason);
    TEST_ASSERT_FALSE(equipment_has_drives(&equipment));
    bring_up(1U);
    TEST_ASSERT_TRUE(equipment_is_engaged(&equipment));
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_start_control, ALL));
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_engage, ALL));
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_secure, ALL));
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_post, ALL));
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(equipment_hardware_deinit, ALL));
    TEST_ASSERT_EQUAL_UINT(0U, node->boots);
}

static void expect_refused(const char* const document, const uint32_t line, const char* const reason)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    load(document);
    TEST_ASSERT_FALSE(fits(&misfit));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, reason), misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
}

static void a_descriptor_that_does_not_fit_is_refused(void)
{
    expect_refused(BEGIN CONFIGURATION("ONE", "1") STREAM("A", "a") DRIVE("9", "") END_CONFIGURATION END, 6U,
                   "wrong mode");
    expect_refused(BEGIN CONFIGURATION("ONE", "1") STREAM("A", "a") STREAM("B", "a") DRIVE("8", "")
                       END_CONFIGURATION END,
                   7U, "no device above has");
    expect_refused(BEGIN CONFIGURATION("ONE", "1") DRIVE("8", "") END_CONFIGURATION CONFIGURATION("TWO", "2")
                       STREAM("A", "a") END_CONFIGURATION END,
                   7U, "wrong count");
    expect_refused(BEGIN CONFIGURATION("ONE", "1") DRIVE("8", "") STREAM("A", "a") STREAM("B", "b")
                       STREAM("C", "c") STREAM("D", "d") END_CONFIGURATION END,
                   12U, "wrong most");
    expect_refused(
        BEGIN CONFIGURATION(
            "ONE", "1") "<Device name='A' type='stream'><Field name='VALUE' "
                        "direction='IN' type='INT16'/><Field name='ENABLE' direction='OUT' type='UINT8'/>"
                        "<Setting object='0x6060:00' type='INT8' value='8'/><Endnode type='SHM' "
                        "name='a'/></Device>" END_CONFIGURATION END,
        4U, "expected no <Setting>");
    expect_refused(
        BEGIN CONFIGURATION("ONE", "1") "<Device name='A' type='joint-drive'>\n<Endnode type='SHM' "
                                        "name='a'/></Device>" END_CONFIGURATION END,
        5U, "expected CAN");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(both_kinds_are_brought_up_and_counted_separately);
    RUN_TEST(the_drive_waits_for_the_streams);
    RUN_TEST(a_configuration_has_its_devices_of_both_kinds);
    RUN_TEST(the_drive_is_configured_after_the_streams);
    RUN_TEST(both_kinds_are_secured_at_once);
    RUN_TEST(a_full_stream_delays_the_end_of_securing_but_not_the_drive);
    RUN_TEST(each_kind_has_its_own_events);
    RUN_TEST(streams_alone_need_no_bus);
    RUN_TEST(a_descriptor_that_does_not_fit_is_refused);
    return UNITY_END();
}
