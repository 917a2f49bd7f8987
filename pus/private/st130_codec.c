// SPDX-License-Identifier: Apache-2.0
#include "pus/private/st130_codec.h"

#include "base/assertion.h"
#include "pus/core/record_codec.h"

// Fields of the properties and of the two ends of a link, which begin at offset `base` of the struct.
#define PROPERTIES(base)                                                                                     \
    PUS_CODEC_FIELD_IN(base, pus_link_properties_t, layout_hash),                                            \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, layout_size),                                        \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, byte_order),                                         \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, period_us),                                          \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, tolerance_permille),                                 \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, method),                                             \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, depth),                                              \
        PUS_CODEC_FIELD_IN(base, pus_link_properties_t, age_max_us)
#define ENDS(base)                                                                                           \
    PUS_CODEC_FIELD_IN(base, pus_link_ends_t, producer_apid),                                                \
        PUS_CODEC_FIELD_IN(base, pus_link_ends_t, producer_port),                                            \
        PUS_CODEC_FIELD_IN(base, pus_link_ends_t, consumer_apid),                                            \
        PUS_CODEC_FIELD_IN(base, pus_link_ends_t, consumer_port)

const pus_codec_field_t link_request_fields[LINK_ENDS + LINK_PROPERTIES + 3U] = {
    PUS_CODEC_FIELD(pus_link_request_t, transaction), PUS_CODEC_FIELD(pus_link_request_t, link),
    ENDS(offsetof(pus_link_request_t, ends)), PROPERTIES(offsetof(pus_link_request_t, properties)),
    PUS_CODEC_END};

const pus_codec_field_t link_accept_fields[LINK_PROPERTIES + 3U] = {
    PUS_CODEC_FIELD(pus_link_accept_t, transaction), PUS_CODEC_FIELD(pus_link_accept_t, link),
    PROPERTIES(offsetof(pus_link_accept_t, properties)), PUS_CODEC_END};

const pus_codec_field_t link_refuse_fields[LINK_PROPERTIES + 4U] = {
    PUS_CODEC_FIELD(pus_link_refuse_t, transaction), PUS_CODEC_FIELD(pus_link_refuse_t, reason),
    PUS_CODEC_FIELD(pus_link_refuse_t, field), PROPERTIES(offsetof(pus_link_refuse_t, supported)),
    PUS_CODEC_END};

const pus_codec_field_t link_open_fields[3U] = {PUS_CODEC_FIELD(pus_link_open_t, link),
                                                PUS_CODEC_FIELD(pus_link_open_t, epoch), PUS_CODEC_END};

const pus_codec_field_t link_close_fields[3U] = {PUS_CODEC_FIELD(pus_link_close_t, link),
                                                 PUS_CODEC_FIELD(pus_link_close_t, reason), PUS_CODEC_END};

const pus_codec_field_t link_transition_fields[5U] = {
    PUS_CODEC_FIELD(pus_link_transition_t, link), PUS_CODEC_FIELD(pus_link_transition_t, previous),
    PUS_CODEC_FIELD(pus_link_transition_t, state), PUS_CODEC_FIELD(pus_link_transition_t, cause),
    PUS_CODEC_END};

const pus_codec_field_t link_offer_fields[LINK_PROPERTIES + 3U] = {
    PUS_CODEC_FIELD(pus_link_offer_t, port), PUS_CODEC_FIELD(pus_link_offer_t, role),
    PROPERTIES(offsetof(pus_link_offer_t, properties)), PUS_CODEC_END};

const pus_codec_field_t link_status_fields[LINK_ENDS + LINK_PROPERTIES + 8U] = {
    PUS_CODEC_FIELD(pus_link_status_t, link),          PUS_CODEC_FIELD(pus_link_status_t, state),
    ENDS(offsetof(pus_link_status_t, ends)),           PROPERTIES(offsetof(pus_link_status_t, properties)),
    PUS_CODEC_FIELD(pus_link_status_t, sent),          PUS_CODEC_FIELD(pus_link_status_t, received),
    PUS_CODEC_FIELD(pus_link_status_t, lost),          PUS_CODEC_FIELD(pus_link_status_t, late),
    PUS_CODEC_FIELD(pus_link_status_t, last_sequence), PUS_CODEC_END};

static void write_endpoint(octet_writer_t* const writer, const pus_endpoint_t* const endpoint)
{
    FSW_ASSERT(endpoint->size <= PUS_ENDPOINT_MAX);
    octet_write_u8(writer, endpoint->kind);
    octet_write_u8(writer, endpoint->size);
    octet_write_octets(writer, endpoint->octets, endpoint->size);
}

status_t pus_link_request_read(octet_reader_t* const reader, pus_link_request_t* const out_request)
{
    return pus_codec_read_all(reader, link_request_fields, out_request);
}

status_t pus_link_open_read(octet_reader_t* const reader, pus_link_open_t* const out_open)
{
    return pus_codec_read_all(reader, link_open_fields, out_open);
}

status_t pus_link_close_read(octet_reader_t* const reader, pus_link_close_t* const out_close)
{
    return pus_codec_read_all(reader, link_close_fields, out_close);
}

status_t pus_link_accept_report(pus_app_process_t* const process, const uint16_t destination,
                                const pus_link_accept_t* const accept, const uint64_t now_ns)
{
    octet_writer_t writer = pus_tm_begin(process, PUS_SERVICE_RTLINK, PUS_LINK_ACCEPT, destination, now_ns);
    pus_codec_write(&writer, link_accept_fields, accept);
    write_endpoint(&writer, &accept->endpoint);
    return pus_tm_post(process, &writer);
}

status_t pus_link_refuse_report(pus_app_process_t* const process, const uint16_t destination,
                                const pus_link_refuse_t* const refuse, const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_RTLINK, PUS_LINK_REFUSE, link_refuse_fields};
    return pus_codec_post(process, &layout, destination, refuse, now_ns);
}

status_t pus_link_transition_report(pus_app_process_t* const process,
                                    const pus_link_transition_t* const transition, const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(process, PUS_SERVICE_RTLINK, PUS_LINK_TRANSITION, PUS_USER_GROUND, now_ns);
    pus_codec_write(&writer, link_transition_fields, transition);
    pus_time_write(&writer, process->epoch_ns + transition->time_ns);
    return pus_tm_post(process, &writer);
}
