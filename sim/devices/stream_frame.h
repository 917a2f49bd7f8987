// SPDX-License-Identifier: Apache-2.0
/// Framing of messages in a stream of octets, on the side of the device: a length of 16 bits before each
/// message, or SLIP (RFC 1055).
///
/// Context    One task.
#ifndef SIM_DEVICES_STREAM_FRAME_H
#define SIM_DEVICES_STREAM_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STREAM_FRAME_MESSAGE_MAX 64U
#define STREAM_FRAME_OCTETS(message) ((2U * (message)) + 2U) ///< Longest frame of a message.

typedef struct {
    bool is_slip;   ///< True: SLIP; false: a length before each message (LENGTH).
    bool is_little; ///< Byte order of the length: true if little-endian.
} stream_framing_t;

/// Frame a message. Returns the octets of the frame.
size_t stream_frame_put(const stream_framing_t* framing, const uint8_t* message, size_t size, uint8_t* frame);
/// Move the first message from the *held octets to `message` (STREAM_FRAME_MESSAGE_MAX octets). False: no
/// message is complete. If the length field is impossible, or a SLIP frame without end is too long, all
/// octets are dropped. A longer message in a SLIP frame is cut.
bool stream_frame_take(const stream_framing_t* framing, uint8_t* octets, size_t* held, uint8_t* message,
                       size_t* out_size);

#endif // SIM_DEVICES_STREAM_FRAME_H
