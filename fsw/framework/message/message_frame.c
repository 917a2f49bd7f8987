// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_frame.h"

#include "base/octets.h"

#define MAGIC 0x484DU
#define VERSION 1U

/// Offset of each field in the header; that of the kind is MESSAGE_AT_KIND.
enum {
    AT_MAGIC     = 0,
    AT_VERSION   = 2,
    AT_FROM      = 4,
    AT_TO        = 6,
    AT_FROM_LIFE = 8,
    AT_TO_LIFE   = 12,
    AT_SEQUENCE  = 16,
    AT_TAKEN     = 20
};

void message_frame_write(const message_frame_t* const frame, uint8_t header[MESSAGE_HEADER_OCTETS])
{
    octets_put_u16(&header[AT_MAGIC], MAGIC);
    header[AT_VERSION]      = VERSION;
    header[MESSAGE_AT_KIND] = frame->kind;
    octets_put_u16(&header[AT_FROM], frame->from);
    octets_put_u16(&header[AT_TO], frame->to);
    octets_put_u32(&header[AT_FROM_LIFE], frame->from_life);
    octets_put_u32(&header[AT_TO_LIFE], frame->to_life);
    octets_put_u32(&header[AT_SEQUENCE], frame->sequence);
    octets_put_u32(&header[AT_TAKEN], frame->taken);
}

message_frame_t message_frame_read(const uint8_t header[MESSAGE_HEADER_OCTETS], const uint8_t kind,
                                   const size_t size)
{
    return (message_frame_t){.kind      = kind,
                             .from      = octets_u16_at(&header[AT_FROM]),
                             .to        = octets_u16_at(&header[AT_TO]),
                             .from_life = octets_u32_at(&header[AT_FROM_LIFE]),
                             .to_life   = octets_u32_at(&header[AT_TO_LIFE]),
                             .sequence  = octets_u32_at(&header[AT_SEQUENCE]),
                             .taken     = octets_u32_at(&header[AT_TAKEN]),
                             .size      = size - MESSAGE_HEADER_OCTETS};
}

bool message_frame_is_well_formed(const uint8_t* const octets, const size_t size, const uint16_t self)
{
    return (size >= MESSAGE_HEADER_OCTETS) && (size <= MESSAGE_FRAME_MAX) &&
           (octets_u16_at(&octets[AT_MAGIC]) == MAGIC) && (octets[AT_VERSION] == VERSION) &&
           (octets[MESSAGE_AT_KIND] <= MESSAGE_SYNC_ACK) && (octets_u16_at(&octets[AT_TO]) == self) &&
           (octets_u32_at(&octets[AT_FROM_LIFE]) != 0U);
}
