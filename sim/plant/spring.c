// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>

#define ROUNDING_M 1e-9 // Smaller distances from the plane of a planar robot are rounding errors.

/// Force of a cable stretched by `stretch_m`: zero while the cable is slack. The preload grows linearly to
/// its full value over the first `travel`.
static double cable_pull(const world_spring_t* const cable, const double stretch_m)
{
    if (stretch_m <= 0.0) {
        return 0.0;
    }
    const double share = (stretch_m < cable->travel) ? stretch_m / cable->travel : 1.0;
    return share * cable->preload + cable->stiffness * stretch_m;
}

void spring_force(const world_spring_t* const cable, spring_t* const spring, const double place_m[3],
                  double out_force_n[3])
{
    // Vector from the fixed end of the cable, which is `length` below the rest position of the hook.
    const double along_x = place_m[0] - cable->hook[0];
    const double along_y = place_m[1] - cable->hook[1];
    const double along_z = place_m[2] - (cable->hook[2] - cable->length);
    const double lateral = (fabs(along_y) > ROUNDING_M) ? along_y : 0.0;
    const double length  = sqrt(along_x * along_x + along_z * along_z + lateral * lateral);
    const double pull    = cable_pull(cable, length - cable->length);
    const bool below     = place_m[2] < cable->hook[2];

    // The link takes the hook when it passes it from below, and loses it when the cable is slack or pulls too
    // hard.
    if (!spring->hooked) {
        const double off = sqrt(along_x * along_x + lateral * lateral);
        spring->hooked   = spring->below && !below && (off <= cable->catch);
    } else if ((pull <= 0.0) || (pull > cable->limit)) {
        spring->hooked = false;
    }
    spring->below = below;

    const double share = spring->hooked ? -pull / length : 0.0;
    out_force_n[0]     = share * along_x;
    out_force_n[1]     = (lateral == 0.0) ? 0.0 : share * lateral;
    out_force_n[2]     = share * along_z;
}
