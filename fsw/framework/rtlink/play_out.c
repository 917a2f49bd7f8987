// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/play_out.h"

#include "base/assertion.h"

#include <string.h>

#define NS_PER_US 1000U

void rtlink_play_out_clear(rtlink_play_out_t* const buffer, const size_t sample_octets)
{
    FSW_ASSERT((buffer != NULL) && (sample_octets >= 1U) && (sample_octets <= RTLINK_PAYLOAD_MAX));
    const size_t fitting  = RTLINK_PLAY_OUT_OCTETS / sample_octets;
    buffer->sample_octets = sample_octets;
    buffer->capacity      = (fitting < RTLINK_PLAY_OUT_SAMPLES) ? fitting : RTLINK_PLAY_OUT_SAMPLES;
    buffer->count         = 0U;
}

static bool is_known(const rtlink_play_out_t* const buffer, const uint32_t sequence)
{
    size_t i = 0U;
    while ((i < buffer->count) && (buffer->headers[i].sequence != sequence)) {
        i++;
    }
    return i < buffer->count;
}

void rtlink_play_out_put(rtlink_play_out_t* const buffer, const rtlink_frame_header_t* const header,
                         const uint8_t* const payload)
{
    FSW_ASSERT((buffer != NULL) && (header != NULL) && (payload != NULL));
    if ((buffer->count == buffer->capacity) || is_known(buffer, header->sequence)) {
        return;
    }
    buffer->headers[buffer->count] = *header;
    (void)memcpy(&buffer->payloads[buffer->count * buffer->sample_octets], payload, buffer->sample_octets);
    buffer->count++;
}

/// True if a sample must be played now. A sample from the future is not due: the producer's clock may be
/// ahead.
static bool is_due(const rtlink_play_out_t* const buffer, const size_t index, const uint64_t now_ns)
{
    const uint64_t wait_ns = ((uint64_t)buffer->delay_us + buffer->budget_us) * NS_PER_US;
    const uint64_t time_ns = buffer->headers[index].time_ns;
    return (now_ns >= time_ns) && ((now_ns - time_ns) >= wait_ns);
}

/// True if sequence number `one` precedes `other`; sequence numbers wrap.
static bool is_before(const uint32_t one, const uint32_t other)
{
    return (one - other) > (UINT32_MAX / 2U);
}

bool rtlink_play_out_take(rtlink_play_out_t* const buffer, const uint64_t now_ns,
                          rtlink_frame_header_t* const out_header, const uint8_t** const out_payload)
{
    FSW_ASSERT((buffer != NULL) && (out_header != NULL) && (out_payload != NULL));
    size_t found = buffer->count;
    for (size_t i = 0U; i < buffer->count; i++) {
        const bool is_better = (found == buffer->count) ||
                               is_before(buffer->headers[i].sequence, buffer->headers[found].sequence);
        if (is_due(buffer, i, now_ns) && is_better) {
            found = i;
        }
    }
    if (found == buffer->count) {
        return false;
    }
    // Swap the sample with the last one, so that its payload stays readable in the slot after the others.
    const size_t last                = buffer->count - 1U;
    const rtlink_frame_header_t kept = buffer->headers[last];
    uint8_t octets[RTLINK_PAYLOAD_MAX];
    *out_header = buffer->headers[found];
    if (found != last) {
        (void)memcpy(octets, &buffer->payloads[found * buffer->sample_octets], buffer->sample_octets);
        (void)memcpy(&buffer->payloads[found * buffer->sample_octets],
                     &buffer->payloads[last * buffer->sample_octets], buffer->sample_octets);
        (void)memcpy(&buffer->payloads[last * buffer->sample_octets], octets, buffer->sample_octets);
        buffer->headers[found] = kept;
    }
    buffer->count = last;
    *out_payload  = &buffer->payloads[last * buffer->sample_octets];
    return true;
}
