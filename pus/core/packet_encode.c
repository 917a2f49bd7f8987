// SPDX-License-Identifier: Apache-2.0
// Composes whole packets from their fields, for ground tools and tests. On board, app_process.c and
// requester.c write packets in place, so no flight program contains this code.
#include "base/assertion.h"
#include "base/crc.h"
#include "pus/core/packet_internal.h"

#define COMMON_SIZE 9U // Size of the headers of requests and reports [octets].

/// Begin a packet of `size` octets. False: there is no room.
static bool header_write(octet_writer_t* const writer, const packet_header_t* const header, const size_t size)
{
    uint8_t* const octets = octet_write_space(writer, COMMON_SIZE);
    if (octets != NULL) {
        octets_put_u16(octets, (uint16_t)(header->word0 | PACKET_SECONDARY_HEADER));
        octets_put_u16(&octets[2],
                       (uint16_t)((PUS_UNSEGMENTED << 14U) | (header->word1 & PACKET_SEQUENCE_MASK)));
        octets_put_u16(&octets[PACKET_LENGTH_FIELD], (uint16_t)(size - PACKET_LENGTH_OFFSET));
        octets[6] = (uint8_t)((PUS_VERSION << 4U) | (header->flags & PACKET_FLAGS_MASK));
        octets[7] = header->service;
        octets[8] = header->subtype;
    }
    return octets != NULL;
}

/// Append data and checksum to a packet whose headers are written.
static status_t finish(octet_writer_t* const writer, const uint8_t* const data, const size_t size,
                       size_t* const out_size)
{
    if (size > 0U) {
        octet_write_octets(writer, data, size);
    }
    octet_write_u16(writer, crc16_ccitt(writer->octets, writer->position));
    *out_size = writer->failed ? 0U : writer->position;
    return writer->failed ? STATUS_TOO_LARGE : STATUS_OK;
}

status_t pus_tc_encode(const pus_tc_t* const tc, uint8_t* const octets, const size_t capacity,
                       size_t* const out_size)
{
    FSW_ASSERT((tc != NULL) && (octets != NULL) && (out_size != NULL));
    const packet_header_t header = {.word0   = (uint16_t)(PACKET_TYPE_TC | (tc->apid & PACKET_APID_MASK)),
                                    .word1   = tc->sequence,
                                    .flags   = tc->ack,
                                    .service = tc->service,
                                    .subtype = tc->subtype};
    octet_writer_t writer        = octet_writer(octets, capacity);
    *out_size                    = 0U;
    if ((tc->size > PUS_TC_DATA_MAX) || !header_write(&writer, &header, tc->size + PUS_TC_MIN)) {
        return STATUS_TOO_LARGE;
    }
    octet_write_u16(&writer, tc->source);
    return finish(&writer, tc->data, tc->size, out_size);
}

status_t pus_tm_encode(const pus_tm_t* const tm, uint8_t* const octets, const size_t capacity,
                       size_t* const out_size)
{
    FSW_ASSERT((tm != NULL) && (octets != NULL) && (out_size != NULL));
    const packet_header_t header = {.word0   = (uint16_t)(tm->apid & PACKET_APID_MASK),
                                    .word1   = tm->sequence,
                                    .flags   = tm->time_status,
                                    .service = tm->service,
                                    .subtype = tm->subtype};
    octet_writer_t writer        = octet_writer(octets, capacity);
    *out_size                    = 0U;
    if ((tm->size > PUS_TM_DATA_MAX) || !header_write(&writer, &header, tm->size + PUS_TM_MIN)) {
        return STATUS_TOO_LARGE;
    }
    octet_write_u16(&writer, tm->counter);
    octet_write_u16(&writer, tm->destination);
    pus_time_write(&writer, tm->time_ns);
    return finish(&writer, tm->data, tm->size, out_size);
}
