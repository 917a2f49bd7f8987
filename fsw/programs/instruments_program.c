// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/instruments/instruments.h"
#include "generated/instruments_services.h"

typedef struct {
    subsystem_host_t host;
    instruments_t own;
    instruments_services_t services;
} instruments_program_t;

static instruments_program_t storage;

bool instruments_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    if (!subsystem_host_load(&storage.host, runtime, INSTRUMENTS_INTERFACE_HASH, instruments_callbacks())) {
        return false;
    }
    instruments_init(&storage.own, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.own,
                         (subsystem_services_t){&storage.services, instruments_add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
