// SPDX-License-Identifier: Apache-2.0
#include "fsw/app/member.h"
#include "fsw/app/program.h"
#include "fsw/subsystems/manipulator/manipulator.h"
#include "generated/manipulator_services.h"

typedef struct {
    member_t member;
    manipulator_t manipulator;
    manipulator_services_t services;
} manipulator_program_t;

static manipulator_program_t storage;

static uint64_t step(void* const context, const uint64_t now_ns, const uint32_t octets_due)
{
    (void)octets_due;
    return member_step(&((manipulator_program_t*)context)->member, now_ns);
}

bool manipulator_open(seat_t* const seat, program_t* const out_program)
{
    if (!member_load(&storage.member, seat, MANIPULATOR_INTERFACE_HASH, manipulator_callbacks())) {
        return false;
    }
    manipulator_init(&storage.manipulator, &storage.member.component, &seat->flows);
    member_begin(&storage.member, &storage.manipulator,
                 (component_services_t){&storage.services, manipulator_add_services});
    *out_program = (program_t){.self          = &storage,
                               .step          = step,
                               .link_datagram = member_link_datagram,
                               .close         = member_close,
                               .component     = &storage.member.component,
                               .storage       = &storage,
                               .size          = sizeof storage};
    return true;
}
