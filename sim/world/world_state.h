// SPDX-License-Identifier: Apache-2.0
/// The elements of a robot that define its motion at the start, and the spread of its parameters. Private to
/// sim/world.
#ifndef SIM_WORLD_WORLD_STATE_H
#define SIM_WORLD_WORLD_STATE_H

#include "sim/world/document.h"
#include "sim/world/world.h"

/// Read State: position and motion of the root link of the last robot. STATUS_OK, STATUS_INVALID (the
/// error of the document is filled).
MUST_USE status_t world_take_state(world_t* world, const element_t* element);
/// Read Spread: the largest differences of the true parameters of the last robot from its URDF. STATUS_OK,
/// STATUS_INVALID (the error of the document is filled).
MUST_USE status_t world_take_spread(world_t* world, const element_t* element);

#endif // SIM_WORLD_WORLD_STATE_H
