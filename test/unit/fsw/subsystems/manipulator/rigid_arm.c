// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/subsystems/manipulator/rigid_arm.h"

#include <math.h>

#define STEPS 20U
#define STEP_S 0.000025
#define DAMPING_NMS_RAD 8.0

const manipulator_control_t rigid_arm_gains = {.kp                  = {4000.0, 4000.0},
                                               .kd                  = {100.0, 100.0},
                                               .reference_bandwidth = 125.0,
                                               .velocity_bandwidth  = 1250.0,
                                               .observer_bandwidth  = 500.0,
                                               .observer_gain       = 400.0,
                                               .friction_share      = 0.8,
                                               .torque_ceiling      = {40.0, 40.0},
                                               .position_scale      = 2.0,
                                               .home                = {1.0471975511966, -1.5707963267949},
                                               .range               = {1.5, 1.5},
                                               .speed_limit         = 1.0,
                                               .tare_time           = 0.7,
                                               .tare_ceiling        = 1.0,
                                               .fade_time           = 0.25,
                                               .compliance          = 0.001,
                                               .compliance_corner   = 50.0};

const manipulator_model_t rigid_arm_model = {.link_length   = {0.22, 0.25},
                                             .link_mass     = {3.0, 2.0},
                                             .link_centre   = {0.11, 0.125},
                                             .link_inertia  = {0.0121, 0.0104166666667},
                                             .rotor_inertia = {0.25, 0.25},
                                             .stiffness     = {8000.0, 8000.0},
                                             .coulomb       = {0.0, 0.0},
                                             .viscous       = {1.0, 1.0},
                                             .gravity       = 9.81};

static void gravity(const rigid_arm_t* const arm, double out_nm[2])
{
    const manipulator_model_t* const m = &arm->model;
    const double lower = m->link_mass[1] * m->gravity * m->link_centre[1] * cos(arm->link[0] + arm->link[1]);
    const double upper = ((m->link_mass[0] * m->link_centre[0]) + (m->link_mass[1] * m->link_length[0])) *
                         m->gravity * cos(arm->link[0]);
    out_nm[0] = upper + lower;
    out_nm[1] = lower;
}

void rigid_arm_init(rigid_arm_t* const arm, const manipulator_model_t* const model, const double pose_rad[2])
{
    *arm = (rigid_arm_t){.model = *model, .link = {pose_rad[0], pose_rad[1]}};
    double load[2];
    gravity(arm, load);
    for (unsigned i = 0U; i < 2U; i++) {
        arm->motor[i] = arm->link[i] + (load[i] / model->stiffness[i]);
    }
}

void rigid_arm_sensors(const rigid_arm_t* const arm, double out_torque_nm[2])
{
    for (unsigned i = 0U; i < 2U; i++) {
        out_torque_nm[i] = (arm->model.stiffness[i] * (arm->motor[i] - arm->link[i])) +
                           (DAMPING_NMS_RAD * (arm->motor_speed[i] - arm->link_speed[i]));
    }
}

static void accelerate_links(rigid_arm_t* const arm, const double gear_nm[2])
{
    const manipulator_model_t* const m = &arm->model;
    const double k                     = m->link_mass[1] * m->link_length[0] * m->link_centre[1];
    const double outer = m->link_inertia[1] + (m->link_mass[1] * m->link_centre[1] * m->link_centre[1]);
    const double inner = m->link_inertia[0] + (m->link_mass[0] * m->link_centre[0] * m->link_centre[0]) +
                         (m->link_mass[1] * m->link_length[0] * m->link_length[0]);
    const double c   = cos(arm->link[1]);
    const double s   = sin(arm->link[1]);
    const double m11 = inner + outer + (2.0 * k * c);
    const double m12 = outer + (k * c);
    const double v1  = arm->link_speed[0];
    const double v2  = arm->link_speed[1];
    double load[2];
    gravity(arm, load);
    const double f1  = gear_nm[0] + arm->external_nm[0] - load[0] + (k * s * ((2.0 * v1 * v2) + (v2 * v2)));
    const double f2  = gear_nm[1] + arm->external_nm[1] - load[1] - (k * s * v1 * v1);
    const double det = (m11 * outer) - (m12 * m12);
    arm->link_speed[0] += STEP_S * ((outer * f1) - (m12 * f2)) / det;
    arm->link_speed[1] += STEP_S * ((m11 * f2) - (m12 * f1)) / det;
}

void rigid_arm_run(rigid_arm_t* const arm, const double torque_nm[2])
{
    for (unsigned step = 0U; step < STEPS; step++) {
        double gear[2];
        rigid_arm_sensors(arm, gear);
        accelerate_links(arm, gear);
        for (unsigned i = 0U; i < 2U; i++) {
            const double friction = arm->model.viscous[i] * arm->motor_speed[i];
            arm->motor_speed[i]   = arm->is_braked
                                        ? 0.0
                                        : (arm->motor_speed[i] + (STEP_S * (torque_nm[i] - gear[i] - friction) /
                                                                arm->model.rotor_inertia[i]));
            arm->motor[i] += STEP_S * arm->motor_speed[i];
            arm->link[i] += STEP_S * arm->link_speed[i];
        }
    }
}
