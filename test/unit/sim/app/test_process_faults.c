// SPDX-License-Identifier: Apache-2.0
// The word of a scenario line names one process of the run, or is refused with the names.
#include "sim/app/process_faults.h"
#include "unity.h"

#include <string.h>

static process_faults_t faults;
static char error[SCENARIO_ERROR_MAX];

void setUp(void)
{
    faults   = (process_faults_t){.scheduler = NULL};
    error[0] = '\0';
}

void tearDown(void)
{
}

static void name_two_arms(void)
{
    static const char* const names[] = {"supervisor", "SUPERVISOR", "arm", "LEFT", "arm", "RIGHT"};
    for (unsigned i = 0U; i < 6U; i++) {
        TEST_ASSERT_TRUE(process_faults_name(&faults, names[i], i / 2U));
    }
    TEST_ASSERT_TRUE(process_faults_name(&faults, "launcher", PROCESS_FAULTS_OTHER));
    TEST_ASSERT_TRUE(process_faults_name(&faults, "image", PROCESS_FAULTS_OTHER));
}

static status_t check(const char* word)
{
    const scenario_line_t line = {.path = "a.scn", .line = 7U, .word_count = 2U, .word = {"kill", word}};
    return process_faults_check(&faults, &line, 1U, error);
}

static void an_unknown_process_is_refused_with_the_names(void)
{
    name_two_arms();
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, check("nosuch"));
    TEST_ASSERT_EQUAL_STRING("a.scn:7: found 'nosuch', expected a process of this run: supervisor SUPERVISOR "
                             "arm LEFT arm RIGHT launcher image",
                             error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, check("simulator")); // Another form of the run has this process.
}

static void a_program_of_two_subsystems_is_refused_with_the_choices(void)
{
    osal_lockstep_t* const some = (osal_lockstep_t*)&faults; // Only the presence of a scheduler counts.
    name_two_arms();
    faults.scheduler = some;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, check("arm"));
    TEST_ASSERT_EQUAL_STRING(
        "a.scn:7: found 'arm', expected one of the subsystems that run this program: LEFT RIGHT", error);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("RIGHT"));
    faults.scheduler = NULL; // Their processes cannot be told apart.
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, check("RIGHT"));
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(error, "found 'RIGHT', expected a subsystem with a program of its own"), error);
}

static void names_of_one_process_are_accepted(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("nosuch")); // The processes of the run are not known.
    name_two_arms();
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("supervisor"));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("SUPERVISOR"));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("image"));
    TEST_ASSERT_EQUAL_INT(STATUS_OK, check("launcher"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_unknown_process_is_refused_with_the_names);
    RUN_TEST(a_program_of_two_subsystems_is_refused_with_the_choices);
    RUN_TEST(names_of_one_process_are_accepted);
    return UNITY_END();
}
