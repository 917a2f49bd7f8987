// SPDX-License-Identifier: Apache-2.0
/// Faults of a scenario: the lines of the actor `fault`, and their effects on buses and devices. The lines
/// are listed in docs/scenarios.md.
#ifndef SIM_APP_FAULTS_H
#define SIM_APP_FAULTS_H

#include "base/status.h"
#include "sim/bus/bus.h"
#include "sim/devices/drive.h"
#include "sim/devices/instrument.h"
#include "sim/devices/power_unit.h"
#include "sim/operator/scenario.h"
#include "sim/truth/truth.h"

#include <stddef.h>
#include <stdint.h>

#define FAULT_BUSES_MAX 8U
#define FAULT_DEVICES_MAX 96U
#define FAULT_DEVICE_ALL FAULT_DEVICES_MAX           ///< All devices of the bus.
#define FAULT_DEVICE_FLIGHT (FAULT_DEVICES_MAX + 1U) ///< The controller of the flight software.
#define FAULT_INSTRUMENTS_MAX 16U
#define FAULT_TARGET_MAX 48U

typedef enum {
    FAULT_UNPLUG,
    FAULT_PLUG,
    FAULT_CUT,
    FAULT_MEND,
    FAULT_LOSS,
    FAULT_CORRUPTION,
    FAULT_DUPLICATION,
    FAULT_DELAY,
    FAULT_BABBLE,
    FAULT_SYNC,
    FAULT_STUCK,
    FAULT_OVERFLOW,
    FAULT_BUS_OFF,
    FAULT_RESTART,
    FAULT_ARBITRATION,
    FAULT_RESET,
    FAULT_ERROR,
    FAULT_TORQUE_OFFSET,
    FAULT_TEMPERATURE,
    FAULT_SILENT,
    FAULT_GARBAGE,
    FAULT_KILL,
    FAULT_HANG,
    FAULT_RESUME,
    FAULT_KIND_COUNT
} fault_kind_t;

typedef enum {
    FAULT_RESTART_AUTO,  ///< From now on the controller recovers from bus-off by itself.
    FAULT_RESTART_ORDER, ///< From now on it recovers only after FAULT_RESTART_NOW.
    FAULT_RESTART_NOW    ///< The controller begins to recover.
} fault_restart_t;

typedef struct {
    uint64_t time_ns;
    fault_kind_t kind;
    unsigned bus;     ///< Index in fault_world_t; FAULT_BUSES_MAX: the fault names an instrument.
    unsigned channel; ///< NODE_CHANNEL_A, _B.
    unsigned device;  ///< Index of device or instrument in fault_world_t, FAULT_DEVICE_ALL or _FLIGHT.
    /// By the kind: probability, [us], [Nm], [degC], number of frames, 1 (on) or 0 (off), or fault_restart_t.
    double value;
    uint16_t code; ///< EMCY code.
    char target[FAULT_TARGET_MAX];
} fault_t;

typedef scenario_lines_t faults_t; ///< The records are fault_t; other modules only read them.

typedef struct {
    const char* name;     ///< Null: scenario lines cannot name it.
    bus_t* bus;           ///< Null: the bus has no such channel.
    unsigned flight_node; ///< BUS_NODES_MAX: there is none.
} fault_channel_t;

typedef struct {
    const char* name;
    unsigned bus;
    unsigned id;
    node_t* node;       ///< Null: the device is a power unit.
    power_unit_t* unit; ///< Null: the device is a node.
    drive_t* drive;     ///< Null: the device is not a drive.
    /// An error of the device appears or disappears.
    void (*set_error)(void* model, uint16_t code, bool is_present, uint64_t now_ns);
    void* model;
} fault_device_t;

typedef struct {
    const char* name;
    instrument_t* instrument;
} fault_instrument_t;

/// The buses, devices and processes that faults change.
typedef struct {
    fault_channel_t channel[FAULT_BUSES_MAX][NODE_CHANNELS];
    fault_device_t device[FAULT_DEVICES_MAX];
    size_t device_count;
    fault_instrument_t instrument[FAULT_INSTRUMENTS_MAX];
    size_t instrument_count;
    /// Apply FAULT_KILL, FAULT_HANG or FAULT_RESUME to a process. Null: these faults have no effect.
    void (*process)(void* context, fault_kind_t kind, const char* process);
    /// Check that word `index` of the line names one process. Null: every name is accepted. Returns
    /// STATUS_OK, STATUS_INVALID (`error` is filled).
    status_t (*check_process)(void* context, const scenario_line_t* line, size_t index,
                              char error[SCENARIO_ERROR_MAX]);
    void* process_context; ///< Context of `process` and `check_process`.
} fault_world_t;

/// Read the fault lines of a scenario (null: no scenario, no faults). They name buses and devices of `world`.
/// faults_free frees them, also after an error. Returns STATUS_OK, or a status of scenario_read with `error`
/// filled; STATUS_EXHAUSTED: no memory.
MUST_USE status_t faults_load(faults_t* faults, const fault_world_t* world, const char* scenario_path,
                              char error[SCENARIO_ERROR_MAX]);
/// Add one line of the actor `fault`; its time must not be before that of the last fault applied. A refused
/// line changes nothing. STATUS_OK; else `error` is filled: STATUS_INVALID, STATUS_EXHAUSTED (no memory).
MUST_USE status_t faults_add(faults_t* faults, const fault_world_t* world, const scenario_line_t* line,
                             char error[SCENARIO_ERROR_MAX]);
void faults_free(faults_t* faults);
/// Returns the time of the next fault not yet applied; UINT64_MAX if there is none.
uint64_t faults_next_ns(const faults_t* faults);
/// Apply the next fault, and return it. The buses must have run up to its time.
const fault_t* faults_apply_next(faults_t* faults, const fault_world_t* world);
/// Returns the verb in scenarios for a kind of fault.
const char* fault_word(fault_kind_t kind);
/// True if the fault begins an effect, false if it ends one.
bool fault_is_onset(const fault_t* fault);

#endif // SIM_APP_FAULTS_H
