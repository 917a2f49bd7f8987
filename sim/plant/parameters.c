// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/parameters.h"

/// Periods of a ripple per turn of the motor: a strain-wave gear has two lobes.
#define DEFAULT_PERIODS 2.0

static torque_ripple_t ripple_of(const world_drive_type_t* const type, const double amplitude_nm,
                                 const double periods)
{
    return (torque_ripple_t){.amplitude_nm = amplitude_nm,
                             .waves        = ((periods > 0.0) ? periods : DEFAULT_PERIODS) * type->ratio};
}

plant_drive_t plant_drive_of(const world_drive_type_t* const type, const double lower_rad,
                             const double upper_rad)
{
    return (plant_drive_t){.gear_ratio            = type->ratio,
                           .rotor_inertia_kgm2    = type->rotor_inertia,
                           .gear_stiffness_nm_rad = type->stiffness,
                           .gear_damping_nms_rad  = type->damping,
                           .coulomb_nm            = type->coulomb,
                           .stiction_nm           = type->stiction,
                           .stribeck_rad_s        = type->stribeck,
                           .viscous_nms_rad       = type->viscous,
                           .ripple                = ripple_of(type, type->ripple, type->ripple_periods),
                           .brake_torque_nm       = type->brake,
                           .lower_rad             = lower_rad,
                           .upper_rad             = upper_rad,
                           .stop_nm_rad           = type->stop_stiffness,
                           .stop_nms_rad          = type->stop_damping};
}

void plant_drive_vary(plant_drive_t* const drive, const world_drive_difference_t* const difference)
{
    drive->coulomb_nm *= 1.0 + difference->friction;
    drive->stiction_nm *= 1.0 + difference->friction;
    drive->viscous_nms_rad *= 1.0 + difference->friction;
    drive->gear_stiffness_nm_rad *= 1.0 + difference->stiffness;
}

torque_sensor_parameters_t torque_sensor_of(const world_drive_type_t* const type)
{
    return (torque_sensor_parameters_t){.noise_rms_nm   = type->torque_noise,
                                        .offset_max_nm  = type->torque_offset,
                                        .drift_max_nm_s = type->torque_drift,
                                        .ripple = ripple_of(type, type->torque_ripple, type->torque_periods),
                                        .range_nm = type->torque_range};
}

encoder_parameters_t encoder_of(const world_drive_type_t* const type)
{
    return (encoder_parameters_t){.counts_per_turn = type->encoder_counts, .gear_ratio = type->ratio};
}

encoder_parameters_t stick_encoder_of(const world_joystick_t* const joystick)
{
    return (encoder_parameters_t){.counts_per_turn = joystick->encoder_counts, .gear_ratio = 1.0};
}
