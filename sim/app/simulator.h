// SPDX-License-Identifier: Apache-2.0
/// The simulator of a mission: the world of a file with its plant, devices, buses and operator's hand;
/// faults of the scenario; logs.
///
/// One step covers the time since the last step: it takes the frames that flight software has queued on its
/// controllers, runs the buses, applies the scenario's faults at their exact times, then moves the plant. The
/// caller determines the time of each step, in a separate process (simulator_main.c) or inside the image.
///
/// Ownership  simulator_open allocates everything, simulator_close frees it and completes the logs.
/// Context    One task.
/// Errors     simulator_open writes a message for users into a buffer: one line, with the next step.
#ifndef SIM_APP_SIMULATOR_H
#define SIM_APP_SIMULATOR_H

#include "base/status.h"
#include "sim/app/faults.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SIMULATOR_ERROR_MAX 512U

#define SIMULATOR_BUSES_MAX 8U
/// Longest wait for the tools in lock-step in one step [s of wall-clock time]; the launcher must wait longer.
#define SIMULATOR_TOOL_TIMEOUT_S 20U

typedef struct {
    const char* name;
    const char* address;      ///< Flight software's controller (osal_can_open); null or "": none.
    const char* published;    ///< Interface on which tools see the bus ("can:vcan-robot"); null or "": none.
    unsigned bit_rate;        ///< Nominal [bit/s], divides 10^9; 0: CAN FD with 1 and 5 Mbit/s.
    unsigned data_bit_rate;   ///< Bit rate of the data of FD frames, divides 10^9; 0: classic bus.
    const char* redundant_to; ///< This is channel B of the bus of that name; null: a separate bus.
} simulator_bus_t;

typedef struct {
    const char* world_path;    ///< The world (sim/world/world.h).
    const char* scenario_path; ///< Null: no motion of the hand, no faults.
    const char* output_path;   ///< Directory for logs and truth, exists; null: nothing is written.
    const char* devices_path;  ///< Directory of the EDS files; null: "descriptors/devices".
    /// Called for the faults of the scenario that act on processes (kill, hang, resume). Null: they have no
    /// effect.
    void (*process_fault)(void* context, fault_kind_t kind, const char* process);
    /// Check the name of a process in the scenario (fault_world_t.check_process). Null: every name is
    /// accepted.
    status_t (*process_check)(void* context, const scenario_line_t* line, size_t index,
                              char error[SCENARIO_ERROR_MAX]);
    void* process_context;                    ///< Context of process_fault and process_check.
    simulator_bus_t bus[SIMULATOR_BUSES_MAX]; ///< The buses of the world always exist.
    size_t bus_count;
    const char* flows; ///< Identity of the run, part of the addresses of its instruments; null: none.
    /// Stepped time: octets and datagrams of instruments are counted (osal/include/osal/hand_over.h).
    bool are_flows_counted;
    uint64_t seed;
    bool classic_bus;   ///< All buses are classic buses of 1 Mbit/s.
    bool serve_tools;   ///< Open the socketcand port.
    bool is_live;       ///< Open the live port (sim/app/live.h); needs output_path.
    bool is_paced;      ///< The caller keeps the pace that simulator_pace returns.
    bool tools_in_step; ///< Simulated time waits until the tool sends; for deterministic tests.
    uint16_t tool_port; ///< 0: any free port, see simulator_tool_port.
    /// With tools_in_step: time by which each frame of a tool advances the run; 0: 5 ms.
    uint64_t tool_quantum_ns;
} simulator_config_t;

typedef struct {
    uint64_t busy_ns[SIMULATOR_BUSES_MAX]; ///< Per bus: first the buses of the world, in its order.
    uint64_t refused;                      ///< Sum of segment_t.refused.
    uint64_t tool_dropped;                 ///< Messages that a tool at the socketcand port did not read.
    uint64_t tools_lost;  ///< Tools in lock-step that did not finish a step in SIMULATOR_TOOL_TIMEOUT_S.
    uint64_t tool_frames; ///< Frames of tools on the interfaces that publish buses.
    uint64_t unpublished; ///< Frames that such an interface did not accept.
    uint64_t undelivered; ///< See instrument_set_lost.
} simulator_statistics_t;

typedef struct simulator simulator_t;

/// Returns STATUS_OK; else *out_simulator is null and `error` is filled: STATUS_NOT_FOUND (a file or bus),
/// STATUS_INVALID (content of a file), STATUS_TOO_LARGE (file of the world), STATUS_EXHAUSTED (memory),
/// STATUS_EXISTS (port in use), STATUS_IO, or another status of osal_can_open or instrument_open.
MUST_USE status_t simulator_open(const simulator_config_t* config, simulator_t** out_simulator,
                                 char error[SIMULATOR_ERROR_MAX]);

/// Simulate [last step, now_ns). Returns the requested time of the next step: the next whole step. A world
/// that diverges (simulator_failure) is not simulated further.
uint64_t simulator_step(simulator_t* simulator, uint64_t now_ns);

/// Returns the reason for which the run has to end: the world diverges (plant_failure). Null if it does not.
const char* simulator_failure(const simulator_t* simulator);

/// With tools_in_step: wait (wall-clock, at most timeout_ms) until the tool has sent frames for the next
/// step. Returns true if the next step may be taken; without tools_in_step it always may.
bool simulator_may_step(simulator_t* simulator, uint32_t timeout_ms);

typedef struct {
    bool is_held; ///< The next step must not be taken yet.
    double speed; ///< Simulated time per wall-clock time; 0: as fast as possible.
} simulator_pace_t;

/// Returns the pace that lines of the live port have set; 1 without a live port. While simulated time is
/// held, this function takes the lines.
simulator_pace_t simulator_pace(simulator_t* simulator);

/// Flush and close the logs, free everything. Null is allowed. Returns STATUS_OK, or STATUS_IO: a log is
/// not complete.
status_t simulator_close(simulator_t* simulator);

/// Returns the name of a bus, in the order of simulator_statistics_t; null if there are fewer buses.
const char* simulator_bus_name(const simulator_t* simulator, unsigned index);
/// Returns the port of the socketcand server; 0 when there is none.
uint16_t simulator_tool_port(const simulator_t* simulator);
void simulator_statistics(const simulator_t* simulator, simulator_statistics_t* out_statistics);

/// Let the tasks of the logs write the records so far, so that they exist even if the process is killed. With
/// `waits` it returns when the operating system has them, and may be called in the signal handler of a crash.
void simulator_flush(simulator_t* simulator, bool waits);

#endif // SIM_APP_SIMULATOR_H
