// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/member.h"
#include "fsw/programs/program.h"
#include "fsw/subsystems/joystick/joystick.h"
#include "generated/joystick_services.h"

typedef struct {
    member_t member;
    joystick_t joystick;
    joystick_services_t services;
} joystick_program_t;

static joystick_program_t storage;

bool joystick_open(seat_t* const seat, program_t* const out_program)
{
    if (!member_load(&storage.member, seat, JOYSTICK_INTERFACE_HASH, joystick_callbacks())) {
        return false;
    }
    joystick_init(&storage.joystick, &storage.member.component, &seat->flows);
    member_begin(&storage.member, &storage.joystick,
                 (component_services_t){&storage.services, joystick_add_services});
    *out_program = member_program(&storage.member, &storage, sizeof storage);
    return true;
}
