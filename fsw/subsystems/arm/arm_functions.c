// SPDX-License-Identifier: Apache-2.0
// Function commands of the arm, and the motions that they start.
#include "fsw/subsystems/arm/arm_internal.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "pus/core/tailoring.h"

#include <stddef.h>
#include <string.h>

/// Returns the failure code of a refused motion; the descriptor lists the reasons with the same numbers.
static uint16_t code_of(const arm_refusal_t refusal)
{
    return (uint16_t)(PUS_FAILURE_OWN + (unsigned)refusal.reason);
}

/// Returns the joint that is the cause of a refused or ended motion, from 1; 0: none.
static uint32_t joint_of(const arm_refusal_t refusal)
{
    const bool has_joint = (refusal.reason == ARM_REFUSAL_POSITION) || (refusal.reason == ARM_REFUSAL_SPEED);
    return has_joint ? (refusal.joint + 1U) : 0U;
}

static void end_move(arm_t* const arm, const uint16_t failure_code, const uint32_t detail)
{
    arm->is_moving   = false;
    arm->is_checking = false;
    arm->is_planning = false;
    arm->is_stopping = false;
    subsystem_function_done(arm->generic, arm->move_token, failure_code, detail);
    arm->move_token = 0U;
}

static void begin_path(arm_t* const arm, const arm_path_t* const path)
{
    arm->path        = *path;
    arm->is_checking = false;
    arm->is_planning = false;
    arm->is_moving   = true;
}

/// Begin to check whether the arm can follow `line` with its tool.
static void begin_check(arm_t* const arm)
{
    arm_line_check_begin(&arm->check, &arm->line, &arm->motion);
    arm->is_checking = true;
}

/// Continue the check of a line or of a trajectory of the tool. When the check has ended, begin the motion or
/// refuse it.
static void check_line(arm_t* const arm)
{
    arm_refusal_t refusal = {ARM_REFUSAL_NONE, 0U};
    const status_t status = arm_line_check_step(&arm->check, &arm->model, &arm->limits, &refusal);
    if (status == STATUS_OK) {
        begin_path(arm, &arm->line);
    } else if (status != STATUS_BUSY) {
        end_move(arm, code_of(refusal), joint_of(refusal));
    } else {
        // The check continues in the next cycle.
    }
}

/// Continue to plan a trajectory. When the plan is complete, begin the trajectory.
static void plan_trajectory(arm_t* const arm)
{
    const status_t status = arm_trajectory_plan(&arm->trajectory, &arm->limits);
    if (status == STATUS_OK) {
        arm_path_begin_trajectory(&arm->line, &arm->trajectory);
        arm->is_planning = false;
        if (arm->trajectory.is_tool) {
            begin_check(arm);
        } else {
            begin_path(arm, &arm->line);
        }
    } else if (status != STATUS_BUSY) {
        end_move(arm, code_of((arm_refusal_t){ARM_REFUSAL_POINTS, 0U}), 0U);
    } else {
        // Planning continues in the next cycle.
    }
}

/// End a line that cannot be followed further: the joints brake from their present positions.
static void abort_line(arm_t* const arm, const arm_refusal_t refusal)
{
    uint8_t octets[2];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, (uint8_t)refusal.reason);
    octet_write_u8(&writer, (uint8_t)joint_of(refusal));
    const descriptor_event_t* const event =
        descriptor_find_event_name(subsystem_descriptor(arm->generic), "MOTION_ENDED");
    if (event != NULL) {
        (void)subsystem_raise(arm->generic, event->id, octets, writer.position);
    }
    arm_path_brake(&arm->path, &arm->model, &arm->limits, &arm->motion);
    arm->is_stopping = true;
}

void arm_motion_step(arm_t* const arm, const double period_s)
{
    FSW_ASSERT(arm != NULL);
    if (arm->is_checking) {
        check_line(arm);
    }
    if (arm->is_planning) {
        plan_trajectory(arm);
    }
    const arm_refusal_t refusal =
        arm_path_step(&arm->path, &arm->model, &arm->limits, period_s, &arm->motion);
    if (refusal.reason != ARM_REFUSAL_NONE) {
        abort_line(arm, refusal);
    } else if (arm->is_moving && arm_path_is_done(&arm->path)) {
        arm_path_rest(&arm->path, &arm->model, &arm->motion);
        end_move(arm, arm->is_stopping ? PUS_FAILURE_ABORTED : PUS_FAILURE_NONE, 0U);
    } else {
        // The motion continues, or the arm is at rest.
    }
}

void arm_abandon(void* const self)
{
    FSW_ASSERT(self != NULL);
    arm_t* const arm = self;
    // The desired motion becomes rest at the present position.
    for (unsigned i = 0U; i < arm->model.joint_count; i++) {
        arm->motion.position_rad[i]        = arm->control.link_rad[i];
        arm->motion.velocity_rad_s[i]      = 0.0;
        arm->motion.acceleration_rad_s2[i] = 0.0;
    }
    arm_path_rest(&arm->path, &arm->model, &arm->motion);
    arm_trajectory_clear(&arm->points);
    arm_trajectory_clear(&arm->poses);
    end_move(arm, PUS_FAILURE_ABORTED, 0U);
}

// ---- Functions ----

/// Returns the values of an argument.
static const double* argument_of(const arm_t* const arm, const subsystem_function_t* const function,
                                 const descriptor_function_t* const described, const unsigned index)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(arm->generic);
    const uint32_t offset = descriptor->fields[described->first_argument + index].offset;
    return (const double*)(const void*)((const uint8_t*)function->arguments + offset);
}

static status_t refuse(arm_t* const arm, const uint32_t call_token, const arm_refusal_t refusal)
{
    subsystem_function_done(arm->generic, call_token, code_of(refusal), joint_of(refusal));
    return STATUS_OUT_OF_RANGE;
}

static status_t move_to(arm_t* const arm, const subsystem_function_t* const function,
                        const descriptor_function_t* const described)
{
    arm_path_t path;
    const double* const goal_rad = argument_of(arm, function, described, 0U);
    const double share           = *argument_of(arm, function, described, 1U);
    const arm_refusal_t refusal =
        arm_path_begin_joints(&path, &arm->model, &arm->limits, &arm->motion, goal_rad, share);
    if (refusal.reason != ARM_REFUSAL_NONE) {
        return refuse(arm, function->call_token, refusal);
    }
    begin_path(arm, &path);
    arm->move_token = function->call_token;
    return STATUS_BUSY;
}

static status_t line_to(arm_t* const arm, const subsystem_function_t* const function,
                        const descriptor_function_t* const described)
{
    static const arm_rotation_t none = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    const arm_pose_t goal            = {
                   .rotation   = arm_rotation_turned_by(&none, arm_vector(argument_of(arm, function, described, 1U))),
                   .position_m = arm_vector(argument_of(arm, function, described, 0U))};
    const double share = *argument_of(arm, function, described, 2U);
    arm_path_begin_line(&arm->line, &arm->model, &arm->limits, &arm->motion, &goal, share);
    begin_check(arm);
    arm->move_token = function->call_token;
    return STATUS_BUSY;
}

/// Add a point to the next trajectory; this is possible even while the arm moves.
static status_t add_point(arm_t* const arm, const subsystem_function_t* const function,
                          const descriptor_function_t* const described)
{
    const double* const point_rad = argument_of(arm, function, described, 0U);
    arm_refusal_t refusal         = arm_path_check_positions(&arm->model, &arm->limits, point_rad);
    if ((refusal.reason == ARM_REFUSAL_NONE) &&
        (arm_trajectory_add(&arm->points, &arm->model, point_rad) != STATUS_OK)) {
        refusal.reason = ARM_REFUSAL_POINTS;
    }
    return (refusal.reason == ARM_REFUSAL_NONE) ? STATUS_OK : refuse(arm, function->call_token, refusal);
}

/// Add a pose of the tool to its next trajectory; this is possible even while the arm moves.
static status_t add_pose(arm_t* const arm, const subsystem_function_t* const function,
                         const descriptor_function_t* const described)
{
    const status_t status = arm_trajectory_add_pose(&arm->poses, argument_of(arm, function, described, 0U),
                                                    argument_of(arm, function, described, 1U));
    return (status == STATUS_OK) ? STATUS_OK
                                 : refuse(arm, function->call_token, (arm_refusal_t){ARM_REFUSAL_POINTS, 0U});
}

/// Begin to plan a trajectory through the points, or through the poses of the tool.
static status_t move_through(arm_t* const arm, const subsystem_function_t* const function,
                             const descriptor_function_t* const described, arm_trajectory_t* const points)
{
    const double share = *argument_of(arm, function, described, 0U);
    const double blend = *argument_of(arm, function, described, 1U);
    if ((points->point_count == 0U) || !(blend > 0.0)) {
        return refuse(arm, function->call_token, (arm_refusal_t){ARM_REFUSAL_POINTS, 0U});
    }
    arm->trajectory = *points;
    arm_trajectory_clear(points);
    if (arm->trajectory.is_tool) {
        arm_kinematics_t kinematics;
        arm_kinematics(&arm->model, arm->motion.position_rad, &kinematics);
        arm_trajectory_begin_tool(&arm->trajectory, &arm->limits, &kinematics.tool, share, blend);
    } else {
        arm_trajectory_begin(&arm->trajectory, &arm->limits, &arm->motion, share, blend);
    }
    arm->is_planning = true;
    arm->move_token  = function->call_token;
    return STATUS_BUSY;
}

static status_t stop(arm_t* const arm)
{
    if (arm->drives.activity != DRIVES_ENGAGED) {
        return STATUS_FORBIDDEN;
    }
    if (arm->is_checking || arm->is_planning) {
        end_move(arm, PUS_FAILURE_ABORTED, 0U);
    } else if (arm->is_moving && !arm->is_stopping) {
        arm_path_stop(&arm->path, &arm->model, &arm->limits, &arm->motion);
        arm->is_stopping = true;
    } else {
        // The arm is at rest already, or is stopping.
    }
    return STATUS_OK;
}

/// Begin a motion, if the arm is at rest.
static status_t begin_motion(arm_t* const arm, const subsystem_function_t* const function,
                             const descriptor_function_t* const described)
{
    if (arm->is_moving || arm->is_checking || arm->is_planning) {
        return STATUS_FORBIDDEN;
    }
    if (strcmp(described->name, "MOVE_TO") == 0) {
        return move_to(arm, function, described);
    }
    if (strcmp(described->name, "MOVE_VIA") == 0) {
        return move_through(arm, function, described, &arm->points);
    }
    return (strcmp(described->name, "LINE_VIA") == 0) ? move_through(arm, function, described, &arm->poses)
                                                      : line_to(arm, function, described);
}

status_t arm_perform(void* const self, const subsystem_function_t* const function)
{
    FSW_ASSERT((self != NULL) && (function != NULL));
    arm_t* const arm                               = self;
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(arm->generic);
    const descriptor_function_t* const described   = (const descriptor_function_t*)descriptor_numbered(
          descriptor->functions, descriptor->function_count, sizeof descriptor->functions[0],
          function->function_id);
    if (described == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (arm->is_telepresence) { // The hand controls the motion.
        return STATUS_FORBIDDEN;
    }
    if (strcmp(described->name, "STOP") == 0) {
        return stop(arm);
    }
    if (arm->drives.activity != DRIVES_ENGAGED) {
        return STATUS_FORBIDDEN;
    }
    if (strcmp(described->name, "ADD_VIA") == 0) {
        return add_point(arm, function, described);
    }
    if (strcmp(described->name, "ADD_POSE") == 0) {
        return add_pose(arm, function, described);
    }
    if (strcmp(described->name, "CLR_VIA") == 0) {
        arm_trajectory_clear(&arm->points);
        arm_trajectory_clear(&arm->poses);
        return STATUS_OK;
    }
    return begin_motion(arm, function, described);
}
