// SPDX-License-Identifier: Apache-2.0
/// ST[18] on-board control procedures, all 20 messages: loading, running, suspending ("held" in the status).
/// The engine that implements pus/core/procedure_port.h defines the language of procedures. Rules,
/// observation and refusals: docs/services/st18.md.
///
/// Loaded code and the status of the engine (running or stopped) are persistent; after a restart all
/// procedures are inactive.
///
/// Ownership  The caller provides all storage.
/// Context    The loop of the process.
/// Time       A step is O(slots * budget); a request O(procedures).
#ifndef PUS_ST18_ST18_PROCEDURES_H
#define PUS_ST18_ST18_PROCEDURES_H

#include "pus/core/event_port.h"
#include "pus/core/file_port.h"
#include "pus/core/procedure_port.h"
#include "pus/core/requester.h"
#include "pus/core/service.h"

#define PUS_PROCEDURE_CODE_MAX 16384U ///< Largest code [octets].
/// Largest size of the values communicated to a procedure [octets].
#define PUS_PROCEDURE_ARGUMENTS_MAX 1024U
#define PUS_PROCEDURE_NONE UINT16_MAX
/// Characters of the text in an observation event.
#define PUS_OBSERVATION_TEXT 45U

typedef enum {
    PUS_PROCEDURE_INACTIVE = 0,
    PUS_PROCEDURE_RUNNING  = 1,
    PUS_PROCEDURE_HELD     = 2
} pus_procedure_status_t;

typedef enum {
    PUS_OBSERVE_NOTHING   = 0,
    PUS_OBSERVE_PROCEDURE = 1,
    PUS_OBSERVE_STEPS     = 2,
    PUS_OBSERVE_ALL       = 3
} pus_observability_t;

/// Kind of an observation, in the auxiliary data of the observation event.
typedef enum {
    PUS_OBSERVED_STARTED  = 1,
    PUS_OBSERVED_ENDED    = 2,
    PUS_OBSERVED_FAILED   = 3,
    PUS_OBSERVED_STOPPED  = 4,
    PUS_OBSERVED_ABORTED  = 5,
    PUS_OBSERVED_HELD     = 6,
    PUS_OBSERVED_RESUMED  = 7,
    PUS_OBSERVED_STEP     = 8,
    PUS_OBSERVED_SENT     = 9,
    PUS_OBSERVED_RECEIVED = 10
} pus_observation_t;

/// Port to the last reported telemetry.
typedef struct {
    void* context;
    /// Read the value of a parameter. STATUS_OK, STATUS_NOT_FOUND (unknown, never reported, or not a scalar).
    status_t (*read)(void* context, uint32_t parameter_id, value_type_t* out_type, uint64_t* out_bits);
    /// Read a value by name; `name` may be that of a scalar in a structured parameter. Same statuses.
    status_t (*read_named)(void* context, const char* name, value_type_t* out_type, uint64_t* out_bits);
} pus_telemetry_port_t;

typedef struct { // Private: a loaded procedure.
    uint8_t id[PUS_NAME_SIZE];
    bool in_use;
    bool was_aborted;  // The last request to abort all procedures has aborted this one.
    uint8_t parts;     // One bit for each record of the procedure that was restored.
    uint8_t level;     // pus_observability_t.
    uint16_t size;     // Size of the code [octets].
    uint16_t checksum; // Checksum of the code.
    uint16_t slot;     // PUS_PROCEDURE_NONE: inactive.
    uint8_t code[PUS_PROCEDURE_CODE_MAX];
} pus_procedure_t;

/// Condition for which a running procedure waits.
typedef enum {
    PUS_WAITS_NOT,
    PUS_WAITS_TIME,
    PUS_WAITS_PORT, // The port must take a request.
    PUS_WAITS_VERIFICATION,
    PUS_WAITS_PARAMETERS
} pus_waiting_t;

typedef struct { // Private: the step at which a procedure must stop or be suspended.
    bool is_wanted;
    uint16_t step; // 0: the next step.
} pus_hold_t;

typedef struct {        // Private: a slot of the engine.
    uint16_t procedure; // PUS_PROCEDURE_NONE: free.
    bool is_held;
    bool unloads; // When the procedure has stopped, it is unloaded.
    uint16_t step;
    pus_hold_t stop;
    pus_hold_t suspension;
    pus_token_t token; // Token of the request that activated the procedure.
    pus_waiting_t waiting;
    uint64_t until;      // Cycle in which the wait ends.
    uint32_t request_id; // Id of the request for whose end the procedure waits.
    pus_call_t call;
    pus_answer_t answer;
    uint16_t communicated; // Octets in `values` that the procedure has not taken yet.
    uint8_t values[PUS_PROCEDURE_ARGUMENTS_MAX];
    uint8_t taken[PUS_PROCEDURE_ARGUMENTS_MAX];
} pus_procedure_run_t;

typedef struct {
    pus_app_process_t* process;
    pus_procedure_port_t engine;
    pus_requester_t* requester; ///< Requester that no other service uses.
    pus_telemetry_port_t telemetry;
    pus_event_port_t events;
    const pus_file_port_t* files;         ///< Null: procedures cannot be loaded by reference.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    pus_procedure_t* procedures;
    pus_procedure_run_t* runs; ///< One entry for each slot of the engine.
    uint16_t capacity;         ///< Number of entries of `procedures`, 1..16383.
    uint32_t budget;           ///< Units of the engine that a procedure may use in a cycle.
    /// Largest number of steps, events and requests of a procedure in a cycle, >= 1.
    uint16_t calls;
    uint64_t cycle_ns;            ///< Length of a cycle [ns], >= 1.
    uint32_t verification_cycles; ///< Longest wait for the end of a request [cycles].
    uint16_t observation_event;   ///< Event that reports observations; 0: none.
    uint16_t failure_event;
} pus_procedures_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_procedures_config_t config;
    bool is_stopped; // The engine is stopped.
    uint64_t cycle;  // Cycle count, extended to 64 bits.
    uint32_t last_cycle;
    uint64_t now_ns;
    struct {
        uint32_t started;
        uint32_t ended;
        uint32_t failed;  ///< Ended with an error, or could not be started.
        uint32_t aborted; ///< Stopped or aborted.
        uint32_t sent;    ///< Requests released.
        uint32_t refused; ///< Instructions and requests refused.
        uint32_t unsaved; ///< Changes and commits that could not be stored; such a change was refused.
    } counters;
} pus_procedures_t;

void pus_procedures_init(pus_procedures_t* self, const pus_procedures_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_procedures_service(pus_procedures_t* self);
/// Restore one record. STATUS_OK, STATUS_INVALID (malformed, or its checksum is wrong), STATUS_EXHAUSTED
/// (no room). A procedure is loaded when all its records have been restored.
MUST_USE status_t pus_procedures_restore(pus_procedures_t* self, uint32_t key, const uint8_t* octets,
                                         size_t size);
/// Evaluate a report. If a procedure waits for this verification report, it becomes the answer to the
/// procedure.
void pus_procedures_observe(pus_procedures_t* self, const pus_tm_t* tm);
/// Continue running procedures. `cycle` may jump forward.
void pus_procedures_step(pus_procedures_t* self, uint64_t now_ns, uint32_t cycle);
/// True if any procedure is active.
bool pus_procedures_are_active(const pus_procedures_t* self);

#endif // PUS_ST18_ST18_PROCEDURES_H
