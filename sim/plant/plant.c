// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant.h"

#include "sim/plant/plant_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#define DENORMALS_ARE_ZERO 0x8040U // FTZ and DAZ of MXCSR.
#endif

#if defined(__GNUC__)
#define NOT_INLINE __attribute__((noinline))
#else
#define NOT_INLINE
#endif

#define NS_PER_S 1.0e9

static unsigned open_plants; // Number of plants. ODE is initialised while there is at least one.

// ---- Creation ----

static void create_world(plant_t* const plant)
{
    const double* gravity = plant->world->gravity;
    plant->ode            = dWorldCreate();
    dWorldSetGravity(plant->ode, gravity[0], gravity[1], gravity[2]);
    dWorldSetERP(plant->ode, 0.2);
    dWorldSetCFM(plant->ode, 1e-10);
    dWorldSetAutoDisableFlag(plant->ode, 0);
}

/// Positions of the origins of the links named by contacts and springs.
static void read_positions(plant_t* const plant)
{
    const world_t* world = plant->world;
    for (size_t i = 0U; i < world->contact_count; i++) {
        const world_side_t* a      = &world->contact[i].side[0];
        const robot_frame_t* frame = &world->robot[a->robot].model.frame[a->frame];
        robot_point(plant, a->robot, frame->body, frame->pose.position_m, plant->truth.contact[i].place_m);
    }
    for (size_t i = 0U; i < world->spring_count; i++) {
        const world_spring_t* cable = &world->spring[i];
        const robot_frame_t* frame  = &world->robot[cable->robot].model.frame[cable->frame];
        robot_point(plant, cable->robot, frame->body, frame->pose.position_m, plant->truth.spring[i].place_m);
    }
}

status_t plant_create(const world_t* const world, plant_t** const out_plant, char error[DOCUMENT_ERROR_MAX])
{
    plant_t* plant = calloc(1U, sizeof *plant);
    *out_plant     = NULL;
    if (plant == NULL) {
        (void)snprintf(error, DOCUMENT_ERROR_MAX, "no memory for the plant");
        return STATUS_EXHAUSTED;
    }
    if (open_plants == 0U) {
        dInitODE2(0);
    }
    open_plants++;
    dAllocateODEDataForThread((unsigned)dAllocateMaskAll);
    plant->world = world;
    create_world(plant);
    status_t status = robots_create(plant, error);
    status          = (status == STATUS_OK) ? mimics_create(plant, error) : status;
    status          = (status == STATUS_OK) ? contacts_create(plant, error) : status;
    if (status != STATUS_OK) {
        plant_destroy(plant);
        return status;
    }
    robots_read(plant);
    read_positions(plant);
    wheels_create(plant);
    for (size_t i = 0U; i < world->spring_count; i++) {
        plant->spring[i].below = plant->truth.spring[i].place_m[2] < world->spring[i].hook[2];
    }
    *out_plant = plant;
    return STATUS_OK;
}

void plant_destroy(plant_t* const plant)
{
    if (plant == NULL) {
        return;
    }
    contacts_destroy(plant);
    dWorldDestroy(plant->ode);
    free(plant);
    open_plants--;
    if (open_plants == 0U) {
        dCloseODE();
    }
}

// ---- One step ----

/// Integrate a rotor over one substep; the gear torque assumes that the link keeps its present speed.
static void step_rotor(plant_t* const plant, const plant_input_t* const input, const unsigned joint,
                       const unsigned substep, const double torque_nm, const double h_s)
{
    plant_truth_t* truth       = &plant->truth;
    const plant_drive_t* drive = &plant->joint[joint].drive;
    const double speed         = truth->link_velocity_rad_s[joint];
    const double link          = truth->link_position_rad[joint] + speed * (double)substep * h_s;
    const double stretch       = truth->motor[joint].position_rad - link;
    const double gear          = drive->gear_stiffness_nm_rad * stretch +
                        drive->gear_damping_nms_rad * (truth->motor[joint].velocity_rad_s - speed);
    const double friction =
        joint_rotor_step(drive, &truth->motor[joint], input->brake_engaged[joint], torque_nm, gear, h_s);
    truth->joint_torque_nm[joint] += gear / PLANT_SUBSTEPS;
    truth->friction_nm[joint] += friction / PLANT_SUBSTEPS;
}

static void step_rotors(plant_t* const plant, const plant_input_t* const input, const unsigned substep,
                        const double h_s)
{
    plant_truth_t* truth = &plant->truth;
    double torque[PLANT_JOINTS_MAX];

    memset(torque, 0, truth->joint_count * sizeof torque[0]);
    if (input->drive != NULL) {
        input->drive(input->drive_context, substep, truth->motor, torque);
    }
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        if (plant->joint[i].drive_of != NULL) {
            step_rotor(plant, input, i, substep, torque[i], h_s);
        } else {
            truth->joint_torque_nm[i] += torque[i] / PLANT_SUBSTEPS;
        }
        truth->motor_torque_nm[i] += torque[i] / PLANT_SUBSTEPS;
    }
}

static void step_stick(plant_t* const plant, const plant_input_t* const input, const unsigned index,
                       const unsigned substep, const double h_s)
{
    plant_stick_t* stick             = &plant->truth.stick[index];
    const world_joystick_t* joystick = &plant->world->joystick[index];
    double hand[PLANT_AXES_MAX]      = {0.0};

    if (input->hand[index] != NULL) {
        input->hand[index](input->hand_context[index], substep, stick->position_rad, stick->velocity_rad_s,
                           hand);
    }
    for (unsigned i = 0U; i < joystick->axes; i++) {
        stick_step(joystick, input->stick_torque_nm[index][i] + hand[i], h_s, &stick->position_rad[i],
                   &stick->velocity_rad_s[i]);
        stick->hand_torque_nm[i] += hand[i] / PLANT_SUBSTEPS;
    }
}

/// Apply the torque of a rotor to the parent link that carries it: the reaction to its acceleration, and the
/// gyroscopic torque. At the joint speed w a rotor with the inertia J_m turns at N w, so its angular momentum
/// is J_m N w = (J_m N^2 / N) w. For a prismatic joint the torque is zero, because the axis of the motor is
/// not known.
static void rotor_reaction(const joint_t* const joint, const double speed_rad_s, const double before_rad_s,
                           const double dt_s)
{
    const dBodyID parent = joint->parent;
    if ((parent == NULL) || (joint->drive_of == NULL) || (joint->model->kind == ROBOT_JOINT_PRISMATIC)) {
        return;
    }
    const double spin = joint->drive.rotor_inertia_kgm2 / joint->drive.gear_ratio;
    const double gain = -spin * (speed_rad_s - before_rad_s) / dt_s;
    const double h    = spin * before_rad_s;
    const dReal* rate = dBodyGetAngularVel(parent);
    dVector3 axis;
    dJointGetHingeAxis(joint->ode, axis);
    dBodyAddTorque(parent, gain * axis[0] - h * (rate[1] * axis[2] - rate[2] * axis[1]),
                   gain * axis[1] - h * (rate[2] * axis[0] - rate[0] * axis[2]),
                   gain * axis[2] - h * (rate[0] * axis[1] - rate[1] * axis[0]));
}

static void clear_sums(plant_t* const plant, const plant_input_t* const input)
{
    plant_truth_t* truth = &plant->truth;
    memcpy(truth->valve_open, input->valve_open, sizeof truth->valve_open);
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        truth->motor_torque_nm[i]    = 0.0;
        truth->joint_torque_nm[i]    = 0.0;
        truth->friction_nm[i]        = 0.0;
        truth->external_torque_nm[i] = 0.0;
        truth->brake_engaged[i]      = input->brake_engaged[i] && (plant->joint[i].drive_of != NULL);
    }
    for (unsigned k = 0U; k < plant->world->joystick_count; k++) {
        memset(truth->stick[k].hand_torque_nm, 0, sizeof truth->stick[k].hand_torque_nm);
        memcpy(truth->stick[k].torque_nm, input->stick_torque_nm[k], sizeof truth->stick[k].torque_nm);
    }
}

/// Integrate rotors and joysticks, which are outside of ODE; then apply the gear torques to the links.
static void step_mechanisms(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    plant_truth_t* truth = &plant->truth;
    double before[PLANT_JOINTS_MAX];
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        before[i] = truth->motor[i].velocity_rad_s;
    }
    for (unsigned substep = 0U; substep < PLANT_SUBSTEPS; substep++) {
        step_rotors(plant, input, substep, dt_s / PLANT_SUBSTEPS);
        for (unsigned k = 0U; k < plant->world->joystick_count; k++) {
            step_stick(plant, input, k, substep, dt_s / PLANT_SUBSTEPS);
        }
    }
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        const joint_t* joint = &plant->joint[i];
        if (joint->model->kind == ROBOT_JOINT_PRISMATIC) {
            dJointAddSliderForce(joint->ode, truth->joint_torque_nm[i]);
        } else {
            dJointAddHingeTorque(joint->ode, truth->joint_torque_nm[i]);
        }
        rotor_reaction(joint, truth->motor[i].velocity_rad_s, before[i], dt_s);
    }
}

static void pull_springs(plant_t* const plant)
{
    for (unsigned i = 0U; i < plant->world->spring_count; i++) {
        const world_spring_t* cable = &plant->world->spring[i];
        plant_spring_t* truth       = &plant->truth.spring[i];
        load_t load                 = {.robot = cable->robot,
                                       .body  = plant->world->robot[cable->robot].model.frame[cable->frame].body};
        const dBodyID body          = plant->robot[load.robot].body[load.body];
        memcpy(load.point_m, truth->place_m, sizeof load.point_m);
        spring_force(cable, &plant->spring[i], truth->place_m, load.force_n);
        robots_add_load(plant, &load);
        memcpy(truth->force_n, load.force_n, sizeof truth->force_n);
        truth->is_hooked = plant->spring[i].hooked;
        if (body != NULL) {
            dBodyAddForceAtPos(body, load.force_n[0], load.force_n[1], load.force_n[2], load.point_m[0],
                               load.point_m[1], load.point_m[2]);
        }
    }
}

/// Apply the thrust of the open valves to their links.
static void push_valves(plant_t* const plant, const plant_input_t* const input)
{
    for (unsigned i = 0U; i < plant->world->valve_count; i++) {
        const world_valve_t* valve = &plant->world->valve[i];
        const robot_frame_t* frame = &plant->world->robot[valve->robot].model.frame[valve->frame];
        const dBodyID body         = plant->robot[valve->robot].body[frame->body];
        const pose_t turn          = {.rotation = frame->pose.rotation};
        load_t load                = {.robot = valve->robot, .body = frame->body};
        double at[3];
        double along[3];
        dVector3 direction;
        if (!input->valve_open[i] || (body == NULL)) {
            continue;
        }
        pose_apply(&frame->pose, valve->at, at);
        pose_apply(&turn, valve->direction, along);
        robot_point(plant, load.robot, load.body, at, load.point_m);
        dBodyVectorToWorld(body, along[0], along[1], along[2], direction);
        for (unsigned k = 0U; k < 3U; k++) {
            load.force_n[k] = valve->force * direction[k];
        }
        robots_add_load(plant, &load);
        dBodyAddForceAtPos(body, load.force_n[0], load.force_n[1], load.force_n[2], load.point_m[0],
                           load.point_m[1], load.point_m[2]);
    }
}

/// Add all forces and torques of the present pose first, because plant_is_sound adds their effect to the
/// speeds. Change the joints of latches and contacts after that check, so that a failed step changes none.
/// Latches come before contacts, because a closed latch ends the contact between its links. Last, read the
/// state after the step into the truth.
static NOT_INLINE void step_world(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    clear_sums(plant, input);
    step_mechanisms(plant, input, dt_s);
    robots_read_axes(plant);
    pull_springs(plant);
    wheels_step(plant, input, dt_s);
    robots_add_gyroscopic_torques(plant, dt_s);
    push_valves(plant, input);
    if (!plant_is_sound(plant, dt_s)) {
        return;
    }
    const bool has_closed = latches_step(plant, input, dt_s);
    contacts_touch(plant, dt_s);
    if (plant->mimic_count > 0U) {
        mimics_step(plant, dt_s);
    } else {
        dWorldStep(plant->ode, dt_s);
    }
    contacts_read(plant, dt_s);
    if (has_closed) {
        robots_forget_rates(plant);
    }
    robots_read(plant);
    wheels_read(plant);
    read_positions(plant);
}

void plant_step(plant_t* const plant, const plant_input_t* const input, const uint64_t dt_ns)
{
    if (plant_failure(plant) != NULL) {
        return;
    }
    // Velocities perpendicular to the plane of a planar arm decay into denormal numbers, which make a step
    // eight times as long. Processors without this mode compute the same results more slowly.
#if defined(__SSE2__)
    const unsigned mode = _mm_getcsr();
    _mm_setcsr(mode | DENORMALS_ARE_ZERO);
#endif
    step_world(plant, input, (double)dt_ns / NS_PER_S);
#if defined(__SSE2__)
    // This also discards the exception flags that the step has raised.
    _mm_setcsr(mode);
#endif
    if (plant_failure(plant) == NULL) {
        plant->truth.time_ns += dt_ns;
    }
}

const plant_truth_t* plant_truth(const plant_t* const plant)
{
    return &plant->truth;
}
