// SPDX-License-Identifier: Apache-2.0
#include "test/unit/sim/plant/plant_state.h"

#include "sim/plant/plant_internal.h"

#include <string.h>

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void add_body_momentum(const dBodyID body, double linear[3], double angular[3])
{
    dMass mass;
    dBodyGetMass(body, &mass);
    const dReal* velocity = dBodyGetLinearVel(body);
    const dReal* rate     = dBodyGetAngularVel(body);
    double momentum[3];
    double orbital[3];
    for (unsigned i = 0U; i < 3U; i++) {
        momentum[i] = mass.mass * velocity[i];
        linear[i] += momentum[i];
    }
    cross(dBodyGetPosition(body), momentum, orbital);

    dVector3 local;
    dVector3 spin;
    double own[3];
    dBodyVectorFromWorld(body, rate[0], rate[1], rate[2], local);
    for (unsigned i = 0U; i < 3U; i++) {
        own[i] =
            mass.I[4U * i] * local[0] + mass.I[(4U * i) + 1U] * local[1] + mass.I[(4U * i) + 2U] * local[2];
    }
    dBodyVectorToWorld(body, own[0], own[1], own[2], spin);
    for (unsigned i = 0U; i < 3U; i++) {
        angular[i] += orbital[i] + spin[i];
    }
}

static void add_rotor_momentum(const plant_t* const plant, const unsigned index, double angular[3])
{
    const joint_t* joint = &plant->joint[index];
    if ((joint->drive_of == NULL) || (joint->model->kind == ROBOT_JOINT_PRISMATIC)) {
        return;
    }
    // `drive` and the truth give inertia and velocity on the joint side of the gear. The rotor itself has
    // the inertia J / N^2 and turns N times as fast, so its angular momentum is J / N times the velocity.
    const double spin =
        joint->drive.rotor_inertia_kgm2 / joint->drive.gear_ratio * plant->truth.motor[index].velocity_rad_s;
    dVector3 axis;
    dJointGetHingeAxis(joint->ode, axis);
    for (unsigned k = 0U; k < 3U; k++) {
        angular[k] += spin * axis[k];
    }
}

void plant_momentum(const plant_t* const plant, double out_linear[3], double out_angular[3])
{
    memset(out_linear, 0, 3U * sizeof(double));
    memset(out_angular, 0, 3U * sizeof(double));
    for (unsigned r = 0U; r < plant->world->robot_count; r++) {
        for (unsigned i = 0U; i < ROBOT_BODIES_MAX; i++) {
            if (plant->robot[r].body[i] != NULL) {
                add_body_momentum(plant->robot[r].body[i], out_linear, out_angular);
            }
        }
    }
    for (unsigned i = 0U; i < plant->truth.joint_count; i++) {
        add_rotor_momentum(plant, i, out_angular);
    }
    for (unsigned i = 0U; i < plant->world->wheel_count; i++) {
        double axis[3];
        wheel_axis(plant, i, axis);
        for (unsigned k = 0U; k < 3U; k++) {
            out_angular[k] += plant->truth.wheel[i].momentum_nms * axis[k];
        }
    }
}

/// FNV-1a over the octets of `count` numbers.
static uint64_t hash_numbers(uint64_t hash, const double* const number, const unsigned count)
{
    unsigned char octet[sizeof(double)];
    for (unsigned i = 0U; i < count; i++) {
        memcpy(octet, &number[i], sizeof octet);
        for (unsigned k = 0U; k < sizeof octet; k++) {
            hash = (hash ^ octet[k]) * 0x100000001B3U;
        }
    }
    return hash;
}

static uint64_t hash_body(uint64_t hash, const dBodyID body)
{
    hash = hash_numbers(hash, dBodyGetPosition(body), 3U);
    hash = hash_numbers(hash, dBodyGetQuaternion(body), 4U);
    hash = hash_numbers(hash, dBodyGetLinearVel(body), 3U);
    return hash_numbers(hash, dBodyGetAngularVel(body), 3U);
}

uint64_t plant_hash(const plant_t* const plant)
{
    const plant_truth_t* truth = &plant->truth;
    uint64_t hash              = 0xCBF29CE484222325U;

    for (unsigned r = 0U; r < plant->world->robot_count; r++) {
        for (unsigned i = 0U; i < ROBOT_BODIES_MAX; i++) {
            hash = (plant->robot[r].body[i] != NULL) ? hash_body(hash, plant->robot[r].body[i]) : hash;
        }
    }
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        const double rotor[] = {truth->motor[i].position_rad, truth->motor[i].velocity_rad_s,
                                truth->link_position_rad[i]};
        hash                 = hash_numbers(hash, rotor, 3U);
    }
    for (unsigned i = 0U; i < plant->contacts.pair_count; i++) {
        hash = hash_numbers(hash, plant->contacts.pair[i].stretch_m, 2U);
    }
    for (unsigned i = 0U; i < plant->world->spring_count; i++) {
        const double flag[] = {plant->spring[i].hooked ? 1.0 : 0.0, plant->spring[i].below ? 1.0 : 0.0};
        hash                = hash_numbers(hash, flag, 2U);
    }
    for (unsigned i = 0U; i < plant->world->wheel_count; i++) {
        hash = hash_numbers(hash, &truth->wheel[i].momentum_nms, 1U);
    }
    for (unsigned i = 0U; i < plant->world->joystick_count; i++) {
        hash = hash_numbers(hash, truth->stick[i].position_rad, PLANT_AXES_MAX);
        hash = hash_numbers(hash, truth->stick[i].velocity_rad_s, PLANT_AXES_MAX);
    }
    return hash;
}
