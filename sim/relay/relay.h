// SPDX-License-Identifier: Apache-2.0
/// A network with delay, jitter, loss and reordering, for the frames of several links. Delays and losses are
/// drawn from a seed, for each link independently: the delay and the loss of a frame depend only on the seed,
/// its link and its number on that link.
///
/// Ownership  The caller provides relay_t (4.4 MiB).
/// Context    One task.
/// Time       relay_take: O(frames that are due later); all others O(1).
#ifndef SIM_RELAY_RELAY_H
#define SIM_RELAY_RELAY_H

#include "sim/bus/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RELAY_LINKS_MAX 32U
#define RELAY_FRAME_MAX 1088U  ///< Octets.
#define RELAY_FRAMES_MAX 4096U ///< Most frames of all links that are under way at a time.
#define RELAY_NEVER UINT64_MAX

typedef struct {
    uint64_t delay_ns; ///< Mean delay of a frame.
    double jitter; ///< 0..1: the delay is uniform from delay_ns * (1 - jitter) to delay_ns * (1 + jitter).
    double loss;   ///< Probability that a frame is lost, 0..1.
} relay_law_t;

typedef struct {
    uint64_t delayed;   ///< Frames delivered after their delay.
    uint64_t lost;      ///< Frames lost: at random, too long, or beyond RELAY_FRAMES_MAX.
    uint64_t reordered; ///< Frames delivered after a later frame of their link.
} relay_counters_t;

typedef struct { // Private.
    uint64_t due_ns;
    uint64_t number; // Number of the frame on its link, from 1.
    uint16_t link;
    uint16_t size;
    uint8_t octets[RELAY_FRAME_MAX];
} relay_frame_t;

typedef struct { // Private, except counters.
    relay_law_t law;
    relay_counters_t counters;
    bus_random_t random[RELAY_LINKS_MAX];
    uint64_t taken[RELAY_LINKS_MAX];
    uint64_t latest[RELAY_LINKS_MAX]; // Largest number of a delivered frame.
    size_t count;
    size_t first;                     // Index in `order` of the frame that is due first.
    uint16_t order[RELAY_FRAMES_MAX]; // Ring of the frames under way, by due time, then by arrival.
    uint16_t unused[RELAY_FRAMES_MAX];
    relay_frame_t frames[RELAY_FRAMES_MAX];
} relay_t;

void relay_init(relay_t* relay, uint64_t seed, const relay_law_t* law);
/// Take a frame of `link` (below RELAY_LINKS_MAX) at `now_ns`.
void relay_take(relay_t* relay, unsigned link, const uint8_t* octets, size_t size, uint64_t now_ns);
/// Give the next frame that is due at `now_ns`, valid until the next call of relay_take. Null: none is due.
const relay_frame_t* relay_give(relay_t* relay, uint64_t now_ns);
/// Returns the time at which the next frame is due; RELAY_NEVER if there is none.
uint64_t relay_next_ns(const relay_t* relay);

#endif // SIM_RELAY_RELAY_H
