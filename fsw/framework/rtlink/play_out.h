// SPDX-License-Identifier: Apache-2.0
/// Play-out buffer of a link whose frames have different delays: it makes the delay constant. A sample is
/// played when its age reaches the delay of the link plus the jitter budget. A sample that arrives later is
/// played at once if it is newer than the last one played; otherwise the consumer drops it. Frames may arrive
/// in any order and more than once. A sample is stale when it is older than its play-out time by more than
/// the agreed age of the link and by more than RTLINK_PLAY_OUT_BUDGETS budgets.
///
/// Ownership  The caller provides rtlink_play_out_t. It belongs to one consumer while the consumer is open.
/// Context    The task of the consumer.
/// Time       rtlink_play_out_put and rtlink_play_out_take: O(samples in the buffer).
#ifndef FSW_FRAMEWORK_RTLINK_PLAY_OUT_H
#define FSW_FRAMEWORK_RTLINK_PLAY_OUT_H

#include "fsw/framework/rtlink/link_frame.h"

/// Largest number of samples in the buffer; their payloads together have at most RTLINK_PLAY_OUT_OCTETS. A
/// build that defines one of the two must define both. The default values are sufficient for samples of 96
/// octets at 2 kHz that all arrive at once and are played 550 ms later (--delay 1000): a frame arrives early
/// if time in the run is slower than in the network.
#ifndef RTLINK_PLAY_OUT_SAMPLES
#define RTLINK_PLAY_OUT_SAMPLES 1152U
#define RTLINK_PLAY_OUT_OCTETS 110592U
#endif
#define RTLINK_PLAY_OUT_BUDGETS 3U

typedef struct {        // Private, except delay_us and budget_us, which are set before the link is opened.
    uint32_t delay_us;  ///< Mean delay of the link.
    uint32_t budget_us; ///< Jitter that the buffer compensates.
    size_t sample_octets;
    size_t capacity; // Number of samples of that size for which the buffer has room.
    size_t count;
    rtlink_frame_header_t headers[RTLINK_PLAY_OUT_SAMPLES]; // The first `count`, in any order.
    uint8_t payloads[RTLINK_PLAY_OUT_OCTETS];
} rtlink_play_out_t;

/// Empty the buffer, for samples of `sample_octets` (1..RTLINK_PAYLOAD_MAX).
void rtlink_play_out_clear(rtlink_play_out_t* buffer, size_t sample_octets);
/// Keep a sample until it is played. It is dropped if the buffer is full or has a sample of that sequence
/// number.
void rtlink_play_out_put(rtlink_play_out_t* buffer, const rtlink_frame_header_t* header,
                         const uint8_t* payload);
/// Remove the sample with the lowest sequence number among those due at `now_ns`. False: none is due.
/// *out_payload is valid until the next call.
bool rtlink_play_out_take(rtlink_play_out_t* buffer, uint64_t now_ns, rtlink_frame_header_t* out_header,
                          const uint8_t** out_payload);

#endif // FSW_FRAMEWORK_RTLINK_PLAY_OUT_H
