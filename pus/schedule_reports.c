// SPDX-License-Identifier: Apache-2.0
#include "pus/schedule_internal.h"

#include "pus/st01_verification.h"

enum {
    DETAIL_BY_IDS    = 9,
    DETAIL           = 10,
    DETAIL_BY_FILTER = 11,
    SUMMARY          = 13,
    DETAIL_OF_ALL    = 16
};

#define PACKETS_PER_CALL 4U // Of a report, so that a step stays short.

/// Write one entry. False: it does not fit, and the writer has failed.
static bool write_entry(pus_schedule_t* const schedule, const uint16_t slot, octet_writer_t* const writer)
{
    const pus_activity_t* const activity = &schedule->config.activities[slot];
    octet_write_u8(writer, activity->sub_schedule);
    octet_write_u8(writer, activity->group);
    schedule->kind->write_tag(writer, schedule->config.nodes[slot].tag);
    if (schedule->report.subtype == (uint8_t)DETAIL) {
        const size_t size = schedule_request(schedule, slot, schedule->record);
        octet_write_octets(writer, schedule->record, size);
    } else {
        octet_write_u16(writer, activity->id.source);
        octet_write_u16(writer, activity->id.apid);
        octet_write_u16(writer, activity->id.sequence);
    }
    return !writer->failed;
}

/// Fill a packet and send it. False: the port does not take it; nothing has changed.
static bool send_packet(pus_schedule_t* const schedule, pus_process_t* const process, const uint64_t now_ns)
{
    pus_schedule_report_t* const report = &schedule->report;
    octet_writer_t writer =
        pus_tm_begin(process, schedule->kind->service, report->subtype, report->token.source, now_ns);
    uint8_t* const count_place = octet_write_space(&writer, sizeof(uint16_t)); // It fits.
    octet_writer_t filled      = writer;                                       // As far as entries are whole.
    uint16_t count             = 0U;
    uint16_t slot              = schedule_select(schedule, &report->filter);
    while ((slot != NO_SLOT) && write_entry(schedule, slot, &writer)) {
        filled = writer;
        count++;
        slot = schedule_select_next(schedule, &report->filter, slot);
    }
    octets_put_u16(count_place, count);
    if (pus_tm_send(process, &filled) != STATUS_OK) {
        return false;
    }
    report->is_active = slot != NO_SLOT;
    if (slot != NO_SLOT) {
        report->filter.from   = schedule->config.nodes[slot].tag;
        report->filter.serial = schedule->config.nodes[slot].serial;
    }
    return true;
}

/// Send packets. True: all that there was to report is out.
static bool send_packets(pus_schedule_t* const schedule, pus_process_t* const process, const uint64_t now_ns)
{
    bool is_taken = true;
    for (unsigned i = 0U; (i < PACKETS_PER_CALL) && is_taken && schedule->report.is_active; i++) {
        is_taken = send_packet(schedule, process, now_ns);
    }
    return !schedule->report.is_active;
}

void schedule_report_go_on(pus_schedule_t* const schedule, const uint64_t now_ns)
{
    pus_process_t* const process              = schedule->config.process;
    const pus_schedule_report_t* const report = &schedule->report;
    if (send_packets(schedule, process, now_ns)) {
        const uint16_t code = (report->refused > 0U) ? PUS_FAILURE_SOME_FAILED : PUS_FAILURE_NONE;
        pus_verify_ended(process, &report->token, pus_failure(code, report->refused), now_ns);
    }
}

/// Which report a request asks for.
static uint8_t subtype_of(const pus_request_t* const request)
{
    const uint8_t asked = request->token.subtype;
    return ((asked == (uint8_t)DETAIL_BY_IDS) || (asked == (uint8_t)DETAIL_BY_FILTER) ||
            (asked == (uint8_t)DETAIL_OF_ALL))
               ? (uint8_t)DETAIL
               : (uint8_t)SUMMARY;
}

/// Begin a report, whose request has started.
static pus_reply_t begin(pus_schedule_t* const schedule, pus_request_t* const request,
                         const pus_schedule_filter_t* const filter, const uint16_t refused)
{
    schedule->report = (pus_schedule_report_t){.is_active = true,
                                               .subtype   = subtype_of(request),
                                               .refused   = refused,
                                               .token     = request->token,
                                               .filter    = *filter};
    return send_packets(schedule, request->process, request->now_ns) ? pus_done() : pus_started();
}

pus_reply_t pus_schedule_report_ids(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const uint8_t count            = octet_read_u8(&request->reader);
    pus_schedule_filter_t filter   = {.from = TAG_NEVER};
    uint16_t refused               = 0U;
    if (schedule->report.is_active) {
        return schedule_refuse(schedule, PUS_FAILURE_STATE, schedule->report.subtype);
    }
    schedule->report_number++;
    filter.report = schedule->report_number;
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_activity_id_t id = schedule_read_id(&request->reader);
        uint16_t slot              = schedule_find(schedule, &id);
        if (slot == NO_SLOT) {
            refused++;
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_UNKNOWN_ID, schedule_id_detail(&id));
        } else {
            pus_request_perform(request);
        }
        for (; slot != NO_SLOT; slot = schedule_find_next(schedule, slot)) {
            const uint64_t tag                       = schedule->config.nodes[slot].tag;
            schedule->config.activities[slot].report = filter.report;
            filter.from                              = (tag < filter.from) ? tag : filter.from;
            filter.to                                = (tag > filter.to) ? tag : filter.to;
        }
    }
    return (refused < count) ? begin(schedule, request, &filter, refused) : pus_done();
}

static pus_reply_t report_selected(pus_schedule_t* const schedule, pus_request_t* const request,
                                   const pus_schedule_filter_t* const filter)
{
    if (schedule->report.is_active) {
        return schedule_refuse(schedule, PUS_FAILURE_STATE, schedule->report.subtype);
    }
    pus_request_perform(request);
    return begin(schedule, request, filter, 0U);
}

pus_reply_t pus_schedule_report_filtered(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    pus_schedule_filter_t filter;
    const pus_reply_t reply = schedule_read_filter(schedule, &request->reader, &filter);
    return (reply.kind == PUS_DONE) ? report_selected(schedule, request, &filter) : reply;
}

pus_reply_t pus_schedule_report_all(void* const object, pus_request_t* const request)
{
    const pus_schedule_filter_t filter = schedule_filter_all();
    return report_selected(object, request, &filter);
}
