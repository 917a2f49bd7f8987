// SPDX-License-Identifier: Apache-2.0
/// The operator's knowledge of the scene: position of the finger for joint angles, and forces of contour and
/// spring. The models are static and independent of those of the plant.
#ifndef SIM_OPERATOR_SCENE_H
#define SIM_OPERATOR_SCENE_H

#include "sim/world/world.h"

#include <stdbool.h>

#define SCENE_JOINTS 2U

/// The operator's model of the scene, which is planar: a fixed robot at the origin whose two joints turn
/// about -y and whose links lie along x; a sphere at its tip ("finger"), which touches a fixture (a box with
/// a bump across it) and pulls one cable.
typedef struct {
    double link_length_m[SCENE_JOINTS];
    double home_rad[SCENE_JOINTS];
    double tip_radius_m;
    double contour_top_m;         ///< Height of the flat part of the contour.
    double bump_x_m;              ///< Position of the top of the bump.
    double bump_height_m;         ///< Height of the bump above the flat part.
    double bump_radius_m;         ///< Radius of the bump, a cylinder across the plane.
    double contour_stiffness_n_m; ///< Normal contact stiffness.
    double contour_friction;      ///< Coulomb coefficient.
    double hook_m[2];             ///< x, z of the spring's hook at rest.
    double cable_m;               ///< Rest length of the cable, straight down from the hook.
    double spring_stiffness_n_m;  ///< Stiffness of the spring, whose force adds to the preload.
    double spring_preload_n;      ///< Preload; it rises from 0 over the first spring_preload_m.
    double spring_preload_m;
} scene_t;

/// Derive the scene from the first robot, contact and spring of a world. STATUS_OK, or STATUS_INVALID if the
/// world differs from this model: then `error` contains file, line, value and what is expected.
MUST_USE status_t scene_of(const world_t* world, scene_t* out_scene, char error[DOCUMENT_ERROR_MAX]);

/// A point or force in the plane of the arm.
typedef struct {
    double x;
    double z;
} plane_t;

/// True if the finger can reach `tip` with a margin of 1 cm.
bool scene_reachable(const scene_t* scene, plane_t tip);

/// Returns the position of the tip for joint angles.
plane_t scene_tip(const scene_t* scene, const double joint_rad[SCENE_JOINTS]);

/// Joint angles for a tip within reach, elbow up.
void scene_joints(const scene_t* scene, plane_t tip, double out_joint_rad[SCENE_JOINTS]);

/// Height of the centre of the finger at which it presses on the contour with `force_n` (0: it touches only).
double scene_press_height(const scene_t* scene, double x_m, double force_n);

/// True if a finger at `tip` would overlap the contour, so that it presses on it.
bool scene_touching(const scene_t* scene, plane_t tip);

/// Joint torques of the contour on a finger held at `tip`. `slide` in -1..1 is the share of the full friction
/// that acts, positive for a finger that slides to +x.
void scene_contact_torque(const scene_t* scene, plane_t tip, double slide,
                          double out_torque_nm[SCENE_JOINTS]);

/// Joint torques of the hooked spring on a finger held at `tip`.
void scene_spring_torque(const scene_t* scene, plane_t tip, double out_torque_nm[SCENE_JOINTS]);

#endif // SIM_OPERATOR_SCENE_H
