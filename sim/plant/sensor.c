// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/sensor.h"

#include <math.h>

#define PI 3.14159265358979323846
#define STREAM_NOISE 0x6E6F697365U // Separate streams of one (seed, device, step).
#define STREAM_UNIFORM 0x756E69666FU

/// Mix 64 bits so that each output bit depends on each input bit (finaliser of splitmix64).
static uint64_t mix(uint64_t value)
{
    value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
    value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
    return value ^ (value >> 31U);
}

static uint64_t key(const uint64_t seed, const uint32_t device, const uint64_t step, const uint64_t stream)
{
    return mix(mix(mix(seed + 0x9E3779B97F4A7C15U) ^ (stream << 20U) ^ device) ^ step);
}

double sensor_noise(const uint64_t seed, const uint32_t device, const uint64_t step)
{
    // Twelve uniforms of variance 1/12 in [0, 1), three from each word of 63 bits; their sum is exact.
    const uint64_t base = key(seed, device, step, STREAM_NOISE);
    uint64_t sum        = 0U;
    for (uint64_t word = 1U; word <= 4U; word++) {
        const uint64_t bits = mix(base + word * 0x9E3779B97F4A7C15U);
        sum += (bits & 0x1FFFFFU) + ((bits >> 21U) & 0x1FFFFFU) + ((bits >> 42U) & 0x1FFFFFU);
    }
    return (double)sum / 2097152.0 - 6.0;
}

double sensor_uniform(const uint64_t seed, const uint32_t device, const uint64_t step)
{
    return (double)(key(seed, device, step, STREAM_UNIFORM) >> 11U) / 4503599627370496.0 - 1.0;
}

double torque_ripple(const torque_ripple_t* const ripple, const double motor_position_rad)
{
    return (ripple->amplitude_nm == 0.0) ? 0.0
                                         : ripple->amplitude_nm * sin(ripple->waves * motor_position_rad);
}

void torque_sensor_init(torque_sensor_t* const sensor, const torque_sensor_parameters_t* const parameters,
                        const uint64_t seed, const uint32_t device)
{
    sensor->parameters = *parameters;
    sensor->seed       = seed;
    sensor->device     = device;
    sensor->offset_nm  = parameters->offset_max_nm * sensor_uniform(seed, device, 0U);
    sensor->drift_nm_s = parameters->drift_max_nm_s * sensor_uniform(seed, device, 1U);
}

double torque_sensor_read(const torque_sensor_t* const sensor, const uint64_t step, const uint64_t time_ns,
                          const double torque_nm, const double motor_position_rad)
{
    const torque_sensor_parameters_t* parameters = &sensor->parameters;
    const double noise   = parameters->noise_rms_nm * sensor_noise(sensor->seed, sensor->device, step);
    const double drift   = sensor->drift_nm_s * (double)time_ns * 1.0e-9;
    const double ripple  = torque_ripple(&parameters->ripple, motor_position_rad);
    const double reading = torque_nm + sensor->offset_nm + drift + noise + ripple;
    return fmax(-parameters->range_nm, fmin(parameters->range_nm, reading));
}

int64_t encoder_count(const encoder_parameters_t* const parameters, const double position_rad)
{
    const double turns = position_rad * parameters->gear_ratio / (2.0 * PI);
    return (int64_t)floor(turns * (double)parameters->counts_per_turn);
}

double encoder_read(const encoder_parameters_t* const parameters, const double position_rad)
{
    const double quantum = 2.0 * PI / ((double)parameters->counts_per_turn * parameters->gear_ratio);
    return (double)encoder_count(parameters, position_rad) * quantum;
}
