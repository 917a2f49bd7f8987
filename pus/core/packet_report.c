// SPDX-License-Identifier: Apache-2.0
// Decoding of reports, for the supervisor and for tools; a subsystem only writes reports.
#include "base/assertion.h"
#include "pus/core/packet_internal.h"

status_t pus_tm_decode(const uint8_t* const octets, const size_t size, pus_tm_t* const out_tm,
                       pus_failure_t* const out_failure)
{
    FSW_ASSERT(((octets != NULL) || (size == 0U)) && (out_tm != NULL) && (out_failure != NULL));
    octet_reader_t reader = octet_reader(octets, size);
    packet_header_t header;
    packet_header_read(&reader, &header);
    out_tm->apid               = (uint16_t)(header.word0 & PACKET_APID_MASK);
    out_tm->sequence           = (uint16_t)(header.word1 & PACKET_SEQUENCE_MASK);
    out_tm->time_status        = (uint8_t)(header.flags & PACKET_FLAGS_MASK);
    out_tm->service            = header.service;
    out_tm->subtype            = header.subtype;
    out_tm->counter            = octet_read_u16(&reader);
    out_tm->destination        = octet_read_u16(&reader);
    const status_t time_status = pus_time_read(&reader, &out_tm->time_ns);
    out_tm->data               = NULL;
    out_tm->size               = 0U;

    const packet_form_t form = {.least = PUS_TM_MIN, .most = PUS_PACKET_MAX, .type = 0U};
    const status_t status    = packet_check(octets, size, &form, &header, out_failure);
    if (status != STATUS_OK) {
        return status;
    }
    if (time_status != STATUS_OK) {
        *out_failure = pus_failure(PUS_FAILURE_DATA, PUS_TM_HEADER_SIZE - PUS_TIME_SIZE);
        return STATUS_INVALID;
    }
    out_tm->size = size - PUS_TM_MIN;
    out_tm->data = octet_read_octets(&reader, out_tm->size);
    return STATUS_OK;
}
