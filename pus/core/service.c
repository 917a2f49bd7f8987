// SPDX-License-Identifier: Apache-2.0
#include "pus/core/service.h"

#include "base/assertion.h"
#include "pus/core/request_format.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

#define REQUEST_ID_SIZE 4U // Octets of a packet that identify the request in a report.

pus_reply_t pus_done(void)
{
    return (pus_reply_t){.kind = PUS_DONE};
}

pus_reply_t pus_later(void)
{
    return (pus_reply_t){.kind = PUS_LATER};
}

pus_reply_t pus_started(void)
{
    return (pus_reply_t){.kind = PUS_STARTED};
}

pus_reply_t pus_refused(const uint16_t code, const uint32_t detail)
{
    return (pus_reply_t){.kind = PUS_REFUSED, .failure = pus_failure(code, detail)};
}

pus_reply_t pus_failed(const uint16_t code, const uint32_t detail)
{
    return (pus_reply_t){.kind = PUS_FAILED, .failure = pus_failure(code, detail)};
}

/// Send TM[1,3], if the request asks for it and it was not sent before.
static void start(pus_request_t* const request)
{
    if (!request->is_started) {
        request->is_started = true;
        pus_verify_started(request->process, &request->token, request->now_ns);
    }
}

void pus_request_perform(pus_request_t* const request)
{
    FSW_ASSERT(request != NULL);
    request->performed++;
    start(request);
}

void pus_request_refuse(pus_request_t* const request, const uint16_t instruction, const uint16_t code,
                        const uint32_t detail)
{
    FSW_ASSERT((request != NULL) && (instruction >= 1U));
    const pus_failure_t failure = {.code = code, .instruction = instruction, .detail = detail};
    request->refused++;
    if (request->is_resumed) {
        return; // An earlier execution of the request has reported this refusal.
    }
    if ((request->refused > 1U) && pus_app_process_is_waiting(request->process) &&
        !pus_app_process_has_firm_room(request->process)) {
        request->process->counters.lost++; // TM[1,8] of the request reports the number of refusals.
        return;
    }
    pus_verify_start_failed(request->process, &request->token, &failure, request->now_ns);
}

pus_service_t pus_service_of(const uint8_t type, const pus_subtype_t* const subtypes,
                             const size_t subtype_count, void* const self)
{
    FSW_ASSERT((subtypes != NULL) && (self != NULL));
    return (pus_service_t){
        .type = type, .subtype_count = (uint8_t)subtype_count, .subtypes = subtypes, .self = self};
}

void pus_answer_send(pus_request_t* const request, octet_writer_t* const writer)
{
    FSW_ASSERT((request != NULL) && (writer != NULL));
    request->packets++;
    if (request->is_unfinished || (request->packets <= request->packets_out)) {
        // An earlier packet waits, or an earlier execution has sent this packet.
        pus_tm_cancel(request->process);
        return;
    }
    const status_t status =
        request->may_resume ? pus_tm_send(request->process, writer) : pus_tm_post(request->process, writer);
    request->is_unfinished = request->may_resume && (status == STATUS_FULL);
    request->packets_lost =
        (uint16_t)(request->packets_lost + (((status == STATUS_OK) || request->is_unfinished) ? 0U : 1U));
    request->packets_out = (uint16_t)(request->packets_out + (request->is_unfinished ? 0U : 1U));
}

octet_writer_t pus_answer_begin(const pus_request_t* const request, const uint8_t subtype)
{
    return pus_tm_begin(request->process, request->token.service, subtype, request->token.source,
                        request->now_ns);
}

octet_writer_t pus_list_begin(const pus_request_t* const request, const uint8_t subtype)
{
    octet_writer_t writer = pus_answer_begin(request, subtype);
    (void)octet_write_space(&writer, sizeof(uint16_t));
    return writer;
}

pus_reply_t pus_list_end(const pus_request_t* const request, octet_writer_t* const writer,
                         const uint16_t count)
{
    octets_put_u16(&writer->octets[PUS_TM_HEADER_SIZE], count);
    const status_t status = pus_tm_post(request->process, writer);
    return (status == STATUS_TOO_LARGE) ? pus_failed(PUS_FAILURE_TABLE_FULL, PUS_TM_DATA_MAX) : pus_done();
}

bool pus_request_format_empty(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)reader;
    return true;
}

bool pus_request_format_u8(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)octet_read_u8(reader);
    return true;
}

bool pus_request_format_u16(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)octet_read_u16(reader);
    return true;
}

void pus_dispatcher_init(pus_dispatcher_t* const dispatcher, pus_app_process_t* const process,
                         const pus_service_t* const services, const size_t service_count)
{
    FSW_ASSERT((dispatcher != NULL) && (process != NULL) && (services != NULL));
    *dispatcher =
        (pus_dispatcher_t){.process = process, .services = services, .service_count = service_count};
}

void pus_dispatcher_defer(pus_dispatcher_t* const dispatcher, const pus_performer_t* const performer)
{
    FSW_ASSERT((dispatcher != NULL) && (performer != NULL) && (performer->take != NULL));
    dispatcher->performer = *performer;
}

void pus_dispatcher_persist(pus_dispatcher_t* const dispatcher, const pus_persistence_t* const persistence)
{
    FSW_ASSERT((dispatcher != NULL) && (persistence != NULL));
    dispatcher->persistence = persistence;
}

static const pus_subtype_t* subtype_of(const pus_service_t* const service, const uint8_t number)
{
    for (size_t i = 0U; i < service->subtype_count; i++) {
        if (service->subtypes[i].subtype == number) {
            return &service->subtypes[i];
        }
    }
    return NULL;
}

/// pus_tc_decode, or its variant for requests longer than a packet.
typedef status_t (*decode_t)(const uint8_t* octets, size_t size, pus_tc_t* out_tc,
                             pus_failure_t* out_failure);

/// Decode a packet, find its service and subtype, and check its format. The code of the failure is
/// PUS_FAILURE_NONE if no check failed; otherwise *out_tc has the header fields that identify the packet.
static pus_failure_t find(const pus_dispatcher_t* const dispatcher, const uint8_t* const packet,
                          const size_t size, const decode_t decode, pus_tc_t* const out_tc,
                          const pus_service_t** const out_service, const pus_subtype_t** const out_subtype)
{
    pus_failure_t failure = {0};
    if (decode(packet, size, out_tc, &failure) != STATUS_OK) {
        return failure;
    }
    if (out_tc->apid != dispatcher->process->apid) {
        return pus_failure(PUS_FAILURE_APID, out_tc->apid);
    }
    const pus_service_t* service   = dispatcher->services;
    const pus_service_t* const end = &dispatcher->services[dispatcher->service_count];
    while ((service < end) && (service->type != out_tc->service)) {
        service++;
    }
    if (service >= end) {
        return pus_failure(PUS_FAILURE_SERVICE, out_tc->service);
    }
    const pus_subtype_t* const subtype = subtype_of(service, out_tc->subtype);
    if (subtype == NULL) {
        return pus_failure(PUS_FAILURE_SUBTYPE, ((uint32_t)out_tc->service << 8U) | out_tc->subtype);
    }
    octet_reader_t reader = octet_reader(out_tc->data, out_tc->size);
    const bool has_format = (subtype->has_format != NULL)
                                ? subtype->has_format(service->self, &reader)
                                : pus_request_format_check(subtype->format, &reader);
    if (!has_format || !octet_reader_is_done(&reader)) {
        return pus_failure(PUS_FAILURE_DATA, (uint32_t)reader.position);
    }
    *out_service = service;
    *out_subtype = subtype;
    return failure;
}

/// Report the completion of a request that has been performed.
static void complete(pus_request_t* const request)
{
    if (request->refused == 0U) {
        start(request);
        pus_verify_completed(request->process, &request->token, request->now_ns);
    } else if (request->performed > 0U) {
        const pus_failure_t failure = pus_failure(PUS_FAILURE_SOME_FAILED, request->refused);
        pus_verify_failed(request->process, &request->token, &failure, request->now_ns);
    } else {
        // Each instruction was refused with its own TM[1,4], so no execution has started or ended.
    }
}

/// Send the verification reports for the reply of a service.
static void report_reply(pus_request_t* const request, const pus_reply_t* const reply)
{
    switch (reply->kind) {
    case PUS_DONE:
        complete(request);
        break;
    case PUS_LATER:
        start(request);
        break;
    case PUS_STARTED:
        break;
    case PUS_REFUSED:
        pus_verify_start_failed(request->process, &request->token, &reply->failure, request->now_ns);
        break;
    case PUS_FAILED:
    default:
        start(request);
        pus_verify_failed(request->process, &request->token, &reply->failure, request->now_ns);
        break;
    }
}

/// Execute a request and send its verification.
static pus_reply_kind_t execute(pus_request_t* const request, const pus_service_t* const service,
                                const pus_subtype_t* const subtype, const uint8_t* const data,
                                const size_t size, const pus_persistence_t* const persistence)
{
    request->reader       = octet_reader(data, size);
    pus_reply_t reply     = subtype->execute(service->self, request);
    const status_t status = (persistence != NULL) ? persistence->commit(persistence->context) : STATUS_OK;
    // A failed commit ends only a request that was performed now. A request that continues reports its own
    // end, and a refused one has already been reported.
    const bool is_performed =
        (reply.kind == PUS_DONE) && ((request->performed > 0U) || (request->refused == 0U));
    if (request->is_unfinished) {
        start(request);
        reply = pus_started();
    } else if ((status != STATUS_OK) && is_performed) {
        reply = pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    } else if ((request->packets_lost > 0U) && (reply.kind == PUS_DONE)) {
        reply = pus_failed(PUS_FAILURE_SOME_FAILED, request->packets_lost);
    } else {
        // Report the reply of the service unchanged.
    }
    report_reply(request, &reply);
    return reply.kind;
}

void pus_perform(pus_app_process_t* const process, const pus_service_t* const service,
                 const pus_token_t* const token, const uint8_t* const data, const size_t size,
                 const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (service != NULL) && (token != NULL));
    const pus_subtype_t* const subtype = subtype_of(service, token->subtype);
    FSW_ASSERT((subtype != NULL) && (service->type == token->service));
    pus_request_t request = {.token = *token, .now_ns = now_ns, .process = process};
    (void)execute(&request, service, subtype, data, size, NULL);
}

/// Keep a request whose answer is not completely sent, so that it can be executed again.
static void put_off(pus_unfinished_t* const unfinished, const pus_request_t* const request,
                    const pus_service_t* const service, const pus_subtype_t* const subtype,
                    const pus_tc_t* const tc)
{
    unfinished->service      = service;
    unfinished->subtype      = subtype;
    unfinished->token        = request->token;
    unfinished->packets_out  = request->packets_out;
    unfinished->packets_lost = request->packets_lost;
    unfinished->size         = (uint16_t)tc->size;
    if (tc->size > 0U) {
        (void)memcpy(unfinished->data, tc->data, tc->size);
    }
}

bool pus_dispatcher_is_answering(const pus_dispatcher_t* const dispatcher)
{
    FSW_ASSERT(dispatcher != NULL);
    return dispatcher->unfinished.service != NULL;
}

bool pus_dispatcher_resume(pus_dispatcher_t* const dispatcher, const uint64_t now_ns)
{
    FSW_ASSERT(dispatcher != NULL);
    pus_unfinished_t* const unfinished = &dispatcher->unfinished;
    const status_t status              = pus_app_process_flush(dispatcher->process);
    if ((unfinished->service == NULL) || (status != STATUS_OK)) {
        // The reports that are kept must be sent before the answer continues.
        return unfinished->service != NULL;
    }
    pus_request_t request = {.token        = unfinished->token,
                             .now_ns       = now_ns,
                             .process      = dispatcher->process,
                             .is_started   = true,
                             .may_resume   = true,
                             .is_resumed   = true,
                             .packets_out  = unfinished->packets_out,
                             .packets_lost = unfinished->packets_lost};
    (void)execute(&request, unfinished->service, unfinished->subtype, unfinished->data, unfinished->size,
                  NULL);
    unfinished->packets_out  = request.packets_out;
    unfinished->packets_lost = request.packets_lost;
    unfinished->service      = request.is_unfinished ? unfinished->service : NULL;
    return request.is_unfinished;
}

static status_t dispatch(pus_dispatcher_t* const dispatcher, const uint8_t* const packet, const size_t size,
                         const decode_t decode, const uint64_t now_ns)
{
    FSW_ASSERT((dispatcher != NULL) && ((packet != NULL) || (size == 0U)));
    if (size < REQUEST_ID_SIZE) {
        dispatcher->counters.ignored++;
        return STATUS_TRUNCATED;
    }
    pus_tc_t tc                  = {0};
    const pus_service_t* service = NULL;
    const pus_subtype_t* subtype = NULL;
    const pus_failure_t failure  = find(dispatcher, packet, size, decode, &tc, &service, &subtype);
    pus_request_t request        = {.token      = pus_token_of(&tc),
                                    .now_ns     = now_ns,
                                    .process    = dispatcher->process,
                                    .may_resume = (tc.size <= PUS_RESUMED_DATA_MAX) &&
                                                  (dispatcher->unfinished.service == NULL)};
    if (failure.code != PUS_FAILURE_NONE) {
        dispatcher->counters.rejected++;
        pus_verify_rejected(request.process, &request.token, &failure, now_ns);
        return STATUS_INVALID;
    }
    // If no check has failed, service and subtype were found.
    FSW_ASSERT((service != NULL) && (subtype != NULL));
    dispatcher->counters.accepted++;
    pus_verify_accepted(request.process, &request.token, now_ns);
    const pus_performer_t* const performer = &dispatcher->performer;
    pus_reply_t reply                      = pus_done();
    if (performer->take != NULL) {
        reply = performer->take(performer->context, &request.token, tc.data, tc.size);
    }
    if (reply.kind == PUS_DONE) {
        reply.kind = execute(&request, service, subtype, tc.data, tc.size, dispatcher->persistence);
        if (request.is_unfinished) {
            put_off(&dispatcher->unfinished, &request, service, subtype, &tc);
        }
    } else {
        report_reply(&request, &reply);
    }
    dispatcher->counters.refused += (reply.kind == PUS_REFUSED) ? 1U : 0U;
    return STATUS_OK;
}

status_t pus_dispatch(pus_dispatcher_t* const dispatcher, const uint8_t* const packet, const size_t size,
                      const uint64_t now_ns)
{
    return dispatch(dispatcher, packet, size, pus_tc_decode, now_ns);
}

status_t pus_dispatch_large(pus_dispatcher_t* const dispatcher, const uint8_t* const packet,
                            const size_t size, const uint64_t now_ns)
{
    return dispatch(dispatcher, packet, size, pus_tc_decode_large, now_ns);
}
