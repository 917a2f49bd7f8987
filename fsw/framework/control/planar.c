// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/control/planar.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

#define DETERMINANT_LEAST_M2 1.0e-3
#define NEWTON_STEPS 5U // The first estimate is at most 42 % wrong; five steps reduce the error below 1e-15.

static double determinant(const double jacobian[CONTROL_PLANAR_ENTRIES])
{
    return (jacobian[0] * jacobian[3]) - (jacobian[1] * jacobian[2]);
}

bool control_planar_is_regular(const double jacobian[CONTROL_PLANAR_ENTRIES])
{
    FSW_ASSERT(jacobian != NULL);
    return control_absolute(determinant(jacobian)) >= DETERMINANT_LEAST_M2;
}

void control_planar_force(const double jacobian[CONTROL_PLANAR_ENTRIES],
                          const double torque_nm[CONTROL_PLANAR_AXES],
                          double out_force_n[CONTROL_PLANAR_AXES])
{
    FSW_ASSERT((jacobian != NULL) && (torque_nm != NULL) && (out_force_n != NULL));
    const double scale = 1.0 / determinant(jacobian);
    out_force_n[0]     = scale * ((jacobian[3] * torque_nm[0]) - (jacobian[2] * torque_nm[1]));
    out_force_n[1]     = scale * ((jacobian[0] * torque_nm[1]) - (jacobian[1] * torque_nm[0]));
}

void control_planar_torque(const double jacobian[CONTROL_PLANAR_ENTRIES],
                           const double force_n[CONTROL_PLANAR_AXES],
                           double out_torque_nm[CONTROL_PLANAR_AXES])
{
    FSW_ASSERT((jacobian != NULL) && (force_n != NULL) && (out_torque_nm != NULL));
    out_torque_nm[0] = (jacobian[0] * force_n[0]) + (jacobian[2] * force_n[1]);
    out_torque_nm[1] = (jacobian[1] * force_n[0]) + (jacobian[3] * force_n[1]);
}

void control_planar_move(const double jacobian[CONTROL_PLANAR_ENTRIES],
                         const double angle_rad[CONTROL_PLANAR_AXES], double out_m[CONTROL_PLANAR_AXES])
{
    FSW_ASSERT((jacobian != NULL) && (angle_rad != NULL) && (out_m != NULL));
    out_m[0] = (jacobian[0] * angle_rad[0]) + (jacobian[1] * angle_rad[1]);
    out_m[1] = (jacobian[2] * angle_rad[0]) + (jacobian[3] * angle_rad[1]);
}

void control_planar_angles(const double jacobian[CONTROL_PLANAR_ENTRIES],
                           const double move_m[CONTROL_PLANAR_AXES], double out_rad[CONTROL_PLANAR_AXES])
{
    FSW_ASSERT((jacobian != NULL) && (move_m != NULL) && (out_rad != NULL));
    const double scale = 1.0 / determinant(jacobian);
    out_rad[0]         = scale * ((jacobian[3] * move_m[0]) - (jacobian[1] * move_m[1]));
    out_rad[1]         = scale * ((jacobian[0] * move_m[1]) - (jacobian[2] * move_m[0]));
}

double control_planar_length(const double vector[CONTROL_PLANAR_AXES])
{
    FSW_ASSERT(vector != NULL);
    const double one    = control_absolute(vector[0]);
    const double other  = control_absolute(vector[1]);
    const double square = (one * one) + (other * other);
    if (!(square > 0.0)) {
        return 0.0;
    }
    // The first estimate is at most 42 % too large. Each step of Newton's method squares the relative error.
    double length = one + other;
    for (unsigned i = 0U; i < NEWTON_STEPS; i++) {
        length = 0.5 * (length + (square / length));
    }
    return length;
}
