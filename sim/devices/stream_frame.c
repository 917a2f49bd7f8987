// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/stream_frame.h"

#include <string.h>

#define LENGTH_OCTETS 2U
#define SLIP_END 0xC0U
#define SLIP_ESCAPE 0xDBU
#define SLIP_ESCAPED_END 0xDCU
#define SLIP_ESCAPED_ESCAPE 0xDDU

static size_t put_slip(const uint8_t* const message, const size_t size, uint8_t* const frame)
{
    size_t length   = 0U;
    frame[length++] = SLIP_END;
    for (size_t i = 0U; i < size; i++) {
        if (message[i] == SLIP_END) {
            frame[length++] = SLIP_ESCAPE;
            frame[length++] = SLIP_ESCAPED_END;
        } else if (message[i] == SLIP_ESCAPE) {
            frame[length++] = SLIP_ESCAPE;
            frame[length++] = SLIP_ESCAPED_ESCAPE;
        } else {
            frame[length++] = message[i];
        }
    }
    frame[length++] = SLIP_END;
    return length;
}

size_t stream_frame_put(const stream_framing_t* const framing, const uint8_t* const message,
                        const size_t size, uint8_t* const frame)
{
    if (framing->is_slip) {
        return put_slip(message, size, frame);
    }
    frame[framing->is_little ? 1U : 0U] = (uint8_t)(size >> 8U);
    frame[framing->is_little ? 0U : 1U] = (uint8_t)(size & 0xFFU);
    memcpy(&frame[LENGTH_OCTETS], message, size);
    return size + LENGTH_OCTETS;
}

static void drop(uint8_t* const octets, size_t* const held, const size_t size)
{
    *held -= size;
    memmove(octets, &octets[size], *held);
}

static bool take_counted(const stream_framing_t* const framing, uint8_t* const octets, size_t* const held,
                         uint8_t* const message, size_t* const out_size)
{
    if (*held < LENGTH_OCTETS) {
        return false;
    }
    const size_t high = octets[framing->is_little ? 1U : 0U];
    const size_t size = (high << 8U) | octets[framing->is_little ? 0U : 1U];
    if (size > STREAM_FRAME_MESSAGE_MAX) {
        *held = 0U;
        return false;
    }
    if (*held < (size + LENGTH_OCTETS)) {
        return false;
    }
    memcpy(message, &octets[LENGTH_OCTETS], size);
    *out_size = size;
    drop(octets, held, size + LENGTH_OCTETS);
    return true;
}

static size_t unescape(const uint8_t* const octets, const size_t size, uint8_t* const message)
{
    size_t length = 0U;
    for (size_t i = 0U; (i < size) && (length < STREAM_FRAME_MESSAGE_MAX); i++) {
        uint8_t octet = octets[i];
        if ((octet == SLIP_ESCAPE) && ((i + 1U) < size)) {
            i++;
            octet = (octets[i] == SLIP_ESCAPED_END) ? SLIP_END : SLIP_ESCAPE;
        }
        message[length++] = octet;
    }
    return length;
}

static bool take_slip(uint8_t* const octets, size_t* const held, uint8_t* const message,
                      size_t* const out_size)
{
    const uint8_t* frame_end = memchr(octets, SLIP_END, *held);
    while (frame_end != NULL) {
        const size_t size = (size_t)(frame_end - octets);
        *out_size         = unescape(octets, size, message);
        drop(octets, held, size + 1U);
        if (*out_size > 0U) {
            return true;
        }
        frame_end = memchr(octets, SLIP_END, *held);
    }
    if (*held > STREAM_FRAME_OCTETS(STREAM_FRAME_MESSAGE_MAX)) {
        *held = 0U;
    }
    return false;
}

bool stream_frame_take(const stream_framing_t* const framing, uint8_t* const octets, size_t* const held,
                       uint8_t* const message, size_t* const out_size)
{
    return framing->is_slip ? take_slip(octets, held, message, out_size)
                            : take_counted(framing, octets, held, message, out_size);
}
