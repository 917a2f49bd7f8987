// SPDX-License-Identifier: Apache-2.0
/// Format of octets on a data flow: framing, byte order, bit rate. The descriptor of an end node defines it;
/// the flow applies it. All zeros: raw octets, most significant first.
#ifndef BASE_FLOW_FORMAT_H
#define BASE_FLOW_FORMAT_H

#include <stdint.h>

typedef enum {
    FLOW_FRAMING_RAW,    ///< No frames: octets in any division. On datagrams and queues: one frame each.
    FLOW_FRAMING_LENGTH, ///< Length of 16 bits in the byte order of the flow, then that many octets.
    FLOW_FRAMING_SLIP,   ///< RFC 1055: 0xC0 before and after, escapes inside.
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
    flow_direction_t direction; ///< For a file; all others go both ways.
    uint32_t baud;              ///< Bit rate of a serial line [bit/s].
} flow_format_t;

#endif // BASE_FLOW_FORMAT_H
