// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <string.h>

#define NS_PER_S 1.0e9
#define STEP_S 1e-3 // Largest step of the integration back to time 0.
#define NUMBERS 12U ///< Numbers of a state: the rows of the rotation, and the rate in the body.

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void apply(const matrix_t* const matrix, const double vector[3], double out[3])
{
    const pose_t pose = {.rotation = *matrix};
    pose_apply(&pose, vector, out);
}

static matrix_t inverse(const matrix_t* const m)
{
    matrix_t found;
    double minor[3];
    cross(m->at[1], m->at[2], minor);
    const double determinant = m->at[0][0] * minor[0] + m->at[0][1] * minor[1] + m->at[0][2] * minor[2];
    for (unsigned i = 0U; i < 3U; i++) {
        cross(m->at[(i + 1U) % 3U], m->at[(i + 2U) % 3U], minor);
        for (unsigned k = 0U; k < 3U; k++) {
            found.at[k][i] = minor[k] / determinant;
        }
    }
    return found;
}

/// Rates of change of rotation and rate of a rigid body without torque.
static void rates_of(const robot_mass_t* const mass, const matrix_t* const back, const double state[NUMBERS],
                     double out[NUMBERS])
{
    const double* rate = &state[9];
    double momentum[3];
    double torque[3];
    for (unsigned i = 0U; i < 3U; i++) {
        cross(&state[(size_t)3U * i], rate, &out[(size_t)3U * i]); // Row i of R [rate x].
    }
    apply(&mass->inertia_kgm2, rate, momentum);
    cross(momentum, rate, torque);
    apply(back, torque, &out[9]);
}

/// Perform one step of the Runge-Kutta method.
static void advance(const robot_mass_t* const mass, const matrix_t* const back, const double h_s,
                    double state[NUMBERS])
{
    static const double at[4]     = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    double slope[NUMBERS]         = {0.0};
    double sum[NUMBERS]           = {0.0};
    for (unsigned stage = 0U; stage < 4U; stage++) {
        double there[NUMBERS];
        for (unsigned i = 0U; i < NUMBERS; i++) {
            there[i] = state[i] + at[stage] * h_s * slope[i];
        }
        rates_of(mass, back, there, slope);
        for (unsigned i = 0U; i < NUMBERS; i++) {
            sum[i] += weight[stage] * slope[i];
        }
    }
    for (unsigned i = 0U; i < NUMBERS; i++) {
        state[i] += h_s * sum[i];
    }
}

void robot_start(const plant_t* const plant, const unsigned index, robot_start_t* const out_start)
{
    const world_robot_t* robot = &plant->world->robot[index];
    const robot_mass_t* mass   = &robot->model.body[0];
    const double* gravity      = plant->world->gravity;
    const double time_s        = robot->valid_ns / NS_PER_S;
    const unsigned steps       = (unsigned)ceil(time_s / STEP_S);
    double state[NUMBERS];
    double arm[3];
    double turn[3];
    *out_start = (robot_start_t){.pose = robot->pose};
    memcpy(out_start->velocity_m_s, robot->velocity_m_s, sizeof out_start->velocity_m_s);
    memcpy(out_start->rate_rad_s, robot->rate_rad_s, sizeof out_start->rate_rad_s);
    if (steps == 0U) {
        return;
    }
    // Backwards in time, the centre of mass falls freely, and the body turns about it without torque.
    const matrix_t back = inverse(&mass->inertia_kgm2);
    const matrix_t into = inverse(&robot->pose.rotation);
    memcpy(state, robot->pose.rotation.at, sizeof robot->pose.rotation.at);
    apply(&into, robot->rate_rad_s, &state[9]);
    for (unsigned i = 0U; i < steps; i++) {
        advance(mass, &back, -time_s / (double)steps, state);
    }
    apply(&robot->pose.rotation, mass->com_m, arm);
    cross(robot->rate_rad_s, arm, turn);
    memcpy(out_start->pose.rotation.at, state, sizeof out_start->pose.rotation.at);
    for (unsigned i = 0U; i < 3U; i++) {
        const double speed         = robot->velocity_m_s[i] + turn[i];
        out_start->velocity_m_s[i] = speed - gravity[i] * time_s;
        out_start->pose.position_m[i] += arm[i] - speed * time_s + 0.5 * gravity[i] * time_s * time_s;
    }
    apply(&out_start->pose.rotation, &state[9], out_start->rate_rad_s);
    apply(&out_start->pose.rotation, mass->com_m, arm);
    cross(out_start->rate_rad_s, arm, turn);
    for (unsigned i = 0U; i < 3U; i++) {
        out_start->velocity_m_s[i] -= turn[i];
        out_start->pose.position_m[i] -= arm[i];
    }
}
