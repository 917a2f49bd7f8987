// SPDX-License-Identifier: Apache-2.0
/// The element Latch of a world. Private to sim/world.
#ifndef SIM_WORLD_WORLD_LATCH_H
#define SIM_WORLD_WORLD_LATCH_H

#include "sim/world/world.h"

#define WORLD_LATCH_FIELDS 11U
extern const field_t world_latch_fields[WORLD_LATCH_FIELDS];

/// Find the links and the device of a Latch. STATUS_OK, or STATUS_INVALID with the error.
status_t world_latch_finish(world_t* world, const element_t* element, void* record);

#endif // SIM_WORLD_WORLD_LATCH_H
