// SPDX-License-Identifier: Apache-2.0
// The limit for polled readers: only a sequence lock around the latest value in shared memory.
#include "test/bench/transport/round_trip.h"

#include <string.h>

typedef struct {
    uint32_t sequence_counter;
    uint32_t unused;
    uint64_t words[ROUND_TRIP_PAYLOAD_MAX / 8U];
} slot_t;

static slot_t* slots;
static slot_t* out;
static slot_t* in;
static size_t octets;
static uint32_t seen;

static bool prepare(size_t size)
{
    octets = size;
    slots  = round_trip_shared(2U * 4096U);
    return slots != NULL;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    (void)size;
    slot_t* const second = (slot_t*)(void*)((uint8_t*)slots + 4096U);
    out                  = (side == 0U) ? slots : second;
    in                   = (side == 0U) ? second : slots;
    return is_polled;
}

static void send_payload(const uint8_t* payload)
{
    const uint32_t counter = __atomic_load_n(&out->sequence_counter, __ATOMIC_RELAXED);
    __atomic_store_n(&out->sequence_counter, counter + 1U, __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_RELEASE);
    for (size_t i = 0U; i < (octets / 8U); i++) {
        uint64_t word = 0U;
        (void)memcpy(&word, &payload[8U * i], sizeof word);
        __atomic_store_n(&out->words[i], word, __ATOMIC_RELAXED);
    }
    __atomic_store_n(&out->sequence_counter, counter + 2U, __ATOMIC_RELEASE);
}

static void receive(uint8_t* payload)
{
    for (;;) {
        const uint32_t before = __atomic_load_n(&in->sequence_counter, __ATOMIC_ACQUIRE);
        if ((before == seen) || ((before & 1U) != 0U)) {
            continue;
        }
        for (size_t i = 0U; i < (octets / 8U); i++) {
            const uint64_t word = __atomic_load_n(&in->words[i], __ATOMIC_RELAXED);
            (void)memcpy(&payload[8U * i], &word, sizeof word);
        }
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        if (__atomic_load_n(&in->sequence_counter, __ATOMIC_RELAXED) == before) {
            seen = before;
            return;
        }
    }
}

int main(int count, char** words)
{
    const transport_t transport = {
        .may_poll = true, .prepare = prepare, .open = open_side, .send = send_payload, .receive = receive};
    return round_trip_main(count, words, &transport);
}
