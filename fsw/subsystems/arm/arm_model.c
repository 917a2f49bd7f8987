// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_model.h"

#include "base/assertion.h"

#include <stddef.h>

/// Returns the pose of a link relative to the previous link.
static arm_pose_t pose_in_previous(const arm_link_t* const link, const double angle_rad)
{
    if (link->is_prismatic) {
        const arm_vector_t shift = arm_rotated(&link->origin.rotation, arm_times(link->axis, angle_rad));
        return (arm_pose_t){.rotation   = link->origin.rotation,
                            .position_m = arm_sum(link->origin.position_m, shift)};
    }
    const arm_rotation_t turn = arm_rotation_about(link->axis, angle_rad);
    return (arm_pose_t){.rotation   = arm_product(&link->origin.rotation, &turn),
                        .position_m = link->origin.position_m};
}

void arm_kinematics(const arm_model_t* const model, const double angle_rad[ARM_JOINTS_MAX],
                    arm_kinematics_t* const out_kinematics)
{
    FSW_ASSERT((model != NULL) && (out_kinematics != NULL) && (model->joint_count >= 1U));
    for (unsigned i = 0U; i < model->joint_count; i++) {
        const arm_pose_t pose   = pose_in_previous(&model->link[i], angle_rad[i]);
        out_kinematics->link[i] = (i == 0U) ? pose : arm_composed(&out_kinematics->link[i - 1U], &pose);
        out_kinematics->axis[i] = arm_rotated(&out_kinematics->link[i].rotation, model->link[i].axis);
    }
    out_kinematics->tool = arm_composed(&out_kinematics->link[model->joint_count - 1U], &model->tool);
}

void arm_jacobian(const arm_model_t* const model, const arm_kinematics_t* const kinematics,
                  arm_jacobian_t* const out_jacobian)
{
    FSW_ASSERT((model != NULL) && (kinematics != NULL) && (out_jacobian != NULL));
    for (unsigned i = 0U; i < model->joint_count; i++) {
        const bool is_prismatic = model->link[i].is_prismatic;
        const arm_vector_t lever =
            arm_difference(kinematics->tool.position_m, kinematics->link[i].position_m);
        const arm_vector_t linear =
            is_prismatic ? kinematics->axis[i] : arm_cross(kinematics->axis[i], lever);
        for (unsigned k = 0U; k < 3U; k++) {
            out_jacobian->at[k][i]      = linear.at[k];
            out_jacobian->at[k + 3U][i] = is_prismatic ? 0.0 : kinematics->axis[i].at[k];
        }
    }
}

// ---- Dynamics: all vectors of link i are in its own axes ----

typedef struct {
    arm_pose_t pose;   // Pose relative to the previous link.
    arm_vector_t rate; // Angular velocity.
    arm_vector_t angular_acceleration;
    arm_vector_t acceleration; // Acceleration of the frame's origin, minus gravity.
    arm_vector_t force;        // Force on the link through its joint.
    arm_vector_t moment;
} body_t;

/// Returns the acceleration of a point of a body, computed from the acceleration of the origin of its frame.
static arm_vector_t acceleration_at(const body_t* const body, const arm_vector_t point)
{
    const arm_vector_t tangential  = arm_cross(body->angular_acceleration, point);
    const arm_vector_t centripetal = arm_cross(body->rate, arm_cross(body->rate, point));
    return arm_sum(body->acceleration, arm_sum(tangential, centripetal));
}

/// Compute the motion of a link from the motion of the previous link, and the force and moment that this
/// motion needs.
static void forward_recursion(const arm_link_t* const link, const body_t* const previous,
                              const arm_motion_t* const motion, const unsigned joint, body_t* const body)
{
    body->pose                          = pose_in_previous(link, motion->position_rad[joint]);
    const arm_rotation_t* const r       = &body->pose.rotation;
    const arm_vector_t carried          = arm_rotated_back(r, previous->rate);
    const arm_vector_t own              = arm_times(link->axis, motion->velocity_rad_s[joint]);
    const arm_vector_t own_acceleration = arm_times(link->axis, motion->acceleration_rad_s2[joint]);
    const arm_vector_t angular_carried  = arm_rotated_back(r, previous->angular_acceleration);
    const arm_vector_t origin_acceleration =
        arm_rotated_back(r, acceleration_at(previous, body->pose.position_m));
    if (link->is_prismatic) {
        const arm_vector_t coriolis = arm_times(arm_cross(carried, own), 2.0);
        body->rate                  = carried;
        body->angular_acceleration  = angular_carried;
        body->acceleration          = arm_sum(origin_acceleration, arm_sum(coriolis, own_acceleration));
    } else {
        body->rate = arm_sum(carried, own);
        body->angular_acceleration =
            arm_sum(arm_sum(angular_carried, arm_cross(carried, own)), own_acceleration);
        body->acceleration = origin_acceleration;
    }
    // The inertia is a matrix like a rotation, so arm_rotated multiplies by it.
    body->force                         = arm_times(acceleration_at(body, link->centre_m), link->mass_kg);
    const arm_vector_t angular_momentum = arm_rotated(&link->inertia_kgm2, body->rate);
    const arm_vector_t own_moment = arm_sum(arm_rotated(&link->inertia_kgm2, body->angular_acceleration),
                                            arm_cross(body->rate, angular_momentum));
    body->moment                  = arm_sum(own_moment, arm_cross(link->centre_m, body->force));
}

void arm_inverse_dynamics(const arm_model_t* const model, const arm_motion_t* const motion,
                          double out_torque_nm[ARM_JOINTS_MAX])
{
    FSW_ASSERT((model != NULL) && (motion != NULL));
    body_t bodies[ARM_JOINTS_MAX];
    // Gravity has the same effect as a base that accelerates upwards.
    const body_t base = {.acceleration = arm_times(model->gravity_m_s2, -1.0)};
    for (unsigned i = 0U; i < model->joint_count; i++) {
        forward_recursion(&model->link[i], (i == 0U) ? &base : &bodies[i - 1U], motion, i, &bodies[i]);
    }
    // Backwards: each joint carries its own link and all links after it.
    for (unsigned i = model->joint_count; i > 0U; i--) {
        const body_t* const body     = &bodies[i - 1U];
        const arm_link_t* const link = &model->link[i - 1U];
        out_torque_nm[i - 1U]        = arm_dot(link->is_prismatic ? body->force : body->moment, link->axis);
        if (i > 1U) {
            body_t* const previous    = &bodies[i - 2U];
            const arm_vector_t force  = arm_rotated(&body->pose.rotation, body->force);
            const arm_vector_t moment = arm_rotated(&body->pose.rotation, body->moment);
            previous->force           = arm_sum(previous->force, force);
            previous->moment =
                arm_sum(previous->moment, arm_sum(moment, arm_cross(body->pose.position_m, force)));
        }
    }
}
