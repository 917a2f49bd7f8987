// SPDX-License-Identifier: Apache-2.0
// The shared memory of a run, which is created once and found by its name, and the names that components
// record in it so that the launcher can remove them.
#include "fsw/programs/run_state.h"

#include "osal/include/osal/task.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define COMPONENTS 4U
#define NAMES_EACH 8U

typedef struct {
    osal_task_t task;
    unsigned number;
    unsigned noted;
} subsystem_t;

static run_state_t block;
static char identity[RUN_IDENTITY_MAX];
static char name_of_run[RUN_NAME_MAX];

void setUp(void)
{
    (void)memset(&block, 0, sizeof block);
    (void)snprintf(identity, sizeof identity, "test-%d", (int)getpid());
    (void)snprintf(name_of_run, sizeof name_of_run, "/test-%d.run", (int)getpid());
}

void tearDown(void)
{
    (void)osal_shm_remove(name_of_run);
}

/// Returns the number of mappings of the run in this process.
static unsigned mappings(void)
{
    char line[512];
    unsigned count  = 0U;
    FILE* const map = fopen("/proc/self/maps", "r");
    TEST_ASSERT_NOT_NULL(map);
    while (fgets(line, sizeof line, map) != NULL) {
        count += (strstr(line, name_of_run) != NULL) ? 1U : 0U;
    }
    (void)fclose(map);
    return count;
}

static void a_run_is_created_once_and_found_by_its_name(void)
{
    osal_shm_t made;
    osal_shm_t second;
    osal_shm_t found;
    run_state_t* run       = NULL;
    run_state_t* none      = NULL;
    run_state_t* found_run = NULL;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_state_attach(&found, name_of_run, &found_run));
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_create(&made, identity, &run));
    TEST_ASSERT_EQUAL_STRING(identity, run->identity);
    TEST_ASSERT_EQUAL(0U, run->component_count);
    TEST_ASSERT_EQUAL(STATUS_EXISTS, run_state_create(&second, identity, &none));
    TEST_ASSERT_NULL(none);
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_attach(&found, name_of_run, &found_run));
    run->component_count = 3U;
    TEST_ASSERT_EQUAL(3U, found_run->component_count);
    osal_shm_close(&found);
    osal_shm_close(&made);
    TEST_ASSERT_EQUAL(0U, mappings());
}

static void memory_of_another_version_is_refused(void)
{
    osal_shm_t made;
    osal_shm_t found;
    run_state_t* run       = NULL;
    run_state_t* found_run = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_create(&made, identity, &run));
    run->magic++;
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_state_attach(&found, name_of_run, &found_run));
    TEST_ASSERT_EQUAL(1U, mappings()); // The mapping of the creator is the only one.
    osal_shm_close(&made);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(name_of_run));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&made, name_of_run, sizeof(run_state_t) / 2U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, run_state_attach(&found, name_of_run, &found_run));
    TEST_ASSERT_EQUAL(1U, mappings());
    osal_shm_close(&made);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_state_attach(&found, "no name", &found_run));
}

static void names_of_a_run_begin_with_its_identity(void)
{
    char name[16];
    (void)strcpy(block.identity, "hirosco-1");
    TEST_ASSERT_TRUE(run_name(&block, "run", 0U, name, sizeof name));
    TEST_ASSERT_EQUAL_STRING("/hirosco-1.run", name);
    TEST_ASSERT_TRUE(run_name(&block, "run", 1U, name, sizeof name)); // 15 characters and the end.
    TEST_ASSERT_EQUAL_STRING("/hirosco-1.run1", name);
    TEST_ASSERT_FALSE(run_name(&block, "run", 10U, name, sizeof name));
}

static void participants_and_types_follow_from_the_run(void)
{
    block.component_count = 3U;
    block.instance        = 0xFF123456U;
    TEST_ASSERT_EQUAL_UINT(1U, run_participant(0U));
    TEST_ASSERT_EQUAL_UINT(4U, run_operator(&block));
    TEST_ASSERT_EQUAL_HEX32(0x48123456U, run_message_type(&block));
    TEST_ASSERT_EQUAL_HEX32(0x4C123456U, run_link_type(&block));
}

static bool is_noted(const char* name)
{
    for (unsigned i = 0U; i < RUN_FLOWS_MAX; i++) {
        if (strcmp(block.flows[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

static void a_component_is_found_by_its_apid(void)
{
    static const uint16_t apids[] = {16U, 17U, 1U};
    unsigned index                = 99U;
    TEST_ASSERT_FALSE(run_state_find(&block, 0U, &index)); // The run has no components yet.
    block.component_count = 3U;
    for (unsigned i = 0U; i < 3U; i++) {
        block.components[i].apid = apids[i];
    }
    block.components[3].apid = 18U; // Beyond component_count.
    TEST_ASSERT_FALSE(run_state_find(&block, 18U, &index));
    TEST_ASSERT_EQUAL_UINT(99U, index);
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_TRUE(run_state_find(&block, apids[i], &index));
        TEST_ASSERT_EQUAL_UINT(i, index);
    }
}

static void the_last_beat_of_each_component_is_kept(void)
{
    run_state_beat(&block, 1U, 700U, 900U);
    run_state_beat(&block, 2U, 800U, 1000U);
    TEST_ASSERT_EQUAL_UINT64(700U, run_state_last_beat(&block, 1U).step_ns);
    TEST_ASSERT_EQUAL_UINT64(900U, run_state_last_beat(&block, 1U).wake_ns);
    TEST_ASSERT_EQUAL_UINT64(800U, run_state_last_beat(&block, 2U).step_ns);
    TEST_ASSERT_EQUAL_UINT64(1000U, run_state_last_beat(&block, 2U).wake_ns);
    TEST_ASSERT_EQUAL_UINT64(0U, run_state_last_beat(&block, 0U).step_ns);
}

static void a_name_is_recorded_once(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, "/run.flow.camera"));
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, "/run.flow.camera"));
    TEST_ASSERT_EQUAL_STRING("/run.flow.camera", block.flows[0].name);
    TEST_ASSERT_EQUAL_STRING("", block.flows[1].name);
}

static void a_slot_that_is_being_written_is_not_changed(void)
{
    block.flows[0].state = 1U; // Another component is writing this slot.
    (void)strcpy(block.flows[0].name, "/run.flow.cam");
    // The name may be the same.
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, "/run.flow.cam"));
    TEST_ASSERT_EQUAL_STRING("/run.flow.cam", block.flows[0].name);
    TEST_ASSERT_EQUAL_UINT32(1U, block.flows[0].state);
    TEST_ASSERT_EQUAL_STRING("/run.flow.cam", block.flows[1].name);
    TEST_ASSERT_EQUAL_UINT32(2U, block.flows[1].state);
    TEST_ASSERT_EQUAL_UINT32(0U, block.flows[2].state);
}

static void a_flow_name_that_does_not_fit_is_refused(void)
{
    char name[RUN_NAME_MAX + 1U];
    (void)memset(name, 'x', RUN_NAME_MAX);
    name[RUN_NAME_MAX] = '\0';
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, run_state_note_flow(&block, name));
    name[RUN_NAME_MAX - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, name));
    for (unsigned i = 1U; i < RUN_FLOWS_MAX; i++) {
        (void)snprintf(name, sizeof name, "/run.flow.%u", i);
        TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, name));
    }
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, run_state_note_flow(&block, "/run.flow.more"));
    TEST_ASSERT_EQUAL(STATUS_OK, run_state_note_flow(&block, "/run.flow.1"));
}

static void note_names(void* context)
{
    subsystem_t* const self = context;
    for (unsigned i = 0U; i < NAMES_EACH; i++) {
        char name[RUN_NAME_MAX];
        (void)snprintf(name, sizeof name, "/run.flow.%u.%u", self->number, i);
        self->noted += (run_state_note_flow(&block, name) == STATUS_OK) ? 1U : 0U;
    }
}

static void components_record_their_names_concurrently(void)
{
    static subsystem_t components[COMPONENTS];
    for (unsigned i = 0U; i < COMPONENTS; i++) {
        components[i] = (subsystem_t){.number = i};
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&components[i].task, note_names, &components[i], 0));
    }
    for (unsigned i = 0U; i < COMPONENTS; i++) {
        osal_task_join(&components[i].task);
        TEST_ASSERT_EQUAL_UINT(NAMES_EACH, components[i].noted);
    }
    for (unsigned i = 0U; i < (COMPONENTS * NAMES_EACH); i++) {
        char name[RUN_NAME_MAX];
        (void)snprintf(name, sizeof name, "/run.flow.%u.%u", i / NAMES_EACH, i % NAMES_EACH);
        TEST_ASSERT_TRUE_MESSAGE(is_noted(name), name);
    }
}

static void lateness_is_counted_in_classes(void)
{
    static const uint64_t late_ns[]              = {0U,       99999U,    100000U,    999999U,
                                                    1000000U, 10000000U, 100000000U, 5000000000U};
    static const uint32_t expected[RUN_LATENESS] = {2U, 2U, 1U, 1U, 2U};
    run_state_beat(&block, 1U, 500U, 1000U);
    TEST_ASSERT_EQUAL_UINT64(500U, run_state_last_beat(&block, 1U).step_ns);
    TEST_ASSERT_EQUAL_UINT64(1000U, run_state_last_beat(&block, 1U).wake_ns);
    run_state_wake(&block, 1U, 999U); // Woken by a message.
    for (size_t i = 0U; i < (sizeof late_ns / sizeof late_ns[0]); i++) {
        run_state_wake(&block, 1U, 1000U + late_ns[i]);
    }
    TEST_ASSERT_EQUAL_UINT32_ARRAY(expected, block.beats[1].late, RUN_LATENESS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_run_is_created_once_and_found_by_its_name);
    RUN_TEST(memory_of_another_version_is_refused);
    RUN_TEST(names_of_a_run_begin_with_its_identity);
    RUN_TEST(participants_and_types_follow_from_the_run);
    RUN_TEST(a_component_is_found_by_its_apid);
    RUN_TEST(the_last_beat_of_each_component_is_kept);
    RUN_TEST(a_name_is_recorded_once);
    RUN_TEST(a_slot_that_is_being_written_is_not_changed);
    RUN_TEST(a_flow_name_that_does_not_fit_is_refused);
    RUN_TEST(components_record_their_names_concurrently);
    RUN_TEST(lateness_is_counted_in_classes);
    return UNITY_END();
}
