// SPDX-License-Identifier: Apache-2.0
// A socket for message frames receives arbitrary datagrams, also oversized and empty ones, from its peers and
// from other senders. A datagram of another sender is counted and never enters the inbox. The state of the
// endpoint stays consistent, and its credit stays within the window.
//
// Records by kind:
//   0, 1  peer 2 or 3 sends the octets as a datagram
//   2     another sender sends the octets as a datagram
//   3     the endpoint receives
//   4     the endpoint sends the octets as a message to peer 2 + argument % 3
//   5     the carrier is read although no datagram has arrived
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/udp_carrier.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"
#include "test/support/consistent_message.h"

#include <string.h>

#define SELF 1U
#define FIRST_PEER 2U
#define PORT_OF(component) (7000U + (component))

static message_endpoint_t endpoint;
static message_udp_carrier_t carrier;
static osal_socket_t socket_of_endpoint;
static message_slot_t inbox[2];
static uint8_t block[MESSAGE_PAYLOAD_MAX];

static void delivered(void* const context, const uint16_t to)
{
    (void)context;
    FUZZ_CHECK((to == FIRST_PEER) || (to == (FIRST_PEER + 1U)));
}

static void begin(void)
{
    const osal_address_t here = {OSAL_IPV4_LOOPBACK, PORT_OF(SELF)};
    memory_sockets_reset();
    FUZZ_CHECK(osal_udp_open(&socket_of_endpoint, here, 0U) == STATUS_OK);
    message_udp_carrier_init(&carrier, &socket_of_endpoint, (message_delivery_notice_t){NULL, delivered});
    message_open(&endpoint, SELF, 1U, message_udp_carrier_port(&carrier), inbox, 2U);
    for (uint16_t peer = FIRST_PEER; peer < (FIRST_PEER + 2U); peer++) {
        const osal_address_t there = {OSAL_IPV4_LOOPBACK, (uint16_t)PORT_OF(peer)};
        FUZZ_CHECK(message_udp_carrier_add_peer(&carrier, peer, there) == STATUS_OK);
        FUZZ_CHECK(message_add_peer(&endpoint, peer) == STATUS_OK);
    }
}

static void arrive(const fuzz_record_t* const record)
{
    const osal_address_t from       = {OSAL_IPV4_LOOPBACK, (uint16_t)PORT_OF(FIRST_PEER + record->kind)};
    const uint32_t other_senders    = carrier.other_senders;
    const message_counters_t before = endpoint.counters;
    const uint32_t stamp            = endpoint.stamp;
    memory_sockets_datagram(from, record->octets, record->size);
    const status_t status = message_udp_carrier_pump(&carrier, &endpoint);
    const bool is_kept    = (endpoint.stamp != stamp);
    if (record->size > MESSAGE_FRAME_MAX) {
        FUZZ_CHECK((status == STATUS_NOT_OURS) && !is_kept &&
                   (endpoint.counters.malformed == (before.malformed + 1U)));
    } else if (record->kind == 2U) {
        FUZZ_CHECK((status == STATUS_NOT_OURS) && !is_kept &&
                   (carrier.other_senders == (other_senders + 1U)));
    } else {
        const bool is_counted = (endpoint.counters.malformed != before.malformed) ||
                                (endpoint.counters.overruns != before.overruns);
        FUZZ_CHECK(((status == STATUS_OK) && (is_kept != is_counted)) || (record->size == 0U));
        FUZZ_CHECK(carrier.other_senders == other_senders);
    }
}

static void receive(void)
{
    uint16_t from   = 0U;
    size_t size     = 0U;
    status_t status = STATUS_OK;
    while (status != STATUS_EMPTY) {
        status = message_receive(&endpoint, &from, block, sizeof block, &size);
        FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_EMPTY));
        FUZZ_CHECK((size <= sizeof block) && ((status == STATUS_EMPTY) || (from >= FIRST_PEER)));
    }
}

static void act(fuzz_record_t* const record)
{
    record->kind %= 6U;
    switch (record->kind) {
    case 0U:
    case 1U:
    case 2U:
        arrive(record);
        break;
    case 3U:
        receive();
        break;
    case 4U:
        (void)!message_send(&endpoint, (uint16_t)(FIRST_PEER + (record->argument % 3U)), record->octets,
                            record->size);
        break;
    default:
        FUZZ_CHECK(message_udp_carrier_pump(&carrier, &endpoint) != STATUS_OK);
        break;
    }
    FUZZ_CHECK(message_is_consistent(&endpoint));
    FUZZ_CHECK((message_credit(&endpoint, FIRST_PEER) <= MESSAGE_WINDOW) &&
               (message_credit(&endpoint, FIRST_PEER + 1U) <= MESSAGE_WINDOW));
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    receive();
    osal_socket_close(&socket_of_endpoint);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    static const uint8_t head[] = {0x48U, 0x4DU, 1U, 0U, 0U, FIRST_PEER, 0U, SELF,
                                   0U,    0U,    0U, 1U, 0U, 0U,         0U, 1U};
    if (((kind % 6U) > 2U) || (size < MESSAGE_HEADER_OCTETS)) {
        return;
    }
    const uint8_t form = octets[3] & 1U;
    (void)memcpy(octets, head, sizeof head);
    octets[3]  = form;
    octets[5]  = (uint8_t)(FIRST_PEER + (kind % 6U));
    octets[11] = (uint8_t)(1U + (fuzz_random(random) % 3U));
    octets[15] = (uint8_t)(fuzz_random(random) % 3U);
    (void)memset(&octets[16], 0, 3U);
    (void)memset(&octets[20], 0, 3U);
    octets[19] = (uint8_t)(octets[19] % 48U);
    octets[23] = (uint8_t)(octets[23] % 48U);
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
