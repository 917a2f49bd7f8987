// SPDX-License-Identifier: Apache-2.0
#include "sim/world/robot_model.h"

#include "sim/world/urdf.h"

#include <math.h>
#include <string.h>

typedef struct {
    const char* path;
    char* error;
    urdf_t urdf;
    robot_model_t* model;
} builder_t;

// ---- Poses ----

static matrix_t multiply(const matrix_t* const a, const matrix_t* const b)
{
    matrix_t product;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            product.at[i][k] =
                a->at[i][0] * b->at[0][k] + a->at[i][1] * b->at[1][k] + a->at[i][2] * b->at[2][k];
        }
    }
    return product;
}

void pose_apply(const pose_t* const pose, const double point[3], double out[3])
{
    for (unsigned i = 0U; i < 3U; i++) {
        const double* row = pose->rotation.at[i];
        out[i]            = pose->position_m[i] + (row[0] * point[0] + row[1] * point[1] + row[2] * point[2]);
    }
}

pose_t pose_of(const double position_m[3], const double rpy_rad[3])
{
    const double cr = cos(rpy_rad[0]);
    const double sr = sin(rpy_rad[0]);
    const double cp = cos(rpy_rad[1]);
    const double sp = sin(rpy_rad[1]);
    const double cy = cos(rpy_rad[2]);
    const double sy = sin(rpy_rad[2]);
    return (pose_t){.rotation   = {{{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                                    {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                                    {-sp, cp * sr, cp * cr}}},
                    .position_m = {position_m[0], position_m[1], position_m[2]}};
}

pose_t pose_compose(const pose_t* const outer, const pose_t* const inner)
{
    pose_t pose = {.rotation = multiply(&outer->rotation, &inner->rotation)};
    pose_apply(outer, inner->position_m, pose.position_m);
    return pose;
}

// ---- Masses ----

/// Rotate an inertia tensor into the axes in which `rotation` is given: R I R^T.
static matrix_t turn_inertia(const matrix_t* const rotation, const matrix_t* const inertia)
{
    const matrix_t half = multiply(rotation, inertia);
    matrix_t transposed;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            transposed.at[i][k] = rotation->at[k][i];
        }
    }
    return multiply(&half, &transposed);
}

static void add_point_mass(const double mass_kg, const double offset[3], matrix_t* const inertia)
{
    const double square = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            inertia->at[i][k] += mass_kg * (((i == k) ? square : 0.0) - offset[i] * offset[k]);
        }
    }
}

void robot_mass_add(robot_mass_t* const body, const pose_t* const pose, const robot_mass_t* const more)
{
    robot_mass_t moved = *more;
    if (more->mass_kg == 0.0) {
        return;
    }
    pose_apply(pose, more->com_m, moved.com_m);
    moved.inertia_kgm2 = turn_inertia(&pose->rotation, &more->inertia_kgm2);
    if (body->mass_kg == 0.0) {
        *body = moved;
        return;
    }
    const robot_mass_t before = *body;
    body->mass_kg             = before.mass_kg + moved.mass_kg;
    for (unsigned i = 0U; i < 3U; i++) {
        body->com_m[i] = (before.mass_kg * before.com_m[i] + moved.mass_kg * moved.com_m[i]) / body->mass_kg;
        for (unsigned k = 0U; k < 3U; k++) {
            body->inertia_kgm2.at[i][k] += moved.inertia_kgm2.at[i][k];
        }
    }
    double from_before[3];
    double from_moved[3];
    for (unsigned i = 0U; i < 3U; i++) {
        from_before[i] = before.com_m[i] - body->com_m[i];
        from_moved[i]  = moved.com_m[i] - body->com_m[i];
    }
    add_point_mass(before.mass_kg, from_before, &body->inertia_kgm2);
    add_point_mass(moved.mass_kg, from_moved, &body->inertia_kgm2);
}

// ---- Assembly ----

static status_t refuse_joint(const builder_t* const builder, const urdf_joint_t* const joint,
                             const char* const found, const char* const expected)
{
    return document_refuse(builder->path, joint->line, found, expected, builder->error);
}

static size_t find_link(const builder_t* const builder, const char* const name)
{
    size_t index = 0U;
    while ((index < builder->urdf.link_count) && (strcmp(builder->urdf.link[index].name, name) != 0)) {
        index++;
    }
    return index;
}

static status_t check_motion(const builder_t* const builder, urdf_joint_t* const joint)
{
    const double length   = sqrt(joint->axis[0] * joint->axis[0] + joint->axis[1] * joint->axis[1] +
                                 joint->axis[2] * joint->axis[2]);
    const bool is_bounded = (joint->kind == ROBOT_JOINT_REVOLUTE) || (joint->kind == ROBOT_JOINT_PRISMATIC);
    if (joint->kind == ROBOT_JOINT_FIXED) {
        return STATUS_OK;
    }
    if (length < 1e-3) {
        return refuse_joint(builder, joint, joint->name, "a joint whose axis has a direction");
    }
    for (unsigned i = 0U; i < 3U; i++) {
        joint->axis[i] /= length;
    }
    if (is_bounded && (!joint->has_limit || !(joint->lower < joint->upper))) {
        return refuse_joint(builder, joint, joint->name, "a limit with lower < upper");
    }
    return STATUS_OK;
}

/// Find the two links that a joint connects, and check the joint.
static status_t connect(builder_t* const builder, const unsigned index)
{
    urdf_joint_t* joint = &builder->urdf.joint[index];
    const size_t parent = find_link(builder, joint->parent_name);
    const size_t child  = find_link(builder, joint->child_name);
    if (parent == builder->urdf.link_count) {
        return refuse_joint(builder, joint, joint->parent_name, "a parent that is a link of the file");
    }
    if (child == builder->urdf.link_count) {
        return refuse_joint(builder, joint, joint->child_name, "a child that is a link of the file");
    }
    if (builder->urdf.link[child].joint != URDF_ROOT) {
        return refuse_joint(builder, joint, joint->child_name,
                            "a child that no earlier joint has: robots are trees");
    }
    joint->parent                   = (unsigned)parent;
    joint->child                    = (unsigned)child;
    builder->urdf.link[child].joint = index;
    return check_motion(builder, joint);
}

/// Assign the child link of a joint to the body of its parent (fixed joint) or to a new body.
static status_t place_link(builder_t* const builder, const urdf_joint_t* const joint)
{
    robot_model_t* model      = builder->model;
    const robot_frame_t* from = &model->frame[joint->parent];
    const pose_t origin       = pose_of(joint->origin.position_m, joint->origin.rpy_rad);
    robot_frame_t* to         = &model->frame[joint->child];
    to->body                  = from->body;
    to->pose                  = pose_compose(&from->pose, &origin);
    if (joint->kind != ROBOT_JOINT_FIXED) {
        if (model->joint_count == ROBOT_JOINTS_MAX) {
            return refuse_joint(builder, joint, joint->name, "at most 12 joints that move");
        }
        robot_joint_t* moving = &model->joint[model->joint_count];
        *moving               = (robot_joint_t){.line   = joint->line,
                                                .kind   = joint->kind,
                                                .parent = from->body,
                                                .origin = to->pose,
                                                .axis   = {joint->axis[0], joint->axis[1], joint->axis[2]},
                                                .lower  = joint->lower,
                                                .upper  = joint->upper};
        memcpy(moving->name, joint->name, sizeof moving->name);
        model->joint_count++;
        to->body = (unsigned)model->joint_count;
        to->pose = pose_of((const double[3]){0.0}, (const double[3]){0.0});
    }
    builder->urdf.link[joint->child].is_placed = true;
    robot_mass_add(&model->body[to->body], &to->pose, &builder->urdf.link[joint->child].mass);
    return STATUS_OK;
}

/// Assign all links to bodies: parents before children, otherwise in the order of the file.
static status_t place_links(builder_t* const builder)
{
    status_t status = STATUS_OK;
    for (size_t pass = 0U; pass < builder->urdf.joint_count; pass++) {
        for (size_t i = 0U; (i < builder->urdf.joint_count) && (status == STATUS_OK); i++) {
            const urdf_joint_t* joint = &builder->urdf.joint[i];
            if (builder->urdf.link[joint->parent].is_placed && !builder->urdf.link[joint->child].is_placed) {
                status = place_link(builder, joint);
            }
        }
    }
    for (size_t i = 0U; (i < builder->urdf.link_count) && (status == STATUS_OK); i++) {
        const urdf_link_t* link = &builder->urdf.link[i];
        if (!link->is_placed) {
            status = document_refuse(builder->path, link->line, link->name,
                                     "a link that joints connect with the root", builder->error);
        }
    }
    return status;
}

static status_t place_root(builder_t* const builder)
{
    robot_model_t* model = builder->model;
    size_t roots         = 0U;
    model->frame_count   = builder->urdf.link_count;
    for (size_t i = 0U; i < builder->urdf.link_count; i++) {
        urdf_link_t* link = &builder->urdf.link[i];
        memcpy(model->frame[i].name, link->name, sizeof link->name);
        if (link->joint == URDF_ROOT) {
            if (roots != 0U) {
                return document_refuse(builder->path, link->line, link->name,
                                       "one root: make this link the child of a joint", builder->error);
            }
            roots++;
            link->is_placed      = true;
            model->frame[i].pose = pose_of((const double[3]){0.0}, (const double[3]){0.0});
            model->body[0]       = link->mass;
        }
    }
    return (roots == 1U) ? STATUS_OK
                         : document_refuse(builder->path, 1U, "no root", "a link that is no joint's child",
                                           builder->error);
}

/// Find the leader of a mimic, and check it.
static status_t set_leader(const builder_t* const builder, const urdf_joint_t* const joint)
{
    robot_model_t* model  = builder->model;
    const size_t follower = robot_model_joint(model, joint->name);
    const size_t leader   = robot_model_joint(model, joint->leader_name);
    if (follower == model->joint_count) {
        return document_refuse(builder->path, joint->leader_line, "mimic", "no mimic in a fixed joint",
                               builder->error);
    }
    if (leader == model->joint_count) {
        return document_refuse(builder->path, joint->leader_line, joint->leader_name,
                               "a joint of the file that moves", builder->error);
    }
    for (size_t i = 0U; i < builder->urdf.joint_count; i++) {
        const urdf_joint_t* other = &builder->urdf.joint[i];
        if ((other->leader_name[0] != '\0') && (strcmp(other->name, joint->leader_name) == 0)) {
            return document_refuse(builder->path, joint->leader_line, joint->leader_name,
                                   "a joint that is not itself a mimic", builder->error);
        }
    }
    robot_joint_t* moving = &model->joint[follower];
    moving->is_mimic      = true;
    moving->leader        = (unsigned)leader;
    moving->multiplier    = joint->multiplier;
    moving->offset        = joint->offset;
    return STATUS_OK;
}

static status_t assemble(builder_t* const builder)
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < builder->urdf.joint_count) && (status == STATUS_OK); i++) {
        status = connect(builder, i);
    }
    status = (status == STATUS_OK) ? place_root(builder) : status;
    status = (status == STATUS_OK) ? place_links(builder) : status;
    for (size_t i = 0U; (i < builder->urdf.joint_count) && (status == STATUS_OK); i++) {
        const urdf_joint_t* joint = &builder->urdf.joint[i];
        status                    = (joint->leader_name[0] != '\0') ? set_leader(builder, joint) : STATUS_OK;
    }
    for (size_t i = 0U; (i < builder->model->joint_count) && (status == STATUS_OK); i++) {
        const robot_joint_t* joint = &builder->model->joint[i];
        if (builder->model->body[i + 1U].mass_kg == 0.0) {
            status = document_refuse(builder->path, joint->line, joint->name, "a joint that moves a mass",
                                     builder->error);
        }
    }
    return status;
}

status_t robot_model_read(const char* const path, robot_model_t* const out_model,
                          char error[DOCUMENT_ERROR_MAX])
{
    builder_t builder = {.path = path, .error = error, .model = out_model};
    memset(out_model, 0, sizeof *out_model);
    const status_t status = urdf_read(path, &builder.urdf, error);
    if (status != STATUS_OK) {
        return status;
    }
    out_model->shape_count = builder.urdf.shape_count;
    memcpy(out_model->shape, builder.urdf.shape, sizeof out_model->shape);
    return assemble(&builder);
}

size_t robot_model_joint(const robot_model_t* const model, const char* const name)
{
    size_t index = 0U;
    while ((index < model->joint_count) && (strcmp(model->joint[index].name, name) != 0)) {
        index++;
    }
    return index;
}

size_t robot_model_frame(const robot_model_t* const model, const char* const name)
{
    size_t index = 0U;
    while ((index < model->frame_count) && (strcmp(model->frame[index].name, name) != 0)) {
        index++;
    }
    return index;
}
