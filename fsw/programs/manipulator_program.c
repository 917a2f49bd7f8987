// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/manipulator/manipulator.h"
#include "generated/manipulator_services.h"

typedef struct {
    subsystem_host_t host;
    manipulator_t manipulator;
    manipulator_services_t services;
} manipulator_program_t;

static manipulator_program_t storage;

bool manipulator_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    if (!subsystem_host_load(&storage.host, runtime, MANIPULATOR_INTERFACE_HASH, manipulator_callbacks())) {
        return false;
    }
    manipulator_init(&storage.manipulator, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.manipulator,
                         (subsystem_services_t){&storage.services, manipulator_add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
