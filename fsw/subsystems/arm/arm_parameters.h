// SPDX-License-Identifier: Apache-2.0
/// Parameters of the subsystem ARM. Their names, types and order are fixed. The number of joints of an arm
/// is the number of devices of its configurations; it determines the lengths of the lists in the descriptor.
/// No header is generated for an arm; instead its descriptor is checked here when the program starts. Single
/// values of CUR_VALUES may also be separate parameters, for services that accept scalars only: TORQUE_2 is
/// the second value of TORQUE.
///
/// Units      The descriptor gives the unit of each value; for prismatic joints see arm_model.h.
/// Ownership  The caller provides the structures.
/// Context    Any.
#ifndef FSW_SUBSYSTEMS_ARM_ARM_PARAMETERS_H
#define FSW_SUBSYSTEMS_ARM_ARM_PARAMETERS_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/parameter/parameter.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "fsw/subsystems/arm/arm_hand.h"
#include "fsw/subsystems/arm/arm_model.h"
#include "fsw/subsystems/arm/arm_path.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // CUR_VALUES
    int32_t state;
    double position_rad[ARM_JOINTS_MAX];
    double velocity_rad_s[ARM_JOINTS_MAX];
    double torque_nm[ARM_JOINTS_MAX];
    double command[ARM_JOINTS_MAX]; ///< Position mode: motor angles [rad]; torque mode: torques [Nm].
    double desired_rad[ARM_JOINTS_MAX];
    double tool_position_m[3];
    double tool_rotation_rad[3]; ///< Rotation vector in the frame of the base.
    double tool_error[2];        ///< Distance and angle between the measured and the desired pose [m, rad].
    double tool_force_n[3];      ///< Force on the tool, in the axes of the base.
    uint16_t statusword[ARM_JOINTS_MAX];
} arm_cur_values_t;

typedef struct { // LIMITS, settable
    double lower[ARM_JOINTS_MAX];
    double upper[ARM_JOINTS_MAX];
    double speed[ARM_JOINTS_MAX];
    double acceleration[ARM_JOINTS_MAX];
    double torque[ARM_JOINTS_MAX];
    double tool_speed;
    double tool_acceleration;
    double tool_rate;
    double tool_angular_acceleration;
    double tolerance;
} arm_limit_values_t;

typedef struct { // CONTROL, settable
    double kp[ARM_JOINTS_MAX];
    double kd[ARM_JOINTS_MAX];
    double velocity_bandwidth;
    double friction_share;
    double fade_time;
    double singular_limit;
    double singular_damping;
    /// In torque mode, virtual springs and dampers hold the tool; the joints are not position-controlled.
    bool is_compliant;
    double tool_stiffness[6];
    double tool_damping[6];
    double joint_damping;
    /// Gain of the feedback of joint torques while the tool is compliant; it divides friction by 1 + gain.
    double torque_gain;
} arm_control_values_t;

typedef struct { // GEOMETRY
    double origin[3U * ARM_JOINTS_MAX];
    double rpy[3U * ARM_JOINTS_MAX];
    double axis[3U * ARM_JOINTS_MAX];
    double tool[3];
    double tool_rpy[3];
    /// If the descriptor does not have this member, all joints are revolute.
    bool is_prismatic[ARM_JOINTS_MAX];
} arm_geometry_values_t;

typedef struct { // MASSES
    double mass[ARM_JOINTS_MAX];
    double centre[3U * ARM_JOINTS_MAX];
    double inertia[6U * ARM_JOINTS_MAX]; ///< ixx, ixy, ixz, iyy, iyz, izz of each link.
    double gravity[3];
} arm_mass_values_t;

typedef struct {                          // DRIVES
    double rotor_inertia[ARM_JOINTS_MAX]; ///< Inertia of the rotor, referred to the joint side of the gear.
    double stiffness[ARM_JOINTS_MAX];     ///< Stiffness of gear and torque sensor; 0: rigid.
    double coulomb[ARM_JOINTS_MAX];
    double viscous[ARM_JOINTS_MAX];
} arm_drive_values_t;

typedef struct { // COUNTERS
    uint32_t cycles;
    uint32_t frames_received;
    uint32_t frames_sent;
    uint32_t pdo_missed[ARM_JOINTS_MAX];
    uint32_t emergencies;
    uint32_t command_limited;
    uint32_t tc_refused;
    uint32_t parameter_refused;
} arm_counter_values_t;

typedef struct {          // TELEPRESENCE, settable
    double directions[6]; ///< Direction of the tool for each axis of the hand, in the axes of the base.
    double position_scale;
    double dead_band;
    double range;
    double bandwidth;
    double force_scale;
    double force_bandwidth;
    double tare_limit; ///< Largest zero of a torque sensor, as a share of the torque limit of the joint.
} arm_telepresence_values_t;

typedef struct { // HAND
    double position_rad[ARM_HAND_AXES];
    double offset_m[ARM_HAND_AXES]; ///< Desired offset from the pose in which the hand was coupled.
    uint8_t state;                  ///< State of the hand (arm_hand_state_t).
} arm_hand_values_t;

typedef struct {
    arm_cur_values_t cur_values;
    arm_limit_values_t limits;
    arm_control_values_t control;
    arm_geometry_values_t geometry;
    arm_mass_values_t masses;
    arm_drive_values_t drives;
    arm_counter_values_t counters;
    arm_telepresence_values_t telepresence;
    arm_hand_values_t hand;
} arm_parameters_t;

#define ARM_PARAMETERS 9U         ///< Number of structures.
#define ARM_SCALARS 48U           ///< Largest number of additional scalars: single values of CUR_VALUES.
#define ARM_FIELDS 66U            ///< Number of fields of all structures together.
#define ARM_PARAMETER_COUNTERS 6U ///< Indices in the definitions.
#define ARM_PARAMETER_TELEPRESENCE 7U

typedef struct { // Private.
    size_t count;
    parameter_field_t fields[ARM_FIELDS + ARM_SCALARS];
    parameter_definition_t definitions[ARM_PARAMETERS + ARM_SCALARS];
    size_t offsets[ARM_PARAMETERS + ARM_SCALARS];
} arm_definitions_t;

/// Returns the number of joints of the arm; 0 if the descriptor has no configuration.
unsigned arm_joint_count(const subsystem_descriptor_t* descriptor);
/// True if the descriptor has exactly these parameters, and possibly single values of CUR_VALUES; otherwise
/// *out_misfit is the first difference.
bool arm_parameters_fit(const subsystem_descriptor_t* descriptor, subsystem_misfit_t* out_misfit);
/// Create the definitions of the parameters of a descriptor that has been accepted; their storage is an
/// arm_parameters_t.
void arm_definitions_create(arm_definitions_t* definitions, const subsystem_descriptor_t* descriptor);

/// Compute the model of the arm from the parameters. STATUS_INVALID if an axis has no direction, or a mass, a
/// rotor inertia or a stiffness is negative; the model is then not set.
status_t arm_model_of_parameters(const arm_parameters_t* parameters, unsigned joint_count,
                                 arm_model_t* out_model);
/// Compute the limits of motions, and the settings of telepresence, from the parameters.
void arm_limits_of_parameters(const arm_parameters_t* parameters, unsigned joint_count,
                              arm_limits_t* out_limits);
void arm_hand_settings_of_parameters(const arm_parameters_t* parameters, arm_hand_settings_t* out_settings);

#endif // FSW_SUBSYSTEMS_ARM_ARM_PARAMETERS_H
