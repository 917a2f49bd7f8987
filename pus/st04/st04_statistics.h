// SPDX-License-Identifier: Apache-2.0
/// ST[04] parameter statistics: for each defined scalar parameter the number of samples, the largest and the
/// smallest value with their times, mean and standard deviation. All 9 messages. Sampling and reports:
/// docs/services/st04.md.
///
/// Definitions and the reporting interval are persistent; samples are not.
///
/// Ownership  The caller provides all storage.
/// Context    The loop of the process.
/// Time       A step is O(samples due * log definitions), and O(definitions) if a report is due; a request
///            O(entries * definitions).
#ifndef PUS_ST04_ST04_STATISTICS_H
#define PUS_ST04_ST04_STATISTICS_H

#include "pus/core/due_heap.h"
#include "pus/core/scalar.h"
#include "pus/core/service.h"

typedef struct { // Private.
    bool in_use;
    pus_scalar_t scalar;
    int64_t interval_ticks; // Interval of the request [2^-24 s].
    uint64_t interval;      // [cycles]
    uint32_t samples;
    uint64_t maximum;
    uint64_t minimum;
    uint64_t maximum_ns; // Time of the maximum [ns since 1958].
    uint64_t minimum_ns;
    double mean;
    double squares; // Sum of the squared distances from the mean.
} pus_statistic_t;

typedef struct {
    pus_app_process_t* process;
    pus_parameter_port_t parameters;      ///< `write` is not used.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    pus_statistic_t* statistics;          ///< This array and the next two have `capacity` entries.
    pus_due_t* due;
    uint16_t* positions;
    uint16_t capacity;
    uint64_t cycle_ns; ///< Minimum sampling interval [ns], >= 1.
} pus_statistics_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_statistics_config_t config;
    pus_due_heap_t due;
    uint64_t cycle;      // Cycle count, extended to 64 bits.
    uint32_t last_cycle; // Last cycle count of the caller.
    bool is_started;     // start_ns is known.
    uint64_t start_ns;
    int64_t reporting_ticks; // 0: no periodic reports.
    uint64_t reporting_interval;
    uint64_t next_report; // Cycle of the next periodic report.
    struct {
        uint32_t samples;    ///< Samples taken.
        uint32_t missing;    ///< Samples not taken because the parameter was unavailable.
        uint32_t not_finite; ///< Values that were not finite.
        uint32_t lost;       ///< Periodic reports that were not sent completely.
        uint32_t refused;    ///< Instructions and requests refused.
        uint32_t unsaved;    ///< Records that could not be stored or erased; their changes were refused.
    } counters;
} pus_statistics_t;

/// Start without definitions and without periodic reports.
void pus_statistics_init(pus_statistics_t* self, const pus_statistics_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_statistics_service(pus_statistics_t* self);
/// Restore one record. STATUS_OK, STATUS_INVALID (malformed, not a scalar, or an interval out of range),
/// STATUS_EXHAUSTED (no room). The parameter does not need to exist yet.
MUST_USE status_t pus_statistics_restore(pus_statistics_t* self, uint32_t key, const uint8_t* octets,
                                         size_t size);
/// Take the samples that are due, and report. `cycle` counts minimum sampling intervals and may jump forward.
void pus_statistics_step(pus_statistics_t* self, uint64_t now_ns, uint32_t cycle);

#endif // PUS_ST04_ST04_STATISTICS_H
