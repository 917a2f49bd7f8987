// SPDX-License-Identifier: Apache-2.0
// Compares the terms of the model with derivatives of the kinetic and the potential energy. The test computes
// both energies only from the positions of the centres of mass.
#include "fsw/subsystems/manipulator/manipulator_model.h"
#include "test/support/bounds.h"

#include "unity.h"

#include <math.h>

#define STEP 1.0e-5

static const manipulator_model_t model = {.link_length   = {0.22, 0.25},
                                          .link_mass     = {3.0, 2.0},
                                          .link_centre   = {0.11, 0.125},
                                          .link_inertia  = {0.0121, 0.0104166666667},
                                          .rotor_inertia = {0.25, 0.25},
                                          .stiffness     = {8000.0, 8000.0},
                                          .coulomb       = {2.0, 2.0},
                                          .viscous       = {1.0, 1.0},
                                          .gravity       = 9.81};

void setUp(void)
{
}

void tearDown(void)
{
}

typedef struct {
    double x[2];
    double z[2];
} centres_t;

static centres_t centres(const double q[2])
{
    const double elbow_x = model.link_length[0] * cos(q[0]);
    const double elbow_z = model.link_length[0] * sin(q[0]);
    return (centres_t){
        .x = {model.link_centre[0] * cos(q[0]), elbow_x + (model.link_centre[1] * cos(q[0] + q[1]))},
        .z = {model.link_centre[0] * sin(q[0]), elbow_z + (model.link_centre[1] * sin(q[0] + q[1]))}};
}

static double potential(const double q[2])
{
    const centres_t at = centres(q);
    return model.gravity * ((model.link_mass[0] * at.z[0]) + (model.link_mass[1] * at.z[1]));
}

/// Kinetic energy at velocity v; velocities of the centres of mass are differences of their positions.
static double kinetic(const double q[2], const double v[2])
{
    const double ahead[2]  = {q[0] + (STEP * v[0]), q[1] + (STEP * v[1])};
    const double behind[2] = {q[0] - (STEP * v[0]), q[1] - (STEP * v[1])};
    const centres_t a      = centres(ahead);
    const centres_t b      = centres(behind);
    const double turn[2]   = {v[0], v[0] + v[1]};
    double energy          = 0.0;
    for (unsigned i = 0U; i < 2U; i++) {
        const double vx = (a.x[i] - b.x[i]) / (2.0 * STEP);
        const double vz = (a.z[i] - b.z[i]) / (2.0 * STEP);
        energy += 0.5 * ((model.link_mass[i] * ((vx * vx) + (vz * vz))) +
                         (model.link_inertia[i] * turn[i] * turn[i]));
    }
    return energy;
}

/// Kinetic energy by the mass matrix of the model, v M v / 2.
static double kinetic_by_model(const manipulator_arm_terms_t* const terms, const double v[2])
{
    double product[2];
    manipulator_arm_inertia_times(terms, v, product);
    return 0.5 * ((v[0] * product[0]) + (v[1] * product[1]));
}

typedef void (*check_t)(const double q[2], const double v[2]);

static void in_many_poses(const check_t check)
{
    for (double q1 = -1.0; q1 <= 3.0; q1 += 0.37) {
        for (double q2 = -3.0; q2 <= 0.5; q2 += 0.41) {
            const double q[2]     = {q1, q2};
            const double v1[2]    = {0.8, -1.3};
            const double v2[2]    = {-0.4, 0.9};
            const double still[2] = {0.0, 0.0};
            check(q, v1);
            check(q, v2);
            check(q, still);
        }
    }
}

static void check_kinetic(const double q[2], const double v[2])
{
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&model, q);
    EXPECT_WITHIN(kinetic(q, v), 1.0e-8, kinetic_by_model(&terms, v));
    // The mass matrix is positive definite.
    EXPECT_ABOVE(0.0, (terms.m11 * terms.m22) - (terms.m12 * terms.m12));
}

static void check_gravity(const double q[2], const double v[2])
{
    (void)v;
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&model, q);
    for (unsigned i = 0U; i < 2U; i++) {
        double ahead[2]  = {q[0], q[1]};
        double behind[2] = {q[0], q[1]};
        ahead[i] += STEP;
        behind[i] -= STEP;
        EXPECT_WITHIN((potential(ahead) - potential(behind)) / (2.0 * STEP), 1.0e-7, terms.gravity_nm[i]);
    }
}

/// Time derivative of M v at constant v, and gradient of the kinetic energy.
static void differentiate(const double q[2], const double v[2], double rate[2], double gradient[2])
{
    const double ahead[2]           = {q[0] + (STEP * v[0]), q[1] + (STEP * v[1])};
    const double behind[2]          = {q[0] - (STEP * v[0]), q[1] - (STEP * v[1])};
    const manipulator_arm_terms_t a = manipulator_arm_terms(&model, ahead);
    const manipulator_arm_terms_t b = manipulator_arm_terms(&model, behind);
    double pa[2];
    double pb[2];
    manipulator_arm_inertia_times(&a, v, pa);
    manipulator_arm_inertia_times(&b, v, pb);
    for (unsigned i = 0U; i < 2U; i++) {
        double plus[2]  = {q[0], q[1]};
        double minus[2] = {q[0], q[1]};
        plus[i] += STEP;
        minus[i] -= STEP;
        const manipulator_arm_terms_t p = manipulator_arm_terms(&model, plus);
        const manipulator_arm_terms_t m = manipulator_arm_terms(&model, minus);
        rate[i]                         = (pa[i] - pb[i]) / (2.0 * STEP);
        gradient[i]                     = (kinetic_by_model(&p, v) - kinetic_by_model(&m, v)) / (2.0 * STEP);
    }
}

static void check_coriolis(const double q[2], const double v[2])
{
    // Lagrange, with the kinetic energy E: C v = d/dt (M v) - dE/dq. At constant v, d/dt (M v) = (C + C^T) v,
    // so that C^T v = dE/dq.
    double rate[2];
    double gradient[2];
    double forward[2];
    double transposed[2];
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&model, q);
    differentiate(q, v, rate, gradient);
    manipulator_arm_coriolis(&terms, v, forward);
    manipulator_arm_coriolis_transposed(&terms, v, transposed);
    for (unsigned i = 0U; i < 2U; i++) {
        EXPECT_WITHIN(rate[i] - gradient[i], 1.0e-7, forward[i]);
        EXPECT_WITHIN(gradient[i], 1.0e-7, transposed[i]);
    }
}

static void the_mass_matrix_gives_the_kinetic_energy(void)
{
    in_many_poses(check_kinetic);
}

static void gravity_is_the_gradient_of_the_potential_energy(void)
{
    in_many_poses(check_gravity);
}

static void velocity_terms_follow_from_the_mass_matrix(void)
{
    in_many_poses(check_coriolis);
}

static void the_home_pose_needs_the_expected_holding_torques(void)
{
    const double home[2]                = {1.0471975511966, -1.5707963267949};
    const manipulator_arm_terms_t terms = manipulator_arm_terms(&model, home);
    EXPECT_WITHIN(5.9, 0.05, terms.gravity_nm[0]); // Computed by hand: 1.62 + 2.16 + 2.12 Nm.
    EXPECT_WITHIN(2.124, 0.001, terms.gravity_nm[1]);
    double product[2] = {1.0, 0.0};
    manipulator_arm_inertia_times(&terms, product, product); // The result may replace the input.
    EXPECT_WITHIN(terms.m11, 0.0, product[0]);
    EXPECT_WITHIN(terms.m12, 0.0, product[1]);
}

static void tip(const double q[2], double out[2])
{
    out[0] = (model.link_length[0] * cos(q[0])) + (model.link_length[1] * cos(q[0] + q[1]));
    out[1] = (model.link_length[0] * sin(q[0])) + (model.link_length[1] * sin(q[0] + q[1]));
}

static void the_jacobian_is_the_derivative_of_the_tip(void)
{
    for (double first = -1.2; first < 1.5; first += 0.3) {
        for (unsigned joint = 0U; joint < 2U; joint++) {
            const double q[2]      = {first, 0.7 - (2.0 * first)};
            const double ahead[2]  = {q[0] + ((joint == 0U) ? STEP : 0.0),
                                      q[1] + ((joint == 1U) ? STEP : 0.0)};
            const double behind[2] = {q[0] - ((joint == 0U) ? STEP : 0.0),
                                      q[1] - ((joint == 1U) ? STEP : 0.0)};
            double a[2];
            double b[2];
            double jacobian[4];
            tip(ahead, a);
            tip(behind, b);
            manipulator_arm_jacobian(&model, q, jacobian);
            EXPECT_WITHIN((a[0] - b[0]) / (2.0 * STEP), 1.0e-9, jacobian[joint]);
            EXPECT_WITHIN((a[1] - b[1]) / (2.0 * STEP), 1.0e-9, jacobian[2U + joint]);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_mass_matrix_gives_the_kinetic_energy);
    RUN_TEST(gravity_is_the_gradient_of_the_potential_energy);
    RUN_TEST(velocity_terms_follow_from_the_mass_matrix);
    RUN_TEST(the_home_pose_needs_the_expected_holding_torques);
    RUN_TEST(the_jacobian_is_the_derivative_of_the_tip);
    return UNITY_END();
}
