// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/motion.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define PEAK_SPEED 1.875 // Peak speed of s(x) = 10 x^3 - 15 x^4 + 6 x^5 on [0, 1].

void control_motion_rest(control_motion_t* const motion, const double position)
{
    FSW_ASSERT(motion != NULL);
    *motion = (control_motion_t){.start = position, .duration_s = 1.0, .elapsed_s = 1.0};
}

void control_motion_begin(control_motion_t* const motion, const double start, const double goal,
                          const double duration_s)
{
    FSW_ASSERT((motion != NULL) && (duration_s > 0.0));
    *motion = (control_motion_t){.start = start, .distance = goal - start, .duration_s = duration_s};
}

void control_motion_brake(control_motion_t* const motion, const control_motion_point_t* const from,
                          const double deceleration)
{
    FSW_ASSERT((motion != NULL) && (from != NULL) && (deceleration > 0.0));
    const double duration_s = control_absolute(from->velocity) / deceleration;
    *motion                 = (control_motion_t){.start      = from->position,
                                                 .distance   = 0.5 * from->velocity * duration_s,
                                                 .duration_s = duration_s,
                                                 .speed      = from->velocity};
}

control_motion_point_t control_motion_step(control_motion_t* const motion, const double period_s)
{
    FSW_ASSERT(motion != NULL);
    motion->elapsed_s += period_s;
    // Sums of periods are not exact: less than half a period before the end counts as the end.
    if ((motion->elapsed_s + (0.5 * period_s)) > motion->duration_s) {
        motion->elapsed_s = motion->duration_s;
    }
    if (control_motion_is_done(motion)) {
        return (control_motion_point_t){.position = motion->start + motion->distance};
    }
    if (motion->speed != 0.0) {
        const double t            = motion->elapsed_s;
        const double acceleration = -motion->speed / motion->duration_s;
        return (control_motion_point_t){.position =
                                            motion->start + (t * (motion->speed + (0.5 * acceleration * t))),
                                        .velocity     = motion->speed + (acceleration * t),
                                        .acceleration = acceleration};
    }
    const double x    = motion->elapsed_s / motion->duration_s;
    const double rate = 1.0 / motion->duration_s;
    const double y    = 1.0 - x;
    return (control_motion_point_t){
        .position     = motion->start + (motion->distance * x * x * x * (10.0 + (x * ((6.0 * x) - 15.0)))),
        .velocity     = motion->distance * rate * 30.0 * x * x * y * y,
        .acceleration = motion->distance * rate * rate * 60.0 * x * y * (1.0 - (2.0 * x)),
    };
}

bool control_motion_is_done(const control_motion_t* const motion)
{
    FSW_ASSERT(motion != NULL);
    return motion->elapsed_s >= motion->duration_s;
}

double control_motion_peak_speed(const double distance, const double duration_s)
{
    return PEAK_SPEED * control_absolute(distance) / duration_s;
}
