// SPDX-License-Identifier: Apache-2.0
#include "pus/core/list_report.h"

#include "base/assertion.h"

#include <string.h>

pus_list_target_t pus_list_answer(pus_request_t* const request, const uint8_t subtype)
{
    FSW_ASSERT(request != NULL);
    return (pus_list_target_t){.request     = request,
                               .process     = request->process,
                               .service     = request->token.service,
                               .subtype     = subtype,
                               .destination = request->token.source,
                               .now_ns      = request->now_ns};
}

static void begin_packet(pus_list_report_t* const list)
{
    const pus_list_target_t* const target = &list->target;
    list->writer =
        pus_tm_begin(target->process, target->service, target->subtype, target->destination, target->now_ns);
    octet_write_octets(&list->writer, list->prefix, list->prefix_size);
    // Not null, because a packet has room for it.
    list->head  = octet_write_space(&list->writer, sizeof(uint16_t));
    list->count = 0U;
}

static void end_packet(pus_list_report_t* const list)
{
    octets_put_u16(list->head, list->count);
    if (list->target.request != NULL) {
        pus_answer_send(list->target.request, &list->writer);
        list->lost = list->target.request->packets_lost;
    } else if (pus_tm_post(list->target.process, &list->writer) != STATUS_OK) {
        list->lost++;
    } else {
        // The packet was sent, or it is kept and sent later.
    }
}

void pus_list_report_begin(pus_list_report_t* const list, const pus_list_target_t* const target,
                           const uint8_t* const prefix, const size_t prefix_size)
{
    FSW_ASSERT((list != NULL) && (target != NULL) && (prefix_size <= PUS_LIST_PREFIX_MAX));
    FSW_ASSERT((prefix != NULL) || (prefix_size == 0U));
    *list = (pus_list_report_t){.target = *target, .prefix_size = (uint8_t)prefix_size};
    if (prefix != NULL) {
        (void)memcpy(list->prefix, prefix, prefix_size);
    }
    begin_packet(list);
}

octet_writer_t* pus_list_report_entry(pus_list_report_t* const list, const size_t size)
{
    FSW_ASSERT((list != NULL) && (size <= PUS_LIST_ENTRY_MAX));
    if (size > (list->writer.capacity - list->writer.position)) {
        end_packet(list);
        begin_packet(list);
    }
    list->count++;
    return &list->writer;
}

pus_reply_t pus_list_report_end(pus_list_report_t* const list)
{
    FSW_ASSERT(list != NULL);
    end_packet(list);
    if ((list->target.request != NULL) && list->target.request->is_unfinished) {
        return pus_started();
    }
    return (list->lost == 0U) ? pus_done() : pus_failed(PUS_FAILURE_SOME_FAILED, list->lost);
}
