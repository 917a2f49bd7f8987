// SPDX-License-Identifier: Apache-2.0
/// Point-to-point motion with minimum jerk: rest to rest in a given time, smooth to the second derivative;
/// and a stop from such a motion with constant deceleration. Positions have any unit; velocities and
/// accelerations are per second and per second squared.
///
/// Ownership  The caller provides control_motion_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_CONTROL_MOTION_H
#define FSW_FRAMEWORK_CONTROL_MOTION_H

#include <stdbool.h>

typedef struct { // All fields are private.
    double start;
    double distance; ///< From the start to the end of the motion or of the stop, with sign.
    double duration_s;
    double elapsed_s;
    double speed; ///< Speed at the beginning of a stop, with sign; 0: not a stop.
} control_motion_t;

typedef struct {
    double position;
    double velocity;
    double acceleration;
} control_motion_point_t;

/// Set the motion to rest at a position.
void control_motion_rest(control_motion_t* motion, double position);
/// Begin a motion from start to goal. duration_s > 0.
void control_motion_begin(control_motion_t* motion, double start, double goal, double duration_s);
/// Stop with a constant deceleration > 0, beginning at the point `from` of a motion.
void control_motion_brake(control_motion_t* motion, const control_motion_point_t* from, double deceleration);
/// Advance by one period; returns the point reached. After the end, the point is at rest at the goal.
control_motion_point_t control_motion_step(control_motion_t* motion, double period_s);
bool control_motion_is_done(const control_motion_t* motion);
/// Returns the largest speed of a minimum-jerk motion over a distance.
double control_motion_peak_speed(double distance, double duration_s);

#endif // FSW_FRAMEWORK_CONTROL_MOTION_H
