// SPDX-License-Identifier: Apache-2.0
/// Header of a message frame; docs/framework.md, "Messages", defines its layout.
///
/// Context    Any.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_FRAME_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_FRAME_H

#include "fsw/framework/message/message.h"

#include "base/octets.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MESSAGE_AT_KIND 3U ///< Offset of the kind in the header.
#define MESSAGE_DATA 0U
#define MESSAGE_CREDIT 1U
#define MESSAGE_SYNC 2U
#define MESSAGE_SYNC_ACK 3U ///< The last kind.

typedef struct {
    uint8_t kind;
    uint16_t from;
    uint16_t to;
    uint32_t from_life;
    uint32_t to_life;
    uint32_t sequence;
    uint32_t taken;
    size_t size; ///< Size of the payload.
} message_frame_t;

void message_frame_write(const message_frame_t* frame, uint8_t header[MESSAGE_HEADER_OCTETS]);
/// Decode a header of this kind; `size` is the size of the frame.
message_frame_t message_frame_read(const uint8_t header[MESSAGE_HEADER_OCTETS], uint8_t kind, size_t size);
/// Read single fields of a header.
static inline uint16_t message_frame_from(const uint8_t header[MESSAGE_HEADER_OCTETS])
{
    return octets_u16_at(&header[4]);
}
static inline uint32_t message_frame_life(const uint8_t header[MESSAGE_HEADER_OCTETS])
{
    return octets_u32_at(&header[8]);
}
static inline uint32_t message_frame_sequence(const uint8_t header[MESSAGE_HEADER_OCTETS])
{
    return octets_u32_at(&header[16]);
}
/// True if the octets are a frame that is addressed to component `self`.
bool message_frame_is_well_formed(const uint8_t* octets, size_t size, uint16_t self);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_FRAME_H
