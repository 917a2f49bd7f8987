// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/tracker.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void control_tracker_reset(control_tracker_t* const tracker, const double position)
{
    FSW_ASSERT(tracker != NULL);
    *tracker = (control_tracker_t){.position = position};
}

void control_tracker_step(control_tracker_t* const tracker, const double sample, const double omega_rad_s,
                          const double period_s)
{
    FSW_ASSERT(tracker != NULL);
    const double error    = sample - tracker->position;
    tracker->acceleration = omega_rad_s * omega_rad_s * error;
    const double step     = period_s * (tracker->velocity + (2.0 * omega_rad_s * error));
    tracker->position     = control_settle(tracker->position + step);
    tracker->velocity     = control_settle(tracker->velocity + (period_s * tracker->acceleration));
}
