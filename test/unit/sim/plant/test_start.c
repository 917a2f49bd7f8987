// SPDX-License-Identifier: Apache-2.0
// A robot whose <State> is valid at a later time reaches that state at that time.
#include "sim/plant/plant.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <math.h>

#define STEP_NS 250000U
#define STEP_S 0.00025
#define BODY                                                                                                 \
    "<robot name=\"b\"><link name=\"base\"><inertial><origin xyz=\"0.2 -0.1 0.05\"/><mass value=\"224\"/>"   \
    "<inertia ixx=\"32\" ixy=\"1\" ixz=\"-1.5\" iyy=\"38\" iyz=\"0.8\" "                                     \
    "izz=\"45\"/></inertial></link></robot>"
#define WORLD(gravity, valid)                                                                                \
    "<World name=\"w\" step=\"500us\" gravity=\"" gravity                                                    \
    "\">\n<Robot name=\"r\" urdf=\"b.urdf\" base=\"free\"><State at=\"2.16 0.5 -0.3\" rpy=\"0.3 -0.2 0.9\" " \
    "velocity=\"0.02 -0.01 0.03\" rate=\"0.052 0.013 -0.02\"" valid "/></Robot>\n</World>\n"

static world_t world;
static plant_t* plant;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    (void)temporary_file("b.urdf", BODY);
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static plant_base_t base_after(const char* text, double seconds)
{
    static plant_input_t input;
    plant_destroy(plant);
    plant = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    plant_step(plant, &input, STEP_NS);
    for (unsigned i = 1U; i < (unsigned)lround(seconds / STEP_S); i++) {
        plant_step(plant, &input, STEP_NS);
    }
    return plant_truth(plant)->base[0];
}

static void expect_same(const plant_base_t* wanted, const plant_base_t* found, double bound)
{
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(wanted->position_m[i], bound, found->position_m[i]);
        EXPECT_WITHIN(wanted->velocity_m_s[i], bound, found->velocity_m_s[i]);
        EXPECT_WITHIN(wanted->rate_rad_s[i], bound, found->rate_rad_s[i]);
    }
    const double sign = (wanted->rotation[0] * found->rotation[0] < 0.0) ? -1.0 : 1.0;
    for (unsigned i = 0U; i < 4U; i++) {
        EXPECT_WITHIN(wanted->rotation[i], bound, sign * found->rotation[i]);
    }
}

static void a_tumbling_robot_reaches_its_state_at_the_given_time(void)
{
    const plant_base_t wanted = base_after(WORLD("0 0 0", ""), STEP_S);
    const plant_base_t start  = base_after(WORLD("0 0 0", " valid=\"75s\""), STEP_S);
    const plant_base_t found  = base_after(WORLD("0 0 0", " valid=\"75s\""), 75.0 + STEP_S);
    expect_same(&wanted, &found, 2e-5);
    EXPECT_ABOVE(0.5, fabs(start.position_m[0] - wanted.position_m[0]));
    EXPECT_ABOVE(0.1, fabs(start.rotation[1] - wanted.rotation[1]));
    EXPECT_ABOVE(1e-3, fabs(start.rate_rad_s[2] - wanted.rate_rad_s[2]));
}

static void gravity_acts_before_the_given_time(void)
{
    const plant_base_t wanted = base_after(WORLD("0 0.1 -0.2", ""), STEP_S);
    const plant_base_t found  = base_after(WORLD("0 0.1 -0.2", " valid=\"3s\""), 3.0 + STEP_S);
    expect_same(&wanted, &found, 2e-4); // The plant integrates gravity in steps.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_tumbling_robot_reaches_its_state_at_the_given_time);
    RUN_TEST(gravity_acts_before_the_given_time);
    return UNITY_END();
}
