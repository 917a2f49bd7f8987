// SPDX-License-Identifier: Apache-2.0
// Proves: the assembler of frames accesses nothing outside its buffer, whatever octets it receives, in pieces
//     of any size, in every framing and from every state; it takes all octets, or those up to the end of a
//     frame whose payload fits the buffer. From a frame that flow_frame_encode wrote, the assembler extracts
//     the same payload.
// Bounds: a buffer of 4 octets, any sound state, pieces of 0..3 octets; payloads of 0..2 octets.
// Replaced: nothing.
// Sources: fsw/framework/dataflow/framing.c
// Options: --unwind 9
// Fault: fsw/framework/dataflow/framing.c
//   - if ((assembler->prefix == LENGTH_OCTETS) && (assembler->length > assembler->capacity)) {
//   + if ((assembler->prefix == LENGTH_OCTETS) && (assembler->length > (assembler->capacity + 1U))) {
// Fault: fsw/framework/dataflow/framing.c
//   - octets[position++] = (payload[i] == SLIP_END) ? SLIP_ESCAPED_END : SLIP_ESCAPED_ESCAPE;
//   + octets[position++] = SLIP_ESCAPED_END;
#include "fsw/framework/dataflow/framing.h"
#include "test/proof/proof.h"

#define CAPACITY 4U
#define PIECE 3U
#define PAYLOAD 2U

static uint8_t buffer[CAPACITY];

static flow_format_t any_format(void)
{
    flow_format_t format = {0};
    format.framing       = (flow_framing_t)(nondet_u8() % (uint8_t)FLOW_FRAMINGS);
    format.order         = nondet_bool() ? FLOW_ORDER_BIG : FLOW_ORDER_LITTLE;
    return format;
}

/// States that the assembler can have between two calls.
static bool is_sound(const flow_frame_assembler_t* const assembler)
{
    const bool is_length = (assembler->framing == FLOW_FRAMING_LENGTH);
    const bool is_whole  = (assembler->prefix == 2U);
    const bool is_filled = is_length && is_whole && !assembler->is_skipping && !assembler->is_done;
    return (assembler->held <= CAPACITY) && (assembler->prefix <= 2U) &&
           (is_length || (assembler->prefix == 0U)) && (assembler->length <= 65535U) &&
           (!is_length || is_whole || ((assembler->held == 0U) && !assembler->is_skipping)) &&
           (!is_filled || ((assembler->held < assembler->length) && (assembler->length <= CAPACITY))) &&
           (!is_length || !assembler->is_skipping || (assembler->length >= 1U)) &&
           (!assembler->is_done || !assembler->is_skipping);
}

static void prove_any_stream(void)
{
    const flow_format_t format = any_format();
    flow_frame_assembler_t assembler;
    flow_frame_assembler_init(&assembler, &format, buffer, CAPACITY);
    assembler.held        = nondet_size();
    assembler.length      = nondet_u32();
    assembler.prefix      = nondet_u8();
    assembler.is_skipping = nondet_bool();
    assembler.is_escaped  = nondet_bool();
    assembler.is_done     = nondet_bool();
    ASSUME(is_sound(&assembler));
    const size_t size = any_size(PIECE);
    uint8_t octets[PIECE];
    size_t taken          = 0U;
    size_t got            = 0U;
    const status_t status = flow_frame_assembler_feed(&assembler, octets, size, &taken, &got);
    PROVE((status == STATUS_OK) || (status == STATUS_EMPTY), "the status is one of the contract");
    PROVE((taken <= size) && (got <= CAPACITY), "a payload fits the buffer");
    PROVE(IMPLIES(status == STATUS_EMPTY, (taken == size) && (got == 0U)), "without a frame all is taken");
    PROVE(IMPLIES(status == STATUS_OK, taken > 0U), "a frame ends with an octet");
    PROVE((format.framing == FLOW_FRAMING_RAW) || is_sound(&assembler), "the state stays sound");
}

static void prove_round_trip(void)
{
    const flow_format_t format = any_format();
    const size_t size          = any_size(PAYLOAD);
    uint8_t payload[PAYLOAD];
    uint8_t octets[8];
    size_t framed = 0U;
    if (flow_frame_encode(&format, payload, size, octets, sizeof octets, &framed) != STATUS_OK) {
        PROVE(format.framing == FLOW_FRAMING_LINE, "only a line refuses a short payload");
        return;
    }
    flow_frame_assembler_t assembler;
    size_t taken = 0U;
    size_t got   = 0U;
    flow_frame_assembler_init(&assembler, &format, buffer, CAPACITY);
    const status_t status = flow_frame_assembler_feed(&assembler, octets, framed, &taken, &got);
    const bool has_none =
        (size == 0U) && ((format.framing == FLOW_FRAMING_RAW) || (format.framing == FLOW_FRAMING_SLIP));
    PROVE(has_none || ((status == STATUS_OK) && (taken == framed) && (got == size)),
          "the payload has its size");
    for (size_t i = 0U; i < size; i++) {
        PROVE(buffer[i] == payload[i], "the payload has its octets");
    }
}

void proof(void)
{
    if (nondet_bool()) {
        prove_any_stream();
    } else {
        prove_round_trip();
    }
}
