// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/framework/subsystem/device_service.h"
#include "fsw/framework/subsystem/memory_service.h"
#include "fsw/framework/subsystem/monitoring_service.h"
#include "fsw/framework/subsystem/statistics_service.h"
#include "fsw/subsystems/arm/arm.h"
#include "pus/core/tailoring.h"

/// Storage for the largest capacities, because this program supports arms with any descriptor.
typedef struct {
    device_service_t device;
    pus_device_operation_t device_operations[ARM_DEVICE_REQUESTS];
    statistics_service_t statistics;
    pus_statistic_t statistics_entries[ARM_STATISTICS];
    pus_due_t statistics_due[ARM_STATISTICS];
    uint16_t statistics_positions[ARM_STATISTICS];
    memory_service_t memory;
    pus_memory_operation_t memory_operations[ARM_MEMORY_OPERATIONS];
    monitoring_service_t monitoring;
    pus_pmon_t pmons[ARM_MONITORS];
    uint16_t pmon_order[ARM_MONITORS];
    uint16_t pmon_positions[ARM_MONITORS];
    pus_due_t pmon_due[ARM_MONITORS];
    pus_fmon_t fmons[ARM_FUNCTIONAL_MONITORS];
    uint16_t fmons_touched[ARM_FUNCTIONAL_MONITORS];
    pus_fmon_member_t fmon_members[ARM_FUNCTIONAL_MONITORS * MONITORING_FMON_MEMBERS];
} arm_services_t;

typedef struct {
    subsystem_host_t host;
    arm_t arm;
    arm_services_t services;
} arm_program_t;

static arm_program_t storage;

static void add_service(arm_services_t* const own, subsystem_t* const component,
                        const descriptor_service_t* const listed)
{
    const statistics_room_t statistics = {.statistics = own->statistics_entries,
                                          .due        = own->statistics_due,
                                          .positions  = own->statistics_positions,
                                          .capacity   = listed->capacity};
    const monitoring_room_t monitoring = {.pmons      = own->pmons,
                                          .order      = own->pmon_order,
                                          .positions  = own->pmon_positions,
                                          .due        = own->pmon_due,
                                          .capacity   = listed->capacity,
                                          .fmons      = own->fmons,
                                          .touched    = own->fmons_touched,
                                          .members    = own->fmon_members,
                                          .functional = listed->functional};
    switch (listed->type) {
    case PUS_SERVICE_DEVICE_ACCESS:
        subsystem_device_service_add(component, &own->device, own->device_operations,
                                     (uint8_t)listed->capacity);
        break;
    case PUS_SERVICE_STATISTICS:
        subsystem_statistics_service_add(component, &own->statistics, &statistics);
        break;
    case PUS_SERVICE_MEMORY:
        subsystem_memory_service_add(component, &own->memory, own->memory_operations,
                                     (uint8_t)listed->capacity);
        break;
    default: // ST[12]; the reader of descriptors admits no other service.
        subsystem_monitoring_service_add(component, &own->monitoring, &monitoring);
        break;
    }
}

/// Add the services of the descriptor. `fits` of arm.c has checked that their capacities fit the storage.
static void add_services(void* const own, subsystem_t* const component)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(component);
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        add_service((arm_services_t*)own, component, &descriptor->services[i]);
    }
}

bool arm_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    // The program has no compiled interface: `fits` checks the descriptor, and a reloaded descriptor must
    // have the same interface.
    const uint64_t interface_hash = runtime->own->interface_hash;
    if (!subsystem_host_load(&storage.host, runtime, interface_hash, arm_callbacks())) {
        return false;
    }
    arm_init(&storage.arm, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.arm,
                         (subsystem_services_t){&storage.services, add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
