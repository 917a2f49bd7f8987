// SPDX-License-Identifier: Apache-2.0
// ZeroMQ, a PAIR of sockets over ipc.
#include "test/bench/transport/round_trip.h"

#include <stdio.h>
#include <unistd.h>
#include <zmq.h>

static void* context;
static void* end;
static char path[64];
static size_t octets;

static bool prepare(size_t size)
{
    octets = size;
    (void)snprintf(path, sizeof path, "ipc:///tmp/bench-zeromq-%ld", (long)getpid());
    return true;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    context = zmq_ctx_new();
    end     = zmq_socket(context, ZMQ_PAIR);
    return !is_polled && (end != NULL) &&
           (((side == 0U) ? zmq_bind(end, path) : zmq_connect(end, path)) == 0);
}

static void send_payload(const uint8_t* payload)
{
    (void)zmq_send(end, payload, octets, 0);
}

static void receive(uint8_t* payload)
{
    while (zmq_recv(end, payload, octets, 0) != (int)octets) {
    }
}

static void close_side(void)
{
    (void)zmq_close(end);
    (void)zmq_ctx_term(context);
    (void)unlink(&path[sizeof "ipc://" - 1U]);
}

int main(int count, char** words)
{
    const transport_t transport = {
        .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive, .close = close_side};
    return round_trip_main(count, words, &transport);
}
