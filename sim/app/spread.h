// SPDX-License-Identifier: Apache-2.0
/// The true parameters of a world, which differ at random from those in its files. The flight software knows
/// only the files.
#ifndef SIM_APP_SPREAD_H
#define SIM_APP_SPREAD_H

#include "sim/world/world.h"

#include <stdint.h>

/// Change the parameters for which the world has a spread, by random numbers from `seed`: masses, inertias,
/// centres of mass, initial poses and motions of robots; friction and stiffness of drives; gains of wheels;
/// mounting of cameras.
void spread_apply(world_t* world, uint64_t seed);

#endif // SIM_APP_SPREAD_H
