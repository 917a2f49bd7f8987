// SPDX-License-Identifier: Apache-2.0
// Compares the plant with independent computations: a planar elastic arm that is integrated by Runge-Kutta,
// and the momentum of a free-floating robot.
#include "sim/plant/parameters.h"
#include "sim/plant/plant.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "test/unit/sim/plant/plant_state.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define JOINTS 2U
#define HALF_TURN 3.14159265358979323846

static uint64_t now_ns;  // Time of the plant under test.
static uint64_t step_ns; // Duration of its steps.

void setUp(void)
{
    now_ns  = 0U;
    step_ns = 500000U;
}

void tearDown(void)
{
}

// ---- An elastic arm in a plane ----

static world_t world;
static plant_drive_t drive; // Drive of all joints.

static plant_t* plant_in_world(void)
{
    char error[DOCUMENT_ERROR_MAX];
    plant_t* plant = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    return plant;
}

/// The mission's arm hangs down, without dry friction (which no Runge-Kutta method can follow) and without
/// obstacles.
static void hang_arm(void)
{
    world                        = rokviss()->world;
    world.robot[0].start[0]      = -HALF_TURN / 2.0;
    world.robot[0].start[1]      = 0.0;
    world.contact_count          = 0U;
    world.spring_count           = 0U;
    world.drive_type[0].coulomb  = 0.0;
    world.drive_type[0].stiction = 0.0;
    for (unsigned i = 0U; i < JOINTS; i++) {
        world.robot[0].model.joint[i].kind = ROBOT_JOINT_CONTINUOUS;
    }
    drive = plant_drive_of(&world.drive_type[0], 0.0, 0.0);
}

static void prescribed(double time_s, double torque_nm[JOINTS])
{
    torque_nm[0] = 4.0 * sin(2.1 * time_s) + 1.5 * sin(5.3 * time_s);
    torque_nm[1] = 1.5 * sin(3.7 * time_s) - 1.0 * cos(1.1 * time_s);
}

static void drive_prescribed(void* context, unsigned substep, const plant_rotor_t* motor,
                             double* out_torque_nm)
{
    (void)context;
    (void)motor;
    prescribed(((double)now_ns + (double)step_ns * substep / PLANT_SUBSTEPS) * 1.0e-9, out_torque_nm);
}

#define STATES 8 // q1 q2 th1 th2 and their rates.

/// Lagrange's equations of two rods with elastic gears; the acceleration of the second rotor acts on the
/// first link.
static void derivative(double time_s, const double y[STATES], double dy[STATES])
{
    const robot_model_t* arm = &world.robot[0].model;
    const double gravity     = -world.gravity[2];
    const double l1          = arm->joint[1].origin.position_m[0];
    const double c1          = arm->body[1].com_m[0];
    const double c2          = arm->body[2].com_m[0];
    const double m1          = arm->body[1].mass_kg;
    const double m2          = arm->body[2].mass_kg;
    const double i1          = arm->body[1].inertia_kgm2.at[1][1];
    const double m22         = arm->body[2].inertia_kgm2.at[1][1] + m2 * c2 * c2;
    const double m12         = m22 + m2 * l1 * c2 * cos(y[1]);
    const double m11         = i1 + m1 * c1 * c1 + m22 + m2 * (l1 * l1 + 2.0 * l1 * c2 * cos(y[1]));
    const double h           = m2 * l1 * c2 * sin(y[1]);
    const double g2          = m2 * gravity * c2 * cos(y[0] + y[1]);
    const double g1          = (m1 * c1 + m2 * l1) * gravity * cos(y[0]) + g2;

    double motor[JOINTS];
    double gear[JOINTS];
    double spin[JOINTS];
    prescribed(time_s, motor);
    for (unsigned i = 0U; i < JOINTS; i++) {
        gear[i] = drive.gear_stiffness_nm_rad * (y[2U + i] - y[i]) +
                  drive.gear_damping_nms_rad * (y[6U + i] - y[4U + i]);
        spin[i] = (motor[i] - gear[i] - drive.viscous_nms_rad * y[6U + i]) / drive.rotor_inertia_kgm2;
    }
    const double r1 = gear[0] + h * (2.0 * y[4] * y[5] + y[5] * y[5]) - g1 -
                      drive.rotor_inertia_kgm2 / drive.gear_ratio * spin[1];
    const double r2  = gear[1] - h * y[4] * y[4] - g2;
    const double det = m11 * m22 - m12 * m12;
    memcpy(dy, &y[4], 4U * sizeof(double));
    dy[4] = (m22 * r1 - m12 * r2) / det;
    dy[5] = (m11 * r2 - m12 * r1) / det;
    dy[6] = spin[0];
    dy[7] = spin[1];
}

static void runge_kutta(double time_s, double h, double y[STATES])
{
    double k[4][STATES];
    double z[STATES];
    derivative(time_s, y, k[0]);
    for (unsigned stage = 1U; stage < 4U; stage++) {
        const double reach = (stage == 3U) ? h : h / 2.0;
        for (unsigned i = 0U; i < STATES; i++) {
            z[i] = y[i] + reach * k[stage - 1U][i];
        }
        derivative(time_s + reach, z, k[stage]);
    }
    for (unsigned i = 0U; i < STATES; i++) {
        y[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    }
}

typedef struct {
    double worst_rad;
    double rms_rad;
    double travel_rad;
} deviation_t;

/// Run plant and reference together under the prescribed torques.
static deviation_t deviation(uint64_t dt_ns, uint64_t duration_ns)
{
    hang_arm();
    const double* home        = world.robot[0].start;
    const plant_input_t input = {.drive = drive_prescribed};
    plant_t* const plant      = plant_in_world();
    double y[STATES]          = {home[0], home[1], home[0], home[1]};
    deviation_t result        = {0.0, 0.0, 0.0};
    double samples            = 0.0;

    now_ns  = 0U;
    step_ns = dt_ns;
    while (now_ns < duration_ns) {
        plant_step(plant, &input, dt_ns);
        for (unsigned part = 0U; part < dt_ns / 25000U; part++) {
            runge_kutta((double)now_ns * 1.0e-9 + part * 25.0e-6, 25.0e-6, y);
        }
        now_ns += dt_ns;
        for (unsigned i = 0U; i < JOINTS; i++) {
            const double error = fabs(plant_truth(plant)->link_position_rad[i] - y[i]);
            result.worst_rad   = fmax(result.worst_rad, error);
            result.travel_rad  = fmax(result.travel_rad, fabs(y[i] - home[i]));
            result.rms_rad += error * error;
            samples += 1.0;
        }
    }
    result.rms_rad = sqrt(result.rms_rad / samples);
    plant_destroy(plant);
    return result;
}

static void elastic_arm_follows_the_equations_of_motion(void)
{
    const deviation_t found = deviation(500000U, 10000000000U);
    printf("10 s at 0.5 ms: worst %.2e rad, rms %.2e rad, travel %.2f rad\n", found.worst_rad, found.rms_rad,
           found.travel_rad);
    EXPECT_ABOVE(0.5, found.travel_rad);
    EXPECT_BELOW(1.0e-3, found.worst_rad);
    EXPECT_BELOW(5.0e-4, found.rms_rad);
}

static void the_error_decreases_with_the_step(void)
{
    // A semi-implicit scheme is of first order: half the step gives half the error.
    const deviation_t coarse = deviation(500000U, 2000000000U);
    const deviation_t fine   = deviation(250000U, 2000000000U);
    EXPECT_WITHIN(0.5, 0.1, fine.rms_rad / coarse.rms_rad);
}

// ---- A robot in free fall ----

static void drive_swinging(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    const double time_s = (double)now_ns * 1.0e-9;
    for (unsigned i = 0U; i < JOINTS; i++) {
        const double wanted = rokviss()->scene.home_rad[i] + 0.5 * sin((0.7 + 0.4 * i) * time_s);
        out_torque_nm[i]    = 400.0 * (wanted - motor[i].position_rad) - 20.0 * motor[i].velocity_rad_s;
    }
}

/// The mission's arm on a free base, far from all obstacles.
static void float_arm(void)
{
    world                  = rokviss()->world;
    world.robot[0].is_free = true;
    world.contact_count    = 0U;
    world.spring_count     = 0U;
    memset(world.gravity, 0, sizeof world.gravity);
}

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void momentum_is_conserved_without_gravity(void)
{
    float_arm();
    robot_mass_t* base = &world.robot[0].model.body[0];
    base->mass_kg      = 150.0;
    for (unsigned i = 0U; i < 3U; i++) {
        base->inertia_kgm2.at[i][i] = 15.0;
    }
    // The base tumbles about all axes, so that the rotors act on their parents, and moves away.
    memcpy(world.robot[0].velocity_m_s, (const double[3]){1e-3, -2e-3, 1e-3}, 3U * sizeof(double));
    memcpy(world.robot[0].rate_rad_s, (const double[3]){0.01, 0.02, -0.01}, 3U * sizeof(double));
    const plant_input_t input = {.drive = drive_swinging};
    plant_t* const plant      = plant_in_world();
    double p0[3];
    double l0[3];
    double worst_linear  = 0.0;
    double worst_angular = 0.0;

    plant_momentum(plant, p0, l0);
    for (unsigned step = 0U; step < 120000U; step++) { // 60 s
        plant_step(plant, &input, step_ns);
        now_ns += step_ns;
        double p[3];
        double l[3];
        plant_momentum(plant, p, l);
        for (unsigned i = 0U; i < 3U; i++) {
            p[i] -= p0[i];
            l[i] -= l0[i];
        }
        worst_linear  = fmax(worst_linear, length(p));
        worst_angular = fmax(worst_angular, length(l));
    }
    plant_destroy(plant);
    printf("60 s tumbling: |dP| %.1e Ns, |dL|/|L| %.1e\n", worst_linear, worst_angular / length(l0));
    EXPECT_BELOW(1.0e-10, worst_linear);
    EXPECT_BELOW(1.0e-3, worst_angular / length(l0));
}

static void total_momentum_stays_zero_while_an_arm_swings(void)
{
    // The robot starts at rest: its angular momentum stays zero whatever the arm does, so the base must turn
    // in the other direction.
    float_arm();
    const plant_input_t input = {.drive = drive_swinging};
    plant_t* const plant      = plant_in_world();
    double linear[3];
    double angular[3];
    for (unsigned step = 0U; step < 4000U; step++) {
        plant_step(plant, &input, step_ns);
        now_ns += step_ns;
    }
    plant_momentum(plant, linear, angular);
    EXPECT_ABOVE(0.05, fabs(plant_truth(plant)->link_velocity_rad_s[0]));
    EXPECT_BELOW(1.0e-12, length(linear));
    EXPECT_BELOW(1.0e-5, length(angular));
    plant_destroy(plant);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(elastic_arm_follows_the_equations_of_motion);
    RUN_TEST(the_error_decreases_with_the_step);
    RUN_TEST(momentum_is_conserved_without_gravity);
    RUN_TEST(total_momentum_stays_zero_while_an_arm_swings);
    return UNITY_END();
}
