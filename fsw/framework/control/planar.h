// SPDX-License-Identifier: Apache-2.0
/// Forces and motions of the tip of a mechanism with two axes that moves in a plane, by its Jacobian matrix.
/// The matrix is {dx/dq1, dx/dq2, dz/dq1, dz/dq2} [m/rad].
///
/// Context    Any, no state.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_CONTROL_PLANAR_H
#define FSW_FRAMEWORK_CONTROL_PLANAR_H

#include <stdbool.h>

#define CONTROL_PLANAR_AXES 2U
#define CONTROL_PLANAR_ENTRIES 4U

/// True if the matrix can be inverted: the absolute value of its determinant is not below 1e-3 m2.
/// Functions marked "regular" may be called only then.
bool control_planar_is_regular(const double jacobian[CONTROL_PLANAR_ENTRIES]);
/// Compute the force at the tip that the torques of the axes produce; regular.
void control_planar_force(const double jacobian[CONTROL_PLANAR_ENTRIES],
                          const double torque_nm[CONTROL_PLANAR_AXES],
                          double out_force_n[CONTROL_PLANAR_AXES]);
/// Compute the torques of the axes that produce a force at the tip.
void control_planar_torque(const double jacobian[CONTROL_PLANAR_ENTRIES],
                           const double force_n[CONTROL_PLANAR_AXES],
                           double out_torque_nm[CONTROL_PLANAR_AXES]);
/// Compute the motion of the tool tip that small motions of the axes produce.
void control_planar_move(const double jacobian[CONTROL_PLANAR_ENTRIES],
                         const double angle_rad[CONTROL_PLANAR_AXES], double out_m[CONTROL_PLANAR_AXES]);
/// Compute the small motions of the axes that produce a motion of the tip; regular.
void control_planar_angles(const double jacobian[CONTROL_PLANAR_ENTRIES],
                           const double move_m[CONTROL_PLANAR_AXES], double out_rad[CONTROL_PLANAR_AXES]);
/// Returns the length of a vector; the relative error is below 1e-15.
double control_planar_length(const double vector[CONTROL_PLANAR_AXES]);

#endif // FSW_FRAMEWORK_CONTROL_PLANAR_H
