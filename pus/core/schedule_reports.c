// SPDX-License-Identifier: Apache-2.0
#include "pus/core/schedule_internal.h"

enum {
    DETAIL_BY_IDS    = 9,
    DETAIL           = 10,
    DETAIL_BY_FILTER = 11,
    SUMMARY          = 13,
    DETAIL_OF_ALL    = 16
};

/// Write the first entry at or after the cursor (tag, serial).
static bool write_entry(void* const object, pus_report_cursor_t* const cursor, octet_writer_t* const writer)
{
    pus_schedule_t* const schedule      = object;
    pus_schedule_filter_t* const filter = &schedule->report_filter;
    filter->from                        = cursor->first;
    filter->serial                      = cursor->second;
    const uint16_t slot                 = schedule_select(schedule, filter);
    if (slot == NO_SLOT) {
        return false;
    }
    const pus_activity_t* const activity      = &schedule->config.activities[slot];
    const pus_sorted_index_node_t* const node = &schedule->config.nodes[slot];
    octet_write_u8(writer, activity->sub_schedule);
    octet_write_u8(writer, activity->group);
    schedule->kind->write_tag(writer, node->tag);
    if (schedule->report.subtype == (uint8_t)DETAIL) {
        const size_t size = schedule_request(schedule, slot, schedule->record);
        octet_write_octets(writer, schedule->record, size);
    } else {
        octet_write_u16(writer, activity->id.source);
        octet_write_u16(writer, activity->id.apid);
        octet_write_u16(writer, activity->id.sequence);
    }
    cursor->first  = node->tag;
    cursor->second = node->serial + 1U;
    return true;
}

static pus_report_entries_t entries_of(pus_schedule_t* const schedule)
{
    return (pus_report_entries_t){.self = schedule, .write = write_entry};
}

void schedule_report_go_on(pus_schedule_t* const schedule, const uint64_t now_ns)
{
    const pus_report_entries_t entries = entries_of(schedule);
    pus_long_report_go_on(&schedule->report, schedule->config.process, &entries, now_ns);
}

/// Subtype of the report that answers a request.
static uint8_t subtype_of(const pus_request_t* const request)
{
    const uint8_t asked = request->token.subtype;
    return ((asked == (uint8_t)DETAIL_BY_IDS) || (asked == (uint8_t)DETAIL_BY_FILTER) ||
            (asked == (uint8_t)DETAIL_OF_ALL))
               ? (uint8_t)DETAIL
               : (uint8_t)SUMMARY;
}

static pus_reply_t begin(pus_schedule_t* const schedule, pus_request_t* const request,
                         const pus_schedule_filter_t* const filter)
{
    const pus_report_entries_t entries = entries_of(schedule);
    const pus_report_cursor_t cursor   = {.first = filter->from, .second = filter->serial};
    schedule->report_filter            = *filter;
    return pus_long_report_begin(&schedule->report, request, subtype_of(request), &entries, &cursor, NULL,
                                 0U);
}

pus_reply_t pus_schedule_report_ids(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const uint8_t count            = octet_read_u8(&request->reader);
    pus_schedule_filter_t filter   = {.from = TAG_NEVER};
    if (schedule->report.is_active) {
        return schedule_refuse(schedule, PUS_FAILURE_STATE, schedule->report.subtype);
    }
    schedule->report_number++;
    filter.report = schedule->report_number;
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_activity_id_t id = schedule_read_id(&request->reader);
        uint16_t slot              = schedule_find(schedule, &id);
        if (slot == NO_SLOT) {
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
    return (request->performed > 0U) ? begin(schedule, request, &filter) : pus_done();
}

static pus_reply_t report_selected(pus_schedule_t* const schedule, pus_request_t* const request,
                                   const pus_schedule_filter_t* const filter)
{
    if (schedule->report.is_active) {
        return schedule_refuse(schedule, PUS_FAILURE_STATE, schedule->report.subtype);
    }
    return begin(schedule, request, filter);
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
