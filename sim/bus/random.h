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
/// Draw a number: true with the given probability.
bool bus_random_draw(bus_random_t* random, double probability);

/// True with the given probability. No number is drawn if the probability is 0 or less. Inline, because every
/// frame asks several times, and without faults all probabilities are 0.
static inline bool bus_random_chance(bus_random_t* const random, const double probability)
{
    return (probability > 0.0) && bus_random_draw(random, probability);
}

#endif // SIM_BUS_RANDOM_H
