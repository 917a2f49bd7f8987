// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_yield.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define LEAD_SHARE 0.01     // Share of the lag of acted_rad behind asked_rad that one cycle removes.
#define LEAD_MAX_RAD 2.0e-4 // Largest change in one cycle.

/// True if the sample has an angle of the hand in which no number is infinite or NaN: x - x is then 0.
static bool has_hand(const manipulator_arm_yield_sample_t* const sample)
{
    return (sample->hand_rad != NULL) && ((sample->hand_rad[0] - sample->hand_rad[0]) == 0.0) &&
           ((sample->hand_rad[1] - sample->hand_rad[1]) == 0.0);
}

void manipulator_arm_yield_reset(manipulator_arm_yield_t* const yield,
                                 const manipulator_arm_yield_sample_t* const sample)
{
    FSW_ASSERT((yield != NULL) && (sample != NULL));
    *yield = (manipulator_arm_yield_t){.is_started = has_hand(sample)};
    if (yield->is_started) {
        control_reserve_take_sum(&yield->reserve, sample->paid_j);
        for (unsigned i = 0U; i < ARM_JOINTS; i++) {
            yield->hand_rad[i]  = sample->hand_rad[i];
            yield->asked_rad[i] = sample->hand_rad[i];
            yield->acted_rad[i] = sample->hand_rad[i];
        }
    }
}

/// Estimate the contact. The motion of the arm disturbs the estimate of the force, so only the slow part of
/// the force is used. The force contains friction, so the normal follows the direction of the force with a
/// longer time constant; at the beginning of a contact the normal is set to this direction.
static void follow_contact(manipulator_arm_yield_t* const yield,
                           const manipulator_arm_yield_setup_t* const setup, const double force_n[ARM_JOINTS])
{
    const manipulator_remote_t* const gains = setup->gains;
    const double quick = control_clamp(gains->contact_corner * setup->period_s, 0.0, 1.0);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        yield->slow_n[i] = control_settle(yield->slow_n[i] + (quick * (force_n[i] - yield->slow_n[i])));
    }
    const double size = control_planar_length(yield->slow_n);
    if (size < gains->touch) {
        yield->is_touching = false;
        yield->push_n      = 0.0;
        return;
    }
    const double slow = control_clamp(gains->normal_corner * setup->period_s, 0.0, 1.0);
    double sum[ARM_JOINTS];
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double direction = yield->slow_n[i] / size;
        sum[i] =
            yield->is_touching ? (yield->normal[i] + (slow * (direction - yield->normal[i]))) : direction;
    }
    const double length = control_planar_length(sum);
    if (length > 0.0) {
        yield->normal[0] = sum[0] / length;
        yield->normal[1] = sum[1] / length;
    }
    yield->is_touching = true;
    yield->push_n      = (yield->slow_n[0] * yield->normal[0]) + (yield->slow_n[1] * yield->normal[1]);
}

/// Compute how far the arm yields, as angles of the joystick.
static void give_way(manipulator_arm_yield_t* const yield, const manipulator_arm_yield_setup_t* const setup,
                     const manipulator_arm_yield_sample_t* const sample, double out_rad[ARM_JOINTS])
{
    out_rad[0] = 0.0;
    out_rad[1] = 0.0;
    if (!control_planar_is_regular(sample->jacobian) || !(setup->position_scale > 0.0)) {
        return;
    }
    double force[ARM_JOINTS];
    control_planar_force(sample->jacobian, sample->external_nm, force);
    follow_contact(yield, setup, force);
    const double normal = (force[0] * yield->normal[0]) + (force[1] * yield->normal[1]);
    const double speed  = setup->gains->give_way * (normal - setup->gains->force_limit);
    yield->given_way_m =
        control_clamp(yield->given_way_m + (speed * setup->period_s), 0.0, setup->gains->give_way_max);
    const double move[ARM_JOINTS] = {yield->given_way_m * yield->normal[0],
                                     yield->given_way_m * yield->normal[1]};
    control_planar_angles(sample->jacobian, move, out_rad);
    out_rad[0] /= setup->position_scale;
    out_rad[1] /= setup->position_scale;
}

/// Perform a step of the angle that the arm follows. The step is shortened so that the arm gives away no
/// more energy than its reserve.
static void take_step(manipulator_arm_yield_t* const yield, const manipulator_arm_yield_setup_t* const setup,
                      const double torque_nm[ARM_JOINTS], double step_rad[ARM_JOINTS])
{
    const manipulator_remote_t* const gains = setup->gains;
    double given                            = 0.0;
    double square                           = 0.0;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        given -= torque_nm[i] * step_rad[i];
        square += torque_nm[i] * torque_nm[i];
    }
    const double excess = given - (yield->reserve.reserve_j + gains->tolerance);
    if ((given > 0.0) && (excess > 0.0)) {
        // The reserve is never below -tolerance, so excess <= given: the step is shortened, not reversed.
        for (unsigned i = 0U; i < ARM_JOINTS; i++) {
            step_rad[i] += (excess / square) * torque_nm[i];
        }
        given -= excess;
    }
    yield->taken_j += (given < 0.0) ? -given : 0.0;
    control_reserve_add(&yield->reserve, -given, gains->reserve);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        yield->acted_rad[i] += step_rad[i];
    }
}

const double* manipulator_arm_yield_step(manipulator_arm_yield_t* const yield,
                                         const manipulator_arm_yield_setup_t* const setup,
                                         const manipulator_arm_yield_sample_t* const sample)
{
    FSW_ASSERT((yield != NULL) && (setup != NULL) && (sample != NULL));
    if (!yield->is_started) {
        manipulator_arm_yield_reset(yield, sample);
        return yield->is_started ? yield->acted_rad : NULL;
    }
    double way[ARM_JOINTS];
    double torque[ARM_JOINTS];
    double step[ARM_JOINTS];
    give_way(yield, setup, sample, way);
    if (has_hand(sample)) {
        control_reserve_take_sum(&yield->reserve, sample->paid_j);
        yield->hand_rad[0] = sample->hand_rad[0];
        yield->hand_rad[1] = sample->hand_rad[1];
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double asked = yield->hand_rad[i] + way[i];
        const double late  = LEAD_SHARE * (yield->asked_rad[i] - yield->acted_rad[i]);
        step[i]            = (asked - yield->asked_rad[i]) + control_clamp(late, -LEAD_MAX_RAD, LEAD_MAX_RAD);
        torque[i]          = setup->gains->force_scale * sample->external_nm[i];
        yield->asked_rad[i] = asked;
    }
    take_step(yield, setup, torque, step);
    return yield->acted_rad;
}
