// SPDX-License-Identifier: Apache-2.0
/// Storage of the large packet transfer of ST[13]. A request to the supervisor itself may have any length
/// that the length field allows; a request to another subsystem may be as long as a packet: a longer one is
/// refused with the first part that contains its length (PUS_FAILURE_TABLE_FULL, PUS_PACKET_MAX). A report of
/// the supervisor may be as long as a request.
#ifndef FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H
#define FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H

#include "pus/st13/st13_large_packets.h"

#define SPACECRAFT_LARGE_REPORTS 4U                 ///< Under way at once.
#define SPACECRAFT_LARGE_UPLINKS 4U                 ///< Requests that are assembled at once.
#define SPACECRAFT_LARGE_PARTS 8U                   ///< Sent in a step at most.
#define SPACECRAFT_LARGE_TIMEOUT_NS 120000000000ULL ///< Between two parts of a request.

typedef struct { // Private to fsw/supervisor.
    pus_large_t service;
    pus_large_report_t reports[SPACECRAFT_LARGE_REPORTS];
    uint8_t report_octets[SPACECRAFT_LARGE_REPORTS * PUS_LARGE_MAX];
    pus_large_uplink_t uplinks[SPACECRAFT_LARGE_UPLINKS];
    uint8_t uplink_octets[SPACECRAFT_LARGE_UPLINKS * PUS_LARGE_MAX];
} spacecraft_large_packets_t;

#endif // FSW_SUPERVISOR_SERVICES_LARGE_PACKETS_H
