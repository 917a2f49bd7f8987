// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_homing.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"

#include <stddef.h>

/// Returns device number `position` of the applied configuration (stream devices are counted) if it is in
/// mode homing; otherwise null.
static canopen_device_t* homing_device(drives_t* const drives, const uint16_t position)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const descriptor_device_t* const device =
        &descriptor->devices[drives->configuration->first_device + position];
    const descriptor_endnode_t* const endnode = drives_endnode(descriptor, device);
    const bool is_homing = (endnode != NULL) && (drives_mode(descriptor, device) == CIA402_MODE_HOMING);
    const uint8_t index  = is_homing ? drives_find(drives, endnode->node) : NETWORK_NO_DEVICE;
    return (index != NETWORK_NO_DEVICE) ? &drives->devices[index].device : NULL;
}

static uint16_t device_count(const drives_t* const drives)
{
    return (drives->configuration != NULL) ? drives->configuration->device_count : 0U;
}

status_t drives_home(drives_t* const drives, const bool is_wanted)
{
    FSW_ASSERT(drives != NULL);
    status_t status = STATUS_NOT_FOUND;
    for (uint16_t i = 0U; i < device_count(drives); i++) {
        canopen_device_t* const device = homing_device(drives, i);
        const uint8_t axes             = (device != NULL) ? device->profile->axis_count : 0U;
        for (uint8_t k = 0U; k < axes; k++) {
            canopen_cia402_axis_home(&device->axes[k], is_wanted);
            status = STATUS_OK;
        }
    }
    return status;
}

/// Returns the worse of two results. `order` lists the results, the worst first.
static status_t worse_of(const status_t one, const status_t other)
{
    static const status_t order[] = {STATUS_INVALID, STATUS_EMPTY, STATUS_BUSY};
    for (size_t i = 0U; i < (sizeof order / sizeof order[0]); i++) {
        if ((one == order[i]) || (other == order[i])) {
            return order[i];
        }
    }
    return STATUS_OK;
}

status_t drives_homing(drives_t* const drives, uint8_t* const out_node)
{
    FSW_ASSERT((drives != NULL) && (out_node != NULL));
    status_t worst = STATUS_OK;
    bool has_any   = false;
    for (uint16_t i = 0U; i < device_count(drives); i++) {
        const canopen_device_t* const device = homing_device(drives, i);
        const uint8_t axes                   = (device != NULL) ? device->profile->axis_count : 0U;
        for (uint8_t k = 0U; k < axes; k++) {
            const status_t status = canopen_cia402_axis_homing(&device->axes[k]);
            *out_node             = (status == STATUS_INVALID) ? device->node : *out_node;
            worst                 = worse_of(worst, status);
            has_any               = true;
        }
    }
    return has_any ? worst : STATUS_EMPTY;
}
