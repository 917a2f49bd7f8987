// SPDX-License-Identifier: Apache-2.0
#include "pus/core/long_report.h"

#include "base/assertion.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

/// Fill a packet and send it. False: the port has refused the packet, and the report has not changed.
static bool send_packet(pus_long_report_t* const report, pus_app_process_t* const process,
                        const pus_report_entries_t* const entries, const uint64_t now_ns)
{
    const pus_report_cursor_t begin = report->cursor;
    octet_writer_t writer =
        pus_tm_begin(process, report->token.service, report->subtype, report->token.source, now_ns);
    octet_write_octets(&writer, report->front, report->front_size);
    // Not null, because a packet has room for it.
    uint8_t* const count_field = octet_write_space(&writer, sizeof(uint16_t));
    octet_writer_t whole       = writer; // The packet up to its last complete entry.
    pus_report_cursor_t next   = begin;
    uint16_t count             = 0U;
    bool has_more              = entries->write(entries->self, &next, &writer);
    while (has_more && !writer.failed) {
        whole          = writer;
        report->cursor = next;
        count++;
        has_more = entries->write(entries->self, &next, &writer);
    }
    octets_put_u16(count_field, count);
    if (pus_tm_send(process, &whole) != STATUS_OK) {
        report->cursor = begin;
        return false;
    }
    report->is_active = has_more;
    return true;
}

static void send_packets(pus_long_report_t* const report, pus_app_process_t* const process,
                         const pus_report_entries_t* const entries, const uint64_t now_ns)
{
    bool is_taken = true;
    for (unsigned i = 0U; (i < PUS_LONG_REPORT_PACKETS) && is_taken && report->is_active; i++) {
        is_taken = send_packet(report, process, entries, now_ns);
    }
}

pus_reply_t pus_long_report_begin(pus_long_report_t* const report, pus_request_t* const request,
                                  const uint8_t subtype, const pus_report_entries_t* const entries,
                                  const pus_report_cursor_t* const cursor, const uint8_t* const front,
                                  const size_t front_size)
{
    FSW_ASSERT((report != NULL) && (request != NULL) && (entries != NULL) && (cursor != NULL) &&
               (front_size <= PUS_LONG_REPORT_FRONT));
    *report = (pus_long_report_t){.is_active  = true,
                                  .subtype    = subtype,
                                  .front_size = (uint8_t)front_size,
                                  .refused    = request->refused,
                                  .token      = request->token,
                                  .cursor     = *cursor};
    if (front_size > 0U) {
        (void)memcpy(report->front, front, front_size);
    }
    pus_request_perform(request);
    send_packets(report, request->process, entries, request->now_ns);
    return report->is_active ? pus_started() : pus_done();
}

void pus_long_report_go_on(pus_long_report_t* const report, pus_app_process_t* const process,
                           const pus_report_entries_t* const entries, const uint64_t now_ns)
{
    FSW_ASSERT((report != NULL) && report->is_active && (process != NULL) && (entries != NULL));
    send_packets(report, process, entries, now_ns);
    if (!report->is_active) {
        const uint16_t code = (report->refused > 0U) ? PUS_FAILURE_SOME_FAILED : PUS_FAILURE_NONE;
        pus_verify_ended(process, &report->token, pus_failure(code, report->refused), now_ns);
    }
}
