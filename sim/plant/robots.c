// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/parameters.h"
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <string.h>

/// Pose of a body at the start. Successive turns about the same axis are added to one angle, because in
/// floating point the sum of angles is more exact than the product of rotations.
typedef struct {
    pose_t pose;
    matrix_t still; ///< Rotation before the turn about `axis`.
    double axis[3]; ///< In the axes of `still`; zero: no turn.
    double angle_rad;
    bool is_still_constant; ///< No joint turns `still`.
} start_pose_t;

static const double nowhere[3] = {0.0, 0.0, 0.0};

// ---- Poses ----

static pose_t turned(const matrix_t* const still, const matrix_t* const turn)
{
    const pose_t outer = {.rotation = *still};
    const pose_t inner = {.rotation = *turn};
    return pose_compose(&outer, &inner);
}

/// Returns the rotation by an angle about an axis of length 1.
static matrix_t rotation_about(const double axis[3], const double angle_rad)
{
    const double c           = cos(angle_rad);
    const double s           = sin(angle_rad);
    const double cross[3][3] = {{0.0, -axis[2], axis[1]}, {axis[2], 0.0, -axis[0]}, {-axis[1], axis[0], 0.0}};
    matrix_t turn;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            turn.at[i][k] = ((i == k) ? c : 0.0) + (1.0 - c) * axis[i] * axis[k] + s * cross[i][k];
        }
    }
    return turn;
}

static bool is_turned(const matrix_t* const rotation)
{
    bool is_turned = false;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            is_turned = is_turned || (rotation->at[i][k] != ((i == k) ? 1.0 : 0.0));
        }
    }
    return is_turned;
}

static bool is_same(const double a[3], const double b[3])
{
    return (a[0] == b[0]) && (a[1] == b[1]) && (a[2] == b[2]);
}

/// Express a direction, given in a frame, in the axes of the world.
static void direction(const matrix_t* const rotation, const double in_frame[3], double out[3])
{
    const pose_t pose = {.rotation = *rotation};
    pose_apply(&pose, in_frame, out);
}

/// Pose of the body that a joint moves, at the start position of the joint.
static start_pose_t start_pose_of(const start_pose_t* const parent, const robot_joint_t* const joint,
                                  const double position)
{
    const pose_t before     = pose_compose(&parent->pose, &joint->origin);
    start_pose_t start_pose = {.pose  = before,
                               .still = before.rotation,
                               .is_still_constant =
                                   parent->is_still_constant && is_same(parent->axis, nowhere)};
    if (joint->kind == ROBOT_JOINT_PRISMATIC) {
        const double along[3] = {joint->axis[0] * position, joint->axis[1] * position,
                                 joint->axis[2] * position};
        pose_apply(&before, along, start_pose.pose.position_m);
        return start_pose;
    }
    start_pose.angle_rad = position;
    memcpy(start_pose.axis, joint->axis, sizeof start_pose.axis);
    if (!is_turned(&joint->origin.rotation) && is_same(parent->axis, joint->axis)) {
        start_pose.still             = parent->still;
        start_pose.is_still_constant = parent->is_still_constant;
        start_pose.angle_rad += parent->angle_rad;
    }
    const matrix_t turn      = rotation_about(start_pose.axis, start_pose.angle_rad);
    start_pose.pose.rotation = turned(&start_pose.still, &turn).rotation;
    return start_pose;
}

// ---- Bodies ----

static void set_rotation(const dBodyID body, const start_pose_t* const start_pose)
{
    dMatrix3 half; // The rotation as ODE computes it: from sine and cosine of half the angle.
    dMatrix3 rotation = {0.0};
    matrix_t turn;
    dRFromAxisAndAngle(half, start_pose->axis[0], start_pose->axis[1], start_pose->axis[2],
                       start_pose->angle_rad);
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            turn.at[i][k] = half[(4U * i) + k];
        }
    }
    const matrix_t whole = turned(&start_pose->still, &turn).rotation;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            rotation[(4U * i) + k] = whole.at[i][k];
        }
    }
    dBodySetRotation(body, rotation);
}

/// Create a body. Its frame in ODE has the origin in the centre of mass and the axes of the model.
static dBodyID create_body(const plant_t* const plant, const robot_mass_t* const mass,
                           const start_pose_t* const start_pose)
{
    const matrix_t* inertia = &mass->inertia_kgm2;
    const dBodyID body      = dBodyCreate(plant->ode);
    double centre[3];
    dMass all;
    dMassSetParameters(&all, mass->mass_kg, 0.0, 0.0, 0.0, inertia->at[0][0], inertia->at[1][1],
                       inertia->at[2][2], inertia->at[0][1], inertia->at[0][2], inertia->at[1][2]);
    dBodySetMass(body, &all);
    set_rotation(body, start_pose);
    pose_apply(&start_pose->pose, mass->com_m, centre);
    dBodySetPosition(body, centre[0], centre[1], centre[2]);
    dBodySetGyroscopicMode(body, 1);
    return body;
}

// ---- Joints ----

/// Set the limits of a joint without a drive as stops in ODE, whose joint positions are relative to the
/// start.
static status_t limit(const plant_t* const plant, const world_robot_t* const robot,
                      const joint_t* const joint, char error[DOCUMENT_ERROR_MAX])
{
    const robot_joint_t* model = joint->model;
    const double lower         = model->lower - joint->start;
    const double upper         = model->upper - joint->start;
    if ((joint->drive_of != NULL) || (model->kind == ROBOT_JOINT_CONTINUOUS)) {
        return STATUS_OK;
    }
    if (model->kind == ROBOT_JOINT_PRISMATIC) {
        dJointSetSliderParam(joint->ode, dParamLoStop, lower);
        dJointSetSliderParam(joint->ode, dParamHiStop, upper);
        return STATUS_OK;
    }
    if ((lower < -M_PI) || (upper > M_PI)) {
        return document_refuse(plant->world->path, robot->line, model->name,
                               "a Drive, or limits within half a turn of the start", error);
    }
    dJointSetHingeParam(joint->ode, dParamLoStop, lower);
    dJointSetHingeParam(joint->ode, dParamHiStop, upper);
    return STATUS_OK;
}

static void create_joint(const plant_t* const plant, joint_t* const joint, const dBodyID child,
                         const start_pose_t* const start_pose)
{
    const double* at = start_pose->pose.position_m;
    direction(&start_pose->still, joint->model->axis, joint->axis);
    if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
        joint->ode = dJointCreateSlider(plant->ode, NULL);
        dJointAttach(joint->ode, child, joint->parent);
        dJointSetSliderAxis(joint->ode, joint->axis[0], joint->axis[1], joint->axis[2]);
        return;
    }
    joint->ode = dJointCreateHinge(plant->ode, NULL);
    dJointAttach(joint->ode, child, joint->parent);
    dJointSetHingeAnchor(joint->ode, at[0], at[1], at[2]);
    dJointSetHingeAxis(joint->ode, joint->axis[0], joint->axis[1], joint->axis[2]);
}

static const world_drive_t* drive_of(const world_t* const world, const unsigned robot, const unsigned joint)
{
    for (size_t i = 0U; i < world->drive_count; i++) {
        if ((world->drive[i].robot == robot) && (world->drive[i].joint == joint)) {
            return &world->drive[i];
        }
    }
    return NULL;
}

static void prepare_joint(plant_t* const plant, const unsigned robot, const unsigned index)
{
    const world_t* world                                        = plant->world;
    const robot_model_t* model                                  = &world->robot[robot].model;
    const unsigned parent                                       = model->joint[index].parent;
    robot_t* own                                                = &plant->robot[robot];
    joint_t* joint                                              = &plant->joint[own->first_joint + index];
    joint->model                                                = &model->joint[index];
    joint->drive_of                                             = drive_of(world, robot, index);
    joint->start                                                = world->robot[robot].start[index];
    plant->truth.motor[own->first_joint + index].velocity_rad_s = world->robot[robot].rate[index];
    joint->parent                                               = own->body[parent];
    own->moved_by[index + 1U]                                   = own->moved_by[parent] | (1U << index);
    if (joint->drive_of != NULL) {
        const bool is_bounded = joint->model->kind != ROBOT_JOINT_CONTINUOUS;
        joint->drive          = plant_drive_of(&world->drive_type[joint->drive_of->type],
                                      is_bounded ? joint->model->lower : -(double)INFINITY,
                                      is_bounded ? joint->model->upper : (double)INFINITY);
        plant_drive_vary(&joint->drive, &joint->drive_of->difference);
    }
}

// ---- Robots ----

static void set_in_motion(const robot_start_t* const start, const dBodyID body)
{
    const dReal* at     = dBodyGetPosition(body);
    const double* rate  = start->rate_rad_s;
    const double* speed = start->velocity_m_s;
    const double r[3]   = {at[0] - start->pose.position_m[0], at[1] - start->pose.position_m[1],
                           at[2] - start->pose.position_m[2]};
    dBodySetLinearVel(body, speed[0] + rate[1] * r[2] - rate[2] * r[1],
                      speed[1] + rate[2] * r[0] - rate[0] * r[2], speed[2] + rate[0] * r[1] - rate[1] * r[0]);
    dBodySetAngularVel(body, rate[0], rate[1], rate[2]);
    dBodySetGyroscopicMode(body, 0); // robots_add_gyroscopic_torques adds a more exact torque instead.
}

/// Add the motion that the rates of the joints give to the bodies that they carry.
static void set_joint_rates(const plant_t* const plant, const unsigned index,
                            const start_pose_t start_pose[ROBOT_BODIES_MAX])
{
    const world_robot_t* robot = &plant->world->robot[index];
    const robot_t* own         = &plant->robot[index];
    for (unsigned i = 0U; i < robot->model.joint_count; i++) {
        const joint_t* joint = &plant->joint[own->first_joint + i];
        const double* anchor = start_pose[i + 1U].pose.position_m;
        const double turn[3] = {joint->axis[0] * robot->rate[i], joint->axis[1] * robot->rate[i],
                                joint->axis[2] * robot->rate[i]};
        for (unsigned k = i + 1U; (robot->rate[i] != 0.0) && (k <= robot->model.joint_count); k++) {
            const dBodyID body = own->body[k];
            const dReal* v     = dBodyGetLinearVel(body);
            const dReal* w     = dBodyGetAngularVel(body);
            const dReal* at    = dBodyGetPosition(body);
            const double r[3]  = {at[0] - anchor[0], at[1] - anchor[1], at[2] - anchor[2]};
            if ((own->moved_by[k] & (1U << i)) == 0U) {
                continue;
            }
            if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
                dBodySetLinearVel(body, v[0] + turn[0], v[1] + turn[1], v[2] + turn[2]);
                continue;
            }
            dBodySetLinearVel(body, v[0] + turn[1] * r[2] - turn[2] * r[1],
                              v[1] + turn[2] * r[0] - turn[0] * r[2], v[2] + turn[0] * r[1] - turn[1] * r[0]);
            dBodySetAngularVel(body, w[0] + turn[0], w[1] + turn[1], w[2] + turn[2]);
        }
    }
}

static status_t create_robot(plant_t* const plant, const unsigned index, char error[DOCUMENT_ERROR_MAX])
{
    const world_robot_t* robot = &plant->world->robot[index];
    const robot_model_t* model = &robot->model;
    robot_t* own               = &plant->robot[index];
    robot_start_t start;
    robot_start(plant, index, &start);
    start_pose_t start_pose[ROBOT_BODIES_MAX] = {
        {.pose = start.pose, .still = start.pose.rotation, .is_still_constant = !robot->is_free}};
    status_t status = STATUS_OK;

    own->base    = start.pose;
    own->body[0] = robot->is_free ? create_body(plant, &model->body[0], &start_pose[0]) : NULL;
    for (unsigned i = 0U; i < model->joint_count; i++) {
        start_pose[i + 1U] =
            start_pose_of(&start_pose[model->joint[i].parent], &model->joint[i], robot->start[i]);
        own->body[i + 1U] = create_body(plant, &model->body[i + 1U], &start_pose[i + 1U]);
    }
    for (unsigned i = 0U; (i < model->joint_count) && (status == STATUS_OK); i++) {
        joint_t* joint = &plant->joint[own->first_joint + i];
        prepare_joint(plant, index, i);
        create_joint(plant, joint, own->body[i + 1U], &start_pose[i + 1U]);
        joint->is_axis_constant = start_pose[i + 1U].is_still_constant;
        status                  = limit(plant, robot, joint, error);
    }
    for (unsigned i = 0U; robot->is_free && (i <= model->joint_count); i++) {
        set_in_motion(&start, own->body[i]);
    }
    set_joint_rates(plant, index, start_pose);
    return status;
}

unsigned plant_joint(const world_t* const world, const unsigned robot, const unsigned joint)
{
    unsigned index = joint;
    for (unsigned i = 0U; i < robot; i++) {
        index += (unsigned)world->robot[i].model.joint_count;
    }
    return index;
}

status_t robots_create(plant_t* const plant, char error[DOCUMENT_ERROR_MAX])
{
    const world_t* world = plant->world;
    plant_truth_t* truth = &plant->truth;
    status_t status      = STATUS_OK;
    for (unsigned i = 0U; (i < world->robot_count) && (status == STATUS_OK); i++) {
        plant->robot[i].first_joint = plant_joint(world, i, 0U);
        status                      = create_robot(plant, i, error);
    }
    truth->joint_count = plant_joint(world, (unsigned)world->robot_count, 0U);
    for (unsigned i = 0U; (i < truth->joint_count) && (status == STATUS_OK); i++) {
        truth->link_position_rad[i]  = plant->joint[i].start;
        truth->motor[i].position_rad = plant->joint[i].start;
    }
    if (status == STATUS_OK) {
        robots_forget_rates(plant);
    }
    return status;
}

// ---- State ----

/// Speed of a prismatic joint. The speed that ODE computes ignores the velocity of the body due to a turning
/// parent.
static double slider_speed(const joint_t* const joint)
{
    const dBodyID body = dJointGetBody(joint->ode, 0);
    const dReal* v     = dBodyGetLinearVel(body);
    dVector3 axis;
    dVector3 carried = {0.0};
    dJointGetSliderAxis(joint->ode, axis);
    if (joint->parent != NULL) {
        const dReal* at = dBodyGetPosition(body);
        dBodyGetPointVel(joint->parent, at[0], at[1], at[2], carried);
    }
    return axis[0] * (v[0] - carried[0]) + axis[1] * (v[1] - carried[1]) + axis[2] * (v[2] - carried[2]);
}

/// Returns the position of a hinge that was at `before` when ODE computed joint->angle_rad, and is now at
/// `angle_rad` of ODE, which is limited to half a turn.
static double unwrapped(const joint_t* const joint, const double angle_rad, const double before)
{
    const double change = angle_rad - joint->angle_rad;
    const double turn   = (change > M_PI) ? -2.0 * M_PI : ((change < -M_PI) ? 2.0 * M_PI : 0.0);
    return before + (change + turn);
}

double joint_position(const joint_t* const joint, const double before)
{
    if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
        return joint->start + dJointGetSliderPosition(joint->ode);
    }
    return unwrapped(joint, dJointGetHingeAngle(joint->ode), before);
}

/// Read position and speed of a joint; angles are not limited to half a turn.
static void read_joint(joint_t* const joint, double* const position, double* const velocity)
{
    if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
        *position = joint_position(joint, *position);
        *velocity = slider_speed(joint);
        return;
    }
    const double angle_rad = dJointGetHingeAngle(joint->ode);
    *position              = unwrapped(joint, angle_rad, *position);
    *velocity              = dJointGetHingeAngleRate(joint->ode);
    joint->angle_rad       = angle_rad;
}

static void read_base(const plant_t* const plant, const unsigned robot, plant_base_t* const out_base)
{
    const dBodyID body = plant->robot[robot].body[0];
    dVector3 speed;
    robot_point(plant, robot, 0U, nowhere, out_base->position_m);
    memcpy(out_base->rotation, dBodyGetQuaternion(body), sizeof out_base->rotation);
    memcpy(out_base->rate_rad_s, dBodyGetAngularVel(body), sizeof out_base->rate_rad_s);
    dBodyGetPointVel(body, out_base->position_m[0], out_base->position_m[1], out_base->position_m[2], speed);
    memcpy(out_base->velocity_m_s, speed, sizeof out_base->velocity_m_s);
}

void robots_read(plant_t* const plant)
{
    plant_truth_t* truth = &plant->truth;
    truth->base_count    = 0U;
    for (unsigned i = 0U; i < plant->world->robot_count; i++) {
        if (plant->world->robot[i].is_free) {
            read_base(plant, i, &truth->base[truth->base_count]);
            truth->base_count++;
        }
    }
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        joint_t* joint = &plant->joint[i];
        read_joint(joint, &truth->link_position_rad[i], &truth->link_velocity_rad_s[i]);
        if (joint->drive_of == NULL) {
            truth->motor[i] = (plant_rotor_t){truth->link_position_rad[i], truth->link_velocity_rad_s[i]};
        }
    }
}

/// Read the present axis of a joint, and a point on it.
static void read_axis(joint_t* const joint)
{
    dVector3 found;
    const bool is_slider = joint->model->kind == ROBOT_JOINT_PRISMATIC;
    if (!joint->is_axis_constant) {
        if (is_slider) {
            dJointGetSliderAxis(joint->ode, found);
        } else {
            dJointGetHingeAxis(joint->ode, found);
        }
        memcpy(joint->axis, found, sizeof joint->axis);
    }
    if (is_slider) {
        return;
    }
    // For a joint fixed to the world, the second anchor is the exact point in the world.
    if (joint->parent == NULL) {
        dJointGetHingeAnchor2(joint->ode, found);
    } else {
        dJointGetHingeAnchor(joint->ode, found);
    }
    memcpy(joint->anchor_m, found, sizeof joint->anchor_m);
}

void robots_read_axes(plant_t* const plant)
{
    for (unsigned i = 0U; i < plant->truth.joint_count; i++) {
        read_axis(&plant->joint[i]);
    }
}

void robot_point(const plant_t* const plant, const unsigned robot, const unsigned body,
                 const double in_body_m[3], double out_m[3])
{
    const robot_t* own    = &plant->robot[robot];
    const double* centre  = plant->world->robot[robot].model.body[body].com_m;
    const double point[3] = {in_body_m[0] - centre[0], in_body_m[1] - centre[1], in_body_m[2] - centre[2]};
    dVector3 found;
    if (own->body[body] == NULL) {
        pose_apply(&own->base, in_body_m, out_m);
        return;
    }
    dBodyGetRelPointPos(own->body[body], point[0], point[1], point[2], found);
    memcpy(out_m, found, 3U * sizeof(double));
}

void robots_add_load(plant_t* const plant, const load_t* const load)
{
    const robot_t* own  = &plant->robot[load->robot];
    const double* force = load->force_n;
    const size_t count  = plant->world->robot[load->robot].model.joint_count;
    for (unsigned i = 0U; i < count; i++) {
        const joint_t* joint = &plant->joint[own->first_joint + i];
        const double* axis   = joint->axis;
        if ((own->moved_by[load->body] & (1U << i)) == 0U) {
            continue;
        }
        const double r[3] = {load->point_m[0] - joint->anchor_m[0], load->point_m[1] - joint->anchor_m[1],
                             load->point_m[2] - joint->anchor_m[2]};
        const double turning[3] = {r[1] * force[2] - r[2] * force[1], r[2] * force[0] - r[0] * force[2],
                                   r[0] * force[1] - r[1] * force[0]};
        const double* acts      = (joint->model->kind == ROBOT_JOINT_PRISMATIC) ? force : turning;
        plant->truth.external_torque_nm[own->first_joint + i] +=
            axis[0] * acts[0] + axis[1] * acts[1] + axis[2] * acts[2];
    }
}
