// SPDX-License-Identifier: Apache-2.0
#include "sim/relay/relay.h"

#include <string.h>

#define TWO_POWER_MINUS_53 1.1102230246251565e-16 // Converts 53 random bits to a number in [0, 1).
#define LINK_STEP 0xD1B54A32D192ED03ULL ///< Difference of the seeds of two links; odd, so all are different.

void relay_init(relay_t* const relay, const uint64_t seed, const relay_law_t* const law)
{
    (void)memset(relay, 0, sizeof *relay);
    relay->law = *law;
    for (unsigned link = 0U; link < RELAY_LINKS_MAX; link++) {
        bus_random_seed(&relay->random[link], seed + (LINK_STEP * (link + 1U)));
    }
    for (size_t i = 0U; i < RELAY_FRAMES_MAX; i++) {
        relay->unused[i] = (uint16_t)i;
    }
}

static size_t index_of(const relay_t* const relay, const size_t rank)
{
    return (relay->first + rank) % RELAY_FRAMES_MAX;
}

/// Insert a frame after all frames that are due earlier or at the same time.
static void insert(relay_t* const relay, const uint16_t index)
{
    const uint64_t due_ns = relay->frames[index].due_ns;
    size_t rank           = relay->count;
    while ((rank > 0U) && (relay->frames[relay->order[index_of(relay, rank - 1U)]].due_ns > due_ns)) {
        relay->order[index_of(relay, rank)] = relay->order[index_of(relay, rank - 1U)];
        rank--;
    }
    relay->order[index_of(relay, rank)] = index;
    relay->count++;
}

void relay_take(relay_t* const relay, const unsigned link, const uint8_t* const octets, const size_t size,
                const uint64_t now_ns)
{
    bus_random_t* const random = &relay->random[link];
    // Draw loss and delay for every frame, so that the loss of a frame does not change the delay of the next.
    const bool is_lost  = bus_random_chance(random, relay->law.loss);
    const double spread = (2.0 * (double)(bus_random_next(random) >> 11U) * TWO_POWER_MINUS_53) - 1.0;
    const double factor = 1.0 + (relay->law.jitter * spread);
    relay->taken[link]++;
    if (is_lost || (size > RELAY_FRAME_MAX) || (relay->count == RELAY_FRAMES_MAX)) {
        relay->counters.lost++;
        return;
    }
    const uint16_t index       = relay->unused[RELAY_FRAMES_MAX - 1U - relay->count];
    relay_frame_t* const frame = &relay->frames[index];
    frame->due_ns              = now_ns + (uint64_t)((double)relay->law.delay_ns * factor);
    frame->number              = relay->taken[link];
    frame->link                = (uint16_t)link;
    frame->size                = (uint16_t)size;
    (void)memcpy(frame->octets, octets, size);
    insert(relay, index);
}

const relay_frame_t* relay_give(relay_t* const relay, const uint64_t now_ns)
{
    if (relay_next_ns(relay) > now_ns) {
        return NULL;
    }
    const uint16_t index             = relay->order[relay->first];
    const relay_frame_t* const frame = &relay->frames[index];
    relay->first                     = index_of(relay, 1U);
    relay->count--;
    relay->unused[RELAY_FRAMES_MAX - 1U - relay->count] = index;
    relay->counters.delayed++;
    if (frame->number < relay->latest[frame->link]) {
        relay->counters.reordered++;
    } else {
        relay->latest[frame->link] = frame->number;
    }
    return frame;
}

uint64_t relay_next_ns(const relay_t* const relay)
{
    return (relay->count > 0U) ? relay->frames[relay->order[relay->first]].due_ns : RELAY_NEVER;
}
