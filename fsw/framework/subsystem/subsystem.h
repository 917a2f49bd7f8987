// SPDX-License-Identifier: Apache-2.0
/// The generic subsystem: state machine, cyclic step, services and links of one component.
///
/// A specific subsystem is a table of callbacks (subsystem_callbacks_t) and one descriptor. The generic part
/// answers telecommands, runs the state machine, reads and writes links and samples housekeeping; the
/// callbacks control the devices. One cycle, every samplingTime of the applied configuration:
///
///     sense                       read device data
///     entry action of the state   once
///     control                     the cyclic code of the state
///     emit                        commands to the devices and SYNC; then write links, sample housekeeping
///
/// Ownership  The program provides subsystem_t and what subsystem_config_t points to; all outlive the
///            subsystem.
/// Context    One task; the callbacks run inside subsystem_step and never block. The time is an argument.
/// Errors     Each function lists its statuses.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_H
#define FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_H

#include "base/status.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/parameter/parameter.h"
#include "fsw/framework/subsystem/state_machine.h"
#include "pus/st02/st02_device_access.h"
#include "pus/core/parameter_port.h"
#include "pus/st06/st06_memory.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct subsystem subsystem_t;

/// A function command (ST[08]) that the specific subsystem completes now or later.
typedef struct {
    uint16_t function_id;  ///< Id of the function in the descriptor (generated enum).
    const void* arguments; ///< Generated argument struct of that function; valid during the call.
    uint32_t call_token;   ///< Argument of subsystem_function_done, if perform returns STATUS_BUSY.
} subsystem_function_t;

/// Further memories of the subsystem, each with its own id, and the port to the files from which memories
/// are loaded and to which they are dumped. All of them must outlive the component.
typedef struct {
    const pus_memory_t* memories;
    uint8_t count;
    const pus_file_port_t* files; ///< Null: TC[6,19] to [6,22] are refused.
} subsystem_memories_t;

/// The first part of a descriptor that the program cannot support.
typedef struct {
    uint32_t line;      ///< Line of the descriptor file.
    const char* reason; ///< Value found and value expected; if `most` > 0, what there is too much of.
    uint32_t most;      ///< Capacity of the program; 0 if no capacity is exceeded.
} subsystem_misfit_t;

/// Callbacks of a specific subsystem. `self` is the context of the subsystem. A null callback means that
/// nothing is to be done. An entry action returns STATUS_BUSY while it runs (it is called again in each
/// cycle), STATUS_OK when it is done, any other status when it has failed. The descriptor's time-out for
/// the state ends an action that does not end by itself.
typedef struct {
    status_t (*software_init)(void* self); ///< Publish parameters with subsystem_publish.
    status_t (*hardware_init)(void* self); ///< Switch power on, wait for boot-up, initialise devices.
    status_t (*configure)(void* self, const descriptor_configuration_t* configuration); ///< Connect devices.
    status_t (*start_control)(void* self);   ///< Switch controllers on; actuators stay off.
    status_t (*stop_control)(void* self);    ///< Switch controllers off.
    status_t (*engage)(void* self);          ///< Switch actuators on, without a jump of the motion.
    status_t (*disengage)(void* self);       ///< Switch actuators off.
    status_t (*secure)(void* self);          ///< Stop quickly, engage brakes; must be safe in any state.
    status_t (*post)(void* self);            ///< Disconnect devices.
    status_t (*hardware_deinit)(void* self); ///< Switch devices and power off.
    status_t (*software_deinit)(void* self); ///< Release all resources.
    /// Called at the start of each cycle from HARDWARE_INIT to HARDWARE_DEINIT.
    void (*sense)(void* self);
    void (*control)(void* self); ///< Called in each cycle in states 3 (CONFIGURED), 4, 5 and 6.
    /// Called at the end of each cycle that begins or ends in a state from HARDWARE_INIT to HARDWARE_DEINIT.
    void (*emit)(void* self);
    /// Perform a function command. STATUS_OK: done; STATUS_BUSY: continues, until subsystem_function_done is
    /// called with its token; STATUS_FORBIDDEN: wrong state; STATUS_OUT_OF_RANGE: invalid argument; any other
    /// status: failed.
    status_t (*perform)(void* self, const subsystem_function_t* function);
    /// Called when a telecommand has set a parameter; `parameter_id` is that of the generated header. May
    /// be null.
    void (*parameter_set)(void* self, uint32_t parameter_id);
    /// Called when a report of another component has arrived. May be null; only `communication`, which sends
    /// these reports to ground, has this callback.
    void (*report)(void* self, const uint8_t* packet, size_t size);
    /// Returns the port through which ST[02] accesses the devices. May be null if the descriptor does not
    /// list that service. Called once, at the start.
    pus_device_port_t (*device_port)(void* self);
    /// Returns further memories for ST[06], if the descriptor lists that service. Null: there are none.
    /// Called once, at the start.
    subsystem_memories_t (*memories)(void* self);
    /// Returns the port to the parameters that ST[12] monitors, if the descriptor lists that service. Null:
    /// the subsystem's own parameters. Called once, at the start.
    pus_parameter_port_t (*watched)(void* self);
    /// Called when the program ends, in any state: close everything that is open and leave the devices as
    /// they are. May be null.
    void (*release)(void* self);
    /// True if the subsystem can drive the devices of a descriptor; otherwise *out_misfit is the first
    /// content that it does not support. Null: the subsystem supports devices on CAN if it has the callback
    /// sense, otherwise no devices. Called before the subsystem is initialised.
    bool (*fits)(const subsystem_descriptor_t* descriptor, subsystem_misfit_t* out_misfit);
} subsystem_callbacks_t;

// ---- Called by a specific subsystem from its callbacks ----

/// Return the time of this cycle [ns of the run], and the number of cycles since the configuration was
/// applied.
uint64_t subsystem_now_ns(const subsystem_t* subsystem);
uint32_t subsystem_cycle(const subsystem_t* subsystem);
/// Returns the nominal period of the cycle [ns]: of the applied configuration or, without one, of the
/// descriptor.
uint64_t subsystem_period_ns(const subsystem_t* subsystem);
/// Returns the silence after which devices and their master regard each other as lost [ns]; 0: use the times
/// of the descriptor and of the protocol.
uint64_t subsystem_device_deadline_ns(const subsystem_t* subsystem);
state_t subsystem_state(const subsystem_t* subsystem);
/// Returns the configuration that is applied or is being applied, or null.
const descriptor_configuration_t* subsystem_configuration(const subsystem_t* subsystem);
const subsystem_descriptor_t* subsystem_descriptor(const subsystem_t* subsystem);
/// True if the process of this component has started more than once in this run.
bool subsystem_is_restarted(const subsystem_t* subsystem);
parameter_dictionary_t* subsystem_dictionary(subsystem_t* subsystem);

/// Publish one parameter in software_init. Statuses of parameter_publish.
MUST_USE status_t subsystem_publish(subsystem_t* subsystem, const parameter_definition_t* definition,
                                    void* storage);
/// Publish all parameters of the generated header: `definitions` and `offsets` are its tables, `storage` is
/// the structure of all parameters. Statuses of parameter_publish.
MUST_USE status_t subsystem_publish_all(subsystem_t* subsystem, const parameter_definition_t* definitions,
                                        const size_t* offsets, size_t count, void* storage);

/// Raise an event of the descriptor with auxiliary octets (big-endian, in the order that the descriptor
/// defines). If size is 0, the parameters to which the event refers are sampled now. After an event of
/// severity HIGH the subsystem goes to ERROR_OPERATIONAL in this cycle, before any command is sent to a
/// device (from the states 1, 2, 7, 8 and 9 to OFFLINE). After an event of severity MEDIUM in
/// OPERATIONAL it waits 4 cycles for a command of the supervisor, then goes to SAFE_OPERATIONAL by itself; in
/// other states it stays. Events of the supervisor itself change no state. STATUS_OK (an event that is not
/// reported, because of the size of its data or for lack of room, counts in events_refused); STATUS_NOT_FOUND
/// (no such event).
status_t subsystem_raise(subsystem_t* subsystem, uint16_t event_id, const uint8_t* auxiliary, size_t size);
/// Raise an event by telecommand, without data. Only events of severity LOW are permitted, because others
/// trigger reactions. STATUS_OK, STATUS_OUT_OF_RANGE (another severity, or no such event).
status_t subsystem_raise_by_command(subsystem_t* subsystem, uint16_t event_id);

/// End a function command for which perform has returned STATUS_BUSY. Code 0 means success; otherwise a
/// failure code and its detail. When called inside perform, it ends that command, and the status that
/// perform returns is ignored. No effect for token 0 and for a command that has already ended.
void subsystem_function_done(subsystem_t* subsystem, uint32_t call_token, uint16_t failure_code,
                             uint32_t detail);

/// Copy the latest sample of a required port into `payload` (generated struct; `size` is its exact size).
/// STATUS_OK, STATUS_EMPTY (no sample yet), STATUS_STALE (sample copied, but older than allowed),
/// STATUS_CLOSED (no link; `payload` is unchanged), STATUS_NOT_FOUND (no such port in this configuration).
MUST_USE status_t subsystem_link_read(subsystem_t* subsystem, uint16_t port, void* payload, size_t size);
/// Returns the state of the producer of a required port, from its last frame; STATE_OFFLINE without a link or
/// a frame.
state_t subsystem_link_peer_state(const subsystem_t* subsystem, uint16_t port);
/// Returns the age of the last sample [us]; UINT32_MAX if there is no sample, or if the age exceeds this
/// range.
uint32_t subsystem_link_age_us(const subsystem_t* subsystem, uint16_t port);
typedef struct { // Sums over all links that this subsystem has consumed since it started. Each [wraps].
    uint32_t received;
    uint32_t lost; ///< Samples missing in the sequence.
    uint32_t late; ///< Reads of a sample that was older than allowed.
    /// Frames of another epoch, link or layout, or with a wrong CRC; reads that a busy writer prevented.
    uint32_t refused;
} subsystem_link_totals_t;
void subsystem_link_totals(const subsystem_t* subsystem, subsystem_link_totals_t* out_totals);
typedef struct { // Refusals and losses since the start, for a COUNTERS parameter. Each counter [wraps].
    /// Largest number of function commands that ran at the same time (does not wrap), and commands refused
    /// because SUBSYSTEM_CALL_TOKENS commands were running.
    uint16_t pool_peak;
    uint32_t pool_refused;
    uint32_t requests_refused;     ///< Telecommands rejected, or failed at their start.
    uint32_t parameters_refused;   ///< Reads and writes of parameters that were refused.
    uint32_t events_refused;       ///< Events with unknown id or wrong data, or for which there was no room.
    uint32_t housekeeping_dropped; ///< Housekeeping reports that the packet port did not accept.
    uint32_t reports_lost;         ///< Other reports for which there was no room.
    uint32_t events_suppressed;    ///< Occurrences of events that their limiters suppressed.
} subsystem_health_t;
void subsystem_health(const subsystem_t* subsystem, subsystem_health_t* out_health);
/// Publish a sample on a provided port; it is sent immediately, with the present state, on each open link of
/// the port. STATUS_OK (a link that could not send it counts it as lost), STATUS_CLOSED (no link is open),
/// STATUS_NOT_FOUND (no such port in this configuration).
status_t subsystem_link_write(subsystem_t* subsystem, uint16_t port, const void* payload, size_t size);

#endif // FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_H
