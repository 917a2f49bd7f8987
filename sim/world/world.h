// SPDX-License-Identifier: Apache-2.0
/// Reader of worlds (descriptors/worlds/<mission>.xml, schema descriptors/schema/world.xsd): the robots of a
/// mission, what is around them, and which device on which bus moves or measures what.
///
/// A name is defined before it is used. Joints and links are named robot.joint and robot.link. Refused, with
/// file and line: unknown elements and attributes, values outside their range, unknown or repeated names, two
/// devices with one node id on a bus, two drives of one joint.
///
/// Ownership  The caller places world_t; it has no pointers.
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
#define WORLD_DRIVE_TYPES_MAX 8U
#define WORLD_DRIVES_MAX 24U
#define WORLD_BENCHES_MAX 16U
#define WORLD_FIXTURES_MAX 8U
#define WORLD_FIXTURE_SHAPES_MAX 8U
#define WORLD_CONTACTS_MAX 16U
#define WORLD_SPRINGS_MAX 8U
#define WORLD_JOYSTICKS_MAX 2U
#define WORLD_HANDS_MAX 1U
#define WORLD_POWER_UNITS_MAX 1U
#define WORLD_SUPPLIES_MAX 4U ///< Of a power unit.

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    char urdf[DOCUMENT_TEXT_MAX];
    char base[DOCUMENT_TEXT_MAX];
    unsigned line;
    bool is_free; ///< Not bolted to the world.
    robot_model_t model;
    double start[ROBOT_JOINTS_MAX]; ///< Joint positions at time 0.
} world_robot_t;

/// Motor, gear, sensors and brake of a joint.
typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    double ratio;            ///< Motor turns per joint turn.
    double rotor_inertia;    ///< Referred to the joint [kgm2].
    double stiffness;        ///< Gear and torque sensor in series [Nm/rad].
    double damping;          ///< In parallel to the stiffness [Nms/rad].
    double coulomb;          ///< [Nm]
    double stiction;         ///< At zero speed, >= coulomb [Nm].
    double stribeck;         ///< Speed at which the excess of stiction has halved [rad/s].
    double viscous;          ///< [Nms/rad]
    double brake;            ///< What the holding brake can take, on the joint side [Nm].
    double stop_stiffness;   ///< Of the joint's end stops, acting on the rotor [Nm/rad].
    double stop_damping;     ///< [Nms/rad]
    unsigned encoder_counts; ///< Per turn of the motor.
    bool has_torque_sensor;
    double torque_noise;  ///< Standard deviation [Nm].
    double torque_offset; ///< Drawn from +- this [Nm].
    double torque_drift;  ///< Drawn from +- this [Nm/s].
    double torque_range;  ///< Readings saturate at +- this [Nm].
} world_drive_type_t;

/// What every device has.
typedef struct {
    char name[DOCUMENT_TEXT_MAX]; ///< Its name in scenarios.
    char bus_name[DOCUMENT_TEXT_MAX];
    char eds[DOCUMENT_TEXT_MAX]; ///< File, in the folder of the EDS files.
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
} world_drive_t;

/// A drive on a table: its output touches an elastic object from an angle on.
typedef struct {
    world_device_t device;
    char type_name[DOCUMENT_TEXT_MAX];
    unsigned type;
    double contact;   ///< [rad]
    double stiffness; ///< Stiffness of the object [Nm/rad]; 0: there is no object.
    double range;     ///< End stops at +- this [rad].
} world_bench_t;

typedef struct {
    char name[DOCUMENT_TEXT_MAX];
    unsigned line;
    double at[3];
    size_t shape_count;
    shape_t shape[WORLD_FIXTURE_SHAPES_MAX]; ///< Poses are relative to `at`.
} world_fixture_t;

/// Collision shapes of a link against a fixture.
typedef struct {
    char a[DOCUMENT_TEXT_MAX];
    char b[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned robot;
    unsigned frame;
    unsigned fixture;
    double stiffness; ///< [N/m]
    double damping;   ///< [Ns/m]
    double friction;
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
    unsigned axes;
    double inertia;  ///< Inertia of each axis [kgm2].
    double friction; ///< Viscous [Nms/rad].
    double range;    ///< End stops at +- this [rad].
    double stop_stiffness;
    double stop_damping;
    unsigned encoder_counts;
} world_joystick_t;

/// The operator's hand on a joystick, with what he has learned of the robot's control.
typedef struct {
    char joystick_name[DOCUMENT_TEXT_MAX];
    unsigned line;
    unsigned joystick;
    double stiffness;       ///< Stiffness of the grip [Nm/rad].
    double damping;         ///< Damping of the grip [Nms/rad].
    double position_scale;  ///< Joint angle per stick angle.
    double force_scale;     ///< Stick torque per joint torque.
    double joint_stiffness; ///< Stiffness of a controlled joint [Nm/rad].
} world_hand_t;

typedef struct {
    world_device_t device; ///< No EDS.
    size_t supply_count;
    char supply[WORLD_SUPPLIES_MAX][DOCUMENT_TEXT_MAX]; ///< Names of devices.
} world_power_unit_t;

typedef struct {
    char path[WORLD_PATH_MAX];
    char name[DOCUMENT_TEXT_MAX];
    double step_ns;
    double gravity[3];
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
} world_t;

/// Read a world and the robots that it names. Statuses of document_read; the error names the file at fault.
MUST_USE status_t world_read(const char* path, world_t* out_world, char error[DOCUMENT_ERROR_MAX]);

#endif // SIM_WORLD_WORLD_H
