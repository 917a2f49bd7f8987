// SPDX-License-Identifier: Apache-2.0
// Services that a descriptor lists: how they are added, stepped and restored, with ST[02] and ST[06] as
// examples.
#include "fsw/framework/subsystem/optional_services.h"

#include "base/crc.h"
#include "fsw/framework/subsystem/device_service.h"
#include "fsw/framework/subsystem/memory_service.h"
#include "test/support/assertion.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <string.h>

#define MEMORY_OPERATIONS 2U

static struct {
    memory_service_t memory;
    pus_memory_operation_t operations[MEMORY_OPERATIONS];
    device_service_t devices;
    pus_device_operation_t exchanges[1];
    uint32_t steps; // Cycle number of the last step.
    uint32_t key;   // Key of the restored record.
} storage;
static pus_persistence_t persistence;
static uint8_t data[64];
static octet_writer_t writer;

static void note_step(void* self, uint64_t now_ns, uint32_t cycle)
{
    TEST_ASSERT_EQUAL_PTR(&storage, self);
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns, now_ns);
    TEST_ASSERT_EQUAL_UINT32(storage.steps + 1U, cycle);
    storage.steps = cycle;
}

static status_t note_record(void* self, uint32_t key, const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&storage, self);
    TEST_ASSERT_TRUE((size == 1U) && (octets[0] == 9U));
    storage.key = key;
    return STATUS_OK;
}

static void add_services(void* context, subsystem_t* subsystem)
{
    static const pus_service_t stepped = {.type = 200U, .self = &storage, .step = note_step};
    static const pus_service_t still   = {.type = 201U, .self = &storage};
    TEST_ASSERT_EQUAL_PTR(&storage, context);
    TEST_ASSERT_TRUE(subsystem_persistence(subsystem) == fixture.subsystem.config.persistence);
    subsystem_add_service(subsystem, &still, NULL);
    subsystem_add_service(subsystem, &stepped, note_record);
    subsystem_device_service_add(subsystem, &storage.devices, storage.exchanges, 1U);
    subsystem_memory_service_add(subsystem, &storage.memory, storage.operations, MEMORY_OPERATIONS);
}

static status_t nothing_kept(void* context)
{
    (void)context;
    return STATUS_IO;
}

static pus_device_port_t device_port(void* self);

static void begin(const pus_persistence_t* kept)
{
    (void)memset(&storage, 0, sizeof storage);
    subsystem_config_t config = fixture.subsystem.config;
    static subsystem_callbacks_t callbacks;
    callbacks             = *config.callbacks;
    callbacks.device_port = device_port;
    config.callbacks      = &callbacks;
    config.optional       = (subsystem_services_t){&storage, add_services};
    config.persistence    = kept;
    fixture_begin(&config);
}

void setUp(void)
{
    persistence = (pus_persistence_t){.commit = nothing_kept};
    fixture_open(NULL);
    begin(NULL);
}

void tearDown(void)
{
    fixture_close();
}

static void optional_services_are_stepped_in_every_cycle_also_in_offline(void)
{
    fixture_run(3U);
    TEST_ASSERT_EQUAL_UINT32(3U, storage.steps);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL_UINT64(fixture.now_ns + 10000000U, subsystem_step(&fixture.subsystem, fixture.now_ns));
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    const uint32_t before = storage.steps;
    fixture_run(100U);
    // The services are stepped in PRE_OPERATIONAL, too.
    TEST_ASSERT_EQUAL_UINT32(before + 100U, storage.steps);
}

static void each_record_is_restored_by_its_service(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_restore(&fixture.subsystem, 200U, 5U, (const uint8_t*)"\11", 1U));
    TEST_ASSERT_EQUAL_UINT32(5U, storage.key);
    static const uint8_t record[] = {MEMORY_PARAMETERS, 0, 0, 0, 0, 0};
    TEST_ASSERT_EQUAL(STATUS_OK,
                      subsystem_restore(&fixture.subsystem, 20U, FIXTURE_APID << 21U, record, sizeof record));
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_restore(&fixture.subsystem, 3U, 5U, (const uint8_t*)"\0", 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      subsystem_restore(&fixture.subsystem, 201U, 5U, (const uint8_t*)"\11", 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      subsystem_restore(&fixture.subsystem, 202U, 5U, (const uint8_t*)"\11", 1U));
}

static void a_request_whose_effect_is_not_stored_fails(void)
{
    begin(&persistence);
    (void)fixture_command(17U, 1U, NULL, 0U);
    TEST_ASSERT_TRUE(fixture_has("1.8 #"));
}

static void a_subsystem_tests_its_connection_to_itself_and_the_supervisor_only(void)
{
    (void)fixture_command(17U, 3U, "\0\20", 2U);
    (void)fixture_command(17U, 3U, "\0\1", 2U);
    (void)fixture_command(17U, 3U, "\0\21", 2U);
    fixture_expect(
        "1.1 #0\n1.3 #0\n17.4 0010\n1.7 #0\n1.1 #1\n1.3 #1\n17.4 0001\n1.7 #1\n1.1 #2\n1.4 #2 0201 11\n");
}

// ---- ST[02] ----

static status_t check_device(void* context, const pus_device_action_t* action)
{
    TEST_ASSERT_EQUAL_PTR(&fixture, context);
    return (action->device == 1U) ? STATUS_OK : STATUS_NOT_FOUND;
}

static status_t begin_action(void* context, uint8_t slot, const pus_device_action_t* action,
                             pus_device_result_t* out_result)
{
    (void)out_result;
    TEST_ASSERT_TRUE((context == &fixture) && (slot == 0U) && (action->kind == PUS_DEVICE_SWITCH));
    return STATUS_OK;
}

static status_t poll_device(void* context, uint8_t slot, pus_device_result_t* out_result)
{
    (void)out_result;
    TEST_ASSERT_TRUE((context == &fixture) && (slot == 0U));
    return STATUS_OK;
}

static void abandon_device(void* context, uint8_t slot)
{
    TEST_ASSERT_TRUE((context == &fixture) && (slot == 0U));
}

static pus_device_port_t device_port(void* self)
{
    return (pus_device_port_t){self, check_device, begin_action, poll_device, abandon_device};
}

static void devices_are_reached_by_the_port_of_the_subsystem(void)
{
    (void)fixture_command(2U, 1U, "\2\0\1\0\2", 5U); // Addresses 1 and 2.
    fixture_run(1U);
    fixture_expect("1.1 #0\n1.4 #0 0201 2 in 2\n1.3 #0\n1.8 #0 0407 1\n");
}

static void add_without_a_port(void)
{
    static subsystem_callbacks_t callbacks;
    callbacks                          = *fixture.subsystem.config.callbacks;
    callbacks.device_port              = NULL;
    fixture.subsystem.config.callbacks = &callbacks;
    fixture.subsystem.service_count    = 0U;
    subsystem_device_service_add(&fixture.subsystem, &storage.devices, storage.exchanges, 1U);
}

/// The descriptor lists service 2, but the subsystem has no callback device_port. This is an error of the
/// program, which ends at its start before it accepts requests.
static void the_device_service_without_a_port_ends_the_program_at_its_start(void)
{
    TEST_ASSERT_TRUE(assertion_fails(add_without_a_port));
    TEST_ASSERT_EQUAL_UINT16(0U, fixture.subsystem.service_count);
}

// ---- ST[06] ----

static void start_request(uint8_t memory, uint32_t base_id, bool is_object)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, memory);
    if (is_object) {
        octet_write_u32(&writer, base_id);
    }
    octet_write_u8(&writer, 1U);
}

static void add_area(uint32_t offset, uint32_t length)
{
    octet_write_u32(&writer, offset);
    octet_write_u32(&writer, length);
}

static void add_data(uint32_t offset, const void* octets, uint16_t size)
{
    octet_write_u32(&writer, offset);
    octet_write_u16(&writer, size);
    octet_write_octets(&writer, octets, size);
    octet_write_u16(&writer, crc16_ccitt(octets, size));
}

static void request(uint8_t subtype)
{
    fixture_forget();
    (void)fixture_command(6U, subtype, data, writer.position);
    fixture_run(4U);
}

static void parameters_are_loaded_and_dumped_as_objects(void)
{
    const uint16_t count = 0x1234U;
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    start_request(MEMORY_PARAMETERS, fixture_count_id, true);
    add_data(0U, &count, sizeof count);
    request(1U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #"));
    TEST_ASSERT_EQUAL_HEX16(count, fixture.count);
    start_request(MEMORY_PARAMETERS, fixture_count_id, true);
    add_area(1U, 1U);
    request(3U);
    TEST_ASSERT_TRUE(fixture_has("6.4 01"));
    start_request(MEMORY_PARAMETERS, fixture_count_id, true);
    add_area(1U, 2U);
    request(3U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #"));
    start_request(MEMORY_PARAMETERS, 0U, true);
    add_area(0U, 1U);
    request(3U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #"));
}

static void addresses_may_span_several_parameters(void)
{
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    fixture.values.position[1] = 1.5;
    fixture.limit              = 2.5;
    start_request(MEMORY_PARAMETERS, 0U, false);
    add_area(23U, 2U); // The last octet of VALUES and the first of LIMIT.
    request(9U);
    TEST_ASSERT_TRUE(fixture_has("6.10 010001"));
    start_request(MEMORY_PARAMETERS, 0U, false);
    add_area(32U, 3U); // COUNT has only two octets.
    request(9U);
    TEST_ASSERT_TRUE(fixture_has("1.8 #"));
    TEST_ASSERT_FALSE(fixture_has("6.10"));
    start_request(MEMORY_PARAMETERS, 0U, false);
    add_data(0x8000U, "x", 1U); // This address belongs to no memory.
    request(2U);
    TEST_ASSERT_TRUE(fixture_has("1.8 #"));
}

/// Addresses 24 to 31 are LIMIT, 32 and 33 COUNT; padding begins at 34.
static void a_load_that_reaches_padding_changes_no_parameter(void)
{
    static const uint8_t octets[11] = {0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU,
                                       0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU};
    fixture_bring(STATE_PRE_OPERATIONAL, 0U);
    fixture.limit = 2.5;
    fixture.count = 7U;
    start_request(MEMORY_PARAMETERS, 0U, false);
    add_data(24U, octets, sizeof octets);
    request(2U);
    TEST_ASSERT_TRUE(fixture_has("1.8 #"));
    TEST_ASSERT_EQUAL_DOUBLE(2.5, fixture.limit);
    TEST_ASSERT_EQUAL_UINT16(7U, fixture.count);
    start_request(MEMORY_PARAMETERS, 0U, false);
    add_data(24U, octets, sizeof octets - 1U);
    request(2U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #"));
    TEST_ASSERT_EQUAL_UINT16(0xFFFFU, fixture.count);
}

static void memory_of_the_component_can_be_read_but_not_written(void)
{
    fixture_run(1U);
    start_request(MEMORY_COMPONENT, 0U, false);
    add_area((uint32_t)(sizeof fixture.subsystem - 1U), 1U);
    request(9U);
    TEST_ASSERT_TRUE(fixture_has("6.10 02"));
    for (uint32_t object = 0U; object < 3U; object++) {
        start_request(MEMORY_COMPONENT, object, true);
        add_area(0U, 8U);
        request(7U);
        TEST_ASSERT_EQUAL(object < 2U, fixture_has("6.8 02"));
    }
    start_request(MEMORY_COMPONENT, 0U, false);
    add_data(0U, "x", 1U);
    request(2U);
    TEST_ASSERT_TRUE(fixture_has("1.4 #"));
    start_request(MEMORY_COMPONENT, 0U, false);
    writer.position = 1U;
    request(13U);
    TEST_ASSERT_TRUE(fixture_has("1.7 #"));
    fixture_run((unsigned)(sizeof fixture.subsystem / PUS_MEMORY_SLICE) + 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, storage.memory.memory.counters.passes);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(optional_services_are_stepped_in_every_cycle_also_in_offline);
    RUN_TEST(each_record_is_restored_by_its_service);
    RUN_TEST(a_request_whose_effect_is_not_stored_fails);
    RUN_TEST(a_subsystem_tests_its_connection_to_itself_and_the_supervisor_only);
    RUN_TEST(devices_are_reached_by_the_port_of_the_subsystem);
    RUN_TEST(the_device_service_without_a_port_ends_the_program_at_its_start);
    RUN_TEST(parameters_are_loaded_and_dumped_as_objects);
    RUN_TEST(addresses_may_span_several_parameters);
    RUN_TEST(a_load_that_reaches_padding_changes_no_parameter);
    RUN_TEST(memory_of_the_component_can_be_read_but_not_written);
    return UNITY_END();
}
