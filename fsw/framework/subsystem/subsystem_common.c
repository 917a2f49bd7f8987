// SPDX-License-Identifier: Apache-2.0
// Functions that several specific subsystems need, based on subsystem.h.
#include "fsw/framework/subsystem/subsystem.h"

#include "base/assertion.h"

status_t subsystem_publish_all(subsystem_t* const subsystem, const parameter_definition_t* const definitions,
                               const size_t* const offsets, const size_t count, void* const storage)
{
    FSW_ASSERT((subsystem != NULL) && (definitions != NULL) && (offsets != NULL) && (storage != NULL));
    uint8_t* const octets = storage;
    status_t status       = STATUS_OK;
    for (size_t i = 0U; (status == STATUS_OK) && (i < count); i++) {
        status = subsystem_publish(subsystem, &definitions[i], &octets[offsets[i]]);
    }
    return status;
}

status_t subsystem_raise_by_command(subsystem_t* const subsystem, const uint16_t event_id)
{
    FSW_ASSERT(subsystem != NULL);
    const descriptor_event_t* const event = descriptor_find_event(subsystem_descriptor(subsystem), event_id);
    if ((event == NULL) || (event->severity != DESCRIPTOR_LOW)) {
        return STATUS_OUT_OF_RANGE;
    }
    return subsystem_raise(subsystem, event_id, NULL, 0U);
}
