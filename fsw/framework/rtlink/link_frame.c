// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/link_frame.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "base/octets.h"

#include <string.h>

#define MAGIC 0x5254U
#define VERSION 1U

/// Returns the first word of the header: magic, version, state, link and flags, from the most significant
/// octet on.
static uint64_t first_word(const uint8_t state, const uint16_t link)
{
    return ((uint64_t)MAGIC << 48U) | ((uint64_t)VERSION << 40U) | ((uint64_t)state << 32U) |
           ((uint64_t)link << 16U);
}

void rtlink_frame_pack(const rtlink_frame_header_t* const header, uint64_t out_words[LINK_FRAME_HEADER_WORDS])
{
    FSW_ASSERT((header != NULL) && (out_words != NULL));
    out_words[0] = first_word(header->producer_state, header->link);
    out_words[1] = ((uint64_t)header->epoch << 32U) | header->sequence;
    out_words[2] = header->time_ns;
}

status_t rtlink_frame_unpack(const uint64_t words[LINK_FRAME_HEADER_WORDS],
                             rtlink_frame_header_t* const out_header)
{
    FSW_ASSERT((words != NULL) && (out_header != NULL));
    *out_header = (rtlink_frame_header_t){.producer_state = (uint8_t)((words[0] >> 32U) & 0xFFU),
                                          .link           = (uint16_t)((words[0] >> 16U) & 0xFFFFU),
                                          .epoch          = (uint32_t)(words[1] >> 32U),
                                          .sequence       = (uint32_t)(words[1] & UINT32_MAX),
                                          .time_ns        = words[2]};
    return (words[0] == first_word(out_header->producer_state, out_header->link)) ? STATUS_OK
                                                                                  : STATUS_INVALID;
}

size_t rtlink_frame_encode(const rtlink_frame_header_t* const header, const uint8_t* const payload,
                           const size_t payload_size, const bool with_crc, uint8_t out_frame[LINK_FRAME_MAX])
{
    FSW_ASSERT((header != NULL) && (payload != NULL));
    FSW_ASSERT((payload_size >= 1U) && (payload_size <= RTLINK_PAYLOAD_MAX));
    const size_t checked = LINK_FRAME_HEADER_OCTETS + payload_size;
    uint64_t words[LINK_FRAME_HEADER_WORDS];
    rtlink_frame_pack(header, words);
    for (size_t i = 0U; i < LINK_FRAME_HEADER_WORDS; i++) {
        octets_put_u64(&out_frame[8U * i], words[i]);
    }
    (void)memcpy(&out_frame[LINK_FRAME_HEADER_OCTETS], payload, payload_size);
    if (with_crc) {
        octets_put_u32(&out_frame[checked], crc32_iso(out_frame, checked));
    }
    return checked + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U);
}

uint32_t rtlink_frame_epoch(const uint8_t* const frame, const size_t size)
{
    FSW_ASSERT(frame != NULL);
    return (size >= LINK_FRAME_HEADER_OCTETS) ? octets_u32_at(&frame[8U]) : 0U;
}

status_t rtlink_frame_decode(const uint8_t* const frame, const size_t size, const size_t payload_size,
                             const bool with_crc, rtlink_frame_header_t* const out_header,
                             const uint8_t** const out_payload)
{
    FSW_ASSERT((frame != NULL) && (out_header != NULL) && (out_payload != NULL));
    const size_t checked = LINK_FRAME_HEADER_OCTETS + payload_size;
    if (size != (checked + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U))) {
        return STATUS_TRUNCATED;
    }
    uint64_t words[LINK_FRAME_HEADER_WORDS];
    for (size_t i = 0U; i < LINK_FRAME_HEADER_WORDS; i++) {
        words[i] = octets_u64_at(&frame[8U * i]);
    }
    *out_payload = &frame[LINK_FRAME_HEADER_OCTETS];
    if (rtlink_frame_unpack(words, out_header) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (with_crc && (octets_u32_at(&frame[checked]) != crc32_iso(frame, checked))) {
        return STATUS_CHECKSUM;
    }
    return STATUS_OK;
}
