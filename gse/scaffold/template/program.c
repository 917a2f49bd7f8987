// SPDX-License-Identifier: Apache-2.0
#include "fsw/app/member.h"
#include "fsw/app/program.h"
#include "fsw/subsystems/@name@/@name@.h"
#include "generated/@name@_services.h"

typedef struct {
    member_t member;
    @name@_t own;
    @name@_services_t services;
} @name@_program_t;

static @name@_program_t storage;

static uint64_t step(void* const context, const uint64_t now_ns, const uint32_t octets_due)
{
    (void)octets_due;
    return member_step(&((@name@_program_t*)context)->member, now_ns);
}

bool @name@_open(seat_t* const seat, program_t* const out_program)
{
    if (!member_load(&storage.member, seat, @NAME@_INTERFACE_HASH, @name@_callbacks())) {
        return false;
    }
    @name@_init(&storage.own, &storage.member.component, &seat->flows);
    member_begin(&storage.member, &storage.own,
                 (component_services_t){&storage.services, @name@_add_services});
    *out_program = (program_t){.self          = &storage,
                               .step          = step,
                               .link_datagram = member_link_datagram,
                               .close         = member_close,
                               .component     = &storage.member.component,
                               .storage       = &storage,
                               .size          = sizeof storage};
    return true;
}
