// SPDX-License-Identifier: Apache-2.0
// Proves: message_frame_is_well_formed accesses no octet outside a frame, and accepts a frame if and only if
//     it is for this component, has a permitted size and kind, the right magic and version, and a life of its
//     sender other than 0; the fields that message_frame_write wrote are read with the same values, all
//     together and one by one.
// Bounds: every frame of 0..MESSAGE_FRAME_MAX + 1 octets, every header.
// Replaced: nothing.
// Sources: fsw/framework/message/message_frame.c
// Options: --unwind 2
// Quick: yes
// Fault: fsw/framework/message/message_frame.c
//   - return (size >= MESSAGE_HEADER_OCTETS) && (size <= MESSAGE_FRAME_MAX) &&
//   + return (size > 20U) && (size <= MESSAGE_FRAME_MAX) &&
// Fault: fsw/framework/message/message_frame.c
//   - (octets_u16_at(&octets[AT_MAGIC]) == MAGIC) && (octets[AT_VERSION] == VERSION) &&
//   + (octets_u16_at(&octets[AT_MAGIC]) == MAGIC) &&
// Fault: fsw/framework/message/message_frame.c
//   - octets_put_u32(&header[AT_TO_LIFE], frame->to_life);
//   + octets_put_u16(&header[AT_TO_LIFE], (uint16_t)frame->to_life);
// Fault: fsw/framework/message/message_frame.c
//   - return (size >= MESSAGE_HEADER_OCTETS) && (size <= MESSAGE_FRAME_MAX) &&
//   + return (size >= MESSAGE_HEADER_OCTETS) && (size < MESSAGE_FRAME_MAX) &&
#include "fsw/framework/message/message_frame.h"
#include "test/proof/proof.h"

static void prove_reading(void)
{
    const size_t size = any_size(MESSAGE_FRAME_MAX + 1U);
    uint8_t octets[size];
    const uint16_t self    = nondet_u16();
    const bool is_accepted = message_frame_is_well_formed(octets, size, self);
    const bool has_size    = (size >= MESSAGE_HEADER_OCTETS) && (size <= MESSAGE_FRAME_MAX);
    PROVE(IMPLIES(!has_size, !is_accepted), "a frame with a size that is not permitted is refused");
    if (has_size) {
        const message_frame_t frame = message_frame_read(octets, octets[MESSAGE_AT_KIND], size);
        PROVE(is_accepted ==
                  ((octets[0] == 0x48U) && (octets[1] == 0x4DU) && (octets[2] == 1U) &&
                   (frame.kind <= MESSAGE_SYNC_ACK) && (frame.to == self) && (frame.from_life != 0U)),
              "a frame is accepted if and only if it is well formed and for this component");
        PROVE(frame.size == (size - MESSAGE_HEADER_OCTETS), "the payload is what follows the header");
    }
}

static void prove_writing(void)
{
    const message_frame_t sent = {.kind      = nondet_u8(),
                                  .from      = nondet_u16(),
                                  .to        = nondet_u16(),
                                  .from_life = nondet_u32(),
                                  .to_life   = nondet_u32(),
                                  .sequence  = nondet_u32(),
                                  .taken     = nondet_u32()};
    uint8_t header[MESSAGE_HEADER_OCTETS];
    message_frame_write(&sent, header);
    const message_frame_t got = message_frame_read(header, header[MESSAGE_AT_KIND], sizeof header);
    PROVE((got.kind == sent.kind) && (got.from == sent.from) && (got.to == sent.to) &&
              (got.from_life == sent.from_life) && (got.to_life == sent.to_life) &&
              (got.sequence == sent.sequence) && (got.taken == sent.taken) && (got.size == 0U),
          "the header is the same");
    PROVE((message_frame_from(header) == sent.from) && (message_frame_life(header) == sent.from_life) &&
              (message_frame_sequence(header) == sent.sequence),
          "single fields are the same");
    PROVE(message_frame_is_well_formed(header, sizeof header, sent.to) ==
              ((sent.kind <= MESSAGE_SYNC_ACK) && (sent.from_life != 0U)),
          "a written header is well formed if and only if its kind is permitted and its life is not 0");
}

void proof(void)
{
    if (nondet_bool()) {
        prove_reading();
    } else {
        prove_writing();
    }
}
