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
    dBodyVectorFromWorld(body, rate[0], rate[1], rate[2], local);
    dBodyVectorToWorld(body, mass.I[0] * local[0], mass.I[5] * local[1], mass.I[10] * local[2], spin);
    for (unsigned i = 0U; i < 3U; i++) {
        angular[i] += orbital[i] + spin[i];
    }
}

void plant_momentum(const plant_t* const plant, double out_linear[3], double out_angular[3])
{
    memset(out_linear, 0, 3U * sizeof(double));
    memset(out_angular, 0, 3U * sizeof(double));
    if (plant->base != NULL) {
        add_body_momentum(plant->base, out_linear, out_angular);
    }
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        const double spin = plant->parameters.drive[i].rotor_inertia_kgm2 /
                            plant->parameters.drive[i].gear_ratio * plant->truth.motor[i].velocity_rad_s;
        dVector3 axis;
        dJointGetHingeAxis(plant->hinge[i], axis);
        for (unsigned k = 0U; k < 3U; k++) {
            out_angular[k] += spin * axis[k];
        }
        add_body_momentum(plant->link[i], out_linear, out_angular);
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
    const double flag[]        = {plant->spring.hooked ? 1.0 : 0.0, plant->spring.below ? 1.0 : 0.0};
    uint64_t hash              = 0xCBF29CE484222325U;

    hash = (plant->base != NULL) ? hash_body(hash, plant->base) : hash;
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        const double rotor[] = {truth->motor[i].position_rad, truth->motor[i].velocity_rad_s,
                                truth->link_position_rad[i]};
        hash                 = hash_body(hash, plant->link[i]);
        hash                 = hash_numbers(hash, rotor, 3U);
    }
    hash = hash_numbers(hash, truth->stick_position_rad, PLANT_AXES);
    hash = hash_numbers(hash, truth->stick_velocity_rad_s, PLANT_AXES);
    return hash_numbers(hash, flag, 2U);
}
