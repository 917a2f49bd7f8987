// SPDX-License-Identifier: Apache-2.0
/// Where the spacecraft is along its orbit, as ST[22] counts: a circular orbit of constant period, whose
/// first ascending node is at mission time 0. A spacecraft with a navigation subsystem reads its parameter
/// instead.
#ifndef FSW_SUPERVISOR_ORBIT_H
#define FSW_SUPERVISOR_ORBIT_H

#include <stdint.h>

/// Orbits since mission time 0 << 16 | angle from the ascending node [2^-16 orbits]; period_ms 0: the
/// position stands still at 0.
uint64_t orbit_position(uint64_t now_ns, uint32_t period_ms);

#endif // FSW_SUPERVISOR_ORBIT_H
