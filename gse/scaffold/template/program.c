// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/@name@/@name@.h"
#include "generated/@name@_services.h"

typedef struct {
    subsystem_host_t host;
    @name@_t own;
    @name@_services_t services;
} @name@_program_t;

static @name@_program_t storage;

bool @name@_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    if (!subsystem_host_load(&storage.host, runtime, @NAME@_INTERFACE_HASH, @name@_callbacks())) {
        return false;
    }
    @name@_init(&storage.own, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.own,
                         (subsystem_services_t){&storage.services, @name@_add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
