// SPDX-License-Identifier: Apache-2.0
/// Motions of an arm from rest to rest: all joints at the same time, or the tool along a straight line while
/// it turns about a fixed axis, both with minimum jerk and in the shortest time that the limits permit; or
/// all joints, or the tool, along a trajectory through via points.
///
/// The arm follows a line or a trajectory of the tool by inverse kinematics in each cycle. Before the motion
/// begins, a check follows each line in 400 steps and finds out whether the motion is possible; the same
/// conditions are checked during the motion.
///
/// Ownership  The caller provides the structures.
/// Context    One task.
/// Time       O(joints) for each step.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_PATH_H
#define FSW_SUBSYSTEMS_ARM_ARM_PATH_H

#include "base/status.h"
#include "fsw/framework/control/motion.h"
#include "fsw/subsystems/arm/arm_limits.h"
#include "fsw/subsystems/arm/arm_model.h"
#include "fsw/subsystems/arm/arm_trajectory.h"

#include <stdbool.h>

/// Reason for which a motion is refused or ended; telemetry contains these numbers.
typedef enum {
    ARM_REFUSAL_NONE     = 0,
    ARM_REFUSAL_POSITION = 1, ///< A joint would leave its range.
    ARM_REFUSAL_SPEED    = 2, ///< A joint would exceed its speed.
    ARM_REFUSAL_LINE     = 3, ///< The tool cannot stay on its line: out of reach, or a singular pose.
    /// No via point, no room for another one, a blend that is not above 0, or no motion through the points.
    ARM_REFUSAL_POINTS = 4
} arm_refusal_reason_t;

typedef struct {
    arm_refusal_reason_t reason;
    unsigned joint; ///< Number of the joint, from 0; 0 also if no joint is the cause.
} arm_refusal_t;

typedef struct {                        // All fields are private.
    bool is_line;                       ///< The tool follows a line, or a trajectory of its own.
    const arm_trajectory_t* trajectory; ///< Trajectory; null if the motion is not a trajectory.
    bool is_slowing;                    ///< The time of the trajectory slows down; it is `progress`.
    double elapsed_s;                   ///< Time of the trajectory, if it does not slow down.
    /// Progress of the motion from 0 to 1, or the time [s] of a trajectory that slows down or of braking.
    control_motion_t progress;
    double start_rad[ARM_JOINTS_MAX];
    double distance_rad[ARM_JOINTS_MAX];
    arm_pose_t from;
    arm_vector_t shift_m;
    arm_vector_t turn_rad;
} arm_path_t;

/// Rest at the position of `motion`.
void arm_path_rest(arm_path_t* path, const arm_model_t* model, const arm_motion_t* motion);
/// Begin a motion of the joints to a goal. The motion uses a `share`, > 0, of the limits. Returns
/// ARM_REFUSAL_POSITION if the goal is outside the range of a joint; `path` is then unchanged.
arm_refusal_t arm_path_begin_joints(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                                    const arm_motion_t* from, const double goal_rad[ARM_JOINTS_MAX],
                                    double share);
/// Begin a motion of the tool to a pose in the frame of the base. The motion uses a `share`, > 0, of the
/// limits.
void arm_path_begin_line(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                         const arm_motion_t* from, const arm_pose_t* goal, double share);
/// Begin a motion along a trajectory whose plan is ready, of the joints or of the tool. `trajectory` must
/// stay valid during the motion.
void arm_path_begin_trajectory(arm_path_t* path, const arm_trajectory_t* trajectory);
/// Returns the first joint whose position is outside its range, or ARM_REFUSAL_NONE.
arm_refusal_t arm_path_check_positions(const arm_model_t* model, const arm_limits_t* limits,
                                       const double position_rad[ARM_JOINTS_MAX]);
/// Advance by one period: the next point of the motion replaces `motion`. Returns ARM_REFUSAL_NONE; if the
/// tool follows a line or a trajectory, also the reason why the motion must end.
arm_refusal_t arm_path_step(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                            double period_s, arm_motion_t* motion);
/// Come to rest on the path with the accelerations of the limits. On a trajectory they add to the
/// accelerations of its blends.
void arm_path_stop(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                   const arm_motion_t* motion);
/// Brake all joints with these accelerations from their present motion to rest, without following the path.
void arm_path_brake(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                    const arm_motion_t* motion);
bool arm_path_is_done(const arm_path_t* path);
/// Duration of the present motion, or of braking, from its start to rest.
double arm_path_duration_s(const arm_path_t* path);

typedef struct { // All fields are private.
    arm_path_t path;
    arm_motion_t motion;
    double period_s;
} arm_line_check_t;

void arm_line_check_begin(arm_line_check_t* check, const arm_path_t* path, const arm_motion_t* from);
/// Check the next part of the line, as much as one cycle permits. STATUS_BUSY; STATUS_OK: the motion is
/// possible; STATUS_OUT_OF_RANGE: *out_refusal is the reason.
MUST_USE status_t arm_line_check_step(arm_line_check_t* check, const arm_model_t* model,
                                      const arm_limits_t* limits, arm_refusal_t* out_refusal);

#endif // FSW_SUBSYSTEMS_ARM_ARM_PATH_H
