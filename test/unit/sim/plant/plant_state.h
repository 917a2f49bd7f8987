// SPDX-License-Identifier: Apache-2.0
/// Sums over the whole state of a plant, for the tests of its mechanics.
#ifndef TEST_UNIT_SIM_PLANT_PLANT_STATE_H
#define TEST_UNIT_SIM_PLANT_PLANT_STATE_H

#include "sim/plant/plant.h"

/// Compute the linear [Ns] and angular [Nms, about the origin] momentum of base, links, rotors and wheels.
void plant_momentum(const plant_t* plant, double out_linear[3], double out_angular[3]);
/// Returns a checksum (FNV-1a 64) of the complete state: equal in two runs if they are bit-identical.
uint64_t plant_hash(const plant_t* plant);

#endif // TEST_UNIT_SIM_PLANT_PLANT_STATE_H
