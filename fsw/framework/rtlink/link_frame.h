// SPDX-License-Identifier: Apache-2.0
/// The data frame of real-time links (not a PUS packet): 24 octets of header, big-endian, then the payload in
/// the producer's byte order, then, on UDP and TIPC only, a CRC-32 over all octets before it.
///
///     magic u16 0x5254 | version u8 1 | producer state u8 | link id u16 | flags u16 0 | epoch u32 |
///     sequence u32 | time u64 [ns of the run]
#ifndef FSW_FRAMEWORK_RTLINK_LINK_FRAME_H
#define FSW_FRAMEWORK_RTLINK_LINK_FRAME_H

#include "base/status.h"
#include "fsw/framework/rtlink/agreement.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LINK_FRAME_HEADER_OCTETS 24U
#define LINK_FRAME_HEADER_WORDS 3U ///< Size of the header in 64-bit words.
#define LINK_FRAME_CRC_OCTETS 4U
#define LINK_FRAME_MAX (LINK_FRAME_HEADER_OCTETS + RTLINK_PAYLOAD_MAX + LINK_FRAME_CRC_OCTETS)

typedef struct {
    uint8_t producer_state; ///< State number of the producing subsystem.
    /// Number of the link.
    uint16_t link;
    /// Number of the opening of the link.
    uint32_t epoch;
    /// Number of the sample since the opening.
    uint32_t sequence;
    /// Time of the sample [ns of the run].
    uint64_t time_ns;
} rtlink_frame_header_t;

/// Write the header as 64-bit numbers for memory that both sides share; their values do not depend on the
/// byte order.
void rtlink_frame_pack(const rtlink_frame_header_t* header, uint64_t out_words[LINK_FRAME_HEADER_WORDS]);
/// Read such a header. STATUS_OK, STATUS_INVALID (magic, version or flags).
MUST_USE status_t rtlink_frame_unpack(const uint64_t words[LINK_FRAME_HEADER_WORDS],
                                      rtlink_frame_header_t* out_header);
/// Encode header, payload and, if requested, CRC. Returns the frame's size [octets].
/// payload_size 1..RTLINK_PAYLOAD_MAX.
size_t rtlink_frame_encode(const rtlink_frame_header_t* header, const uint8_t* payload, size_t payload_size,
                           bool with_crc, uint8_t out_frame[LINK_FRAME_MAX]);
/// Returns the octets at the place of the epoch, without a check of the frame, whose payload may have any
/// layout; 0 if there are fewer octets than a header has.
uint32_t rtlink_frame_epoch(const uint8_t* frame, size_t size);
/// Decode a frame. *out_payload points into `frame`. STATUS_OK; STATUS_INVALID: magic, version or flags;
/// STATUS_TRUNCATED: `size` does not match payload_size; STATUS_CHECKSUM.
MUST_USE status_t rtlink_frame_decode(const uint8_t* frame, size_t size, size_t payload_size, bool with_crc,
                                      rtlink_frame_header_t* out_header, const uint8_t** out_payload);

#endif // FSW_FRAMEWORK_RTLINK_LINK_FRAME_H
