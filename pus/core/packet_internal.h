// SPDX-License-Identifier: Apache-2.0
/// Shared by packet.c, packet_report.c and packet_encode.c: the first fields of requests and reports. Private
/// to these files. The files are separate, so that a program that decodes no reports or composes no whole
/// packets does not contain that code.
#ifndef PUS_CORE_PACKET_INTERNAL_H
#define PUS_CORE_PACKET_INTERNAL_H

#include "pus/core/packet.h"

#define PACKET_TYPE_TC 0x1000U // Bits of the packet's first word.
#define PACKET_SECONDARY_HEADER 0x0800U
#define PACKET_APID_MASK 0x07FFU
#define PACKET_SEQUENCE_MASK 0x3FFFU
#define PACKET_FLAGS_MASK 0x0FU
#define PACKET_LENGTH_FIELD 4U
#define PACKET_LENGTH_OFFSET 7U // Size of a packet minus the value of its length field [octets].

typedef struct {
    uint16_t word0;
    uint16_t word1;
    uint8_t flags; ///< PUS version, and 4 bits: acknowledgement flags (TC) or time reference status (TM).
    uint8_t service;
    uint8_t subtype;
} packet_header_t;

typedef struct {   // Required properties of a packet of one direction.
    size_t least;  ///< Smallest size [octets].
    size_t most;   ///< Largest size [octets].
    uint16_t type; ///< PACKET_TYPE_TC, or 0 for a report.
} packet_form_t;

/// Read the header; the reader fails if there are fewer octets.
void packet_header_read(octet_reader_t* reader, packet_header_t* out_header);
/// Check size, checksum and the header's fields. Statuses of pus_tc_decode; *out_failure has the reason.
MUST_USE status_t packet_check(const uint8_t* octets, size_t size, const packet_form_t* form,
                               const packet_header_t* header, pus_failure_t* out_failure);

#endif // PUS_CORE_PACKET_INTERNAL_H
