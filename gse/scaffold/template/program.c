// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/member.h"
#include "fsw/programs/program.h"
#include "fsw/subsystems/@name@/@name@.h"
#include "generated/@name@_services.h"

typedef struct {
    member_t member;
    @name@_t own;
    @name@_services_t services;
} @name@_program_t;

static @name@_program_t storage;

bool @name@_open(seat_t* const seat, program_t* const out_program)
{
    if (!member_load(&storage.member, seat, @NAME@_INTERFACE_HASH, @name@_callbacks())) {
        return false;
    }
    @name@_init(&storage.own, &storage.member.component, &seat->flows);
    member_begin(&storage.member, &storage.own,
                 (component_services_t){&storage.services, @name@_add_services});
    *out_program = member_program(&storage.member, &storage, sizeof storage);
    return true;
}
