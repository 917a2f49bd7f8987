// SPDX-License-Identifier: Apache-2.0
/// Control law of an arm: computes the commands of the drives from sensors and desired motion.
///
/// Each cycle calls arm_control_sense, then _hold (actuators off: engaging causes no step), _step or _comply.
///     motor target  th_d = q_d + tau / K + offset       tau: inverse dynamics of the desired motion
///     feed-forward  u_ff = tau + J a_d + friction(v_d)
///     torque        u    = u_ff + bias + Kp (th_d - th) + Kd (v_d - v)
///     compliant     u    = t_j + J a_d + friction(v_d) + G (t_j - torque)
///                   t_j  = tau(q) + bias + Jac^T (Kt e + Dt (t_d - t)) - Dj v
///
/// q, v, a: link; th: motor; _d: desired; K: stiffness; J: rotor inertia; Jac: Jacobian of the tool; e: from
/// the tool to its desired pose; t: velocity of the tool; Kp, Kd, Kt, Dt, Dj, G: parameter CONTROL. offset,
/// bias: differences from the model at engagement, which decay.
///
/// Ownership  The caller provides arm_control_t.
/// Context    One task. O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_CONTROL_H
#define FSW_SUBSYSTEMS_ARM_ARM_CONTROL_H

#include "fsw/framework/control/tracker.h"
#include "fsw/subsystems/arm/arm_parameters.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const arm_model_t* model;
    const arm_parameters_t* parameters;
    double period_s;
} arm_setup_t;

typedef struct { // Read-only outside.
    bool is_started;
    double motor_rad[ARM_JOINTS_MAX];
    double torque_nm[ARM_JOINTS_MAX]; ///< Torque sensor, without correction.
    double link_rad[ARM_JOINTS_MAX];
    control_tracker_t motor[ARM_JOINTS_MAX]; ///< Velocity of the motor angle.
    arm_kinematics_t kinematics;             ///< Kinematics at link_rad.
    arm_twist_t tool_error;                  ///< Displacement from the tool to its desired pose [m, rad].
    double offset_rad[ARM_JOINTS_MAX];
    double bias_nm[ARM_JOINTS_MAX];
    double motor_target_rad[ARM_JOINTS_MAX];
    double feed_forward_nm[ARM_JOINTS_MAX];
    double command_nm[ARM_JOINTS_MAX]; ///< Commands of torque mode.
    uint32_t limited;                  ///< Torque commands cut at their limits [commands, wraps].
} arm_control_t;

void arm_control_init(arm_control_t* control);
/// Process the measured motor angles and joint torques.
void arm_control_sense(arm_control_t* control, const arm_setup_t* setup,
                       const double motor_rad[ARM_JOINTS_MAX], const double torque_nm[ARM_JOINTS_MAX]);
/// Compute commands that hold the present pose.
void arm_control_hold(arm_control_t* control, const arm_setup_t* setup);
/// Compute commands for a desired motion.
void arm_control_step(arm_control_t* control, const arm_setup_t* setup, const arm_motion_t* desired);
/// Compute command_nm for a desired motion with a compliant tool. The other commands are not computed.
void arm_control_comply(arm_control_t* control, const arm_setup_t* setup, const arm_motion_t* desired);

#endif // FSW_SUBSYSTEMS_ARM_ARM_CONTROL_H
