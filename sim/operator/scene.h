// SPDX-License-Identifier: Apache-2.0
/// The operator's knowledge of the scene: position of the finger by joint angles, and forces of contour and
/// spring. Static models, written independently of the plant's.
#ifndef SIM_OPERATOR_SCENE_H
#define SIM_OPERATOR_SCENE_H

#include "sim/plant/plant.h"

#include <stdbool.h>

/// A point or force in the plane of the arm.
typedef struct {
    double x;
    double z;
} plane_t;

/// True if the finger can reach `tip` with a margin of 1 cm.
bool scene_reachable(const plant_parameters_t* scene, plane_t tip);

/// Tip for joint angles.
plane_t scene_tip(const plant_parameters_t* scene, const double joint_rad[PLANT_JOINTS]);

/// Joint angles for a tip within reach, elbow up.
void scene_joints(const plant_parameters_t* scene, plane_t tip, double out_joint_rad[PLANT_JOINTS]);

/// Height of the finger's centre at which it presses on the contour with `force_n` (0: just touches).
double scene_press_height(const plant_parameters_t* scene, double x_m, double force_n);

/// True if a finger at `tip` would overlap the contour, so that it presses on it.
bool scene_touching(const plant_parameters_t* scene, plane_t tip);

/// Joint torques of the contour on a finger held at `tip`. `slide` in -1..1 is the share of the full friction
/// that acts, positive for a finger that slides to +x.
void scene_contact_torque(const plant_parameters_t* scene, plane_t tip, double slide,
                          double out_torque_nm[PLANT_JOINTS]);

/// Joint torques of the hooked spring on a finger held at `tip`.
void scene_spring_torque(const plant_parameters_t* scene, plane_t tip, double out_torque_nm[PLANT_JOINTS]);

#endif // SIM_OPERATOR_SCENE_H
