// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/parameters.h"

#include <math.h>

#define ALIGNED 1e-9 // Largest deviation of a direction.

typedef struct {
    const world_t* world;
    const world_robot_t* robot;
    plant_parameters_t* parameters;
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

/// The vector lies on the x axis.
static bool is_along_x(const double vector[3])
{
    return (vector[1] == 0.0) && (vector[2] == 0.0);
}

// ---- The arm ----

static bool is_rod(const robot_mass_t* const body)
{
    const matrix_t* inertia = &body->inertia_kgm2;
    return is_along_x(body->com_m) && (inertia->at[0][1] == 0.0) && (inertia->at[0][2] == 0.0) &&
           (inertia->at[1][2] == 0.0) && (inertia->at[1][1] == inertia->at[2][2]);
}

static status_t take_link(const taker_t* const taker, const unsigned index)
{
    plant_parameters_t* parameters = taker->parameters;
    const robot_joint_t* joint     = &taker->robot->model.joint[index];
    const robot_mass_t* body       = &taker->robot->model.body[index + 1U];
    const bool is_in_plane         = (joint->kind == ROBOT_JOINT_REVOLUTE) && (joint->parent == index) &&
                             !is_turned(&joint->origin) && is_along_x(joint->origin.position_m) &&
                             (fabs(joint->axis[1] + 1.0) <= ALIGNED);
    if (!is_in_plane || ((index == 0U) && (joint->origin.position_m[0] != 0.0))) {
        return refuse(taker, taker->robot->line, joint->name,
                      "revolute joints about -y, one after the other along x from the origin");
    }
    if (!is_rod(body)) {
        return refuse(taker, taker->robot->line, joint->name,
                      "bodies with a centre of mass on their x axis and equal moments across it");
    }
    if (index > 0U) {
        parameters->link_length_m[index - 1U] = joint->origin.position_m[0];
    }
    parameters->link_mass_kg[index]      = body->mass_kg;
    parameters->link_com_m[index]        = body->com_m[0];
    parameters->link_twist_kgm2[index]   = body->inertia_kgm2.at[0][0];
    parameters->link_inertia_kgm2[index] = body->inertia_kgm2.at[1][1];
    parameters->home_rad[index]          = taker->robot->start[index];
    return STATUS_OK;
}

static status_t take_drives(const taker_t* const taker)
{
    const world_t* world = taker->world;
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        const robot_joint_t* joint = &taker->robot->model.joint[i];
        if ((i >= world->drive_count) || (world->drive[i].joint != i)) {
            return refuse(taker, taker->robot->line, joint->name,
                          "one Drive for each joint, in the order of the joints");
        }
        taker->parameters->drive[i] =
            plant_drive_of(&world->drive_type[world->drive[i].type], joint->lower, joint->upper);
    }
    return STATUS_OK;
}

static status_t take_robot(const taker_t* const taker)
{
    const world_t* world           = taker->world;
    const robot_mass_t* base       = &taker->robot->model.body[0];
    plant_parameters_t* parameters = taker->parameters;
    if (world->robot_count != 1U) {
        return refuse(taker, (world->robot_count > 1U) ? world->robot[1].line : 1U, "Robot", "one robot");
    }
    if (taker->robot->is_free || (taker->robot->model.joint_count != PLANT_JOINTS)) {
        return refuse(taker, taker->robot->line, taker->robot->name, "a fixed robot of two joints");
    }
    if ((world->gravity[0] != 0.0) || (world->gravity[1] != 0.0)) {
        return refuse(taker, 1U, "gravity", "gravity along z");
    }
    parameters->gravity_m_s2      = -world->gravity[2];
    parameters->base_mass_kg      = base->mass_kg;
    parameters->base_inertia_kgm2 = base->inertia_kgm2.at[0][0];
    status_t status               = STATUS_OK;
    for (unsigned i = 0U; (i < PLANT_JOINTS) && (status == STATUS_OK); i++) {
        status = take_link(taker, i);
    }
    return (status == STATUS_OK) ? take_drives(taker) : status;
}

// ---- What it touches ----

/// A frame of the last body on its x axis: the tip.
static bool is_tip(const taker_t* const taker, const unsigned frame)
{
    const robot_frame_t* tip = &taker->robot->model.frame[frame];
    return (tip->body == PLANT_JOINTS) && !is_turned(&tip->pose) && is_along_x(tip->pose.position_m);
}

static status_t take_tip(const taker_t* const taker, const world_contact_t* const contact)
{
    const robot_model_t* model = &taker->robot->model;
    const shape_t* ball        = NULL;
    unsigned count             = 0U;
    for (size_t i = 0U; i < model->shape_count; i++) {
        if (model->shape[i].frame == contact->frame) {
            ball = &model->shape[i];
            count++;
        }
    }
    const bool is_ball = (count == 1U) && (ball->kind == SHAPE_SPHERE) && is_along_x(ball->pose.position_m) &&
                         (ball->pose.position_m[0] == 0.0);
    if (!is_ball || !is_tip(taker, contact->frame)) {
        return refuse(taker, contact->line, contact->a, "a sphere at the end of the second body");
    }
    taker->parameters->tip_radius_m                     = ball->radius_m;
    taker->parameters->link_length_m[PLANT_JOINTS - 1U] = model->frame[contact->frame].pose.position_m[0];
    return STATUS_OK;
}

static status_t take_contour(const taker_t* const taker)
{
    const world_t* world           = taker->world;
    plant_parameters_t* parameters = taker->parameters;
    if ((world->contact_count != 1U) || (world->fixture_count != 1U)) {
        return refuse(taker, taker->robot->line, "Contact", "one contact with one fixture");
    }
    const world_contact_t* contact = &world->contact[0];
    const world_fixture_t* fixture = &world->fixture[contact->fixture];
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
    const double axis_z               = fixture->at[2] + bump->pose.position_m[2];
    parameters->contour_top_m         = fixture->at[2] + (at[2] + flat->size_m[2] / 2.0);
    parameters->contour_start_m       = fixture->at[0] + at[0] - flat->size_m[0] / 2.0;
    parameters->contour_end_m         = fixture->at[0] + at[0] + flat->size_m[0] / 2.0;
    parameters->contour_width_m       = flat->size_m[1];
    parameters->contour_depth_m       = flat->size_m[2];
    parameters->bump_x_m              = fixture->at[0] + bump->pose.position_m[0];
    parameters->bump_radius_m         = bump->radius_m;
    parameters->bump_height_m         = (axis_z + bump->radius_m) - parameters->contour_top_m;
    parameters->contour_stiffness_n_m = contact->stiffness;
    parameters->contour_damping_ns_m  = contact->damping;
    parameters->contour_friction      = contact->friction;
    return take_tip(taker, contact);
}

static status_t take_spring(const taker_t* const taker)
{
    plant_parameters_t* parameters = taker->parameters;
    if (taker->world->spring_count != 1U) {
        return refuse(taker, taker->robot->line, "CableSpring", "one cable spring");
    }
    const world_spring_t* spring = &taker->world->spring[0];
    if ((spring->frame != taker->world->contact[0].frame) || (spring->hook[1] != 0.0)) {
        return refuse(taker, spring->line, spring->on,
                      "a cable in the plane of the arm on the link of the contact");
    }
    parameters->hook_m[0]            = spring->hook[0];
    parameters->hook_m[1]            = spring->hook[2];
    parameters->hook_catch_m         = spring->catch;
    parameters->cable_m              = spring->length;
    parameters->spring_stiffness_n_m = spring->stiffness;
    parameters->spring_preload_n     = spring->preload;
    parameters->spring_preload_m     = spring->travel;
    parameters->spring_limit_n       = spring->limit;
    return STATUS_OK;
}

static status_t take_stick(const taker_t* const taker)
{
    plant_parameters_t* parameters   = taker->parameters;
    const world_joystick_t* joystick = &taker->world->joystick[0];
    if ((taker->world->joystick_count != 1U) || (joystick->axes != PLANT_AXES)) {
        return refuse(taker, taker->robot->line, "Joystick", "one joystick of two axes");
    }
    parameters->stick_inertia_kgm2     = joystick->inertia;
    parameters->stick_friction_nms_rad = joystick->friction;
    parameters->stick_range_rad        = joystick->range;
    parameters->stick_stop_nm_rad      = joystick->stop_stiffness;
    parameters->stick_stop_nms_rad     = joystick->stop_damping;
    return STATUS_OK;
}

status_t plant_parameters_take(const world_t* const world, plant_parameters_t* const out_parameters,
                               char error[DOCUMENT_ERROR_MAX])
{
    const taker_t taker = {
        .world = world, .robot = &world->robot[0], .parameters = out_parameters, .error = error};
    *out_parameters = (plant_parameters_t){.gravity_m_s2 = 0.0};
    status_t status = take_robot(&taker);
    status          = (status == STATUS_OK) ? take_contour(&taker) : status;
    status          = (status == STATUS_OK) ? take_spring(&taker) : status;
    return (status == STATUS_OK) ? take_stick(&taker) : status;
}

// ---- Parts ----

plant_drive_t plant_drive_of(const world_drive_type_t* const type, const double lower_rad,
                             const double upper_rad)
{
    return (plant_drive_t){.gear_ratio            = type->ratio,
                           .rotor_inertia_kgm2    = type->rotor_inertia,
                           .gear_stiffness_nm_rad = type->stiffness,
                           .gear_damping_nms_rad  = type->damping,
                           .coulomb_nm            = type->coulomb,
                           .stiction_nm           = type->stiction,
                           .stribeck_rad_s        = type->stribeck,
                           .viscous_nms_rad       = type->viscous,
                           .brake_torque_nm       = type->brake,
                           .lower_rad             = lower_rad,
                           .upper_rad             = upper_rad,
                           .stop_nm_rad           = type->stop_stiffness,
                           .stop_nms_rad          = type->stop_damping};
}

torque_sensor_parameters_t torque_sensor_of(const world_drive_type_t* const type)
{
    return (torque_sensor_parameters_t){.noise_rms_nm   = type->torque_noise,
                                        .offset_max_nm  = type->torque_offset,
                                        .drift_max_nm_s = type->torque_drift,
                                        .range_nm       = type->torque_range};
}

encoder_parameters_t encoder_of(const world_drive_type_t* const type)
{
    return (encoder_parameters_t){.counts_per_turn = type->encoder_counts, .gear_ratio = type->ratio};
}

encoder_parameters_t stick_encoder_of(const world_joystick_t* const joystick)
{
    return (encoder_parameters_t){.counts_per_turn = joystick->encoder_counts, .gear_ratio = 1.0};
}
