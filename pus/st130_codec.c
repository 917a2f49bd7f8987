// SPDX-License-Identifier: Apache-2.0
#include "pus/st130_codec.h"

#include "fsw/framework/base/assertion.h"

#include <string.h>

#define OFFER_SIZE 24U  // Of an entry of TM[130,2] [octets].
#define STATUS_SIZE 52U // Of an entry of TM[130,9] [octets].

void link_properties_write(octet_writer_t* const writer, const pus_link_properties_t* const properties)
{
    octet_write_u32(writer, properties->layout_hash);
    octet_write_u32(writer, properties->layout_size);
    octet_write_u8(writer, properties->byte_order);
    octet_write_u32(writer, properties->period_us);
    octet_write_u16(writer, properties->tolerance_permille);
    octet_write_u8(writer, properties->method);
    octet_write_u8(writer, properties->depth);
    octet_write_u32(writer, properties->age_max_us);
}

static void properties_read(octet_reader_t* const reader, pus_link_properties_t* const out_properties)
{
    out_properties->layout_hash        = octet_read_u32(reader);
    out_properties->layout_size        = octet_read_u32(reader);
    out_properties->byte_order         = octet_read_u8(reader);
    out_properties->period_us          = octet_read_u32(reader);
    out_properties->tolerance_permille = octet_read_u16(reader);
    out_properties->method             = octet_read_u8(reader);
    out_properties->depth              = octet_read_u8(reader);
    out_properties->age_max_us         = octet_read_u32(reader);
}

void link_endpoint_write(octet_writer_t* const writer, const pus_endpoint_t* const endpoint)
{
    FSW_ASSERT(endpoint->size <= PUS_ENDPOINT_MAX);
    octet_write_u8(writer, endpoint->kind);
    octet_write_u8(writer, endpoint->size);
    octet_write_octets(writer, endpoint->octets, endpoint->size);
}

/// An endpoint longer than PUS_ENDPOINT_MAX makes the reader fail.
static void endpoint_read(octet_reader_t* const reader, pus_endpoint_t* const out_endpoint)
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

void link_ends_write(octet_writer_t* const writer, const pus_link_ends_t* const ends)
{
    octet_write_u16(writer, ends->producer_apid);
    octet_write_u16(writer, ends->producer_port);
    octet_write_u16(writer, ends->consumer_apid);
    octet_write_u16(writer, ends->consumer_port);
}

static void ends_read(octet_reader_t* const reader, pus_link_ends_t* const out_ends)
{
    out_ends->producer_apid = octet_read_u16(reader);
    out_ends->producer_port = octet_read_u16(reader);
    out_ends->consumer_apid = octet_read_u16(reader);
    out_ends->consumer_port = octet_read_u16(reader);
}

static status_t done(const octet_reader_t* const reader)
{
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

void pus_link_request_write(octet_writer_t* const writer, const pus_link_request_t* const request)
{
    octet_write_u32(writer, request->transaction);
    octet_write_u16(writer, request->link);
    link_ends_write(writer, &request->ends);
    link_properties_write(writer, &request->properties);
}

status_t pus_link_request_read(octet_reader_t* const reader, pus_link_request_t* const out_request)
{
    out_request->transaction = octet_read_u32(reader);
    out_request->link        = octet_read_u16(reader);
    ends_read(reader, &out_request->ends);
    properties_read(reader, &out_request->properties);
    return done(reader);
}

status_t pus_link_accept_read(octet_reader_t* const reader, pus_link_accept_t* const out_accept)
{
    out_accept->transaction = octet_read_u32(reader);
    out_accept->link        = octet_read_u16(reader);
    properties_read(reader, &out_accept->properties);
    endpoint_read(reader, &out_accept->endpoint);
    return done(reader);
}

status_t pus_link_refuse_read(octet_reader_t* const reader, pus_link_refuse_t* const out_refuse)
{
    out_refuse->transaction = octet_read_u32(reader);
    out_refuse->reason      = octet_read_u8(reader);
    out_refuse->field       = octet_read_u8(reader);
    properties_read(reader, &out_refuse->supported);
    return done(reader);
}

void pus_link_open_write(octet_writer_t* const writer, const pus_link_open_t* const open)
{
    octet_write_u16(writer, open->link);
    octet_write_u32(writer, open->epoch);
    link_endpoint_write(writer, &open->peer);
    octet_write_u32(writer, open->deadline_ms);
}

status_t pus_link_open_read(octet_reader_t* const reader, pus_link_open_t* const out_open)
{
    out_open->link  = octet_read_u16(reader);
    out_open->epoch = octet_read_u32(reader);
    endpoint_read(reader, &out_open->peer);
    out_open->deadline_ms = octet_read_u32(reader);
    return done(reader);
}

void pus_link_close_write(octet_writer_t* const writer, const pus_link_close_t* const close)
{
    octet_write_u16(writer, close->link);
    octet_write_u8(writer, close->reason);
}

status_t pus_link_close_read(octet_reader_t* const reader, pus_link_close_t* const out_close)
{
    out_close->link   = octet_read_u16(reader);
    out_close->reason = octet_read_u8(reader);
    return done(reader);
}

status_t pus_link_transition_read(octet_reader_t* const reader, pus_link_transition_t* const out_transition)
{
    out_transition->link     = octet_read_u16(reader);
    out_transition->previous = octet_read_u8(reader);
    out_transition->state    = octet_read_u8(reader);
    out_transition->cause    = octet_read_u8(reader);
    const status_t status    = pus_time_read(reader, &out_transition->time_ns);
    return (status == STATUS_OK) ? done(reader) : STATUS_INVALID;
}

/// Count of a list whose entries fill the rest exactly.
static status_t count_read(octet_reader_t* const reader, const size_t entry_size, uint16_t* const out_count)
{
    const uint16_t count = octet_read_u16(reader);
    const bool is_good   = !reader->failed && (octet_reader_left(reader) == (count * entry_size));
    *out_count           = is_good ? count : 0U;
    return is_good ? STATUS_OK : STATUS_INVALID;
}

status_t pus_link_offers_read(octet_reader_t* const reader, uint16_t* const out_count)
{
    return count_read(reader, OFFER_SIZE, out_count);
}

void pus_link_offer_read(octet_reader_t* const reader, pus_link_offer_t* const out_offer)
{
    out_offer->port = octet_read_u16(reader);
    out_offer->role = octet_read_u8(reader);
    properties_read(reader, &out_offer->properties);
}

status_t pus_link_statuses_read(octet_reader_t* const reader, uint16_t* const out_count)
{
    return count_read(reader, STATUS_SIZE, out_count);
}

void pus_link_status_read(octet_reader_t* const reader, pus_link_status_t* const out_status)
{
    out_status->link  = octet_read_u16(reader);
    out_status->state = octet_read_u8(reader);
    ends_read(reader, &out_status->ends);
    properties_read(reader, &out_status->properties);
    out_status->sent          = octet_read_u32(reader);
    out_status->received      = octet_read_u32(reader);
    out_status->lost          = octet_read_u32(reader);
    out_status->late          = octet_read_u32(reader);
    out_status->last_sequence = octet_read_u32(reader);
}
