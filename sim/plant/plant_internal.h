// SPDX-License-Identifier: Apache-2.0
/// State of the plant, and the functions of its parts. Private to sim/plant.
#ifndef SIM_PLANT_PLANT_INTERNAL_H
#define SIM_PLANT_PLANT_INTERNAL_H

#include "sim/plant/plant.h"

#include <ode/ode.h>

typedef struct {
    dBodyID body[ROBOT_BODIES_MAX];           ///< Bodies of the model; null: fixed to the world.
    uint32_t moved_by[ROBOT_BODIES_MAX];      ///< Bit i is set if joint i of the robot moves this body.
    pose_t base;                              ///< Pose of body 0 at the start.
    unsigned first_joint;                     ///< Index (plant_joint) of its joint 0.
    double before_rad_s[ROBOT_BODIES_MAX][3]; ///< Rates of the bodies of a free robot before the last step.
} robot_t;

typedef struct {
    const robot_joint_t* model;
    const world_drive_t* drive_of; ///< Null: the joint has no drive.
    plant_drive_t drive;
    dJointID ode;
    dBodyID parent;        ///< Null: the world.
    double angle_rad;      ///< Last angle from ODE, for unwrapping.
    double start;          ///< Position at creation.
    bool is_axis_constant; ///< No joint turns the axis.
    double axis[3];        ///< Axis in the world: constant, or its value before the step.
    double anchor_m[3];    ///< A point of the axis before the step.
} joint_t;

/// A force on a body of a robot, and the point at which it acts.
typedef struct {
    unsigned robot;
    unsigned body;
    double force_n[3];
    double point_m[3];
} load_t;

/// State of a cable spring, which rests on its hook until the link picks it up.
typedef struct {
    bool hooked;
    bool below; ///< The link was below the hook in the last step, so that it can pick up the cable.
} spring_t;

typedef struct {
    unsigned robot;
    unsigned body;
    double axis[3]; ///< In the body.
    /// Momentum in the axes of the world: that at the start, plus the reactions of its link since then.
    double momentum_nms[3];
} mounted_wheel_t;

typedef struct {
    dJointID joint;       ///< Null: the latch is open.
    double pressed_s;     ///< Time for which its drive has pressed.
    double direction;     ///< Sign of the force with which the drive presses.
    double closed_at_rad; ///< Position of the joint of its drive when it closed.
} latch_t;

#define MIMICS_MAX 8U

/// A joint that follows another of its robot: position = multiplier * position of the leader + offset.
typedef struct {
    unsigned joint;  ///< Index (plant_joint).
    unsigned leader; ///< Index (plant_joint) of the joint that it follows.
    double multiplier;
    double offset;
    double force; ///< Force on the joint in the last step; -multiplier times this force acts on the leader.
} mimic_t;

#define POINTS_PER_PAIR 8U ///< Most contact points of two shapes.
#define PAIRS_MAX 64U      ///< Most pairs of shapes that may touch.
#define SHAPES_MAX ((WORLD_ROBOTS_MAX * ROBOT_SHAPES_MAX) + (WORLD_FIXTURES_MAX * WORLD_FIXTURE_SHAPES_MAX))

/// A shape that may touch others.
typedef struct {
    const shape_t* shape;
    dGeomID geom;
    dGeomID side; ///< Capsule that replaces a cylinder for contacts with spheres at its side.
    dBodyID body; ///< Null: the shape does not move.
    unsigned robot;
    unsigned body_index;
    double centre_m[3];   ///< Position relative to the centre of mass of its body.
    matrix_t rotation;    ///< Rotation relative to its body.
    double reach_m;       ///< Radius of a ball around it.
    double position_m[3]; ///< Position in the world, before the step.
} solid_t;

typedef struct {
    double normal[3];   ///< Normal of the surface, directed into `a`.
    double along[2][3]; ///< Directions of friction.
    double point_m[3];
    dJointFeedback feedback;
} point_t;

/// Two shapes that may touch.
typedef struct {
    unsigned contact; ///< Index in the world.
    unsigned a;       ///< Shape that moves; if is_swapped, it belongs to side b of the contact.
    unsigned b;
    bool is_swapped;
    bool is_steep;  ///< Selects the directions of friction (contacts.c).
    unsigned count; ///< Contact points of the present step.
    point_t point[POINTS_PER_PAIR];
    double stretch_m[2]; ///< Deflection of the contact along the directions of friction; 0 without contact.
} pair_t;

typedef struct {
    dJointGroupID joints;
    solid_t solid[SHAPES_MAX];
    solid_t* moving[SHAPES_MAX]; ///< The shapes of links that move.
    size_t moving_count;
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

/// Compute the motion at time 0 of a robot whose State is valid at a later time; until then only gravity acts
/// on it.
void robot_start(const plant_t* plant, unsigned robot, robot_start_t* out_start);
/// Make the bodies and joints of all robots, in a fixed order: ODE's results depend on it. Statuses of
/// plant_create.
MUST_USE status_t robots_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// Copy positions and speeds of the joints from ODE to the truth; angles are not limited to half a turn.
void robots_read(plant_t* plant);
/// Add the gyroscopic torques of free robots for a step of dt_s.
void robots_add_gyroscopic_torques(plant_t* plant, double dt_s);
/// Called at the start, and after a step with an impact: robots_add_gyroscopic_torques must not extrapolate
/// from earlier rates.
void robots_forget_rates(plant_t* plant);
/// Read the present axes and anchors of the joints from ODE.
void robots_read_axes(plant_t* plant);
/// Position in the world of a point that is given in a frame of a robot.
void robot_point(const plant_t* plant, unsigned robot, unsigned body, const double in_body_m[3],
                 double out_m[3]);
/// Add J^T F of a load to the truth; robots_read_axes was called before the step.
void robots_add_load(plant_t* plant, const load_t* load);

/// Returns the position of a joint, from ODE, unwrapped from its position `before`, which robots_read has
/// read last.
double joint_position(const joint_t* joint, double before);

/// Check before a step of dt_s that no body has or gets a speed above the limits of soundness.c: for such a
/// speed ODE would end the program by an assertion. If a body has or gets one, set the failure and return
/// false.
bool plant_is_sound(plant_t* plant, double dt_s);

/// Find the mimics of all robots. Statuses of plant_create.
MUST_USE status_t mimics_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// dWorldStep in a world with mimics. ODE has no constraint between two joints. Therefore trial steps from
/// the same state determine how the speeds depend on forces between mimics and leaders, and the step is made
/// with the forces for which the mimics follow. They are exact if no contact changes between the trial steps;
/// otherwise the next step corrects the error.
void mimics_step(plant_t* plant, double dt_s);

/// Advance one rotor by h_s against gear torque, friction, brake and end stop; `torque_nm` is the motor's.
/// Returns the friction torque of this substep.
double joint_rotor_step(const plant_drive_t* drive, plant_rotor_t* rotor, bool brake, double torque_nm,
                        double gear_torque_nm, double h_s);

/// Advance one axis of a joystick by h_s under the sum of motor and hand torque.
void stick_step(const world_joystick_t* joystick, double torque_nm, double h_s, double* position_rad,
                double* velocity_rad_s);

/// Force of the cable on a link at `place_m`. Updates whether the link has picked up the hook.
void spring_force(const world_spring_t* cable, spring_t* spring, const double place_m[3],
                  double out_force_n[3]);

/// Place the wheels on their links, with their momenta at the start.
void wheels_create(plant_t* plant);
/// Advance the momenta by one step under the torques of the input, and apply the reactions to the links.
void wheels_step(plant_t* plant, const plant_input_t* input, double dt_s);
/// Write the rates of the links about the axes of the wheels into the truth.
void wheels_read(plant_t* plant);
/// The axis of a wheel in the world.
void wheel_axis(const plant_t* plant, unsigned wheel, double out_axis[3]);

/// Close and open latches, depending on their devices and the positions of their links, before a step of
/// dt_s. Returns true if a latch has closed.
bool latches_step(plant_t* plant, const plant_input_t* input, double dt_s);
/// True if a closed latch connects these bodies; a null body is fixed to the world.
bool latches_connect(const plant_t* plant, dBodyID a, dBodyID b);

/// Make the shapes that the contacts of the world name. Statuses of plant_create.
MUST_USE status_t contacts_create(plant_t* plant, char error[DOCUMENT_ERROR_MAX]);
/// Free the objects that contacts_create has made.
void contacts_destroy(plant_t* plant);
/// Add the contact joints of the present pose, for one world step of dt_s.
void contacts_touch(plant_t* plant, double dt_s);
/// Called after the world step of dt_s: copy forces to the truth, and remove the contact joints.
void contacts_read(plant_t* plant, double dt_s);

#endif // SIM_PLANT_PLANT_INTERNAL_H
