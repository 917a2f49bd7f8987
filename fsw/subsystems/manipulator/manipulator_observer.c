// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_observer.h"

#include "base/assertion.h"

#include <stddef.h>

manipulator_arm_observer_gains_t manipulator_arm_observer_gains(const manipulator_control_t* const gains,
                                                                const double period_s)
{
    FSW_ASSERT(gains != NULL);
    return (manipulator_arm_observer_gains_t){
        .bandwidth_rad_s = gains->observer_bandwidth, .gain_1_s = gains->observer_gain, .period_s = period_s};
}

void manipulator_arm_observer_step(manipulator_arm_observer_t* const observer,
                                   const manipulator_model_t* const model,
                                   const manipulator_arm_observer_gains_t* const gains,
                                   const double link_rad[ARM_JOINTS], const double torque_nm[ARM_JOINTS])
{
    FSW_ASSERT((observer != NULL) && (model != NULL) && (gains != NULL));
    double velocity[ARM_JOINTS];
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        if (!observer->is_started) {
            control_tracker_reset(&observer->link[i], link_rad[i]);
        }
        control_tracker_step(&observer->link[i], link_rad[i], gains->bandwidth_rad_s, gains->period_s);
        velocity[i] = observer->link[i].velocity;
    }
    const manipulator_arm_terms_t terms = manipulator_arm_terms(model, link_rad);
    double momentum[ARM_JOINTS];
    double coriolis[ARM_JOINTS];
    manipulator_arm_inertia_times(&terms, velocity, momentum);
    manipulator_arm_coriolis_transposed(&terms, velocity, coriolis);
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        if (!observer->is_started) {
            observer->momentum[i] = momentum[i];
        }
        const double known = torque_nm[i] + coriolis[i] - terms.gravity_nm[i];
        observer->momentum[i] += gains->period_s * (known + observer->external_nm[i]);
        observer->external_nm[i] = gains->gain_1_s * (momentum[i] - observer->momentum[i]);
    }
    observer->is_started = true;
}
