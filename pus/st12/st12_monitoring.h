// SPDX-License-Identifier: Apache-2.0
/// ST[12] on-board monitoring: parameter monitoring (PMON) and functional monitoring (FMON) definitions. All
/// 28 messages. Checks, statuses, events and restrictions: docs/services/st12.md.
///
/// The definitions with their statuses, the statuses of both monitoring functions and the reporting delay are
/// persistent; the results of checks are not.
///
/// Ownership  The caller provides all storage.
/// Context    The loop of the process.
/// Time       A step is O(PMONs due * (log PMONs + FMONs that name them)); a request O(entries * (log PMONs +
///            FMON members)).
#ifndef PUS_ST12_ST12_MONITORING_H
#define PUS_ST12_ST12_MONITORING_H

#include "pus/core/due_heap.h"
#include "pus/core/event_port.h"
#include "pus/core/scalar.h"
#include "pus/core/service.h"

typedef enum {
    PUS_CHECK_EXPECTED = 0,
    PUS_CHECK_LIMIT    = 1,
    PUS_CHECK_DELTA    = 2
} pus_check_type_t;

typedef enum {
    PUS_CHECK_NOMINAL   = 0,
    PUS_CHECK_UNCHECKED = 1,
    PUS_CHECK_INVALID   = 2,
    PUS_CHECK_LOW       = 3, ///< Unexpected value, or below the low limit or threshold.
    PUS_CHECK_HIGH      = 4
} pus_check_status_t;

typedef enum {
    PUS_FMON_UNCHECKED = 0,
    PUS_FMON_RUNNING   = 1,
    PUS_FMON_INVALID   = 2,
    PUS_FMON_FAILED    = 3
} pus_fmon_status_t;

typedef struct {         // Private.
    pus_scalar_t scalar; // If its id is 0, the condition is always true.
    uint64_t mask;
    uint64_t expected;
} pus_validity_t;

/// A change of the status of a PMON, as in TM[12,11] and TM[12,12].
typedef struct { // Private.
    uint16_t pmon_id;
    uint32_t parameter_id;
    uint8_t check_type;
    uint8_t previous;
    uint8_t current;
    uint64_t mask;
    uint64_t value;
    uint64_t limit;
    uint64_t time_ns; // Time [ns since 1958].
} pus_check_transition_t;

typedef struct { // Private.
    uint16_t id;
    uint16_t repetition;
    uint32_t interval;
    pus_scalar_t scalar;
    pus_validity_t validity;
    uint64_t low;  // Limit, threshold, or mask.
    uint64_t high; // Limit, threshold, or expected value.
    uint16_t low_event;
    uint16_t high_event;
    uint16_t deltas;
    uint8_t check_type;
    bool is_enabled;
    uint8_t status;
    uint8_t verdict;      // Result of the last check.
    uint16_t verdicts;    // Number of equal results in a row, at most `repetition`.
    uint16_t differences; // Number of differences in the present block.
    bool has_first;       // The block has its first value.
    uint64_t first;
    pus_check_transition_t last;
    uint16_t members; // Number of the first FMON member that names this PMON, plus 1; 0: none.
} pus_pmon_t;

typedef struct { // Private.
    uint16_t id;
    uint16_t event;
    uint16_t minimum;
    uint8_t count; // Number of members.
    uint8_t status;
    bool in_use;
    bool is_enabled;
    bool is_protected;
    bool is_touched; // The FMON must be evaluated.
    pus_validity_t validity;
} pus_fmon_t;

typedef struct { // Private. Member k of FMON f is number f * fmon_members + k.
    uint16_t pmon_id;
    uint16_t next; // Number of the next member that names the same PMON, plus 1; 0: none.
} pus_fmon_member_t;

typedef struct {
    pus_app_process_t* process;
    pus_parameter_port_t parameters; ///< `write` is not used.
    pus_event_port_t events;
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    pus_pmon_t* pmons;                    ///< This array and the next three have pmon_capacity entries.
    uint16_t* pmon_order;
    uint16_t* pmon_positions;
    pus_due_t* due;
    pus_fmon_t* fmons; ///< This array and the next have fmon_capacity entries.
    uint16_t* touched;
    pus_fmon_member_t* members;          ///< fmon_capacity * fmon_members entries, less than 65535.
    pus_check_transition_t* transitions; ///< transition_capacity entries, >= 1.
    uint16_t pmon_capacity;
    uint16_t fmon_capacity;
    uint16_t transition_capacity;
    uint8_t fmon_members;     ///< Largest number of PMONs that an FMON can name.
    uint32_t reporting_delay; ///< Initial value of the maximum transition reporting delay [cycles].
} pus_monitoring_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_monitoring_config_t config;
    pus_due_heap_t due;
    uint64_t cycle;      // Cycle count, extended to 64 bits.
    uint32_t last_cycle; // Last cycle count of the caller.
    uint32_t reporting_delay;
    uint16_t pmon_count; // Number of used entries of pmon_order, sorted by id; the free entries follow.
    uint16_t touched_count;
    uint16_t transition_count;
    uint64_t transitions_since; // Cycle of the first transition in the list.
    bool is_enabled;
    bool is_functional; // The FMON function is enabled.
    bool is_unlinked;   // The chains in `members` are not up to date.
    struct {
        uint32_t checks;      ///< Samples checked, valid or not.
        uint32_t transitions; ///< Changes of status.
        uint32_t lost;        ///< Transitions not reported, because the list was full and the port refused.
        uint32_t failures;    ///< FMONs that became failed.
        uint32_t refused;     ///< Instructions and requests refused.
        uint32_t unsaved;     ///< Records that could not be stored or erased; their changes were refused.
    } counters;
} pus_monitoring_t;

/// Start without definitions, with both functions disabled.
void pus_monitoring_init(pus_monitoring_t* self, const pus_monitoring_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_monitoring_service(pus_monitoring_t* self);
/// Restore one record. STATUS_OK, STATUS_INVALID (malformed, or a request with it would be refused),
/// STATUS_NOT_FOUND (an event), STATUS_EXHAUSTED (no room). The parameters do not need to exist yet.
MUST_USE status_t pus_monitoring_restore(pus_monitoring_t* self, uint32_t key, const uint8_t* octets,
                                         size_t size);
/// Perform the checks that are due, and report. `cycle` counts minimum sampling intervals and may jump
/// forward; a PMON that has missed checks is then checked once.
void pus_monitoring_step(pus_monitoring_t* self, uint64_t now_ns, uint32_t cycle);

#endif // PUS_ST12_ST12_MONITORING_H
