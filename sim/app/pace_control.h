// SPDX-License-Identifier: Apache-2.0
/// Pace of simulated time relative to the wall clock: it runs at the speed that the live port sets, and
/// stands still while the live port pauses it.
#ifndef SIM_APP_PACE_CONTROL_H
#define SIM_APP_PACE_CONTROL_H

#include "osal/include/osal/clock.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "sim/app/simulator.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {            // Private.
    osal_clock_t wall;      // Monotonic time.
    uint64_t since_ns;      // Simulated time at which the present speed began.
    uint64_t wall_since_ns; // Monotonic time of since_ns.
    double speed;
    bool is_released; // The launcher has ended a hold, because the mission shuts down: no further holds.
} pace_control_t;

/// Begin with speed 1. Simulated time 0 is `origin_ns` of osal_clock_monotonic_ns.
void pace_control_open(pace_control_t* pace, uint64_t origin_ns);
/// Hold simulated time while the live port pauses it, then wait until the wall clock has reached `now_ns`. A
/// run that is more than 20 ms late does not catch up: its pace starts again at the present time.
void pace_control_wait(pace_control_t* pace, simulator_t* simulator, osal_lockstep_t* scheduler,
                       uint64_t now_ns);

#endif // SIM_APP_PACE_CONTROL_H
