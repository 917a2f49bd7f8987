// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/monitoring_service.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/optional_services.h"

static bool is_event(void* const context, const uint16_t event_id)
{
    const subsystem_t* const subsystem = context;
    return descriptor_find_event(subsystem->descriptor, event_id) != NULL;
}

/// True if a monitor can supply the auxiliary data of an event: the event has no fields of its own
/// (parameters are sampled), or its fields have the size of the monitor's data.
static bool can_fill(void* const context, const uint16_t event_id, const size_t size)
{
    const subsystem_t* const subsystem    = context;
    const descriptor_event_t* const event = descriptor_find_event(subsystem->descriptor, event_id);
    FSW_ASSERT(event != NULL); // ST[12] asks only about events that exist.
    return (event->field_count == 0U) || (event->octets == size);
}

static void raise_event(void* const context, const uint16_t event_id, const uint8_t* const auxiliary,
                        const size_t size, const uint64_t now_ns)
{
    subsystem_t* const subsystem          = context;
    const descriptor_event_t* const event = descriptor_find_event(subsystem->descriptor, event_id);
    const bool is_own_data                = (event != NULL) && (event->octets == size);
    (void)now_ns; // subsystem_raise uses the time of the component.
    (void)subsystem_raise(subsystem, event_id, is_own_data ? auxiliary : NULL, is_own_data ? size : 0U);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_monitoring_restore(self, key, octets, size);
}

void subsystem_monitoring_service_add(subsystem_t* const subsystem, monitoring_service_t* const service,
                                      const monitoring_room_t* const room)
{
    FSW_ASSERT((subsystem != NULL) && (service != NULL) && (room != NULL));
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    const pus_parameter_port_t watched           = (callbacks->watched != NULL)
                                                       ? callbacks->watched(subsystem->config.self)
                                                       : subsystem_parameter_port(subsystem);
    const pus_monitoring_config_t config         = {.process        = subsystem_process(subsystem),
                                                    .parameters     = watched,
                                                    .events         = {subsystem, is_event, can_fill, raise_event},
                                                    .persistence    = subsystem_persistence(subsystem),
                                                    .pmons          = room->pmons,
                                                    .pmon_order     = room->order,
                                                    .pmon_positions = room->positions,
                                                    .due            = room->due,
                                                    .fmons          = room->fmons,
                                                    .touched        = room->touched,
                                                    .members        = room->members,
                                                    .transitions    = service->transitions,
                                                    .pmon_capacity  = room->capacity,
                                                    .fmon_capacity  = room->functional,
                                                    .transition_capacity = MONITORING_TRANSITIONS,
                                                    .fmon_members        = MONITORING_FMON_MEMBERS,
                                                    .reporting_delay     = MONITORING_DELAY_CYCLES};
    pus_monitoring_init(&service->monitoring, &config);
    const pus_service_t entry = pus_monitoring_service(&service->monitoring);
    subsystem_add_service(subsystem, &entry, restore);
}
