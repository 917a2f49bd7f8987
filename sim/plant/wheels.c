// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <string.h>

static dBodyID body_of(const plant_t* const plant, const unsigned wheel)
{
    const mounted_wheel_t* own = &plant->wheel[wheel];
    return plant->robot[own->robot].body[own->body];
}

void wheel_axis(const plant_t* const plant, const unsigned wheel, double out_axis[3])
{
    const mounted_wheel_t* own = &plant->wheel[wheel];
    const dBodyID body         = body_of(plant, wheel);
    const pose_t base          = {.rotation = plant->robot[own->robot].base.rotation};
    dVector3 axis;
    if (body == NULL) {
        pose_apply(&base, own->axis, out_axis);
        return;
    }
    dBodyVectorToWorld(body, own->axis[0], own->axis[1], own->axis[2], axis);
    memcpy(out_axis, axis, 3U * sizeof(double));
}

void wheels_create(plant_t* const plant)
{
    for (unsigned i = 0U; i < plant->world->wheel_count; i++) {
        const world_wheel_t* wheel = &plant->world->wheel[i];
        const robot_frame_t* frame = &plant->world->robot[wheel->robot].model.frame[wheel->frame];
        const pose_t turn          = {.rotation = frame->pose.rotation};
        mounted_wheel_t* own       = &plant->wheel[i];
        double axis[3];
        own->robot = wheel->robot;
        own->body  = frame->body;
        pose_apply(&turn, wheel->axis, own->axis);
        wheel_axis(plant, i, axis);
        for (unsigned k = 0U; k < 3U; k++) {
            own->momentum_nms[k] = wheel->start * axis[k];
        }
        plant->truth.wheel[i].momentum_nms = wheel->start;
    }
    wheels_read(plant);
}

/// Turn `axis` by a small angle `turn`, to the second order.
static void turn_axis(const double turn[3], double axis[3])
{
    const double first[3]  = {turn[1] * axis[2] - turn[2] * axis[1], turn[2] * axis[0] - turn[0] * axis[2],
                              turn[0] * axis[1] - turn[1] * axis[0]};
    const double second[3] = {turn[1] * first[2] - turn[2] * first[1],
                              turn[2] * first[0] - turn[0] * first[2],
                              turn[0] * first[1] - turn[1] * first[0]};
    for (unsigned k = 0U; k < 3U; k++) {
        axis[k] += first[k] + 0.5 * second[k];
    }
}

/// Apply the torque of the wheel to its link: the change of the momentum vector up to the predicted direction
/// of the axis. The next step corrects an error of the prediction, so the total momentum does not drift.
static void apply_reaction(plant_t* const plant, const unsigned wheel, const double dt_s)
{
    mounted_wheel_t* own = &plant->wheel[wheel];
    const dBodyID body   = body_of(plant, wheel);
    double axis[3];
    double torque[3];
    if (body == NULL) {
        return;
    }
    const dReal* rate    = dBodyGetAngularVel(body);
    const double turn[3] = {rate[0] * dt_s, rate[1] * dt_s, rate[2] * dt_s};
    wheel_axis(plant, wheel, axis);
    turn_axis(turn, axis);
    for (unsigned k = 0U; k < 3U; k++) {
        const double wanted  = plant->truth.wheel[wheel].momentum_nms * axis[k];
        torque[k]            = (wanted - own->momentum_nms[k]) / dt_s;
        own->momentum_nms[k] = wanted;
    }
    dBodyAddTorque(body, -torque[0], -torque[1], -torque[2]);
}

void wheels_step(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    for (unsigned i = 0U; i < plant->world->wheel_count; i++) {
        const world_wheel_t* wheel = &plant->world->wheel[i];
        plant_wheel_t* truth       = &plant->truth.wheel[i];
        const double before        = truth->momentum_nms;
        const double commanded     = input->wheel_torque_nm[i] * (1.0 + wheel->gain_difference);
        const double torque        = fmax(-wheel->torque, fmin(wheel->torque, commanded));
        truth->momentum_nms        = fmax(-wheel->momentum, fmin(wheel->momentum, before + torque * dt_s));
        truth->torque_nm           = (truth->momentum_nms - before) / dt_s;
        apply_reaction(plant, i, dt_s);
    }
}

void wheels_read(plant_t* const plant)
{
    for (unsigned i = 0U; i < plant->world->wheel_count; i++) {
        const dBodyID body = body_of(plant, i);
        double axis[3];
        if (body != NULL) {
            const dReal* rate = dBodyGetAngularVel(body);
            wheel_axis(plant, i, axis);
            plant->truth.wheel[i].housing_rad_s = axis[0] * rate[0] + axis[1] * rate[1] + axis[2] * rate[2];
        }
    }
}
