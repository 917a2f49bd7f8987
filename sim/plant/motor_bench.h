// SPDX-License-Identifier: Apache-2.0
/// A motor without a robot: the rotor of a joint with friction, brake and end stops. Above a given angle its
/// output touches an elastic object. This model is sufficient for a gripper, a shutter, or a drive on a
/// table.
///
/// Ownership  The caller provides motor_bench_t.
/// Context    One task.
/// Results    Bit-identical if the same calls are repeated.
#ifndef SIM_PLANT_MOTOR_BENCH_H
#define SIM_PLANT_MOTOR_BENCH_H

#include "sim/plant/plant.h"

#include <stdbool.h>

typedef struct { // Read-only for others.
    const plant_drive_t* drive;
    plant_rotor_t rotor;
    double contact_rad;      ///< Angle above which the output touches the object.
    double stiffness_nm_rad; ///< Stiffness of the elastic object; 0: there is no object.
    double output_torque_nm; ///< Gear torque on the output, as the drive's torque sensor measures it.
} motor_bench_t;

/// Initialise a bench at rest at angle 0. The drive must exist as long as the bench.
void motor_bench_init(motor_bench_t* bench, const plant_drive_t* drive, double contact_rad,
                      double stiffness_nm_rad);
/// Advance by h_s under the torque of the motor, with the brake on or off.
void motor_bench_step(motor_bench_t* bench, bool brake, double motor_torque_nm, double h_s);

#endif // SIM_PLANT_MOTOR_BENCH_H
