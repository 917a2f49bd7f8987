// SPDX-License-Identifier: Apache-2.0
/// Inside of the plant: the parts that share its state. Private to sim/plant.
#ifndef SIM_PLANT_PLANT_INTERNAL_H
#define SIM_PLANT_PLANT_INTERNAL_H

#include "sim/plant/plant.h"

#include <ode/ode.h>

typedef struct {
    dBodyID body[ROBOT_BODIES_MAX];           ///< Bodies of the model; null: fixed to the world.
    uint32_t moved_by[ROBOT_BODIES_MAX];      ///< Bit i: joint i of the robot moves this body.
    pose_t base;                              ///< Pose of body 0 at the start.
    unsigned first_joint;                     ///< plant_joint of its joint 0.
    double before_rad_s[ROBOT_BODIES_MAX][3]; ///< Rates of the bodies of a free robot before the last step.
} robot_t;

typedef struct {
    const robot_joint_t* model;
    const world_drive_t* drive_of; ///< Null: it has no drive.
    plant_drive_t drive;
    dJointID ode;
    dBodyID parent;        ///< Null: the world.
    double angle_rad;      ///< Last angle from ODE, for unwrapping.
    double start;          ///< Position at creation.
    bool is_axis_constant; ///< No joint turns the axis.
    double axis[3];        ///< In the world: constant, or as it was before the step.
    double anchor_m[3];    ///< A point of the axis before the step.
} joint_t;

/// A force on a body of a robot, and where it acts.
typedef struct {
    unsigned robot;
    unsigned body;
    double force_n[3];
    double point_m[3];
} load_t;

/// Cable spring: rests on its hook until the link picks it up.
typedef struct {
    bool hooked;
    bool below; ///< The link was below the hook in the last step, so it can pick the cable up.
} spring_t;

typedef struct {
    unsigned robot;
    unsigned body;
    double axis[3]; ///< In the body.
    double given_nms
        [3]; ///< Momentum, in the world: that at the start, plus what its link has given to it since.
} mounted_wheel_t;

typedef struct {
    dJointID joint;       ///< Null: it is open.
    double pressed_s;     ///< For how long its drive has pressed.
    double direction;     ///< Sign of that press.
    double closed_at_rad; ///< Position of the joint of its drive when it closed.
} latch_t;

#define MIMICS_MAX 8U

/// A joint that follows another of its robot: position = multiplier * position of the leader + offset.
typedef struct {
    unsigned joint; ///< Both as of plant_joint.
    unsigned leader;
    double multiplier;
    double offset;
    double force; ///< On the joint in the last step; -multiplier times this acts on the leader.
} mimic_t;

#define POINTS_PER_PAIR 8U ///< Contact points of two shapes at most.
#define PAIRS_MAX 64U      ///< Pairs of shapes that may touch.
#define SHAPES_MAX ((WORLD_ROBOTS_MAX * ROBOT_SHAPES_MAX) + (WORLD_FIXTURES_MAX * WORLD_FIXTURE_SHAPES_MAX))

/// A shape that may touch others.
typedef struct {
    const shape_t* shape;
    dGeomID geom;
    dGeomID side; ///< Capsule in place of a cylinder, for balls beside it.
    dBodyID body; ///< Null: it does not move.
    unsigned robot;
    unsigned body_index;
    double centre_m[3];   ///< From the centre of mass of its body.
    matrix_t rotation;    ///< In its body.
    double reach_m;       ///< Radius of a ball around it.
    double position_m[3]; ///< In the world, before the step.
} solid_t;

typedef struct {
    double normal[3];   ///< Into `a`.
    double along[2][3]; ///< Directions of friction.
    double point_m[3];
    dJointFeedback feedback;
} point_t;

/// Two shapes that may touch.
typedef struct {
    unsigned contact; ///< Index in the world.
    unsigned a;       ///< It moves; with is_swapped it belongs to side b of the contact.
    unsigned b;
    bool is_swapped;
    bool is_steep;  ///< Which directions of friction are used (contacts.c).
    unsigned count; ///< Contact points of the present step.
    point_t point[POINTS_PER_PAIR];
    double stretch_m[2]; ///< Deflection of the contact along the directions of friction; 0 without contact.
} pair_t;

typedef struct {
    dJointGroupID joints;
    solid_t solid[SHAPES_MAX];
    pair_t pair[PAIRS_MAX];
    size_t pair_count;
} contacts_t;

struct plant {
    const world_t* world;
    plant_truth_t truth;
    dWorldID ode;
    robot_t robot[WORLD_ROBOTS_MAX];
    joint_t joint[PLANT_JOINTS_MAX];
    contacts_t contacts;
    spring_t spring[WORLD_SPRINGS_MAX];
    mounted_wheel_t wheel[WORLD_WHEELS_MAX];
    latch_t latch[WORLD_LATCHES_MAX];
    mimic_t mimic[MIMICS_MAX];
    size_t mimic_count;
    char failure[PLANT_FAILURE_MAX]; ///< Empty: none.
};

/// Pose and motion of the root link of a robot at time 0.
typedef struct {
    pose_t pose;
    double velocity_m_s[3];
    double rate_rad_s[3];
} robot_start_t;

/// Start of a robot whose State is valid at its time, if nothing but gravity acts on it before.
void robot_start(const plant_t* plant, unsigned robot, robot_start_t* out_start);
/// Make the bodies and joints of all robots, in a fixed order: ODE's results depend on it. Statuses of
/// plant_create.
MUST_USE status_t robots_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// Positions and speeds of the joints from ODE into the truth; angles keep counting beyond half a turn.
void robots_read(plant_t* plant);
/// Add the gyroscopic torques of free robots for a step of dt_s.
void robots_spin(plant_t* plant, double dt_s);
/// At the start, and after a step that contained an impact: no rates before are known to robots_spin.
void robots_forget_rates(plant_t* plant);
/// Read the present axes and anchors of the joints from ODE.
void robots_look(plant_t* plant);
/// Position in the world of a point that is given in a frame of a robot.
void robot_point(const plant_t* plant, unsigned robot, unsigned body, const double in_body_m[3],
                 double out_m[3]);
/// Add J^T F of a load to the truth; robots_look was called before the step.
void robots_add_load(plant_t* plant, const load_t* load);

/// Position of a joint, from ODE, if it was at `before` when robots_read was called last.
double joint_position(const joint_t* joint, double before);

/// Check before a step of dt_s that no body has or gets an absurd speed: ODE would end the program by an
/// assertion. If one has, sets the failure and returns false.
bool plant_is_sound(plant_t* plant, double dt_s);

/// Find the mimics of all robots. Statuses of plant_create.
MUST_USE status_t mimics_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// dWorldStep in a world with mimics. ODE has no constraint of two joints, so each step finds the forces that
/// bring mimics and leaders together: trial steps from the same state tell how their speeds depend on them.
/// The forces are exact as long as no contact changes between the trial steps; the next step corrects.
void mimics_step(plant_t* plant, double dt_s);

/// Advance one rotor by h_s against gear torque, friction, brake and end stop; `torque_nm` is the motor's.
/// Returns the friction torque of this substep.
double joint_rotor_step(const plant_drive_t* drive, plant_rotor_t* rotor, bool brake, double torque_nm,
                        double gear_torque_nm, double h_s);

/// Advance one axis of a joystick by h_s under the sum of motor and hand torque.
void stick_step(const world_joystick_t* joystick, double torque_nm, double h_s, double* position_rad,
                double* velocity_rad_s);

/// Force of the cable on a link at `place_m`; picks up and lets go of the hook.
void spring_force(const world_spring_t* wire, spring_t* spring, const double place_m[3],
                  double out_force_n[3]);

/// Place the wheels on their links, with their momenta at the start.
void wheels_create(plant_t* plant);
/// Advance the momenta by one step under the torques of the input, and act on the links for this step.
void wheels_step(plant_t* plant, const plant_input_t* input, double dt_s);
/// Write the rates of the links about the axes of the wheels into the truth.
void wheels_read(plant_t* plant);
/// The axis of a wheel in the world.
void wheel_axis(const plant_t* plant, unsigned wheel, double out_axis[3]);

/// Close and open latches as their devices and the places of their links demand, before a step of dt_s.
/// Returns true if one has closed.
bool latches_step(plant_t* plant, const plant_input_t* input, double dt_s);
/// True if a closed latch connects these bodies; null: fixed to the world.
bool latches_connect(const plant_t* plant, dBodyID a, dBodyID b);

/// Make the shapes that the contacts of the world name. Statuses of plant_create.
MUST_USE status_t contacts_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// Free what contacts_create made.
void contacts_destroy(plant_t* plant);
/// Add the contact joints of the present pose, for one world step of dt_s.
void contacts_touch(plant_t* plant, double dt_s);
/// After the world step of dt_s: forces into the truth, contact joints removed.
void contacts_read(plant_t* plant, double dt_s);

#endif // SIM_PLANT_PLANT_INTERNAL_H
