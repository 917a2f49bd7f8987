// SPDX-License-Identifier: Apache-2.0
// Proves: pus_tc_decode and pus_packet_frame access no octet outside a packet. A packet is accepted if
//     and only if it has a permitted size, which its length field states, a correct checksum and the header
//     of a request; the result has the fields of its headers and a view of its data inside the packet. For a
//     refused packet the failure is reported, and the result has no data.
// Bounds: every packet of 0..4096 octets (the largest of the mission), and packets of 4097 octets.
// Replaced: crc16_ccitt returns any value; test/proof/base/proof_crc16.c proves the function.
// Sources: pus/core/packet.c base/octets.c
// Options: --unwind 2
// Quick: yes
// Fault: pus/core/packet.c
//   - out_tc->size = size - PUS_TC_MIN;
//   + out_tc->size = size - PUS_TC_MIN + 1U;
// Fault: pus/core/packet.c
//   - if (sequence_flags != PUS_UNSEGMENTED) {
//   + if (sequence_flags == 0U) {
// Fault: pus/core/packet.c
//   - if (crc16_ccitt(octets, size) != 0U) {
//   + if (crc16_ccitt(octets, size - 1U) != 0U) {
// Fault: pus/core/packet.c
//   - if (size < least) {
//   + if (size <= least) {
#include "base/crc.h"
#include "pus/core/packet.h"
#include "test/proof/proof.h"

#define SIZE_MAX_HERE (PUS_PACKET_MAX + 1U)

static size_t packet_size;
static uint16_t crc; // Checksum of the whole packet.

uint16_t crc16_ccitt(const uint8_t* const octets, const size_t size)
{
    PROVE((size == 0U) || __CPROVER_r_ok(octets, size), "the checksum reads inside the packet");
    return (size == packet_size) ? crc : nondet_u16();
}

void proof(void)
{
    const size_t size = any_size(SIZE_MAX_HERE);
    uint8_t octets[size]; // Exactly of the size of the packet, so that an access after the packet is found.
    packet_size = size;
    crc         = nondet_u16();
    pus_tc_t tc;
    pus_failure_t failure;

    size_t framed            = 0U;
    const status_t is_framed = pus_packet_frame(octets, size, &framed);
    const size_t stated =
        (size >= PUS_PRIMARY_HEADER_SIZE) ? ((size_t)octets_u16_at(&octets[4]) + 7U) : (size + 1U);
    PROVE((is_framed == STATUS_OK) == ((stated <= size) && (stated <= PUS_PACKET_MAX)),
          "a packet is framed if and only if it is complete and has a permitted size");
    PROVE(IMPLIES(is_framed == STATUS_OK, framed == stated), "a frame has the size of its length field");

    const status_t status = pus_tc_decode(octets, size, &tc, &failure);
    PROVE((status == STATUS_OK) == ((size >= PUS_TC_MIN) && (size <= PUS_PACKET_MAX) && (stated == size) &&
                                    (crc == 0U) && ((octets_u16_at(octets) & 0xF800U) == 0x1800U) &&
                                    ((octets[2] >> 6U) == 3U) && ((octets[6] >> 4U) == 2U)),
          "a request is accepted if and only if it is right");
    if (status == STATUS_OK) {
        PROVE(failure.code == PUS_FAILURE_NONE, "what is accepted has no failure");
        PROVE((tc.size == size - PUS_TC_MIN) && (tc.data == &octets[PUS_TC_MIN - PUS_CRC_SIZE]),
              "the data are between header and checksum");
        PROVE(pus_packet_is_tc(octets, size) && (size <= PUS_PACKET_MAX), "what is accepted is a request");
        PROVE((octets_u16_at(octets) == (0x1800U | tc.apid)) && (tc.apid <= 2047U) &&
                  (octets_u16_at(&octets[2]) == (0xC000U | tc.sequence)) && (tc.sequence <= 16383U),
              "version, kind, APID, whole packet and sequence are those of the primary header");
        PROVE((octets[6] == (0x20U | tc.ack)) && (octets[7] == tc.service) && (octets[8] == tc.subtype) &&
                  (octets_u16_at(&octets[9]) == tc.source) && (octets_u32_at(octets) == tc.request_id),
              "version, acknowledgements, message and source are those of the secondary header");
    } else {
        PROVE(failure.code != PUS_FAILURE_NONE, "what is refused has a failure");
        PROVE((tc.data == NULL) && (tc.size == 0U), "what is refused has no data");
    }
}
