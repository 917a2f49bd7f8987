// SPDX-License-Identifier: Apache-2.0
// Proves: dividing the TCP stream of a ground user into space packets accesses nothing after the received
//     octets; a complete packet is returned with the size that its length field states; the
//     function waits for more octets if and only if the packet is incomplete; it closes the stream if and
//     only if a length field exceeds the largest packet. So the stream always advances, waits or is closed.
// Bounds: 0..4128 received octets (32 more than the largest packet) of any content, any client, no security
//     of the ground link.
// Replaced: crc16_ccitt returns any value (the framing does not call it); the security layer (SDLS) is not
//     used.
// Sources: fsw/subsystems/communication/ground_security.c pus/core/packet.c base/octets.c
// Options: --unwind 2
// Quick: yes
// Fault: pus/core/packet.c
//   - return (size < *out_size) ? STATUS_TRUNCATED : STATUS_OK;
//   + return (size < (*out_size - 1U)) ? STATUS_TRUNCATED : STATUS_OK;
// Fault: pus/core/packet.c
//   - if (*out_size > PUS_PACKET_MAX) {
//   + if (*out_size > (PUS_PACKET_MAX + 1U)) {
// Fault: pus/core/packet.c
//   - if (size < PUS_PRIMARY_HEADER_SIZE) {
//   + if (size <= PUS_PRIMARY_HEADER_SIZE) {
#include "base/crc.h"
#include "fsw/subsystems/communication/ground_security.h"
#include "pus/core/packet.h"
#include "test/proof/proof.h"

#define RECEIVED (PUS_PACKET_MAX + 32U)

uint16_t crc16_ccitt(const uint8_t* const octets, const size_t size)
{
    (void)octets;
    (void)size;
    return nondet_u16();
}

void proof(void)
{
    static communication_ground_security_t security;
    communication_ground_security_init(&security, NULL);
    const size_t size = any_size(RECEIVED);
    uint8_t octets[size];
    const unsigned client = nondet_u8();
    ASSUME(client < GROUND_CLIENTS);
    communication_ground_unit_t unit;
    const status_t status = communication_ground_security_next(&security, client, octets, size, &unit);
    PROVE((status == STATUS_OK) || (status == STATUS_TRUNCATED) || (status == STATUS_CLOSED),
          "the status is one of the contract");
    if (status == STATUS_OK) {
        PROVE((unit.packet == octets) && (unit.size <= size) && __CPROVER_r_ok(unit.packet, unit.size),
              "a packet is inside what was received");
        PROVE((unit.size == ((size_t)octets_u16_at(&octets[4]) + 7U)) && (unit.size >= 7U),
              "a packet has the size of its length field");
        PROVE(unit.taken == unit.size, "the stream advances by the packet");
    }
    const bool has_header   = (size >= PUS_PRIMARY_HEADER_SIZE);
    const size_t stated     = has_header ? ((size_t)octets_u16_at(&octets[4]) + 7U) : 0U;
    const bool is_too_large = has_header && (stated > PUS_PACKET_MAX);
    PROVE((status == STATUS_TRUNCATED) == (!has_header || (!is_too_large && (size < stated))),
          "a packet waits if and only if it is incomplete");
    PROVE(IMPLIES(status == STATUS_TRUNCATED, unit.size <= PUS_PACKET_MAX),
          "an awaited packet is not too large");
    PROVE((status == STATUS_CLOSED) == is_too_large,
          "the stream is closed if and only if a packet is too large");
}
