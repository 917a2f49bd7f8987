// SPDX-License-Identifier: Apache-2.0
/// Cache of telemetered parameters: the value of each parameter of the subsystems as it was last reported
/// in TM[3,25], TM[3,26] or TM[20,2], with the time of that report. The supervisor's services read
/// parameters of other components from it by pus_parameter_port_t; nothing is settable.
///
/// Definitions list the values of a report: supervisor_telemetry_cache_define, or TM[3,10] and TM[3,12] as
/// they pass. The last sample of a super-commutated set is kept. The size of a scalar is in the layout bits
/// of its id; `size_of` gives the others. Reports of unknown structures are ignored; so are reports whose
/// length differs from the definition, which are counted, and values of TM[20,2] after one of unknown size.
///
/// A parameter is known from its first definition, report or look-up on; before a report it reads as zeros
/// and has no time.
///
/// Ownership  The caller places it.
/// Context    One loop.
/// Time       Look-up of a parameter O(1); a report O(structures + its values).
#ifndef FSW_SUPERVISOR_TELEMETRY_CACHE_H
#define FSW_SUPERVISOR_TELEMETRY_CACHE_H

#include "pus/core/packet.h"
#include "pus/core/parameter_port.h"

#include <stdbool.h>

#define TELEMETRY_CACHE_PARAMETERS 2048U
#define TELEMETRY_CACHE_BUCKETS 4096U   ///< A power of two, more than the parameters.
#define TELEMETRY_CACHE_OCTETS 65536U   ///< Octets of all values.
#define TELEMETRY_CACHE_STRUCTURES 256U ///< Housekeeping and diagnostic, of all subsystems.
#define TELEMETRY_CACHE_INTERVALS 3U
#define TELEMETRY_CACHE_AGE_MIN_NS 3000000000ULL
#define TELEMETRY_CACHE_ENTRIES 8192U ///< Number of entries of all structures' definitions.

/// Source of the sizes of parameters that are not scalars.
typedef struct {
    void* context;
    /// STATUS_OK (*out_size octets on the wire, >= 1), STATUS_NOT_FOUND. Null: none.
    status_t (*size_of)(void* context, uint32_t parameter_id, uint16_t* out_size);
} telemetry_cache_sizes_t;

typedef struct { // Private.
    uint32_t id;
    uint16_t size;
    uint32_t offset; // Offset of its value.
    bool is_known;   // It was reported.
    uint64_t taken_ns;
    uint64_t interval_ns; // Between the last two reports; 0: there was only one.
} telemetry_cache_value_t;

typedef struct { // Private.
    uint16_t apid;
    uint8_t subtype; // Subtype of its reports, 25 or 26.
    uint16_t id;
    uint16_t first; // Entry; there are `count` of them.
    uint16_t count;
    uint32_t size; // Size of a report's values [octets].
} telemetry_cache_structure_t;

typedef struct {          // Private: one parameter of a structure, or the head of a set.
    uint16_t value;       // Index; for a head: how many parameters follow.
    uint16_t repetitions; // 0: a parameter.
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
        uint32_t taken;     ///< Values taken from reports.
        uint32_t unfitting; ///< Reports that do not fit their definition, or no definition at all.
        uint32_t full;      ///< Parameters or definitions for which there was no room.
    } counters;
} telemetry_cache_t;

void supervisor_telemetry_cache_init(telemetry_cache_t* cache, const telemetry_cache_sizes_t* sizes);
/// Take values or the definition of a structure from a report. Other reports are ignored.
void supervisor_telemetry_cache_observe(telemetry_cache_t* cache, const pus_tm_t* tm);
/// Learn or replace the definition of a structure: `content` is that of TM[3,10] from the parameters on, N1 x
/// {id}, NFA x {repetitions, N2 x {id}}, counts u16. `subtype` is that of its reports, 25 or 26. STATUS_OK;
/// STATUS_INVALID (malformed, or of unknown size), STATUS_EXHAUSTED (no room): it is not known.
status_t supervisor_telemetry_cache_define(telemetry_cache_t* cache, uint16_t apid, uint8_t subtype,
                                           uint16_t id, octet_reader_t* content);
/// Port to the values; valid as long as the telemetry cache.
pus_parameter_port_t supervisor_telemetry_cache_port(telemetry_cache_t* cache);
/// True if a value was reported regularly but has not been reported for TELEMETRY_CACHE_INTERVALS of its
/// intervals, and for at least TELEMETRY_CACHE_AGE_MIN_NS. A value that was reported only once never becomes
/// old. now_ns: since 1958-01-01 TAI, as in reports.
bool supervisor_telemetry_cache_is_old(const telemetry_cache_t* cache, uint32_t parameter_id,
                                       uint64_t now_ns);
/// Octets of a parameter's value as it was last reported; they change with the next report. STATUS_OK,
/// STATUS_NOT_FOUND (unknown), STATUS_EMPTY (not reported yet).
MUST_USE status_t supervisor_telemetry_cache_value(const telemetry_cache_t* cache, uint32_t parameter_id,
                                                   const uint8_t** out_octets, uint16_t* out_size);

#endif // FSW_SUPERVISOR_TELEMETRY_CACHE_H
