// SPDX-License-Identifier: Apache-2.0
/// ST[03] housekeeping, all 32 messages: reports of parameter values, once or periodically. The configuration
/// or a request defines their structures. Housekeeping structures (TM[3,25]) and diagnostic structures
/// (TM[3,26]) have separate ids and are otherwise equal. Sampling, functional definitions, loops and
/// refusals: docs/services/st03.md.
///
/// A structure can be deleted, extended or given another interval only while its periodic generation is
/// disabled; it is disabled in a new structure. A report that the port refuses is dropped and counted.
///
/// Ownership  The caller provides structures and samples: structure i samples into
///            samples[i * sample_size .. (i + 1) * sample_size - 1].
/// Context    The loop of the process; pus_hk_loop_step in its own loop.
/// Time       A step is O(structures + values sampled).
#ifndef PUS_ST03_ST03_HOUSEKEEPING_H
#define PUS_ST03_ST03_HOUSEKEEPING_H

#include "pus/core/parameter_port.h"
#include "osal/include/osal/mutex.h"
#include "pus/core/service.h"

/// Largest number of parameters of one structure, including those in its sets.
#define PUS_HK_PARAMETERS_MAX 64U
#define PUS_HK_SETS_MAX 8U     ///< Largest number of super-commutated sets of one structure.
#define PUS_HK_MEMBERS_MAX 32U ///< Largest number of structures of one functional reporting definition.

/// A super-commutated set of a structure that the configuration defines. Used only during the call.
typedef struct {
    uint16_t repetitions; ///< Samples per interval, 1..interval.
    uint8_t parameter_count;
    const uint32_t* parameters; ///< Ids.
} pus_hk_set_definition_t;

/// A structure that the configuration defines. Used only during the call.
typedef struct {
    uint16_t id;
    bool is_diagnostic;
    uint32_t interval; ///< [cycles], >= 1.
    bool is_periodic;  ///< Periodic generation is enabled from the start.
    uint8_t loop;      ///< Loop that samples the structure; 0: the loop of the process.
    uint8_t parameter_count;
    uint8_t set_count;
    const uint32_t* parameters; ///< Ids of the simply commutated parameters.
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
    uint16_t offset; // Position of the set's first sample in the sample buffer.
    uint16_t size;   // Size of one sample [octets].
    uint8_t first;   // Index of its first entry.
    uint8_t count;   // Number of its entries.
} pus_hk_set_t;

typedef struct { // Private.
    bool in_use;
    bool is_diagnostic;
    bool is_periodic;
    bool is_collecting; // An interval has begun.
    uint8_t loop;
    uint16_t id;
    uint32_t interval;
    uint32_t start; // Cycle before the first cycle of the interval.
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
    uint8_t* samples; ///< structure_count * sample_size octets.
    /// Size of the values of the largest report [octets], <= PUS_TM_DATA_MAX - 2.
    uint16_t sample_size;
    /// Protects the structures from other loops; null: there are no other loops.
    osal_mutex_t* mutex;
    pus_hk_functional_t* functional; ///< Room for functional reporting definitions.
    uint16_t functional_count;
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_hk_config_t;

typedef struct { // Receiver of the finished reports of a loop.
    void* context;
    /// Take the values of the housekeeping structure `id`, sampled at now_ns. (Loops sample no diagnostic
    /// structures.)
    void (*put)(void* context, uint16_t id, uint64_t now_ns, const uint8_t* values, size_t size);
    uint8_t* values; ///< Buffer of this loop for the values of one report: sample_size octets.
} pus_hk_outlet_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_hk_config_t config;
    pus_hk_structure_t candidate;
    pus_failure_t verdict;          // First failure of the candidate.
    pus_hk_functional_t functional; // Copy of the definition that is being changed.
    struct {
        uint32_t reports; ///< TM[3,25] and [3,26] sent.
        uint32_t dropped; ///< Reports that the port refused, or that were lost on the way from their loop.
    } counters;
} pus_hk_t;

void pus_hk_init(pus_hk_t* hk, const pus_hk_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_hk_service(pus_hk_t* hk);
/// Add a structure from the configuration. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED (no structure left, or
/// too many parameters, sets or octets), STATUS_NOT_FOUND (a parameter), STATUS_FORBIDDEN (not readable),
/// STATUS_INVALID (no parameter, a parameter twice, interval or repetitions out of range).
MUST_USE status_t pus_hk_add(pus_hk_t* hk, const pus_hk_definition_t* definition);
/// Restore a functional reporting definition from its record. STATUS_OK, STATUS_EXHAUSTED (no room),
/// STATUS_INVALID (no such record).
MUST_USE status_t pus_hk_restore(void* self, uint32_t key, const uint8_t* octets, size_t size);
/// Delete all structures, when the configuration is revoked.
void pus_hk_clear(pus_hk_t* hk);
/// Take due samples and send complete reports. `cycle` may jump forward; the missed samples then get the
/// present values.
void pus_hk_step(pus_hk_t* hk, uint64_t now_ns, uint32_t cycle);
/// Like pus_hk_step, for the structures of another loop (1..255). Called in that loop, which has locked
/// `mutex`; `cycle` counts the cycles of that loop.
void pus_hk_loop_step(pus_hk_t* hk, uint8_t loop, uint64_t now_ns, uint32_t cycle,
                      const pus_hk_outlet_t* outlet);
/// Send a report of another loop, with the time at which its values were sampled.
void pus_hk_forward(pus_hk_t* hk, uint16_t id, uint64_t taken_ns, const uint8_t* values, size_t size);
/// Count reports that were lost between their loop and this one.
void pus_hk_count_lost(pus_hk_t* hk, uint32_t reports);

#endif // PUS_ST03_ST03_HOUSEKEEPING_H
