// SPDX-License-Identifier: Apache-2.0
/// Every engineering value of the simulated mission rokviss in one place; rokviss.c tags each one with its
/// source.
#ifndef SIM_PARAMETERS_ROKVISS_H
#define SIM_PARAMETERS_ROKVISS_H

#include "sim/operator/hand.h"
#include "sim/plant/plant.h"
#include "sim/plant/sensor.h"

#define ROKVISS_STEP_NS 500000U ///< Base step of the simulator: 2 kHz.

extern const plant_parameters_t rokviss_plant;
extern const hand_parameters_t rokviss_hand;
extern const torque_sensor_parameters_t rokviss_torque_sensor;
extern const encoder_parameters_t rokviss_joint_encoder;
extern const encoder_parameters_t rokviss_stick_encoder;

#endif // SIM_PARAMETERS_ROKVISS_H
