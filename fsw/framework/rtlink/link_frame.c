// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/link_frame.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc.h"
#include "fsw/framework/base/octets.h"

#include <string.h>

#define MAGIC 0x5254U
#define VERSION 1U

/// Place of each field in the header, whose length is fixed and known to all.
enum {
    AT_MAGIC    = 0,
    AT_VERSION  = 2,
    AT_STATE    = 3,
    AT_LINK     = 4,
    AT_FLAGS    = 6,
    AT_EPOCH    = 8,
    AT_SEQUENCE = 12,
    AT_TIME     = 16
};

void link_frame_encode_header(const link_frame_header_t* const header,
                              uint8_t out_octets[LINK_FRAME_HEADER_OCTETS])
{
    FSW_ASSERT((header != NULL) && (out_octets != NULL));
    octets_put_u16(&out_octets[AT_MAGIC], MAGIC);
    out_octets[AT_VERSION] = VERSION;
    out_octets[AT_STATE]   = header->producer_state;
    octets_put_u16(&out_octets[AT_LINK], header->link);
    octets_put_u16(&out_octets[AT_FLAGS], 0U);
    octets_put_u32(&out_octets[AT_EPOCH], header->epoch);
    octets_put_u32(&out_octets[AT_SEQUENCE], header->sequence);
    octets_put_u64(&out_octets[AT_TIME], header->time_ns);
}

size_t link_frame_encode(const link_frame_header_t* const header, const uint8_t* const payload,
                         const size_t payload_size, const bool with_crc, uint8_t out_frame[LINK_FRAME_MAX])
{
    FSW_ASSERT((header != NULL) && (payload != NULL));
    FSW_ASSERT((payload_size >= 1U) && (payload_size <= RTLINK_PAYLOAD_MAX));
    const size_t checked = LINK_FRAME_HEADER_OCTETS + payload_size;
    link_frame_encode_header(header, out_frame);
    (void)memcpy(&out_frame[LINK_FRAME_HEADER_OCTETS], payload, payload_size);
    if (with_crc) {
        octets_put_u32(&out_frame[checked], crc32_iso(out_frame, checked));
    }
    return checked + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U);
}

status_t link_frame_decode(const uint8_t* const frame, const size_t size, const size_t payload_size,
                           const bool with_crc, link_frame_header_t* const out_header,
                           const uint8_t** const out_payload)
{
    FSW_ASSERT((frame != NULL) && (out_header != NULL) && (out_payload != NULL));
    const size_t checked = LINK_FRAME_HEADER_OCTETS + payload_size;
    if (size != (checked + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U))) {
        return STATUS_TRUNCATED;
    }
    out_header->producer_state = frame[AT_STATE];
    out_header->link           = octets_u16_at(&frame[AT_LINK]);
    out_header->epoch          = octets_u32_at(&frame[AT_EPOCH]);
    out_header->sequence       = octets_u32_at(&frame[AT_SEQUENCE]);
    out_header->time_ns        = octets_u64_at(&frame[AT_TIME]);
    *out_payload               = &frame[LINK_FRAME_HEADER_OCTETS];
    if ((octets_u16_at(&frame[AT_MAGIC]) != MAGIC) || (frame[AT_VERSION] != VERSION) ||
        (octets_u16_at(&frame[AT_FLAGS]) != 0U)) {
        return STATUS_INVALID;
    }
    if (with_crc && (octets_u32_at(&frame[checked]) != crc32_iso(frame, checked))) {
        return STATUS_CHECKSUM;
    }
    return STATUS_OK;
}
