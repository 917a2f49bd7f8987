// SPDX-License-Identifier: Apache-2.0
/// Rigid-body model of an arm: a chain of joints, each with the link that it moves.
///
/// Frames     Joint i turns link i about an axis of the link's frame, or shifts it along the axis if it is
///            prismatic; its origin is the pose of that frame in the previous link at joint position 0 (of
///            joint 0 in the base), as in URDF.
/// Units      In all files of the arm: for a prismatic joint, read m, N and kg where names contain rad, Nm
///            and kgm2.
/// Ownership  The caller provides the structures.
/// Context    Any, no state.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_MODEL_H
#define FSW_SUBSYSTEMS_ARM_ARM_MODEL_H

#include "fsw/subsystems/arm/arm_geometry.h"

#include <stdbool.h>

#define ARM_JOINTS_MAX 12U

typedef struct {
    arm_pose_t origin;
    arm_vector_t axis; ///< Unit vector.
    double mass_kg;
    arm_vector_t centre_m; ///< Centre of mass in the link's frame.
    /// Inertia about the centre of mass, in the axes of the link. (A symmetric matrix, not a rotation.)
    arm_rotation_t inertia_kgm2;
    bool is_prismatic;
} arm_link_t;

typedef struct {
    unsigned joint_count; ///< 1 to ARM_JOINTS_MAX.
    arm_link_t link[ARM_JOINTS_MAX];
    arm_pose_t tool;           ///< Pose of the tool relative to the last link.
    arm_vector_t gravity_m_s2; ///< Gravity in the axes of the base.
} arm_model_t;

typedef struct { // Poses and axes in the frame of the base.
    arm_pose_t link[ARM_JOINTS_MAX];
    arm_vector_t axis[ARM_JOINTS_MAX];
    arm_pose_t tool;
} arm_kinematics_t;

/// Velocities of the tool for velocities of the joints: rows 0 to 2 linear [m], rows 3 to 5 angular [1], in
/// the axes of the base; for a prismatic joint, linear [1], and angular 0.
typedef struct {
    double at[6][ARM_JOINTS_MAX];
} arm_jacobian_t;

typedef struct {
    double position_rad[ARM_JOINTS_MAX];
    double velocity_rad_s[ARM_JOINTS_MAX];
    double acceleration_rad_s2[ARM_JOINTS_MAX];
} arm_motion_t;

void arm_kinematics(const arm_model_t* model, const double angle_rad[ARM_JOINTS_MAX],
                    arm_kinematics_t* out_kinematics);
void arm_jacobian(const arm_model_t* model, const arm_kinematics_t* kinematics, arm_jacobian_t* out_jacobian);

/// Compute the torques of the joints that produce a motion (recursive Newton-Euler method) [Nm]. Without
/// velocities and accelerations they are the torques that hold the arm against gravity.
void arm_inverse_dynamics(const arm_model_t* model, const arm_motion_t* motion,
                          double out_torque_nm[ARM_JOINTS_MAX]);

#endif // FSW_SUBSYSTEMS_ARM_ARM_MODEL_H
