// SPDX-License-Identifier: Apache-2.0
#include "pus/core/requester.h"

#include "base/assertion.h"
#include "base/crc.h"

#include <string.h>

#define OFFSET_SEQUENCE 2U // Offsets of fields in a request [octets].
#define OFFSET_LENGTH 4U
#define OFFSET_ACK 6U
#define OFFSET_SERVICE 7U
#define OFFSET_SUBTYPE 8U
#define OFFSET_SOURCE 9U

void pus_requester_init(pus_requester_t* const requester, const uint16_t apid, const pus_port_t* const port)
{
    FSW_ASSERT((requester != NULL) && (port != NULL) && (port->send != NULL) && (apid >= 1U) &&
               (apid <= PUS_APID_MAX));
    (void)memset(requester, 0, sizeof *requester);
    requester->source = (uint16_t)(PUS_USER_ONBOARD | apid);
    requester->port   = *port;
}

void pus_requester_count_with(pus_requester_t* const requester, pus_requester_t* const other)
{
    FSW_ASSERT((requester != NULL) && (other != NULL) && (other->counting == NULL));
    requester->counting = other;
}

octet_writer_t pus_tc_begin(pus_requester_t* const requester, const uint16_t apid, const uint8_t service,
                            const uint8_t subtype, const uint8_t ack)
{
    FSW_ASSERT((requester != NULL) && (apid <= PUS_APID_MAX));
    if (requester->is_building) {
        requester->counters.discarded++;
    }
    requester->is_building = true;
    requester->apid        = apid;

    octet_writer_t writer = octet_writer(requester->building, PUS_PACKET_MAX - PUS_CRC_SIZE);
    // Not null, because the buffer has room.
    uint8_t* const header = octet_write_space(&writer, PUS_TC_HEADER_SIZE);
    // Sequence and length are written when the request is finished.
    octets_put_u16(header, (uint16_t)(0x1800U | apid));
    header[OFFSET_ACK]     = (uint8_t)((PUS_VERSION << 4U) | (ack & PUS_ACK_ALL));
    header[OFFSET_SERVICE] = service;
    header[OFFSET_SUBTYPE] = subtype;
    octets_put_u16(&header[OFFSET_SOURCE], requester->source);
    return writer;
}

/// Returns the sequence count of the addressee; null if there are too many addressees.
static uint16_t* sequence_of(pus_requester_t* const requester, const uint16_t apid)
{
    for (uint16_t i = 0U; i < requester->addressee_count; i++) {
        if (requester->addressees[i].apid == apid) {
            return &requester->addressees[i].sequence;
        }
    }
    if (requester->addressee_count >= PUS_ADDRESSEES) {
        return NULL;
    }
    const uint16_t index              = requester->addressee_count++;
    requester->addressees[index].apid = apid;
    return &requester->addressees[index].sequence;
}

/// Close the request that is being built. STATUS_OK, STATUS_TOO_LARGE, STATUS_INVALID.
static status_t close_request(pus_requester_t* const requester, octet_writer_t* const writer)
{
    const bool was_building = requester->is_building;
    const bool failed       = writer->failed;
    requester->is_building  = false;
    writer->failed          = true; // The request is finished: it cannot be extended or sent again.
    if (!was_building) {
        requester->counters.discarded++;
        return STATUS_INVALID;
    }
    if (failed) {
        requester->counters.oversized++;
        return STATUS_TOO_LARGE;
    }
    return STATUS_OK;
}

status_t pus_tc_send(pus_requester_t* const requester, octet_writer_t* const writer,
                     pus_token_t* const out_token)
{
    FSW_ASSERT((requester != NULL) && (writer != NULL));
    const status_t status = close_request(requester, writer);
    if (status != STATUS_OK) {
        return status;
    }
    pus_requester_t* const counting = (requester->counting != NULL) ? requester->counting : requester;
    uint16_t* const sequence        = sequence_of(counting, requester->apid);
    if (sequence == NULL) {
        return STATUS_EXHAUSTED;
    }
    const size_t size     = writer->position + PUS_CRC_SIZE;
    uint8_t* const packet = requester->building;
    const uint16_t word1  = (uint16_t)((PUS_UNSEGMENTED << 14U) | *sequence);
    const size_t length   = size - (PUS_PRIMARY_HEADER_SIZE + 1U);
    octets_put_u16(&packet[OFFSET_SEQUENCE], word1);
    octets_put_u16(&packet[OFFSET_LENGTH], (uint16_t)length);
    octets_put_u16(&packet[writer->position], crc16_ccitt(packet, writer->position));

    if (requester->port.send(requester->port.context, packet, size) != STATUS_OK) {
        requester->counters.refused++;
        return STATUS_FULL;
    }
    *sequence = (uint16_t)((*sequence + 1U) % PUS_SEQUENCE_COUNT);
    requester->counters.sent++;
    if (out_token != NULL) {
        *out_token = (pus_token_t){.request_id = octets_u32_at(packet),
                                   .source     = requester->source,
                                   .ack        = (uint8_t)(packet[OFFSET_ACK] & PUS_ACK_ALL),
                                   .service    = packet[OFFSET_SERVICE],
                                   .subtype    = packet[OFFSET_SUBTYPE]};
    }
    return STATUS_OK;
}
