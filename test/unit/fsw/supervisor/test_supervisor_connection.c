// SPDX-License-Identifier: Apache-2.0
// TC[17,3] to the supervisor: it tests the connection to another application, and reports the result.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static void request_connection_test(const uint16_t apid)
{
    const uint8_t data[2] = {(uint8_t)(apid >> 8U), (uint8_t)apid};
    (void)fixture_tc(1U, PUS_SERVICE_TEST, 3U, data, sizeof data);
}

/// Send a report of ARM.
static void answer(const uint8_t service, const uint8_t subtype, const uint16_t destination)
{
    octet_writer_t writer =
        pus_tm_begin(&fixture.members[FIXTURE_ARM].process, service, subtype, destination, fixture.now_ns);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&fixture.members[FIXTURE_ARM].process, &writer));
}

static void the_supervisor_reaches_itself(void)
{
    request_connection_test(1U);
    fixture_run(1U);
    fixture_expect("G 1.1 #0\nG 1.3 #0\nG 17.4 0001\nG 1.7 #0\n");
}

static void an_application_that_answers_is_reached(void)
{
    request_connection_test(ARM);
    fixture_run(1U);
    fixture_expect("G 1.1 #0\nG 1.3 #0\n16 TC 17.1 from 8001\n");
    answer(PUS_SERVICE_TEST, 2U, PUS_USER_GROUND); // This is not the expected answer.
    answer(PUS_SERVICE_TEST, 4U, PUS_USER_SUPERVISOR);
    answer(PUS_SERVICE_EVENTS, 2U, PUS_USER_SUPERVISOR);
    fixture_run(3U);
    TEST_ASSERT_FALSE(fixture_has("G 17.4"));
    answer(PUS_SERVICE_TEST, 2U, PUS_USER_SUPERVISOR);
    fixture_forget();
    fixture_run(3U);
    fixture_expect("G 17.4 0010\nG 1.7 #0\n");
}

/// A request waits for the answer for 1000 ms, 100 steps; then it fails with PUS_FAILURE_TIMEOUT, 0x0406.
static void an_application_that_is_silent_for_a_second_is_reported(void)
{
    request_connection_test(ARM);
    request_connection_test(HAND);
    fixture_run(50U);
    answer(PUS_SERVICE_TEST, 2U, PUS_USER_SUPERVISOR);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G 17.4 0010"));
    fixture_forget();
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #1 0406 3E8"));
    fixture_forget();
    fixture_run(60U);
    TEST_ASSERT_FALSE(fixture_has("G 1.8 #0"));
}

static void applications_that_do_not_exist_are_refused(void)
{
    request_connection_test(99U);
    fixture_run(1U);
    fixture_expect("G 1.1 #0\nG 1.4 #0 0201 63\n");
}

static void the_number_of_concurrent_tests_is_limited(void)
{
    for (unsigned i = 0U; i <= SPACECRAFT_CONNECTIONS; i++) {
        request_connection_test(ARM);
    }
    fixture_run(4U);
    TEST_ASSERT_TRUE(fixture_has("G 1.4 #4 0205 4"));
    answer(PUS_SERVICE_TEST, 2U, PUS_USER_SUPERVISOR); // One answer completes all requests.
    fixture_forget();
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #0"));
    TEST_ASSERT_TRUE(fixture_has("G 1.7 #3"));
}

static void an_application_without_room_gets_no_request(void)
{
    fixture_fill(FIXTURE_ARM);
    request_connection_test(ARM);
    fixture_step();
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #"));
    TEST_ASSERT_NOT_NULL(strstr(fixture_look(), " 0002 10\n"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_supervisor_reaches_itself);
    RUN_TEST(an_application_that_answers_is_reached);
    RUN_TEST(an_application_that_is_silent_for_a_second_is_reported);
    RUN_TEST(applications_that_do_not_exist_are_refused);
    RUN_TEST(the_number_of_concurrent_tests_is_limited);
    RUN_TEST(an_application_without_room_gets_no_request);
    return UNITY_END();
}
