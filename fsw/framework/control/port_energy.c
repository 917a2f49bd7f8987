// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/port_energy.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void control_port_energy_reset(control_port_energy_t* const energy)
{
    FSW_ASSERT(energy != NULL);
    *energy = (control_port_energy_t){.is_started = false};
}

static void begin_window(control_port_energy_t* const energy)
{
    for (unsigned i = 0U; i < CONTROL_PORT_AXES; i++) {
        energy->begin_rad[i] = energy->position_rad[i];
    }
    energy->begin_j   = energy->taken_j;
    energy->elapsed_s = 0.0;
}

double control_port_energy_step(control_port_energy_t* const energy, const control_port_watch_t* const watch,
                                const double torque_nm[CONTROL_PORT_AXES],
                                const double position_rad[CONTROL_PORT_AXES])
{
    FSW_ASSERT((energy != NULL) && (watch != NULL));
    double taken = 0.0;
    bool is_rest = energy->is_started;
    for (unsigned i = 0U; i < CONTROL_PORT_AXES; i++) {
        taken += energy->is_started ? (torque_nm[i] * (position_rad[i] - energy->position_rad[i])) : 0.0;
        energy->position_rad[i] = position_rad[i];
        is_rest = is_rest && (control_absolute(position_rad[i] - energy->begin_rad[i]) <= watch->rest_rad);
    }
    energy->is_started = true;
    energy->taken_j += taken;
    energy->given_j -= (taken < 0.0) ? taken : 0.0;
    energy->received_j += (taken > 0.0) ? taken : 0.0;
    energy->elapsed_s += watch->period_s;
    const bool is_over  = energy->elapsed_s >= watch->time_s;
    const double given  = energy->begin_j - energy->taken_j;
    const bool is_alarm = is_rest && is_over && (given > watch->limit_j);
    if (!is_rest || is_over) {
        begin_window(energy);
    }
    return is_alarm ? given : 0.0;
}

void control_reserve_take_sum(control_reserve_t* const reserve, const double sum_j)
{
    FSW_ASSERT(reserve != NULL);
    if (sum_j != sum_j) { // NaN.
        return;
    }
    const double more = sum_j - reserve->last_sum_j;
    reserve->reserve_j += (reserve->is_started && (more > 0.0)) ? more : 0.0;
    reserve->last_sum_j = sum_j;
    reserve->is_started = true;
}

void control_reserve_add(control_reserve_t* const reserve, const double taken_j, const double cap_j)
{
    FSW_ASSERT(reserve != NULL);
    const double sum   = reserve->reserve_j + taken_j;
    reserve->reserve_j = (sum < cap_j) ? sum : cap_j;
}
