// SPDX-License-Identifier: Apache-2.0
/// Second-order tracker: follows a sampled signal and estimates its velocity and acceleration. It is
/// critically damped, has the bandwidth `omega`, and follows ramps without lag. Positions have any unit;
/// velocities and accelerations are per second and per second squared.
///
/// Ownership  The caller provides control_tracker_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_CONTROL_TRACKER_H
#define FSW_FRAMEWORK_CONTROL_TRACKER_H

typedef struct {
    double position;
    double velocity;
    double acceleration;
} control_tracker_t;

/// Set the tracker to rest at a position.
void control_tracker_reset(control_tracker_t* tracker, double position);
/// Process one sample. omega_rad_s x period_s must be below 0.5; otherwise the tracker oscillates.
void control_tracker_step(control_tracker_t* tracker, double sample, double omega_rad_s, double period_s);

#endif // FSW_FRAMEWORK_CONTROL_TRACKER_H
