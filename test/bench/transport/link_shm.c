// SPDX-License-Identifier: Apache-2.0
// A pair of real-time links through shared memory; the reader polls.
#include "fsw/framework/rtlink/link_channel.h"
#include "test/bench/transport/round_trip.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static rtlink_producer_t producers[2];
static rtlink_producer_t* producer;
static rtlink_consumer_t consumer;
static rtlink_terms_t terms;
static long maker; // Process that created the shared memory.

static bool shm_name(void* context, uint16_t link, char* out_name, size_t capacity)
{
    (void)context;
    (void)snprintf(out_name, capacity, "/bench-link-%ld-%u", maker, (unsigned)link);
    return true;
}

static const rtlink_resolver_t resolver = {.shm_name = shm_name};

static bool prepare(size_t size)
{
    maker = (long)getpid();
    terms = (rtlink_terms_t){.layout_octets = (uint32_t)size,
                             .order         = (uint8_t)rtlink_native_order(),
                             .period_us     = 500U,
                             .methods       = 1U << RTLINK_METHOD_SHARED_MEMORY,
                             .decimation    = 1U,
                             .max_age_us    = UINT32_MAX};
    return (rtlink_producer_open(&producers[0], &resolver, 0U, &terms, 1U) == STATUS_OK) &&
           (rtlink_producer_open(&producers[1], &resolver, 1U, &terms, 1U) == STATUS_OK);
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    producer = &producers[side];
    return is_polled &&
           (rtlink_consumer_open(&consumer, &resolver, (uint16_t)(1U - side), &terms, 1U) == STATUS_OK);
}

static void send_payload(const uint8_t* payload)
{
    (void)rtlink_producer_write(producer, 5U, 1U, payload);
}

static void receive(uint8_t* payload)
{
    const uint32_t frames = consumer.counters.frames;
    while (consumer.counters.frames == frames) {
        (void)rtlink_consumer_read(&consumer, 1U);
    }
    (void)memcpy(payload, consumer.payload, terms.layout_octets);
}

static void close_side(void)
{
    rtlink_consumer_close(&consumer);
    if (maker == (long)getpid()) {
        rtlink_producer_close(&producers[0]);
        rtlink_producer_close(&producers[1]);
    }
}

int main(int count, char** words)
{
    const transport_t transport = {.may_poll = true,
                                   .prepare  = prepare,
                                   .open     = open_side,
                                   .send     = send_payload,
                                   .receive  = receive,
                                   .close    = close_side};
    return round_trip_main(count, words, &transport);
}
