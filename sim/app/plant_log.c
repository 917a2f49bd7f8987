// SPDX-License-Identifier: Apache-2.0
#include "sim/app/plant_log.h"

#include <stdio.h>
#include <string.h>

#define NAME_OCTETS ((size_t)2U * DOCUMENT_TEXT_MAX)
#define AXES_MAX (WORLD_JOYSTICKS_MAX * PLANT_AXES_MAX)

// ---- Names ----

typedef struct {
    char joint[PLANT_JOINTS_MAX][NAME_OCTETS];
    const char* joints[PLANT_JOINTS_MAX];
    const char* axes[AXES_MAX];
    const char* contacts[WORLD_CONTACTS_MAX];
    const char* springs[WORLD_SPRINGS_MAX];
    const char* bases[WORLD_ROBOTS_MAX];
} names_t;

static void name_robots(const world_t* const world, names_t* const names, truth_world_t* const out_world)
{
    for (size_t r = 0U; r < world->robot_count; r++) {
        const world_robot_t* robot = &world->robot[r];
        for (size_t i = 0U; i < robot->model.joint_count; i++) {
            const unsigned index = out_world->joints.count;
            (void)snprintf(names->joint[index], NAME_OCTETS, "%s.%s", robot->name,
                           robot->model.joint[i].name);
            names->joints[index] = names->joint[index];
            out_world->joints.count++;
        }
        if (robot->is_free) {
            names->bases[out_world->bases.count] = robot->name;
            out_world->bases.count++;
        }
    }
}

static void name_axes(const world_t* const world, names_t* const names, truth_world_t* const out_world)
{
    for (size_t k = 0U; k < world->joystick_count; k++) {
        for (unsigned i = 0U; i < world->joystick[k].axes; i++) {
            names->axes[out_world->axes.count] = world->joystick[k].device.name;
            out_world->axes.count++;
        }
    }
}

static status_t name_wheels(truth_t* const log, const world_t* const world)
{
    const char* name[WORLD_WHEELS_MAX];
    const truth_names_t names = {.count = (unsigned)world->wheel_count, .name = name};
    for (size_t i = 0U; i < world->wheel_count; i++) {
        name[i] = world->wheel[i].device.name;
    }
    return (names.count > 0U) ? truth_names(log, 0U, "WHEEL", &names) : STATUS_OK;
}

status_t plant_log_names(truth_t* const log, const world_t* const world)
{
    names_t names;
    truth_world_t all = {.joints   = {.name = names.joints},
                         .axes     = {.name = names.axes},
                         .contacts = {.count = (unsigned)world->contact_count, .name = names.contacts},
                         .springs  = {.count = (unsigned)world->spring_count, .name = names.springs},
                         .bases    = {.name = names.bases}};
    name_robots(world, &names, &all);
    name_axes(world, &names, &all);
    for (size_t i = 0U; i < world->contact_count; i++) {
        names.contacts[i] = world->contact[i].a;
    }
    for (size_t i = 0U; i < world->spring_count; i++) {
        names.springs[i] = world->spring[i].on;
    }
    const status_t status = truth_world(log, 0U, &all);
    return (status == STATUS_OK) ? name_wheels(log, world) : status;
}

// ---- State ----

static status_t log_joints(truth_t* const log, const plant_truth_t* const truth)
{
    double motor[PLANT_JOINTS_MAX];
    const truth_joints_t joints = {.count              = truth->joint_count,
                                   .position_rad       = truth->link_position_rad,
                                   .velocity_rad_s     = truth->link_velocity_rad_s,
                                   .motor_position_rad = motor,
                                   .motor_torque_nm    = truth->motor_torque_nm,
                                   .joint_torque_nm    = truth->joint_torque_nm,
                                   .friction_nm        = truth->friction_nm,
                                   .external_torque_nm = truth->external_torque_nm,
                                   .brake_engaged      = truth->brake_engaged};
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        motor[i] = truth->motor[i].position_rad;
    }
    return (joints.count > 0U) ? truth_joints(log, truth->time_ns, &joints) : STATUS_OK;
}

static status_t log_sticks(truth_t* const log, const world_t* const world, const plant_truth_t* const truth)
{
    double position[AXES_MAX];
    double velocity[AXES_MAX];
    double motor[AXES_MAX];
    double hand[AXES_MAX];
    truth_stick_t axes = {.position_rad    = position,
                          .velocity_rad_s  = velocity,
                          .motor_torque_nm = motor,
                          .hand_torque_nm  = hand};
    for (size_t k = 0U; k < world->joystick_count; k++) {
        const plant_stick_t* stick = &truth->stick[k];
        for (unsigned i = 0U; i < world->joystick[k].axes; i++) {
            position[axes.count] = stick->position_rad[i];
            velocity[axes.count] = stick->velocity_rad_s[i];
            motor[axes.count]    = stick->torque_nm[i];
            hand[axes.count]     = stick->hand_torque_nm[i];
            axes.count++;
        }
    }
    return (axes.count > 0U) ? truth_stick(log, truth->time_ns, &axes) : STATUS_OK;
}

static status_t log_contacts(truth_t* const log, const world_t* const world, const plant_truth_t* const truth)
{
    truth_touch_t touch[WORLD_CONTACTS_MAX];
    const unsigned count = (unsigned)world->contact_count;
    for (unsigned i = 0U; i < count; i++) {
        const plant_contact_t* contact = &truth->contact[i];
        memcpy(touch[i].place_m, contact->place_m, sizeof touch[i].place_m);
        memcpy(touch[i].point_m, contact->point_m, sizeof touch[i].point_m);
        memcpy(touch[i].force_n, contact->force_n, sizeof touch[i].force_n);
        touch[i].is_active = contact->is_touching;
    }
    return (count > 0U) ? truth_contacts(log, truth->time_ns, touch, count) : STATUS_OK;
}

static status_t log_springs(truth_t* const log, const world_t* const world, const plant_truth_t* const truth)
{
    truth_touch_t pull[WORLD_SPRINGS_MAX];
    const unsigned count = (unsigned)world->spring_count;
    for (unsigned i = 0U; i < count; i++) {
        const plant_spring_t* spring = &truth->spring[i];
        memcpy(pull[i].place_m, spring->place_m, sizeof pull[i].place_m);
        memcpy(pull[i].force_n, spring->force_n, sizeof pull[i].force_n);
        pull[i].is_active = spring->is_hooked;
    }
    return (count > 0U) ? truth_springs(log, truth->time_ns, pull, count) : STATUS_OK;
}

static status_t log_wheels(truth_t* const log, const world_t* const world, const plant_truth_t* const truth)
{
    truth_wheel_t wheel[WORLD_WHEELS_MAX];
    const unsigned count = (unsigned)world->wheel_count;
    for (unsigned i = 0U; i < count; i++) {
        wheel[i] = (truth_wheel_t){truth->wheel[i].momentum_nms, truth->wheel[i].torque_nm};
    }
    return (count > 0U) ? truth_wheels(log, truth->time_ns, wheel, count) : STATUS_OK;
}

static status_t log_bases(truth_t* const log, const plant_truth_t* const truth)
{
    truth_base_t base[WORLD_ROBOTS_MAX];
    for (unsigned i = 0U; i < truth->base_count; i++) {
        memcpy(base[i].position_m, truth->base[i].position_m, sizeof base[i].position_m);
        memcpy(base[i].rotation, truth->base[i].rotation, sizeof base[i].rotation);
        memcpy(base[i].velocity_m_s, truth->base[i].velocity_m_s, sizeof base[i].velocity_m_s);
        memcpy(base[i].rate_rad_s, truth->base[i].rate_rad_s, sizeof base[i].rate_rad_s);
    }
    return (truth->base_count > 0U) ? truth_bases(log, truth->time_ns, base, truth->base_count) : STATUS_OK;
}

status_t plant_log_state(truth_t* const log, const world_t* const world, const plant_truth_t* const truth)
{
    status_t status = log_joints(log, truth);
    status          = (status == STATUS_OK) ? log_sticks(log, world, truth) : status;
    status          = (status == STATUS_OK) ? log_contacts(log, world, truth) : status;
    status          = (status == STATUS_OK) ? log_springs(log, world, truth) : status;
    status          = (status == STATUS_OK) ? log_wheels(log, world, truth) : status;
    return (status == STATUS_OK) ? log_bases(log, truth) : status;
}

status_t plant_log_latches(truth_t* const log, const world_t* const world, const plant_truth_t* const truth,
                           bool is_closed[WORLD_LATCHES_MAX])
{
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < world->latch_count) && (status == STATUS_OK); i++) {
        if (truth->is_latched[i] != is_closed[i]) {
            const truth_latch_t event = {world->latch[i].name, truth->is_latched[i]};
            is_closed[i]              = truth->is_latched[i];
            status                    = truth_latch(log, truth->time_ns, &event);
        }
    }
    return status;
}
