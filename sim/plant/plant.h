// SPDX-License-Identifier: Apache-2.0
/// The physical world: a two-joint arm in a vertical plane with a finger, a contour to touch, a cable
/// spring to pull, and the operator's two-axis force-feedback joystick.
///
/// Links, contour and contact live in an ODE world (dWorldStep). Rotors, gear elasticity, friction, brakes
/// and the joystick are integrated PLANT_SUBSTEPS times per step outside of ODE, because they are stiff.
///
/// Frame      x forward, z up, y = 0 is the plane of the arm, origin on the axis of joint 1. Joint angles are
///            geometric: tip = (l1 cos q1 + l2 cos(q1 + q2), 0, l1 sin q1 + l2 sin(q1 + q2)).
/// Ownership  plant_create allocates, plant_destroy frees. Parameters are copied. Any number of plants may
///            live in one process; one thread steps a given plant.
/// Results    Bit-identical in every repeat of the same calls: no clock, no thread, no random choice. The
///            floating point mode of the caller is untouched; inside a step denormals count as zero.
/// Time       About 3 us per step of 0.5 ms with contact.
#ifndef SIM_PLANT_PLANT_H
#define SIM_PLANT_PLANT_H

#include <stdbool.h>
#include <stdint.h>

#define PLANT_JOINTS 2U   ///< Joints of the arm.
#define PLANT_AXES 2U     ///< Axes of the joystick.
#define PLANT_SUBSTEPS 4U ///< Rotor steps per plant step: 8 kHz at 0.5 ms.

/// Motor, gear, brake and end stops of a joint, on the side of the joint.
typedef struct {
    double gear_ratio;            ///< N: motor turns per joint turn.
    double rotor_inertia_kgm2;    ///< J_motor N^2.
    double gear_stiffness_nm_rad; ///< Harmonic drive and torque sensor in series.
    double gear_damping_nms_rad;  ///< In parallel to the stiffness.
    double coulomb_nm;            ///< Friction of the moving rotor.
    double stiction_nm;           ///< Friction at zero speed, >= coulomb_nm.
    double stribeck_rad_s;        ///< Speed at which the excess of stiction has halved.
    double viscous_nms_rad;       ///< Friction growing with speed.
    double brake_torque_nm;       ///< What the holding brake can take.
    double lower_rad;             ///< Position of the end stops.
    double upper_rad;
    double stop_nm_rad; ///< Stiffness of the end stops, acting on the rotor.
    double stop_nms_rad;
} plant_drive_t;

/// Engineering values of the world; sim/plant/parameters.h takes them from its file.
typedef struct {
    double link_length_m[PLANT_JOINTS];
    double link_mass_kg[PLANT_JOINTS];
    double link_com_m[PLANT_JOINTS];        ///< Centre of mass from the joint, along the link.
    double link_inertia_kgm2[PLANT_JOINTS]; ///< About the centre of mass, across the link.
    double link_twist_kgm2[PLANT_JOINTS];   ///< About the long axis of the link.
    double base_mass_kg;                    ///< Only felt when the base is free.
    double base_inertia_kgm2;               ///< About any axis through the centre of mass; at joint 1.
    double home_rad[PLANT_JOINTS];          ///< Pose at creation.
    plant_drive_t drive[PLANT_JOINTS];
    double gravity_m_s2;           ///< Downwards, if switched on at creation.
    double tip_radius_m;           ///< Metal finger: a sphere around the tip.
    double contour_top_m;          ///< Height of the flat part.
    double contour_start_m;        ///< First x of the contour.
    double contour_end_m;          ///< Last x of the contour.
    double contour_depth_m;        ///< Thickness of the flat part.
    double contour_width_m;        ///< Across the plane.
    double bump_x_m;               ///< Top of the bump.
    double bump_height_m;          ///< Above the flat part.
    double bump_radius_m;          ///< A cylinder across the plane.
    double contour_stiffness_n_m;  ///< Normal contact stiffness.
    double contour_damping_ns_m;   ///< Normal contact damping.
    double contour_friction;       ///< Coulomb coefficient, finger on contour.
    double hook_m[2];              ///< x, z of the spring's hook at rest.
    double hook_catch_m;           ///< The finger must pass the hook within this distance in x.
    double cable_m;                ///< Rest length of the cable, straight down from the hook.
    double spring_stiffness_n_m;   ///< Beyond the preload.
    double spring_preload_n;       ///< Reached over the first spring_preload_m.
    double spring_preload_m;       ///< Travel that builds up the preload.
    double spring_limit_n;         ///< The hook slips off beyond this force.
    double stick_inertia_kgm2;     ///< Each axis.
    double stick_friction_nms_rad; ///< Viscous, each axis.
    double stick_range_rad;        ///< End stop at +- range.
    double stick_stop_nm_rad;      ///< Stiffness of the end stop.
    double stick_stop_nms_rad;     ///< Damping of the end stop.
} plant_parameters_t;

/// Differences between two worlds of the same robot.
typedef struct {
    bool gravity;                ///< Laboratory (true) or orbit (false).
    bool free_base;              ///< Base floats instead of being bolted to the world.
    double base_velocity_m_s[3]; ///< Initial, whole assembly; only with free_base.
    double base_rate_rad_s[3];   ///< Initial, whole assembly; only with free_base.
    uint32_t seed;               ///< Passed to ODE, although it has no effect on dWorldStep.
} plant_options_t;

/// Motor of a joint, referred to the joint (motor angle / N).
typedef struct {
    double position_rad;
    double velocity_rad_s;
} plant_rotor_t;

/// Inputs of the world during one step.
typedef struct {
    /// Called before each rotor step (substep 0 .. PLANT_SUBSTEPS-1): the torque of each motor on the joint
    /// side for that substep. May be null: motors without current.
    void (*drive)(void* context, unsigned substep, const plant_rotor_t motor[PLANT_JOINTS],
                  double out_torque_nm[PLANT_JOINTS]);
    void* drive_context;
    /// Called before each rotor step: torque of the operator's hand on the stick. May be null: no hand.
    void (*hand)(void* context, unsigned substep, const double stick_position_rad[PLANT_AXES],
                 const double stick_velocity_rad_s[PLANT_AXES], double out_torque_nm[PLANT_AXES]);
    void* hand_context;
    bool brake_engaged[PLANT_JOINTS];   ///< Holding brake of the rotor, during the whole step.
    double stick_torque_nm[PLANT_AXES]; ///< Motor torque of the joystick, during the whole step.
} plant_input_t;

/// The true state at the end of the last step; forces are those of the last step.
typedef struct {
    uint64_t time_ns;
    plant_rotor_t motor[PLANT_JOINTS];
    double link_position_rad[PLANT_JOINTS];
    double link_velocity_rad_s[PLANT_JOINTS];
    double motor_torque_nm[PLANT_JOINTS]; ///< Mean over the step, as the drives gave it.
    double joint_torque_nm[PLANT_JOINTS]; ///< Gear torque on the link, as the sensor measures it.
    double friction_nm[PLANT_JOINTS];     ///< On the rotor, brake included; opposes motion.
    bool brake_engaged[PLANT_JOINTS];
    double tip_m[3];           ///< Centre of the finger's sphere.
    bool in_contact;           ///< Finger on the contour.
    double contact_point_m[3]; ///< On the sphere's surface; zero without contact.
    double contact_force_n[3]; ///< On the finger, sum over all contact points.
    bool spring_hooked;
    double spring_force_n[3];                ///< On the finger, at the tip.
    double external_torque_nm[PLANT_JOINTS]; ///< J^T F of contact and spring, at their true points.
    double stick_position_rad[PLANT_AXES];
    double stick_velocity_rad_s[PLANT_AXES];
    double stick_torque_nm[PLANT_AXES]; ///< Motor torque of the joystick as given.
    double hand_torque_nm[PLANT_AXES];  ///< Mean over the step.
} plant_truth_t;

typedef struct plant plant_t;

/// A world at rest in its home pose, gears relaxed, brakes as in the input of the first step, stick at zero.
/// Returns null when memory is out.
plant_t* plant_create(const plant_parameters_t* parameters, const plant_options_t* options);

/// Free the world. Null is allowed.
void plant_destroy(plant_t* plant);

/// Advance by dt_ns (500 000 in the mission; tests use others).
void plant_step(plant_t* plant, const plant_input_t* input, uint64_t dt_ns);

/// State after the last step; valid until plant_destroy, renewed by each plant_step.
const plant_truth_t* plant_truth(const plant_t* plant);

#endif // SIM_PLANT_PLANT_H
