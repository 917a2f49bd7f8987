// SPDX-License-Identifier: Apache-2.0
/// The elements Contact and CableSpring of a world. Private to sim/world.
#ifndef SIM_WORLD_WORLD_CONTACT_H
#define SIM_WORLD_WORLD_CONTACT_H

#include "sim/world/world.h"

#define WORLD_CONTACT_FIELDS 7U
#define WORLD_SPRING_FIELDS 8U
extern const field_t world_contact_fields[WORLD_CONTACT_FIELDS];
extern const field_t world_spring_fields[WORLD_SPRING_FIELDS];
/// Complete a Contact: find both sides. STATUS_OK, or STATUS_INVALID with the error.
MUST_USE status_t world_contact_finish(world_t* world, const element_t* element, void* record);
/// Complete a CableSpring: find its link. STATUS_OK, or STATUS_INVALID with the error.
MUST_USE status_t world_spring_finish(world_t* world, const element_t* element, void* record);

#endif // SIM_WORLD_WORLD_CONTACT_H
