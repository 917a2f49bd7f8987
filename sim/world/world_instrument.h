// SPDX-License-Identifier: Apache-2.0
/// The element Instrument of a world. Private to sim/world.
#ifndef SIM_WORLD_WORLD_INSTRUMENT_H
#define SIM_WORLD_WORLD_INSTRUMENT_H

#include "sim/world/document.h"
#include "sim/world/world.h"

#define WORLD_INSTRUMENT_FIELDS 11U

extern const field_t world_instrument_fields[WORLD_INSTRUMENT_FIELDS];
/// Check the enumerated attributes of an instrument, and that its name is new. STATUS_OK, STATUS_INVALID
/// (error is filled).
MUST_USE status_t world_instrument_finish(world_t* world, const element_t* element, void* record);

#endif // SIM_WORLD_WORLD_INSTRUMENT_H
