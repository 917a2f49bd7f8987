// SPDX-License-Identifier: Apache-2.0
// The true state of a world as text: each column has a name, and a row has one number for each of them.
#include "sim/app/live_rows.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <stdlib.h>
#include <string.h>

static world_t world;
static plant_truth_t truth;
static char columns[LIVE_ROW_OCTETS];
static char row[LIVE_ROW_OCTETS];

void setUp(void)
{
    world = rokviss()->world;
    memset(&truth, 0, sizeof truth);
    truth.joint_count = 2U;
}

void tearDown(void)
{
}

static unsigned words_of(const char* const text)
{
    unsigned count = 0U;
    for (const char* at = text; *at != '\0'; at++) {
        count += (*at == ' ') ? 1U : 0U;
    }
    return count;
}

/// Returns the number that the row has in the column with this name.
static double number_in(const char* const name)
{
    const char* word = strstr(columns, " ");
    char* number     = row;
    while ((word != NULL) && ((strncmp(&word[1], name, strlen(name)) != 0) ||
                              (strchr(" \n", word[1U + strlen(name)]) == NULL))) {
        word   = strstr(&word[1], " ");
        number = strstr(&number[1], " ");
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(word, name);
    return atof(strstr(&number[1], " "));
}

static void write_both(void)
{
    const size_t names   = live_rows_columns(&world, columns);
    const size_t numbers = live_rows_row(&world, &truth, row);
    TEST_ASSERT_EQUAL_UINT(strlen(columns), names);
    TEST_ASSERT_EQUAL_UINT(strlen(row), numbers);
    TEST_ASSERT_EQUAL_UINT(words_of(columns), words_of(row));
    TEST_ASSERT_EQUAL_INT('\n', columns[strlen(columns) - 1U]);
    TEST_ASSERT_EQUAL_INT('\n', row[strlen(row) - 1U]);
}

static void joints_have_position_torque_and_brake(void)
{
    truth.link_position_rad[1] = 0.25;
    truth.joint_torque_nm[1]   = -3.0;
    truth.brake_engaged[0]     = true;
    write_both();
    TEST_ASSERT_EQUAL_DOUBLE(0.25, number_in("arm.joint2.position"));
    TEST_ASSERT_EQUAL_DOUBLE(-3.0, number_in("arm.joint2.torque"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, number_in("arm.joint1.brake"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, number_in("arm.joint2.brake"));
}

static void poses_momenta_of_wheels_and_states_of_valves_have_columns(void)
{
    world.robot[0].is_free = true;
    world.wheel_count      = 2U;
    world.valve_count      = 2U;
    (void)strcpy(world.wheel[0].device.name, "RW1");
    (void)strcpy(world.wheel[1].device.name, "RW2");
    (void)strcpy(world.valve[0].name, "PUSH");
    (void)strcpy(world.valve[1].name, "TURN");
    truth.base_count            = 1U;
    truth.base[0].position_m[2] = 1.5;
    truth.base[0].rotation[3]   = 0.5;
    truth.wheel[1].momentum_nms = -12.5;
    truth.valve_open[1]         = true;
    write_both();
    TEST_ASSERT_EQUAL_DOUBLE(1.5, number_in("arm.z"));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, number_in("arm.qz"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, number_in("RW1.momentum"));
    TEST_ASSERT_EQUAL_DOUBLE(-12.5, number_in("RW2.momentum"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, number_in("PUSH.open"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, number_in("TURN.open"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(joints_have_position_torque_and_brake);
    RUN_TEST(poses_momenta_of_wheels_and_states_of_valves_have_columns);
    return UNITY_END();
}
