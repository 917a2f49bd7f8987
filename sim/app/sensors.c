// SPDX-License-Identifier: Apache-2.0
#include "sim/app/sensors.h"

#include "sim/plant/sensor.h"

#include <math.h>
#include <string.h>

#define CHANNEL_SHIFT 16U ///< Position of the number of a device's value in the key of its noise.
#define LOSS_CHANNEL 15U  ///< Key of the random number that decides whether a pose is lost.

unsigned sensor_values(const world_sensor_kind_t kind)
{
    static const unsigned values[] = {
        [SENSOR_GYRO] = 3U, [SENSOR_STAR_TRACKER] = 4U, [SENSOR_POSE_CAMERA] = 6U};
    return values[kind];
}

static double noise(const sensor_t* const sensor, const unsigned channel, const uint64_t number)
{
    return sensor_noise(sensor->seed, sensor->device | (channel << CHANNEL_SHIFT), number);
}

// ---- Quaternions: w, x, y, z ----

static void multiply(const double a[4], const double b[4], double out[4])
{
    const double product[4] = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                               a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                               a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
                               a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1]};
    memcpy(out, product, sizeof product);
}

static void conjugate(const double a[4], double out[4])
{
    out[0] = a[0];
    out[1] = -a[1];
    out[2] = -a[2];
    out[3] = -a[3];
}

/// Transform a vector from the axes of the world to other axes; `axes` is their rotation to the world.
static void into_axes(const double axes[4], const double in_world[3], double out[3])
{
    const double vector[4] = {0.0, in_world[0], in_world[1], in_world[2]};
    double back[4];
    double found[4];
    conjugate(axes, back);
    multiply(back, vector, found);
    multiply(found, axes, found);
    memcpy(out, &found[1], 3U * sizeof(double));
}

static void of_matrix(const matrix_t* const m, double out[4])
{
    // Divide by the largest component: every unit quaternion has one of at least 1/2.
    const double trace      = m->at[0][0] + m->at[1][1] + m->at[2][2];
    const double square[4]  = {1.0 + trace, 1.0 + 2.0 * m->at[0][0] - trace, 1.0 + 2.0 * m->at[1][1] - trace,
                               1.0 + 2.0 * m->at[2][2] - trace};
    const double pair[4][4] = {
        {0.0, m->at[2][1] - m->at[1][2], m->at[0][2] - m->at[2][0], m->at[1][0] - m->at[0][1]},
        {m->at[2][1] - m->at[1][2], 0.0, m->at[1][0] + m->at[0][1], m->at[0][2] + m->at[2][0]},
        {m->at[0][2] - m->at[2][0], m->at[1][0] + m->at[0][1], 0.0, m->at[2][1] + m->at[1][2]},
        {m->at[1][0] - m->at[0][1], m->at[0][2] + m->at[2][0], m->at[2][1] + m->at[1][2], 0.0}};
    unsigned most = 0U;
    for (unsigned i = 1U; i < 4U; i++) {
        most = (square[i] > square[most]) ? i : most;
    }
    const double twice = sqrt(square[most]);
    for (unsigned i = 0U; i < 4U; i++) {
        out[i] = (i == most) ? (0.5 * twice) : (0.5 * pair[most][i] / twice);
    }
}

/// Turn an attitude by small angles about its own axes, and make w positive: the camera does not send w.
static void disturb(const sensor_t* const sensor, const double deviation[3], const unsigned channel,
                    const uint64_t number, double quaternion[4])
{
    double error[4] = {1.0, 0.0, 0.0, 0.0};
    double square   = 0.0;
    for (unsigned i = 0U; i < 3U; i++) {
        error[i + 1U] = 0.5 * deviation[i] * noise(sensor, channel + i, number);
    }
    multiply(quaternion, error, quaternion);
    for (unsigned i = 0U; i < 4U; i++) {
        square += quaternion[i] * quaternion[i];
    }
    const double scale = ((quaternion[0] < 0.0) ? -1.0 : 1.0) / sqrt(square);
    for (unsigned i = 0U; i < 4U; i++) {
        quaternion[i] *= scale;
    }
}

// ---- Kinds ----

static void measure_rate(const sensor_t* const sensor, const plant_base_t* const frame, const uint64_t number,
                         double* const out_values)
{
    into_axes(frame->rotation, frame->rate_rad_s, out_values);
    for (unsigned i = 0U; i < 3U; i++) {
        const uint32_t key = sensor->device | (i << CHANNEL_SHIFT);
        // The bias is the same in each sample: its random number has always the number 0.
        out_values[i] += sensor->element->bias * sensor_uniform(sensor->seed, key, 0U) +
                         sensor->element->gyro_noise * noise(sensor, i, number);
    }
}

static bool measure_pose(const sensor_t* const sensor, const plant_base_t* const frame, const uint64_t number,
                         double* const out_values)
{
    const world_sensor_t* element = sensor->element;
    const pose_t mount            = pose_of(element->at, element->rpy);
    plant_base_t seen;
    double camera[4];
    double back[4];
    double at[3];
    double to_seen[3];
    const uint32_t key = sensor->device | (LOSS_CHANNEL << CHANNEL_SHIFT);
    if ((0.5 + 0.5 * sensor_uniform(sensor->seed, key, number)) < element->loss) {
        return false;
    }
    plant_frame(sensor->plant, element->seen_robot, element->seen_frame, &seen);
    of_matrix(&mount.rotation, camera);
    multiply(frame->rotation, camera, camera);
    conjugate(frame->rotation, back);
    into_axes(back, element->at, at); // Convert from the axes of the link to those of the world.
    for (unsigned i = 0U; i < 3U; i++) {
        to_seen[i] = seen.position_m[i] - frame->position_m[i] - at[i];
    }
    into_axes(camera, to_seen, out_values);
    conjugate(camera, back);
    multiply(back, seen.rotation, camera);
    disturb(sensor, element->angle_noise, 3U, number, camera);
    for (unsigned i = 0U; i < 3U; i++) {
        out_values[i] += element->noise[i] * noise(sensor, i, number);
        out_values[3U + i] = camera[1U + i];
    }
    return true;
}

bool sensor_measure(void* const context, const uint64_t number, double* const out_values)
{
    const sensor_t* sensor = context;
    plant_base_t frame;
    plant_frame(sensor->plant, sensor->element->robot, sensor->element->frame, &frame);
    switch (sensor->element->kind) {
    case SENSOR_GYRO:
        measure_rate(sensor, &frame, number, out_values);
        return true;
    case SENSOR_STAR_TRACKER:
        memcpy(out_values, frame.rotation, sizeof frame.rotation);
        disturb(sensor, sensor->element->noise, 0U, number, out_values);
        return true;
    case SENSOR_POSE_CAMERA:
        break;
    }
    return measure_pose(sensor, &frame, number, out_values);
}
