// SPDX-License-Identifier: Apache-2.0
// Every world of the project, with or without a mission of its name, can be read and has a plant that moves.
#include "sim/plant/plant.h"
#include "unity.h"

#include <glob.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void every_world_is_read_and_moves(void)
{
    static world_t world;
    static const plant_input_t idle = {.drive = NULL};
    char error[DOCUMENT_ERROR_MAX];
    glob_t found;
    TEST_ASSERT_EQUAL_INT(0, glob("descriptors/worlds/*.xml", 0, NULL, &found));
    for (size_t i = 0U; i < found.gl_pathc; i++) {
        plant_t* plant = NULL;
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(found.gl_pathv[i], &world, error), error);
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
        for (unsigned step = 0U; step < 100U; step++) {
            plant_step(plant, &idle, (uint64_t)world.step_ns);
        }
        TEST_ASSERT_NULL(plant_failure(plant));
        plant_destroy(plant);
    }
    globfree(&found);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_world_is_read_and_moves);
    return UNITY_END();
}
