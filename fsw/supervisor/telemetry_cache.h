// SPDX-License-Identifier: Apache-2.0
/// Cache of telemetered parameters: the value of each parameter of the subsystems that was last reported in
/// TM[3,25], TM[3,26] or TM[20,2], with the time of that report. Through pus_parameter_port_t the
/// supervisor's services read parameters of other components from the cache; they cannot set them.
///
/// Definitions list the values of a report; they come from supervisor_telemetry_cache_define, or from
/// TM[3,10] and TM[3,12]. The cache stores the last sample of a super-commutated set. The layout bits of a
/// scalar's id contain its size; `size_of` returns the sizes of other parameters. Reports of unknown
/// structures, and values of TM[20,2] after one of unknown size, are ignored; reports whose length differs
/// from the definition are ignored and counted.
///
/// A parameter is known after its first definition, report or look-up. Until its first report it is zero.
///
/// Ownership  The caller provides telemetry_cache_t.
/// Context    One loop.
/// Time       Look-up of a parameter O(1); a report O(structures + its values).
#ifndef FSW_SUPERVISOR_TELEMETRY_CACHE_H
#define FSW_SUPERVISOR_TELEMETRY_CACHE_H

#include "pus/core/packet.h"
#include "pus/core/parameter_port.h"

#include <stdbool.h>

#define TELEMETRY_CACHE_PARAMETERS 2048U
#define TELEMETRY_CACHE_BUCKETS 4096U   ///< A power of two that exceeds the number of parameters.
#define TELEMETRY_CACHE_OCTETS 65536U   ///< Octets of all values.
#define TELEMETRY_CACHE_STRUCTURES 256U ///< Housekeeping and diagnostic structures of all subsystems.
#define TELEMETRY_CACHE_INTERVALS 3U
#define TELEMETRY_CACHE_AGE_MIN_NS 3000000000ULL
#define TELEMETRY_CACHE_ENTRIES 8192U ///< Number of entries of all structures' definitions.

/// Source of the sizes of parameters that are not scalars.
typedef struct {
    void* context;
    /// Get the size of a parameter on the wire [octets], >= 1. STATUS_OK, STATUS_NOT_FOUND. Null: no sizes
    /// are known.
    status_t (*size_of)(void* context, uint32_t parameter_id, uint16_t* out_size);
} telemetry_cache_sizes_t;

typedef struct { // Private.
    uint32_t id;
    uint16_t size;
    uint32_t offset; // Offset of the value.
    bool is_known;   // A value was reported.
    uint64_t taken_ns;
    uint64_t interval_ns; // Time between the last two reports; 0: there was only one.
} telemetry_cache_value_t;

typedef struct { // Private.
    uint16_t apid;
    uint8_t subtype; // Subtype of its reports, 25 or 26.
    uint16_t id;
    uint16_t first; // Index of its first entry; there are `count` entries.
    uint16_t count;
    uint32_t size; // Size of a report's values [octets].
} telemetry_cache_structure_t;

typedef struct {          // Private: one parameter of a structure, or the head of a set.
    uint16_t value;       // Index of the value; for a head: number of parameters that follow.
    uint16_t repetitions; // Repetitions of a set; 0: this entry is a parameter.
} telemetry_cache_entry_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    telemetry_cache_sizes_t sizes;
    uint16_t value_count;
    uint16_t structure_count;
    uint16_t entry_count;
    uint32_t octet_count;
    telemetry_cache_value_t values[TELEMETRY_CACHE_PARAMETERS];
    uint16_t buckets[TELEMETRY_CACHE_BUCKETS]; // Index + 1 of a value, 0 if free.
    telemetry_cache_structure_t structures[TELEMETRY_CACHE_STRUCTURES];
    telemetry_cache_entry_t entries[TELEMETRY_CACHE_ENTRIES];
    uint8_t octets[TELEMETRY_CACHE_OCTETS];
    struct {
        uint32_t taken; ///< Values taken from reports.
        /// Reports that do not match their definition, malformed definitions, and TM[20,2] that are too short
        /// or have a parameter without a known size or without room.
        uint32_t unfitting;
        uint32_t full; ///< Parameters or definitions for which there was no room.
    } counters;
} telemetry_cache_t;

void supervisor_telemetry_cache_init(telemetry_cache_t* cache, const telemetry_cache_sizes_t* sizes);
/// Store the values, or the definition of a structure, that a report contains. Other reports are ignored.
void supervisor_telemetry_cache_observe(telemetry_cache_t* cache, const pus_tm_t* tm);
/// Add or replace the definition of a structure. `content` is the part of TM[3,10] that lists the
/// parameters: N1 x {id}, NFA x {repetitions, N2 x {id}}, counts u16. `subtype` is the subtype of its
/// reports, 25 or 26. STATUS_OK; STATUS_INVALID (malformed, or of unknown size), STATUS_EXHAUSTED (no room):
/// the structure is then not known.
status_t supervisor_telemetry_cache_define(telemetry_cache_t* cache, uint16_t apid, uint8_t subtype,
                                           uint16_t id, octet_reader_t* content);
/// Returns the port to the values; it is valid as long as the telemetry cache.
pus_parameter_port_t supervisor_telemetry_cache_port(telemetry_cache_t* cache);
/// True if a value was reported regularly but has not been reported for TELEMETRY_CACHE_INTERVALS of its
/// intervals, and for at least TELEMETRY_CACHE_AGE_MIN_NS. A value that was reported only once never becomes
/// old. `now_ns` counts from 1958-01-01 TAI, as the times of reports.
bool supervisor_telemetry_cache_is_old(const telemetry_cache_t* cache, uint32_t parameter_id,
                                       uint64_t now_ns);
/// Get the octets of a parameter's last reported value; they change with the next report. STATUS_OK,
/// STATUS_NOT_FOUND (unknown), STATUS_EMPTY (not reported yet).
MUST_USE status_t supervisor_telemetry_cache_value(const telemetry_cache_t* cache, uint32_t parameter_id,
                                                   const uint8_t** out_octets, uint16_t* out_size);

#endif // FSW_SUPERVISOR_TELEMETRY_CACHE_H
