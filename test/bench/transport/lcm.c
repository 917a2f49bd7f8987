// SPDX-License-Identifier: Apache-2.0
// LCM over UDP multicast on the loopback interface, ttl 0.
#include "test/bench/transport/round_trip.h"

#include <lcm/lcm.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static lcm_t* lcm;
static char channels[2][32];
static unsigned own;
static size_t octets;
static uint8_t received[ROUND_TRIP_PAYLOAD_MAX];
static bool is_new;

static bool prepare(size_t size)
{
    octets = size;
    for (unsigned i = 0U; i < 2U; i++) {
        (void)snprintf(channels[i], sizeof channels[i], "bench%ld-%u", (long)getpid(), i);
    }
    return true;
}

static void take(const lcm_recv_buf_t* buffer, const char* channel, void* context)
{
    (void)channel;
    (void)context;
    if (buffer->data_size == octets) {
        (void)memcpy(received, buffer->data, octets);
        is_new = true;
    }
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    own = side;
    lcm = is_polled ? NULL : lcm_create("udpm://239.255.76.67:7667?ttl=0");
    return (lcm != NULL) && (lcm_subscribe(lcm, channels[1U - side], take, NULL) != NULL);
}

static void send_payload(const uint8_t* payload)
{
    (void)lcm_publish(lcm, channels[own], payload, (unsigned)octets);
}

static void receive(uint8_t* payload)
{
    is_new = false;
    while (!is_new) {
        (void)lcm_handle(lcm);
    }
    (void)memcpy(payload, received, octets);
}

static void close_side(void)
{
    lcm_destroy(lcm);
}

int main(int count, char** words)
{
    const transport_t transport = {
        .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive, .close = close_side};
    return round_trip_main(count, words, &transport);
}
