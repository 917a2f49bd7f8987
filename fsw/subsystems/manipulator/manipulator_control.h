// SPDX-License-Identifier: Apache-2.0
/// Joint control of the arm: computes the commands of the drives from sensors and desired motion.
///
/// Each cycle calls manipulator_arm_control_sense, then _hold (while actuators are off: commands for the
/// present pose, so that engaging causes no step), or _follow and _step. In torque mode this control closes
/// the loop; in position mode the drive does, and gets the motor angle and a feed-forward torque. Equations:
/// docs/control.md.
///
/// Ownership  The caller provides manipulator_arm_control_t. Gains and model: parameters CONTROL and MODEL.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_CONTROL_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_CONTROL_H

#include "fsw/framework/control/tracker.h"
#include "fsw/subsystems/manipulator/manipulator_model.h"
#include "fsw/subsystems/manipulator/manipulator_observer.h"

#include <stdbool.h>

typedef struct {
    double position_rad[ARM_JOINTS];
    double velocity_rad_s[ARM_JOINTS];
    double acceleration_rad_s2[ARM_JOINTS];
} manipulator_arm_motion_t;

typedef struct {
    const manipulator_control_t* gains;
    const manipulator_model_t* model;
    double period_s;
} manipulator_arm_setup_t;

typedef struct { // Read-only outside.
    bool is_started;
    bool is_coupled; ///< hand_zero_rad is known.
    double motor_rad[ARM_JOINTS];
    double torque_nm[ARM_JOINTS]; ///< Torque sensor, without correction.
    double link_rad[ARM_JOINTS];
    control_tracker_t motor[ARM_JOINTS];     ///< Velocity of the motor angle.
    control_tracker_t reference[ARM_JOINTS]; ///< Desired link motion.
    manipulator_arm_observer_t observer;
    double zero_nm[ARM_JOINTS];       ///< Zero point of the torque sensors.
    double hand_zero_rad[ARM_JOINTS]; ///< Joystick angle that corresponds to link_zero_rad.
    /// Link angle when the hand was coupled.
    double link_zero_rad[ARM_JOINTS];
    double goal_rad[ARM_JOINTS]; ///< Goal of the reference, limited in speed and range.
    double slow_nm[ARM_JOINTS];  ///< Low-pass filtered external torque.
    double yielding;             ///< Part of COMPLIANCE in effect: 0 at engagement, then rising to 1.
    /// Difference of the motor angle from the model at engagement; it decays.
    double offset_rad[ARM_JOINTS];
    /// Difference of the torque from the model at engagement; it decays.
    double bias_nm[ARM_JOINTS];
    double motor_target_rad[ARM_JOINTS];
    double feed_forward_nm[ARM_JOINTS];
    double command_nm[ARM_JOINTS]; ///< Commands of torque mode.
    unsigned limited;              ///< Torque commands of _step cut at the ceiling [commands, wraps].
} manipulator_arm_control_t;

void manipulator_arm_control_init(manipulator_arm_control_t* control);
/// Process the measured motor angles and joint torques; estimate link angles, velocities and external
/// torques.
void manipulator_arm_control_sense(manipulator_arm_control_t* control, const manipulator_arm_setup_t* setup,
                                   const double motor_rad[ARM_JOINTS], const double torque_nm[ARM_JOINTS]);
/// Hold the arm, and couple it to the hand in the present pose: the hand's present angle (null: no hand)
/// corresponds to this pose, and the commands hold the arm in it.
void manipulator_arm_control_hold(manipulator_arm_control_t* control, const manipulator_arm_setup_t* setup,
                                  const double* hand_rad);
/// Compute the desired motion that follows the hand. `hand_rad` is null while there is no sample of the
/// hand; the goal then stays.
manipulator_arm_motion_t manipulator_arm_control_follow(manipulator_arm_control_t* control,
                                                        const manipulator_arm_setup_t* setup,
                                                        const double* hand_rad);
/// Compute the commands for a desired motion.
void manipulator_arm_control_step(manipulator_arm_control_t* control, const manipulator_arm_setup_t* setup,
                                  const manipulator_arm_motion_t* desired);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_CONTROL_H
