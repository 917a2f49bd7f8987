// SPDX-License-Identifier: Apache-2.0
/// The simulator's truth as an LCM event log, stamped with simulated time: the figures of a run are computed
/// against it. Two runs of one seed give the same file, octet for octet.
///
/// Types are the .lcm files in the folder of this header; encoding follows LCM's wire format. Channels and
/// rates are in sim/truth/README.md. Writing costs about 0.4 us per event, without waiting for the disk.
///
/// Ownership  truth_open allocates, truth_close frees and flushes.
#ifndef SIM_TRUTH_TRUTH_H
#define SIM_TRUTH_TRUTH_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TRUTH_JOINTS 2
#define TRUTH_AXES 2

typedef struct truth truth_t;

/// Create or overwrite the log. Returns STATUS_OK or STATUS_IO (then *out_truth is null).
MUST_USE status_t truth_open(const char* path, truth_t** out_truth);

/// Flush and close; null is allowed. Returns STATUS_OK or STATUS_IO: something was not written.
status_t truth_close(truth_t* truth);

/// Channel JOINTS, every step.
typedef struct {
    double position_rad[TRUTH_JOINTS];       ///< Link side.
    double velocity_rad_s[TRUTH_JOINTS];     ///< Link side.
    double motor_position_rad[TRUTH_JOINTS]; ///< Referred to the joint.
    double motor_torque_nm[TRUTH_JOINTS];
    double joint_torque_nm[TRUTH_JOINTS];
    double friction_nm[TRUTH_JOINTS];
    bool brake_engaged[TRUTH_JOINTS];
} truth_joints_t;

/// Channel STICK, every step.
typedef struct {
    double position_rad[TRUTH_AXES];
    double velocity_rad_s[TRUTH_AXES];
    double motor_torque_nm[TRUTH_AXES];
    double hand_torque_nm[TRUTH_AXES];
} truth_stick_t;

/// Channel CONTACT, every step.
typedef struct {
    double tip_m[3];
    bool in_contact;
    bool spring_hooked;
    double contact_point_m[3];
    double contact_force_n[3];
    double spring_force_n[3];
    double external_torque_nm[TRUTH_JOINTS];
} truth_contact_t;

/// Channel OPERATOR, every 20th step (100 Hz).
typedef struct {
    double intent_rad[TRUTH_AXES];
    double wanted_tip_m[2];
    double expected_torque_nm[TRUTH_JOINTS];
    double grip;
    const char* verb;
} truth_operator_t;

/// Channel DRIVE, on every change.
typedef struct {
    const char* bus;
    uint8_t node;
    uint8_t axis;        ///< 0, or 1 for the second axis of a two-axis node.
    uint16_t statusword; ///< Statusword in the device, also if it is not sent on the bus.
    bool plugged;
    bool brake_engaged;
} truth_drive_t;

/// Channel FAULT, on every injected fault and its end.
typedef struct {
    const char* kind;   ///< Verb of the scenario line: "unplug", "loss", ...
    const char* target; ///< Its object: "robot 0x11", ...
    bool active;
} truth_fault_t;

/// Write one event. Returns STATUS_OK or STATUS_IO; after a failure nothing more is written.
status_t truth_joints(truth_t* truth, uint64_t time_ns, const truth_joints_t* joints);
status_t truth_stick(truth_t* truth, uint64_t time_ns, const truth_stick_t* stick);
status_t truth_contact(truth_t* truth, uint64_t time_ns, const truth_contact_t* contact);
status_t truth_operator(truth_t* truth, uint64_t time_ns, const truth_operator_t* operator_);
status_t truth_drive(truth_t* truth, uint64_t time_ns, const truth_drive_t* drive);
status_t truth_fault(truth_t* truth, uint64_t time_ns, const truth_fault_t* fault);

#endif // SIM_TRUTH_TRUTH_H
