// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/actuators/actuators.h"
#include "generated/actuators_services.h"

typedef struct {
    subsystem_host_t host;
    actuators_t own;
    actuators_services_t services;
} actuators_program_t;

static actuators_program_t storage;

bool actuators_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    if (!subsystem_host_load(&storage.host, runtime, ACTUATORS_INTERFACE_HASH, actuators_callbacks())) {
        return false;
    }
    actuators_init(&storage.own, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.own,
                         (subsystem_services_t){&storage.services, actuators_add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
