// SPDX-License-Identifier: Apache-2.0
/// The element Latch of a world. Private to sim/world.
#ifndef SIM_WORLD_WORLD_LATCH_H
#define SIM_WORLD_WORLD_LATCH_H

#include "sim/world/world.h"

#define WORLD_LATCH_FIELDS 11U
extern const field_t world_latch_fields[WORLD_LATCH_FIELDS];

/// Complete a Latch: find its links and the device that closes it, check the attributes of the device, and
/// refuse a Latch that repeats one above. STATUS_OK, or STATUS_INVALID with the error.
status_t world_latch_finish(world_t* world, const element_t* element, void* record);

#endif // SIM_WORLD_WORLD_LATCH_H
