// SPDX-License-Identifier: Apache-2.0
#include "sim/operator/scene.h"

#include <math.h>

#define REACH_MARGIN_M 0.01
#define HALVINGS 40U ///< Halvings of a few centimetres: the error is far below the resolution of any encoder.

/// Contact with one part of the contour: direction away from the contour, and depth of the finger in it. The
/// direction is only valid with contact (depth above 0).
typedef struct {
    plane_t normal;
    double depth_m;
} touch_t;

#define SHAPES 2U // Flat part and bump of the contour.

bool scene_reachable(const scene_t* const scene, const plane_t tip)
{
    const double upper    = scene->link_length_m[0];
    const double lower    = scene->link_length_m[1];
    const double distance = sqrt(tip.x * tip.x + tip.z * tip.z);
    return (distance >= fabs(upper - lower) + REACH_MARGIN_M) && (distance <= upper + lower - REACH_MARGIN_M);
}

plane_t scene_tip(const scene_t* const scene, const double joint_rad[SCENE_JOINTS])
{
    const double sum = joint_rad[0] + joint_rad[1];
    return (plane_t){
        .x = scene->link_length_m[0] * cos(joint_rad[0]) + scene->link_length_m[1] * cos(sum),
        .z = scene->link_length_m[0] * sin(joint_rad[0]) + scene->link_length_m[1] * sin(sum),
    };
}

void scene_joints(const scene_t* const scene, const plane_t tip, double out_joint_rad[SCENE_JOINTS])
{
    const double upper  = scene->link_length_m[0];
    const double lower  = scene->link_length_m[1];
    const double square = tip.x * tip.x + tip.z * tip.z;
    const double cosine = (square - upper * upper - lower * lower) / (2.0 * upper * lower);
    out_joint_rad[1]    = -acos(fmax(-1.0, fmin(1.0, cosine)));
    out_joint_rad[0]    = atan2(tip.z, tip.x) - atan2(lower * sin(out_joint_rad[1]), upper + lower * cosine);
}

static void touches(const scene_t* const scene, const plane_t tip, touch_t out_touch[SHAPES])
{
    const double reach   = scene->bump_radius_m + scene->tip_radius_m;
    const plane_t offset = {
        .x = tip.x - scene->bump_x_m,
        .z = tip.z - (scene->contour_top_m + scene->bump_height_m - scene->bump_radius_m),
    };
    const double distance = sqrt(offset.x * offset.x + offset.z * offset.z);
    out_touch[0] =
        (touch_t){.normal = {0.0, 1.0}, .depth_m = scene->contour_top_m + scene->tip_radius_m - tip.z};
    out_touch[1] = (touch_t){.depth_m = reach - distance};
    if (out_touch[1].depth_m > 0.0) {
        out_touch[1].normal = (plane_t){offset.x / distance, offset.z / distance};
    }
}

static double press_force(const scene_t* const scene, const plane_t tip)
{
    touch_t touch[SHAPES];
    plane_t force = {0.0, 0.0};
    touches(scene, tip, touch);
    for (unsigned i = 0U; i < SHAPES; i++) {
        const double push = scene->contour_stiffness_n_m * fmax(0.0, touch[i].depth_m);
        force.x += push * touch[i].normal.x;
        force.z += push * touch[i].normal.z;
    }
    return sqrt(force.x * force.x + force.z * force.z);
}

bool scene_touching(const scene_t* const scene, const plane_t tip)
{
    return press_force(scene, tip) > 0.0;
}

double scene_press_height(const scene_t* const scene, const double x_m, const double force_n)
{
    // The force decreases with height: bisect between a height that is too low and one without contact.
    const double depth = force_n / scene->contour_stiffness_n_m;
    double low         = scene->contour_top_m + scene->tip_radius_m - 2.0 * depth - 1.0e-6;
    double high        = scene->contour_top_m + scene->bump_height_m + scene->tip_radius_m + 1.0e-6;
    for (unsigned i = 0U; i < HALVINGS; i++) {
        const double middle = 0.5 * (low + high);
        if (press_force(scene, (plane_t){x_m, middle}) > force_n) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

/// Add the torques about both joints of a force at a point, for an arm with its tip at `tip`.
static void add_torque(const scene_t* const scene, const plane_t tip, const plane_t point,
                       const plane_t force, double torque_nm[SCENE_JOINTS])
{
    double joint_rad[SCENE_JOINTS];
    scene_joints(scene, tip, joint_rad);
    const plane_t elbow = {scene->link_length_m[0] * cos(joint_rad[0]),
                           scene->link_length_m[0] * sin(joint_rad[0])};
    torque_nm[0] += point.x * force.z - point.z * force.x;
    torque_nm[1] += (point.x - elbow.x) * force.z - (point.z - elbow.z) * force.x;
}

void scene_contact_torque(const scene_t* const scene, const plane_t tip, const double slide,
                          double out_torque_nm[SCENE_JOINTS])
{
    touch_t touch[SHAPES];
    touches(scene, tip, touch);
    out_torque_nm[0] = 0.0;
    out_torque_nm[1] = 0.0;
    for (unsigned i = 0U; i < SHAPES; i++) {
        const plane_t normal = touch[i].normal;
        const double push    = scene->contour_stiffness_n_m * touch[i].depth_m;
        const double drag    = scene->contour_friction * slide * push;
        if (push > 0.0) {
            // The finger is a sphere: the contour acts on its surface. Drag points against the motion.
            const plane_t point = {tip.x - scene->tip_radius_m * normal.x,
                                   tip.z - scene->tip_radius_m * normal.z};
            const plane_t force = {push * normal.x - drag * normal.z, push * normal.z + drag * normal.x};
            add_torque(scene, tip, point, force, out_torque_nm);
        }
    }
}

void scene_spring_torque(const scene_t* const scene, const plane_t tip, double out_torque_nm[SCENE_JOINTS])
{
    const plane_t along  = {tip.x - scene->hook_m[0], tip.z - (scene->hook_m[1] - scene->cable_m)};
    const double length  = sqrt(along.x * along.x + along.z * along.z);
    const double stretch = length - scene->cable_m;
    out_torque_nm[0]     = 0.0;
    out_torque_nm[1]     = 0.0;
    if (stretch > 0.0) {
        const double preload = scene->spring_preload_n * fmin(1.0, stretch / scene->spring_preload_m);
        const double pull    = preload + scene->spring_stiffness_n_m * stretch;
        add_torque(scene, tip, tip, (plane_t){-pull * along.x / length, -pull * along.z / length},
                   out_torque_nm);
    }
}
