// SPDX-License-Identifier: Apache-2.0
/// Motion of all joints from rest through via points to rest, without a stop between.
///
/// Straight lines in joint space connect the points; near a point the velocities change from those of one
/// line to those of the next, smoothly to the second derivative: the joints pass it within a distance, the
/// blend. On a line and in a blend no joint exceeds its speed or acceleration, and none leaves the range of
/// its points. The plan begins with the shortest durations of the lines; each round lengthens by 5 % those of
/// lines whose blends overlap or pass too far from their point.
///
/// Ownership  The caller places the structures.
/// Context    One task.
/// Time       O(points x joints) for a round of the plan; O(points + joints) for a point of the motion.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H
#define FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H

#include "base/status.h"
#include "fsw/subsystems/arm/arm_limits.h"
#include "fsw/subsystems/arm/arm_model.h"

#define ARM_POINTS_MAX 16U
#define ARM_PLAN_ROUNDS 400U ///< At most; enough for 1.05^400 times the shortest durations.

typedef struct { // All fields are private.
    unsigned joint_count;
    unsigned point_count;                                  ///< Behind the start.
    double point_rad[ARM_POINTS_MAX + 1U][ARM_JOINTS_MAX]; ///< The start, then the points.
    double line_s[ARM_POINTS_MAX];                         ///< Duration of each line, from point to point.
    double blend_s[ARM_POINTS_MAX + 1U]; ///< Duration of the change of velocity at each point.
    double share;
    double blend; ///< Largest distance of a joint from a point [rad, m].
    unsigned rounds;
} arm_trajectory_t;

/// No point yet.
void arm_trajectory_clear(arm_trajectory_t* trajectory);
/// Append a point. STATUS_EXHAUSTED: there are ARM_POINTS_MAX.
MUST_USE status_t arm_trajectory_add(arm_trajectory_t* trajectory, const arm_model_t* model,
                                     const double point_rad[ARM_JOINTS_MAX]);
/// Begin the plan, with at least one point: from rest at `from`, with a share, > 0, of the limits.
void arm_trajectory_begin(arm_trajectory_t* trajectory, const arm_limits_t* limits, const arm_motion_t* from,
                          double share, double blend);
/// A round of the plan. STATUS_BUSY: go on; STATUS_OK: it is ready; STATUS_EXHAUSTED: ARM_PLAN_ROUNDS were
/// not enough.
MUST_USE status_t arm_trajectory_plan(arm_trajectory_t* trajectory, const arm_limits_t* limits);
double arm_trajectory_duration_s(const arm_trajectory_t* trajectory);
/// The motion at a time, of a plan that is ready; before and after, at rest at its ends.
void arm_trajectory_at(const arm_trajectory_t* trajectory, double time_s, arm_motion_t* out_motion);

#endif // FSW_SUBSYSTEMS_ARM_ARM_TRAJECTORY_H
