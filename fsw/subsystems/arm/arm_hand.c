// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_hand.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <math.h>
#include <stddef.h>

#define KEEPING_1_S 20.0 // Rate at which deviations from the pose that the tool must keep decay.
// Number of joints that an arm needs to keep an orientation while it moves the tool.
#define JOINTS_OF_A_POSE 6U
#define MARGIN_RAD 1.0e-4 // Distance from the end of its range at which a joint stops.
// Smallest speed limit of a joint: a joint that hardly takes part in a motion must not stop it.
#define CREEP_RAD_S 1.0e-7
#define NEARING_1_S 4.0   // Rate at which the arm may approach the limit of singular poses.
#define BRAKING_SHARE 0.5 // Share of the acceleration limit with which a joint brakes before its end.

static arm_vector_t normalized(const arm_vector_t vector)
{
    const double length = arm_length(vector);
    return arm_times(vector, (length > 0.0) ? (1.0 / length) : 0.0);
}

void arm_hand_directions(const double components[6], arm_vector_t out_direction[ARM_HAND_AXES])
{
    FSW_ASSERT((components != NULL) && (out_direction != NULL));
    const arm_vector_t second = arm_vector(&components[3]);
    out_direction[0]          = normalized(arm_vector(components));
    out_direction[1] =
        normalized(arm_difference(second, arm_times(out_direction[0], arm_dot(second, out_direction[0]))));
}

void arm_hand_begin(arm_hand_t* const hand, const arm_model_t* const model, const arm_motion_t* const motion)
{
    FSW_ASSERT((hand != NULL) && (model != NULL) && (motion != NULL));
    arm_kinematics_t kinematics;
    arm_kinematics(model, motion->position_rad, &kinematics);
    *hand = (arm_hand_t){.state = ARM_HAND_MISSING, .anchor = kinematics.tool};
}

// ---- Goal ----

/// True if a number is neither infinite nor NaN.
static bool is_finite(const double value)
{
    return (value - value) == 0.0;
}

/// Move the goal of the tool as the hand moves, scaled, within its range and not faster than the tool may
/// move. Without a sample of the hand, the goal is the present offset.
static void lead_goal(arm_hand_t* const hand, const arm_hand_setup_t* const setup,
                      const double* const hand_rad)
{
    const arm_hand_settings_t* const settings = &setup->settings;
    const bool is_known = (hand_rad != NULL) && is_finite(hand_rad[0]) && is_finite(hand_rad[1]);
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        if (!is_known) {
            hand->goal_m[i] = hand->offset_m[i];
            continue;
        }
        if (!hand->is_coupled) {
            hand->zero_rad[i] = hand_rad[i];
            hand->start_m[i]  = hand->offset_m[i];
            hand->goal_m[i]   = hand->offset_m[i];
        }
        hand->hand_rad[i]   = hand_rad[i];
        const double turned = hand_rad[i] - hand->zero_rad[i];
        const double beyond =
            turned - control_clamp(turned, -settings->dead_band_rad, settings->dead_band_rad);
        const double wanted = control_clamp(hand->start_m[i] + (settings->scale_m_rad * beyond),
                                            -settings->range_m, settings->range_m);
        const double step   = setup->limits->tool_speed_m_s * setup->period_s;
        hand->goal_m[i] += control_clamp(wanted - hand->goal_m[i], -step, step);
    }
    hand->is_coupled = is_known;
}

// ---- Tool ----

typedef struct {
    arm_kinematics_t kinematics;
    arm_jacobian_t jacobian;
    double offset_m[ARM_HAND_AXES];
    arm_twist_t deviation; ///< Displacement from the tool to the pose that it must keep.
} tool_state_t;

/// Compute the state of the tool for a pose of the joints.
static tool_state_t tool_state_of(const arm_hand_t* const hand, const arm_hand_setup_t* const setup,
                                  const double position_rad[ARM_JOINTS_MAX])
{
    tool_state_t tool_state;
    arm_kinematics(setup->model, position_rad, &tool_state.kinematics);
    arm_jacobian(setup->model, &tool_state.kinematics, &tool_state.jacobian);
    const arm_pose_t* const tool = &tool_state.kinematics.tool;
    tool_state.deviation =
        (arm_twist_t){.linear_m_s    = arm_difference(hand->anchor.position_m, tool->position_m),
                      .angular_rad_s = arm_rotation_between(&tool->rotation, &hand->anchor.rotation)};
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        const arm_vector_t direction = setup->settings.direction[i];
        tool_state.offset_m[i]       = -arm_dot(direction, tool_state.deviation.linear_m_s);
        tool_state.deviation.linear_m_s =
            arm_sum(tool_state.deviation.linear_m_s, arm_times(direction, tool_state.offset_m[i]));
    }
    if (setup->model->joint_count < JOINTS_OF_A_POSE) {
        tool_state.deviation.angular_rad_s = (arm_vector_t){{0.0}};
    }
    return tool_state;
}

/// Returns the next speed of the tool in one direction: that of a critically damped system, within the limits
/// of the tool, and so slow that the tool can brake before the goal.
static double next_speed(const arm_hand_setup_t* const setup, const double left_m, const double speed_m_s)
{
    const double omega        = setup->settings.bandwidth_rad_s;
    const double acceleration = setup->limits->tool_acceleration_m_s2;
    const double braking      = sqrt(2.0 * acceleration * control_absolute(left_m));
    const double largest =
        (braking < setup->limits->tool_speed_m_s) ? braking : setup->limits->tool_speed_m_s;
    const double wanted =
        speed_m_s + (((omega * omega * left_m) - (2.0 * omega * speed_m_s)) * setup->period_s);
    const double change = control_clamp(wanted, -largest, largest) - speed_m_s;
    const double step   = acceleration * setup->period_s;
    return control_settle(speed_m_s + control_clamp(change, -step, step));
}

/// Returns the velocity that moves the tool towards the goal, and back to the pose that it must keep.
static arm_twist_t wanted_twist(const arm_hand_t* const hand, const arm_hand_setup_t* const setup,
                                const tool_state_t* const tool_state, const arm_motion_t* const motion)
{
    arm_vector_t velocity = {{0.0}};
    arm_twist_t twist     = {.linear_m_s    = arm_times(tool_state->deviation.linear_m_s, KEEPING_1_S),
                             .angular_rad_s = arm_times(tool_state->deviation.angular_rad_s, KEEPING_1_S)};
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            velocity.at[k] += tool_state->jacobian.at[k][i] * motion->velocity_rad_s[i];
        }
    }
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        const arm_vector_t direction = setup->settings.direction[i];
        const double speed =
            next_speed(setup, hand->goal_m[i] - tool_state->offset_m[i], arm_dot(direction, velocity));
        twist.linear_m_s = arm_sum(twist.linear_m_s, arm_times(direction, speed));
    }
    return twist;
}

// ---- Joints ----

/// Returns the time that all joints need to brake from these rates to rest together, so that the tool keeps
/// its direction.
static double braking_time(const arm_hand_setup_t* const setup, const double rate_rad_s[ARM_JOINTS_MAX])
{
    double least_s = setup->period_s;
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double needed_s = control_absolute(rate_rad_s[i]) / setup->limits->acceleration_rad_s2[i];
        least_s               = (needed_s > least_s) ? needed_s : least_s;
    }
    return least_s;
}

/// Returns the largest speed of a joint in the direction of `rate_rad_s` from which it can brake within its
/// range, if all joints brake together in `braking_s` from these rates.
static double braking_speed(const arm_limits_t* const limits, const unsigned joint, const double position_rad,
                            const double rate_rad_s, const double braking_s)
{
    const double way_rad = (rate_rad_s > 0.0) ? (limits->upper_rad[joint] - position_rad)
                                              : (position_rad - limits->lower_rad[joint]);
    const double square =
        2.0 * BRAKING_SHARE * (control_absolute(rate_rad_s) / braking_s) * (way_rad - MARGIN_RAD);
    return (square > (CREEP_RAD_S * CREEP_RAD_S)) ? sqrt(square) : CREEP_RAD_S;
}

/// Scale all rates down by the same factor, so that no joint exceeds its limits.
static arm_hand_state_t limit_rates(const arm_hand_setup_t* const setup, const arm_motion_t* const motion,
                                    double rate_rad_s[ARM_JOINTS_MAX])
{
    const arm_limits_t* const limits = setup->limits;
    arm_hand_state_t state           = ARM_HAND_LEADS;
    double share                     = 1.0;
    const double braking_s           = braking_time(setup, rate_rad_s);
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double braking = braking_speed(limits, i, motion->position_rad[i], rate_rad_s[i], braking_s);
        const double largest = (braking < limits->speed_rad_s[i]) ? braking : limits->speed_rad_s[i];
        if ((share * control_absolute(rate_rad_s[i])) > largest) {
            share = largest / control_absolute(rate_rad_s[i]);
            state = (braking < limits->speed_rad_s[i]) ? ARM_HAND_POSITION : ARM_HAND_SPEED;
        }
    }
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        rate_rad_s[i] *= share;
    }
    return state;
}

/// Change the velocities towards these rates, as far as the accelerations permit.
static void approach(const arm_hand_setup_t* const setup, const double rate_rad_s[ARM_JOINTS_MAX],
                     arm_motion_t* const motion)
{
    double share = 1.0;
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double largest = setup->limits->acceleration_rad_s2[i] * setup->period_s;
        const double change  = control_absolute(rate_rad_s[i] - motion->velocity_rad_s[i]);
        share                = ((share * change) > largest) ? (largest / change) : share;
    }
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        const double change            = share * (rate_rad_s[i] - motion->velocity_rad_s[i]);
        motion->velocity_rad_s[i]      = control_settle(motion->velocity_rad_s[i] + change);
        motion->acceleration_rad_s2[i] = change / setup->period_s;
        motion->position_rad[i] += motion->velocity_rad_s[i] * setup->period_s;
    }
}

/// Compute the rates of the joints for a velocity of the tool. Returns the smallest singular value.
static double rates_of(const arm_hand_setup_t* const setup, const arm_jacobian_t* const jacobian,
                       const arm_twist_t* const twist, double out_rate_rad_s[ARM_JOINTS_MAX])
{
    arm_inverse_t settings    = setup->limits->inverse;
    settings.is_position_only = (setup->model->joint_count < JOINTS_OF_A_POSE);
    return arm_inverse(&settings, jacobian, setup->model->joint_count, twist, out_rate_rad_s);
}

/// Returns the factor for these rates with which the smallest singular value decreases so slowly that the arm
/// comes to rest before it is singular.
static double singular_share(const arm_hand_setup_t* const setup, const arm_motion_t* const motion,
                             const double smallest, const double rate_rad_s[ARM_JOINTS_MAX])
{
    static const arm_twist_t none = {.linear_m_s = {{0.0}}};
    arm_kinematics_t kinematics;
    arm_jacobian_t jacobian;
    double position_rad[ARM_JOINTS_MAX];
    double unused[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        position_rad[i] = motion->position_rad[i] + (rate_rad_s[i] * setup->period_s);
    }
    arm_kinematics(setup->model, position_rad, &kinematics);
    arm_jacobian(setup->model, &kinematics, &jacobian);
    const double falling = (smallest - rates_of(setup, &jacobian, &none, unused)) / setup->period_s;
    const double excess  = smallest - setup->limits->inverse.limit;
    const double allowed = (excess > 0.0) ? (NEARING_1_S * excess) : CREEP_RAD_S;
    return (falling > allowed) ? (allowed / falling) : 1.0;
}

void arm_hand_step(arm_hand_t* const hand, const arm_hand_setup_t* const setup, const double* const hand_rad,
                   arm_motion_t* const motion)
{
    FSW_ASSERT((hand != NULL) && (setup != NULL) && (motion != NULL) && (setup->period_s > 0.0));
    const tool_state_t now = tool_state_of(hand, setup, motion->position_rad);
    for (unsigned i = 0U; i < ARM_HAND_AXES; i++) {
        hand->offset_m[i] = now.offset_m[i];
    }
    lead_goal(hand, setup, hand_rad);
    const arm_twist_t twist = wanted_twist(hand, setup, &now, motion);
    double rate_rad_s[ARM_JOINTS_MAX];
    const double smallest  = rates_of(setup, &now.jacobian, &twist, rate_rad_s);
    arm_hand_state_t state = limit_rates(setup, motion, rate_rad_s);
    const double share     = singular_share(setup, motion, smallest, rate_rad_s);
    for (unsigned i = 0U; i < setup->model->joint_count; i++) {
        rate_rad_s[i] *= share;
    }
    approach(setup, rate_rad_s, motion);
    state       = (share < 1.0) ? ARM_HAND_SINGULAR : state;
    hand->state = hand->is_coupled ? state : ARM_HAND_MISSING;
}
