// SPDX-License-Identifier: Apache-2.0
#include "pus/private/st130_rtlink.h"

#include "base/assertion.h"
#include "pus/private/st130_codec.h"

#define ENTRY_MAX 64U // Maximum size of an entry [octets].

void pus_rtlink_init(pus_rtlink_t* const rtlink, const pus_rtlink_port_t* const port)
{
    FSW_ASSERT((rtlink != NULL) && (port != NULL) && (port->offer != NULL) && (port->request != NULL) &&
               (port->open != NULL) && (port->close != NULL) && (port->status != NULL));
    *rtlink = (pus_rtlink_t){.port = *port};
}

// ---- Lists: a filter {N x {u16}} selects entries; N = 0 selects all ----

static bool format_filter(void* const self, octet_reader_t* const reader)
{
    (void)self;
    const uint8_t count = octet_read_u8(reader);
    (void)octet_read_octets(reader, (size_t)count * sizeof(uint16_t));
    return true;
}

/// Function that writes entry `index` of a list; *out_id is its id. False after the last entry.
typedef bool (*entry_t)(const pus_rtlink_port_t* port, uint16_t index, uint16_t* out_id,
                        octet_writer_t* writer);

static bool write_offer(const pus_rtlink_port_t* const port, const uint16_t index, uint16_t* const out_id,
                        octet_writer_t* const writer)
{
    pus_link_offer_t offer = {0};
    if (!port->offer(port->context, index, &offer)) {
        return false;
    }
    *out_id = offer.port;
    pus_codec_write(writer, link_offer_fields, &offer);
    return true;
}

static bool write_status(const pus_rtlink_port_t* const port, const uint16_t index, uint16_t* const out_id,
                         octet_writer_t* const writer)
{
    pus_link_status_t status = {0};
    if (!port->status(port->context, index, &status)) {
        return false;
    }
    *out_id = status.link;
    pus_codec_write(writer, link_status_fields, &status);
    return true;
}

/// True if there is an entry with this id.
static bool has_entry(const pus_rtlink_port_t* const port, const entry_t entry, const uint16_t id)
{
    uint8_t scratch[ENTRY_MAX];
    uint16_t found        = 0U;
    octet_writer_t writer = octet_writer(scratch, sizeof scratch);
    for (uint16_t index = 0U; entry(port, index, &found, &writer); index++) {
        if (found == id) {
            return true;
        }
        writer.position = 0U;
    }
    return false;
}

/// Answer TC[130,1] or TC[130,8] with the list of the selected entries; refuse each id in the filter for
/// which there is no entry.
static pus_reply_t report_list(const pus_rtlink_port_t* const port, pus_request_t* const request,
                               const uint8_t subtype, const entry_t entry)
{
    const uint8_t id_count   = octet_read_u8(&request->reader);
    const octet_reader_t ids = request->reader;
    for (uint16_t i = 1U; i <= id_count; i++) {
        const uint16_t id = octet_read_u16(&request->reader);
        if (has_entry(port, entry, id)) {
            pus_request_perform(request);
        } else {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
        }
    }
    if ((id_count > 0U) && (request->performed == 0U)) {
        return pus_done();
    }
    if (id_count == 0U) {
        pus_request_perform(request);
    }
    octet_writer_t writer = pus_list_begin(request, subtype);
    uint16_t count        = 0U;
    size_t end            = writer.position;
    uint16_t id           = 0U;
    for (uint16_t index = 0U; entry(port, index, &id, &writer) && !writer.failed; index++) {
        bool is_selected = (id_count == 0U);
        request->reader  = ids;
        for (uint8_t i = 0U; i < id_count; i++) {
            is_selected = (octet_read_u16(&request->reader) == id) || is_selected;
        }
        if (is_selected) {
            count++;
            end = writer.position;
        }
        writer.position = end;
    }
    return pus_list_end(request, &writer, count);
}

static pus_reply_t report_offers(void* const self, pus_request_t* const request)
{
    return report_list(&((const pus_rtlink_t*)self)->port, request, PUS_LINK_OFFERS, write_offer);
}

static pus_reply_t report_status(void* const self, pus_request_t* const request)
{
    return report_list(&((const pus_rtlink_t*)self)->port, request, PUS_LINK_STATUS, write_status);
}

// ---- Negotiation ----

static bool format_request(void* const self, octet_reader_t* const reader)
{
    pus_link_request_t request;
    (void)self;
    return pus_link_request_read(reader, &request) == STATUS_OK;
}

static bool format_open(void* const self, octet_reader_t* const reader)
{
    pus_link_open_t open;
    (void)self;
    return pus_link_open_read(reader, &open) == STATUS_OK;
}

static bool format_close(void* const self, octet_reader_t* const reader)
{
    pus_link_close_t close;
    (void)self;
    return pus_link_close_read(reader, &close) == STATUS_OK;
}

static pus_reply_t request_link(void* const self, pus_request_t* const request)
{
    const pus_rtlink_port_t* const port = &((const pus_rtlink_t*)self)->port;
    pus_link_request_t wanted;
    pus_link_answer_t answer = {0};
    if (pus_link_request_read(&request->reader, &wanted) != STATUS_OK) {
        return pus_refused(PUS_FAILURE_DATA, 0U);
    }
    const pus_reply_t reply =
        port->request(port->context, &wanted, &answer, &request->token, request->now_ns);
    if (reply.kind != PUS_DONE) {
        return reply;
    }
    pus_request_perform(request);
    if (answer.is_accepted) {
        answer.accept.transaction = wanted.transaction;
        (void)pus_link_accept_report(request->process, request->token.source, &answer.accept,
                                     request->now_ns);
        return pus_done();
    }
    answer.refuse.transaction = wanted.transaction;
    (void)pus_link_refuse_report(request->process, request->token.source, &answer.refuse, request->now_ns);
    return pus_failed(PUS_FAILURE_LINK_REFUSED, ((uint32_t)answer.refuse.reason << 8U) | answer.refuse.field);
}

static pus_reply_t open_link(void* const self, pus_request_t* const request)
{
    const pus_rtlink_port_t* const port = &((const pus_rtlink_t*)self)->port;
    pus_link_open_t open;
    if (pus_link_open_read(&request->reader, &open) != STATUS_OK) {
        return pus_refused(PUS_FAILURE_DATA, 0U);
    }
    return port->open(port->context, &open, &request->token, request->now_ns);
}

static pus_reply_t close_link(void* const self, pus_request_t* const request)
{
    const pus_rtlink_port_t* const port = &((const pus_rtlink_t*)self)->port;
    pus_link_close_t close;
    if (pus_link_close_read(&request->reader, &close) != STATUS_OK) {
        return pus_refused(PUS_FAILURE_DATA, 0U);
    }
    return port->close(port->context, &close, &request->token, request->now_ns);
}

pus_service_t pus_rtlink_service(pus_rtlink_t* const rtlink)
{
    static const pus_subtype_t subtypes[] = {
        {PUS_LINK_REPORT_OFFERS, format_filter, report_offers, NULL},
        {PUS_LINK_REQUEST, format_request, request_link, NULL},
        {PUS_LINK_OPEN, format_open, open_link, NULL},
        {PUS_LINK_CLOSE, format_close, close_link, NULL},
        {PUS_LINK_REPORT_STATUS, format_filter, report_status, NULL},
    };
    return pus_service_of(PUS_SERVICE_RTLINK, subtypes, sizeof subtypes / sizeof subtypes[0], rtlink);
}
