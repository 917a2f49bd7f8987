// SPDX-License-Identifier: Apache-2.0
// An endpoint for message frames has two peers, of which only one exists. It receives correct frames from
// this peer, and arbitrary frames with the address of either. Its inbox stays consistent, a credit never
// exceeds the window, and the frames that it sends are well-formed.
//
// Records by kind:
//   0  the inbox gets the octets as a frame
//   1  the existing peer sends the octets as a message
//   2  the endpoint sends the octets as a message to TRUE_PEER + argument % 3
//   3  the endpoint and the existing peer receive
//   4  the existing peer starts again
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/ring_carrier.h"
#include "test/fuzz/fuzz.h"
#include "test/support/consistent_message.h"

#include <string.h>

#define SELF 1U
#define TRUE_PEER 2U
#define SILENT_PEER 3U

static message_endpoint_t endpoint;
static message_endpoint_t peer;
static message_ring_carrier_t hub;
static message_slot_t inbox[2];
static message_slot_t peer_inbox[1];
static uint8_t block[MESSAGE_PAYLOAD_MAX];

static void delivered(void* const context, const uint16_t to)
{
    (void)context;
    (void)to;
}

static void begin(void)
{
    message_ring_carrier_init(&hub, (message_delivery_notice_t){NULL, delivered});
    message_open(&endpoint, SELF, 1U, message_ring_carrier_port(&hub), inbox, 2U);
    message_open(&peer, TRUE_PEER, 1U, message_ring_carrier_port(&hub), peer_inbox, 1U);
    FUZZ_CHECK((message_add_peer(&endpoint, TRUE_PEER) == STATUS_OK) &&
               (message_add_peer(&endpoint, SILENT_PEER) == STATUS_OK) &&
               (message_add_peer(&peer, SELF) == STATUS_OK));
    FUZZ_CHECK((message_ring_carrier_attach(&hub, &endpoint) == STATUS_OK) &&
               (message_ring_carrier_attach(&hub, &peer) == STATUS_OK));
}

static void receive(message_endpoint_t* const who)
{
    uint16_t from   = 0U;
    size_t size     = 0U;
    status_t status = STATUS_OK;
    while (status != STATUS_EMPTY) {
        status = message_receive(who, &from, block, sizeof block, &size);
        FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_EMPTY));
        FUZZ_CHECK(size <= sizeof block);
    }
}

static void act(const fuzz_record_t* const record, uint32_t* const epoch)
{
    switch (record->kind % 5U) {
    case 0U:
        (void)!message_deliver(&endpoint, record->octets, record->size);
        break;
    case 1U:
        (void)!message_send(&peer, SELF, record->octets, record->size);
        break;
    case 2U:
        (void)!message_send(&endpoint, (uint16_t)(TRUE_PEER + (record->argument % 3U)), record->octets,
                            record->size);
        break;
    case 3U:
        receive(&endpoint);
        receive(&peer);
        break;
    default:
        (*epoch)++;
        message_open(&peer, TRUE_PEER, *epoch, message_ring_carrier_port(&hub), peer_inbox, 1U);
        FUZZ_CHECK(message_add_peer(&peer, SELF) == STATUS_OK);
        break;
    }
    FUZZ_CHECK(message_is_consistent(&endpoint) && message_is_consistent(&peer));
    FUZZ_CHECK((message_credit(&endpoint, TRUE_PEER) <= MESSAGE_WINDOW) &&
               (message_credit(&endpoint, SILENT_PEER) <= MESSAGE_WINDOW) &&
               (message_credit(&peer, SELF) <= MESSAGE_WINDOW));
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    uint32_t epoch     = 1U;
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record, &epoch);
    }
    receive(&endpoint);
    receive(&peer);
    FUZZ_CHECK(peer.counters.malformed == 0U);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    static const uint8_t head[] = {0x48U, 0x4DU, 1U, 0U, 0U, TRUE_PEER, 0U, SELF,
                                   0U,    0U,    0U, 1U, 0U, 0U,        0U, 1U};
    if (((kind % 5U) != 0U) || (size < MESSAGE_HEADER_OCTETS)) {
        return;
    }
    const uint8_t form = octets[3] & 3U;
    (void)memcpy(octets, head, sizeof head);
    octets[3]  = form;
    octets[5]  = (uint8_t)(TRUE_PEER + (fuzz_random(random) % 2U));
    octets[11] = (uint8_t)(1U + (fuzz_random(random) % 3U));
    octets[15] = (uint8_t)(fuzz_random(random) % 3U);
    if ((fuzz_random(random) % 4U) != 0U) { // Numbers close to the expected ones.
        (void)memset(&octets[16], 0, 3U);
        (void)memset(&octets[20], 0, 3U);
        octets[19] = (uint8_t)(octets[19] % 48U);
        octets[23] = (uint8_t)(octets[23] % 48U);
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
