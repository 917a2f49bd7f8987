// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_state.h"

#include "sim/world/world_internal.h"

#include <math.h>
#include <string.h>

#define VALID_MAX_NS 1e12

typedef struct {
    double at[3];
    double rpy[3];
    double velocity[3];
    double rate[3];
    double valid_ns;
    char relative_to[DOCUMENT_TEXT_MAX];
} state_t;

/// Pose of the body that a joint moves, in the frame of the joint, at the start position of the joint.
static pose_t moved(const robot_joint_t* const joint, const double position)
{
    const double* a = joint->axis;
    const double c  = cos(position);
    const double s  = sin(position);
    const double d  = 1.0 - c;
    pose_t pose     = pose_of((const double[3]){0.0}, (const double[3]){0.0});
    if (joint->kind == ROBOT_JOINT_PRISMATIC) {
        for (unsigned i = 0U; i < 3U; i++) {
            pose.position_m[i] = a[i] * position;
        }
        return pose;
    }
    pose.rotation =
        (matrix_t){{{c + d * a[0] * a[0], d * a[0] * a[1] - s * a[2], d * a[0] * a[2] + s * a[1]},
                    {d * a[0] * a[1] + s * a[2], c + d * a[1] * a[1], d * a[1] * a[2] - s * a[0]},
                    {d * a[0] * a[2] - s * a[1], d * a[1] * a[2] + s * a[0], c + d * a[2] * a[2]}}};
    return pose;
}

/// Pose of a frame of a robot in the world, at time 0.
static pose_t frame_at_start(const world_robot_t* const robot, const unsigned frame)
{
    pose_t body[ROBOT_BODIES_MAX] = {robot->pose};
    for (unsigned i = 0U; i < robot->model.joint_count; i++) {
        const robot_joint_t* joint = &robot->model.joint[i];
        const pose_t before        = pose_compose(&body[joint->parent], &joint->origin);
        const pose_t motion        = moved(joint, robot->start[i]);
        body[i + 1U]               = pose_compose(&before, &motion);
    }
    const robot_frame_t* found = &robot->model.frame[frame];
    return pose_compose(&body[found->body], &found->pose);
}

/// Convert a state that is relative to a link of an earlier robot into the axes of the world.
static status_t place_relative(const world_t* const world, const element_t* const element,
                               const state_t* const state, world_robot_t* const robot)
{
    unsigned other        = 0U;
    unsigned frame        = 0U;
    const status_t status = world_find_frame(world, element, state->relative_to, &other, &frame);
    if ((status != STATUS_OK) || (&world->robot[other] == robot) || (world->robot[other].valid_ns > 0.0)) {
        return element_refuse(element, state->relative_to,
                              "robot.link of another robot above, whose State is valid at time 0");
    }
    const pose_t origin = frame_at_start(&world->robot[other], frame);
    const pose_t axes   = {.rotation = origin.rotation};
    robot->pose         = pose_compose(&origin, &robot->pose);
    pose_apply(&axes, state->velocity, robot->velocity_m_s);
    pose_apply(&axes, state->rate, robot->rate_rad_s);
    return STATUS_OK;
}

status_t world_take_state(world_t* const world, const element_t* const element)
{
    static const field_t fields[] = {
        {"at", FIELD_VECTOR, offsetof(state_t, at), -FAR_M, FAR_M, true},
        {"rpy", FIELD_VECTOR, offsetof(state_t, rpy), -TURNS_RAD, TURNS_RAD, true},
        {"velocity", FIELD_VECTOR, offsetof(state_t, velocity), -FAR_M, FAR_M, true},
        {"rate", FIELD_VECTOR, offsetof(state_t, rate), -TURNS_RAD, TURNS_RAD, true},
        {"valid", FIELD_TIME, offsetof(state_t, valid_ns), 0.0, VALID_MAX_NS, true},
        {"relativeTo", FIELD_TEXT, offsetof(state_t, relative_to), 0.0, 0.0, true}};
    world_robot_t* robot  = &world->robot[world->robot_count - 1U];
    state_t state         = {.valid_ns = 0.0};
    const status_t status = element_take(element, fields, COUNT_OF(fields), &state);
    if (!robot->is_free &&
        ((element_attribute(element, "velocity") != NULL) || (element_attribute(element, "rate") != NULL))) {
        return element_refuse(element, robot->name, "a robot with a free base, or no velocity and no rate");
    }
    if ((state.valid_ns > 0.0) && (!robot->is_free || (robot->model.joint_count > 0U))) {
        return element_refuse(element, element_attribute(element, "valid"),
                              "no time in a robot that is fixed or has joints that move");
    }
    robot->pose     = pose_of(state.at, state.rpy);
    robot->valid_ns = state.valid_ns;
    memcpy(robot->velocity_m_s, state.velocity, sizeof robot->velocity_m_s);
    memcpy(robot->rate_rad_s, state.rate, sizeof robot->rate_rad_s);
    return ((status == STATUS_OK) && (state.relative_to[0] != '\0'))
               ? place_relative(world, element, &state, robot)
               : status;
}

status_t world_take_spread(world_t* const world, const element_t* const element)
{
    static const field_t fields[] = {OPTIONAL(world_robot_t, "mass", spread_mass, 0.0, SHARE_MAX),
                                     OPTIONAL(world_robot_t, "inertia", spread_inertia, 0.0, SHARE_MAX),
                                     OPTIONAL(world_robot_t, "com", spread_com, 0.0, 1.0),
                                     OPTIONAL(world_robot_t, "at", spread_start.at, 0.0, FAR_M),
                                     OPTIONAL(world_robot_t, "rpy", spread_start.rpy, 0.0, TURNS_RAD),
                                     OPTIONAL(world_robot_t, "velocity", spread_start.velocity, 0.0, FAR_M),
                                     OPTIONAL(world_robot_t, "rate", spread_start.rate, 0.0, TURNS_RAD)};
    world_robot_t* robot          = &world->robot[world->robot_count - 1U];
    if (!robot->is_free &&
        ((element_attribute(element, "velocity") != NULL) || (element_attribute(element, "rate") != NULL))) {
        return element_refuse(element, robot->name, "a robot with a free base, or no velocity and no rate");
    }
    return element_take(element, fields, COUNT_OF(fields), robot);
}
