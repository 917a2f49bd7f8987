// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/joystick/joystick.h"
#include "generated/joystick_services.h"

typedef struct {
    subsystem_host_t host;
    joystick_t joystick;
    joystick_services_t services;
} joystick_program_t;

static joystick_program_t storage;

bool joystick_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    if (!subsystem_host_load(&storage.host, runtime, JOYSTICK_INTERFACE_HASH, joystick_callbacks())) {
        return false;
    }
    joystick_init(&storage.joystick, &storage.host.subsystem, &runtime->flows);
    subsystem_host_begin(&storage.host, &storage.joystick,
                         (subsystem_services_t){&storage.services, joystick_add_services});
    *out_instance = subsystem_host_instance(&storage.host, &storage, sizeof storage);
    return true;
}
