// SPDX-License-Identifier: Apache-2.0
/// Vectors, rotations and poses in three dimensions.
///
/// The columns of a rotation are the axes of the inner frame: v_outer = rotation v_inner.
///
/// Context    Any, no state.
/// Time       O(1).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_GEOMETRY_H
#define FSW_SUBSYSTEMS_ARM_ARM_GEOMETRY_H

typedef struct {
    double at[3];
} arm_vector_t;

typedef struct {
    double at[3][3];
} arm_rotation_t;

/// Pose of a frame in an outer one: p_outer = rotation p_inner + position.
typedef struct {
    arm_rotation_t rotation;
    arm_vector_t position_m;
} arm_pose_t;

arm_vector_t arm_vector(const double components[3]);
arm_vector_t arm_sum(arm_vector_t a, arm_vector_t b);
arm_vector_t arm_difference(arm_vector_t a, arm_vector_t b);
arm_vector_t arm_times(arm_vector_t a, double factor);
arm_vector_t arm_cross(arm_vector_t a, arm_vector_t b);
double arm_dot(arm_vector_t a, arm_vector_t b);
double arm_length(arm_vector_t a);

/// Convert a vector from the inner to the outer frame, and back.
arm_vector_t arm_rotated(const arm_rotation_t* rotation, arm_vector_t inner);
arm_vector_t arm_rotated_back(const arm_rotation_t* rotation, arm_vector_t outer);
arm_rotation_t arm_product(const arm_rotation_t* outer, const arm_rotation_t* inner);
arm_pose_t arm_composed(const arm_pose_t* outer, const arm_pose_t* inner);

/// Returns the rotation about an axis of length 1.
arm_rotation_t arm_rotation_about(arm_vector_t axis, double angle_rad);
/// Returns the rotation of roll, pitch and yaw: about the fixed axes x, y and z, in that order (as in URDF).
arm_rotation_t arm_rotation_of_rpy(const double rpy_rad[3]);
/// Returns the rotation vector (axis times angle, 0 to pi) that turns `from` into `to`, in the outer frame
/// [rad].
arm_vector_t arm_rotation_between(const arm_rotation_t* from, const arm_rotation_t* to);
/// Turn a rotation by a rotation vector of the outer frame.
arm_rotation_t arm_rotation_turned_by(const arm_rotation_t* rotation, arm_vector_t vector_rad);

#endif // FSW_SUBSYSTEMS_ARM_ARM_GEOMETRY_H
