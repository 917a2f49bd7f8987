// SPDX-License-Identifier: Apache-2.0
/// Decodes one packet even if it is malformed: all fields that are present, and a list of all errors.
#ifndef PUS_TOOL_PUSDUMP_PACKET_H
#define PUS_TOOL_PUSDUMP_PACKET_H

#include "base/octets.h"
#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROBLEM_MAX 400U ///< Characters of the description of all errors.

typedef struct {
    const uint8_t* octets;
    size_t size;
    bool has_primary;   ///< The packet has a primary header.
    bool has_secondary; ///< The packet has a secondary header.
    bool has_time;      ///< The packet has a time, time_ns.
    bool has_crc;       ///< The packet has a checksum; crc_is_good is its result.
    bool crc_is_good;
    bool is_tc;
    uint16_t apid;
    uint16_t sequence;
    uint8_t flags; ///< Acknowledgement flags of a request, time status of a report.
    uint8_t service;
    uint8_t subtype;
    uint16_t counter; ///< Message type counter of a report.
    uint16_t user;    ///< Source of a request, or destination of a report.
    uint64_t time_ns; ///< Time since the epoch of its time code.
    uint8_t p_field;
    const uint8_t* data; ///< Application or source data; null if their end is not known.
    size_t data_size;
    char problem[PROBLEM_MAX]; ///< Empty if the packet is well-formed.
} dump_packet_t;

/// Read a packet from `octets`. It never fails; `problem` describes all errors.
void dump_packet_read(const uint8_t* octets, size_t size, dump_packet_t* out_packet);
/// Append an error to the description.
void dump_packet_add_problem(dump_packet_t* packet, const char* format, ...)
    __attribute__((format(printf, 2, 3)));
/// True if the time code counts from 1958-01-01.
bool dump_packet_is_tai(const dump_packet_t* packet);

/// Read an absolute time, any CUC (up to 4 + 3 octets) or CDS code. STATUS_OK, STATUS_TRUNCATED,
/// STATUS_INVALID.
MUST_USE status_t dump_time_read(octet_reader_t* reader, uint8_t* out_p_field, uint64_t* out_time_ns);

#endif // PUS_TOOL_PUSDUMP_PACKET_H
