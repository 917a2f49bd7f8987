// SPDX-License-Identifier: Apache-2.0
/// Reader of worlds (descriptors/worlds/<mission>.xml, schema descriptors/schema/world.xsd): the robots of a
/// mission, the objects around them, and the devices on each bus with the objects that they move or measure.
///
/// A name must be defined before it is used. Joints and links are named robot.joint and robot.link. The
/// reader refuses, with file and line: unknown elements and attributes, values outside their range, unknown
/// or repeated names, two devices with the same node id on a bus, two drives of one joint.
///
/// Ownership  The caller provides world_t; it has no pointers.
/// Context    One task.
#ifndef SIM_WORLD_WORLD_H
#define SIM_WORLD_WORLD_H

#include "base/status.h"
#include "sim/world/document.h"
#include "sim/world/robot_model.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WORLD_PATH_MAX 256U
#define WORLD_BUSES_MAX 8U
#define WORLD_ROBOTS_MAX 4U
#define WORLD_DRIVE_TYPES_MAX 12U
#define WORLD_DRIVES_MAX 24U
#define WORLD_BENCHES_MAX 64U
#define WORLD_FIXTURES_MAX 8U
#define WORLD_FIXTURE_SHAPES_MAX 8U
#define WORLD_CONTACTS_MAX 16U
#define WORLD_SPRINGS_MAX 8U
#define WORLD_JOYSTICKS_MAX 2U
#define WORLD_HANDS_MAX 1U
#define WORLD_POWER_UNITS_MAX 1U
#define WORLD_INSTRUMENTS_MAX 16U
#define WORLD_WHEELS_MAX 8U
#define WORLD_VALVE_BOXES_MAX 4U
#define WORLD_VALVES_MAX 32U
#define WORLD_VALVE_OUTPUTS 16U ///< Outputs of a valve box.
#define WORLD_SENSORS_MAX 12U
#define WORLD_LATCHES_MAX 4U
#define WORLD_SUPPLIES_MAX 4U ///< Devices that one power unit supplies.

/// Largest differences of the true state at the start from the element State, along or about each axis; rates
/// are in the axes of the world.
typedef struct {
    double at;       ///< [m]
    double rpy;      ///< [rad]
    double velocity; ///< [m/s]
    double rate;     ///< [rad/s]
} world_start_spread_t;

/// Differences of the true parameters of one drive from those of its type, drawn from the seed.
typedef struct {
    double friction;  ///< Relative difference of coulomb, stiction and viscous friction.
    double stiffness; ///< Relative difference of the stiffness of its gear.
} world_drive_difference_t;

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    char urdf[DOCUMENT_TEXT_MAX];
    char base[DOCUMENT_TEXT_MAX];
    /// Line of the element in the file of the world.
    unsigned line;
    bool is_free; ///< The base is not fixed to the world.
    robot_model_t model;
    double start[ROBOT_JOINTS_MAX]; ///< Joint positions at time 0.
    double rate[ROBOT_JOINTS_MAX];  ///< Joint rates at time 0.
    pose_t pose;                    ///< Pose of the root link at `valid_ns`.
    /// Velocity of the root link at `valid_ns`; the robot moves as one rigid body then.
    double velocity_m_s[3];
    double rate_rad_s[3]; ///< In the axes of the world.
    /// Time of this pose and velocity. If it is not 0, the simulator computes from them those at time 0, with
    /// gravity only.
    double valid_ns;
    double spread_mass;    ///< Largest relative difference of the true mass of each body.
    double spread_inertia; ///< The same for its inertia, in addition to the difference of its mass.
    double spread_com;     ///< Largest difference of its centre of mass along each axis [m].
    world_start_spread_t spread_start;
} world_robot_t;

/// Motor, gear, sensors and brake of a joint.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    double ratio;            ///< Motor turns per joint turn.
    double rotor_inertia;    ///< Referred to the joint [kgm2].
    double stiffness;        ///< Gear and torque sensor in series [Nm/rad].
    double damping;          ///< Damping parallel to the stiffness [Nms/rad].
    double coulomb;          ///< [Nm]
    double stiction;         ///< At zero speed, >= coulomb [Nm].
    double stribeck;         ///< Speed at which half of stiction - coulomb remains [rad/s].
    double viscous;          ///< [Nms/rad]
    double brake;            ///< Largest torque of the holding brake, on the joint side [Nm].
    double stop_stiffness;   ///< Stiffness of the end stops, which act on the rotor [Nm/rad].
    double stop_damping;     ///< [Nms/rad]
    unsigned encoder_counts; ///< Counts per turn of the motor.
    double ripple;           ///< Amplitude of the periodic torque of motor and gear [Nm]; 0: no such torque.
    double ripple_periods;   ///< Periods per turn of the motor; 0 means 2.
    bool has_torque_sensor;
    double friction_spread;  ///< Largest relative difference of the friction of a drive.
    double stiffness_spread; ///< Largest relative difference of the stiffness of the gear of a drive.
    double torque_noise;     ///< Standard deviation [Nm].
    double torque_offset;    ///< Largest offset: drawn from +- this [Nm].
    double torque_drift;     ///< Largest drift: drawn from +- this [Nm/s].
    double torque_range;     ///< Readings saturate at +- this [Nm]; 0: there is no sensor.
    double torque_ripple;    ///< Amplitude of the periodic error [Nm]; 0: no such error.
    double torque_periods;   ///< Periods of this error per turn of the motor; 0 means 2.
} world_drive_type_t;

/// Attributes that every device has.
typedef struct {
    char name[DOCUMENT_TEXT_MAX]; ///< Name of the device in scenarios.
    char bus_name[DOCUMENT_TEXT_MAX];
    char eds[DOCUMENT_TEXT_MAX]; ///< File, in the directory of the EDS files.
    unsigned line;
    unsigned bus; ///< Index in world_t.bus.
    unsigned node;
} world_device_t;

typedef struct {
    world_device_t device;
    char joint_name[DOCUMENT_TEXT_MAX];
    char type_name[DOCUMENT_TEXT_MAX];
    unsigned robot;
    unsigned joint;
    unsigned type;
    double force; ///< Gripper: largest force of its motor on the joint [N]; 0: the element is a Drive.
    world_drive_difference_t difference;
} world_drive_t;

/// A drive on a test bench: its output touches an elastic object above a given angle.
typedef struct {
    world_device_t device;
    char type_name[DOCUMENT_TEXT_MAX];
    unsigned type;
    double contact;   ///< Angle above which the output touches the object [rad].
    double stiffness; ///< Stiffness of the object [Nm/rad]; 0: there is no object.
    double range;     ///< End stops at +- this [rad].
    world_drive_difference_t difference;
} world_bench_t;

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    double at[3];
    size_t shape_count;
    shape_t shape[WORLD_FIXTURE_SHAPES_MAX]; ///< Poses are relative to `at`.
} world_fixture_t;

/// A link of a robot, or a fixture.
typedef struct {
    bool is_fixture;
    unsigned robot;
    unsigned frame;
    unsigned fixture;
} world_side_t;

/// Contact between the collision shapes of a link and those of a fixture or of another link.
typedef struct {
    char a[DOCUMENT_TEXT_MAX];
    char b[DOCUMENT_TEXT_MAX];
    unsigned line;
    world_side_t side[2];
    double stiffness;     ///< Stiffness of two shapes along the normal [N/m].
    double damping;       ///< [Ns/m]
    double friction;      ///< Coefficient.
    double shear;         ///< Stiffness along the surface while friction holds [N/m]; 0: rigid.
    double shear_damping; ///< [Ns/m]
} world_contact_t;

/// A cable with a spring at its end; a link that passes the hook from below pulls it.
typedef struct {
    char on[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned robot;
    unsigned frame;
    double hook[3];   ///< Rest position of the hook in the world [m].
    double catch;     ///< Largest horizontal distance from the hook at which the link takes it [m].
    double length;    ///< Length of the relaxed cable, straight down from the hook [m].
    double stiffness; ///< [N/m]
    double preload;   ///< [N], reached over the first `travel` [m].
    double travel;
    double limit; ///< The hook slips off beyond this force [N].
} world_spring_t;

typedef struct {
    world_device_t device;
    unsigned axes;           ///< Always two; simulated joysticks have no others.
    double inertia;          ///< Inertia of each axis [kgm2].
    double friction;         ///< Viscous [Nms/rad].
    double range;            ///< End stops at +- this [rad].
    double stop_stiffness;   ///< [Nm/rad]
    double stop_damping;     ///< [Nms/rad]
    unsigned encoder_counts; ///< Counts per revolution.
} world_joystick_t;

/// The operator's hand on a joystick, with the operator's knowledge of the control of the robot. Without this
/// knowledge the operator does not know the scene either (sim/operator/scene.h).
typedef struct {
    char joystick_name[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned joystick;
    double stiffness; ///< Stiffness of the grip [Nm/rad].
    double damping;   ///< Damping of the grip [Nms/rad].
    bool knows_scene;
    double position_scale;  ///< Joint angle per stick angle.
    double force_scale;     ///< Stick torque per joint torque.
    double joint_stiffness; ///< Stiffness of a controlled joint [Nm/rad].
} world_hand_t;

typedef struct {
    world_device_t device; ///< A power unit has no EDS.
    size_t supply_count;
    char supply[WORLD_SUPPLIES_MAX][DOCUMENT_TEXT_MAX]; ///< Names of devices.
} world_power_unit_t;

/// A reaction wheel: an angular momentum about an axis of a link. The inertia of the link in its URDF
/// includes the wheel, except for its moment of inertia about the axis.
typedef struct {
    world_device_t device;
    char on[DOCUMENT_TEXT_MAX];
    unsigned robot;
    unsigned frame;
    double axis[3];         ///< In the frame of the link, of length 1.
    double momentum;        ///< Largest momentum, at the largest speed of its EDS [Nms].
    double torque;          ///< Largest torque of the motor [Nm].
    double start;           ///< Momentum at time 0 [Nms].
    double gain_spread;     ///< Largest relative difference of its torque from the commanded torque.
    double gain_difference; ///< The relative difference, drawn from the seed.
} world_wheel_t;

/// A CiA 401 module with outputs for valves (sim/devices/valve_box.h).
typedef struct {
    world_device_t device;
} world_valve_box_t;

/// A thruster and its valve: while the valve is open, the thruster pushes its link.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    char on[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned robot;
    unsigned frame;
    double at[3];        ///< In the link.
    double direction[3]; ///< Direction of the force on the link, in the link; length 1.
    double force;        ///< [N]
    double shortest_ns;  ///< Shortest pulse.
    unsigned box;
    unsigned output; ///< From 1.
} world_valve_t;

typedef enum {
    SENSOR_GYRO,
    SENSOR_STAR_TRACKER,
    SENSOR_POSE_CAMERA
} world_sensor_kind_t;

/// A sensor of motion, attitude or pose, in the frame of a link. Noise is a standard deviation.
typedef struct {
    world_device_t device;
    world_sensor_kind_t kind;
    char on[DOCUMENT_TEXT_MAX];
    unsigned robot;
    unsigned frame;
    double rate_hz;    ///< Exposures; 0: at each SYNC.
    double gyro_noise; ///< Noise of the rates of a gyro [rad/s].
    double bias;       ///< Bias of each axis of a gyro, drawn from +- this [rad/s].
    double noise[3];   ///< For a tracker, of the angles about its axes [rad]; for a camera, of positions [m].
    double angle_noise[3];        ///< Noise of the angles of a camera [rad].
    double at[3];                 ///< Position of a camera in the frame of the link [m].
    double rpy[3];                ///< [rad]
    double at_spread;             ///< Largest difference of the true mounting along each axis [m].
    double rpy_spread;            ///< The same about each axis [rad].
    char sees[DOCUMENT_TEXT_MAX]; ///< The link whose pose a camera measures.
    unsigned seen_robot;
    unsigned seen_frame;
    double delay_ns;
    double loss; ///< Probability that a pose is not found.
} world_sensor_t;

typedef enum {
    WORLD_LATCH_TOUCHED, ///< Closes by itself when the links are near, and stays closed.
    WORLD_LATCH_PRESSED, ///< Closes when a drive presses.
    WORLD_LATCH_WIRED    ///< Closes when an output of a valve box is on.
} world_latch_trigger_t;

/// Connects two links rigidly while it is closed. It closes only if their frames are near each other.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    char a[DOCUMENT_TEXT_MAX];
    char b[DOCUMENT_TEXT_MAX];
    char when[DOCUMENT_TEXT_MAX]; ///< Name of the device that closes it; "": none.
    unsigned line;
    world_side_t side[2];
    double distance; ///< Largest distance of the origins when it closes [m].
    double angle;    ///< Largest angle between the frames [rad].
    double speed;    ///< Largest speed of one origin relative to the other [m/s].
    world_latch_trigger_t trigger;
    unsigned drive;  ///< PRESSED: index in world_t.drive.
    double force;    ///< PRESSED: smallest gear torque or force that counts as pressing [Nm or N].
    double stall_ns; ///< PRESSED: the latch closes after this time of pressing.
    /// PRESSED: the latch opens when the joint has moved back by this distance [rad or m]; 0: it stays
    /// closed.
    double release;
    unsigned box;
    unsigned output; ///< WIRED: from 1.
} world_latch_t;

/// A simple axis that exchanges records over an end node (sim/devices/instrument.h).
typedef struct {
    char name[DOCUMENT_TEXT_MAX]; ///< Name of the axis in scenarios.
    char type_name[DOCUMENT_TEXT_MAX];
    char channel[DOCUMENT_TEXT_MAX];
    char framing[DOCUMENT_TEXT_MAX];
    char order[DOCUMENT_TEXT_MAX];
    char checksum[DOCUMENT_TEXT_MAX];
    char value_name[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned type;  ///< stream_port_kind_t.
    unsigned value; ///< instrument_value_t.
    bool is_slip;
    bool is_little;
    bool has_checksum;
    double period_ns;
    double scale; ///< value = raw * scale + offset, in both directions.
    double offset;
    double speed; ///< Largest change of the value in a second.
} world_instrument_t;

typedef struct {
    char path[WORLD_PATH_MAX];
    char name[DOCUMENT_TEXT_MAX];
    double step_ns;
    double gravity[3]; ///< In the axes of the world [m/s2].
    size_t bus_count;
    char bus[WORLD_BUSES_MAX][DOCUMENT_TEXT_MAX]; ///< In the order of their first device.
    size_t robot_count;
    world_robot_t robot[WORLD_ROBOTS_MAX];
    size_t drive_type_count;
    world_drive_type_t drive_type[WORLD_DRIVE_TYPES_MAX];
    size_t drive_count;
    world_drive_t drive[WORLD_DRIVES_MAX];
    size_t bench_count;
    world_bench_t bench[WORLD_BENCHES_MAX];
    size_t fixture_count;
    world_fixture_t fixture[WORLD_FIXTURES_MAX];
    size_t contact_count;
    world_contact_t contact[WORLD_CONTACTS_MAX];
    size_t spring_count;
    world_spring_t spring[WORLD_SPRINGS_MAX];
    size_t joystick_count;
    world_joystick_t joystick[WORLD_JOYSTICKS_MAX];
    size_t hand_count;
    world_hand_t hand[WORLD_HANDS_MAX];
    size_t power_unit_count;
    world_power_unit_t power_unit[WORLD_POWER_UNITS_MAX];
    size_t wheel_count;
    world_wheel_t wheel[WORLD_WHEELS_MAX];
    size_t valve_box_count;
    world_valve_box_t valve_box[WORLD_VALVE_BOXES_MAX];
    size_t valve_count;
    world_valve_t valve[WORLD_VALVES_MAX];
    size_t sensor_count;
    world_sensor_t sensor[WORLD_SENSORS_MAX];
    size_t latch_count;
    world_latch_t latch[WORLD_LATCHES_MAX];
    size_t instrument_count;
    world_instrument_t instrument[WORLD_INSTRUMENTS_MAX];
} world_t;

/// Read a world and the robots that it names. Statuses of document_read; the error names the file that
/// contains it.
MUST_USE status_t world_read(const char* path, world_t* out_world, char error[DOCUMENT_ERROR_MAX]);

#endif // SIM_WORLD_WORLD_H
