// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_geometry.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <math.h>
#include <stddef.h>

arm_vector_t arm_vector(const double components[3])
{
    return (arm_vector_t){{components[0], components[1], components[2]}};
}

arm_vector_t arm_sum(const arm_vector_t a, const arm_vector_t b)
{
    return (arm_vector_t){{a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2]}};
}

arm_vector_t arm_difference(const arm_vector_t a, const arm_vector_t b)
{
    return (arm_vector_t){{a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]}};
}

arm_vector_t arm_times(const arm_vector_t a, const double factor)
{
    return (arm_vector_t){{a.at[0] * factor, a.at[1] * factor, a.at[2] * factor}};
}

arm_vector_t arm_cross(const arm_vector_t a, const arm_vector_t b)
{
    return (arm_vector_t){{(a.at[1] * b.at[2]) - (a.at[2] * b.at[1]),
                           (a.at[2] * b.at[0]) - (a.at[0] * b.at[2]),
                           (a.at[0] * b.at[1]) - (a.at[1] * b.at[0])}};
}

double arm_dot(const arm_vector_t a, const arm_vector_t b)
{
    return (a.at[0] * b.at[0]) + (a.at[1] * b.at[1]) + (a.at[2] * b.at[2]);
}

double arm_length(const arm_vector_t a)
{
    return sqrt(arm_dot(a, a));
}

arm_vector_t arm_rotated(const arm_rotation_t* const rotation, const arm_vector_t inner)
{
    FSW_ASSERT(rotation != NULL);
    arm_vector_t outer;
    for (unsigned i = 0U; i < 3U; i++) {
        outer.at[i] = (rotation->at[i][0] * inner.at[0]) + (rotation->at[i][1] * inner.at[1]) +
                      (rotation->at[i][2] * inner.at[2]);
    }
    return outer;
}

arm_vector_t arm_rotated_back(const arm_rotation_t* const rotation, const arm_vector_t outer)
{
    FSW_ASSERT(rotation != NULL);
    arm_vector_t inner;
    for (unsigned i = 0U; i < 3U; i++) {
        inner.at[i] = (rotation->at[0][i] * outer.at[0]) + (rotation->at[1][i] * outer.at[1]) +
                      (rotation->at[2][i] * outer.at[2]);
    }
    return inner;
}

arm_rotation_t arm_product(const arm_rotation_t* const outer, const arm_rotation_t* const inner)
{
    FSW_ASSERT((outer != NULL) && (inner != NULL));
    arm_rotation_t product;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            product.at[i][k] = (outer->at[i][0] * inner->at[0][k]) + (outer->at[i][1] * inner->at[1][k]) +
                               (outer->at[i][2] * inner->at[2][k]);
        }
    }
    return product;
}

arm_pose_t arm_composed(const arm_pose_t* const outer, const arm_pose_t* const inner)
{
    FSW_ASSERT((outer != NULL) && (inner != NULL));
    return (arm_pose_t){.rotation = arm_product(&outer->rotation, &inner->rotation),
                        .position_m =
                            arm_sum(outer->position_m, arm_rotated(&outer->rotation, inner->position_m))};
}

arm_rotation_t arm_rotation_about(const arm_vector_t axis, const double angle_rad)
{
    const control_sine_cosine_t angle = control_sine_cosine(angle_rad);
    const double s                    = angle.sine;
    const double c                    = angle.cosine;
    const double d                    = 1.0 - c;
    const double x                    = axis.at[0];
    const double y                    = axis.at[1];
    const double z                    = axis.at[2];
    return (arm_rotation_t){{{c + (x * x * d), (x * y * d) - (z * s), (x * z * d) + (y * s)},
                             {(x * y * d) + (z * s), c + (y * y * d), (y * z * d) - (x * s)},
                             {(x * z * d) - (y * s), (y * z * d) + (x * s), c + (z * z * d)}}};
}

arm_rotation_t arm_rotation_of_rpy(const double rpy_rad[3])
{
    const arm_rotation_t roll  = arm_rotation_about((arm_vector_t){{1.0, 0.0, 0.0}}, rpy_rad[0]);
    const arm_rotation_t pitch = arm_rotation_about((arm_vector_t){{0.0, 1.0, 0.0}}, rpy_rad[1]);
    const arm_rotation_t yaw   = arm_rotation_about((arm_vector_t){{0.0, 0.0, 1.0}}, rpy_rad[2]);
    const arm_rotation_t inner = arm_product(&pitch, &roll);
    return arm_product(&yaw, &inner);
}

/// Returns `to` times the transpose of `from`.
static arm_rotation_t quotient(const arm_rotation_t* const from, const arm_rotation_t* const to)
{
    arm_rotation_t turn;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            turn.at[i][k] = (to->at[i][0] * from->at[k][0]) + (to->at[i][1] * from->at[k][1]) +
                            (to->at[i][2] * from->at[k][2]);
        }
    }
    return turn;
}

arm_vector_t arm_rotation_between(const arm_rotation_t* const from, const arm_rotation_t* const to)
{
    FSW_ASSERT((from != NULL) && (to != NULL));
    // Find the quaternion q of the rotation. All elements of 4 q q^T are known; the row with the largest
    // diagonal element is used, to avoid a division by a small number.
    const arm_rotation_t turn  = quotient(from, to);
    const double x             = turn.at[0][0];
    const double y             = turn.at[1][1];
    const double z             = turn.at[2][2];
    const double product[4][4] = {{1.0 + x + y + z, turn.at[2][1] - turn.at[1][2],
                                   turn.at[0][2] - turn.at[2][0], turn.at[1][0] - turn.at[0][1]},
                                  {turn.at[2][1] - turn.at[1][2], 1.0 + x - y - z,
                                   turn.at[0][1] + turn.at[1][0], turn.at[0][2] + turn.at[2][0]},
                                  {turn.at[0][2] - turn.at[2][0], turn.at[0][1] + turn.at[1][0],
                                   1.0 - x + y - z, turn.at[1][2] + turn.at[2][1]},
                                  {turn.at[1][0] - turn.at[0][1], turn.at[0][2] + turn.at[2][0],
                                   turn.at[1][2] + turn.at[2][1], 1.0 - x - y + z}};
    unsigned row               = 0U;
    for (unsigned i = 1U; i < 4U; i++) {
        row = (product[i][i] > product[row][row]) ? i : row;
    }
    // q and -q are the same rotation; use the one with the smaller angle.
    const double sign      = (product[row][0] < 0.0) ? -1.0 : 1.0;
    const arm_vector_t v   = arm_times(arm_vector(&product[row][1]), sign);
    const double sine      = arm_length(v);
    const double half_turn = control_angle(sine, sign * product[row][0]);
    return (sine > 0.0) ? arm_times(v, 2.0 * half_turn / sine) : v;
}

arm_rotation_t arm_rotation_turned_by(const arm_rotation_t* const rotation, const arm_vector_t vector_rad)
{
    FSW_ASSERT(rotation != NULL);
    const double angle_rad = arm_length(vector_rad);
    if (!(angle_rad > 0.0)) {
        return *rotation;
    }
    const arm_rotation_t turn = arm_rotation_about(arm_times(vector_rad, 1.0 / angle_rad), angle_rad);
    return arm_product(&turn, rotation);
}
