// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/member.h"
#include "fsw/programs/program.h"
#include "fsw/subsystems/manipulator/manipulator.h"
#include "generated/manipulator_services.h"

typedef struct {
    member_t member;
    manipulator_t manipulator;
    manipulator_services_t services;
} manipulator_program_t;

static manipulator_program_t storage;

bool manipulator_open(seat_t* const seat, program_t* const out_program)
{
    if (!member_load(&storage.member, seat, MANIPULATOR_INTERFACE_HASH, manipulator_callbacks())) {
        return false;
    }
    manipulator_init(&storage.manipulator, &storage.member.component, &seat->flows);
    member_begin(&storage.member, &storage.manipulator,
                 (component_services_t){&storage.services, manipulator_add_services});
    *out_program = member_program(&storage.member, &storage, sizeof storage);
    return true;
}
