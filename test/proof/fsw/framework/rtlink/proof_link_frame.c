// SPDX-License-Identifier: Apache-2.0
// Proves: rtlink_frame_decode accesses no octet outside a frame and accepts only a frame of the agreed
//     size with correct magic, version, flags and checksum of header and payload; a frame that
//     rtlink_frame_encode wrote is decoded to the same header and payload; the epoch can be read without
//     decoding.
// Bounds: payloads of 1..16 octets, received frames of 0..48 octets, with and without checksum.
// Replaced: crc32_iso returns any value, the same when a frame is encoded and decoded;
//     test/proof/base/proof_crc32.c proves the function.
// Sources: fsw/framework/rtlink/link_frame.c
// Options: --unwind 4
// Fault: fsw/framework/rtlink/link_frame.c
//   - if (size != (checked + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U))) {
//   + if (size < checked) {
// Fault: fsw/framework/rtlink/link_frame.c
//   - .epoch          = (uint32_t)(words[1] >> 32U),
//   + .epoch          = (uint32_t)(words[1] >> 31U),
// Fault: fsw/framework/rtlink/link_frame.c
//   - if (with_crc && (octets_u32_at(&frame[checked]) != crc32_iso(frame, checked))) {
//   + if (with_crc && (octets_u32_at(&frame[checked]) != crc32_iso(frame, payload_size))) {
#include "base/crc.h"
#include "base/octets.h"
#include "fsw/framework/rtlink/link_frame.h"
#include "test/proof/proof.h"

#include <string.h>

#define PAYLOAD 16U
#define RECEIVED 48U

static uint32_t checksum;
static const uint8_t* summed; // The octets of the last checksum.
static size_t summed_size;

uint32_t crc32_iso(const uint8_t* const octets, const size_t size)
{
    PROVE(__CPROVER_r_ok(octets, size), "the checksum reads inside the frame");
    summed      = octets;
    summed_size = size;
    return checksum;
}

static void prove_round_trip(void)
{
    const rtlink_frame_header_t sent = {.producer_state = nondet_u8(),
                                        .link           = nondet_u16(),
                                        .epoch          = nondet_u32(),
                                        .sequence       = nondet_u32(),
                                        .time_ns        = nondet_u64()};
    uint8_t payload[PAYLOAD];
    uint8_t frame[LINK_FRAME_MAX];
    const size_t payload_size = any_size(PAYLOAD);
    const bool with_crc       = nondet_bool();
    ASSUME(payload_size >= 1U);
    const size_t size = rtlink_frame_encode(&sent, payload, payload_size, with_crc, frame);
    PROVE(IMPLIES(with_crc, (summed == frame) && (summed_size == (LINK_FRAME_HEADER_OCTETS + payload_size))),
          "the checksum that is sent is that of header and payload");
    rtlink_frame_header_t got;
    const uint8_t* data   = NULL;
    const status_t status = rtlink_frame_decode(frame, size, payload_size, with_crc, &got, &data);
    PROVE(status == STATUS_OK, "what is encoded is decoded");
    PROVE((got.producer_state == sent.producer_state) && (got.link == sent.link) &&
              (got.epoch == sent.epoch) && (got.sequence == sent.sequence) && (got.time_ns == sent.time_ns),
          "the header is the same");
    const size_t index = any_size(PAYLOAD);
    PROVE(IMPLIES(index < payload_size, data[index] == payload[index]), "the payload is the same");
    PROVE(rtlink_frame_epoch(frame, size) == sent.epoch, "the epoch is read without decoding");
}

static void prove_decoding(void)
{
    const size_t size = any_size(RECEIVED);
    uint8_t frame[size];
    const size_t payload_size = any_size(PAYLOAD);
    const bool with_crc       = nondet_bool();
    rtlink_frame_header_t header;
    const uint8_t* data = NULL;
    (void)rtlink_frame_epoch(frame, size);
    if (rtlink_frame_decode(frame, size, payload_size, with_crc, &header, &data) == STATUS_OK) {
        PROVE(size == (LINK_FRAME_HEADER_OCTETS + payload_size + (with_crc ? LINK_FRAME_CRC_OCTETS : 0U)),
              "the size is the agreed one");
        PROVE((octets_u16_at(frame) == 0x5254U) && (frame[2] == 1U) && (octets_u16_at(&frame[6]) == 0U),
              "magic, version and flags");
        PROVE(IMPLIES(with_crc, (octets_u32_at(&frame[size - LINK_FRAME_CRC_OCTETS]) == checksum) &&
                                    (summed == frame) &&
                                    (summed_size == (LINK_FRAME_HEADER_OCTETS + payload_size))),
              "the checksum is that of header and payload");
        PROVE(__CPROVER_r_ok(data, payload_size), "the payload is inside the frame");
    }
}

void proof(void)
{
    checksum = nondet_u32();
    if (nondet_bool()) {
        prove_round_trip();
    } else {
        prove_decoding();
    }
}
