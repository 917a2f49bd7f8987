// SPDX-License-Identifier: Apache-2.0
// ST[18] of the supervisor: requests, readings and events of its procedures, and the cost of a procedure
// without an end.
#include "base/crc.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

#define LOOK "LOOK\0\0\0\0"
#define NAME_OCTETS 8U

static bool has_descriptor;
static const subsystem_descriptor_t* own;

static status_t load_own(void* const context, const uint16_t index,
                         const subsystem_descriptor_t** const out_descriptor)
{
    *out_descriptor = own;
    TEST_ASSERT_EQUAL_PTR(&own, context);
    return (has_descriptor && (fixture.supervisor.mission->subsystems[index].apid == SUPERVISOR_APID))
               ? STATUS_OK
               : STATUS_NOT_FOUND;
}

/// Give the supervisor its own descriptor; the descriptors of other subsystems cannot be read.
static void give_descriptors(supervisor_config_t* const config)
{
    own                 = config->descriptor;
    config->descriptors = (supervisor_descriptors_t){&own, load_own};
}

static void begin(void)
{
    fixture_configure = give_descriptors;
    fixture_open_up();
    fixture.ack = 0U;
}

void setUp(void)
{
    has_descriptor = true;
    begin();
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

static const pus_procedures_t* service(void)
{
    return &fixture.supervisor.spacecraft.procedures.service;
}

/// Load a procedure under the name LOOK or under another name.
static void load(const char* const name, const char* const code)
{
    uint8_t data[2048];
    octet_writer_t writer = octet_writer(data, sizeof data);
    const uint8_t* octets = (const uint8_t*)code;
    octet_write_octets(&writer, (const uint8_t*)name, NAME_OCTETS);
    octet_write_u16(&writer, (uint16_t)strlen(code));
    octet_write_octets(&writer, octets, strlen(code));
    octet_write_u16(&writer, crc16_ccitt(octets, strlen(code)));
    TEST_ASSERT_FALSE(writer.failed);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_PROCEDURES, 1U, data, writer.position);
    fixture_step();
}

static void activate(const char* const name)
{
    uint8_t data[NAME_OCTETS + 2U] = {0}; // No level, no arguments.
    (void)memcpy(data, name, NAME_OCTETS);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_PROCEDURES, 3U, data, sizeof data);
    fixture_step();
}

static void run(const char* const code)
{
    load(LOOK, code);
    activate(LOOK);
}

static void expect_ends(const uint32_t ended, const uint32_t failed)
{
    // Text of the last error.
    const char* const text = fixture.supervisor.spacecraft.procedures.slots[0].text;
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(failed, service()->counters.failed, text);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(ended, service()->counters.ended, text);
}

static void a_request_is_routed_and_its_end_awaited(void)
{
    run("assert(send(16, 17, 1, '', true)) assert(send(16, 17, 1))");
    fixture_run(3U);
    fixture_expect("16 TC 17.1 from 8001\n16 TC 17.1 from 8001\n");
    expect_ends(1U, 0U);
}

static void a_procedure_s_request_without_permission_is_refused(void)
{
    // PUS_FAILURE_PERMISSION, PUS_FAILURE_NO_ROUTE.
    run("local ok, code = send(16, 8, 1, 'MOVE\\0\\0\\0\\0\\0', true) assert(not ok and code == 0x0110)\n"
        "ok, code = send(99, 17, 1, '', true) assert(not ok and code == 0x0001)");
    fixture_run(5U);
    fixture_expect("");
    expect_ends(1U, 0U);
}

/// A procedure cannot send TC[129,8], even if the mission permits this request.
static void a_procedure_gives_no_orders_in_the_name_of_the_supervisor(void)
{
    run("local ok, code, detail = send(18, 129, 8, '\\3\\0', true)\n" // PUS_FAILURE_SOURCE.
        "assert(not ok and code == 0x0107 and detail == 0x8001, code)");
    fixture_run(5U);
    fixture_expect("");
    expect_ends(1U, 0U);
}

static void a_procedure_is_notified_when_an_addressee_does_not_answer(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    // PUS_FAILURE_TIMEOUT.
    run("local ok, code = send(16, 17, 1, '', true) assert(not ok and code == 0x0406, code)");
    fixture_run(1100U); // The supervisor ends requests that are not accepted in time.
    expect_ends(1U, 0U);
}

static void requests_share_the_sequence_counts_of_the_supervisor(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_OPERATIONAL);
    run("for i = 1, 3 do assert(send(16, 17, 1, '', true)) end");
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_MEDIUM, STRAIN); // The plan of this event commands ARM.
    fixture_run(10U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 "));
    expect_ends(1U, 0U);
    TEST_ASSERT_EQUAL_UINT16(0U, fixture.supervisor.spacecraft.procedures.requester.addressee_count);
    TEST_ASSERT_TRUE(fixture.supervisor.requester.addressee_count > 0U);
}

static void telemetry_is_read_by_name_and_number(void)
{
    static const uint8_t values[] = {0, 1, 0x02, 0x02, 0, 5, 0, 0, 0x10, 0x92}; // TM[20,2]: UINT32 5 of ARM.
    static const uint8_t large[]  = {0, 1, 0x02, 0x03, 0, 6, 0, 0, 0, 0, 0, 0, 0, 7};
    fixture_run(600U); // Until the supervisor has reported its own values.
    fixture_report(FIXTURE_ARM, PUS_SERVICE_PARAMETERS, 2U, values, sizeof values);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_PARAMETERS, 2U, large, sizeof large);
    fixture_step();
    run("assert(get('SUPERVISOR.STATUS.SUBSYSTEMS') == 5)\n"
        "assert(get(0x02020005) == 4242 and get(0x02030006) == 7)\n"
        "assert(get(0x02020007) == nil and get(0x02180005) == nil and get('ARM.NOTHING') == nil)\n"
        "assert(get('SUPERVISOR.ORBIT.ANGLE') == nil)"); // This parameter was never reported.
    fixture_run(3U);
    expect_ends(1U, 0U);
}

static void names_come_from_descriptors(void)
{
    fixture_close();
    has_descriptor = false;
    begin();
    fixture_run(600U);
    run("assert(get('SUPERVISOR.STATUS.SUBSYSTEMS') == nil)");
    fixture_run(3U);
    expect_ends(1U, 0U);
}

static void only_events_for_procedures_are_raised(void)
{
    run("step(2) assert(event(15) and event(16)) assert(not event(1) and not event(13) and not event(99))");
    fixture_run(3U);
    // PROCEDURE_NOTE (15) and PROCEDURE_WARNING (16): name LOOK, step 2.
    fixture_expect("G 5.1 000F4C4F4F4B000000000002\nG 5.2 00104C4F4F4B000000000002\n");
    expect_ends(1U, 0U);
}

static void an_error_is_reported(void)
{
    run("\nerror('no light')");
    fixture_run(2U);
    // PROCEDURE_FAILED (14): name LOOK, what 3, step 0, line 2, text "LOOK:2: no light".
    TEST_ASSERT_TRUE(
        fixture_has("G 5.2 000E4C4F4F4B00000000030000000000024C4F4F4B3A323A206E6F206C6967687400"));
    expect_ends(0U, 1U);
}

/// In each step the fixture checks that the supervisor asks for its next wake within a tick.
static void procedures_without_end_use_only_their_share(void)
{
    char name[NAME_OCTETS] = "SPIN";
    for (unsigned i = 1U; i < SPACECRAFT_PROCEDURE_SLOTS; i++) {
        name[4] = (char)('0' + (int)i);
        load(name, "while true do pcall(string.rep, 'x', 1000) end");
        activate(name);
    }
    run("while true do send(16, 17, 1) event(15) end");
    fixture_forget();
    for (unsigned i = 0U; i < 101U; i++) {
        fixture_run(1U);
        TEST_ASSERT_TRUE(fixture_count_lines(fixture_look(), "") <= SPACECRAFT_PROCEDURE_CALLS);
    }
    TEST_ASSERT_EQUAL_UINT32(SPACECRAFT_PROCEDURE_SLOTS, service()->counters.started);
    TEST_ASSERT_TRUE(service()->counters.sent >= (100U * SPACECRAFT_PROCEDURE_CALLS / 2U));
    TEST_ASSERT_TRUE(fixture.members[FIXTURE_ARM].heartbeats > 0U);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_PROCEDURES, 17U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(SPACECRAFT_PROCEDURE_SLOTS, service()->counters.aborted);
    TEST_ASSERT_FALSE(pus_procedures_are_active(service()));
}

/// A request to a subsystem that reads nothing, does not run or does not exist delays requests to other
/// subsystems by at most a tenth of a second.
static void requests_to_a_subsystem_that_reads_nothing_end_in_time(void)
{
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    fixture.members[FIXTURE_LONE].is_running   = false;
    fixture_run(20U);
    load("SPIN\0\0\0\0", "while true do send(16, 17, 1) send(18, 17, 1) send(99, 17, 1) end");
    activate("SPIN\0\0\0\0");
    fixture_run(200U); // ARM's inbox is full.
    TEST_ASSERT_TRUE(fixture.supervisor.counters.tc_unroutable > 100U);
    load(LOOK, "send(17, 17, 1)");
    fixture_forget();
    activate(LOOK);
    fixture_run((unsigned)(SPACECRAFT_CREDIT_TIMEOUT_NS / FIXTURE_TICK_NS) + 3U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 17.1 "));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_request_is_routed_and_its_end_awaited);
    RUN_TEST(a_procedure_s_request_without_permission_is_refused);
    RUN_TEST(a_procedure_gives_no_orders_in_the_name_of_the_supervisor);
    RUN_TEST(a_procedure_is_notified_when_an_addressee_does_not_answer);
    RUN_TEST(requests_share_the_sequence_counts_of_the_supervisor);
    RUN_TEST(telemetry_is_read_by_name_and_number);
    RUN_TEST(names_come_from_descriptors);
    RUN_TEST(only_events_for_procedures_are_raised);
    RUN_TEST(an_error_is_reported);
    RUN_TEST(procedures_without_end_use_only_their_share);
    RUN_TEST(requests_to_a_subsystem_that_reads_nothing_end_in_time);
    return UNITY_END();
}
