// SPDX-License-Identifier: Apache-2.0
#include "sim/bus/random.h"

#define TWO_POWER_MINUS_53 1.1102230246251565e-16 // Converts 53 random bits to a number in [0, 1).

void bus_random_seed(bus_random_t* const random, const uint64_t seed)
{
    random->state = seed;
}

uint64_t bus_random_next(bus_random_t* const random)
{
    random->state += 0x9E3779B97F4A7C15ULL;
    uint64_t mixed = random->state;
    mixed          = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9ULL;
    mixed          = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBULL;
    return mixed ^ (mixed >> 31);
}

bool bus_random_draw(bus_random_t* const random, const double probability)
{
    return ((double)(bus_random_next(random) >> 11) * TWO_POWER_MINUS_53) < probability;
}
