// SPDX-License-Identifier: Apache-2.0
#include "sim/app/spread.h"

#include "sim/plant/sensor.h"

// First number of the random streams of each kind; an index is added. The noise of devices has lower numbers.
#define BODIES 0x53000000U
#define STARTS 0x54000000U
#define DRIVES 0x44000000U
#define BENCHES 0x42000000U
#define WHEELS 0x57000000U
#define SENSORS 0x43000000U
#define BODY_SHIFT 8U

/// A source of random numbers. A parameter without a spread keeps its exact value.
typedef struct {
    uint64_t seed;
    uint32_t key;
} stream_t;

/// Random number `index` of a stream, within +- `most`.
static double draw(const stream_t* const stream, const double most, const uint64_t index)
{
    return (most == 0.0) ? 0.0 : most * sensor_uniform(stream->seed, stream->key, index);
}

/// Add a random number within +- `most` to each component of a vector; `first` is the index of the first one.
static void vary(const stream_t* const stream, const double most, const uint64_t first, double vector[3])
{
    for (unsigned i = 0U; (most != 0.0) && (i < 3U); i++) {
        vector[i] += draw(stream, most, first + i);
    }
}

static void spread_body(const world_robot_t* const robot, const stream_t* const stream,
                        robot_mass_t* const body)
{
    const double heavier = 1.0 + draw(stream, robot->spread_mass, 0U);
    const double wider   = heavier * (1.0 + draw(stream, robot->spread_inertia, 1U));
    body->mass_kg *= heavier;
    vary(stream, robot->spread_com, 2U, body->com_m);
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            body->inertia_kgm2.at[i][k] *= wider;
        }
    }
}

static void spread_start(world_robot_t* const robot, const stream_t* const stream)
{
    const world_start_spread_t* most = &robot->spread_start;
    double rpy[3]                    = {0.0};
    vary(stream, most->at, 0U, robot->pose.position_m);
    vary(stream, most->velocity, 6U, robot->velocity_m_s);
    vary(stream, most->rate, 9U, robot->rate_rad_s);
    if (most->rpy != 0.0) {
        vary(stream, most->rpy, 3U, rpy);
        const pose_t turn = pose_of((const double[3]){0.0}, rpy);
        robot->pose       = pose_compose(&robot->pose, &turn);
    }
}

static void spread_robot(world_robot_t* const robot, const uint32_t index, const uint64_t seed)
{
    for (uint32_t b = 0U; b <= robot->model.joint_count; b++) {
        const stream_t stream = {seed, BODIES | (index << (2U * BODY_SHIFT)) | (b << BODY_SHIFT)};
        spread_body(robot, &stream, &robot->model.body[b]);
    }
    spread_start(robot, &(const stream_t){seed, STARTS | index});
}

static world_drive_difference_t difference(const world_drive_type_t* const type, const stream_t stream)
{
    return (world_drive_difference_t){.friction  = draw(&stream, type->friction_spread, 0U),
                                      .stiffness = draw(&stream, type->stiffness_spread, 1U)};
}

void spread_apply(world_t* const world, const uint64_t seed)
{
    for (uint32_t i = 0U; i < world->robot_count; i++) {
        spread_robot(&world->robot[i], i, seed);
    }
    for (uint32_t i = 0U; i < world->drive_count; i++) {
        world_drive_t* drive = &world->drive[i];
        drive->difference    = difference(&world->drive_type[drive->type], (stream_t){seed, DRIVES | i});
    }
    for (uint32_t i = 0U; i < world->bench_count; i++) {
        world_bench_t* bench = &world->bench[i];
        bench->difference    = difference(&world->drive_type[bench->type], (stream_t){seed, BENCHES | i});
    }
    for (uint32_t i = 0U; i < world->wheel_count; i++) {
        const stream_t stream           = {seed, WHEELS | i};
        world->wheel[i].gain_difference = draw(&stream, world->wheel[i].gain_spread, 0U);
    }
    for (uint32_t i = 0U; i < world->sensor_count; i++) {
        const stream_t stream  = {seed, SENSORS | i};
        world_sensor_t* sensor = &world->sensor[i];
        vary(&stream, sensor->at_spread, 0U, sensor->at);
        vary(&stream, sensor->rpy_spread, 3U, sensor->rpy);
    }
}
