// SPDX-License-Identifier: Apache-2.0
/// The true parameters of a world, which differ from its files as the world allows. Flight knows the files.
#ifndef SIM_APP_SPREAD_H
#define SIM_APP_SPREAD_H

#include "sim/world/world.h"

#include <stdint.h>

/// Draw by the seed what the world lets differ: masses, inertias, centres of mass and the start of robots
/// with a Spread, friction and stiffness of drives, the gain of wheels, the mounting of cameras.
void spread_apply(world_t* world, uint64_t seed);

#endif // SIM_APP_SPREAD_H
