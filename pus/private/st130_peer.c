// SPDX-License-Identifier: Apache-2.0
// The side of the link manager in service 130: writes requests and reads reports.
#include "pus/private/st130_codec.h"

#include <string.h>

#define STATUS_SIZE 52U // Size of an entry of TM[130,9] [octets].

void pus_link_request_write(octet_writer_t* const writer, const pus_link_request_t* const request)
{
    pus_codec_write(writer, link_request_fields, request);
}

void pus_link_open_write(octet_writer_t* const writer, const pus_link_open_t* const open)
{
    pus_codec_write(writer, link_open_fields, open);
}

void pus_link_close_write(octet_writer_t* const writer, const pus_link_close_t* const close)
{
    pus_codec_write(writer, link_close_fields, close);
}

/// Read an endpoint. The reader fails if the endpoint is longer than PUS_ENDPOINT_MAX.
static void read_endpoint(octet_reader_t* const reader, pus_endpoint_t* const out_endpoint)
{
    *out_endpoint               = (pus_endpoint_t){0};
    out_endpoint->kind          = octet_read_u8(reader);
    const uint8_t size          = octet_read_u8(reader);
    const uint8_t* const octets = octet_read_octets(reader, size);
    if ((octets == NULL) || (size > PUS_ENDPOINT_MAX)) {
        reader->failed = true;
        return;
    }
    out_endpoint->size = size;
    (void)memcpy(out_endpoint->octets, octets, size);
}

status_t pus_link_accept_read(octet_reader_t* const reader, pus_link_accept_t* const out_accept)
{
    pus_codec_read(reader, link_accept_fields, out_accept);
    read_endpoint(reader, &out_accept->endpoint);
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

status_t pus_link_refuse_read(octet_reader_t* const reader, pus_link_refuse_t* const out_refuse)
{
    return pus_codec_read_all(reader, link_refuse_fields, out_refuse);
}

status_t pus_link_transition_read(octet_reader_t* const reader, pus_link_transition_t* const out_transition)
{
    pus_codec_read(reader, link_transition_fields, out_transition);
    const status_t status = pus_time_read(reader, &out_transition->time_ns);
    return ((status == STATUS_OK) && octet_reader_is_done(reader)) ? STATUS_OK : STATUS_INVALID;
}

status_t pus_link_statuses_read(octet_reader_t* const reader, uint16_t* const out_count)
{
    const uint16_t count = octet_read_u16(reader);
    const bool is_good   = !reader->failed && (octet_reader_left(reader) == ((size_t)count * STATUS_SIZE));
    *out_count           = is_good ? count : 0U;
    return is_good ? STATUS_OK : STATUS_INVALID;
}

void pus_link_status_read(octet_reader_t* const reader, pus_link_status_t* const out_status)
{
    pus_codec_read(reader, link_status_fields, out_status);
}
