// SPDX-License-Identifier: Apache-2.0
/// Motions of an arm from rest to rest: all joints at once, or the tool along a straight line while it turns
/// about a fixed axis. Minimum jerk in time; the duration is the shortest that the limits allow. Or all
/// joints along a trajectory through via points.
///
/// A line is followed by inverse kinematics cycle by cycle. Before it begins, a check goes along it with
/// larger steps and tells whether the arm can do it; in motion the same checks go on.
///
/// Ownership  The caller places the structures.
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

/// Why a motion is refused or ended; the numbers are in telemetry.
typedef enum {
    ARM_REFUSAL_NONE     = 0,
    ARM_REFUSAL_POSITION = 1, ///< A joint would leave its range.
    ARM_REFUSAL_SPEED    = 2, ///< A joint would exceed its speed.
    ARM_REFUSAL_LINE     = 3, ///< The tool cannot stay on its line: out of reach, or a singular pose.
    ARM_REFUSAL_POINTS   = 4  ///< There is no via point, or no room for another one.
} arm_refusal_reason_t;

typedef struct {
    arm_refusal_reason_t reason;
    unsigned joint; ///< From 0; 0 if the refusal concerns none.
} arm_refusal_t;

typedef struct { // All fields are private.
    bool is_line;
    const arm_trajectory_t* trajectory; ///< Null: no trajectory.
    bool is_slowing;                    ///< The trajectory is left in a slower time: `progress`.
    double elapsed_s;                   ///< Time of the trajectory, otherwise.
    control_motion_t progress;          ///< From 0 to 1; of a trajectory, its time.
    double start_rad[ARM_JOINTS_MAX];
    double distance_rad[ARM_JOINTS_MAX];
    arm_pose_t from;
    arm_vector_t shift_m;
    arm_vector_t turn_rad;
} arm_path_t;

/// At rest where `motion` is.
void arm_path_rest(arm_path_t* path, const arm_model_t* model, const arm_motion_t* motion);
/// Joints to a goal. `share` of the limits, > 0, is used.
arm_refusal_t arm_path_begin_joints(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                                    const arm_motion_t* from, const double goal_rad[ARM_JOINTS_MAX],
                                    double share);
/// Tool to a pose in the frame of the base. `share` of the limits, > 0, is used.
void arm_path_begin_line(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                         const arm_motion_t* from, const arm_pose_t* goal, double share);
/// Joints along a trajectory whose plan is ready; it is kept.
void arm_path_begin_trajectory(arm_path_t* path, const arm_trajectory_t* trajectory);
/// The first joint of a pose that is outside its range.
arm_refusal_t arm_path_check_positions(const arm_model_t* model, const arm_limits_t* limits,
                                       const double position_rad[ARM_JOINTS_MAX]);
/// Advance by one period: the next point of the motion replaces `motion`.
arm_refusal_t arm_path_step(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                            double period_s, arm_motion_t* motion);
/// Come to rest on the path, with the accelerations of the limits; on a trajectory in addition to those of
/// its blends.
void arm_path_stop(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                   const arm_motion_t* motion);
/// The joints come to rest from where they are, with these accelerations, whatever the path was.
void arm_path_brake(arm_path_t* path, const arm_model_t* model, const arm_limits_t* limits,
                    const arm_motion_t* motion);
bool arm_path_is_done(const arm_path_t* path);
double arm_path_duration_s(const arm_path_t* path);

typedef struct { // All fields are private.
    arm_path_t path;
    arm_motion_t motion;
    double period_s;
} arm_line_check_t;

void arm_line_check_begin(arm_line_check_t* check, const arm_path_t* path, const arm_motion_t* from);
/// A part of the way, for one cycle. STATUS_BUSY; STATUS_OK: the arm can do it; STATUS_OUT_OF_RANGE with
/// *out_refusal.
MUST_USE status_t arm_line_check_step(arm_line_check_t* check, const arm_model_t* model,
                                      const arm_limits_t* limits, arm_refusal_t* out_refusal);

#endif // FSW_SUBSYSTEMS_ARM_ARM_PATH_H
