// SPDX-License-Identifier: Apache-2.0
/// The measurements of the sensors of a world: the true values with noise, bias and losses drawn from the
/// seed.
///
/// A gyro has three values, the rate in the axes of its link [rad/s]. A star tracker has four, the quaternion
/// w, x, y, z from the axes of its link to those of the world, w >= 0. A pose camera has six, the position of
/// the link that it measures [m] and x, y, z of its quaternion (w >= 0), both in the axes of the camera.
///
/// Ownership  The caller provides sensor_t. Plant and world outlive it.
#ifndef SIM_APP_SENSORS_H
#define SIM_APP_SENSORS_H

#include "sim/plant/plant.h"
#include "sim/world/world.h"

#include <stdbool.h>
#include <stdint.h>

#define SENSOR_VALUES_MAX 8U ///< Most values of a sensor.

typedef struct {
    const plant_t* plant;
    const world_sensor_t* element; ///< Its element of the world.
    uint64_t seed;
    uint32_t device; ///< Number of the device, unique in the run, for its noise.
} sensor_t;

/// Returns the number of values of a kind of sensor.
unsigned sensor_values(world_sensor_kind_t kind);
/// measuring_config_t.measure; the context is a sensor_t. False: a pose camera found no pose.
bool sensor_measure(void* context, uint64_t number, double* out_values);

#endif // SIM_APP_SENSORS_H
