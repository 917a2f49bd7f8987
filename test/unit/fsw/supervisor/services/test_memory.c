// SPDX-License-Identifier: Apache-2.0
// ST[06] of the supervisor: its buffer for files, and access to files without a store.
#include "fsw/framework/subsystem/memory_service.h"
#include "fsw/supervisor/services/memory.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

static struct {
    memory_service_t memory;
    pus_memory_operation_t operations[1];
} services;

static void add_services(void* const context, subsystem_t* const subsystem)
{
    (void)context;
    subsystem_memory_service_add(subsystem, &services.memory, services.operations, 1U);
}

static void give_service(supervisor_config_t* const config)
{
    config->optional = (subsystem_services_t){&services, add_services};
}

void setUp(void)
{
    fixture_configure = give_service;
    fixture_open_up();
    fixture.ack = 0U;
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

static void request(const uint8_t subtype, const char* const data, const size_t size)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MEMORY, subtype, data, size);
    fixture_run(2U);
}
#define REQUEST(subtype, octets) request((subtype), (octets), sizeof(octets) - 1U)

/// Memory 3 is the buffer. Each area has an address (u32); for loading, length (u16), octets and checksum
/// follow, for dumping the length (u32).
static void the_buffer_is_loaded_and_dumped(void)
{
    REQUEST(2U, "\3\1\0\1\377\376\0\2ab\151\360"); // The last two octets.
    REQUEST(2U, "\3\1\0\2\0\0\0\1a\0\0");          // After the end of the buffer.
    TEST_ASSERT_EQUAL_MEMORY(
        "ab", &fixture.supervisor.spacecraft.memory.buffer[SPACECRAFT_MEMORY_BUFFER_OCTETS - 2U], 2U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 "));
    fixture_forget();
    REQUEST(5U, "\3\1\0\1\377\376\0\0\0\2");
    TEST_ASSERT_TRUE(fixture_has("G 6.6 0300010001FFFE0002616269F0"));
}

static void without_a_store_requests_with_files_are_refused(void)
{
    REQUEST(20U, "\3\0\1/\0\1a\1\0\0\0\0\0\0\0\1"); // Dump one octet of the buffer to the file /a.
    TEST_ASSERT_TRUE(fixture_has("G 1.4 "));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_buffer_is_loaded_and_dumped);
    RUN_TEST(without_a_store_requests_with_files_are_refused);
    return UNITY_END();
}
