// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world.h"

#include "sim/world/world_attitude.h"
#include "sim/world/world_contact.h"
#include "sim/world/world_instrument.h"
#include "sim/world/world_internal.h"
#include "sim/world/world_latch.h"
#include "sim/world/world_state.h"
#include "sim/world/world_valve.h"

#include <stdio.h>
#include <string.h>

#define LEVELS 3U       // Largest depth of elements in a world.
#define PERIODS_MAX 1e3 // Most periods of a ripple per turn of a motor.

typedef struct kind kind_t;

typedef struct {
    world_t* world;
    const kind_t* open[LEVELS]; // Open elements, by depth.
    uint64_t seen[LEVELS];      // Of each open element: kinds of the elements inside it so far, as bits.
    unsigned depth;
} reader_t;

/// A kind of element: the record for its attributes, and the functions that process them.
struct kind {
    const char* name;
    const char* parent; // Name of the parent element; "": the document.
    const field_t* fields;
    size_t field_count;
    size_t array; // Offset of the array of records in world_t.
    size_t stride;
    size_t count; // Offset of the number of records in world_t.
    size_t most;
    /// Called when the attributes are in the record. May be null.
    status_t (*finish)(world_t* world, const element_t* element, void* record);
    /// For elements without an array in world_t: processes the element instead of the members above. Else
    /// null.
    status_t (*take)(world_t* world, const element_t* element);
    bool is_single; // At most one in its parent.
    /// Called at the end of the element. May be null.
    status_t (*close)(const world_t* world, const element_t* element);
};

// ---- Elements ----

static const field_t world_fields[] = {
    NAME(world_t, "name", name),
    {"step", FIELD_TIME, offsetof(world_t, step_ns), 1e5, 1e7, false},
    {"gravity", FIELD_VECTOR, offsetof(world_t, gravity), -100.0, 100.0, false}};

static status_t take_world(world_t* const world, const element_t* const element)
{
    const status_t status = element_take(element, world_fields, COUNT_OF(world_fields), world);
    return ((status == STATUS_OK) && !world_is_lower_name(world->name, WORLD_NAME_MAX))
               ? element_refuse(element, world->name, "a lower-case name of at most 32 characters")
               : status;
}

static const field_t robot_fields[] = {NAME(world_robot_t, "name", name), TEXT(world_robot_t, "urdf", urdf),
                                       NAME(world_robot_t, "base", base)};

/// Set the start positions of the mimics from those of their leaders. Returns the first mimic that is then
/// outside of its limits, or null.
static const robot_joint_t* start_mimics(world_robot_t* const robot)
{
    const robot_joint_t* outside = NULL;
    for (size_t i = 0U; i < robot->model.joint_count; i++) {
        const robot_joint_t* joint = &robot->model.joint[i];
        if (joint->is_mimic) {
            const double start    = (joint->multiplier * robot->start[joint->leader]) + joint->offset;
            const bool is_bounded = joint->kind != ROBOT_JOINT_CONTINUOUS;
            const bool is_outside = is_bounded && ((start < joint->lower) || (start > joint->upper));
            robot->start[i]       = start;
            outside               = (is_outside && (outside == NULL)) ? joint : outside;
        }
    }
    return outside;
}

static status_t finish_robot(world_t* const world, const element_t* const element, void* const record)
{
    world_robot_t* robot = record;
    char path[WORLD_PATH_MAX + DOCUMENT_TEXT_MAX];
    const char* slash   = strrchr(world->path, '/');
    const int directory = (slash != NULL) ? (int)(slash - world->path) + 1 : 0;
    robot->line         = element->line;
    robot->is_free      = strcmp(robot->base, "free") == 0;
    robot->pose         = pose_of((const double[3]){0.0}, (const double[3]){0.0});
    if (!robot->is_free && (strcmp(robot->base, "fixed") != 0)) {
        return element_refuse(element, robot->base, "base fixed or free");
    }
    for (size_t i = 0U; (i + 1U) < world->robot_count; i++) {
        if (strcmp(world->robot[i].name, robot->name) == 0) {
            return element_refuse(element, robot->name, "a name that no robot above has");
        }
    }
    (void)snprintf(path, sizeof path, "%.*s%s", directory, world->path, robot->urdf);
    const status_t status = robot_model_read(path, &robot->model, element->error);
    if (status == STATUS_NOT_FOUND) {
        return element_refuse(element, robot->urdf, "a URDF file in the directory of the world");
    }
    if ((status == STATUS_OK) && robot->is_free && (robot->model.body[0].mass_kg == 0.0)) {
        return element_refuse(element, robot->name, "a free base that has a mass");
    }
    (void)start_mimics(robot); // Limits are checked only for the positions of a Start element.
    return status;
}

/// Read an element whose attributes have the names of joints of the robot. `limit` is the largest magnitude
/// of each number; if it is 0, the limits of the joints apply.
static status_t take_joints(const world_robot_t* const robot, const element_t* const element,
                            const double limit, double out_value[ROBOT_JOINTS_MAX])
{
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        const char* name   = element->attributes[i];
        const char* number = element->attributes[i + 1U];
        const size_t index = robot_model_joint(&robot->model, name);
        if (index == robot->model.joint_count) {
            return element_refuse(element, name, "a joint of this robot that moves");
        }
        const robot_joint_t* joint = &robot->model.joint[index];
        const bool is_bounded      = (limit == 0.0) && (joint->kind != ROBOT_JOINT_CONTINUOUS);
        const double most          = (limit == 0.0) ? TURNS_RAD : limit;
        if (joint->is_mimic) {
            return element_refuse(element, name, "a joint that is not itself a mimic");
        }
        if (!document_number(number, is_bounded ? joint->lower : -most, is_bounded ? joint->upper : most,
                             &out_value[index])) {
            return element_refuse(element, number,
                                  (limit == 0.0) ? "a number inside of the limits of the joint"
                                                 : "a number from -1000 to 1000");
        }
    }
    return STATUS_OK;
}

static status_t take_start(world_t* const world, const element_t* const element)
{
    world_robot_t* robot         = &world->robot[world->robot_count - 1U];
    const status_t status        = take_joints(robot, element, 0.0, robot->start);
    const robot_joint_t* outside = start_mimics(robot);
    return ((status != STATUS_OK) || (outside == NULL))
               ? status
               : element_refuse(element, outside->name, "a mimic that starts inside of its limits");
}

static status_t take_start_rate(world_t* const world, const element_t* const element)
{
    world_robot_t* robot  = &world->robot[world->robot_count - 1U];
    const status_t status = take_joints(robot, element, TURNS_RAD, robot->rate);
    for (size_t i = 0U; i < robot->model.joint_count; i++) {
        const robot_joint_t* joint = &robot->model.joint[i];
        robot->rate[i] = joint->is_mimic ? (joint->multiplier * robot->rate[joint->leader]) : robot->rate[i];
    }
    return status;
}

static const field_t drive_type_fields[] = {
    NAME(world_drive_type_t, "name", name),
    NUMBER(world_drive_type_t, "ratio", ratio, 0.01, 1e5),
    NUMBER(world_drive_type_t, "rotorInertia", rotor_inertia, 1e-9, GREAT),
    NUMBER(world_drive_type_t, "stiffness", stiffness, 1.0, GREAT),
    NUMBER(world_drive_type_t, "damping", damping, 0.0, GREAT),
    NUMBER(world_drive_type_t, "coulomb", coulomb, 0.0, GREAT),
    NUMBER(world_drive_type_t, "stiction", stiction, 0.0, GREAT),
    NUMBER(world_drive_type_t, "stribeck", stribeck, 1e-6, GREAT),
    NUMBER(world_drive_type_t, "viscous", viscous, 0.0, GREAT),
    NUMBER(world_drive_type_t, "brake", brake, 0.0, GREAT),
    NUMBER(world_drive_type_t, "stopStiffness", stop_stiffness, 0.0, GREAT),
    NUMBER(world_drive_type_t, "stopDamping", stop_damping, 0.0, GREAT),
    UNSIGNED(world_drive_type_t, "encoderCounts", encoder_counts, 1.0, 4294967295.0),
    OPTIONAL(world_drive_type_t, "ripple", ripple, 0.0, GREAT),
    OPTIONAL(world_drive_type_t, "ripplePeriods", ripple_periods, 1e-3, PERIODS_MAX),
    OPTIONAL(world_drive_type_t, "frictionSpread", friction_spread, 0.0, SHARE_MAX),
    OPTIONAL(world_drive_type_t, "stiffnessSpread", stiffness_spread, 0.0, SHARE_MAX)};

static status_t finish_drive_type(world_t* const world, const element_t* const element, void* const record)
{
    world_drive_type_t* type = record;
    type->line               = element->line;
    for (size_t i = 0U; (i + 1U) < world->drive_type_count; i++) {
        if (strcmp(world->drive_type[i].name, type->name) == 0) {
            return element_refuse(element, type->name, "a name that no DriveType above has");
        }
    }
    return (type->stiction >= type->coulomb) ? STATUS_OK
                                             : element_refuse(element, element_attribute(element, "stiction"),
                                                              "a stiction of at least coulomb");
}

static status_t take_torque_sensor(world_t* const world, const element_t* const element)
{
    static const field_t fields[] = {
        NUMBER(world_drive_type_t, "noise", torque_noise, 0.0, GREAT),
        NUMBER(world_drive_type_t, "offset", torque_offset, 0.0, GREAT),
        NUMBER(world_drive_type_t, "drift", torque_drift, 0.0, GREAT),
        NUMBER(world_drive_type_t, "range", torque_range, 1e-9, GREAT),
        OPTIONAL(world_drive_type_t, "ripple", torque_ripple, 0.0, GREAT),
        OPTIONAL(world_drive_type_t, "ripplePeriods", torque_periods, 1e-3, PERIODS_MAX)};
    world_drive_type_t* type = &world->drive_type[world->drive_type_count - 1U];
    type->has_torque_sensor  = true;
    return element_take(element, fields, COUNT_OF(fields), type);
}

static const field_t drive_fields[] = {ADDRESS(world_drive_t), TEXT(world_drive_t, "eds", device.eds),
                                       TEXT(world_drive_t, "joint", joint_name),
                                       NAME(world_drive_t, "type", type_name)};

static status_t finish_drive(world_t* const world, const element_t* const element, void* const record)
{
    world_drive_t* drive = record;
    const char* name     = world_find_robot(world, drive->joint_name, &drive->robot);
    if (name != NULL) {
        drive->joint = (unsigned)robot_model_joint(&world->robot[drive->robot].model, name);
    }
    if ((name == NULL) || (drive->joint == world->robot[drive->robot].model.joint_count)) {
        return element_refuse(element, drive->joint_name, "robot.joint of a robot above");
    }
    if (world->robot[drive->robot].model.joint[drive->joint].is_mimic) {
        return element_refuse(element, drive->joint_name, "a joint that is not itself a mimic");
    }
    for (const world_drive_t* other = world->drive; other < drive; other++) {
        if ((other->robot == drive->robot) && (other->joint == drive->joint)) {
            return element_refuse(element, drive->joint_name, "a joint that no drive above moves");
        }
    }
    const status_t status = world_find_type(world, element, drive->type_name, &drive->type);
    return (status == STATUS_OK) ? world_take_device(world, element, &drive->device) : status;
}

static const field_t gripper_fields[] = {
    ADDRESS(world_drive_t), TEXT(world_drive_t, "eds", device.eds), TEXT(world_drive_t, "joint", joint_name),
    NAME(world_drive_t, "type", type_name), NUMBER(world_drive_t, "force", force, 1e-6, GREAT)};

/// Complete a Gripper, which is the drive of a joint that other joints mimic.
static status_t finish_gripper(world_t* const world, const element_t* const element, void* const record)
{
    const world_drive_t* drive = record;
    const status_t status      = finish_drive(world, element, record);
    const robot_model_t* model = &world->robot[drive->robot].model;
    bool is_mimicked           = false;
    for (size_t i = 0U; (status == STATUS_OK) && (i < model->joint_count); i++) {
        is_mimicked = is_mimicked || (model->joint[i].is_mimic && (model->joint[i].leader == drive->joint));
    }
    return ((status == STATUS_OK) && !is_mimicked)
               ? element_refuse(element, drive->joint_name, "the joint of a finger that other fingers mimic")
               : status;
}

static const field_t bench_fields[] = {ADDRESS(world_bench_t),
                                       TEXT(world_bench_t, "eds", device.eds),
                                       NAME(world_bench_t, "type", type_name),
                                       NUMBER(world_bench_t, "contact", contact, -10.0, 10.0),
                                       NUMBER(world_bench_t, "stiffness", stiffness, 0.0, 1e5),
                                       NUMBER(world_bench_t, "range", range, 1e-3, TURNS_RAD)};

static status_t finish_bench(world_t* const world, const element_t* const element, void* const record)
{
    world_bench_t* bench  = record;
    const status_t status = world_find_type(world, element, bench->type_name, &bench->type);
    return (status == STATUS_OK) ? world_take_device(world, element, &bench->device) : status;
}

static const field_t fixture_fields[] = {NAME(world_fixture_t, "name", name),
                                         VECTOR(world_fixture_t, "at", at)};

static status_t finish_fixture(world_t* const world, const element_t* const element, void* const record)
{
    world_fixture_t* fixture = record;
    fixture->line            = element->line;
    for (const world_fixture_t* other = world->fixture; other < fixture; other++) {
        if (strcmp(other->name, fixture->name) == 0) {
            return element_refuse(element, fixture->name, "a name that no Fixture above has");
        }
    }
    return STATUS_OK;
}

static status_t close_fixture(const world_t* const world, const element_t* const element)
{
    const world_fixture_t* fixture = &world->fixture[world->fixture_count - 1U];
    return (fixture->shape_count > 0U)
               ? STATUS_OK
               : document_refuse(element->path, fixture->line, fixture->name,
                                 "a Box, Sphere or Cylinder inside of the Fixture", element->error);
}

static status_t take_shape(world_t* const world, const element_t* const element)
{
    typedef struct {
        shape_t shape;
        double at[3];
        double rpy[3];
    } placed_t;
    static const field_t rpy = {"rpy", FIELD_VECTOR, offsetof(placed_t, rpy), -TURNS_RAD, TURNS_RAD, true};
    const field_t box[]      = {{"size", FIELD_VECTOR, offsetof(placed_t, shape.size_m), 1e-6, FAR_M, false},
                                VECTOR(placed_t, "at", at),
                                rpy};
    const field_t sphere[]   = {NUMBER(placed_t, "radius", shape.radius_m, 1e-6, FAR_M),
                                VECTOR(placed_t, "at", at)};
    const field_t cylinder[] = {NUMBER(placed_t, "radius", shape.radius_m, 1e-6, FAR_M),
                                NUMBER(placed_t, "length", shape.length_m, 1e-6, FAR_M),
                                VECTOR(placed_t, "at", at), rpy};
    const struct {
        const char* name;
        const field_t* fields;
        size_t count;
    } kinds_of_shape[]       = {[SHAPE_BOX]      = {"Box", box, COUNT_OF(box)},
                                [SHAPE_SPHERE]   = {"Sphere", sphere, COUNT_OF(sphere)},
                                [SHAPE_CYLINDER] = {"Cylinder", cylinder, COUNT_OF(cylinder)}};
    world_fixture_t* fixture = &world->fixture[world->fixture_count - 1U];
    shape_kind_t kind        = SHAPE_BOX;
    while ((kind < SHAPE_CYLINDER) && (strcmp(element->name, kinds_of_shape[kind].name) != 0)) {
        kind++;
    }
    placed_t placed = {.shape = {.kind = kind}};
    if (fixture->shape_count == WORLD_FIXTURE_SHAPES_MAX) {
        return element_refuse(element, "one more shape", "at most 8");
    }
    const status_t status =
        element_take(element, kinds_of_shape[kind].fields, kinds_of_shape[kind].count, &placed);
    placed.shape.pose                    = pose_of(placed.at, placed.rpy);
    fixture->shape[fixture->shape_count] = placed.shape;
    fixture->shape_count++;
    return status;
}

static const field_t joystick_fields[] = {
    ADDRESS(world_joystick_t),
    TEXT(world_joystick_t, "eds", device.eds),
    UNSIGNED(world_joystick_t, "axes", axes, 2.0, 2.0),
    NUMBER(world_joystick_t, "inertia", inertia, 1e-9, GREAT),
    NUMBER(world_joystick_t, "friction", friction, 0.0, GREAT),
    NUMBER(world_joystick_t, "range", range, 1e-6, TURNS_RAD),
    NUMBER(world_joystick_t, "stopStiffness", stop_stiffness, 0.0, GREAT),
    NUMBER(world_joystick_t, "stopDamping", stop_damping, 0.0, GREAT),
    UNSIGNED(world_joystick_t, "encoderCounts", encoder_counts, 1.0, 4294967295.0)};

static status_t finish_joystick(world_t* const world, const element_t* const element, void* const record)
{
    return world_take_device(world, element, &((world_joystick_t*)record)->device);
}

static const field_t hand_fields[] = {NAME(world_hand_t, "joystick", joystick_name),
                                      NUMBER(world_hand_t, "stiffness", stiffness, 1e-3, GREAT),
                                      NUMBER(world_hand_t, "damping", damping, 0.0, GREAT),
                                      OPTIONAL(world_hand_t, "positionScale", position_scale, 1e-3, 1e3),
                                      OPTIONAL(world_hand_t, "forceScale", force_scale, 1e-9, 1e3),
                                      OPTIONAL(world_hand_t, "jointStiffness", joint_stiffness, 1e-3, GREAT)};

static status_t finish_hand(world_t* const world, const element_t* const element, void* const record)
{
    world_hand_t* hand = record;
    hand->line         = element->line;
    while ((hand->joystick < world->joystick_count) &&
           (strcmp(world->joystick[hand->joystick].device.name, hand->joystick_name) != 0)) {
        hand->joystick++;
    }
    hand->knows_scene = (hand->position_scale > 0.0);
    if (((hand->force_scale > 0.0) != hand->knows_scene) ||
        ((hand->joint_stiffness > 0.0) != hand->knows_scene)) {
        return element_refuse(element, "Hand",
                              "all of positionScale, forceScale and jointStiffness, or none");
    }
    return (hand->joystick < world->joystick_count)
               ? STATUS_OK
               : element_refuse(element, hand->joystick_name, "a Joystick above");
}

static const field_t power_unit_fields[] = {ADDRESS(world_power_unit_t)};

static status_t finish_power_unit(world_t* const world, const element_t* const element, void* const record)
{
    return world_take_device(world, element, &((world_power_unit_t*)record)->device);
}

static status_t close_power_unit(const world_t* const world, const element_t* const element)
{
    const world_power_unit_t* unit = &world->power_unit[world->power_unit_count - 1U];
    return (unit->supply_count > 0U) ? STATUS_OK
                                     : document_refuse(element->path, unit->device.line, unit->device.name,
                                                       "a Supply inside of the PowerUnit", element->error);
}

/// True if a power unit supplies the device.
static bool is_supplied(const world_t* const world, const char* const device)
{
    for (size_t i = 0U; i < world->power_unit_count; i++) {
        const world_power_unit_t* unit = &world->power_unit[i];
        for (size_t k = 0U; k < unit->supply_count; k++) {
            if (strcmp(unit->supply[k], device) == 0) {
                return true;
            }
        }
    }
    return false;
}

static status_t take_supply(world_t* const world, const element_t* const element)
{
    typedef struct {
        char device[DOCUMENT_TEXT_MAX];
    } supply_t;
    static const field_t fields[] = {NAME(supply_t, "device", device)};
    world_power_unit_t* unit      = &world->power_unit[world->power_unit_count - 1U];
    supply_t supply;
    const world_device_t* device = NULL;
    const status_t status        = element_take(element, fields, COUNT_OF(fields), &supply);
    if (status != STATUS_OK) {
        return status;
    }
    if (unit->supply_count == WORLD_SUPPLIES_MAX) {
        return element_refuse(element, supply.device, "at most 4 devices");
    }
    if (is_supplied(world, supply.device)) {
        return element_refuse(element, supply.device, "a device that no Supply above has");
    }
    for (size_t i = 0U; (device = world_device_at(world, i)) != NULL; i++) {
        if ((device->eds[0] != '\0') && (strcmp(device->name, supply.device) == 0)) {
            memcpy(unit->supply[unit->supply_count], supply.device, sizeof supply.device);
            unit->supply_count++;
            return STATUS_OK;
        }
    }
    return element_refuse(element, supply.device, "a device above");
}

// ---- The file ----

#define CLOSED(element, fields, member, most, finish, close)                                                 \
    {                                                                                                        \
        element, "World", fields, COUNT_OF(fields), offsetof(world_t, member),                               \
            sizeof(((world_t*)NULL)->member[0]), offsetof(world_t, member##_count), most, finish, NULL,      \
            false, close                                                                                     \
    }
#define RECORDS(element, fields, member, most, finish) CLOSED(element, fields, member, most, finish, NULL)
#define PART(element, parent, take)                                                                          \
    {                                                                                                        \
        element, parent, NULL, 0U, 0U, 0U, 0U, 0U, NULL, take, false, NULL                                   \
    }
#define SINGLE(element, parent, take)                                                                        \
    {                                                                                                        \
        element, parent, NULL, 0U, 0U, 0U, 0U, 0U, NULL, take, true, NULL                                    \
    }

static const kind_t kinds[] = {
    PART("World", "", take_world),
    RECORDS("Robot", robot_fields, robot, WORLD_ROBOTS_MAX, finish_robot),
    RECORDS("DriveType", drive_type_fields, drive_type, WORLD_DRIVE_TYPES_MAX, finish_drive_type),
    RECORDS("Drive", drive_fields, drive, WORLD_DRIVES_MAX, finish_drive),
    RECORDS("Gripper", gripper_fields, drive, WORLD_DRIVES_MAX, finish_gripper),
    RECORDS("Bench", bench_fields, bench, WORLD_BENCHES_MAX, finish_bench),
    CLOSED("Fixture", fixture_fields, fixture, WORLD_FIXTURES_MAX, finish_fixture, close_fixture),
    RECORDS("Contact", world_contact_fields, contact, WORLD_CONTACTS_MAX, world_contact_finish),
    RECORDS("CableSpring", world_spring_fields, spring, WORLD_SPRINGS_MAX, world_spring_finish),
    RECORDS("Joystick", joystick_fields, joystick, WORLD_JOYSTICKS_MAX, finish_joystick),
    RECORDS("Hand", hand_fields, hand, WORLD_HANDS_MAX, finish_hand),
    CLOSED("PowerUnit", power_unit_fields, power_unit, WORLD_POWER_UNITS_MAX, finish_power_unit,
           close_power_unit),
    {"Wheel", "World", world_wheel_fields, WORLD_WHEEL_FIELDS, offsetof(world_t, wheel),
     sizeof(world_wheel_t), offsetof(world_t, wheel_count), WORLD_WHEELS_MAX, world_wheel_finish, NULL, false,
     NULL},
    {"ValveBox", "World", world_valve_box_fields, WORLD_VALVE_BOX_FIELDS, offsetof(world_t, valve_box),
     sizeof(world_valve_box_t), offsetof(world_t, valve_box_count), WORLD_VALVE_BOXES_MAX,
     world_valve_box_finish, NULL, false, NULL},
    {"Gyro", "World", world_gyro_fields, WORLD_GYRO_FIELDS, offsetof(world_t, sensor), sizeof(world_sensor_t),
     offsetof(world_t, sensor_count), WORLD_SENSORS_MAX, world_gyro_finish, NULL, false, NULL},
    {"StarTracker", "World", world_tracker_fields, WORLD_TRACKER_FIELDS, offsetof(world_t, sensor),
     sizeof(world_sensor_t), offsetof(world_t, sensor_count), WORLD_SENSORS_MAX, world_tracker_finish, NULL,
     false, NULL},
    {"PoseCamera", "World", world_camera_fields, WORLD_CAMERA_FIELDS, offsetof(world_t, sensor),
     sizeof(world_sensor_t), offsetof(world_t, sensor_count), WORLD_SENSORS_MAX, world_camera_finish, NULL,
     false, NULL},
    {"Instrument", "World", world_instrument_fields, WORLD_INSTRUMENT_FIELDS, offsetof(world_t, instrument),
     sizeof(world_instrument_t), offsetof(world_t, instrument_count), WORLD_INSTRUMENTS_MAX,
     world_instrument_finish, NULL, false, NULL},
    {"Latch", "World", world_latch_fields, WORLD_LATCH_FIELDS, offsetof(world_t, latch),
     sizeof(world_latch_t), offsetof(world_t, latch_count), WORLD_LATCHES_MAX, world_latch_finish, NULL,
     false, NULL},
    SINGLE("State", "Robot", world_take_state),
    SINGLE("Spread", "Robot", world_take_spread),
    SINGLE("Start", "Robot", take_start),
    SINGLE("StartRate", "Robot", take_start_rate),
    SINGLE("TorqueSensor", "DriveType", take_torque_sensor),
    PART("Box", "Fixture", take_shape),
    PART("Sphere", "Fixture", take_shape),
    PART("Cylinder", "Fixture", take_shape),
    PART("Supply", "PowerUnit", take_supply),
    PART("Valve", "ValveBox", world_valve_take)};

static status_t refuse_kind(const element_t* const element, const char* const parent)
{
    char expected[200] = "no element inside of this one";
    size_t used        = 0U;
    for (size_t i = 0U; (i < COUNT_OF(kinds)) && (used < sizeof expected); i++) {
        if (strcmp(kinds[i].parent, parent) == 0) {
            const int more = snprintf(&expected[used], sizeof expected - used, "%s%s",
                                      (used == 0U) ? "" : " ", kinds[i].name);
            used += (more > 0) ? (size_t)more : 0U;
        }
    }
    return element_refuse(element, element->name, expected);
}

static status_t take_element(reader_t* const reader, const element_t* const element, const kind_t* const kind)
{
    world_t* world = reader->world;
    if (kind->take != NULL) {
        return kind->take(world, element);
    }
    size_t* count = (size_t*)(void*)((char*)world + kind->count);
    if (*count == kind->most) {
        char expected[40];
        (void)snprintf(expected, sizeof expected, "at most %u of them", (unsigned)kind->most);
        return element_refuse(element, element->name, expected);
    }
    void* record = (char*)world + kind->array + (*count * kind->stride);
    (*count)++;
    const status_t status = element_take(element, kind->fields, kind->field_count, record);
    return (status == STATUS_OK) ? kind->finish(world, element, record) : status;
}

/// Open an element, which is then the innermost one, and process it.
static status_t open_element(reader_t* const reader, const element_t* const element, const size_t kind)
{
    const uint64_t bit = (uint64_t)1U << kind;
    bool is_repeated   = false;
    if (reader->depth > 0U) {
        uint64_t* seen = &reader->seen[reader->depth - 1U];
        is_repeated    = kinds[kind].is_single && ((*seen & bit) != 0U);
        *seen |= bit;
    }
    reader->open[reader->depth] = &kinds[kind];
    reader->seen[reader->depth] = 0U;
    reader->depth++;
    return is_repeated ? element_refuse(element, element->name, "only one of these in its parent")
                       : take_element(reader, element, &kinds[kind]);
}

static status_t on_start(void* const context, const element_t* const element, bool* const out_is_skipped)
{
    reader_t* reader   = context;
    const char* parent = (reader->depth == 0U) ? "" : reader->open[reader->depth - 1U]->name;
    (void)out_is_skipped;
    for (size_t i = 0U; i < COUNT_OF(kinds); i++) {
        if ((strcmp(kinds[i].name, element->name) == 0) && (strcmp(kinds[i].parent, parent) == 0)) {
            return open_element(reader, element, i);
        }
    }
    return refuse_kind(element, parent);
}

static status_t on_end(void* const context, const element_t* const element)
{
    reader_t* reader = context;
    reader->depth--;
    const kind_t* kind = reader->open[reader->depth];
    return (kind->close != NULL) ? kind->close(reader->world, element) : STATUS_OK;
}

status_t world_read(const char* const path, world_t* const out_world, char error[DOCUMENT_ERROR_MAX])
{
    reader_t reader                  = {.world = out_world};
    const document_handler_t handler = {.start = on_start, .end = on_end, .context = &reader};
    memset(out_world, 0, sizeof *out_world);
    if (strlen(path) >= sizeof out_world->path) {
        (void)snprintf(error, DOCUMENT_ERROR_MAX, "%.100s...: a path of at most 255 octets", path);
        return STATUS_TOO_LARGE;
    }
    memcpy(out_world->path, path, strlen(path) + 1U);
    return document_read(path, &handler, error);
}
