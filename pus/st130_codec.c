// SPDX-License-Identifier: Apache-2.0
#include "pus/st130_codec.h"

#include "fsw/framework/base/assertion.h"
#include "pus/fields.h"

#include <string.h>

#define OFFER_SIZE 24U  // Of an entry of TM[130,2] [octets].
#define STATUS_SIZE 52U // Of an entry of TM[130,9] [octets].

// P and the two ends, at their place in a message.
#define PROPERTIES(place)                                                                                    \
    PUS_FIELD_IN(place, pus_link_properties_t, layout_hash),                                                 \
        PUS_FIELD_IN(place, pus_link_properties_t, layout_size),                                             \
        PUS_FIELD_IN(place, pus_link_properties_t, byte_order),                                              \
        PUS_FIELD_IN(place, pus_link_properties_t, period_us),                                               \
        PUS_FIELD_IN(place, pus_link_properties_t, tolerance_permille),                                      \
        PUS_FIELD_IN(place, pus_link_properties_t, method),                                                  \
        PUS_FIELD_IN(place, pus_link_properties_t, depth),                                                   \
        PUS_FIELD_IN(place, pus_link_properties_t, age_max_us)
#define ENDS(place)                                                                                          \
    PUS_FIELD_IN(place, pus_link_ends_t, producer_apid),                                                     \
        PUS_FIELD_IN(place, pus_link_ends_t, producer_port),                                                 \
        PUS_FIELD_IN(place, pus_link_ends_t, consumer_apid),                                                 \
        PUS_FIELD_IN(place, pus_link_ends_t, consumer_port)

static const pus_field_t request_fields[] = {
    PUS_FIELD(pus_link_request_t, transaction), PUS_FIELD(pus_link_request_t, link),
    ENDS(offsetof(pus_link_request_t, ends)), PROPERTIES(offsetof(pus_link_request_t, properties)),
    PUS_FIELDS_END};

static const pus_field_t accept_fields[] = {
    PUS_FIELD(pus_link_accept_t, transaction), PUS_FIELD(pus_link_accept_t, link),
    PROPERTIES(offsetof(pus_link_accept_t, properties)), PUS_FIELDS_END};

static const pus_field_t refuse_fields[] = {
    PUS_FIELD(pus_link_refuse_t, transaction), PUS_FIELD(pus_link_refuse_t, reason),
    PUS_FIELD(pus_link_refuse_t, field), PROPERTIES(offsetof(pus_link_refuse_t, supported)), PUS_FIELDS_END};

static const pus_field_t open_fields[] = {PUS_FIELD(pus_link_open_t, link), PUS_FIELD(pus_link_open_t, epoch),
                                          PUS_FIELDS_END};

static const pus_field_t close_fields[] = {PUS_FIELD(pus_link_close_t, link),
                                           PUS_FIELD(pus_link_close_t, reason), PUS_FIELDS_END};

static const pus_field_t transition_fields[] = {
    PUS_FIELD(pus_link_transition_t, link), PUS_FIELD(pus_link_transition_t, previous),
    PUS_FIELD(pus_link_transition_t, state), PUS_FIELD(pus_link_transition_t, cause), PUS_FIELDS_END};

static const pus_field_t offer_fields[] = {
    PUS_FIELD(pus_link_offer_t, port), PUS_FIELD(pus_link_offer_t, role),
    PROPERTIES(offsetof(pus_link_offer_t, properties)), PUS_FIELDS_END};

static const pus_field_t status_fields[] = {
    PUS_FIELD(pus_link_status_t, link),          PUS_FIELD(pus_link_status_t, state),
    ENDS(offsetof(pus_link_status_t, ends)),     PROPERTIES(offsetof(pus_link_status_t, properties)),
    PUS_FIELD(pus_link_status_t, sent),          PUS_FIELD(pus_link_status_t, received),
    PUS_FIELD(pus_link_status_t, lost),          PUS_FIELD(pus_link_status_t, late),
    PUS_FIELD(pus_link_status_t, last_sequence), PUS_FIELDS_END};

static void endpoint_write(octet_writer_t* const writer, const pus_endpoint_t* const endpoint)
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

static status_t done(const octet_reader_t* const reader)
{
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

void pus_link_request_write(octet_writer_t* const writer, const pus_link_request_t* const request)
{
    pus_fields_write(writer, request_fields, request);
}

status_t pus_link_request_read(octet_reader_t* const reader, pus_link_request_t* const out_request)
{
    return pus_fields_read_all(reader, request_fields, out_request);
}

status_t pus_link_accept_read(octet_reader_t* const reader, pus_link_accept_t* const out_accept)
{
    pus_fields_read(reader, accept_fields, out_accept);
    endpoint_read(reader, &out_accept->endpoint);
    return done(reader);
}

status_t pus_link_refuse_read(octet_reader_t* const reader, pus_link_refuse_t* const out_refuse)
{
    return pus_fields_read_all(reader, refuse_fields, out_refuse);
}

void pus_link_open_write(octet_writer_t* const writer, const pus_link_open_t* const open)
{
    pus_fields_write(writer, open_fields, open);
    endpoint_write(writer, &open->peer);
    octet_write_u32(writer, open->deadline_ms);
}

status_t pus_link_open_read(octet_reader_t* const reader, pus_link_open_t* const out_open)
{
    pus_fields_read(reader, open_fields, out_open);
    endpoint_read(reader, &out_open->peer);
    out_open->deadline_ms = octet_read_u32(reader);
    return done(reader);
}

void pus_link_close_write(octet_writer_t* const writer, const pus_link_close_t* const close)
{
    pus_fields_write(writer, close_fields, close);
}

status_t pus_link_close_read(octet_reader_t* const reader, pus_link_close_t* const out_close)
{
    return pus_fields_read_all(reader, close_fields, out_close);
}

status_t pus_link_accept_report(pus_process_t* const process, const uint16_t destination,
                                const pus_link_accept_t* const accept, const uint64_t now_ns)
{
    octet_writer_t writer = pus_tm_begin(process, PUS_SERVICE_RTLINK, PUS_LINK_ACCEPT, destination, now_ns);
    pus_fields_write(&writer, accept_fields, accept);
    endpoint_write(&writer, &accept->endpoint);
    return pus_tm_post(process, &writer);
}

status_t pus_link_refuse_report(pus_process_t* const process, const uint16_t destination,
                                const pus_link_refuse_t* const refuse, const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_RTLINK, PUS_LINK_REFUSE, refuse_fields};
    return pus_fields_post(process, &layout, destination, refuse, now_ns);
}

status_t pus_link_transition_report(pus_process_t* const process,
                                    const pus_link_transition_t* const transition, const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(process, PUS_SERVICE_RTLINK, PUS_LINK_TRANSITION, PUS_USER_GROUND, now_ns);
    pus_fields_write(&writer, transition_fields, transition);
    pus_time_write(&writer, process->epoch_ns + transition->time_ns);
    return pus_tm_post(process, &writer);
}

status_t pus_link_transition_read(octet_reader_t* const reader, pus_link_transition_t* const out_transition)
{
    pus_fields_read(reader, transition_fields, out_transition);
    const status_t status = pus_time_read(reader, &out_transition->time_ns);
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

void link_offer_write(octet_writer_t* const writer, const pus_link_offer_t* const offer)
{
    pus_fields_write(writer, offer_fields, offer);
}

void pus_link_offer_read(octet_reader_t* const reader, pus_link_offer_t* const out_offer)
{
    pus_fields_read(reader, offer_fields, out_offer);
}

status_t pus_link_statuses_read(octet_reader_t* const reader, uint16_t* const out_count)
{
    return count_read(reader, STATUS_SIZE, out_count);
}

void link_status_write(octet_writer_t* const writer, const pus_link_status_t* const status)
{
    pus_fields_write(writer, status_fields, status);
}

void pus_link_status_read(octet_reader_t* const reader, pus_link_status_t* const out_status)
{
    pus_fields_read(reader, status_fields, out_status);
}
