// SPDX-License-Identifier: Apache-2.0
// The limit for datagrams: two sockets on the loopback interface, and a receive call that sleeps.
#include "test/bench/transport/round_trip.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

static int sockets[2];
static struct sockaddr_in addresses[2];
static unsigned own;
static size_t octets;

static bool prepare(size_t size)
{
    octets = size;
    for (unsigned i = 0U; i < 2U; i++) {
        socklen_t length = sizeof addresses[i];
        addresses[i] =
            (struct sockaddr_in){.sin_family = AF_INET, .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
        sockets[i] = socket(AF_INET, SOCK_DGRAM, 0);
        if ((bind(sockets[i], (const struct sockaddr*)&addresses[i], sizeof addresses[i]) != 0) ||
            (getsockname(sockets[i], (struct sockaddr*)&addresses[i], &length) != 0)) {
            return false;
        }
    }
    return true;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    own = side;
    return !is_polled;
}

static void send_payload(const uint8_t* payload)
{
    (void)sendto(sockets[own], payload, octets, 0, (const struct sockaddr*)&addresses[1U - own],
                 sizeof addresses[0]);
}

static void receive(uint8_t* payload)
{
    while (recv(sockets[own], payload, octets, 0) != (ssize_t)octets) {
    }
}

int main(int count, char** words)
{
    const transport_t transport = {
        .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive};
    return round_trip_main(count, words, &transport);
}
