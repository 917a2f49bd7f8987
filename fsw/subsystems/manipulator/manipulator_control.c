// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_control.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

// Speed below which the compensation of Coulomb friction is proportional to the speed.
#define FRICTION_SPEED_RAD_S 0.02

void manipulator_arm_control_init(manipulator_arm_control_t* const control)
{
    FSW_ASSERT(control != NULL);
    *control = (manipulator_arm_control_t){.is_started = false};
}

void manipulator_arm_control_sense(manipulator_arm_control_t* const control,
                                   const manipulator_arm_setup_t* const setup,
                                   const double motor_rad[ARM_JOINTS], const double torque_nm[ARM_JOINTS])
{
    FSW_ASSERT((control != NULL) && (setup != NULL));
    double free_torque[ARM_JOINTS];
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        control->motor_rad[i] = motor_rad[i];
        control->torque_nm[i] = torque_nm[i];
        control->link_rad[i]  = motor_rad[i] - (torque_nm[i] / setup->model->stiffness[i]);
        free_torque[i]        = torque_nm[i] - control->zero_nm[i];
        if (!control->is_started) {
            control_tracker_reset(&control->motor[i], motor_rad[i]);
            control_tracker_reset(&control->reference[i], control->link_rad[i]);
            control->goal_rad[i] = control->link_rad[i];
        }
        control_tracker_step(&control->motor[i], motor_rad[i], setup->gains->velocity_bandwidth,
                             setup->period_s);
    }
    control->is_started = true;
    const manipulator_arm_observer_gains_t gains =
        manipulator_arm_observer_gains(setup->gains, setup->period_s);
    manipulator_arm_observer_step(&control->observer, setup->model, &gains, control->link_rad, free_torque);
}

void manipulator_arm_control_hold(manipulator_arm_control_t* const control,
                                  const manipulator_arm_setup_t* const setup, const double* const hand_rad)
{
    FSW_ASSERT((control != NULL) && (setup != NULL));
    const manipulator_arm_terms_t terms = manipulator_arm_terms(setup->model, control->link_rad);
    control->is_coupled                 = (hand_rad != NULL);
    control->yielding                   = 0.0;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double link         = control->link_rad[i];
        const double gravity      = terms.gravity_nm[i];
        control->hand_zero_rad[i] = (hand_rad != NULL) ? hand_rad[i] : 0.0;
        control->link_zero_rad[i] = link;
        control->goal_rad[i]      = link;
        control_tracker_reset(&control->reference[i], link);
        control->slow_nm[i]    = control->observer.external_nm[i];
        control->offset_rad[i] = control->motor_rad[i] - (link + (gravity / setup->model->stiffness[i]));
        control->bias_nm[i]    = (control->torque_nm[i] - control->zero_nm[i]) - gravity;
        control->motor_target_rad[i] = control->motor_rad[i];
        control->feed_forward_nm[i]  = gravity + control->bias_nm[i];
        control->command_nm[i] = control_clamp(control->feed_forward_nm[i], -setup->gains->torque_ceiling[i],
                                               setup->gains->torque_ceiling[i]);
    }
}

/// Move the goal of one joint towards `wanted`, but not beyond the range around home and not faster than the
/// speed limit.
static void lead_goal(manipulator_arm_control_t* const control, const manipulator_arm_setup_t* const setup,
                      const unsigned joint, const double wanted)
{
    if (wanted != wanted) {
        return; // Ignore a NaN hand position.
    }
    const manipulator_control_t* const gains = setup->gains;
    const double low                         = gains->home[joint] - gains->range[joint];
    const double high                        = gains->home[joint] + gains->range[joint];
    const double step                        = gains->speed_limit * setup->period_s;
    const double reach                       = control_clamp(wanted, low, high);
    control->goal_rad[joint] += control_clamp(reach - control->goal_rad[joint], -step, step);
}

/// Returns the angle by which a joint yields to the fast part of the external torque.
static double yield(manipulator_arm_control_t* const control, const manipulator_arm_setup_t* const setup,
                    const unsigned joint)
{
    const manipulator_control_t* const gains = setup->gains;
    const double fast                        = control->observer.external_nm[joint] - control->slow_nm[joint];
    control->slow_nm[joint] += control_clamp(gains->compliance_corner * setup->period_s, 0.0, 1.0) * fast;
    return control->yielding * gains->compliance * fast;
}

/// Returns the share of offset_rad and bias_nm, the differences at engagement, that remains after one period.
static double remaining_share(const manipulator_arm_setup_t* const setup)
{
    return 1.0 - control_clamp(setup->period_s / setup->gains->fade_time, 0.0, 1.0);
}

manipulator_arm_motion_t manipulator_arm_control_follow(manipulator_arm_control_t* const control,
                                                        const manipulator_arm_setup_t* const setup,
                                                        const double* const hand_rad)
{
    FSW_ASSERT((control != NULL) && (setup != NULL));
    manipulator_arm_motion_t desired;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        if (hand_rad != NULL) {
            // The first sample of the hand arrived after the arm was engaged: couple the hand at the present
            // goal.
            if (!control->is_coupled) {
                control->hand_zero_rad[i] = hand_rad[i];
                control->link_zero_rad[i] = control->goal_rad[i];
            }
            const double moved = setup->gains->position_scale * (hand_rad[i] - control->hand_zero_rad[i]);
            lead_goal(control, setup, i, control->link_zero_rad[i] + moved);
        }
        control_tracker_t* const reference = &control->reference[i];
        control_tracker_step(reference, control->goal_rad[i], setup->gains->reference_bandwidth,
                             setup->period_s);
        desired.position_rad[i]        = reference->position + yield(control, setup, i);
        desired.velocity_rad_s[i]      = reference->velocity;
        desired.acceleration_rad_s2[i] = reference->acceleration;
    }
    control->is_coupled = control->is_coupled || (hand_rad != NULL);
    control->yielding   = 1.0 - (remaining_share(setup) * (1.0 - control->yielding));
    return desired;
}

void manipulator_arm_control_step(manipulator_arm_control_t* const control,
                                  const manipulator_arm_setup_t* const setup,
                                  const manipulator_arm_motion_t* const desired)
{
    FSW_ASSERT((control != NULL) && (setup != NULL) && (desired != NULL));
    const manipulator_control_t* const gains = setup->gains;
    const manipulator_model_t* const model   = setup->model;
    const manipulator_arm_terms_t terms      = manipulator_arm_terms(model, desired->position_rad);
    const double fade                        = remaining_share(setup);
    double inertial[ARM_JOINTS];
    double coriolis[ARM_JOINTS];
    manipulator_arm_inertia_times(&terms, desired->acceleration_rad_s2, inertial);
    manipulator_arm_coriolis(&terms, desired->velocity_rad_s, coriolis);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double speed = desired->velocity_rad_s[i];
        const double rigid = inertial[i] + coriolis[i] + terms.gravity_nm[i];
        const double friction =
            (gains->friction_share * model->coulomb[i] * control_tanh(speed / FRICTION_SPEED_RAD_S)) +
            (model->viscous[i] * speed);
        control->offset_rad[i] = control_settle(control->offset_rad[i] * fade);
        control->bias_nm[i]    = control_settle(control->bias_nm[i] * fade);
        control->motor_target_rad[i] =
            desired->position_rad[i] + (rigid / model->stiffness[i]) + control->offset_rad[i];
        control->feed_forward_nm[i] = rigid + (model->rotor_inertia[i] * desired->acceleration_rad_s2[i]) +
                                      friction + control->bias_nm[i];
        const double wanted = control->feed_forward_nm[i] +
                              (gains->kp[i] * (control->motor_target_rad[i] - control->motor_rad[i])) +
                              (gains->kd[i] * (speed - control->motor[i].velocity));
        control->command_nm[i] = control_clamp(wanted, -gains->torque_ceiling[i], gains->torque_ceiling[i]);
        control->limited += (control->command_nm[i] != wanted) ? 1U : 0U;
    }
}
