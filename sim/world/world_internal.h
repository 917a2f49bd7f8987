// SPDX-License-Identifier: Apache-2.0
/// Names, addresses and fields that several kinds of elements of a world have. Private to sim/world.
#ifndef SIM_WORLD_WORLD_INTERNAL_H
#define SIM_WORLD_WORLD_INTERNAL_H

#include "sim/world/world.h"

#define FAR_M 1e4     // Largest coordinate [m] or linear velocity [m/s] in a world.
#define TURNS_RAD 1e3 // Largest angle [rad] or angular velocity [rad/s] in a world.
#define GREAT 1e9     // Largest value of all other physical quantities in a world, in SI units.
#define SHARE_MAX 0.5 // Largest relative difference of a true parameter from its nominal value.
#define WORLD_NAME_MAX 32U
#define NODE_MIN 2.0
#define NODE_MAX 127.0

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
// Rows of a table of the attributes of an element: attribute, its form, the member that gets the value,
// lowest and highest value, and whether the attribute is optional.
#define NAME(type, attribute, member)                                                                        \
    {                                                                                                        \
        attribute, FIELD_NAME, offsetof(type, member), 0.0, 0.0, false                                       \
    }
#define TEXT(type, attribute, member)                                                                        \
    {                                                                                                        \
        attribute, FIELD_TEXT, offsetof(type, member), 0.0, 0.0, false                                       \
    }
#define NUMBER(type, attribute, member, low, high)                                                           \
    {                                                                                                        \
        attribute, FIELD_NUMBER, offsetof(type, member), low, high, false                                    \
    }
#define OPTIONAL(type, attribute, member, low, high)                                                         \
    {                                                                                                        \
        attribute, FIELD_NUMBER, offsetof(type, member), low, high, true                                     \
    }
#define VECTOR(type, attribute, member)                                                                      \
    {                                                                                                        \
        attribute, FIELD_VECTOR, offsetof(type, member), -FAR_M, FAR_M, false                                \
    }
#define UNSIGNED(type, attribute, member, low, high)                                                         \
    {                                                                                                        \
        attribute, FIELD_UNSIGNED, offsetof(type, member), low, high, false                                  \
    }
// The attributes that every device on a bus has.
#define ADDRESS(type)                                                                                        \
    NAME(type, "name", device.name), NAME(type, "bus", device.bus_name),                                     \
        UNSIGNED(type, "node", device.node, NODE_MIN, NODE_MAX)

/// True for a name of at most `most` characters: a lower-case letter, then lower-case letters, digits, '_'
/// and '-'.
bool world_is_lower_name(const char* name, size_t most);
/// Find the robot of "robot.name", and set *out_robot to its index. Returns the part after the dot; null if
/// there is no such robot.
const char* world_find_robot(const world_t* world, const char* name, unsigned* out_robot);
/// Find the frame that robot.link names. STATUS_OK, or STATUS_INVALID with the error.
MUST_USE status_t world_find_frame(const world_t* world, const element_t* element, const char* name,
                                   unsigned* out_robot, unsigned* out_frame);
/// Find a DriveType. STATUS_OK, or STATUS_INVALID with the error.
MUST_USE status_t world_find_type(const world_t* world, const element_t* element, const char* name,
                                  unsigned* out_type);
/// Device number `index`, counted over all kinds; null if there are fewer.
const world_device_t* world_device_at(const world_t* world, size_t index);
/// Check the name and address of a device, and find its bus; add the bus if no earlier device has it.
/// STATUS_OK, or STATUS_INVALID with the error.
MUST_USE status_t world_take_device(world_t* world, const element_t* element, world_device_t* device);

#endif // SIM_WORLD_WORLD_INTERNAL_H
