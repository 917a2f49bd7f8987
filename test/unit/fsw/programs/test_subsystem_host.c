// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"

#include "unity.h"

#include <string.h>

#define LONG_DIRECTORY "/a-directory-with-a-name-of-forty-characters"

static run_state_t run;
static mission_descriptor_t mission;
static mission_subsystem_t arm;
static subsystem_descriptor_t descriptor;
static component_runtime_t runtime;
static subsystem_host_t host;

void setUp(void)
{
    arm     = (mission_subsystem_t){.apid = 16U, .line = 5U, .descriptor = "subsystems/arm.xml"};
    mission = (mission_descriptor_t){.subsystems = &arm, .subsystem_count = 1U};
    descriptor.interface_hash = 1U;
    runtime = (component_runtime_t){.run = &run, .mission = &mission, .apid = 16U, .own = &descriptor};
}

void tearDown(void)
{
}

static const char* refusal(const char* const directory, const unsigned count)
{
    static const subsystem_callbacks_t callbacks = {.hardware_init = NULL};
    run.mission_path[0]                          = '\0';
    for (unsigned i = 0U; i < count; i++) {
        (void)strcat(run.mission_path, directory);
    }
    (void)strcat(run.mission_path, "/m.xml");
    TEST_ASSERT_FALSE(subsystem_host_load(&host, &runtime, 2U, &callbacks));
    return runtime.error;
}

static void the_path_of_its_descriptor_is_relative_to_the_mission_or_absolute(void)
{
    TEST_ASSERT_EQUAL_STRING(
        "/f/subsystems/arm.xml:1: interface hash: expected 0x0000000000000002 as compiled, found "
        "0x0000000000000001: run make",
        refusal("/f", 1U));
    arm.descriptor = "/g/arm.xml";
    TEST_ASSERT_EQUAL_STRING_LEN("/g/arm.xml:1: ", refusal("/f", 1U), 14U);
}

static void a_path_that_is_too_long_is_refused_with_a_message(void)
{
    const char* const reason = refusal(LONG_DIRECTORY, 6U);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(reason,
                                        "/m.xml:5: descriptor=\"subsystems/arm.xml\" of <Subsystem>: "
                                        "expected a path of at most 255 characters with its directory"),
                                 reason);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_path_of_its_descriptor_is_relative_to_the_mission_or_absolute);
    RUN_TEST(a_path_that_is_too_long_is_refused_with_a_message);
    return UNITY_END();
}
