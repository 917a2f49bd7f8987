// SPDX-License-Identifier: Apache-2.0
// The limit for sleeping readers: a payload in shared memory, a count, and a futex.
#define _GNU_SOURCE
#include "test/bench/transport/round_trip.h"

#include <linux/futex.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

typedef struct {
    uint32_t count;
    uint8_t payload[ROUND_TRIP_PAYLOAD_MAX];
    uint8_t apart[124];
} box_t;

static box_t* boxes;
static box_t* out;
static box_t* in;
static size_t octets;
static uint32_t seen;

static bool prepare(size_t size)
{
    octets = size;
    boxes  = round_trip_shared(2U * sizeof *boxes);
    return boxes != NULL;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    out = &boxes[side];
    in  = &boxes[1U - side];
    return !is_polled;
}

static void send_payload(const uint8_t* payload)
{
    (void)memcpy(out->payload, payload, octets);
    (void)__atomic_add_fetch(&out->count, 1U, __ATOMIC_RELEASE);
    (void)syscall(SYS_futex, &out->count, FUTEX_WAKE, 1, NULL, NULL, 0);
}

static void receive(uint8_t* payload)
{
    while (__atomic_load_n(&in->count, __ATOMIC_ACQUIRE) == seen) {
        (void)syscall(SYS_futex, &in->count, FUTEX_WAIT, seen, NULL, NULL, 0);
    }
    seen++;
    (void)memcpy(payload, in->payload, octets);
}

int main(int count, char** words)
{
    const transport_t transport = {
        .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive};
    return round_trip_main(count, words, &transport);
}
