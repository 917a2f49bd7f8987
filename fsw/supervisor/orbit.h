// SPDX-License-Identifier: Apache-2.0
/// Position of the spacecraft along its orbit in the units of ST[22]: a circular orbit whose first ascending
/// node is at mission time 0. When the period changes, the position continues from its present value. A
/// spacecraft with a navigation subsystem would use the position of that subsystem instead.
#ifndef FSW_SUPERVISOR_ORBIT_H
#define FSW_SUPERVISOR_ORBIT_H

#include <stdint.h>

typedef struct { // Private; all zeros: the first node is at time 0.
    uint32_t period_ms;
    uint64_t since_ns; ///< Time at which the present period began.
    uint64_t position; ///< Position at that time.
} orbit_t;

/// Returns orbits << 16 | angle: the number of orbits since mission time 0, and the angle from the ascending
/// node [2^-16 orbits]. With period_ms 0 the position does not change. now_ns must not be less than in the
/// last call.
uint64_t supervisor_orbit_position(orbit_t* orbit, uint64_t now_ns, uint32_t period_ms);

#endif // FSW_SUPERVISOR_ORBIT_H
