// SPDX-License-Identifier: Apache-2.0
/// Framing of octet streams: decodes payloads from octets in any pieces, and encodes payloads.
///
/// The assembler reads each octet once and keeps its state between calls, so that a frame may be cut
/// anywhere. Octets that do not form a frame, and frames that are too long for the buffer, are counted and
/// skipped up to the next frame; invalid octets never end a flow.
///
/// Ownership  The caller provides the assembler and its buffer.
/// Context    One task.
/// Time       O(octets).
/// Errors     Each function lists its statuses; a null argument is a coding error.
#ifndef FSW_FRAMEWORK_DATAFLOW_FRAMING_H
#define FSW_FRAMEWORK_DATAFLOW_FRAMING_H

#include "base/flow_format.h"
#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAMING_LENGTH_MAX 65535U ///< Longest payload with a length of 16 bits.

typedef struct { // [frames, wraps]
    uint32_t complete;
    uint32_t oversize;  ///< Frames longer than the buffer, dropped.
    uint32_t malformed; ///< Frames with an invalid escape sequence, dropped.
    uint32_t cut;       ///< Frames incomplete when the stream ended.
} flow_frame_counters_t;

typedef struct { // Private, except counters: read-only.
    flow_framing_t framing;
    flow_order_t order;
    uint8_t* buffer;
    size_t capacity;
    size_t held;      ///< Octets of the present frame in the buffer.
    uint32_t length;  ///< LENGTH: payload octets of the present frame.
    uint8_t prefix;   ///< LENGTH: octets of the length field received so far.
    bool is_skipping; ///< The rest of the present frame is skipped.
    bool is_escaped;  ///< SLIP: the previous octet was an escape. LINE: it was a carriage return.
    bool is_done;     ///< The buffer contains a frame that was returned.
    flow_frame_counters_t counters;
} flow_frame_assembler_t;

/// Initialise. capacity >= 1 is the longest payload; with RAW, the largest number of octets returned at
/// once.
void flow_frame_assembler_init(flow_frame_assembler_t* assembler, const flow_format_t* format,
                               uint8_t* buffer, size_t capacity);
/// Drop the present frame, because the stream has ended and a new one begins.
void flow_frame_assembler_reset(flow_frame_assembler_t* assembler);
/// Process octets up to the end of the next frame; *out_taken is the number of processed octets. STATUS_OK:
/// the payload is `buffer`, *out_size octets (0 or more), until the next call. STATUS_EMPTY: all octets
/// were processed and no frame has ended.
MUST_USE status_t flow_frame_assembler_feed(flow_frame_assembler_t* assembler, const uint8_t* octets,
                                            size_t size, size_t* out_taken, size_t* out_size);

/// Encode one payload as a frame. STATUS_OK; STATUS_INVALID (LINE: the payload contains a line end);
/// STATUS_TOO_LARGE (longer than the length field of the framing allows); STATUS_FULL (the frame does not
/// fit `capacity`). Only with STATUS_OK the output is valid.
MUST_USE status_t flow_frame_encode(const flow_format_t* format, const uint8_t* payload, size_t size,
                                    uint8_t* octets, size_t capacity, size_t* out_size);

#endif // FSW_FRAMEWORK_DATAFLOW_FRAMING_H
