// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>

/// Pull of a cable stretched by `stretch_m`: slack pulls nothing, the preload builds up over its first
/// travel.
static double cable_pull(const plant_parameters_t* const parameters, const double stretch_m)
{
    if (stretch_m <= 0.0) {
        return 0.0;
    }
    const double share =
        (stretch_m < parameters->spring_preload_m) ? stretch_m / parameters->spring_preload_m : 1.0;
    return share * parameters->spring_preload_n + parameters->spring_stiffness_n_m * stretch_m;
}

void spring_force(const plant_parameters_t* const parameters, spring_t* const spring, const double tip_m[3],
                  double out_force_n[3])
{
    const double anchor_x = parameters->hook_m[0];
    const double anchor_z = parameters->hook_m[1] - parameters->cable_m;
    const double along_x  = tip_m[0] - anchor_x;
    const double along_z  = tip_m[2] - anchor_z;
    const double length   = sqrt(along_x * along_x + along_z * along_z);
    const double pull     = cable_pull(parameters, length - parameters->cable_m);
    const bool below      = tip_m[2] < parameters->hook_m[1];

    if (!spring->hooked) {
        spring->hooked = spring->below && !below && (fabs(along_x) <= parameters->hook_catch_m);
    } else if ((pull <= 0.0) || (pull > parameters->spring_limit_n)) {
        spring->hooked = false;
    }
    spring->below = below;

    const double share = spring->hooked ? -pull / length : 0.0;
    out_force_n[0]     = share * along_x;
    out_force_n[1]     = 0.0;
    out_force_n[2]     = share * along_z;
}
