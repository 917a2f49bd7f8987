// SPDX-License-Identifier: Apache-2.0
/// The elements ValveBox and Valve of a world. Private to sim/world.
#ifndef SIM_WORLD_WORLD_VALVE_H
#define SIM_WORLD_WORLD_VALVE_H

#include "sim/world/world.h"

#define WORLD_VALVE_BOX_FIELDS 4U
extern const field_t world_valve_box_fields[WORLD_VALVE_BOX_FIELDS];

/// Check the address of a ValveBox. STATUS_OK, or STATUS_INVALID with the error.
status_t world_valve_box_finish(world_t* world, const element_t* element, void* record);
/// Read an element Valve, which belongs to the last ValveBox. Statuses of element_take.
status_t world_valve_take(world_t* world, const element_t* element);

#endif // SIM_WORLD_WORLD_VALVE_H
