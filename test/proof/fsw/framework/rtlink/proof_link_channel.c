// SPDX-License-Identifier: Apache-2.0
// Proves: a consumer takes a sample only from a frame of its own link, with the epoch of its own opening,
//     that is newer than its last sample; all other frames leave its sample unchanged. So it takes no frame
//     of a producer of another epoch (test/proof/fsw/supervisor/proof_link_manager.c proves that each opening
//     has a different epoch). No received octet causes an access outside the payload.
// Bounds: any consumer of datagrams without a play-out buffer, with a payload of 1..16 octets; one received
//     frame of 0..48 octets; no decimation; counters at 0.
// Replaced: crc32_iso returns any value; shared memory, sockets and play-out buffers are not used.
// Sources: fsw/framework/rtlink/link_frame.c
// Options: --unwind 4
// Fault: fsw/framework/rtlink/link_channel.c
//   - (decoded == STATUS_OK) && (header->link == consumer->link) && (header->epoch == consumer->epoch);
//   + (decoded == STATUS_OK) && (header->link == consumer->link) && (header->epoch >= consumer->epoch);
// Fault: fsw/framework/rtlink/link_channel.c
//   - return consumer->has_sample && ((ahead == 0U) || (ahead > (UINT32_MAX / 2U)));
//   + return consumer->has_sample && (ahead == 0U);
#include "fsw/framework/rtlink/link_channel.c"

#include "base/octets.h"
#include "test/proof/proof.h"

#define PAYLOAD 16U
#define RECEIVED 48U

uint32_t crc32_iso(const uint8_t* const octets, const size_t size)
{
    PROVE(__CPROVER_r_ok(octets, size), "the checksum reads inside the frame");
    return nondet_u32();
}

void rtlink_play_out_put(rtlink_play_out_t* const buffer, const rtlink_frame_header_t* const header,
                         const uint8_t* const payload)
{
    (void)buffer;
    (void)header;
    (void)payload;
    NEVER("there is no play-out buffer");
}

void proof(void)
{
    static rtlink_consumer_t consumer;
    consumer.terms.layout_octets = nondet_u32();
    consumer.terms.methods       = nondet_u8();
    consumer.terms.decimation    = 1U;
    consumer.link                = nondet_u16();
    consumer.epoch               = nondet_u32();
    consumer.is_open             = nondet_bool();
    consumer.has_sample          = nondet_bool();
    consumer.sequence            = nondet_u32();
    ASSUME((consumer.terms.layout_octets >= 1U) && (consumer.terms.layout_octets <= PAYLOAD));
    const uint32_t sequence = consumer.sequence;
    const bool had_sample   = consumer.has_sample;
    const size_t index      = any_size(PAYLOAD - 1U);
    consumer.payload[index] = nondet_u8();
    consumer.sample_time_ns = nondet_u64();
    const uint8_t octet     = consumer.payload[index];
    const uint64_t time_ns  = consumer.sample_time_ns;

    const size_t size = any_size(RECEIVED);
    uint8_t frame[size];
    const status_t status = rtlink_consumer_deliver(&consumer, frame, size);
    const bool is_taken   = (consumer.counters.frames != 0U);
    PROVE(IMPLIES(is_taken, (status == STATUS_OK) && consumer.is_open), "only an open link takes a sample");
    if (is_taken) {
        PROVE(octets_u16_at(&frame[4]) == consumer.link, "the sample is of this link");
        PROVE(octets_u32_at(&frame[8]) == consumer.epoch, "the sample is of this opening");
        PROVE(octets_u32_at(&frame[12]) == consumer.sequence, "the sequence number of the frame is stored");
        PROVE(!had_sample || ((consumer.sequence - sequence - 1U) < (UINT32_MAX / 2U)),
              "the sample is newer than the last one");
        PROVE(consumer.has_sample, "there is a sample");
        PROVE(consumer.payload[index] ==
                  ((index < consumer.terms.layout_octets) ? frame[LINK_FRAME_HEADER_OCTETS + index] : octet),
              "the payload is copied, and nothing else");
    } else {
        PROVE((consumer.sequence == sequence) && (consumer.has_sample == had_sample) &&
                  (consumer.payload[index] == octet) && (consumer.sample_time_ns == time_ns),
              "what is refused changes nothing");
    }
}
