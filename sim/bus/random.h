// SPDX-License-Identifier: Apache-2.0
/// Seeded random numbers of one bus (SplitMix64): the same sequence on every machine.
#ifndef SIM_BUS_RANDOM_H
#define SIM_BUS_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private.
    uint64_t state;
} bus_random_t;

void bus_random_seed(bus_random_t* random, uint64_t seed);
/// Uniform 64 bits.
uint64_t bus_random_next(bus_random_t* random);
/// True with the given probability. No number is drawn if the probability is 0 or less.
bool bus_random_chance(bus_random_t* random, double probability);

#endif // SIM_BUS_RANDOM_H
