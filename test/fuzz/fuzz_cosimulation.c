// SPDX-License-Identifier: Apache-2.0
// A client sends arbitrary octets in pieces to the co-simulation port of the scheduler. The client takes part
// only after a correct join, and the reason for its removal is counted once. Each record contains the octets
// that the client sends before the port's next turn; kind 1 opens a new connection.
#include "sim/clock/cosimulation_port.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"

#include <string.h>

static uint8_t storage[OSAL_LOCKSTEP_OCTETS] __attribute__((aligned(64)));

static uint32_t gone(const cosimulation_port_t* const cosimulation)
{
    return cosimulation->count.left + cosimulation->count.vanished + cosimulation->count.malformed +
           cosimulation->count.silent;
}

static void turn(cosimulation_port_t* const cosimulation)
{
    const osal_grant_t grant         = {1000U, 1U, 0U};
    const cosimulation_port_t before = *cosimulation;
    uint64_t wake_ns                 = 0U;
    uint32_t octets                  = 0U;
    if (!osal_socket_is_open(&cosimulation->client)) {
        const bool is_inside = (cosimulation_port_accept(cosimulation, 0U) == STATUS_OK);
        FUZZ_CHECK(is_inside == osal_socket_is_open(&cosimulation->client));
        FUZZ_CHECK(cosimulation->count.joined == (before.count.joined + (is_inside ? 1U : 0U)));
        return;
    }
    const status_t status = cosimulation_port_exchange(cosimulation, &grant, 0U, &wake_ns, &octets);
    FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_CLOSED));
    FUZZ_CHECK((status == STATUS_OK) == osal_socket_is_open(&cosimulation->client));
    FUZZ_CHECK(gone(cosimulation) == (gone(&before) + ((status == STATUS_OK) ? 0U : 1U)));
    FUZZ_CHECK(cosimulation->line_size <= COSIMULATION_PORT_LINE_OCTETS);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    cosimulation_port_t cosimulation;
    osal_socket_t client = OSAL_SOCKET_CLOSED;
    fuzz_input_t input   = fuzz_input(data, size);
    fuzz_record_t record;
    memory_sockets_reset();
    osal_lockstep_t* const scheduler = osal_lockstep_create(storage, 500000U, false);
    FUZZ_CHECK((scheduler != NULL) && (cosimulation_port_open(&cosimulation, "cosimulation", "operator",
                                                              scheduler, 0U) == STATUS_OK));
    while (fuzz_next(&input, &record)) {
        size_t sent = 0U;
        if (((record.kind % 4U) == 1U) || !osal_socket_is_open(&client)) {
            osal_socket_close(&client);
            (void)!memory_sockets_connect_local(&client);
        }
        (void)!osal_stream_send(&client, record.octets, record.size, &sent);
        turn(&cosimulation);
    }
    cosimulation_port_close(&cosimulation);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, NULL);
}
