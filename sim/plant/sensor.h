// SPDX-License-Identifier: Apache-2.0
/// Sensor errors: computes the measured value from the true state.
///
/// Noise is a function of (seed, device, step) only: adding a device or omitting a sample does not change the
/// noise of other devices. The noise does not use libm, so it is the same on every machine.
#ifndef SIM_PLANT_SENSOR_H
#define SIM_PLANT_SENSOR_H

#include <stdint.h>

/// Standard normal variate (sum of twelve uniforms, within +-6) for (seed, device, step).
double sensor_noise(uint64_t seed, uint32_t device, uint64_t step);

/// Uniform variate in [-1, 1) for (seed, device, step), independent of sensor_noise.
double sensor_uniform(uint64_t seed, uint32_t device, uint64_t step);

/// A periodic torque of a motor or gear, or a periodic error of a torque sensor: a sine of the motor angle.
typedef struct {
    double amplitude_nm;
    /// Radians of the sine per radian of the joint: periods per turn of the motor times gear ratio.
    double waves;
} torque_ripple_t;

/// Returns the torque at a position of the motor; the position is referred to the joint.
double torque_ripple(const torque_ripple_t* ripple, double motor_position_rad);

typedef struct {
    double noise_rms_nm;
    double offset_max_nm;  ///< Largest offset: the offset is drawn from +- this.
    double drift_max_nm_s; ///< Largest drift: the drift is drawn from +- this.
    torque_ripple_t ripple;
    double range_nm; ///< Saturates at +- this; 0: the drive has no torque sensor.
} torque_sensor_parameters_t;

/// One torque sensor. All fields are private.
typedef struct {
    torque_sensor_parameters_t parameters;
    uint64_t seed;
    uint32_t device;
    double offset_nm;
    double drift_nm_s;
} torque_sensor_t;

/// Draw offset and drift. `device` is unique in the run (bus number << 8 | node id is a good choice).
void torque_sensor_init(torque_sensor_t* sensor, const torque_sensor_parameters_t* parameters, uint64_t seed,
                        uint32_t device);

/// Reading for a true torque at a step and position of the motor, not quantised; the same arguments give the
/// same reading.
double torque_sensor_read(const torque_sensor_t* sensor, uint64_t step, uint64_t time_ns, double torque_nm,
                          double motor_position_rad);

typedef struct {
    uint32_t counts_per_turn; ///< Counts per turn of the encoder's own shaft.
    double gear_ratio;        ///< Turns of that shaft per turn of the joint or stick; 1 without a gear.
} encoder_parameters_t;

/// Count of the encoder at a true position, rounded down, as an edge counter does.
int64_t encoder_count(const encoder_parameters_t* parameters, double position_rad);

/// Returns the position that a device reports: its count in radians.
double encoder_read(const encoder_parameters_t* parameters, double position_rad);

#endif // SIM_PLANT_SENSOR_H
