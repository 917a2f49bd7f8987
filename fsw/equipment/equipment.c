// SPDX-License-Identifier: Apache-2.0
#include "fsw/equipment/equipment.h"

#include "base/assertion.h"
#include "base/capacities.h"

#include <stddef.h>

CAPACITY_CHECK(equipment_begins_with_drives, offsetof(equipment_t, drives) == 0U);

static bool has_drives(const subsystem_descriptor_t* const descriptor)
{
    bool has_one = false;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        has_one = has_one || !descriptor_is_stream(&descriptor->devices[i]);
    }
    return has_one;
}

bool equipment_fit(const subsystem_descriptor_t* const descriptor, const drives_need_t* const drives,
                   const stream_devices_need_t* const streams, subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (drives != NULL) && (streams != NULL) && (out_misfit != NULL));
    FSW_ASSERT(drives->permits_streams && streams->permits_drives);
    return stream_devices_fit(descriptor, streams, out_misfit) &&
           (!has_drives(descriptor) || drives_fit(descriptor, drives, out_misfit));
}

void equipment_init(equipment_t* const equipment, subsystem_t* const generic,
                    const flow_resolver_t* const resolver, void (*const abandon)(void* self))
{
    FSW_ASSERT(equipment != NULL);
    drives_init(&equipment->drives, generic, resolver, abandon);
    stream_devices_init(&equipment->streams, generic, resolver);
    equipment->is_securing       = false;
    equipment->has_secured       = false;
    equipment->are_drives_secure = false;
}

bool equipment_has_drives(const equipment_t* const equipment)
{
    FSW_ASSERT(equipment != NULL);
    return has_drives(subsystem_descriptor(equipment->drives.generic));
}

bool equipment_is_engaged(const equipment_t* const equipment)
{
    FSW_ASSERT(equipment != NULL);
    return !equipment_has_drives(equipment) || (equipment->drives.activity == DRIVES_ENGAGED);
}

/// Perform an action of the devices on CAN, if there are any.
static status_t with_drives(equipment_t* const equipment, status_t (*const action)(void* self))
{
    FSW_ASSERT(equipment != NULL);
    return equipment_has_drives(equipment) ? action(&equipment->drives) : STATUS_OK;
}

/// Combine two statuses: STATUS_OK only if both are.
static status_t status_of_both(const status_t one, const status_t other)
{
    return (one == STATUS_OK) ? other : one;
}

status_t equipment_hardware_init(void* const self)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    const status_t status = stream_devices_hardware_init(&equipment->streams);
    return (status == STATUS_OK) ? with_drives(equipment, drives_hardware_init) : status;
}

status_t equipment_configure(void* const self, const descriptor_configuration_t* const configuration)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    const status_t status = stream_devices_configure(&equipment->streams, configuration);
    return ((status == STATUS_OK) && equipment_has_drives(equipment))
               ? drives_configure(&equipment->drives, configuration)
               : status;
}

status_t equipment_start_control(void* const self)
{
    return with_drives(self, drives_start_control);
}

status_t equipment_stop_control(void* const self)
{
    return with_drives(self, drives_stop_control);
}

status_t equipment_engage(void* const self)
{
    return with_drives(self, drives_engage);
}

status_t equipment_disengage(void* const self)
{
    return with_drives(self, drives_disengage);
}

status_t equipment_secure(void* const self)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    const bool is_waiting  = equipment->is_securing && equipment->are_drives_secure;
    const status_t drives  = is_waiting ? STATUS_OK : with_drives(equipment, drives_secure);
    const status_t streams = stream_devices_secure(&equipment->streams);
    // While a stream device is not secure yet, drives that are secure already are not secured again: a
    // further call of drives_secure would start the stop and the brakes once more.
    equipment->are_drives_secure = (drives == STATUS_OK) && (streams != STATUS_OK);
    equipment->is_securing       = true;
    equipment->has_secured       = true;
    return status_of_both(drives, streams);
}

status_t equipment_post(void* const self)
{
    equipment_t* const equipment = self;
    const status_t drives        = with_drives(equipment, drives_post);
    return status_of_both(drives, stream_devices_post(&equipment->streams));
}

status_t equipment_hardware_deinit(void* const self)
{
    equipment_t* const equipment = self;
    const status_t drives        = with_drives(equipment, drives_hardware_deinit);
    return status_of_both(drives, stream_devices_hardware_deinit(&equipment->streams));
}

void equipment_release(void* const self)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    drives_release(&equipment->drives);
    stream_devices_release(&equipment->streams);
}

void equipment_sense(void* const self)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    stream_devices_sense(&equipment->streams);
    drives_sense(&equipment->drives);
}

void equipment_emit(void* const self)
{
    equipment_t* const equipment = self;
    FSW_ASSERT(equipment != NULL);
    // A cycle without a call of equipment_secure ends the securing.
    equipment->is_securing = equipment->has_secured;
    equipment->has_secured = false;
    stream_devices_emit(&equipment->streams);
    drives_emit(&equipment->drives);
}
