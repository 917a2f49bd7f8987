// SPDX-License-Identifier: Apache-2.0
/// The physics of a world (sim/world/world.h): its robots, contacts, cable springs, latches and joysticks.
///
/// ODE (Open Dynamics Engine) steps bodies, joints and contacts (dWorldStep). Rotors, gears, friction, brakes
/// and joysticks are integrated PLANT_SUBSTEPS times per step outside of ODE, because they are stiff.
///
/// Joints     A Drive of the world moves its joint by a rotor and an elastic gear; its end stops act on the
///            rotor. Other joints have no friction, follow the caller's torque and stop hard at their limits.
/// Wheels     A wheel is modelled as an angular momentum about an axis of its link, without a body.
/// Indices    Of joints: plant_joint; of contacts, springs and joysticks: those in the world.
/// Units      For a prismatic joint, read m, N and kg where names contain rad, Nm and kgm2.
/// Ownership  plant_create allocates, plant_destroy frees. The world outlives the plant. Any number of plants
///            may exist in one process; one thread steps a given plant.
/// Results    Bit-identical if the same calls are repeated. During a step denormal numbers count as zero; the
///            step restores the floating point mode of the caller.
/// Time       About 3 us per step of 0.5 ms for two joints with a contact.
#ifndef SIM_PLANT_PLANT_H
#define SIM_PLANT_PLANT_H

#include "sim/plant/sensor.h"
#include "sim/world/world.h"

#include <stdbool.h>
#include <stdint.h>

#define PLANT_JOINTS_MAX (WORLD_ROBOTS_MAX * ROBOT_JOINTS_MAX)
#define PLANT_AXES_MAX 8U ///< Axes of a joystick.
#define PLANT_FAILURE_MAX 512U
#define PLANT_SUBSTEPS 4U ///< Rotor steps per plant step: 8 kHz at 0.5 ms.

/// Motor, gear, brake and end stops of a joint, referred to the joint.
typedef struct {
    double gear_ratio;            ///< N: motor turns per joint turn.
    double rotor_inertia_kgm2;    ///< J_motor N^2.
    double gear_stiffness_nm_rad; ///< Harmonic drive and torque sensor in series.
    double gear_damping_nms_rad;  ///< Damping parallel to the stiffness.
    double coulomb_nm;            ///< Friction of the moving rotor.
    double stiction_nm;           ///< Friction at zero speed, >= coulomb_nm.
    double stribeck_rad_s;        ///< Speed at which half of stiction_nm - coulomb_nm remains.
    double viscous_nms_rad;       ///< Friction growing with speed.
    torque_ripple_t ripple;       ///< Torque ripple of motor and gear, acting on the rotor.
    double brake_torque_nm;       ///< Largest torque of the holding brake.
    double lower_rad;             ///< Position of the end stops.
    double upper_rad;
    double stop_nm_rad; ///< Stiffness of the end stops, acting on the rotor.
    double stop_nms_rad;
} plant_drive_t;

/// Motor of a joint, referred to the joint (motor angle / N). For a joint without a Drive these are the
/// values of the joint itself.
typedef struct {
    double position_rad;
    double velocity_rad_s;
} plant_rotor_t;

/// Function of the operator's hand on a joystick. It is called before each rotor step (substep 0 ..
/// PLANT_SUBSTEPS-1) and writes the torque of the hand on each axis of the stick.
typedef void (*plant_hand_t)(void* context, unsigned substep, const double* stick_position_rad,
                             const double* stick_velocity_rad_s, double* out_torque_nm);

/// A reaction wheel. Its momentum is that of the rotor about its axis relative to the world, so it includes
/// the rotation of the link.
typedef struct {
    double momentum_nms;
    double torque_nm;     ///< Torque on the rotor in the last step, limited by torque and momentum.
    double housing_rad_s; ///< Rate of the link that carries the wheel, about the axis of the wheel.
} plant_wheel_t;

/// Inputs of the world during one step.
typedef struct {
    /// Called before each rotor step; computes the torque of each motor on the joint side for that substep.
    /// Null: the motors have no current.
    void (*drive)(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm);
    void* drive_context;
    plant_hand_t hand[WORLD_JOYSTICKS_MAX]; ///< Null: no hand on that joystick.
    void* hand_context[WORLD_JOYSTICKS_MAX];
    bool brake_engaged[PLANT_JOINTS_MAX]; ///< Holding brake of the rotor, during the whole step.
    bool valve_open[WORLD_VALVES_MAX];    ///< Valves that are open during the whole step.
    /// Motor torques of the joysticks, during the whole step.
    double stick_torque_nm[WORLD_JOYSTICKS_MAX][PLANT_AXES_MAX];
    double wheel_torque_nm[WORLD_WHEELS_MAX]; ///< Motor torques of the wheels, during the whole step.
    bool latch_on[WORLD_LATCHES_MAX];         ///< Output of the valve box that closes each latch.
} plant_input_t;

/// State of a Contact of the world.
typedef struct {
    double place_m[3]; ///< Origin of its link `a`.
    bool is_touching;
    double point_m[3]; ///< Centre of the contact points, weighted by force; zero without contact.
    double force_n[3]; ///< Force on link `a`, sum over all points.
} plant_contact_t;

/// State of a CableSpring of the world.
typedef struct {
    double place_m[3]; ///< Origin of the link that pulls the cable.
    bool is_hooked;
    double force_n[3]; ///< On the link, at its origin.
} plant_spring_t;

typedef struct {
    double position_rad[PLANT_AXES_MAX];
    double velocity_rad_s[PLANT_AXES_MAX];
    double torque_nm[PLANT_AXES_MAX];      ///< Motor torque of the input.
    double hand_torque_nm[PLANT_AXES_MAX]; ///< Mean over the step.
} plant_stick_t;

/// The root link of a robot with a free base, or another frame, in the axes of the world.
typedef struct {
    double position_m[3];
    double rotation[4]; ///< Unit quaternion: w, x, y, z.
    double velocity_m_s[3];
    double rate_rad_s[3];
} plant_base_t;

/// The true state at the end of the last step; forces are those of the last step.
typedef struct {
    uint64_t time_ns;
    unsigned joint_count;
    plant_rotor_t motor[PLANT_JOINTS_MAX];
    double link_position_rad[PLANT_JOINTS_MAX];
    double link_velocity_rad_s[PLANT_JOINTS_MAX];
    /// Motor torque that the drives have computed, mean over the step.
    double motor_torque_nm[PLANT_JOINTS_MAX];
    double joint_torque_nm[PLANT_JOINTS_MAX]; ///< Gear torque on the link, as the sensor measures it.
    double friction_nm[PLANT_JOINTS_MAX];     ///< Friction on the rotor, brake included; opposes motion.
    bool brake_engaged[PLANT_JOINTS_MAX];
    double external_torque_nm[PLANT_JOINTS_MAX]; ///< J^T F of contacts and springs, at their true points.
    plant_contact_t contact[WORLD_CONTACTS_MAX];
    plant_spring_t spring[WORLD_SPRINGS_MAX];
    plant_stick_t stick[WORLD_JOYSTICKS_MAX];
    plant_wheel_t wheel[WORLD_WHEELS_MAX];
    bool valve_open[WORLD_VALVES_MAX];  ///< Valves of the input.
    bool is_latched[WORLD_LATCHES_MAX]; ///< The latch is closed: a fixed joint at the pose of its closing.
    unsigned base_count;                ///< Robots with a free base, in the order of the world.
    plant_base_t base[WORLD_ROBOTS_MAX];
} plant_truth_t;

typedef struct plant plant_t;

/// Create the plant of a world in its start pose, with relaxed gears and sticks at zero. Returns STATUS_OK;
/// else *out_plant is null and `error` is filled: STATUS_INVALID (file and line of an element that the plant
/// does not support), STATUS_EXHAUSTED.
MUST_USE status_t plant_create(const world_t* world, plant_t** out_plant, char error[DOCUMENT_ERROR_MAX]);

/// Free the world. Null is allowed.
void plant_destroy(plant_t* plant);

/// Advance by dt_ns (500 000 in the missions; tests use other values).
void plant_step(plant_t* plant, const plant_input_t* input, uint64_t dt_ns);

/// Returns the reason for which the world diverges: body, time, and parameters to check. From then on
/// plant_step has no effect. Null if the world does not diverge.
const char* plant_failure(const plant_t* plant);

/// Returns the state after the last step; valid until plant_destroy, updated by each plant_step.
const plant_truth_t* plant_truth(const plant_t* plant);

/// Pose and motion of the frame of a link of a robot, at the end of the last step.
void plant_frame(const plant_t* plant, unsigned robot, unsigned frame, plant_base_t* out_frame);

/// Returns the index of a joint of a robot of the world.
unsigned plant_joint(const world_t* world, unsigned robot, unsigned joint);

#endif // SIM_PLANT_PLANT_H
