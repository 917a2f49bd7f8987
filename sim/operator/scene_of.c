// SPDX-License-Identifier: Apache-2.0
#include "sim/operator/scene.h"

#include <math.h>

#define ALIGNED 1e-9 // Largest deviation of a component of a direction.

typedef struct {
    const world_t* world;
    const world_robot_t* robot; // The first robot of the world.
    scene_t* scene;
    char* error;
} taker_t;

static status_t refuse(const taker_t* const taker, const unsigned line, const char* const found,
                       const char* const expected)
{
    return document_refuse(taker->world->path, line, found, expected, taker->error);
}

static bool is_turned(const pose_t* const pose)
{
    bool is_turned = false;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            is_turned = is_turned || (pose->rotation.at[i][k] != ((i == k) ? 1.0 : 0.0));
        }
    }
    return is_turned;
}

/// True if the vector is parallel to the x axis.
static bool is_along_x(const double vector[3])
{
    return (vector[1] == 0.0) && (vector[2] == 0.0);
}

// ---- The arm ----

static status_t take_link(const taker_t* const taker, const unsigned index)
{
    const robot_joint_t* joint = &taker->robot->model.joint[index];
    const bool is_in_plane     = (joint->kind == ROBOT_JOINT_REVOLUTE) && (joint->parent == index) &&
                             !is_turned(&joint->origin) && is_along_x(joint->origin.position_m) &&
                             (fabs(joint->axis[1] + 1.0) <= ALIGNED);
    if (!is_in_plane || ((index == 0U) && (joint->origin.position_m[0] != 0.0))) {
        return refuse(taker, taker->robot->line, joint->name,
                      "revolute joints about -y, one after the other along x from the origin");
    }
    if (index > 0U) {
        taker->scene->link_length_m[index - 1U] = joint->origin.position_m[0];
    }
    taker->scene->home_rad[index] = taker->robot->start[index];
    return STATUS_OK;
}

static status_t take_robot(const taker_t* const taker)
{
    const world_robot_t* robot = taker->robot;
    status_t status            = STATUS_OK;
    if (taker->world->robot_count == 0U) {
        return refuse(taker, 1U, "no Robot", "a robot that the hand leads");
    }
    if (robot->is_free || (robot->model.joint_count != SCENE_JOINTS) || is_turned(&robot->pose) ||
        !is_along_x(robot->pose.position_m) || (robot->pose.position_m[0] != 0.0)) {
        return refuse(taker, robot->line, robot->name, "a fixed robot of two joints at the origin");
    }
    for (unsigned i = 0U; (i < SCENE_JOINTS) && (status == STATUS_OK); i++) {
        status = take_link(taker, i);
    }
    return status;
}

// ---- Contour and spring ----

/// True if the frame can be the tip: it is fixed to the last body, on its x axis.
static bool is_tip(const taker_t* const taker, const unsigned frame)
{
    const robot_frame_t* tip = &taker->robot->model.frame[frame];
    return (tip->body == SCENE_JOINTS) && !is_turned(&tip->pose) && is_along_x(tip->pose.position_m);
}

static status_t take_tip(const taker_t* const taker, const world_contact_t* const contact)
{
    const robot_model_t* model = &taker->robot->model;
    const shape_t* ball        = NULL;
    unsigned count             = 0U;
    for (size_t i = 0U; i < model->shape_count; i++) {
        if (model->shape[i].frame == contact->side[0].frame) {
            ball = &model->shape[i];
            count++;
        }
    }
    const bool is_ball = (count == 1U) && (ball->kind == SHAPE_SPHERE) && is_along_x(ball->pose.position_m) &&
                         (ball->pose.position_m[0] == 0.0);
    if (!is_ball || !is_tip(taker, contact->side[0].frame)) {
        return refuse(taker, contact->line, contact->a, "a sphere at the end of the second body");
    }
    taker->scene->tip_radius_m                     = ball->radius_m;
    taker->scene->link_length_m[SCENE_JOINTS - 1U] = model->frame[contact->side[0].frame].pose.position_m[0];
    return STATUS_OK;
}

static status_t take_contour(const taker_t* const taker)
{
    const world_t* world           = taker->world;
    scene_t* scene                 = taker->scene;
    const world_contact_t* contact = &world->contact[0];
    if ((world->contact_count == 0U) || (contact->side[0].robot != 0U) || !contact->side[1].is_fixture) {
        return refuse(taker, taker->robot->line, "Contact", "a contact of the robot with a fixture");
    }
    const world_fixture_t* fixture = &world->fixture[contact->side[1].fixture];
    const shape_t* flat            = &fixture->shape[0];
    const shape_t* bump            = &fixture->shape[1];
    const double* at               = flat->pose.position_m;
    const bool is_contour          = (fixture->shape_count == 2U) && (flat->kind == SHAPE_BOX) &&
                            (bump->kind == SHAPE_CYLINDER) && !is_turned(&flat->pose) &&
                            (fabs(fabs(bump->pose.rotation.at[1][2]) - 1.0) <= ALIGNED) &&
                            ((fixture->at[1] + at[1]) == 0.0) && (bump->length_m == flat->size_m[1]);
    if (!is_contour) {
        return refuse(taker, fixture->line, fixture->name, "a Box and a Cylinder along y, which is as wide");
    }
    const double axis_z          = fixture->at[2] + bump->pose.position_m[2];
    scene->contour_top_m         = fixture->at[2] + (at[2] + flat->size_m[2] / 2.0);
    scene->bump_x_m              = fixture->at[0] + bump->pose.position_m[0];
    scene->bump_radius_m         = bump->radius_m;
    scene->bump_height_m         = (axis_z + bump->radius_m) - scene->contour_top_m;
    scene->contour_stiffness_n_m = contact->stiffness;
    scene->contour_friction      = contact->friction;
    return take_tip(taker, contact);
}

static status_t take_spring(const taker_t* const taker)
{
    scene_t* scene               = taker->scene;
    const world_spring_t* spring = &taker->world->spring[0];
    if (taker->world->spring_count == 0U) {
        return refuse(taker, taker->robot->line, "CableSpring", "a cable spring");
    }
    if ((spring->robot != 0U) || (spring->frame != taker->world->contact[0].side[0].frame) ||
        (spring->hook[1] != 0.0)) {
        return refuse(taker, spring->line, spring->on,
                      "a cable in the plane of the arm on the link of the contact");
    }
    scene->hook_m[0]            = spring->hook[0];
    scene->hook_m[1]            = spring->hook[2];
    scene->cable_m              = spring->length;
    scene->spring_stiffness_n_m = spring->stiffness;
    scene->spring_preload_n     = spring->preload;
    scene->spring_preload_m     = spring->travel;
    return STATUS_OK;
}

status_t scene_of(const world_t* const world, scene_t* const out_scene, char error[DOCUMENT_ERROR_MAX])
{
    const taker_t taker = {.world = world, .robot = &world->robot[0], .scene = out_scene, .error = error};
    *out_scene          = (scene_t){.tip_radius_m = 0.0};
    status_t status     = take_robot(&taker);
    status              = (status == STATUS_OK) ? take_contour(&taker) : status;
    return (status == STATUS_OK) ? take_spring(&taker) : status;
}
