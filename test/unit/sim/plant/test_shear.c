// SPDX-License-Identifier: Apache-2.0
// A contact that yields along the surface.
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define STEP_NS 500000U
#define JOINTS 2U

static world_t world;
static plant_t* plant;
static plant_input_t input;
static double wanted_rad[JOINTS];

/// Motors that hold a pose.
static void hold_pose(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    for (unsigned i = 0U; i < JOINTS; i++) {
        out_torque_nm[i] = 4000.0 * (wanted_rad[i] - motor[i].position_rad) - 100.0 * motor[i].velocity_rad_s;
    }
}

static void begin_with_shear(const double stiffness)
{
    char error[DOCUMENT_ERROR_MAX];
    world                          = rokviss()->world;
    world.contact[0].shear         = stiffness;
    world.contact[0].shear_damping = 80.0;
    plant_destroy(plant);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    input = (plant_input_t){.drive = hold_pose};
    memcpy(wanted_rad, world.robot[0].start, sizeof wanted_rad);
}

void setUp(void)
{
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
}

static void aim(double x, double z)
{
    const double l1 = rokviss()->scene.link_length_m[0];
    const double l2 = rokviss()->scene.link_length_m[1];
    const double d2 = x * x + z * z;

    wanted_rad[0] = atan2(z, x) + acos((l1 * l1 + d2 - l2 * l2) / (2.0 * l1 * sqrt(d2)));
    wanted_rad[1] = acos((l1 * l1 + l2 * l2 - d2) / (2.0 * l1 * l2)) - acos(-1.0);
}

static void glide(double from_x, double from_z, double to_x, double to_z)
{
    for (unsigned i = 0U; i < 2000U; i++) {
        const double s = (double)(i + 1U) / 2000.0;
        aim(from_x + s * (to_x - from_x), from_z + s * (to_z - from_z));
        plant_step(plant, &input, STEP_NS);
    }
}

static void rest(void)
{
    for (unsigned i = 0U; i < 2000U; i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

static void press_at(double x, double below_m)
{
    glide(0.3265, 0.0655, x, -0.02);
    glide(x, -0.02, x, -0.030 - below_m);
    rest();
}

/// Returns the position of the point of the finger that is 12 mm below the tip.
static double touching_x(const plant_truth_t* truth)
{
    return truth->contact[0].place_m[0] + 0.012 * (truth->link_position_rad[0] + truth->link_position_rad[1]);
}

static void a_sticking_finger_is_held_by_a_spring_along_the_contour(void)
{
    const double stiffness[] = {1000.0, 4000.0, 16000.0};
    for (unsigned i = 0U; i < 3U; i++) {
        begin_with_shear(stiffness[i]);
        press_at(0.25, 0.01);
        const plant_truth_t* truth = plant_truth(plant);
        const double before_n      = truth->contact[0].force_n[0];
        const double before_m      = touching_x(truth);
        glide(0.25, -0.04, 0.2495, -0.04); // The finger does not slide.
        rest();
        EXPECT_ABOVE(1.0e-4, before_m - touching_x(truth));
        EXPECT_WITHIN(stiffness[i], 0.01 * stiffness[i],
                      (truth->contact[0].force_n[0] - before_n) / (before_m - touching_x(truth)));
    }
}

static void an_elastic_contact_slides_at_the_same_friction(void)
{
    begin_with_shear(4000.0);
    press_at(0.22, 0.005);
    const plant_truth_t* truth = plant_truth(plant);
    for (unsigned i = 0U; i < 4000U; i++) {
        aim(0.22 + 0.05 * (double)i / 4000.0, -0.035);
        plant_step(plant, &input, STEP_NS);
        EXPECT_BELOW(0.303 * truth->contact[0].force_n[2] + 1e-6, fabs(truth->contact[0].force_n[0]));
    }
    EXPECT_WITHIN(-0.3 * truth->contact[0].force_n[2], 0.004 * truth->contact[0].force_n[2],
                  truth->contact[0].force_n[0]);
}

static void lifting_the_finger_removes_the_deflection(void)
{
    begin_with_shear(4000.0);
    press_at(0.25, 0.01);
    EXPECT_ABOVE(0.5, fabs(plant_truth(plant)->contact[0].force_n[0]));
    glide(0.25, -0.04, 0.25, -0.02);
    TEST_ASSERT_FALSE(plant_truth(plant)->contact[0].is_touching);
    EXPECT_WITHIN(0.0, 0.0, plant->contacts.pair[0].stretch_m[0]);
}

static void a_stiff_contact_equals_rigid_friction(void)
{
    double force[2];
    for (unsigned i = 0U; i < 2U; i++) {
        begin_with_shear((i == 0U) ? 0.0 : 1.0e7);
        press_at(0.25, 0.005);
        force[i] = plant_truth(plant)->contact[0].force_n[0];
    }
    EXPECT_WITHIN(force[0], 0.05, force[1]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_sticking_finger_is_held_by_a_spring_along_the_contour);
    RUN_TEST(an_elastic_contact_slides_at_the_same_friction);
    RUN_TEST(lifting_the_finger_removes_the_deflection);
    RUN_TEST(a_stiff_contact_equals_rigid_friction);
    return UNITY_END();
}
