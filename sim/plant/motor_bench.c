// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/motor_bench.h"

#include "sim/plant/plant_internal.h"

void motor_bench_init(motor_bench_t* const bench, const plant_drive_t* const drive, const double contact_rad,
                      const double stiffness_nm_rad)
{
    *bench =
        (motor_bench_t){.drive = drive, .contact_rad = contact_rad, .stiffness_nm_rad = stiffness_nm_rad};
}

void motor_bench_step(motor_bench_t* const bench, const bool brake, const double motor_torque_nm,
                      const double h_s)
{
    const double beyond     = bench->rotor.position_rad - bench->contact_rad;
    bench->output_torque_nm = (beyond > 0.0) ? bench->stiffness_nm_rad * beyond : 0.0;
    (void)joint_rotor_step(bench->drive, &bench->rotor, brake, motor_torque_nm, bench->output_torque_nm, h_s);
}
