// SPDX-License-Identifier: Apache-2.0
/// Tare: determines the zero of the joint torque sensors as the mean of measured minus gravity torque, at
/// rest and without contact.
///
/// A motion restarts the mean. An offset beyond the ceiling counts as a contact: the tare fails and the old
/// zero stays in force.
///
/// Ownership  The caller provides manipulator_arm_tare_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H
#define FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H

#include "base/status.h"
#include "fsw/subsystems/manipulator/manipulator_model.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {     // Read-only outside.
    status_t result; ///< STATUS_EMPTY (not begun), STATUS_BUSY, STATUS_OK, STATUS_OUT_OF_RANGE (contact).
    uint32_t samples;
    double sum_nm[ARM_JOINTS];
    double offset_nm[ARM_JOINTS]; ///< Zero of the last tare that succeeded.
} manipulator_arm_tare_t;

typedef struct {                      // One sample.
    double difference_nm[ARM_JOINTS]; ///< Measured torque minus gravity torque of the model.
    double velocity_rad_s[ARM_JOINTS];
} manipulator_arm_tare_sample_t;

void manipulator_arm_tare_init(manipulator_arm_tare_t* tare);
void manipulator_arm_tare_begin(manipulator_arm_tare_t* tare);
/// Process a sample if a tare is running. The mean is that of `samples` consecutive samples at rest. Returns
/// tare->result.
status_t manipulator_arm_tare_step(manipulator_arm_tare_t* tare, const manipulator_arm_tare_sample_t* sample,
                                   uint32_t samples, double ceiling_nm);

#endif // FSW_SUBSYSTEMS_MANIPULATOR_MANIPULATOR_TARE_H
