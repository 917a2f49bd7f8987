// SPDX-License-Identifier: Apache-2.0
/// Reader of robots: a subset of URDF that describes the complete mechanics of a robot.
///
/// Elements read: robot, link, inertial (origin, mass, inertia), collision (origin, geometry: box, sphere,
/// cylinder), joint of type revolute, continuous, prismatic or fixed (origin, parent, child, axis, limit,
/// mimic). Elements skipped: visual, material, transmission. All other elements are refused with file and
/// line, because the simulator does not model their physics. Drives define friction: `dynamics` must be zero.
///
/// Links that fixed joints connect become one body with the frame of the topmost link and the inertia of all.
/// Each link of the file is a frame with its name. The reader also refuses: a link with two parents, a loop,
/// more than one root, a mimic of a joint that is unknown, fixed or itself a mimic, a mass or principal
/// moment of inertia that is not positive, moments of which one exceeds the sum of the other two, and a
/// moving body without mass.
///
/// Ownership  The caller provides robot_model_t; it has no pointers.
/// Context    One task.
#ifndef SIM_WORLD_ROBOT_MODEL_H
#define SIM_WORLD_ROBOT_MODEL_H

#include "base/status.h"
#include "sim/world/document.h"

#include <stdbool.h>
#include <stddef.h>

#define ROBOT_JOINTS_MAX 12U ///< Joints that are not fixed.
#define ROBOT_BODIES_MAX (ROBOT_JOINTS_MAX + 1U)
#define ROBOT_LINKS_MAX 32U ///< Links of a file.
#define ROBOT_SHAPES_MAX 32U

typedef struct {
    double at[3][3];
} matrix_t;

/// Position and orientation of an inner frame in an outer frame: p_outer = rotation * p_inner + position.
typedef struct {
    matrix_t rotation;
    double position_m[3];
} pose_t;

/// Mass properties in the axes of the body; the inertia is about the centre of mass.
typedef struct {
    double mass_kg; ///< 0: the body has no mass.
    double com_m[3];
    matrix_t inertia_kgm2;
} robot_mass_t;

typedef enum {
    ROBOT_JOINT_REVOLUTE,
    ROBOT_JOINT_CONTINUOUS,
    ROBOT_JOINT_PRISMATIC,
    ROBOT_JOINT_FIXED ///< Occurs only while the file is read.
} robot_joint_kind_t;

/// A joint that moves body i + 1, where i is its own index.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    robot_joint_kind_t kind;
    unsigned parent; ///< Index of the parent body.
    pose_t origin;   ///< Pose of the moved body in the parent at joint position 0.
    double axis[3];  ///< Axis in the moved body; length 1.
    double lower;    ///< [rad] or [m]; not used for continuous joints.
    double upper;
    bool is_mimic;   ///< The position is multiplier * position of the leader + offset.
    unsigned leader; ///< Index of the leader, which is not itself a mimic.
    double multiplier;
    double offset;
} robot_joint_t;

/// The frame of a link of the file.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned body;
    pose_t pose; ///< Pose in the body.
} robot_frame_t;

typedef enum {
    SHAPE_BOX,
    SHAPE_SPHERE,
    SHAPE_CYLINDER ///< The axis of the cylinder is z.
} shape_kind_t;

typedef struct {
    shape_kind_t kind;
    unsigned frame; ///< For a shape of a robot: the link that it belongs to.
    pose_t pose;    ///< Pose in the frame; for a shape of a fixture in the world.
    double size_m[3];
    double radius_m;
    double length_m;
} shape_t;

typedef struct {
    robot_mass_t body[ROBOT_BODIES_MAX]; ///< Body 0 is the root; parents precede their children.
    size_t joint_count;
    robot_joint_t joint[ROBOT_JOINTS_MAX];
    size_t frame_count;
    robot_frame_t frame[ROBOT_LINKS_MAX];
    size_t shape_count;
    shape_t shape[ROBOT_SHAPES_MAX];
} robot_model_t;

/// Read a robot. Statuses of document_read; STATUS_INVALID also if the file has more elements than the model
/// can store.
MUST_USE status_t robot_model_read(const char* path, robot_model_t* out_model,
                                   char error[DOCUMENT_ERROR_MAX]);

/// Returns the index of a joint or frame; the number of joints or frames if none has that name.
size_t robot_model_joint(const robot_model_t* model, const char* name);
size_t robot_model_frame(const robot_model_t* model, const char* name);

/// Pose with a position and the angles roll, pitch and yaw (about fixed x, y, z, in that order).
pose_t pose_of(const double position_m[3], const double rpy_rad[3]);
/// Express a point, given in the frame `pose`, in the frame in which `pose` is given.
void pose_apply(const pose_t* pose, const double point[3], double out[3]);
/// Express `inner`, a pose in the frame `outer`, in the frame in which `outer` is given.
pose_t pose_compose(const pose_t* outer, const pose_t* inner);

#endif // SIM_WORLD_ROBOT_MODEL_H
