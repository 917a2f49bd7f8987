// SPDX-License-Identifier: Apache-2.0
// Devices and networks of drives.h: look-up and counters.
#include "fsw/drives/drives.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

canopen_network_t* drives_network(drives_t* const drives, const descriptor_endnode_t* const endnode)
{
    FSW_ASSERT((drives != NULL) && (endnode != NULL));
    uint8_t bus = 0U;
    while (strcmp(drives->buses[bus].endnode->bus, endnode->bus) != 0) {
        bus++;
        FSW_ASSERT(bus < drives->bus_count); // list_buses has listed every bus.
    }
    return &drives->buses[bus].network;
}

uint8_t drives_find(const drives_t* const drives, const uint32_t node)
{
    FSW_ASSERT(drives != NULL);
    for (uint8_t i = 0U; i < drives->device_count; i++) {
        if (drives->devices[i].device.node == node) {
            return i;
        }
    }
    return NETWORK_NO_DEVICE;
}

void drives_note_devices(drives_t* const drives, const descriptor_configuration_t* const configuration)
{
    FSW_ASSERT((drives != NULL) && (configuration != NULL));
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    drives->index_count                            = 0U;
    for (uint16_t i = 0U; i < configuration->device_count; i++) {
        const descriptor_endnode_t* const endnode =
            drives_endnode(descriptor, &descriptor->devices[configuration->first_device + i]);
        if (endnode != NULL) {
            FSW_ASSERT(drives->index_count < DESCRIPTOR_DEVICES_MAX); // The descriptor has no more devices.
            drives->indices[drives->index_count] = drives_find(drives, endnode->node);
            drives->index_count++;
        }
    }
}

/// Returns the index in drives_t.devices of device number `position` on CAN of the applied configuration, or
/// NETWORK_NO_DEVICE.
static uint8_t index_of(const drives_t* const drives, const uint16_t position)
{
    return ((drives->configuration != NULL) && (position < drives->index_count)) ? drives->indices[position]
                                                                                 : NETWORK_NO_DEVICE;
}

canopen_device_t* drives_device(drives_t* const drives, const uint16_t position)
{
    FSW_ASSERT(drives != NULL);
    const uint8_t index = index_of(drives, position);
    return (index != NETWORK_NO_DEVICE) ? &drives->devices[index].device : NULL;
}

bool drives_are_running(const drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    bool are_all = (drives->bus_count > 0U);
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        are_all = are_all && drives->buses[i].network.is_running;
    }
    return are_all;
}

uint32_t drives_missed(const drives_t* const drives, const uint16_t position)
{
    FSW_ASSERT(drives != NULL);
    const uint8_t index = index_of(drives, position);
    return (index != NETWORK_NO_DEVICE) ? drives->devices[index].missed : 0U;
}

uint32_t drives_limited(const drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    uint32_t sum = 0U;
    for (uint8_t i = 0U; i < drives->device_count; i++) {
        for (uint8_t k = 0U; k < PROFILE_AXES_MAX; k++) {
            sum += drives->devices[i].device.axes[k].limited;
        }
    }
    return sum;
}
