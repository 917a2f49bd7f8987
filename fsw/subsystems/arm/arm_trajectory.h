// SPDX-License-Identifier: Apache-2.0
/// Motion of all joints, or of the tool, from rest through via points to rest, without a stop between.
///
/// Straight lines in joint space connect the points; near a point the velocities change from those of one
/// line to those of the next, smooth to the second derivative, and the joints pass the point within the
/// distance `blend`. No joint exceeds its speed or acceleration, and no joint leaves the range of its points.
/// The plan begins with the shortest durations of the lines; each round lengthens by 5 % the lines whose
/// blends overlap or pass too far from their point.
/// The tool has six coordinates: its position, and its rotation vector from the orientation at the start.
/// The limits of the tool and `blend` apply to the length of the position vector and of the rotation vector.
///
/// Ownership  The caller provides the structures.
/// Context    One task.
/// Time       O(points x joints) for a round of the plan; O(points + joints) for a point of the motion.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H
#define FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H

#include "base/status.h"
#include "fsw/subsystems/arm/arm_geometry.h"
#include "fsw/subsystems/arm/arm_limits.h"
#include "fsw/subsystems/arm/arm_model.h"

#include <stdbool.h>

#define ARM_POINTS_MAX 16U
#define ARM_PLAN_ROUNDS 400U ///< Largest number of rounds; enough for 1.05^400 times the shortest durations.

typedef struct {          // All fields are private.
    bool is_tool;         ///< The coordinates are those of the tool.
    unsigned joint_count; ///< Number of coordinates.
    unsigned point_count; ///< Number of points without the start.
    /// The start, then the points [rad; of the tool m, rad].
    double point[ARM_POINTS_MAX + 1U][ARM_JOINTS_MAX];
    double line_s[ARM_POINTS_MAX];       ///< Duration of each line, from point to point.
    double blend_s[ARM_POINTS_MAX + 1U]; ///< Duration of the change of velocity at each point.
    double share;                        ///< Share of the limits that the motion uses, > 0.
    double blend;         ///< Largest distance of a joint, or of the tool, from a point [rad, m].
    arm_rotation_t start; ///< Orientation of the tool at the start.
    unsigned rounds;
} arm_trajectory_t;

/// Remove all points.
void arm_trajectory_clear(arm_trajectory_t* trajectory);
/// Append a point. STATUS_OK; STATUS_EXHAUSTED: there are already ARM_POINTS_MAX.
MUST_USE status_t arm_trajectory_add(arm_trajectory_t* trajectory, const arm_model_t* model,
                                     const double point_rad[ARM_JOINTS_MAX]);
/// Append a pose of the tool in the frame of the base; `rotation_rad` is axis times angle. STATUS_OK;
/// STATUS_EXHAUSTED: there are already ARM_POINTS_MAX. The points are either all poses or all joint angles.
MUST_USE status_t arm_trajectory_add_pose(arm_trajectory_t* trajectory, const double position_m[3],
                                          const double rotation_rad[3]);
/// Begin the plan of a motion from rest at `from`, which uses a `share`, > 0, of the limits; `blend` > 0. At
/// least one point is required, and all points are joint angles.
void arm_trajectory_begin(arm_trajectory_t* trajectory, const arm_limits_t* limits, const arm_motion_t* from,
                          double share, double blend);
/// Like arm_trajectory_begin, for a motion of the tool from rest at the pose `from`: all points are poses.
void arm_trajectory_begin_tool(arm_trajectory_t* trajectory, const arm_limits_t* limits,
                               const arm_pose_t* from, double share, double blend);
/// Perform one round of the plan. STATUS_BUSY: call again; STATUS_OK: the plan is ready; STATUS_EXHAUSTED:
/// ARM_PLAN_ROUNDS were not enough.
MUST_USE status_t arm_trajectory_plan(arm_trajectory_t* trajectory, const arm_limits_t* limits);
double arm_trajectory_duration_s(const arm_trajectory_t* trajectory);
/// Compute the motion at a time; the plan must be ready. Before its start and after its end, the arm is at
/// rest.
void arm_trajectory_at(const arm_trajectory_t* trajectory, double time_s, arm_motion_t* out_motion);
/// Compute pose and velocity of the tool at time `time_s` of the plan, if this time passes `rate` times as
/// fast as real time.
void arm_trajectory_tool_at(const arm_trajectory_t* trajectory, double time_s, double rate,
                            arm_pose_t* out_pose, arm_twist_t* out_twist);

#endif // FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H
