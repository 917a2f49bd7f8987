// SPDX-License-Identifier: Apache-2.0
/// Reads the elements of a URDF file and checks each of them separately. Private to sim/world.
#ifndef SIM_WORLD_URDF_H
#define SIM_WORLD_URDF_H

#include "sim/world/robot_model.h"

#define URDF_JOINTS_MAX (ROBOT_LINKS_MAX - 1U)
#define URDF_ROOT URDF_JOINTS_MAX ///< Joint of a link that has no parent.

typedef struct {
    double position_m[3];
    double rpy_rad[3];
} urdf_origin_t;

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    robot_mass_t mass; ///< In the link's frame.
    unsigned joint;    ///< Joint that has this link as its child; URDF_ROOT: there is none.
    bool is_placed;
} urdf_link_t;

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    char type[DOCUMENT_TEXT_MAX];
    char parent_name[DOCUMENT_TEXT_MAX];
    char child_name[DOCUMENT_TEXT_MAX];
    unsigned line;
    robot_joint_kind_t kind;
    urdf_origin_t origin;
    double axis[3];
    double lower;
    double upper;
    bool has_limit;
    char leader_name[DOCUMENT_TEXT_MAX]; ///< The joint that this one mimics; empty: none.
    unsigned leader_line;
    double multiplier;
    double offset;
    double unused[4]; ///< Effort and velocity, which only controllers use; damping and friction, which are 0.
    unsigned parent;  ///< Indices of the two links.
    unsigned child;
} urdf_joint_t;

typedef struct {
    urdf_link_t link[ROBOT_LINKS_MAX];
    size_t link_count;
    urdf_joint_t joint[URDF_JOINTS_MAX];
    size_t joint_count;
    shape_t shape[ROBOT_SHAPES_MAX];
    size_t shape_count;
} urdf_t;

/// Read a URDF file. Statuses of document_read.
MUST_USE status_t urdf_read(const char* path, urdf_t* out_urdf, char error[DOCUMENT_ERROR_MAX]);

/// Add to `body` the mass that is rigidly connected to it at a pose. If the body has no mass, the numbers are
/// copied unchanged.
void robot_mass_add(robot_mass_t* body, const pose_t* pose, const robot_mass_t* more);

#endif // SIM_WORLD_URDF_H
