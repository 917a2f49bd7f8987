// SPDX-License-Identifier: Apache-2.0
#include "sim/app/pace_control.h"

#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"

#define LAG_MAX_NS 20000000ULL  ///< Largest delay behind the wall clock that is caught up.
#define HELD_LOOK_NS 2000000ULL ///< Period of reading the live port while simulated time is held.

void pace_control_open(pace_control_t* const pace, const uint64_t origin_ns)
{
    *pace = (pace_control_t){.wall_since_ns = origin_ns, .speed = 1.0};
    osal_clock_open_real(&pace->wall, 0U);
}

static void restart(pace_control_t* const pace, const uint64_t now_ns, const double speed)
{
    pace->since_ns      = now_ns;
    pace->wall_since_ns = osal_clock_monotonic_ns();
    pace->speed         = speed;
}

static void wait_until(pace_control_t* const pace, const uint64_t wall_ns)
{
    if (osal_clock_wait(&pace->wall, wall_ns, NULL, 0U) != STATUS_OK) {
        osal_console_print_error("simulator: cannot wait for the wall clock");
    }
}

/// Hold simulated time until the live port resumes it. Returns the pace after the hold.
static simulator_pace_t hold(pace_control_t* const pace, simulator_t* const simulator,
                             osal_lockstep_t* const scheduler)
{
    simulator_pace_t wanted = {.is_held = true};
    osal_lockstep_hold(scheduler, true);
    while (wanted.is_held && osal_lockstep_is_held(scheduler) && (osal_process_stop_count() == 0U) &&
           !osal_lockstep_is_closed(scheduler)) {
        wait_until(pace, osal_clock_monotonic_ns() + HELD_LOOK_NS);
        wanted = simulator_pace(simulator);
    }
    pace->is_released = wanted.is_held;
    osal_lockstep_hold(scheduler, false);
    return wanted;
}

void pace_control_wait(pace_control_t* const pace, simulator_t* const simulator,
                       osal_lockstep_t* const scheduler, const uint64_t now_ns)
{
    simulator_pace_t wanted = simulator_pace(simulator);
    const bool is_held      = wanted.is_held && !pace->is_released;
    if (is_held) {
        wanted = hold(pace, simulator, scheduler);
    }
    if (is_held || (wanted.speed != pace->speed)) {
        restart(pace, now_ns, wanted.speed);
    }
    if (wanted.speed == 0.0) {
        return;
    }
    const double passed_ns = (double)(now_ns - pace->since_ns) / wanted.speed;
    const uint64_t due_ns  = pace->wall_since_ns + (uint64_t)passed_ns;
    if (osal_clock_now_ns(&pace->wall) > (due_ns + LAG_MAX_NS)) {
        restart(pace, now_ns, wanted.speed);
    } else {
        wait_until(pace, due_ns);
    }
}
