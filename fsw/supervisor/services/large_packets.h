// SPDX-License-Identifier: Apache-2.0
/// Storage of the large packet transfer of ST[13]. A request to the supervisor itself may have any length
/// that the length field permits. A request to another subsystem may not be longer than a packet; a longer
/// one is refused at the part that completes its length field (failure code PUS_FAILURE_TABLE_FULL, detail
/// PUS_PACKET_MAX). A report of the supervisor may have up to PUS_LARGE_MAX octets.
#ifndef FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H
#define FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H

#include "pus/st13/st13_large_packets.h"

/// Largest number of reports that are sent at the same time.
#define SPACECRAFT_LARGE_REPORTS 4U
/// Largest number of requests that are assembled at the same time.
#define SPACECRAFT_LARGE_UPLINKS 4U
#define SPACECRAFT_LARGE_PARTS 8U                   ///< Largest number of parts sent in one step.
#define SPACECRAFT_LARGE_TIMEOUT_NS 120000000000ULL ///< Longest time between two parts of a request.

typedef struct { // Private to fsw/supervisor.
    pus_large_t service;
    pus_large_report_t reports[SPACECRAFT_LARGE_REPORTS];
    uint8_t report_octets[SPACECRAFT_LARGE_REPORTS * PUS_LARGE_MAX];
    pus_large_uplink_t uplinks[SPACECRAFT_LARGE_UPLINKS];
    uint8_t uplink_octets[SPACECRAFT_LARGE_UPLINKS * PUS_LARGE_MAX];
} spacecraft_large_packets_t;

#endif // FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H
