// SPDX-License-Identifier: Apache-2.0
/// The true state of the simulator as an LCM event log with simulated time. The figures of a run compare
/// telemetry with it. Two runs with the same seed give the same file, octet for octet.
///
/// The .lcm files in the directory of this header define the types; sim/truth/README.md describes channels
/// and rates. A channel at rest is written only every TRUTH_INTERVAL_NS. A task of the log writes the events
/// (sim/logs/write_behind.h).
///
/// Ownership  truth_open allocates, truth_close frees and flushes.
#ifndef SIM_TRUTH_TRUTH_H
#define SIM_TRUTH_TRUTH_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TRUTH_OCTETS_MAX 4294967296U ///< `max_octets` of the simulator for truth_open.

#define TRUTH_INTERVAL_NS 100000000U ///< Time between two events of a channel at rest.
/// A channel is at rest while its real numbers differ from those of its last event by at most this [SI units]
/// and its other values are equal.
#define TRUTH_RESOLUTION 1e-9

typedef struct truth truth_t;

/// Create or overwrite the log. Before it would exceed `max_octets`, it ends with an event CUT. Returns
/// STATUS_OK or STATUS_IO (then *out_truth is null).
MUST_USE status_t truth_open(const char* path, uint64_t max_octets, truth_t** out_truth);

/// Let the task of the log write the events so far. With `waits` it returns when the operating system has
/// them, and may be called in the signal handler of a crash.
void truth_flush(truth_t* truth, bool waits);

/// Flush and close; null is allowed. Returns STATUS_OK or STATUS_IO: some events were not written.
status_t truth_close(truth_t* truth);

/// Channel JOINTS, at every step: arrays of `count`.
typedef struct {
    unsigned count;
    const double* position_rad;       ///< Link side.
    const double* velocity_rad_s;     ///< Link side.
    const double* motor_position_rad; ///< Referred to the joint.
    const double* motor_torque_nm;
    const double* joint_torque_nm;
    const double* friction_nm;
    const double* external_torque_nm; ///< Caused by contacts and springs.
    const bool* brake_engaged;
} truth_joints_t;

/// Channel STICK, at every step: arrays of `count` axes.
typedef struct {
    unsigned count;
    const double* position_rad;
    const double* velocity_rad_s;
    const double* motor_torque_nm;
    const double* hand_torque_nm;
} truth_stick_t;

/// A contact between links a and b, or a spring (its force acts at place_m, point_m is not used), in the axes
/// of the world.
typedef struct {
    double place_m[3]; ///< Origin of link a, or of the link that pulls the spring.
    double point_m[3]; ///< Centre of the contact points, weighted by force; zero without contact.
    double force_n[3]; ///< Force on that link.
    bool is_active;    ///< The contact touches, or the spring is hooked.
} truth_touch_t;

/// The root link of a free robot, in the axes of the world.
typedef struct {
    double position_m[3];   ///< Origin of the link.
    double rotation[4];     ///< Unit quaternion w, x, y, z: from the axes of the link to those of the world.
    double velocity_m_s[3]; ///< Of the origin of the link.
    double rate_rad_s[3];   ///< Angular velocity.
} truth_base_t;

/// Channel WORLD, once: the names of joints, axes, contacts, springs and bases.
typedef struct {
    unsigned count;
    const char* const* name;
} truth_names_t;

typedef struct {
    truth_names_t joints;
    truth_names_t axes;
    truth_names_t contacts;
    truth_names_t springs;
    truth_names_t bases;
} truth_world_t;

/// A reaction wheel: channel WHEEL, every step.
typedef struct {
    double momentum_nms;
    double torque_nm;
} truth_wheel_t;

/// Channel BENCH, at every step: arrays of `count` drives on test benches.
typedef struct {
    unsigned count;
    const double* position_rad;
    const double* velocity_rad_s;
    const double* output_torque_nm;
} truth_benches_t;

/// Channel INSTRUMENT, at every step: arrays of `count`.
typedef struct {
    unsigned count;
    const double* value;
    const bool* enabled;
    const bool* plugged;
} truth_instruments_t;

/// Channel BUS, at every step: arrays of `count`.
typedef struct {
    unsigned count;
    const double* load;     ///< Share of the last complete TRUTH_INTERVAL_NS in which the wire was not idle.
    const uint64_t* frames; ///< Frames sent from the start of the run to the end of that interval.
    const uint64_t* errors; ///< Error frames on the wire, counted in the same time.
    const int32_t* state;   ///< controller_state_t of the controller of flight software; -1: there is none.
    const uint32_t* off;    ///< Number of controllers that are bus-off.
    const bool* plugged;    ///< True if the controller of flight software is connected.
} truth_buses_t;

/// Channel OPERATOR, at every step: the action of the hand (sim/operator/hand.h).
typedef struct {
    double intent_rad[2];         ///< Position of each axis of the stick to which the hand pulls.
    double wanted_tip_m[2];       ///< Wanted position of the tip: x, z of the world; zero without a scene.
    double expected_torque_nm[2]; ///< Torque of contour and spring on each joint, as the hand expects it.
    double grip;                  ///< Share of the grip that acts: 0 (the hand is off the stick) to 1.
    const char* verb;             ///< Verb of the scenario line that acts; "rest" before the first line.
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

/// Channel VALVE, on every change.
typedef struct {
    const char* name;
    bool is_open;
} truth_valve_t;

/// Channel LATCH, on every change.
typedef struct {
    const char* name;
    bool is_closed;
} truth_latch_t;

/// Channel FAULT, on every injected fault and its end.
typedef struct {
    const char* kind;   ///< Verb of the scenario line: "unplug", "loss", ...
    const char* target; ///< Object of the verb: "robot 0x11", ...
    bool active;
} truth_fault_t;

/// Write one event. The caller passes all channels except WORLD, NAMES, DRIVE, VALVE, LATCH and FAULT at
/// every step; the log decides which steps of a channel at rest it writes. Returns STATUS_OK or STATUS_IO.
/// After a failure no more events are written. The same holds after the log has reached its maximum size, but
/// then the status is STATUS_OK.
status_t truth_world(truth_t* truth, uint64_t time_ns, const truth_world_t* world);
status_t truth_joints(truth_t* truth, uint64_t time_ns, const truth_joints_t* joints);
status_t truth_stick(truth_t* truth, uint64_t time_ns, const truth_stick_t* stick);
status_t truth_contacts(truth_t* truth, uint64_t time_ns, const truth_touch_t* contact, unsigned count);
status_t truth_springs(truth_t* truth, uint64_t time_ns, const truth_touch_t* spring, unsigned count);
status_t truth_bases(truth_t* truth, uint64_t time_ns, const truth_base_t* base, unsigned count);
status_t truth_wheels(truth_t* truth, uint64_t time_ns, const truth_wheel_t* wheel, unsigned count);
status_t truth_benches(truth_t* truth, uint64_t time_ns, const truth_benches_t* benches);
status_t truth_instruments(truth_t* truth, uint64_t time_ns, const truth_instruments_t* instruments);
/// Channel POWER: true for each device that its power unit supplies.
status_t truth_power(truth_t* truth, uint64_t time_ns, const bool* supplied, unsigned count);
status_t truth_buses(truth_t* truth, uint64_t time_ns, const truth_buses_t* buses);
/// Called instead of truth_buses after a step that has changed none of its values.
status_t truth_buses_again(truth_t* truth, uint64_t time_ns);
/// Channel NAMES: the names of the entries of another channel.
status_t truth_names(truth_t* truth, uint64_t time_ns, const char* channel, const truth_names_t* names);
status_t truth_operator(truth_t* truth, uint64_t time_ns, const truth_operator_t* operator_);
status_t truth_drive(truth_t* truth, uint64_t time_ns, const truth_drive_t* drive);
status_t truth_valve(truth_t* truth, uint64_t time_ns, const truth_valve_t* valve);
status_t truth_latch(truth_t* truth, uint64_t time_ns, const truth_latch_t* latch);
status_t truth_fault(truth_t* truth, uint64_t time_ns, const truth_fault_t* fault);

#endif // SIM_TRUTH_TRUTH_H
