// SPDX-License-Identifier: Apache-2.0
/// A rigid arm on elastic joints for tests of its control: rotors, gears as springs, and links, integrated by
/// semi-implicit Euler in small steps. The equations are written independently of the controller's model.
#ifndef TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_RIGID_ARM_H
#define TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_RIGID_ARM_H

#include "generated/manipulator_descriptor.h"

#include <stdbool.h>

typedef struct {
    manipulator_model_t model;
    double link[2];
    double link_speed[2];
    double motor[2];
    double motor_speed[2];
    double external_nm[2]; ///< Torque on the links from outside.
    bool is_braked;        ///< The brakes hold the rotors.
} rigid_arm_t;

/// Place the arm at rest in a pose; the gears carry gravity.
void rigid_arm_init(rigid_arm_t* arm, const manipulator_model_t* model, const double pose_rad[2]);
/// One control period of 0.5 ms with constant motor torque.
void rigid_arm_run(rigid_arm_t* arm, const double torque_nm[2]);
/// Torque in the gears, which the sensors measure.
void rigid_arm_sensors(const rigid_arm_t* arm, double out_torque_nm[2]);
/// Gains of the descriptor.
extern const manipulator_control_t rigid_arm_gains;
extern const manipulator_model_t rigid_arm_model;

#endif // TEST_UNIT_FSW_SUBSYSTEMS_MANIPULATOR_RIGID_ARM_H
