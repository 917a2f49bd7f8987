// SPDX-License-Identifier: Apache-2.0
// Descriptors compiled into a program: the hash of the mission selects them, and a run with another hash is
// refused.
#include "fsw/programs/compiled_descriptors.h"

#include "test/support/assertion.h"
#include "unity.h"

#include <string.h>

#define HASH 0x0123456789ABCDEFULL
#define OTHER_HASH 0xFEDCBA9876543210ULL
#define STRANGE_HASH 0x1111111111111111ULL
#define APID 16U
#define OTHER_APID 17U

static const mission_descriptor_t missions[2] = {{.name = "first"}, {.name = "second"}};
static subsystem_descriptor_t models[3];
static const compiled_descriptor_t entries[] = {{HASH, APID, &missions[0], &models[0]},
                                                {OTHER_HASH, APID, &missions[1], &models[1]},
                                                {OTHER_HASH, OTHER_APID, &missions[1], &models[2]}};
static compiled_descriptors_t compiled       = {.entries = entries, .count = 3U};
static component_descriptors_t access;
static run_state_t run;

void setUp(void)
{
    access            = compiled_descriptors(&compiled);
    run               = (run_state_t){.mission_path = "m.xml", .component_count = 2U};
    run.components[0] = (run_component_t){.apid = APID, .name = "FIRST"};
    run.components[1] = (run_component_t){.apid = OTHER_APID, .name = "SECOND"};
}

void tearDown(void)
{
}

static void hash_and_number_of_the_subsystem_select_the_descriptors(void)
{
    static const struct {
        uint64_t hash;
        unsigned component;
        unsigned mission;
        unsigned model;
    } cases[] = {{HASH, 0U, 0U, 0U}, {OTHER_HASH, 0U, 1U, 1U}, {OTHER_HASH, 1U, 1U, 2U}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        const mission_descriptor_t* mission = NULL;
        subsystem_descriptor_t* own         = NULL;
        run.mission_hash                    = cases[i].hash;
        TEST_ASSERT_NULL(access.load(access.context, &run, cases[i].component, &mission, &own));
        TEST_ASSERT_EQUAL_PTR(&missions[cases[i].mission], mission);
        TEST_ASSERT_EQUAL_PTR(&models[cases[i].model], own);
    }
}

static void another_hash_is_refused_with_all_hashes_and_the_next_step(void)
{
    const mission_descriptor_t* mission = NULL;
    subsystem_descriptor_t* own         = NULL;
    run.mission_hash                    = STRANGE_HASH;
    const char* const error             = access.load(access.context, &run, 0U, &mission, &own);
    TEST_ASSERT_EQUAL_STRING("m.xml: hash 0x1111111111111111: run `make rtos` to build the program of FIRST, "
                             "which was compiled for "
                             "first 0x0123456789ABCDEF, second 0xFEDCBA9876543210, second 0xFEDCBA9876543210",
                             error);
    TEST_ASSERT_NULL(mission);
    TEST_ASSERT_NULL(own);
}

static void a_refusal_with_a_long_path_still_has_the_next_step(void)
{
    const mission_descriptor_t* mission = NULL;
    subsystem_descriptor_t* own         = NULL;
    run.mission_hash                    = STRANGE_HASH;
    (void)memset(run.mission_path, 'm', sizeof run.mission_path - 1U);
    const char* const error = access.load(access.context, &run, 0U, &mission, &own);
    TEST_ASSERT_NOT_NULL(
        strstr(error, "run `make rtos` to build the program of FIRST, which was compiled for"));
}

static void a_subsystem_without_a_descriptor_is_refused(void)
{
    const mission_descriptor_t* mission = NULL;
    subsystem_descriptor_t* own         = NULL;
    run.mission_hash                    = HASH; // The mission has no such subsystem of this program.
    TEST_ASSERT_NOT_NULL(strstr(access.load(access.context, &run, 1U, &mission, &own), "of SECOND,"));
}

static void compiled_descriptors_cannot_be_read_again(void)
{
    char characters[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error                  = text_in(characters, sizeof characters);
    subsystem_descriptor_t* spare = &models[0];
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, access.read(access.context, "a.xml", &spare, &error));
    TEST_ASSERT_NULL(spare);
    TEST_ASSERT_EQUAL_STRING("a.xml:1: the descriptor is compiled into the program; run `make rtos`",
                             characters);
}

static void exchange(void)
{
    access.exchange(access.context, &models[0]);
}

static void exchanging_a_model_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(exchange));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(hash_and_number_of_the_subsystem_select_the_descriptors);
    RUN_TEST(another_hash_is_refused_with_all_hashes_and_the_next_step);
    RUN_TEST(a_refusal_with_a_long_path_still_has_the_next_step);
    RUN_TEST(a_subsystem_without_a_descriptor_is_refused);
    RUN_TEST(compiled_descriptors_cannot_be_read_again);
    RUN_TEST(exchanging_a_model_is_a_coding_error);
    return UNITY_END();
}
