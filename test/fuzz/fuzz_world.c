// SPDX-License-Identifier: Apache-2.0
// The file of a world or of a robot is either refused with a message, or gives records in which every checked
// index is in range, every tree lists parents first, and the numbers of robots are finite.
#include "sim/operator/scene.h"
#include "sim/plant/plant.h"
#include "sim/world/world.h"
#include "test/fuzz/fuzz.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static world_t world;
static robot_model_t robot;
static char path[128];

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    (void)argc;
    (void)argv;
    const uint8_t nothing       = 0U;
    const char* const directory = fuzz_directory("world");
    fuzz_link(directory, "rokviss.urdf", "../../../../descriptors/worlds/rokviss.urdf");
    fuzz_link(directory, "world.xml", fuzz_file(&nothing, 0U));
    (void)snprintf(path, sizeof path, "%s/world.xml", directory);
    return 0;
}

static bool are_finite(const double* const numbers, const size_t count)
{
    bool are = true;
    for (size_t i = 0U; i < count; i++) {
        are = are && isfinite(numbers[i]);
    }
    return are;
}

static bool is_pose_finite(const pose_t* const pose)
{
    return are_finite(&pose->rotation.at[0][0], 9U) && are_finite(pose->position_m, 3U);
}

static void check_robot(const robot_model_t* const model)
{
    FUZZ_CHECK((model->joint_count <= ROBOT_JOINTS_MAX) && (model->frame_count >= 1U) &&
               (model->frame_count <= ROBOT_LINKS_MAX) && (model->shape_count <= ROBOT_SHAPES_MAX));
    for (size_t i = 0U; i < model->joint_count; i++) {
        const robot_joint_t* joint = &model->joint[i];
        const robot_mass_t* body   = &model->body[i + 1U];
        const double* axis         = joint->axis;
        FUZZ_CHECK((joint->parent <= i) && (joint->kind < ROBOT_JOINT_FIXED) && (joint->line >= 1U));
        FUZZ_CHECK(fabs(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2] - 1.0) < 1e-9);
        FUZZ_CHECK((joint->kind == ROBOT_JOINT_CONTINUOUS) || (joint->lower < joint->upper));
        FUZZ_CHECK((body->mass_kg > 0.0) && isfinite(body->mass_kg) && are_finite(body->com_m, 3U));
        FUZZ_CHECK(are_finite(&body->inertia_kgm2.at[0][0], 9U) && is_pose_finite(&joint->origin));
        FUZZ_CHECK(robot_model_joint(model, joint->name) <= i);
        FUZZ_CHECK(!joint->is_mimic ||
                   ((joint->leader < model->joint_count) && !model->joint[joint->leader].is_mimic));
    }
    for (size_t i = 0U; i < model->frame_count; i++) {
        FUZZ_CHECK((model->frame[i].body <= model->joint_count) && is_pose_finite(&model->frame[i].pose));
    }
    for (size_t i = 0U; i < model->shape_count; i++) {
        FUZZ_CHECK((model->shape[i].frame < model->frame_count) && (model->shape[i].kind <= SHAPE_CYLINDER));
        FUZZ_CHECK(is_pose_finite(&model->shape[i].pose));
    }
}

static void check_device(const world_device_t* const device)
{
    FUZZ_CHECK((device->bus < world.bus_count) && (device->node >= 2U) && (device->node <= 127U));
    FUZZ_CHECK((device->name[0] != '\0') && (memchr(device->eds, '\0', sizeof device->eds) != NULL));
}

static void check_side(const world_side_t* const side)
{
    if (side->is_fixture) {
        FUZZ_CHECK(side->fixture < world.fixture_count);
        return;
    }
    FUZZ_CHECK((side->robot < world.robot_count) &&
               (side->frame < world.robot[side->robot].model.frame_count));
}

static void check_world(void)
{
    FUZZ_CHECK((world.bus_count <= WORLD_BUSES_MAX) && (world.step_ns >= 1e5) && (world.step_ns <= 1e7));
    for (size_t i = 0U; i < world.robot_count; i++) {
        check_robot(&world.robot[i].model);
    }
    for (size_t i = 0U; i < world.drive_count; i++) {
        const world_drive_t* drive = &world.drive[i];
        check_device(&drive->device);
        FUZZ_CHECK((drive->robot < world.robot_count) && (drive->type < world.drive_type_count) &&
                   (drive->joint < world.robot[drive->robot].model.joint_count));
    }
    for (size_t i = 0U; i < world.bench_count; i++) {
        check_device(&world.bench[i].device);
        FUZZ_CHECK(world.bench[i].type < world.drive_type_count);
    }
    for (size_t i = 0U; i < world.joystick_count; i++) {
        check_device(&world.joystick[i].device);
    }
    for (size_t i = 0U; i < world.contact_count; i++) {
        const world_contact_t* contact = &world.contact[i];
        check_side(&contact->side[0]);
        check_side(&contact->side[1]);
        FUZZ_CHECK(!contact->side[0].is_fixture);
    }
    for (size_t i = 0U; i < world.hand_count; i++) {
        FUZZ_CHECK(world.hand[i].joystick < world.joystick_count);
    }
}

static void check_error(const status_t status, const char* const error)
{
    FUZZ_CHECK((status == STATUS_INVALID) || (status == STATUS_NOT_FOUND) || (status == STATUS_TOO_LARGE));
    FUZZ_CHECK((error[0] != '\0') && (memchr(error, '\0', DOCUMENT_ERROR_MAX) != NULL));
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    char error[DOCUMENT_ERROR_MAX];
    scene_t scene;
    plant_t* plant = NULL;
    (void)fuzz_file(data, size);
    status_t status = robot_model_read(path, &robot, error);
    if (status == STATUS_OK) {
        check_robot(&robot);
    } else {
        check_error(status, error);
    }
    status = world_read(path, &world, error);
    if (status == STATUS_OK) {
        check_world();
        status = scene_of(&world, &scene, error);
        FUZZ_CHECK((status != STATUS_OK) || isfinite(scene.bump_height_m));
        status = plant_create(&world, &plant, error);
        FUZZ_CHECK((status == STATUS_OK) == (plant != NULL));
        plant_destroy(plant);
    }
    if (status != STATUS_OK) {
        check_error(status, error);
    }
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_document(data, size, max_size, seed);
}
