// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <string.h>

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/// Add the gyroscopic torque of a body. A step turns the body by its rate at the end of the step. Only if the
/// torque is computed for this rate, the momentum is constant to second order in the step. ODE computes its
/// torque for the rate before the step, and the errors add up. This function extrapolates the rate at the end
/// of the step from the last two rates. In the axes of the body, the momentum h must turn back by the
/// rotation R of the step: the torque is (h - R h) / dt, here up to the second order of R.
static void add_gyroscopic_torque(const dBodyID body, double before_rad_s[3], const double dt_s)
{
    const dReal* now = dBodyGetAngularVel(body);
    dVector3 rate;
    double momentum[3];
    double first[3];
    double second[3];
    dMass mass;
    dBodyGetMass(body, &mass);
    dBodyVectorFromWorld(body, 2.0 * now[0] - before_rad_s[0], 2.0 * now[1] - before_rad_s[1],
                         2.0 * now[2] - before_rad_s[2], rate);
    for (size_t i = 0U; i < 3U; i++) {
        const dReal* row = &mass.I[4U * i];
        momentum[i]      = row[0] * rate[0] + row[1] * rate[1] + row[2] * rate[2];
    }
    cross(rate, momentum, first);
    cross(rate, first, second);
    dBodyAddRelTorque(body, -(first[0] + 0.5 * dt_s * second[0]), -(first[1] + 0.5 * dt_s * second[1]),
                      -(first[2] + 0.5 * dt_s * second[2]));
    memcpy(before_rad_s, now, 3U * sizeof(double));
}

void robots_add_gyroscopic_torques(plant_t* const plant, const double dt_s)
{
    for (size_t r = 0U; r < plant->world->robot_count; r++) {
        const world_robot_t* robot = &plant->world->robot[r];
        robot_t* own               = &plant->robot[r];
        for (size_t i = 0U; robot->is_free && (i <= robot->model.joint_count); i++) {
            add_gyroscopic_torque(own->body[i], own->before_rad_s[i], dt_s);
        }
    }
}

void robots_forget_rates(plant_t* const plant)
{
    for (size_t r = 0U; r < plant->world->robot_count; r++) {
        const world_robot_t* robot = &plant->world->robot[r];
        robot_t* own               = &plant->robot[r];
        for (size_t i = 0U; robot->is_free && (i <= robot->model.joint_count); i++) {
            memcpy(own->before_rad_s[i], dBodyGetAngularVel(own->body[i]), sizeof own->before_rad_s[i]);
        }
    }
}
