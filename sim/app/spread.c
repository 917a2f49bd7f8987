// SPDX-License-Identifier: Apache-2.0
#include "sim/app/spread.h"

#include "sim/plant/sensor.h"

#define STREAM 0x53000000U ///< Key of the bodies among the devices that draw random numbers.
#define BODY_SHIFT 8U

void spread_apply(world_t* const world, const uint64_t seed)
{
    for (uint32_t r = 0U; r < world->robot_count; r++) {
        world_robot_t* robot = &world->robot[r];
        if ((robot->spread_mass == 0.0) && (robot->spread_inertia == 0.0) && (robot->spread_com == 0.0)) {
            continue; // Its numbers keep all their bits.
        }
        for (uint32_t b = 0U; b <= robot->model.joint_count; b++) {
            robot_mass_t* body   = &robot->model.body[b];
            const uint32_t key   = STREAM | (r << (2U * BODY_SHIFT)) | (b << BODY_SHIFT);
            const double heavier = 1.0 + robot->spread_mass * sensor_uniform(seed, key, 0U);
            const double wider   = heavier * (1.0 + robot->spread_inertia * sensor_uniform(seed, key, 1U));
            body->mass_kg *= heavier;
            for (unsigned i = 0U; i < 3U; i++) {
                body->com_m[i] += robot->spread_com * sensor_uniform(seed, key, 2U + i);
                for (unsigned k = 0U; k < 3U; k++) {
                    body->inertia_kgm2.at[i][k] *= wider;
                }
            }
        }
    }
}
