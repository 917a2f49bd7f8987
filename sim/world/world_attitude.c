// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_attitude.h"

#include "sim/world/world_internal.h"

#include <math.h>

const field_t world_wheel_fields[WORLD_WHEEL_FIELDS] = {
    ADDRESS(world_wheel_t),
    TEXT(world_wheel_t, "eds", device.eds),
    TEXT(world_wheel_t, "on", on),
    VECTOR(world_wheel_t, "axis", axis),
    NUMBER(world_wheel_t, "momentum", momentum, 1e-9, GREAT),
    NUMBER(world_wheel_t, "torque", torque, 1e-9, GREAT),
    {"start", FIELD_NUMBER, offsetof(world_wheel_t, start), -GREAT, GREAT, true},
    OPTIONAL(world_wheel_t, "gainSpread", gain_spread, 0.0, SHARE_MAX)};

status_t world_wheel_finish(world_t* const world, const element_t* const element, void* const record)
{
    world_wheel_t* wheel = record;
    const double length  = sqrt(wheel->axis[0] * wheel->axis[0] + wheel->axis[1] * wheel->axis[1] +
                                wheel->axis[2] * wheel->axis[2]);
    if (length < 1e-3) {
        return element_refuse(element, element_attribute(element, "axis"),
                              "a vector of length 0.001 or more");
    }
    if (fabs(wheel->start) > wheel->momentum) {
        return element_refuse(element, element_attribute(element, "start"),
                              "a start from -momentum to momentum");
    }
    for (unsigned i = 0U; i < 3U; i++) {
        wheel->axis[i] /= length;
    }
    const status_t status = world_find_frame(world, element, wheel->on, &wheel->robot, &wheel->frame);
    return (status == STATUS_OK) ? world_take_device(world, element, &wheel->device) : status;
}

#define SENSOR                                                                                               \
    ADDRESS(world_sensor_t), TEXT(world_sensor_t, "eds", device.eds), TEXT(world_sensor_t, "on", on)
#define RATE(is_optional)                                                                                    \
    {                                                                                                        \
        "rate", FIELD_NUMBER, offsetof(world_sensor_t, rate_hz), 1e-3, 1e4, is_optional                      \
    }
#define DEVIATIONS(attribute, member)                                                                        \
    {                                                                                                        \
        attribute, FIELD_VECTOR, offsetof(world_sensor_t, member), 0.0, 1e3, false                           \
    }

const field_t world_gyro_fields[WORLD_GYRO_FIELDS] = {SENSOR, RATE(true),
                                                      NUMBER(world_sensor_t, "noise", gyro_noise, 0.0, 1e3),
                                                      NUMBER(world_sensor_t, "bias", bias, 0.0, 1e3)};

const field_t world_tracker_fields[WORLD_TRACKER_FIELDS] = {SENSOR, RATE(false), DEVIATIONS("noise", noise)};

const field_t world_camera_fields[WORLD_CAMERA_FIELDS] = {
    SENSOR,
    RATE(false),
    DEVIATIONS("noise", noise),
    DEVIATIONS("angleNoise", angle_noise),
    TEXT(world_sensor_t, "sees", sees),
    {"at", FIELD_VECTOR, offsetof(world_sensor_t, at), -FAR_M, FAR_M, true},
    {"rpy", FIELD_VECTOR, offsetof(world_sensor_t, rpy), -TURNS_RAD, TURNS_RAD, true},
    OPTIONAL(world_sensor_t, "atSpread", at_spread, 0.0, FAR_M),
    OPTIONAL(world_sensor_t, "rpySpread", rpy_spread, 0.0, TURNS_RAD),
    {"delay", FIELD_TIME, offsetof(world_sensor_t, delay_ns), 0.0, 1e10, false},
    {"loss", FIELD_NUMBER, offsetof(world_sensor_t, loss), 0.0, 1.0, false}};

static status_t finish_sensor(world_t* const world, const element_t* const element,
                              world_sensor_t* const sensor, const world_sensor_kind_t kind)
{
    sensor->kind          = kind;
    const status_t status = world_find_frame(world, element, sensor->on, &sensor->robot, &sensor->frame);
    return (status == STATUS_OK) ? world_take_device(world, element, &sensor->device) : status;
}

status_t world_gyro_finish(world_t* const world, const element_t* const element, void* const record)
{
    return finish_sensor(world, element, record, SENSOR_GYRO);
}

status_t world_tracker_finish(world_t* const world, const element_t* const element, void* const record)
{
    return finish_sensor(world, element, record, SENSOR_STAR_TRACKER);
}

status_t world_camera_finish(world_t* const world, const element_t* const element, void* const record)
{
    world_sensor_t* sensor = record;
    if ((sensor->delay_ns * sensor->rate_hz) > (WORLD_DELAY_PERIODS * 1e9)) {
        return element_refuse(element, element_attribute(element, "delay"),
                              "a delay of at most 8 periods of rate");
    }
    const status_t status =
        world_find_frame(world, element, sensor->sees, &sensor->seen_robot, &sensor->seen_frame);
    return (status == STATUS_OK) ? finish_sensor(world, element, sensor, SENSOR_POSE_CAMERA) : status;
}
