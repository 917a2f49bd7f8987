// SPDX-License-Identifier: Apache-2.0
// Proves: pus_tm_decode accesses no octet outside a packet. A packet is accepted if and only if it has a
//     permitted size, which its length field states, a correct checksum, the header of a report and a time in
//     the format of this mission; the result has the fields of its headers and a view of its data inside the
//     packet. For a refused packet the failure is reported, and the result has no data.
// Bounds: every packet of 0..4096 octets (the largest of the mission), and packets of 4097 octets.
// Replaced: crc16_ccitt returns any value; test/proof/base/proof_crc16.c proves the function.
// Sources: pus/core/packet.c pus/core/packet_report.c base/octets.c
// Options: --unwind 2
// Quick: yes
// Fault: pus/core/packet_report.c
//   - if (time_status != STATUS_OK) {
//   + if (time_status == STATUS_TRUNCATED) {
// Fault: pus/core/packet.c
//   - if (size_reported(octets) != size) {
//   + if (size_reported(octets) < size) {
// Fault: pus/core/packet.c
//   - if (size > most) {
//   + if (size >= most) {
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
    uint8_t octets[size];
    packet_size = size;
    crc         = nondet_u16();
    pus_tm_t tm;
    pus_failure_t failure;
    const status_t status = pus_tm_decode(octets, size, &tm, &failure);
    PROVE((status == STATUS_OK) ==
              ((size >= PUS_TM_MIN) && (size <= PUS_PACKET_MAX) &&
               (((size_t)octets_u16_at(&octets[4]) + 7U) == size) && (crc == 0U) &&
               ((octets_u16_at(octets) & 0xF800U) == 0x0800U) && ((octets[2] >> 6U) == 3U) &&
               ((octets[6] >> 4U) == 2U) && (octets[PUS_TM_HEADER_SIZE - PUS_TIME_SIZE] == PUS_TIME_P_FIELD)),
          "a report is accepted if and only if it is right");
    if (status == STATUS_OK) {
        PROVE(failure.code == PUS_FAILURE_NONE, "what is accepted has no failure");
        PROVE((tm.size == size - PUS_TM_MIN) && (tm.data == &octets[PUS_TM_HEADER_SIZE]),
              "the data are between header and checksum");
        PROVE(!pus_packet_is_tc(octets, size) && (size <= PUS_PACKET_MAX), "what is accepted is a report");
        PROVE((octets_u16_at(octets) == (0x0800U | tm.apid)) && (tm.apid <= 2047U) &&
                  (octets_u16_at(&octets[2]) == (0xC000U | tm.sequence)) && (tm.sequence <= 16383U),
              "version, kind, APID, whole packet and sequence are those of the primary header");
        PROVE((octets[6] == (0x20U | tm.time_status)) && (octets[7] == tm.service) &&
                  (octets[8] == tm.subtype) && (octets_u16_at(&octets[9]) == tm.counter) &&
                  (octets_u16_at(&octets[11]) == tm.destination),
              "version, message, counter and destination are those of the secondary header");
    } else {
        PROVE(failure.code != PUS_FAILURE_NONE, "what is refused has a failure");
        PROVE((tm.data == NULL) && (tm.size == 0U), "what is refused has no data");
    }
}
