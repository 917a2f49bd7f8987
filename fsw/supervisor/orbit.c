// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/orbit.h"

#define NS_PER_MS 1000000ULL
#define ANGLE_BITS 16U

uint64_t orbit_position(const uint64_t now_ns, const uint32_t period_ms)
{
    if (period_ms == 0U) {
        return 0U;
    }
    const uint64_t period_ns =
        (uint64_t)period_ms * NS_PER_MS; // < 2^52, so that the angle does not overflow.
    const uint64_t orbits = now_ns / period_ns;
    const uint64_t angle  = ((now_ns % period_ns) << (ANGLE_BITS - 4U)) / (period_ns >> 4U);
    return (orbits << ANGLE_BITS) | angle;
}
