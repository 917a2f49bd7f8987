// SPDX-License-Identifier: Apache-2.0
/// Parameters of the plant, the sensors and the hand from a world. What this plant cannot carry is refused by
/// file and line: it has one fixed robot, whose two joints turn about -y, in the order of its bodies along x;
/// a sphere at its tip, which touches one fixture of a box and a bump across it, and pulls one cable spring;
/// and one joystick of two axes.
#ifndef SIM_PLANT_PARAMETERS_H
#define SIM_PLANT_PARAMETERS_H

#include "sim/plant/plant.h"
#include "sim/plant/sensor.h"
#include "sim/world/world.h"

/// STATUS_OK, or STATUS_INVALID with `error` filled.
MUST_USE status_t plant_parameters_take(const world_t* world, plant_parameters_t* out_parameters,
                                        char error[DOCUMENT_ERROR_MAX]);
/// A drive of a type, with its end stops.
plant_drive_t plant_drive_of(const world_drive_type_t* type, double lower_rad, double upper_rad);
torque_sensor_parameters_t torque_sensor_of(const world_drive_type_t* type);
encoder_parameters_t encoder_of(const world_drive_type_t* type);
/// The encoders of a joystick are on its axes.
encoder_parameters_t stick_encoder_of(const world_joystick_t* joystick);

#endif // SIM_PLANT_PARAMETERS_H
