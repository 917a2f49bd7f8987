// SPDX-License-Identifier: Apache-2.0
/// Converts the types of a world into the parameters of drives, joysticks and sensors of the plant.
#ifndef SIM_PLANT_PARAMETERS_H
#define SIM_PLANT_PARAMETERS_H

#include "sim/plant/plant.h"
#include "sim/plant/sensor.h"
#include "sim/world/world.h"

/// Returns the parameters of a drive of this type with these end stops.
plant_drive_t plant_drive_of(const world_drive_type_t* type, double lower_rad, double upper_rad);
/// Apply the differences of one drive from its type.
void plant_drive_vary(plant_drive_t* drive, const world_drive_difference_t* difference);
torque_sensor_parameters_t torque_sensor_of(const world_drive_type_t* type);
encoder_parameters_t encoder_of(const world_drive_type_t* type);
/// Parameters of the encoders of a joystick, which are on its axes, without a gear.
encoder_parameters_t stick_encoder_of(const world_joystick_t* joystick);

#endif // SIM_PLANT_PARAMETERS_H
