// SPDX-License-Identifier: Apache-2.0
/// Zero of the joint torque sensors: mean of measured minus gravity torque, at rest and free of contact.
///
/// Motion restarts the mean. An offset beyond the ceiling is treated as contact: the tare fails and the old
/// zero stays.
///
/// Ownership  The caller places manipulator_arm_tare_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H

#include "base/status.h"
#include "fsw/subsystems/manipulator/manipulator_model.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {     // Read-only outside.
    status_t result; ///< STATUS_EMPTY (never begun), STATUS_BUSY, STATUS_OK, STATUS_OUT_OF_RANGE (contact).
    uint32_t samples;
    double sum_nm[ARM_JOINTS];
    double offset_nm[ARM_JOINTS]; ///< The zero in force.
} manipulator_arm_tare_t;

typedef struct {                      // One sample.
    double difference_nm[ARM_JOINTS]; ///< Measured torque minus gravity torque of the model.
    double velocity_rad_s[ARM_JOINTS];
} manipulator_arm_tare_sample_t;

void manipulator_arm_tare_init(manipulator_arm_tare_t* tare);
void manipulator_arm_tare_begin(manipulator_arm_tare_t* tare);
/// Take a sample in, if a tare is running. `samples` of them in a row, at rest, make the mean.
/// Returns tare->result.
status_t manipulator_arm_tare_step(manipulator_arm_tare_t* tare, const manipulator_arm_tare_sample_t* sample,
                                   uint32_t samples, double ceiling_nm);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H
