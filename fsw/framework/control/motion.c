// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/motion.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define PEAK_SPEED 1.875 // Of s(x) = 10 x^3 - 15 x^4 + 6 x^5 on [0, 1].

void motion_rest(motion_t* const motion, const double position)
{
    FSW_ASSERT(motion != NULL);
    *motion = (motion_t){.start = position, .duration_s = 1.0, .elapsed_s = 1.0};
}

void motion_begin(motion_t* const motion, const double start, const double goal, const double duration_s)
{
    FSW_ASSERT((motion != NULL) && (duration_s > 0.0));
    *motion = (motion_t){.start = start, .distance = goal - start, .duration_s = duration_s};
}

void motion_brake(motion_t* const motion, const motion_point_t* const from, const double deceleration)
{
    FSW_ASSERT((motion != NULL) && (from != NULL) && (deceleration > 0.0));
    const double duration_s = elementary_absolute(from->velocity) / deceleration;
    *motion                 = (motion_t){.start      = from->position,
                                         .distance   = 0.5 * from->velocity * duration_s,
                                         .duration_s = duration_s,
                                         .speed      = from->velocity};
}

motion_point_t motion_step(motion_t* const motion, const double period_s)
{
    FSW_ASSERT(motion != NULL);
    motion->elapsed_s += period_s;
    if ((motion->elapsed_s + (0.5 * period_s)) > motion->duration_s) { // Sums of periods are not exact.
        motion->elapsed_s = motion->duration_s;
    }
    if (motion_is_done(motion)) {
        return (motion_point_t){.position = motion->start + motion->distance};
    }
    if (motion->speed != 0.0) {
        const double t            = motion->elapsed_s;
        const double acceleration = -motion->speed / motion->duration_s;
        return (motion_point_t){.position = motion->start + (t * (motion->speed + (0.5 * acceleration * t))),
                                .velocity = motion->speed + (acceleration * t),
                                .acceleration = acceleration};
    }
    const double x    = motion->elapsed_s / motion->duration_s;
    const double rate = 1.0 / motion->duration_s;
    const double y    = 1.0 - x;
    return (motion_point_t){
        .position     = motion->start + (motion->distance * x * x * x * (10.0 + (x * ((6.0 * x) - 15.0)))),
        .velocity     = motion->distance * rate * 30.0 * x * x * y * y,
        .acceleration = motion->distance * rate * rate * 60.0 * x * y * (1.0 - (2.0 * x)),
    };
}

bool motion_is_done(const motion_t* const motion)
{
    FSW_ASSERT(motion != NULL);
    return motion->elapsed_s >= motion->duration_s;
}

double motion_peak_speed(const double distance, const double duration_s)
{
    return PEAK_SPEED * elementary_absolute(distance) / duration_s;
}
