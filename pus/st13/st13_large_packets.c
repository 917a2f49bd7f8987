// SPDX-License-Identifier: Apache-2.0
#include "pus/st13/st13_large_packets.h"

#include "base/assertion.h"
#include "generated/pus/st13_request_formats.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

enum {
    FIRST_DOWN  = 1,
    MIDDLE_DOWN = 2,
    LAST_UP     = 11,
    ABORTED     = 16
};

#define PART_NUMBER_OFFSET 2U // Offsets in the application data of a part [octets].
#define PART_OFFSET 4U
#define SOURCE_OFFSET 9U // Offsets in the assembled request [octets].
#define SERVICE_OFFSET 7U
#define LENGTH_OFFSET 4U
#define LENGTH_EXCESS 7U // Size of a packet minus the value of its length field [octets].
#define APID_MASK 0x7FFU

void pus_large_init(pus_large_t* const large, const pus_large_config_t* const config)
{
    FSW_ASSERT((large != NULL) && (config != NULL) && (config->process != NULL) && (config->take != NULL) &&
               (config->limit != NULL));
    FSW_ASSERT((config->reports != NULL) && (config->report_octets != NULL) && (config->report_count >= 1U));
    FSW_ASSERT((config->report_size >= PUS_PACKET_MAX) && (config->report_size <= PUS_LARGE_MAX));
    FSW_ASSERT((config->uplinks != NULL) && (config->uplink_octets != NULL) &&
               (config->uplink_size <= PUS_LARGE_MAX));
    *large = (pus_large_t){.config = *config};
    (void)memset(config->reports, 0, config->report_count * sizeof config->reports[0]);
    (void)memset(config->uplinks, 0, config->uplink_count * sizeof config->uplinks[0]);
}

// ---- Downlink ----

/// Returns the index of the buffer in which the next report is built.
static size_t free_report(const pus_large_t* const large)
{
    return (large->first_report + large->posted) % large->config.report_count;
}

static uint8_t* octets_of_report(const pus_large_t* const large, const size_t index)
{
    return &large->config.report_octets[index * large->config.report_size];
}

status_t pus_large_begin(pus_large_t* const large, const uint8_t service, const uint8_t subtype,
                         const uint16_t destination, const uint64_t now_ns, octet_writer_t* const out_writer)
{
    FSW_ASSERT((large != NULL) && (out_writer != NULL) && !large->is_building);
    if (large->posted >= large->config.report_count) {
        large->counters.refused++;
        return STATUS_FULL;
    }
    const size_t index                       = free_report(large);
    large->config.reports[index].destination = destination;
    large->is_building                       = true;
    *out_writer = pus_tm_begin_large(large->config.process, octets_of_report(large, index),
                                     large->config.report_size, service, subtype, destination, now_ns);
    return STATUS_OK;
}

status_t pus_large_post(pus_large_t* const large, octet_writer_t* const writer)
{
    FSW_ASSERT((large != NULL) && (writer != NULL) && large->is_building);
    large->is_building = false;
    if (!writer->failed && ((writer->position + PUS_CRC_SIZE) <= PUS_PACKET_MAX)) {
        return pus_tm_forward(large->config.process, writer->octets, writer->position + PUS_CRC_SIZE);
    }
    const size_t index               = free_report(large);
    pus_large_report_t* const report = &large->config.reports[index];
    const status_t status            = pus_tm_close_large(large->config.process, writer, &report->size);
    if (status == STATUS_OK) {
        report->transaction = large->transaction;
        report->sent        = 0U;
        large->transaction++;
        large->posted++;
    }
    return status;
}

/// Send the next part of the first report. False: the port cannot take it now.
static bool send_part(pus_large_t* const large, const uint64_t now_ns)
{
    pus_large_report_t* const report = &large->config.reports[large->first_report];
    const size_t left                = report->size - report->sent;
    const bool is_last               = left <= PUS_LARGE_PART;
    const size_t size                = is_last ? left : PUS_LARGE_PART;
    const uint8_t between            = (report->sent == 0U) ? FIRST_DOWN : MIDDLE_DOWN;
    octet_writer_t writer =
        pus_tm_begin(large->config.process, PUS_SERVICE_LARGE_PACKETS,
                     is_last ? PUS_LARGE_LAST_DOWN : between, report->destination, now_ns);
    octet_write_u16(&writer, report->transaction);
    octet_write_u16(&writer, (uint16_t)((report->sent / PUS_LARGE_PART) + 1U));
    octet_write_octets(&writer, &octets_of_report(large, large->first_report)[report->sent], size);
    if (pus_tm_send(large->config.process, &writer) != STATUS_OK) {
        return false;
    }
    report->sent += size;
    large->counters.parts++;
    if (is_last) {
        large->counters.reports++;
        large->posted--;
        large->first_report = (large->first_report + 1U) % large->config.report_count;
    }
    return true;
}

// ---- Uplink ----

static uint8_t* octets_of(const pus_large_t* const large, const pus_large_uplink_t* const uplink)
{
    return &large->config.uplink_octets[(size_t)(uplink - large->config.uplinks) * large->config.uplink_size];
}

static pus_reply_t refuse(pus_large_t* const large, const uint16_t code, const uint32_t detail)
{
    large->counters.refused++;
    return pus_refused(code, detail);
}

/// Abort an uplink, and report it to its sender.
static void give_up(pus_large_t* const large, pus_large_uplink_t* const uplink,
                    const pus_large_reason_t reason, const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(large->config.process, PUS_SERVICE_LARGE_PACKETS, ABORTED, uplink->token.source, now_ns);
    octet_write_u16(&writer, uplink->transaction);
    octet_write_u8(&writer, (uint8_t)reason);
    (void)pus_tm_post(large->config.process, &writer); // The process counts lost reports.
    uplink->is_used = false;
    large->counters.aborted++;
}

/// Find the uplink of a source and transaction or, with `is_free`, an unused uplink; null if there is none.
static pus_large_uplink_t* find_uplink(const pus_large_t* const large, const bool is_free,
                                       const uint16_t source, const uint16_t transaction)
{
    for (size_t i = 0U; i < large->config.uplink_count; i++) {
        pus_large_uplink_t* const uplink = &large->config.uplinks[i];
        const bool is_it                 = is_free
                                               ? !uplink->is_used
                                               : (uplink->is_used && !uplink->is_whole && (uplink->token.source == source) &&
                                  (uplink->transaction == transaction));
        if (is_it) {
            return uplink;
        }
    }
    return NULL;
}

/// Maximum size of the request that is being assembled. *out_size: its size according to its length field, 0
/// until the length field has arrived.
static size_t limit_of(const pus_large_t* const large, const pus_large_uplink_t* const uplink,
                       size_t* const out_size)
{
    const pus_large_config_t* const config = &large->config;
    const uint8_t* const octets            = octets_of(large, uplink);
    *out_size                              = 0U;
    if (uplink->size < PUS_PRIMARY_HEADER_SIZE) {
        return config->uplink_size;
    }
    *out_size          = (size_t)octets_u16_at(&octets[LENGTH_OFFSET]) + LENGTH_EXCESS;
    const size_t limit = config->limit(config->context, octets_u16_at(octets) & APID_MASK);
    return (limit < config->uplink_size) ? limit : config->uplink_size;
}

/// Append a part. PUS_DONE, or the refusal of the request; the uplink is then aborted.
static pus_reply_t append(pus_large_t* const large, pus_large_uplink_t* const uplink,
                          const pus_request_t* const request, const uint8_t* const part, const size_t size)
{
    if (size > (large->config.uplink_size - uplink->size)) {
        give_up(large, uplink, PUS_LARGE_NOT_ACCEPTED, request->now_ns);
        return refuse(large, PUS_FAILURE_TABLE_FULL, (uint32_t)large->config.uplink_size);
    }
    (void)memcpy(&octets_of(large, uplink)[uplink->size], part, size);
    uplink->size += size;
    uplink->next_part++;
    uplink->heard_ns   = request->now_ns;
    size_t whole_size  = 0U;
    const size_t limit = limit_of(large, uplink, &whole_size);
    if ((whole_size > limit) || (uplink->size > limit)) {
        give_up(large, uplink, PUS_LARGE_NOT_ACCEPTED, request->now_ns);
        return refuse(large, PUS_FAILURE_TABLE_FULL, (uint32_t)limit);
    }
    return pus_done();
}

static pus_reply_t take_first(void* const self, pus_request_t* const request)
{
    pus_large_t* const large   = self;
    const uint16_t transaction = octet_read_u16(&request->reader);
    const uint16_t number      = octet_read_u16(&request->reader);
    const size_t size          = octet_reader_left(&request->reader);
    if ((number != 1U) || (size == 0U)) {
        return refuse(large, PUS_FAILURE_OUT_OF_RANGE, (number != 1U) ? PART_NUMBER_OFFSET : PART_OFFSET);
    }
    pus_large_uplink_t* uplink = find_uplink(large, false, request->token.source, transaction);
    if (uplink != NULL) {
        give_up(large, uplink, PUS_LARGE_DISCONTINUITY, request->now_ns);
    }
    uplink = find_uplink(large, true, 0U, 0U);
    if (uplink == NULL) {
        return refuse(large, PUS_FAILURE_TABLE_FULL, (uint32_t)large->config.uplink_count);
    }
    *uplink = (pus_large_uplink_t){
        .is_used = true, .transaction = transaction, .next_part = 1U, .token = request->token};
    return append(large, uplink, request, octet_read_octets(&request->reader, size), size);
}

/// Check the assembled request. Returns the offset of the first field that is not acceptable from this
/// source; 0: all are acceptable.
static uint32_t fault_of(const pus_large_t* const large, const pus_large_uplink_t* const uplink)
{
    pus_tc_t tc;
    pus_failure_t failure;
    const uint8_t* const octets = octets_of(large, uplink);
    if (pus_tc_decode_large(octets, uplink->size, &tc, &failure) != STATUS_OK) {
        return (uint32_t)uplink->size;
    }
    if (tc.service == PUS_SERVICE_LARGE_PACKETS) {
        return SERVICE_OFFSET;
    }
    return (tc.source == uplink->token.source) ? 0U : SOURCE_OFFSET;
}

static pus_reply_t take_next(void* const self, pus_request_t* const request)
{
    pus_large_t* const large         = self;
    const uint16_t transaction       = octet_read_u16(&request->reader);
    const uint16_t number            = octet_read_u16(&request->reader);
    const size_t size                = octet_reader_left(&request->reader);
    pus_large_uplink_t* const uplink = find_uplink(large, false, request->token.source, transaction);
    if (uplink == NULL) {
        return refuse(large, PUS_FAILURE_UNKNOWN_ID, transaction);
    }
    if (number != uplink->next_part) {
        give_up(large, uplink, PUS_LARGE_DISCONTINUITY, request->now_ns);
        return refuse(large, PUS_FAILURE_OUT_OF_RANGE, PART_NUMBER_OFFSET);
    }
    if (size == 0U) {
        give_up(large, uplink, PUS_LARGE_NOT_ACCEPTED, request->now_ns);
        return refuse(large, PUS_FAILURE_OUT_OF_RANGE, PART_OFFSET);
    }
    const pus_reply_t reply = append(large, uplink, request, octet_read_octets(&request->reader, size), size);
    if ((reply.kind != PUS_DONE) || (request->token.subtype != LAST_UP)) {
        return reply;
    }
    const uint32_t fault = fault_of(large, uplink);
    if (fault != 0U) {
        give_up(large, uplink, PUS_LARGE_NOT_ACCEPTED, request->now_ns);
        return refuse(large, PUS_FAILURE_EMBEDDED, fault);
    }
    uplink->is_whole = true;
    uplink->token    = request->token;
    return pus_later();
}

static void step_uplink(pus_large_t* const large, pus_large_uplink_t* const uplink, const uint64_t now_ns)
{
    const pus_large_config_t* const config = &large->config;
    const bool is_taken = uplink->is_whole && (config->take(config->context, octets_of(large, uplink),
                                                            uplink->size, now_ns) == STATUS_OK);
    if (is_taken) {
        uplink->is_used = false;
        large->counters.requests++;
        pus_verify_completed(config->process, &uplink->token, now_ns);
    } else if ((now_ns - uplink->heard_ns) >= config->timeout_ns) {
        const pus_failure_t failure =
            pus_failure(PUS_FAILURE_TIMEOUT, (uint32_t)(config->timeout_ns / 1000000U));
        give_up(large, uplink, uplink->is_whole ? PUS_LARGE_NOT_ACCEPTED : PUS_LARGE_TIMEOUT, now_ns);
        if (uplink->is_whole) {
            pus_verify_failed(config->process, &uplink->token, &failure, now_ns);
        }
    } else {
        // The uplink waits for its next part, and has time left.
    }
}

// ---- The service ----

void pus_large_step(pus_large_t* const large, const uint64_t now_ns)
{
    FSW_ASSERT(large != NULL);
    bool is_taken = true;
    for (uint16_t i = 0U; is_taken && (large->posted > 0U) && (i < large->config.parts_per_step); i++) {
        is_taken = send_part(large, now_ns);
    }
    for (size_t i = 0U; i < large->config.uplink_count; i++) {
        if (large->config.uplinks[i].is_used) {
            step_uplink(large, &large->config.uplinks[i], now_ns);
        }
    }
}

bool pus_large_is_busy(const pus_large_t* const large)
{
    FSW_ASSERT(large != NULL);
    bool is_busy = large->posted > 0U;
    for (size_t i = 0U; i < large->config.uplink_count; i++) {
        is_busy = is_busy || (large->config.uplinks[i].is_used && large->config.uplinks[i].is_whole);
    }
    return is_busy;
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    (void)cycle;
    pus_large_step(self, now_ns);
}

static status_t begin_long(void* const context, const uint8_t service, const uint8_t subtype,
                           const uint16_t destination, const uint64_t now_ns,
                           octet_writer_t* const out_writer)
{
    return pus_large_begin(context, service, subtype, destination, now_ns, out_writer);
}

static status_t post_long(void* const context, octet_writer_t* const writer)
{
    return pus_large_post(context, writer);
}

pus_long_port_t pus_large_port(pus_large_t* const large)
{
    FSW_ASSERT(large != NULL);
    return (pus_long_port_t){.context  = large,
                             .data_max = large->config.report_size - PUS_TM_MIN,
                             .begin    = begin_long,
                             .post     = post_long};
}

pus_service_t pus_large_service(pus_large_t* const large)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(13, 9, take_first),
        PUS_REQUEST(13, 10, take_next),
        PUS_REQUEST(13, 11, take_next),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_LARGE_PACKETS, subtypes, sizeof subtypes / sizeof subtypes[0], large);
    service.step = step;
    return service;
}
