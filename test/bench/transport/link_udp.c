// SPDX-License-Identifier: Apache-2.0
// A pair of real-time links over UDP, with their CRC. The reader waits in the kernel; it has no variant that
// polls.
#include "fsw/framework/rtlink/link_channel.h"
#include "test/bench/transport/round_trip.h"

#include <stdlib.h>
#include <string.h>

static osal_socket_t sockets[2];
static osal_address_t addresses[2];
static rtlink_producer_t producer;
static rtlink_consumer_t consumer;
static rtlink_terms_t terms;
static unsigned own;

/// Each side receives the link whose number is that of the other side.
static bool udp_route(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer)
{
    (void)context;
    *out_socket   = &sockets[link];
    *out_consumer = addresses[1U - link];
    return true;
}

static const rtlink_resolver_t resolver = {.udp_route = udp_route};

static bool prepare(size_t size)
{
    terms        = (rtlink_terms_t){.layout_octets = (uint32_t)size,
                                    .order         = (uint8_t)rtlink_native_order(),
                                    .period_us     = 500U,
                                    .methods       = 1U << RTLINK_METHOD_UDP,
                                    .decimation    = 1U,
                                    .max_age_us    = UINT32_MAX};
    bool is_good = true;
    for (unsigned i = 0U; i < 2U; i++) {
        const osal_address_t any = {OSAL_IPV4_LOOPBACK, 0U};
        is_good                  = is_good && (osal_udp_open(&sockets[i], any, 0U) == STATUS_OK) &&
                  (osal_socket_local_address(&sockets[i], &addresses[i]) == STATUS_OK);
    }
    return is_good;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    own = side;
    return !is_polled &&
           (rtlink_producer_open(&producer, &resolver, (uint16_t)side, &terms, 1U) == STATUS_OK) &&
           (rtlink_consumer_open(&consumer, &resolver, (uint16_t)(1U - side), &terms, 1U) == STATUS_OK);
}

static void send_payload(const uint8_t* payload)
{
    (void)rtlink_producer_write(&producer, 5U, 1U, payload); // State OPERATIONAL, time 1 ns.
}

static void receive(uint8_t* payload)
{
    uint8_t frame[LINK_FRAME_MAX];
    osal_address_t from;
    size_t size           = 0U;
    const uint32_t frames = consumer.counters.frames;
    while (consumer.counters.frames == frames) {
        if (osal_socket_wait_readable(&sockets[own], UINT32_MAX) != STATUS_OK) {
            abort();
        }
        if (osal_udp_receive(&sockets[own], &from, frame, sizeof frame, &size) == STATUS_OK) {
            (void)rtlink_consumer_deliver(&consumer, frame, size);
        }
    }
    (void)memcpy(payload, consumer.payload, terms.layout_octets);
}

int main(int count, char** words)
{
    const transport_t transport = {
        .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive};
    return round_trip_main(count, words, &transport);
}
