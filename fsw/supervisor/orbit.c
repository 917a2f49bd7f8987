// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/orbit.h"

#include "base/assertion.h"

#include <stdbool.h>
#include <stddef.h>

#define NS_PER_MS 1000000ULL
#define ANGLE_BITS 16U

/// Returns the change of the position in the time `age_ns` with this period.
static uint64_t position_change(const uint64_t age_ns, const uint32_t period_ms)
{
    if (period_ms == 0U) {
        return 0U;
    }
    // The angle is remainder * 2^16 / period. Both are below 2^52, so a shift by 12 bits does not overflow;
    // dividing the period by 2^4 replaces the other 4 bits. It has no remainder, as 2^4 divides NS_PER_MS.
    const uint64_t period_ns = (uint64_t)period_ms * NS_PER_MS;
    const uint64_t orbits    = age_ns / period_ns;
    const uint64_t angle     = ((age_ns % period_ns) << (ANGLE_BITS - 4U)) / (period_ns >> 4U);
    return (orbits << ANGLE_BITS) | angle;
}

uint64_t supervisor_orbit_position(orbit_t* const orbit, const uint64_t now_ns, const uint32_t period_ms)
{
    FSW_ASSERT(orbit != NULL);
    const uint64_t age_ns   = (now_ns > orbit->since_ns) ? (now_ns - orbit->since_ns) : 0U;
    const uint64_t position = orbit->position + position_change(age_ns, orbit->period_ms);
    if (period_ms == orbit->period_ms) {
        return position;
    }
    // The first period counts from mission time 0, where the first ascending node is.
    const bool is_first = (orbit->position == 0U) && (orbit->period_ms == 0U);
    orbit->period_ms    = period_ms;
    orbit->since_ns     = is_first ? 0U : now_ns;
    orbit->position     = position;
    return orbit->position + position_change(now_ns - orbit->since_ns, period_ms);
}
