// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_internal.h"

#include "osal/include/osal/can_interface.h"

#include <string.h>

#define FLIGHT_NAME "FLIGHT" // Scenarios name the controller of the flight software so (sim/app/faults.c).

bool world_is_lower_name(const char* const name, const size_t most)
{
    static const char* const letters = "abcdefghijklmnopqrstuvwxyz";
    const size_t length              = strlen(name);
    return (length <= most) && (length > 0U) && (strchr(letters, name[0]) != NULL) &&
           (strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_-") == length);
}

const char* world_find_robot(const world_t* const world, const char* const name, unsigned* const out_robot)
{
    const char* dot = strchr(name, '.');
    for (size_t i = 0U; (dot != NULL) && (i < world->robot_count); i++) {
        const char* robot = world->robot[i].name;
        if ((strlen(robot) == (size_t)(dot - name)) && (strncmp(robot, name, strlen(robot)) == 0)) {
            *out_robot = (unsigned)i;
            return &dot[1];
        }
    }
    return NULL;
}

status_t world_find_frame(const world_t* const world, const element_t* const element, const char* const name,
                          unsigned* const out_robot, unsigned* const out_frame)
{
    const char* link = world_find_robot(world, name, out_robot);
    if (link != NULL) {
        const robot_model_t* model = &world->robot[*out_robot].model;
        *out_frame                 = (unsigned)robot_model_frame(model, link);
        if (*out_frame < model->frame_count) {
            return STATUS_OK;
        }
    }
    return element_refuse(element, name, "robot.link of a robot above");
}

status_t world_find_type(const world_t* const world, const element_t* const element, const char* const name,
                         unsigned* const out_type)
{
    for (size_t i = 0U; i < world->drive_type_count; i++) {
        if (strcmp(world->drive_type[i].name, name) == 0) {
            *out_type = (unsigned)i;
            return STATUS_OK;
        }
    }
    return element_refuse(element, name, "a DriveType above");
}

#define DEVICES(member)                                                                                      \
    {                                                                                                        \
        offsetof(world_t, member) + offsetof(world_##member##_t, device), sizeof(world_##member##_t),        \
            offsetof(world_t, member##_count)                                                                \
    }

const world_device_t* world_device_at(const world_t* const world, size_t index)
{
    static const struct {
        size_t first; // Offset of the device of the first record.
        size_t stride;
        size_t count;
    } arrays[] = {DEVICES(drive), DEVICES(joystick),  DEVICES(bench), DEVICES(power_unit),
                  DEVICES(wheel), DEVICES(valve_box), DEVICES(sensor)};
    for (size_t i = 0U; i < COUNT_OF(arrays); i++) {
        const char* start  = (const char*)world;
        const size_t count = *(const size_t*)(const void*)(start + arrays[i].count);
        if (index < count) {
            return (const world_device_t*)(const void*)(start + arrays[i].first + (index * arrays[i].stride));
        }
        index -= count;
    }
    return NULL;
}

static bool has_instrument(const world_t* const world, const char* const name)
{
    size_t index = 0U;
    while ((index < world->instrument_count) && (strcmp(world->instrument[index].name, name) != 0)) {
        index++;
    }
    return index < world->instrument_count;
}

status_t world_take_device(world_t* const world, const element_t* const element, world_device_t* const device)
{
    const world_device_t* other = NULL;
    device->line                = element->line;
    device->bus                 = 0U;
    if (!world_is_lower_name(device->bus_name, OSAL_CAN_INTERFACE_NAME_MAX)) {
        return element_refuse(element, device->bus_name,
                              "a lower-case name of a bus with at most 15 characters");
    }
    if (strcmp(device->name, FLIGHT_NAME) == 0) {
        return element_refuse(element, device->name,
                              "another name: in scenarios this is the controller of the flight software");
    }
    if (has_instrument(world, device->bus_name)) {
        return element_refuse(
            element, device->bus_name,
            "a name of a bus that no Instrument above has: `fault unplug` names a bus or an Instrument");
    }
    while ((device->bus < world->bus_count) && (strcmp(world->bus[device->bus], device->bus_name) != 0)) {
        device->bus++;
    }
    for (size_t i = 0U; (other = world_device_at(world, i)) != NULL; i++) {
        if (other == device) {
            continue;
        }
        if (strcmp(other->name, device->name) == 0) {
            return element_refuse(element, device->name, "a name that no device above has");
        }
        if ((other->bus == device->bus) && (other->node == device->node)) {
            return element_refuse(element, element_attribute(element, "node"),
                                  "a node id that no device above has on this bus");
        }
    }
    if (device->bus == world->bus_count) {
        if (world->bus_count == WORLD_BUSES_MAX) {
            return element_refuse(element, device->bus_name, "at most 8 buses");
        }
        memcpy(world->bus[device->bus], device->bus_name, sizeof world->bus[0]);
        world->bus_count++;
    }
    return STATUS_OK;
}
