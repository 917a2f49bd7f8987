// SPDX-License-Identifier: Apache-2.0
/// The true parameters of robots, which differ from their URDF as the world allows. Flight knows the URDF.
#ifndef SIM_APP_SPREAD_H
#define SIM_APP_SPREAD_H

#include "sim/world/world.h"

#include <stdint.h>

/// Draw mass, inertia and centre of mass of each body of the robots with a Spread by the seed.
void spread_apply(world_t* world, uint64_t seed);

#endif // SIM_APP_SPREAD_H
