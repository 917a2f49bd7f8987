// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant.h"

#include "sim/plant/plant_internal.h"

#include <math.h>
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

static unsigned open_plants; // ODE is initialised while any plant exists.

// ---- Creation ----

/// A link: x of its body frame points from joint to joint, the hinge axis is -y so that angles raise the tip.
static dBodyID create_link(plant_t* const plant, const unsigned index, const double start_m[2],
                           const double angle_rad)
{
    const plant_parameters_t* parameters = &plant->parameters;
    const double com                     = parameters->link_com_m[index];
    const double across                  = parameters->link_inertia_kgm2[index];
    const dBodyID body                   = dBodyCreate(plant->world);

    dMass mass;
    dMassSetParameters(&mass, parameters->link_mass_kg[index], 0.0, 0.0, 0.0,
                       parameters->link_twist_kgm2[index], across, across, 0.0, 0.0, 0.0);
    dBodySetMass(body, &mass);
    dMatrix3 rotation;
    dRFromAxisAndAngle(rotation, 0.0, -1.0, 0.0, angle_rad);
    dBodySetRotation(body, rotation);
    dBodySetPosition(body, start_m[0] + com * cos(angle_rad), 0.0, start_m[1] + com * sin(angle_rad));
    dBodySetGyroscopicMode(body, 1);
    return body;
}

static dJointID create_hinge(plant_t* const plant, const dBodyID child, const dBodyID parent,
                             const double anchor_m[2])
{
    const dJointID hinge = dJointCreateHinge(plant->world, NULL);
    dJointAttach(hinge, child, parent);
    dJointSetHingeAnchor(hinge, anchor_m[0], 0.0, anchor_m[1]);
    dJointSetHingeAxis(hinge, 0.0, -1.0, 0.0);
    return hinge;
}

static void create_base(plant_t* const plant)
{
    const plant_parameters_t* parameters = &plant->parameters;
    const double inertia                 = parameters->base_inertia_kgm2;
    dMass mass;
    dMassSetParameters(&mass, parameters->base_mass_kg, 0.0, 0.0, 0.0, inertia, inertia, inertia, 0.0, 0.0,
                       0.0);
    plant->base = dBodyCreate(plant->world);
    dBodySetMass(plant->base, &mass);
    dBodySetPosition(plant->base, 0.0, 0.0, 0.0);
    dBodySetGyroscopicMode(plant->base, 1);
}

/// Let a body take part in the initial motion of the whole assembly.
static void set_in_motion(const plant_options_t* const options, const dBodyID body)
{
    const dReal* r      = dBodyGetPosition(body);
    const double* rate  = options->base_rate_rad_s;
    const double* speed = options->base_velocity_m_s;
    dBodySetLinearVel(body, speed[0] + rate[1] * r[2] - rate[2] * r[1],
                      speed[1] + rate[2] * r[0] - rate[0] * r[2], speed[2] + rate[0] * r[1] - rate[1] * r[0]);
    dBodySetAngularVel(body, rate[0], rate[1], rate[2]);
}

/// Bodies and joints in a fixed order: ODE's results depend on it.
static void create_robot(plant_t* const plant)
{
    const plant_parameters_t* parameters = &plant->parameters;
    const double first                   = parameters->home_rad[0];
    const double second                  = first + parameters->home_rad[1];
    const double shoulder[]              = {0.0, 0.0};
    const double elbow[]                 = {parameters->link_length_m[0] * cos(first),
                                            parameters->link_length_m[0] * sin(first)};

    if (plant->options.free_base) {
        create_base(plant);
    }
    plant->link[0]  = create_link(plant, 0U, shoulder, first);
    plant->link[1]  = create_link(plant, 1U, elbow, second);
    plant->hinge[0] = create_hinge(plant, plant->link[0], plant->base, shoulder);
    plant->hinge[1] = create_hinge(plant, plant->link[1], plant->link[0], elbow);
    if (plant->options.free_base) {
        set_in_motion(&plant->options, plant->base);
        set_in_motion(&plant->options, plant->link[0]);
        set_in_motion(&plant->options, plant->link[1]);
    }
}

static void create_world(plant_t* const plant)
{
    plant->world = dWorldCreate();
    dWorldSetGravity(plant->world, 0.0, 0.0, plant->options.gravity ? -plant->parameters.gravity_m_s2 : 0.0);
    dWorldSetERP(plant->world, 0.2);
    dWorldSetCFM(plant->world, 1e-10);
    dWorldSetAutoDisableFlag(plant->world, 0);
    dRandSetSeed(plant->options.seed);
}

static void read_links(plant_t* plant);

plant_t* plant_create(const plant_parameters_t* const parameters, const plant_options_t* const options)
{
    plant_t* plant = calloc(1U, sizeof *plant);
    if (plant == NULL) {
        return NULL;
    }
    if (open_plants == 0U) {
        dInitODE2(0);
    }
    open_plants++;
    dAllocateODEDataForThread((unsigned)dAllocateMaskAll);
    plant->parameters = *parameters;
    plant->options    = *options;
    create_world(plant);
    create_robot(plant);
    // A floating robot is far away from the platform with contour and spring.
    if (!options->free_base && !contour_create(plant)) {
        plant_destroy(plant);
        return NULL;
    }
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        plant->truth.link_position_rad[i]  = parameters->home_rad[i];
        plant->truth.motor[i].position_rad = parameters->home_rad[i];
    }
    read_links(plant);
    plant->spring.below = plant->truth.tip_m[2] < parameters->hook_m[1];
    return plant;
}

void plant_destroy(plant_t* const plant)
{
    if (plant == NULL) {
        return;
    }
    contour_destroy(plant);
    dWorldDestroy(plant->world);
    free(plant);
    open_plants--;
    if (open_plants == 0U) {
        dCloseODE();
    }
}

// ---- One step ----

/// Joint angles and tip from ODE into the truth; angles keep counting beyond half a turn.
static void read_links(plant_t* const plant)
{
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        const double angle        = dJointGetHingeAngle(plant->hinge[i]);
        const double change       = angle - plant->hinge_angle_rad[i];
        const double turn         = (change > M_PI) ? -2.0 * M_PI : ((change < -M_PI) ? 2.0 * M_PI : 0.0);
        plant->hinge_angle_rad[i] = angle;
        plant->truth.link_position_rad[i] += change + turn;
        plant->truth.link_velocity_rad_s[i] = dJointGetHingeAngleRate(plant->hinge[i]);
    }
    const unsigned last = PLANT_JOINTS - 1U;
    dVector3 tip;
    dBodyGetRelPointPos(plant->link[last],
                        plant->parameters.link_length_m[last] - plant->parameters.link_com_m[last], 0.0, 0.0,
                        tip);
    memcpy(plant->truth.tip_m, tip, sizeof plant->truth.tip_m);
}

/// Integrate the rotors over one step of dt_s; the gear torque assumes that the link keeps its present speed.
static void step_rotors(plant_t* const plant, const plant_input_t* const input, const unsigned substep,
                        const double h_s)
{
    const plant_parameters_t* parameters = &plant->parameters;
    plant_truth_t* truth                 = &plant->truth;
    double torque[PLANT_JOINTS]          = {0.0};

    if (input->drive != NULL) {
        input->drive(input->drive_context, substep, truth->motor, torque);
    }
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        const double speed         = truth->link_velocity_rad_s[i];
        const double link          = truth->link_position_rad[i] + speed * (double)substep * h_s;
        const double stretch       = truth->motor[i].position_rad - link;
        const plant_drive_t* drive = &parameters->drive[i];
        const double gear          = drive->gear_stiffness_nm_rad * stretch +
                            drive->gear_damping_nms_rad * (truth->motor[i].velocity_rad_s - speed);
        const double friction =
            joint_rotor_step(drive, &truth->motor[i], input->brake_engaged[i], torque[i], gear, h_s);
        truth->motor_torque_nm[i] += torque[i] / PLANT_SUBSTEPS;
        truth->joint_torque_nm[i] += gear / PLANT_SUBSTEPS;
        truth->friction_nm[i] += friction / PLANT_SUBSTEPS;
    }
}

static void step_stick(plant_t* const plant, const plant_input_t* const input, const unsigned substep,
                       const double h_s)
{
    plant_truth_t* truth    = &plant->truth;
    double hand[PLANT_AXES] = {0.0};

    if (input->hand != NULL) {
        input->hand(input->hand_context, substep, truth->stick_position_rad, truth->stick_velocity_rad_s,
                    hand);
    }
    for (unsigned i = 0U; i < PLANT_AXES; i++) {
        stick_step(&plant->parameters, input->stick_torque_nm[i] + hand[i], h_s,
                   &truth->stick_position_rad[i], &truth->stick_velocity_rad_s[i]);
        truth->hand_torque_nm[i] += hand[i] / PLANT_SUBSTEPS;
    }
}

/// What a rotor of angular momentum J_m N w does to the parent link that carries it: it is spun up against
/// the parent, and it is turned with it.
static void rotor_reaction(plant_t* const plant, const unsigned joint, const double before_rad_s,
                           const double dt_s)
{
    const dBodyID parent = (joint == 0U) ? plant->base : plant->link[joint - 1U];
    if (parent == NULL) {
        return;
    }
    const double spin =
        plant->parameters.drive[joint].rotor_inertia_kgm2 / plant->parameters.drive[joint].gear_ratio;
    const double speed = plant->truth.motor[joint].velocity_rad_s;
    const double gain  = -spin * (speed - before_rad_s) / dt_s;
    const double h     = spin * before_rad_s;
    const dReal* rate  = dBodyGetAngularVel(parent);
    dVector3 axis;
    dJointGetHingeAxis(plant->hinge[joint], axis);
    dBodyAddTorque(parent, gain * axis[0] - h * (rate[1] * axis[2] - rate[2] * axis[1]),
                   gain * axis[1] - h * (rate[2] * axis[0] - rate[0] * axis[2]),
                   gain * axis[2] - h * (rate[0] * axis[1] - rate[1] * axis[0]));
}

/// Everything outside of ODE: rotors, joystick; then the gear torques onto the links.
static void step_mechanisms(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    plant_truth_t* truth = &plant->truth;
    double before[PLANT_JOINTS];
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        before[i]                 = truth->motor[i].velocity_rad_s;
        truth->motor_torque_nm[i] = 0.0;
        truth->joint_torque_nm[i] = 0.0;
        truth->friction_nm[i]     = 0.0;
        truth->brake_engaged[i]   = input->brake_engaged[i];
    }
    for (unsigned i = 0U; i < PLANT_AXES; i++) {
        truth->hand_torque_nm[i]  = 0.0;
        truth->stick_torque_nm[i] = input->stick_torque_nm[i];
    }
    for (unsigned substep = 0U; substep < PLANT_SUBSTEPS; substep++) {
        step_rotors(plant, input, substep, dt_s / PLANT_SUBSTEPS);
        step_stick(plant, input, substep, dt_s / PLANT_SUBSTEPS);
    }
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        dJointAddHingeTorque(plant->hinge[i], truth->joint_torque_nm[i]);
        rotor_reaction(plant, i, before[i], dt_s);
    }
}

/// Torque about each joint of a load on the finger, at the pose of `elbow_m`.
static void add_external_torque(plant_truth_t* const truth, const dVector3 elbow_m,
                                const plant_load_t* const load)
{
    const double* point = load->point_m;
    const double* force = load->force_n;
    truth->external_torque_nm[0] += point[0] * force[2] - point[2] * force[0];
    truth->external_torque_nm[1] += (point[0] - elbow_m[0]) * force[2] - (point[2] - elbow_m[2]) * force[0];
}

/// Contact loads of the step just made into the truth; the point is their centre, weighted by force.
static void read_contact(plant_t* const plant, const dVector3 elbow_m)
{
    plant_truth_t* truth = &plant->truth;
    plant_load_t load[CONTOUR_POINTS];
    const unsigned count = contour_loads(plant, load);
    double weight        = 0.0;

    memset(truth->contact_force_n, 0, sizeof truth->contact_force_n);
    memset(truth->contact_point_m, 0, sizeof truth->contact_point_m);
    for (unsigned i = 0U; i < count; i++) {
        const double* force = load[i].force_n;
        const double size   = sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
        for (unsigned axis = 0U; axis < 3U; axis++) {
            truth->contact_force_n[axis] += force[axis];
            truth->contact_point_m[axis] += size * load[i].point_m[axis];
        }
        weight += size;
        add_external_torque(truth, elbow_m, &load[i]);
    }
    truth->in_contact = weight > 0.0;
    for (unsigned axis = 0U; axis < 3U; axis++) {
        truth->contact_point_m[axis] = truth->in_contact ? truth->contact_point_m[axis] / weight : 0.0;
    }
}

static NOT_INLINE void step_world(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    plant_truth_t* truth = &plant->truth;
    step_mechanisms(plant, input, dt_s);
    if (plant->options.free_base) {
        dWorldStep(plant->world, dt_s);
        read_links(plant);
        return;
    }

    dVector3 elbow;
    dJointGetHingeAnchor(plant->hinge[1], elbow);
    plant_load_t cable;
    memcpy(cable.point_m, truth->tip_m, sizeof cable.point_m);
    spring_force(&plant->parameters, &plant->spring, truth->tip_m, cable.force_n);
    memset(truth->external_torque_nm, 0, sizeof truth->external_torque_nm);
    add_external_torque(truth, elbow, &cable);
    memcpy(truth->spring_force_n, cable.force_n, sizeof truth->spring_force_n);
    truth->spring_hooked = plant->spring.hooked;
    dBodyAddForceAtPos(plant->link[PLANT_JOINTS - 1U], cable.force_n[0], cable.force_n[1], cable.force_n[2],
                       cable.point_m[0], cable.point_m[1], cable.point_m[2]);

    contour_touch(plant, dt_s);
    dWorldStep(plant->world, dt_s);
    read_contact(plant, elbow);
    read_links(plant);
}

void plant_step(plant_t* const plant, const plant_input_t* const input, const uint64_t dt_ns)
{
    // Out of the arm's plane ODE's velocities decay into denormals, which cost eight times the step. Machines
    // without this switch compute the same, only slower.
#if defined(__SSE2__)
    const unsigned mode = _mm_getcsr();
    _mm_setcsr(mode | DENORMALS_ARE_ZERO);
#endif
    step_world(plant, input, (double)dt_ns / NS_PER_S);
#if defined(__SSE2__)
    // Exception flags raised inside stay inside as well.
    _mm_setcsr(mode);
#endif
    plant->truth.time_ns += dt_ns;
}

const plant_truth_t* plant_truth(const plant_t* const plant)
{
    return &plant->truth;
}
