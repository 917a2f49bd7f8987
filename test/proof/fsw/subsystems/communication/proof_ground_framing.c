// SPDX-License-Identifier: Apache-2.0
// Proves: cutting the TCP stream of a ground user into space packets accesses nothing behind the octets
//     received; a packet that is given lies inside them whole and has the size that its length field says;
//     an incomplete one waits; a stream that lost its framing is closed; so the stream always advances or
//     waits for octets.
// Bounds: 0..4128 octets received (32 more than the largest packet) of any content, any client, without
//     security of the ground link.
// Replaced: the security layer (SDLS) is not used.
// Sources: fsw/subsystems/communication/ground_security.c pus/core/packet.c base/octets.c
// Options: --unwind 2
// Quick: yes
// Fault: pus/core/packet.c
//   - return (size < *out_size) ? STATUS_TRUNCATED : STATUS_OK;
//   + return (size < (*out_size - 1U)) ? STATUS_TRUNCATED : STATUS_OK;
// Fault: pus/core/packet.c
//   - if (*out_size > PUS_PACKET_MAX) {
//   + if (*out_size > (PUS_PACKET_MAX + 1U)) {
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
          "three statuses");
    if (status == STATUS_OK) {
        PROVE((unit.packet == octets) && (unit.size <= size) && __CPROVER_r_ok(unit.packet, unit.size),
              "a packet is inside what was received");
        PROVE((unit.size == ((size_t)octets_u16_at(&octets[4]) + 7U)) && (unit.size >= 7U),
              "it has its size");
        PROVE(unit.taken == unit.size, "the stream advances by it");
    }
    PROVE(IMPLIES(status == STATUS_TRUNCATED, (size < PUS_PRIMARY_HEADER_SIZE) || (size < unit.size)),
          "it waits");
    PROVE(IMPLIES(status == STATUS_TRUNCATED, unit.size <= PUS_PACKET_MAX), "what it waits for fits");
    PROVE(IMPLIES(status == STATUS_CLOSED, ((size_t)octets_u16_at(&octets[4]) + 7U) > PUS_PACKET_MAX),
          "it is closed");
}
