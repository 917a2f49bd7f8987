// SPDX-License-Identifier: Apache-2.0
/// The elements of a world that turn a spacecraft or measure its attitude: wheels, gyros, star trackers,
/// cameras. Private to sim/world.
#ifndef SIM_WORLD_WORLD_ATTITUDE_H
#define SIM_WORLD_WORLD_ATTITUDE_H

#include "sim/world/document.h"
#include "sim/world/world.h"

#define WORLD_WHEEL_FIELDS 10U
#define WORLD_GYRO_FIELDS 8U
#define WORLD_TRACKER_FIELDS 7U
#define WORLD_CAMERA_FIELDS 15U
#define WORLD_DELAY_PERIODS 8.0 ///< Largest delay of a camera, in periods of its images.

extern const field_t world_wheel_fields[WORLD_WHEEL_FIELDS];
extern const field_t world_gyro_fields[WORLD_GYRO_FIELDS];
extern const field_t world_tracker_fields[WORLD_TRACKER_FIELDS];
extern const field_t world_camera_fields[WORLD_CAMERA_FIELDS];
/// Find the objects that an element names, and check its values. `record`: the attributes that were read, a
/// world_wheel_t or (the other three) a world_sensor_t. STATUS_OK, STATUS_INVALID (element->error is filled).
MUST_USE status_t world_wheel_finish(world_t* world, const element_t* element, void* record);
MUST_USE status_t world_gyro_finish(world_t* world, const element_t* element, void* record);
MUST_USE status_t world_tracker_finish(world_t* world, const element_t* element, void* record);
MUST_USE status_t world_camera_finish(world_t* world, const element_t* element, void* record);

#endif // SIM_WORLD_WORLD_ATTITUDE_H
