// SPDX-License-Identifier: Apache-2.0
// The socketcand port receives arbitrary octets from two clients, while the bus carries arbitrary frames.
// Each frame on the bus has a permitted length, each answer consists of printable characters, and after the
// clients have closed their connections the server has all its slots free again.
//
// Records by kind:
//   0, 1  client 0 or 1 sends the octets
//   2     another node sends a frame
//   3     the bus runs for argument x 100 us
//   4     the client that the argument names closes its connection
#include "sim/socketcand/socketcand.h"
#include "test/fuzz/can_records.h"
#include "test/fuzz/memory_socket.h"

#include <string.h>

#define PORT 29536U
#define CLIENTS 2U
#define ANSWERS 4096U
#define ROUNDS 128U

static bus_t* bus;
static unsigned own_node;
static socketcand_t* server;
static osal_socket_t clients[CLIENTS];

static void tap(void* const context, const uint32_t senders, const osal_can_frame_t* const frame)
{
    (void)context;
    (void)senders;
    FUZZ_CHECK(frame->length <= OSAL_CAN_DATA_MAX);
}

static void begin(void)
{
    const bus_config_t config  = {.nominal_bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
    const bus_callbacks_t none = {.context = NULL};
    socketcand_bus_t served    = {"robot", NULL};
    memory_sockets_reset();
    bus = bus_create(&config);
    FUZZ_CHECK((bus != NULL) && (bus_add_node(bus, &none, &own_node) == STATUS_OK));
    bus_set_tap(bus, tap, NULL, own_node);
    served.bus = bus;
    FUZZ_CHECK(socketcand_open(PORT, &served, 1U, &server) == STATUS_OK);
    for (unsigned i = 0U; i < CLIENTS; i++) {
        FUZZ_CHECK(osal_tcp_connect_begin(&clients[i], (osal_address_t){OSAL_IPV4_LOOPBACK, PORT}) ==
                   STATUS_OK);
    }
}

static void hear(const unsigned client)
{
    uint8_t octets[ANSWERS];
    size_t size = 0U;
    while (osal_stream_receive(&clients[client], octets, sizeof octets, &size) == STATUS_OK) {
        for (size_t i = 0U; i < size; i++) {
            FUZZ_CHECK((octets[i] >= 0x20U) && (octets[i] < 0x7FU));
        }
    }
}

static void act(const fuzz_record_t* const record)
{
    size_t sent                  = 0U;
    const osal_can_frame_t frame = fuzz_can_frame(record);
    switch (record->kind % 5U) {
    case 2U:
        (void)bus_submit(bus, own_node, &frame, bus_now_ns(bus));
        break;
    case 3U:
        bus_run_until(bus, bus_now_ns(bus) + ((uint64_t)record->argument * 100000U));
        break;
    case 4U:
        osal_socket_close(&clients[record->argument % CLIENTS]);
        break;
    default:
        (void)!osal_stream_send(&clients[record->kind % 5U], record->octets, record->size, &sent);
        break;
    }
    (void)socketcand_receive(server);
    socketcand_send(server);
    for (unsigned i = 0U; i < CLIENTS; i++) {
        hear(i);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    for (unsigned i = 0U; i < CLIENTS; i++) {
        osal_socket_close(&clients[i]);
    }
    osal_socket_t later[SOCKETCAND_CLIENTS_MAX];
    // The server reads the octets that are left piece by piece, and finds the end of a connection after them.
    for (unsigned i = 0U; i < ROUNDS; i++) {
        bus_run_until(bus, bus_now_ns(bus) + 1000000U);
        socketcand_wait(server, 0U); // Accepts a client that is still waiting.
        (void)socketcand_receive(server);
    }
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        uint8_t octets[ANSWERS];
        size_t heard = 0U;
        FUZZ_CHECK(osal_tcp_connect_begin(&later[i], (osal_address_t){OSAL_IPV4_LOOPBACK, PORT}) ==
                   STATUS_OK);
        socketcand_wait(server, 0U);
        (void)socketcand_receive(server);
        socketcand_send(server);
        // All slots are free again, so each new client gets the greeting.
        FUZZ_CHECK(osal_stream_receive(&later[i], octets, sizeof octets, &heard) == STATUS_OK);
    }
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        osal_socket_close(&later[i]);
    }
    socketcand_close(server);
    FUZZ_CHECK(memory_sockets_open() == 0U);
    bus_destroy(bus);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, NULL);
}
