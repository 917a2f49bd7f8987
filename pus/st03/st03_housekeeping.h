// SPDX-License-Identifier: Apache-2.0
/// ST[03] housekeeping: reports of parameter values, once or periodically, from structures that come from the
/// configuration or from a request. Housekeeping structures (TM[3,25]) and diagnostic ones (TM[3,26]) differ
/// only in their space of ids. All 32 messages. Sampling, functional definitions, loops and refusals:
/// docs/services/st03.md.
///
/// A structure is changed (deleted, appended to, given another interval) only while its periodic generation
/// is disabled; a created one starts disabled. If the port refuses a report, it is dropped and counted.
///
/// Ownership  The caller places structures and samples: structure i samples into
///            samples[i * sample_size .. (i + 1) * sample_size - 1].
/// Context    The loop of the process; pus_hk_loop_step in the loop it steps.
/// Time       A step is O(structures + values sampled).
#ifndef PUS_ST03_ST03_HOUSEKEEPING_H
#define PUS_ST03_ST03_HOUSEKEEPING_H

#include "pus/core/parameter_port.h"
#include "osal/include/osal/mutex.h"
#include "pus/core/service.h"

#define PUS_HK_PARAMETERS_MAX 64U ///< Parameters of one structure, in all its lists together.
#define PUS_HK_SETS_MAX 8U        ///< Super-commutated sets of one structure.
#define PUS_HK_MEMBERS_MAX 32U    ///< Structures of one functional reporting definition.

/// A structure as the configuration defines it; borrowed during the call only.
typedef struct {
    uint16_t repetitions; ///< Samples per interval, 1..interval.
    uint8_t parameter_count;
    const uint32_t* parameters; ///< Ids.
} pus_hk_set_definition_t;

typedef struct {
    uint16_t id;
    bool is_diagnostic;
    uint32_t interval; ///< [cycles], >= 1.
    bool is_periodic;  ///< Periodic generation enabled from the start.
    uint8_t loop;      ///< 0 the loop of the process.
    uint8_t parameter_count;
    uint8_t set_count;
    const uint32_t* parameters; ///< Ids of the simply commutated.
    const pus_hk_set_definition_t* sets;
} pus_hk_definition_t;

typedef struct { // Private.
    uint32_t parameter_id;
    uint16_t handle;
    uint16_t size;
} pus_hk_entry_t;

typedef struct { // Private.
    uint16_t repetitions;
    uint16_t taken;  // Samples of the present interval so far.
    uint16_t offset; // Offset of the set's first sample in the sample buffer.
    uint16_t size;   // Size of one sample [octets].
    uint8_t first;   // Entry.
    uint8_t count;   // Entries.
} pus_hk_set_t;

typedef struct { // Private.
    bool in_use;
    bool is_diagnostic;
    bool is_periodic;
    bool is_collecting; // An interval has begun.
    uint8_t loop;
    uint16_t id;
    uint32_t interval;
    uint32_t start; // Cycle before the interval's first.
    uint16_t size;  // Size of all values [octets].
    uint8_t simple_count;
    uint8_t entry_count;
    uint8_t set_count;
    pus_hk_set_t sets[PUS_HK_SETS_MAX];
    pus_hk_entry_t entries[PUS_HK_PARAMETERS_MAX];
} pus_hk_structure_t;

typedef struct { // Private: a structure of a functional reporting definition.
    bool is_diagnostic;
    bool is_periodic;
    uint16_t id;
    uint32_t interval;
} pus_hk_member_t;

typedef struct { // Private.
    bool in_use;
    uint8_t count;
    uint16_t id;
    pus_hk_member_t members[PUS_HK_MEMBERS_MAX];
} pus_hk_functional_t;

typedef struct {
    pus_app_process_t* process;
    pus_parameter_port_t parameters; ///< `write` is not used.
    pus_hk_structure_t* structures;
    uint16_t structure_count;
    uint8_t* samples;                ///< structure_count * sample_size octets.
    uint16_t sample_size;            ///< Largest report's values [octets], <= PUS_TM_DATA_MAX - 2.
    osal_mutex_t* guard;             ///< Null: the process has no other loop.
    pus_hk_functional_t* functional; ///< Room for functional reporting definitions.
    uint16_t functional_count;
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
} pus_hk_config_t;

typedef struct { // Receiver of the finished reports of a loop.
    void* context;
    /// Take the values of structure `id`, sampled at now_ns. It is a housekeeping structure from the
    /// configuration, as all structures of such loops.
    void (*put)(void* context, uint16_t id, uint64_t now_ns, const uint8_t* values, size_t size);
    uint8_t* values; ///< Room for one report's values: sample_size octets, of this loop alone.
} pus_hk_outlet_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_hk_config_t config;
    pus_hk_structure_t candidate;
    pus_failure_t verdict;          // First failure of the candidate.
    pus_hk_functional_t functional; // Being changed.
    struct {
        uint32_t reports; ///< TM[3,25] and [3,26] sent.
        uint32_t dropped; ///< Reports that the port refused, or that did not arrive from their loop.
    } counters;
} pus_hk_t;

void pus_hk_init(pus_hk_t* hk, const pus_hk_config_t* config);
/// The service's entry for a dispatcher; subtypes and step included.
pus_service_t pus_hk_service(pus_hk_t* hk);
/// Add a structure from the configuration. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED (no structure left, or
/// too many parameters, sets or octets), STATUS_NOT_FOUND (a parameter), STATUS_FORBIDDEN (not readable),
/// STATUS_INVALID (no parameter, same one twice, interval or repetitions out of range).
MUST_USE status_t pus_hk_add(pus_hk_t* hk, const pus_hk_definition_t* definition);
/// Restore a record: a functional reporting definition. STATUS_OK, STATUS_EXHAUSTED (no room),
/// STATUS_INVALID (no such record).
MUST_USE status_t pus_hk_restore(void* self, uint32_t key, const uint8_t* octets, size_t size);
/// Delete all structures: the configuration is revoked.
void pus_hk_clear(pus_hk_t* hk);
/// Take due samples and send complete reports. `cycle` may jump forward; missed samples are then taken late,
/// with the present values.
void pus_hk_step(pus_hk_t* hk, uint64_t now_ns, uint32_t cycle);
/// As pus_hk_step, for the structures of another loop (1..255). Called in that loop, which holds the guard;
/// `cycle` counts the cycles of that loop.
void pus_hk_loop_step(pus_hk_t* hk, uint8_t loop, uint64_t now_ns, uint32_t cycle,
                      const pus_hk_outlet_t* outlet);
/// Send a report of another loop, stamped with the time its values were taken.
void pus_hk_forward(pus_hk_t* hk, uint16_t id, uint64_t taken_ns, const uint8_t* values, size_t size);
/// Count reports that were lost between their loop and this one.
void pus_hk_count_lost(pus_hk_t* hk, uint32_t reports);

#endif // PUS_ST03_ST03_HOUSEKEEPING_H
