// SPDX-License-Identifier: Apache-2.0
/// ST[09] time management: TC[9,1] sets the rate of the time reports of the spacecraft, one every 2^v
/// seconds. TM[9,2] has the time as CUC, TM[9,3] as CDS; the configuration selects one of the two. Layout and
/// refusals: docs/services/st09.md.
///
/// A report is sent in the first step at or after each multiple of its period in mission time; after a jump
/// of mission time only one report is sent. A report that the port refuses is built again in the next step,
/// with the time of that step. The rate is one persistent record, key 0.
///
/// Ownership  The caller provides pus_time_t.
/// Context    One loop.
/// Time       O(1).
#ifndef PUS_ST09_ST09_TIME_H
#define PUS_ST09_ST09_TIME_H

#include "pus/core/persistence.h"
#include "pus/core/service.h"

#define PUS_TIME_PACKET_SIZE 18U ///< Size of a time report [octets].
#define PUS_TIME_EXPONENT_MAX 8U ///< Largest exponent v of the rate.
#define PUS_TIME_NO_REPORTS 255U ///< Value of `exponent` in the configuration: no reports before TC[9,1].

typedef enum {
    PUS_TIME_CUC = 2, ///< The value of each format is the subtype of its report.
    PUS_TIME_CDS = 3
} pus_time_format_t;

typedef struct {
    uint32_t epoch_s; ///< Epoch of the mission [seconds since 1958-01-01 TAI].
    pus_time_format_t format;
    uint8_t exponent; ///< Initial exponent of the rate, 0..PUS_TIME_EXPONENT_MAX or PUS_TIME_NO_REPORTS.
    uint8_t status;   ///< Spacecraft time reference status; the mission defines its meaning.
    pus_port_t port;  ///< Sends time packets to ground.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_time_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_time_config_t config;
    uint8_t exponent;
    uint16_t sequence;
    uint64_t period; // Number of the last period in which a report was sent; UINT64_MAX: none.
    struct {
        uint32_t sent;
        uint32_t refused; ///< Reports that the port refused.
    } counters;
} pus_time_t;

/// Begin with the rate of the configuration.
void pus_time_init(pus_time_t* time, const pus_time_config_t* config);
/// Restore the persistent record. STATUS_OK; STATUS_NOT_FOUND (key other than 0), STATUS_INVALID: the rate
/// does not change.
MUST_USE status_t pus_time_restore(pus_time_t* time, uint32_t key, const uint8_t* octets, size_t size);
/// Send a report if one is due.
void pus_time_step(pus_time_t* time, uint64_t now_ns);
/// Returns the time at which the next report is due [ns of the run]; now_ns if one is due now, UINT64_MAX if
/// there are no reports.
uint64_t pus_time_due_ns(const pus_time_t* time, uint64_t now_ns);
/// Entry of the service for a dispatcher. It has no `step`: the caller calls pus_time_step once per cycle.
pus_service_t pus_time_service(pus_time_t* time);

/// True if the octets begin a spacecraft time packet, which pus_tm_decode refuses.
bool pus_is_time_packet(const uint8_t* octets, size_t size);

#endif // PUS_ST09_ST09_TIME_H
