// SPDX-License-Identifier: Apache-2.0
// A stream flow is the client of a peer in memory. Whatever the peer sends, and in whatever pieces,
// the same frames result; the outbox and the frame stay within their buffers; a flow that lost its peer
// connects again. Encoded payloads are decoded to the same octets.
//
// The first octet of the input selects framing and order. The kind of each record selects an action: 0 the
// peer sends the octets; 1 the flow sends the octets; 2 the flow receives; 3 the peer closes; 4 from now on a
// send accepts at most `argument` octets; 5 the peer reads.
#include "fsw/framework/dataflow/flow_stream.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"

#include <stdlib.h>
#include <string.h>

#define PORT 7000U
#define FRAME 64U
#define OUTBOX 160U
#define STEP_NS 1000000U

static flow_stream_t flow;
static uint8_t frame[FRAME];
static uint8_t outbox[OUTBOX];
static osal_socket_t listener;
static osal_socket_t peer;
static uint64_t now_ns;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, "127.0.0.1:7000");
    return STATUS_OK;
}

/// Frames of one stream, compared by their number and a sum over lengths and octets.
typedef struct {
    uint8_t buffer[FRAME];
    flow_frame_assembler_t assembler;
    uint32_t frames;
    uint64_t sum;
} reader_t;

static void read_all(reader_t* const reader, const uint8_t* const octets, const size_t size)
{
    size_t used = 0U;
    while (true) {
        size_t taken = 0U;
        size_t found = 0U;
        const status_t status =
            flow_frame_assembler_feed(&reader->assembler, &octets[used], size - used, &taken, &found);
        used += taken;
        FUZZ_CHECK(used <= size);
        if (status == STATUS_EMPTY) {
            FUZZ_CHECK(used == size);
            return;
        }
        FUZZ_CHECK((status == STATUS_OK) && (found <= FRAME));
        reader->frames++;
        reader->sum = (reader->sum * 31U) + found;
        for (size_t i = 0U; i < found; i++) {
            reader->sum = (reader->sum * 31U) + reader->buffer[i];
        }
    }
}

/// The octets in one piece and octet by octet must give the same frames. RAW has only octets and no frames.
static void check_pieces(const flow_format_t* const format, const uint8_t* const octets, const size_t size)
{
    static reader_t whole;
    static reader_t pieces;
    if (format->framing == FLOW_FRAMING_RAW) {
        return;
    }
    flow_frame_assembler_init(&whole.assembler, format, whole.buffer, FRAME);
    flow_frame_assembler_init(&pieces.assembler, format, pieces.buffer, FRAME);
    whole.frames = pieces.frames = 0U;
    whole.sum = pieces.sum = 0U;
    read_all(&whole, octets, size);
    for (size_t i = 0U; i < size; i++) {
        read_all(&pieces, &octets[i], 1U);
    }
    FUZZ_CHECK((whole.frames == pieces.frames) && (whole.sum == pieces.sum));
    FUZZ_CHECK(memcmp(&whole.assembler.counters, &pieces.assembler.counters, sizeof(flow_frame_counters_t)) ==
               0);
}

static void check_round_trip(const flow_format_t* const format, const uint8_t* const octets,
                             const size_t size)
{
    static reader_t reader;
    uint8_t encoded[(2U * FRAME) + 4U];
    size_t length         = 0U;
    const size_t payload  = (size < FRAME) ? size : FRAME;
    const status_t status = flow_frame_encode(format, octets, payload, encoded, sizeof encoded, &length);
    if (status != STATUS_OK) {
        FUZZ_CHECK((status == STATUS_INVALID) && (format->framing == FLOW_FRAMING_LINE));
        return;
    }
    FUZZ_CHECK(length <= sizeof encoded);
    flow_frame_assembler_init(&reader.assembler, format, reader.buffer, FRAME);
    size_t taken = 0U;
    size_t found = 0U;
    if (flow_frame_assembler_feed(&reader.assembler, encoded, length, &taken, &found) == STATUS_OK) {
        // The reader of lines removes a carriage return at the end.
        const bool is_cut = (format->framing == FLOW_FRAMING_LINE) && (payload > 0U) &&
                            (octets[payload - 1U] == (uint8_t)'\r');
        FUZZ_CHECK((found == (is_cut ? (payload - 1U) : payload)) &&
                   (memcmp(reader.buffer, octets, found) == 0));
    } else {
        FUZZ_CHECK((payload == 0U) || (format->framing == FLOW_FRAMING_LINE));
    }
}

/// Step the flow, then let the peer accept a waiting connection.
static void step(void)
{
    osal_address_t from = {0U, 0U};
    now_ns += STEP_NS;
    const status_t status = flow_stream_step(&flow, now_ns);
    FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_CLOSED));
    FUZZ_CHECK(flow.outbox_held <= OUTBOX);
    if (!osal_socket_is_open(&peer)) {
        (void)!osal_tcp_accept(&listener, &peer, &from);
    }
}

static void receive(void)
{
    const uint8_t* payload = NULL;
    size_t size            = 0U;
    status_t status        = STATUS_OK;
    for (unsigned i = 0U; (i < 64U) && (status == STATUS_OK); i++) {
        status = flow_stream_receive(&flow, &payload, &size);
        FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_EMPTY) || (status == STATUS_CLOSED));
        FUZZ_CHECK((payload == frame) && (size <= FRAME));
    }
}

static void act(const fuzz_record_t* const record, const flow_format_t* const format)
{
    uint8_t read[FRAME];
    size_t count = 0U;
    switch (record->kind % 6U) {
    case 0U:
        check_pieces(format, record->octets, record->size);
        (void)!osal_stream_send(&peer, record->octets, record->size, &count);
        break;
    case 1U:
        check_round_trip(format, record->octets, record->size);
        (void)!flow_stream_send(&flow, record->octets, record->size);
        break;
    case 2U:
        receive();
        break;
    case 3U:
        osal_socket_close(&peer);
        break;
    case 4U:
        memory_sockets_limit(record->argument);
        break;
    default:
        (void)!osal_stream_receive(&peer, read, sizeof read, &count);
        break;
    }
    step();
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static const flow_resolver_t resolver = {NULL, resolve};
    if (size == 0U) {
        return 0;
    }
    const flow_format_t format      = {.framing = (flow_framing_t)(data[0] % (unsigned)FLOW_FRAMINGS),
                                       .order   = (flow_order_t)((data[0] >> 4U) % (unsigned)FLOW_ORDERS)};
    const flow_stream_setup_t setup = {.kind             = ENDNODE_TCP,
                                       .name             = "fuzz",
                                       .format           = format,
                                       .frame            = frame,
                                       .frame_octets     = FRAME,
                                       .outbox           = outbox,
                                       .outbox_octets    = OUTBOX,
                                       .retry_first_ns   = STEP_NS,
                                       .retry_longest_ns = 4U * STEP_NS};
    const osal_address_t here       = {OSAL_IPV4_LOOPBACK, PORT};
    fuzz_input_t input              = fuzz_input(&data[1], size - 1U);
    fuzz_record_t record;
    memory_sockets_reset();
    peer   = (osal_socket_t)OSAL_SOCKET_CLOSED;
    now_ns = 0U;
    FUZZ_CHECK(osal_tcp_listen(&listener, here) == STATUS_OK);
    flow_stream_init(&flow, &setup, &resolver);
    step();
    while (fuzz_next(&input, &record)) {
        act(&record, &format);
    }
    receive();
    for (unsigned i = 0U; (i < 16U) && !flow.link.is_open; i++) {
        step();
    }
    FUZZ_CHECK(flow.link.is_open);
    flow_stream_close(&flow);
    osal_socket_close(&peer);
    osal_socket_close(&listener);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    (void)kind;
    if ((size >= 3U) && ((fuzz_random(random) % 2U) == 0U)) {
        // Write a length field that fits the record, in one of the two byte orders.
        const size_t length = fuzz_random(random) % (size - 1U);
        const size_t low    = fuzz_random(random) % 2U;
        octets[low]         = (uint8_t)length;
        octets[1U - low]    = 0U;
    }
    if ((size >= 1U) && ((fuzz_random(random) % 2U) == 0U)) {
        // Octets that end a frame (SLIP, line) or begin an escape (SLIP).
        static const uint8_t special[]     = {0xC0U, (uint8_t)'\n', 0xDBU};
        octets[fuzz_random(random) % size] = special[fuzz_random(random) % sizeof special];
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    if ((size < 2U) || ((seed % 16U) == 0U)) {
        return LLVMFuzzerMutate(data, size, max_size);
    }
    return 1U + fuzz_mutate_records(&data[1], size - 1U, max_size - 1U, seed, repair);
}
