// SPDX-License-Identifier: Apache-2.0
// The ground port receives octets from up to four clients in pieces of any size and sends them reports, which
// they read slowly; at times the supervisor refuses requests. The supervisor gets exactly the requests of
// each client, complete and in order; a client gets only complete packets.
//
// Records by kind:
//   0..3  the client of this number sends the octets
//   4     the client that the argument names closes its connection
//   5     the supervisor refuses the next requests, as many as the argument says
//   6     a report is sent to all clients
//   7     the clients read
//   8     from now on a connection takes at most argument octets at a time (0: any number)
#include "fsw/subsystems/communication/communication.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"

#include "pus/core/packet.h"

#include <string.h>

#define DESCRIPTOR "descriptors/subsystems/communication.xml"
#define PORT 10015U
#define STREAM_MAX 65536U
#define STREAMS 16U // Connections of one input.
#define SPEAKERS 4U // Records of kinds below this are their octets.

static subsystem_descriptor_t descriptor;
static subsystem_t component;
static communication_t communication;
static unsigned refusals;

// Octets sent on one connection; communication may forward them long after the client has closed it.
typedef struct {
    uint16_t port;
    uint8_t sent[STREAM_MAX];
    size_t sent_size;
    size_t processed; // Octets that were forwarded or were not requests.
} stream_t;

static stream_t streams[STREAMS];
static unsigned stream_count;

static struct {
    osal_socket_t socket;
    stream_t* stream;
    uint8_t read[2U * PUS_PACKET_MAX];
    size_t read_size;
} clients[SPEAKERS];

/// The next request in the octets of a client must be this packet; reports before it are skipped.
static bool is_next_of(stream_t* const stream, const uint8_t* const packet, const size_t size)
{
    size_t at = stream->processed;
    for (;;) {
        const uint8_t* const octets = &stream->sent[at];
        if ((stream->sent_size - at) < 6U) {
            return false;
        }
        const size_t length = (((size_t)octets[4] << 8U) | octets[5]) + 7U;
        if ((length > PUS_PACKET_MAX) || (length > (stream->sent_size - at))) {
            return false;
        }
        if ((octets[0] & 0x10U) != 0U) {
            const bool is_same = (length == size) && (memcmp(octets, packet, size) == 0);
            stream->processed  = is_same ? (at + length) : stream->processed;
            return is_same;
        }
        at += length;
    }
}

static status_t take_report(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    (void)packet;
    (void)size;
    return STATUS_OK;
}

static status_t take_request(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    if (refusals > 0U) {
        refusals--;
        return STATUS_FULL;
    }
    // The index determines the connection, and the connection the port of the client.
    const unsigned place = (unsigned)((size_t)(packet - communication.buffers) / COMMUNICATION_BUFFER);
    osal_address_t peer  = {0U, 0U};
    bool is_known        = false;
    FUZZ_CHECK(flow_tcp_peer(&communication.flow, place, &peer) == STATUS_OK);
    for (unsigned i = 0U; !is_known && (i < stream_count); i++) {
        is_known = (streams[i].port == peer.port) && is_next_of(&streams[i], packet, size);
    }
    FUZZ_CHECK(is_known);
    return STATUS_OK;
}

static void sent(void* const context, const uint16_t peer_port, const uint32_t octets)
{
    (void)context;
    FUZZ_CHECK((peer_port != 0U) && (octets > 0U));
}

static uint16_t participant_port(void* const context)
{
    (void)context;
    return 0U;
}

static void of_participant(void* const context, const uint16_t port)
{
    (void)context;
    FUZZ_CHECK(port != port); // Always fails: no such connection exists.
}

static void intruded(void* const context)
{
    (void)context;
}

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    static descriptor_loader_t loader;
    (void)argc;
    (void)argv;
    descriptor_loader_init(&loader);
    FUZZ_CHECK(descriptor_load_subsystem(&loader, DESCRIPTOR, &descriptor) == STATUS_OK);
    return 0;
}

static void begin(void)
{
    static const communication_hooks_t hooks = {NULL,           sent,           participant_port,
                                                of_participant, of_participant, intruded};
    const pus_port_t uplink                  = {NULL, take_request};
    const subsystem_config_t config          = {.descriptor          = &descriptor,
                                                .is_descriptor_valid = true,
                                                .callbacks           = communication_callbacks(),
                                                .self                = &communication,
                                                .start_count         = 1U,
                                                .status_interval_ns  = SUBSYSTEM_STATUS_INTERVAL_NS,
                                                .port                = {NULL, take_report}};
    osal_socket_t listener                   = OSAL_SOCKET_CLOSED;
    memory_sockets_reset();
    FUZZ_CHECK(osal_tcp_listen(&listener, (osal_address_t){OSAL_IPV4_LOOPBACK, PORT}) == STATUS_OK);
    communication_init(&communication, &component, &uplink, &hooks, osal_socket_descriptor(&listener));
    subsystem_init(&component, &config);
    FUZZ_CHECK(communication_callbacks()->configure(&communication, NULL) == STATUS_OK);
    refusals     = 0U;
    stream_count = 0U;
    for (unsigned i = 0U; i < SPEAKERS; i++) {
        clients[i].socket.descriptor = -1;
    }
}

static void speak(const unsigned client, const uint8_t* const octets, const size_t size)
{
    if (!osal_socket_is_open(&clients[client].socket)) {
        const osal_address_t port = {OSAL_IPV4_LOOPBACK, PORT};
        if ((stream_count == STREAMS) ||
            (osal_tcp_connect_begin(&clients[client].socket, port) != STATUS_OK)) {
            return;
        }
        osal_address_t local = {0U, 0U};
        FUZZ_CHECK(osal_socket_local_address(&clients[client].socket, &local) == STATUS_OK);
        clients[client].stream            = &streams[stream_count];
        clients[client].stream->port      = local.port;
        clients[client].stream->sent_size = 0U;
        clients[client].stream->processed = 0U;
        clients[client].read_size         = 0U;
        stream_count++;
    }
    stream_t* const stream = clients[client].stream;
    size_t taken           = 0U;
    if ((stream->sent_size + size) <= STREAM_MAX) {
        (void)memcpy(&stream->sent[stream->sent_size], octets, size);
        (void)!osal_stream_send(&clients[client].socket, octets, size, &taken);
        stream->sent_size += taken;
    }
}

/// Read what has arrived. All packets must be complete, except the last one.
static void listen_to(const unsigned client)
{
    size_t size     = 0U;
    status_t status = STATUS_OK;
    while (osal_socket_is_open(&clients[client].socket) && (status == STATUS_OK)) {
        status = osal_stream_receive(&clients[client].socket,
                                     &clients[client].read[clients[client].read_size], PUS_PACKET_MAX, &size);
        clients[client].read_size += size;
        size_t packet_size = 0U;
        pus_tm_t tm;
        pus_failure_t failure;
        while (pus_packet_frame(clients[client].read, clients[client].read_size, &packet_size) == STATUS_OK) {
            FUZZ_CHECK(pus_tm_decode(clients[client].read, packet_size, &tm, &failure) == STATUS_OK);
            clients[client].read_size -= packet_size;
            (void)memmove(clients[client].read, &clients[client].read[packet_size],
                          clients[client].read_size);
        }
        FUZZ_CHECK(clients[client].read_size < PUS_PACKET_MAX);
        if ((status == STATUS_CLOSED) || (status == STATUS_IO)) {
            osal_socket_close(&clients[client].socket);
        }
    }
}

static void report(const fuzz_record_t* const record)
{
    static uint8_t packet[PUS_PACKET_MAX];
    size_t size       = 0U;
    const pus_tm_t tm = {.apid        = 1U,
                         .service     = ((record->argument & 1U) != 0U) ? 3U : 1U,
                         .subtype     = 25U,
                         .destination = record->argument >> 1U,
                         .data        = record->octets,
                         .size        = (record->size < PUS_TM_DATA_MAX) ? record->size : PUS_TM_DATA_MAX};
    FUZZ_CHECK(pus_tm_encode(&tm, packet, sizeof packet, &size) == STATUS_OK);
    communication_callbacks()->report(&communication, packet, size);
}

static void act(const fuzz_record_t* const record)
{
    switch (record->kind % 9U) {
    case 4U:
        osal_socket_close(&clients[record->argument % SPEAKERS].socket);
        break;
    case 5U:
        refusals = record->argument;
        break;
    case 6U:
        report(record);
        break;
    case 7U:
        for (unsigned i = 0U; i < SPEAKERS; i++) {
            listen_to(i);
        }
        break;
    case 8U:
        memory_sockets_limit((record->argument == 0U) ? SIZE_MAX : record->argument);
        break;
    default:
        speak(record->kind % 9U, record->octets, record->size);
        break;
    }
    (void)communication_take_in(&communication, 0U);
    communication_send_out(&communication);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    const flow_tcp_user_t nobody = {.context = NULL};
    flow_tcp_end_all(&communication.flow, &nobody);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    if ((kind % 9U) < SPEAKERS) {
        fuzz_repair_packet(kind, octets, size, random);
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
