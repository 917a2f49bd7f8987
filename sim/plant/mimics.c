// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <string.h>

#define CORRECTION 0.2   // Share of a position error that a step corrects, like the ERP of joints in ODE.
#define PROBE 1e-3       // Increase of a force in a trial step, relative to the force plus 1 N or 1 Nm.
#define LEAST_PIVOT 1e-9 // A mimic with a smaller response [1/kg, 1/(kg m^2)] cannot move.

/// A body before a step.
typedef struct {
    dBodyID body;
    dVector3 position;
    dQuaternion rotation;
    dVector3 velocity;
    dVector3 rate;
    dVector3 force;
    dVector3 torque;
} body_state_t;

typedef struct {
    body_state_t body[WORLD_ROBOTS_MAX * ROBOT_BODIES_MAX];
    size_t count;
} before_t;

// ---- Trial steps ----

static void save_bodies(const plant_t* const plant, before_t* const out_before)
{
    out_before->count = 0U;
    for (size_t r = 0U; r < plant->world->robot_count; r++) {
        for (size_t i = 0U; i <= plant->world->robot[r].model.joint_count; i++) {
            const dBodyID body  = plant->robot[r].body[i];
            body_state_t* state = &out_before->body[out_before->count];
            if (body == NULL) {
                continue;
            }
            state->body = body;
            memcpy(state->position, dBodyGetPosition(body), 3U * sizeof(dReal));
            memcpy(state->rotation, dBodyGetQuaternion(body), 4U * sizeof(dReal));
            memcpy(state->velocity, dBodyGetLinearVel(body), 3U * sizeof(dReal));
            memcpy(state->rate, dBodyGetAngularVel(body), 3U * sizeof(dReal));
            memcpy(state->force, dBodyGetForce(body), 3U * sizeof(dReal));
            memcpy(state->torque, dBodyGetTorque(body), 3U * sizeof(dReal));
            out_before->count++;
        }
    }
}

static void restore_bodies(const before_t* const before)
{
    for (size_t i = 0U; i < before->count; i++) {
        const body_state_t* state = &before->body[i];
        dBodySetPosition(state->body, state->position[0], state->position[1], state->position[2]);
        dBodySetQuaternion(state->body, state->rotation);
        dBodySetLinearVel(state->body, state->velocity[0], state->velocity[1], state->velocity[2]);
        dBodySetAngularVel(state->body, state->rate[0], state->rate[1], state->rate[2]);
        dBodySetForce(state->body, state->force[0], state->force[1], state->force[2]);
        dBodySetTorque(state->body, state->torque[0], state->torque[1], state->torque[2]);
    }
}

static void add_force(const joint_t* const joint, const double force)
{
    if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
        dJointAddSliderForce(joint->ode, force);
    } else {
        dJointAddHingeTorque(joint->ode, force);
    }
}

/// Returns the distance of a mimic [m, rad] from the position that its leader determines.
static double error_of(const plant_t* const plant, const mimic_t* const mimic)
{
    const double* before = plant->truth.link_position_rad;
    return joint_position(&plant->joint[mimic->joint], before[mimic->joint]) -
           mimic->multiplier * joint_position(&plant->joint[mimic->leader], before[mimic->leader]) -
           mimic->offset;
}

/// Step all bodies with these forces between mimics and leaders. Returns the errors of the mimics.
static void step(plant_t* const plant, const double force[], const double dt_s, double out_error[])
{
    for (size_t i = 0U; i < plant->mimic_count; i++) {
        const mimic_t* mimic = &plant->mimic[i];
        add_force(&plant->joint[mimic->joint], force[i]);
        add_force(&plant->joint[mimic->leader], -mimic->multiplier * force[i]);
    }
    dWorldStep(plant->ode, dt_s);
    for (size_t i = 0U; i < plant->mimic_count; i++) {
        out_error[i] = error_of(plant, &plant->mimic[i]);
    }
}

// ---- Forces ----

/// Subtract multiples of row `from` so that column `from` of all other rows is zero.
static void eliminate(double row[MIMICS_MAX][MIMICS_MAX + 1U], const size_t count, const size_t from)
{
    for (size_t i = 0U; i < count; i++) {
        const double factor = (i != from) ? (row[i][from] / row[from][from]) : 0.0;
        for (size_t k = 0U; k <= MIMICS_MAX; k++) {
            row[i][k] -= factor * row[from][k];
        }
    }
}

/// Solve the equations whose right sides are in the last column. Except for friction of contacts the matrix
/// is positive semi-definite, so no exchange of rows is needed; the unknown of a row without a pivot is zero.
static void solve(double row[MIMICS_MAX][MIMICS_MAX + 1U], const size_t count, double out[])
{
    bool is_free[MIMICS_MAX];
    for (size_t i = 0U; i < count; i++) {
        is_free[i] = fabs(row[i][i]) > LEAST_PIVOT;
        if (is_free[i]) {
            eliminate(row, count, i);
        }
    }
    for (size_t i = 0U; i < count; i++) {
        out[i] = is_free[i] ? (row[i][MIMICS_MAX] / row[i][i]) : 0.0;
    }
}

void mimics_step(plant_t* const plant, const double dt_s)
{
    const size_t count = plant->mimic_count;
    before_t before;
    double force[MIMICS_MAX]                = {0.0};
    double start[MIMICS_MAX]                = {0.0};
    double error[MIMICS_MAX]                = {0.0};
    double changed[MIMICS_MAX]              = {0.0};
    double row[MIMICS_MAX][MIMICS_MAX + 1U] = {{0.0}};
    save_bodies(plant, &before);
    for (size_t i = 0U; i < count; i++) {
        force[i] = plant->mimic[i].force;
        start[i] = error_of(plant, &plant->mimic[i]);
    }
    // The first trial step uses the forces of the last step. Each further trial step increases one of them
    // slightly. Row i then contains the acceleration of mimic i for each unit of force, and in the last
    // column the change of acceleration that reduces its error.
    step(plant, force, dt_s, error);
    for (size_t k = 0U; k < count; k++) {
        const double more = PROBE * (1.0 + fabs(force[k]));
        restore_bodies(&before);
        force[k] += more;
        step(plant, force, dt_s, changed);
        force[k] = plant->mimic[k].force;
        for (size_t i = 0U; i < count; i++) {
            row[i][k] = (changed[i] - error[i]) / (more * dt_s * dt_s);
        }
        row[k][MIMICS_MAX] = -(error[k] - (1.0 - CORRECTION) * start[k]) / (dt_s * dt_s);
    }
    solve(row, count, changed);
    for (size_t i = 0U; i < count; i++) {
        plant->mimic[i].force += changed[i];
        force[i] = plant->mimic[i].force;
        plant->truth.joint_torque_nm[plant->mimic[i].joint] += force[i];
    }
    restore_bodies(&before);
    step(plant, force, dt_s, error);
}

// ---- Creation ----

status_t mimics_create(plant_t* const plant, char error[DOCUMENT_ERROR_MAX])
{
    const world_t* world = plant->world;
    for (unsigned r = 0U; r < world->robot_count; r++) {
        const robot_model_t* model = &world->robot[r].model;
        for (unsigned i = 0U; i < model->joint_count; i++) {
            const robot_joint_t* joint = &model->joint[i];
            if (!joint->is_mimic) {
                continue;
            }
            if (plant->mimic_count == MIMICS_MAX) {
                return document_refuse(world->path, world->robot[r].line, joint->name,
                                       "at most 8 joints of a world that mimic others", error);
            }
            plant->mimic[plant->mimic_count] = (mimic_t){.joint      = plant_joint(world, r, i),
                                                         .leader     = plant_joint(world, r, joint->leader),
                                                         .multiplier = joint->multiplier,
                                                         .offset     = joint->offset};
            plant->mimic_count++;
        }
    }
    return STATUS_OK;
}
