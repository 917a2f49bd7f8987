// SPDX-License-Identifier: Apache-2.0
// Parameters that ST[12] of the supervisor monitors, and when they have a value.
#include "fsw/supervisor/services/monitoring.h"
#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#define FORCE PARAMETER_ID(ARM, VALUE_UINT16, 7U)
#define NOWHERE PARAMETER_ID(99U, VALUE_UINT16, 7U)

static pus_parameter_port_t port;

void setUp(void)
{
    telemetry_directory_t* const directory = &fixture.supervisor.spacecraft.directory;
    fixture_open_up();
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    directory->parameters[0]   = (telemetry_parameter_t){FORCE, 2U}; // As if the descriptors had been read.
    directory->parameters[1]   = (telemetry_parameter_t){NOWHERE, 2U};
    directory->parameter_count = 2U;
    port                       = spacecraft_watched(&fixture.supervisor);
}

void tearDown(void)
{
    fixture_close();
}

static status_t find(const uint32_t parameter_id, uint16_t* const out_handle)
{
    uint16_t size         = 0U;
    const status_t status = port.find(port.context, parameter_id, out_handle, &size);
    TEST_ASSERT_TRUE((status == STATUS_NOT_FOUND) || (size > 0U));
    return status;
}

/// TM[20,2] of ARM.
static void report_force(const uint16_t force)
{
    uint8_t data[8];
    octet_writer_t writer = octet_writer(data, sizeof data);
    octet_write_u16(&writer, 1U);
    octet_write_u32(&writer, FORCE);
    octet_write_u16(&writer, force);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_PARAMETERS, 2U, data, sizeof data);
    fixture_run(2U);
}

static void a_reported_parameter_is_monitored_while_its_subsystem_runs(void)
{
    uint8_t octets[2]     = {0U};
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    uint16_t handle       = 0U;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(FORCE, &handle));
    report_force(0x0A0BU);
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
    port.read(port.context, handle, &writer);
    TEST_ASSERT_EQUAL_HEX8(0x0AU, octets[0]);
    TEST_ASSERT_EQUAL_HEX8(0x0BU, octets[1]);
    supervisor_registry_find(&fixture.supervisor, ARM)->process = PROCESS_LOST;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(FORCE, &handle));
}

static void a_value_that_is_no_longer_reported_is_absent(void)
{
    uint16_t handle = 0U;
    report_force(1U);
    fixture_run(1000U); // A value that is reported once, perhaps on request, never becomes old.
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
    report_force(2U);
    fixture_run(98U); // Until the next second.
    report_force(3U);
    fixture_run(290U);
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
    fixture_run(20U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(FORCE, &handle));
    report_force(4U);
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
}

static void a_subsystem_that_is_offline_or_not_heard_has_no_values(void)
{
    uint16_t handle = 0U;
    report_force(1U);
    fixture_put_in_state(FIXTURE_ARM, STATE_OFFLINE);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(FORCE, &handle));
    fixture_put_in_state(FIXTURE_ARM, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
    fixture.members[FIXTURE_ARM].is_silent = true;
    fixture_run(160U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(FORCE, &handle));
    fixture.members[FIXTURE_ARM].is_silent = false;
    fixture_run(100U);
    TEST_ASSERT_EQUAL(STATUS_OK, find(FORCE, &handle));
}

static void the_supervisors_own_parameters_are_monitored_directly(void)
{
    uint8_t octets[4]     = {0U};
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    uint16_t handle       = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, find(SUPERVISOR_PARAMETER_ORBIT_PERIOD, &handle));
    fixture.supervisor.orbit_period_ms = 0x01020304U;
    port.read(port.context, handle, &writer);
    TEST_ASSERT_EQUAL_HEX8(4U, octets[3]);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, find(PARAMETER_ID(SUPERVISOR_APID, VALUE_UINT8, 999U), &handle));
}

static void a_parameter_without_a_descriptor_is_unknown(void)
{
    uint16_t handle = 0U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, find(PARAMETER_ID(ARM, VALUE_UINT16, 8U), &handle));
    // The mission has no subsystem with this parameter.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, find(NOWHERE, &handle));
    supervisor_telemetry_directory_init(&fixture.supervisor.spacecraft.directory);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, find(FORCE, &handle));
}

static void a_parameter_without_room_in_the_telemetry_cache_is_unknown(void)
{
    uint16_t handle                                 = 0U;
    fixture.supervisor.spacecraft.cache.value_count = TELEMETRY_CACHE_PARAMETERS;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, find(FORCE, &handle));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_reported_parameter_is_monitored_while_its_subsystem_runs);
    RUN_TEST(a_value_that_is_no_longer_reported_is_absent);
    RUN_TEST(a_subsystem_that_is_offline_or_not_heard_has_no_values);
    RUN_TEST(the_supervisors_own_parameters_are_monitored_directly);
    RUN_TEST(a_parameter_without_a_descriptor_is_unknown);
    RUN_TEST(a_parameter_without_room_in_the_telemetry_cache_is_unknown);
    return UNITY_END();
}
