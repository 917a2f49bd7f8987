// SPDX-License-Identifier: Apache-2.0
// Proves: pus_tc_decode and pus_packet_frame access no octet outside a packet. What is accepted has the
//     size that its length field says, a right checksum, and a view of its data inside the packet; what is
//     refused names its failure and has no data.
// Bounds: every packet of 0..1024 octets.
// Replaced: crc16_ccitt returns any value; base/proof_crc16.c proves it.
// Sources: pus/core/packet.c base/octets.c
// Options: --unwind 2
// Quick: yes
// Fault: pus/core/packet.c
//   - out_tc->size = size - PUS_TC_MIN;
//   + out_tc->size = size - PUS_TC_MIN + 1U;
// Fault: pus/core/packet.c
//   - if (crc16_ccitt(octets, size) != 0U) {
//   + if (crc16_ccitt(octets, size - 1U) != 0U) {
#include "base/crc.h"
#include "pus/core/packet.h"
#include "test/proof/proof.h"

#define SIZE_MAX_HERE 1024U

static uint16_t crc;
static size_t summed;

uint16_t crc16_ccitt(const uint8_t* const octets, const size_t size)
{
    PROVE((size == 0U) || __CPROVER_r_ok(octets, size), "the checksum reads inside the packet");
    crc    = nondet_u16();
    summed = size;
    return crc;
}

void proof(void)
{
    const size_t size = any_size(SIZE_MAX_HERE);
    uint8_t octets[size]; // Of exactly this size, so that the first octet after it is outside.
    pus_tc_t tc;
    pus_failure_t failure;

    size_t framed            = 0U;
    const status_t is_framed = pus_packet_frame(octets, size, &framed);
    PROVE(IMPLIES(is_framed == STATUS_OK, framed <= size), "a complete packet is inside the stream");

    const status_t status = pus_tc_decode(octets, size, &tc, &failure);
    if (status == STATUS_OK) {
        PROVE(failure.code == PUS_FAILURE_NONE, "what is accepted has no failure");
        PROVE((size >= PUS_TC_MIN) && (crc == 0U) && (summed == size),
              "what is accepted has its least size and a right checksum of all its octets");
        PROVE((size_t)octets_u16_at(&octets[4]) + 7U == size, "the length field tells the size");
        PROVE((tc.size == size - PUS_TC_MIN) && (tc.data == &octets[PUS_TC_MIN - PUS_CRC_SIZE]),
              "the data are between header and checksum");
        PROVE(pus_packet_is_tc(octets, size), "what is accepted is a request");
        PROVE((tc.apid <= 2047U) && (tc.sequence <= 16383U), "fields are in their range");
    } else {
        PROVE(failure.code != PUS_FAILURE_NONE, "what is refused has a failure");
        PROVE((tc.data == NULL) && (tc.size == 0U), "what is refused has no data");
    }
}
