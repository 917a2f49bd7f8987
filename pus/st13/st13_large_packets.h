// SPDX-License-Identifier: Apache-2.0
/// ST[13] large packet transfer: packets longer than PUS_PACKET_MAX, up to PUS_LARGE_MAX, are transferred in
/// parts. The parts carry the whole packet, headers and checksum included, and are numbered from 1. Transfers
/// and refusals: docs/services/st13.md.
///
/// Downlink: a report of any service is built here instead of in the process. A report that fits a packet is
/// sent in one packet. Uplink: when all parts of a request have arrived, `take` gets the request.
///
/// Ownership  The caller provides buffers and lists, which outlive the service. The argument of `take` is
///            valid during the call.
/// Context    One loop.
/// Time       O(octets moved); a step sends at most `parts_per_step` parts, and is O(uplinks).
#ifndef PUS_ST13_ST13_LARGE_PACKETS_H
#define PUS_ST13_ST13_LARGE_PACKETS_H

#include "pus/core/service.h"

#define PUS_LARGE_PART 512U ///< Size of a part of a report; the last may be shorter [octets].

/// Subtype of the last part of a report; the subtypes of the other parts are smaller.
#define PUS_LARGE_LAST_DOWN 3U

typedef enum {
    PUS_LARGE_TIMEOUT       = 1,
    PUS_LARGE_DISCONTINUITY = 2,
    PUS_LARGE_NOT_ACCEPTED  = 3 ///< Too large, malformed, or not taken by the application in time.
} pus_large_reason_t;

typedef struct { // Private.
    uint16_t transaction;
    uint16_t destination;
    size_t size;
    size_t sent;
} pus_large_report_t;

typedef struct { // Private.
    bool is_used;
    bool is_whole;
    uint16_t transaction;
    uint16_t next_part;
    size_t size;
    uint64_t heard_ns;
    pus_token_t token; // Token of the last part.
} pus_large_uplink_t;

typedef struct {
    pus_app_process_t* process;
    pus_large_report_t* reports; ///< `report_count` entries; the buffer of each has `report_size` octets.
    uint8_t* report_octets;
    size_t report_count; ///< >= 1.
    size_t report_size;  ///< PUS_PACKET_MAX..PUS_LARGE_MAX.
    uint16_t parts_per_step;
    pus_large_uplink_t* uplinks; ///< `uplink_count` entries; the buffer of each has `uplink_size` octets.
    uint8_t* uplink_octets;
    size_t uplink_count;
    size_t uplink_size;  ///< Longest request that is assembled [octets], up to PUS_LARGE_MAX.
    uint64_t timeout_ns; ///< Longest time between two parts, and until `take` accepts the request.
    void* context;
    /// Size of the largest request that an application takes [octets]; `uplink_size` also limits it.
    size_t (*limit)(void* context, uint16_t apid);
    /// Take a whole request, as if it was received in one packet. STATUS_OK, or any other status: try again
    /// later.
    status_t (*take)(void* context, const uint8_t* packet, size_t size, uint64_t now_ns);
} pus_large_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_large_config_t config;
    size_t first_report; // Index of the report that is being sent; `posted` reports follow in the ring.
    size_t posted;
    bool is_building;
    uint16_t transaction; // Transaction of the next long report.
    struct {
        uint32_t reports;  ///< Reports of which all parts were sent.
        uint32_t parts;    ///< Parts of reports sent.
        uint32_t requests; ///< Requests that were assembled and taken.
        uint32_t aborted;  ///< Aborted uplinks.
        uint32_t refused;  ///< Parts refused, and reports for which there was no buffer.
    } counters;
} pus_large_t;

void pus_large_init(pus_large_t* large, const pus_large_config_t* config);

/// Begin a report of any service, one at a time; the writer takes as much as the buffer holds. STATUS_OK,
/// STATUS_FULL (all buffers are in use: counted, try again later).
MUST_USE status_t pus_large_begin(pus_large_t* large, uint8_t service, uint8_t subtype, uint16_t destination,
                                  uint64_t now_ns, octet_writer_t* out_writer);
/// Finish the report: post it if it fits a packet (pus_tm_post), else send it in parts from the next step on.
/// STATUS_OK, STATUS_TOO_LARGE (longer than the buffer: discarded), STATUS_EXHAUSTED (it fits a packet, but
/// the process has no room: lost, counted).
status_t pus_large_post(pus_large_t* large, octet_writer_t* writer);

/// Send parts, pass complete requests on, abort uplinks that wait too long; to be called once per cycle.
void pus_large_step(pus_large_t* large, uint64_t now_ns);
/// True if the next step has work. An uplink that waits for its next part does not count; the first step
/// after its time-out aborts it.
bool pus_large_is_busy(const pus_large_t* large);
/// Returns the port by which a process builds its long reports here (pus_app_process_lengthen); `context` is
/// the service.
pus_long_port_t pus_large_port(pus_large_t* large);
/// Entry of the service for a dispatcher.
pus_service_t pus_large_service(pus_large_t* large);

#endif // PUS_ST13_ST13_LARGE_PACKETS_H
