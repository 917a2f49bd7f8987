// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/framing.h"

#include "base/assertion.h"

#include <string.h>

#define LENGTH_OCTETS 2U
#define SLIP_END 0xC0U
#define SLIP_ESCAPE 0xDBU
#define SLIP_ESCAPED_END 0xDCU
#define SLIP_ESCAPED_ESCAPE 0xDDU
#define LINE_FEED 0x0AU
#define CARRIAGE_RETURN 0x0DU

// ---- Decoding ----

static void begin_frame(flow_frame_assembler_t* const assembler)
{
    assembler->held        = 0U;
    assembler->length      = 0U;
    assembler->prefix      = 0U;
    assembler->is_skipping = false;
    assembler->is_escaped  = false;
    assembler->is_done     = false;
}

void flow_frame_assembler_init(flow_frame_assembler_t* const assembler, const flow_format_t* const format,
                               uint8_t* const buffer, const size_t capacity)
{
    FSW_ASSERT((assembler != NULL) && (format != NULL) && (buffer != NULL) && (capacity >= 1U));
    *assembler = (flow_frame_assembler_t){
        .framing = format->framing, .order = format->order, .buffer = buffer, .capacity = capacity};
}

void flow_frame_assembler_reset(flow_frame_assembler_t* const assembler)
{
    FSW_ASSERT(assembler != NULL);
    const bool is_begun = (assembler->held > 0U) || (assembler->prefix > 0U) || assembler->is_escaped;
    if (is_begun && !assembler->is_done && !assembler->is_skipping) {
        assembler->counters.cut++;
    }
    begin_frame(assembler);
}

/// Store one octet of the payload, unless the frame is skipped or becomes too long.
static void keep(flow_frame_assembler_t* const assembler, const uint8_t octet)
{
    if (assembler->is_skipping) {
        return;
    }
    if (assembler->held == assembler->capacity) {
        assembler->counters.oversize++;
        assembler->is_skipping = true;
        return;
    }
    assembler->buffer[assembler->held] = octet;
    assembler->held++;
}

/// Process one octet. True if it ends the frame; take_slip and take_line return the same.
static bool take_length(flow_frame_assembler_t* const assembler, const uint8_t octet)
{
    if (assembler->prefix < LENGTH_OCTETS) {
        const bool is_high = ((assembler->order == FLOW_ORDER_BIG) == (assembler->prefix == 0U));
        assembler->length |= is_high ? ((uint32_t)octet << 8U) : octet;
        assembler->prefix++;
        if ((assembler->prefix == LENGTH_OCTETS) && (assembler->length > assembler->capacity)) {
            assembler->counters.oversize++;
            assembler->is_skipping = true;
        }
        return (assembler->prefix == LENGTH_OCTETS) && (assembler->length == 0U);
    }
    if (assembler->is_skipping) {
        assembler->length--;
        return assembler->length == 0U;
    }
    keep(assembler, octet);
    return assembler->held == assembler->length;
}

static bool take_slip(flow_frame_assembler_t* const assembler, const uint8_t octet)
{
    if (octet == SLIP_END) {
        if (assembler->is_escaped && !assembler->is_skipping) {
            assembler->counters.malformed++;
            assembler->is_skipping = true;
        }
        // Two end octets in a row are not an empty frame.
        return (assembler->held > 0U) || assembler->is_skipping;
    }
    if (assembler->is_escaped) {
        assembler->is_escaped = false;
        if ((octet == SLIP_ESCAPED_END) || (octet == SLIP_ESCAPED_ESCAPE)) {
            keep(assembler, (octet == SLIP_ESCAPED_END) ? SLIP_END : SLIP_ESCAPE);
        } else if (!assembler->is_skipping) {
            assembler->counters.malformed++;
            assembler->is_skipping = true;
        } else {
            // The rest of this frame is skipped.
        }
    } else if (octet == SLIP_ESCAPE) {
        assembler->is_escaped = true;
    } else {
        keep(assembler, octet);
    }
    return false;
}

static bool take_line(flow_frame_assembler_t* const assembler, const uint8_t octet)
{
    if (octet != LINE_FEED) {
        // Hold the carriage return back: it belongs to the payload only if no line feed follows.
        if (assembler->is_escaped) {
            assembler->is_escaped = false;
            keep(assembler, CARRIAGE_RETURN);
        }
        if (octet == CARRIAGE_RETURN) {
            assembler->is_escaped = true;
        } else {
            keep(assembler, octet);
        }
    }
    return octet == LINE_FEED;
}

static status_t take_raw(flow_frame_assembler_t* const assembler, const uint8_t* const octets,
                         const size_t size, size_t* const out_taken, size_t* const out_size)
{
    const size_t taken = (size < assembler->capacity) ? size : assembler->capacity;
    if (taken > 0U) {
        (void)memcpy(assembler->buffer, octets, taken);
        assembler->counters.complete++;
    }
    *out_taken = taken;
    *out_size  = taken;
    return (taken > 0U) ? STATUS_OK : STATUS_EMPTY;
}

status_t flow_frame_assembler_feed(flow_frame_assembler_t* const assembler, const uint8_t* const octets,
                                   const size_t size, size_t* const out_taken, size_t* const out_size)
{
    FSW_ASSERT((assembler != NULL) && ((octets != NULL) || (size == 0U)) && (out_taken != NULL) &&
               (out_size != NULL));
    static bool (*const takers[FLOW_FRAMINGS])(flow_frame_assembler_t*,
                                               uint8_t) = {[FLOW_FRAMING_LENGTH] = take_length,
                                                           [FLOW_FRAMING_SLIP]   = take_slip,
                                                           [FLOW_FRAMING_LINE]   = take_line};
    if (assembler->framing == FLOW_FRAMING_RAW) {
        return take_raw(assembler, octets, size, out_taken, out_size);
    }
    if (assembler->is_done) {
        begin_frame(assembler);
    }
    *out_size = 0U;
    for (size_t i = 0U; i < size; i++) {
        if (!takers[assembler->framing](assembler, octets[i])) {
            continue;
        }
        if (!assembler->is_skipping) {
            assembler->is_done = true;
            assembler->counters.complete++;
            *out_taken = i + 1U;
            *out_size  = assembler->held;
            return STATUS_OK;
        }
        begin_frame(assembler);
    }
    *out_taken = size;
    return STATUS_EMPTY;
}

// ---- Encoding ----

static bool is_line(const uint8_t* const payload, const size_t size)
{
    for (size_t i = 0U; i < size; i++) {
        if ((payload[i] == LINE_FEED) || (payload[i] == CARRIAGE_RETURN)) {
            return false;
        }
    }
    return true;
}

/// Returns the number of octets that the framing adds to the payload.
static size_t overhead(const flow_framing_t framing, const uint8_t* const payload, const size_t size)
{
    if (framing == FLOW_FRAMING_LENGTH) {
        return LENGTH_OCTETS;
    }
    if (framing == FLOW_FRAMING_LINE) {
        return 1U;
    }
    if (framing == FLOW_FRAMING_RAW) {
        return 0U;
    }
    size_t octets = 2U;
    for (size_t i = 0U; i < size; i++) {
        octets += ((payload[i] == SLIP_END) || (payload[i] == SLIP_ESCAPE)) ? 1U : 0U;
    }
    return octets;
}

static void write_slip(const uint8_t* const payload, const size_t size, uint8_t* const octets)
{
    size_t position    = 0U;
    octets[position++] = SLIP_END; // Ends a frame that noise may have started.
    for (size_t i = 0U; i < size; i++) {
        if ((payload[i] == SLIP_END) || (payload[i] == SLIP_ESCAPE)) {
            octets[position++] = SLIP_ESCAPE;
            octets[position++] = (payload[i] == SLIP_END) ? SLIP_ESCAPED_END : SLIP_ESCAPED_ESCAPE;
        } else {
            octets[position++] = payload[i];
        }
    }
    octets[position] = SLIP_END;
}

static void write_frame(const flow_format_t* const format, const uint8_t* const payload, const size_t size,
                        uint8_t* const octets)
{
    size_t position = 0U;
    if (format->framing == FLOW_FRAMING_SLIP) {
        write_slip(payload, size, octets);
        return;
    }
    if (format->framing == FLOW_FRAMING_LENGTH) {
        const uint8_t high = (uint8_t)(size >> 8U);
        const uint8_t low  = (uint8_t)(size & 0xFFU);
        octets[0]          = (format->order == FLOW_ORDER_BIG) ? high : low;
        octets[1]          = (format->order == FLOW_ORDER_BIG) ? low : high;
        position           = LENGTH_OCTETS;
    }
    if (size > 0U) {
        (void)memcpy(&octets[position], payload, size);
    }
    if (format->framing == FLOW_FRAMING_LINE) {
        octets[size] = LINE_FEED;
    }
}

status_t flow_frame_encode(const flow_format_t* const format, const uint8_t* const payload, const size_t size,
                           uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((format != NULL) && ((payload != NULL) || (size == 0U)) && (octets != NULL) &&
               (out_size != NULL));
    *out_size = 0U;
    if ((format->framing == FLOW_FRAMING_LINE) && !is_line(payload, size)) {
        return STATUS_INVALID;
    }
    if ((format->framing == FLOW_FRAMING_LENGTH) && (size > FRAMING_LENGTH_MAX)) {
        return STATUS_TOO_LARGE;
    }
    const size_t extra = overhead(format->framing, payload, size);
    if ((size > capacity) || (extra > (capacity - size))) {
        return STATUS_FULL;
    }
    write_frame(format, payload, size, octets);
    *out_size = size + extra;
    return STATUS_OK;
}
