// SPDX-License-Identifier: Apache-2.0
/// Format of octets on a data flow: framing, byte order, bit rate. The descriptor of an end node defines the
/// format, and the flow applies it. A structure of zeros means raw octets, most significant octet first.
#ifndef BASE_FLOW_FORMAT_H
#define BASE_FLOW_FORMAT_H

#include <stdint.h>

typedef enum {
    FLOW_FRAMING_RAW,    ///< No frames on a stream; a datagram or a message of a queue is one frame.
    FLOW_FRAMING_LENGTH, ///< Length of 16 bits in the byte order of the flow, then that many octets.
    FLOW_FRAMING_SLIP,   ///< RFC 1055: 0xC0 before and after the frame, escape sequences inside.
    FLOW_FRAMING_LINE, ///< Text; each frame ends with a line feed, or with a carriage return and a line feed.
    FLOW_FRAMINGS
} flow_framing_t;

typedef enum {
    FLOW_ORDER_BIG,
    FLOW_ORDER_LITTLE,
    FLOW_ORDERS
} flow_order_t;

typedef enum {
    FLOW_DIRECTION_BOTH,
    FLOW_DIRECTION_READ,
    FLOW_DIRECTION_WRITE,
    FLOW_DIRECTIONS
} flow_direction_t;

typedef struct {
    flow_framing_t framing;
    flow_order_t order;
    flow_direction_t direction; ///< Direction of a file; all other end nodes read and write.
    uint32_t baud;              ///< Bit rate of a serial line [bit/s].
} flow_format_t;

#endif // BASE_FLOW_FORMAT_H
