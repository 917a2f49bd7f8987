// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_path.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <math.h>
#include <stddef.h>

// Peak values of a minimum-jerk motion over distance 1 in time 1.
#define PEAK_SPEED 1.875
#define PEAK_ACCELERATION 5.7735026918962576 // 10 / sqrt 3

#define DURATION_MIN_S 0.1
#define STOP_MIN_S 0.05
// Tolerance of the check of speeds: the peak speed of a joint equals its limit, so rounding may exceed it.
#define SPEED_MARGIN 1.001
// Steps of the check of a line.
#define CHECK_STEPS 400U
// Steps of the check in one cycle, so that it does not delay the control.
#define CHECK_STEPS_CYCLE 10U

static double larger(const double a, const double b)
{
    return (a > b) ? a : b;
}

/// Returns the shortest duration of a motion over a distance that uses a share of both limits.
static double duration_of(const double distance, const double speed, const double acceleration,
                          const double share)
{
    const double length = control_absolute(distance);
    return larger(PEAK_SPEED * length / (speed * share),
                  sqrt(PEAK_ACCELERATION * length / (acceleration * share)));
}

void arm_path_rest(arm_path_t* const path, const arm_model_t* const model, const arm_motion_t* const motion)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (motion != NULL));
    *path = (arm_path_t){.is_line = false};
    for (unsigned i = 0U; i < model->joint_count; i++) {
        path->start_rad[i] = motion->position_rad[i];
    }
    control_motion_rest(&path->progress, 0.0);
}

arm_refusal_t arm_path_check_positions(const arm_model_t* const model, const arm_limits_t* const limits,
                                       const double position_rad[ARM_JOINTS_MAX])
{
    FSW_ASSERT((model != NULL) && (limits != NULL) && (position_rad != NULL));
    for (unsigned i = 0U; i < model->joint_count; i++) {
        if (!((position_rad[i] >= limits->lower_rad[i]) && (position_rad[i] <= limits->upper_rad[i]))) {
            return (arm_refusal_t){ARM_REFUSAL_POSITION, i};
        }
    }
    return (arm_refusal_t){ARM_REFUSAL_NONE, 0U};
}

arm_refusal_t arm_path_begin_joints(arm_path_t* const path, const arm_model_t* const model,
                                    const arm_limits_t* const limits, const arm_motion_t* const from,
                                    const double goal_rad[ARM_JOINTS_MAX], const double share)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (limits != NULL) && (from != NULL) && (share > 0.0));
    const arm_refusal_t refusal = arm_path_check_positions(model, limits, goal_rad);
    if (refusal.reason != ARM_REFUSAL_NONE) {
        return refusal;
    }
    double duration_s = DURATION_MIN_S;
    arm_path_rest(path, model, from);
    for (unsigned i = 0U; i < model->joint_count; i++) {
        path->distance_rad[i] = goal_rad[i] - from->position_rad[i];
        duration_s            = larger(duration_s, duration_of(path->distance_rad[i], limits->speed_rad_s[i],
                                                               limits->acceleration_rad_s2[i], share));
    }
    control_motion_begin(&path->progress, 0.0, 1.0, duration_s);
    return refusal;
}

void arm_path_begin_line(arm_path_t* const path, const arm_model_t* const model,
                         const arm_limits_t* const limits, const arm_motion_t* const from,
                         const arm_pose_t* const goal, const double share)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (limits != NULL) && (from != NULL) && (goal != NULL) &&
               (share > 0.0));
    arm_kinematics_t kinematics;
    arm_kinematics(model, from->position_rad, &kinematics);
    *path = (arm_path_t){
        .is_line  = true,
        .from     = kinematics.tool,
        .shift_m  = arm_difference(goal->position_m, kinematics.tool.position_m),
        .turn_rad = arm_rotation_between(&kinematics.tool.rotation, &goal->rotation),
    };
    const double linear =
        duration_of(arm_length(path->shift_m), limits->tool_speed_m_s, limits->tool_acceleration_m_s2, share);
    const double angular = duration_of(arm_length(path->turn_rad), limits->tool_rate_rad_s,
                                       limits->tool_angular_acceleration_rad_s2, share);
    control_motion_begin(&path->progress, 0.0, 1.0, larger(DURATION_MIN_S, larger(linear, angular)));
}

void arm_path_begin_trajectory(arm_path_t* const path, const arm_trajectory_t* const trajectory)
{
    FSW_ASSERT((path != NULL) && (trajectory != NULL));
    const double duration_s = arm_trajectory_duration_s(trajectory);
    *path                   = (arm_path_t){.is_line = trajectory->is_tool, .trajectory = trajectory};
    control_motion_begin(&path->progress, 0.0, duration_s, duration_s);
}

// ---- Steps ----

static void step_joints(const arm_path_t* const path, const arm_model_t* const model,
                        const control_motion_point_t* const point, arm_motion_t* const motion)
{
    for (unsigned i = 0U; i < model->joint_count; i++) {
        motion->position_rad[i]        = path->start_rad[i] + (path->distance_rad[i] * point->position);
        motion->velocity_rad_s[i]      = path->distance_rad[i] * point->velocity;
        motion->acceleration_rad_s2[i] = path->distance_rad[i] * point->acceleration;
    }
}

/// Returns the displacement from a pose of the tool to the pose that it shall have.
static arm_twist_t error_of(const arm_pose_t* const goal, const arm_pose_t* const tool)
{
    return (arm_twist_t){.linear_m_s    = arm_difference(goal->position_m, tool->position_m),
                         .angular_rad_s = arm_rotation_between(&tool->rotation, &goal->rotation)};
}

/// Advance the time of a trajectory: at the normal rate, or slowing down to rest.
static control_motion_point_t step_time(arm_path_t* const path, const control_motion_point_t* const point,
                                        const double period_s)
{
    if (path->is_slowing) {
        return *point;
    }
    path->elapsed_s += period_s;
    return (control_motion_point_t){.position = arm_path_is_done(path) ? point->position : path->elapsed_s,
                                    .velocity = 1.0};
}

/// Compute pose and velocity of the tool at the present point of the line, or of the trajectory.
static void tool_goal(arm_path_t* const path, const control_motion_point_t* const point,
                      const double period_s, arm_pose_t* const out_goal, arm_twist_t* const out_twist)
{
    if (path->trajectory != NULL) {
        const control_motion_point_t time = step_time(path, point, period_s);
        arm_trajectory_tool_at(path->trajectory, time.position, time.velocity, out_goal, out_twist);
        return;
    }
    out_goal->position_m = arm_sum(path->from.position_m, arm_times(path->shift_m, point->position));
    out_goal->rotation =
        arm_rotation_turned_by(&path->from.rotation, arm_times(path->turn_rad, point->position));
    out_twist->linear_m_s    = arm_times(path->shift_m, point->velocity);
    out_twist->angular_rad_s = arm_times(path->turn_rad, point->velocity);
}

/// Check that the tool is near its line, and the joints within their limits.
static arm_refusal_t check_motion(const arm_model_t* const model, const arm_limits_t* const limits,
                                  const arm_motion_t* const motion, const arm_twist_t* const error)
{
    const double distance = larger(arm_length(error->linear_m_s), arm_length(error->angular_rad_s));
    if (!(distance <= limits->tolerance)) {
        return (arm_refusal_t){ARM_REFUSAL_LINE, 0U};
    }
    for (unsigned i = 0U; i < model->joint_count; i++) {
        if (!(control_absolute(motion->velocity_rad_s[i]) <= (SPEED_MARGIN * limits->speed_rad_s[i]))) {
            return (arm_refusal_t){ARM_REFUSAL_SPEED, i};
        }
    }
    return arm_path_check_positions(model, limits, motion->position_rad);
}

/// Move the joints so that the tool is at the point of the line (one step of Newton's method), then compute
/// their velocities from the velocity of the tool.
static arm_refusal_t step_tool(arm_path_t* const path, const arm_model_t* const model,
                               const arm_limits_t* const limits, const control_motion_point_t* const point,
                               const double period_s, arm_motion_t* const motion)
{
    arm_kinematics_t kinematics;
    arm_jacobian_t jacobian;
    arm_pose_t goal;
    arm_twist_t twist;
    double change[ARM_JOINTS_MAX];
    tool_goal(path, point, period_s, &goal, &twist);
    arm_kinematics(model, motion->position_rad, &kinematics);
    arm_jacobian(model, &kinematics, &jacobian);
    arm_twist_t error = error_of(&goal, &kinematics.tool);
    (void)arm_inverse(&limits->inverse, &jacobian, model->joint_count, &error, change);
    for (unsigned i = 0U; i < model->joint_count; i++) {
        motion->position_rad[i] += change[i];
    }
    arm_kinematics(model, motion->position_rad, &kinematics);
    arm_jacobian(model, &kinematics, &jacobian);
    error = error_of(&goal, &kinematics.tool);
    (void)arm_inverse(&limits->inverse, &jacobian, model->joint_count, &twist, change);
    for (unsigned i = 0U; i < model->joint_count; i++) {
        motion->acceleration_rad_s2[i] = (change[i] - motion->velocity_rad_s[i]) / period_s;
        motion->velocity_rad_s[i]      = change[i];
    }
    return check_motion(model, limits, motion, &error);
}

/// Advance along a trajectory of the joints.
static void step_trajectory(arm_path_t* const path, const arm_model_t* const model,
                            const control_motion_point_t* const point, const double period_s,
                            arm_motion_t* const motion)
{
    const control_motion_point_t time = step_time(path, point, period_s);
    arm_trajectory_at(path->trajectory, time.position, motion);
    for (unsigned i = 0U; i < model->joint_count; i++) {
        motion->acceleration_rad_s2[i] = (motion->acceleration_rad_s2[i] * time.velocity * time.velocity) +
                                         (motion->velocity_rad_s[i] * time.acceleration);
        motion->velocity_rad_s[i] *= time.velocity;
    }
}

arm_refusal_t arm_path_step(arm_path_t* const path, const arm_model_t* const model,
                            const arm_limits_t* const limits, const double period_s,
                            arm_motion_t* const motion)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (limits != NULL) && (motion != NULL));
    const control_motion_point_t point = control_motion_step(&path->progress, period_s);
    if (path->is_line) {
        return step_tool(path, model, limits, &point, period_s, motion);
    }
    if (path->trajectory != NULL) {
        step_trajectory(path, model, &point, period_s, motion);
    } else {
        step_joints(path, model, &point, motion);
    }
    return (arm_refusal_t){ARM_REFUSAL_NONE, 0U};
}

static double braking_duration_s(const arm_model_t* const model, const arm_limits_t* const limits,
                                 const arm_motion_t* const motion)
{
    double duration_s = STOP_MIN_S;
    for (unsigned i = 0U; i < model->joint_count; i++) {
        duration_s =
            larger(duration_s, control_absolute(motion->velocity_rad_s[i]) / limits->acceleration_rad_s2[i]);
    }
    return duration_s;
}

void arm_path_stop(arm_path_t* const path, const arm_model_t* const model, const arm_limits_t* const limits,
                   const arm_motion_t* const motion)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (limits != NULL) && (motion != NULL));
    if (path->trajectory != NULL) { // Progress is its time, which slows down from the normal rate to rest.
        const control_motion_point_t now = {.position = path->elapsed_s, .velocity = 1.0};
        path->is_slowing                 = true;
        control_motion_brake(&path->progress, &now, 1.0 / braking_duration_s(model, limits, motion));
        return;
    }
    control_motion_t ahead             = path->progress;
    const control_motion_point_t point = control_motion_step(&ahead, 0.0);
    if (!(point.velocity > 0.0)) {
        control_motion_rest(&path->progress, point.position);
        return;
    }
    control_motion_brake(&path->progress, &point, point.velocity / braking_duration_s(model, limits, motion));
}

void arm_path_brake(arm_path_t* const path, const arm_model_t* const model, const arm_limits_t* const limits,
                    const arm_motion_t* const motion)
{
    FSW_ASSERT((path != NULL) && (model != NULL) && (limits != NULL) && (motion != NULL));
    // Progress is a time that slows down from the normal rate to rest; each joint moves by its present
    // velocity times this time.
    const control_motion_point_t start = {.position = 0.0, .velocity = 1.0};
    arm_path_rest(path, model, motion);
    for (unsigned i = 0U; i < model->joint_count; i++) {
        path->distance_rad[i] = motion->velocity_rad_s[i];
    }
    control_motion_brake(&path->progress, &start, 1.0 / braking_duration_s(model, limits, motion));
}

bool arm_path_is_done(const arm_path_t* const path)
{
    FSW_ASSERT(path != NULL);
    return control_motion_is_done(&path->progress);
}

double arm_path_duration_s(const arm_path_t* const path)
{
    FSW_ASSERT(path != NULL);
    return path->progress.duration_s;
}

// ---- Check of a line ----

void arm_line_check_begin(arm_line_check_t* const check, const arm_path_t* const path,
                          const arm_motion_t* const from)
{
    FSW_ASSERT((check != NULL) && (path != NULL) && (from != NULL));
    // A trajectory has as many lines as points.
    const unsigned lines = (path->trajectory != NULL) ? path->trajectory->point_count : 1U;
    *check               = (arm_line_check_t){.path     = *path,
                                              .motion   = *from,
                                              .period_s = arm_path_duration_s(path) / (double)(CHECK_STEPS * lines)};
}

status_t arm_line_check_step(arm_line_check_t* const check, const arm_model_t* const model,
                             const arm_limits_t* const limits, arm_refusal_t* const out_refusal)
{
    FSW_ASSERT((check != NULL) && (out_refusal != NULL));
    for (unsigned i = 0U; i < CHECK_STEPS_CYCLE; i++) {
        *out_refusal = arm_path_step(&check->path, model, limits, check->period_s, &check->motion);
        if (out_refusal->reason != ARM_REFUSAL_NONE) {
            return STATUS_OUT_OF_RANGE;
        }
        if (arm_path_is_done(&check->path)) {
            return STATUS_OK;
        }
    }
    return STATUS_BUSY;
}
