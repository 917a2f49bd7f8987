// SPDX-License-Identifier: Apache-2.0
// The subsystem's side of real-time links: offers, negotiation, opening, and monitoring of freshness.
#include "fsw/framework/subsystem/subsystem_internal.h"

#include "base/assertion.h"

#include <string.h>

#define METHOD_ANY 0xFFU                 ///< Requested method: any that both ends offer.
#define ACCEPT_DEADLINE_NS 5000000000ULL ///< An accepted link that is not opened in time is closed.

// ---- Terms ----

/// Returns the methods for one link of the port, or for any of its links (link 0).
static uint8_t methods_of(const subsystem_t* const subsystem, const descriptor_port_t* const port,
                          const uint16_t link)
{
    uint8_t methods = 0U;
    for (uint8_t i = 0U; i < port->method_count; i++) {
        if (port->methods[i] < (uint8_t)RTLINK_METHOD_COUNT) {
            methods |= (uint8_t)(1U << port->methods[i]);
        }
    }
    const rtlink_resolver_t* const links = subsystem->config.links;
    const bool is_limited                = (links != NULL) && (links->methods != NULL);
    const uint8_t reaching = is_limited ? links->methods(links->context, port->id, link) : 0xFFU;
    return (uint8_t)(methods & subsystem->config.link_methods & reaching);
}

/// Write the terms that this subsystem offers for a port.
static void describe_port(const subsystem_t* const subsystem, const descriptor_port_t* const port,
                          const uint16_t link, rtlink_terms_t* const out_terms)
{
    out_terms->layout_hash   = port->layout_hash;
    out_terms->layout_octets = port->octets;
    out_terms->order         = (uint8_t)rtlink_native_order();
    out_terms->period_us     = port->period_us;
    out_terms->methods       = methods_of(subsystem, port, link);
    out_terms->decimation    = 1U;
    out_terms->max_age_us    = port->stale_us;
}

/// Returns the number of the lowest method in a set.
static uint8_t method_number(const uint8_t methods)
{
    uint8_t number = 0U;
    while ((number < (uint8_t)RTLINK_METHOD_COUNT) && ((methods & (1U << number)) == 0U)) {
        number++;
    }
    return number;
}

static void write_properties(const rtlink_terms_t* const terms, pus_link_properties_t* const out_properties)
{
    out_properties->layout_hash        = terms->layout_hash;
    out_properties->layout_size        = terms->layout_octets;
    out_properties->byte_order         = terms->order;
    out_properties->period_us          = terms->period_us;
    out_properties->tolerance_permille = 0U;
    out_properties->method             = method_number(terms->methods);
    out_properties->depth              = 1U;
    out_properties->age_max_us         = terms->max_age_us;
}

static void read_terms(const pus_link_properties_t* const properties, rtlink_terms_t* const out_terms)
{
    out_terms->layout_hash   = properties->layout_hash;
    out_terms->layout_octets = properties->layout_size;
    out_terms->order         = properties->byte_order;
    out_terms->period_us     = properties->period_us;
    out_terms->decimation    = 1U;
    out_terms->max_age_us    = properties->age_max_us;
    out_terms->methods       = 0U; // With an unknown method the set stays empty.
    if (properties->method == METHOD_ANY) {
        out_terms->methods = 0xFFU;
    } else if (properties->method < (uint8_t)RTLINK_METHOD_COUNT) {
        out_terms->methods = (uint8_t)(1U << properties->method);
    }
}

// ---- States ----

static void change_state(subsystem_t* const subsystem, subsystem_link_t* const link,
                         const rtlink_state_t state, const uint8_t cause)
{
    const pus_link_transition_t report = {.link     = link->link,
                                          .previous = (uint8_t)link->state,
                                          .state    = (uint8_t)state,
                                          .cause    = cause,
                                          .time_ns  = subsystem->now_ns};
    link->state                        = state;
    (void)pus_link_transition_report(&subsystem->process, &report, subsystem->now_ns);
}

static void add_counters(subsystem_link_totals_t* const totals, const subsystem_link_t* const link)
{
    if (link->is_used && !link->is_producer) {
        totals->received += link->consumer.counters.frames;
        totals->lost += link->consumer.counters.lost;
        totals->late += link->consumer.counters.late;
        totals->refused += link->consumer.counters.refused + link->consumer.counters.torn;
    }
}

static void close_channel(subsystem_link_t* const link)
{
    if (link->is_producer) {
        rtlink_producer_close(&link->producer);
    } else {
        rtlink_consumer_close(&link->consumer);
    }
}

static void close_link(subsystem_t* const subsystem, subsystem_link_t* const link, const uint8_t reason)
{
    add_counters(&subsystem->closed_links, link);
    close_channel(link);
    change_state(subsystem, link, LINK_CLOSED, reason);
    link->is_used = false;
}

void subsystem_close_links(subsystem_t* const subsystem, const uint8_t reason)
{
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        if (subsystem->links[i].is_used) {
            close_link(subsystem, &subsystem->links[i], reason);
        }
    }
}

void subsystem_release(subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        if (subsystem->links[i].is_used) {
            close_channel(&subsystem->links[i]);
        }
    }
    if (subsystem->config.callbacks->release != NULL) {
        subsystem->config.callbacks->release(subsystem->config.self);
    }
}

// ---- Port of service 130 ----

static bool offer_link(void* const context, const uint16_t index, pus_link_offer_t* const out_offer)
{
    const subsystem_t* const subsystem                    = (const subsystem_t*)context;
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    uint16_t left                                         = index;
    if (configuration == NULL) {
        return false;
    }
    for (uint16_t i = 0U; i < configuration->port_count; i++) {
        const descriptor_port_t* const port = &subsystem->descriptor->ports[configuration->first_port + i];
        rtlink_terms_t terms;
        describe_port(subsystem, port, 0U, &terms);
        // Each method is a separate offer.
        for (unsigned rest = terms.methods; rest != 0U; rest &= rest - 1U) {
            if (left == 0U) {
                terms.methods   = (uint8_t)(rest & (0U - rest));
                out_offer->port = port->id;
                out_offer->role = (uint8_t)(port->is_provided ? PUS_LINK_PRODUCER : PUS_LINK_CONSUMER);
                write_properties(&terms, &out_offer->properties);
                return true;
            }
            left--;
        }
    }
    return false;
}

static pus_link_field_t field_of(const rtlink_verdict_t verdict)
{
    switch (verdict) {
    case RTLINK_REFUSED_LAYOUT:
        return PUS_LINK_FIELD_LAYOUT_HASH;
    case RTLINK_REFUSED_ORDER:
        return PUS_LINK_FIELD_BYTE_ORDER;
    case RTLINK_REFUSED_PERIOD:
        return PUS_LINK_FIELD_PERIOD;
    case RTLINK_REFUSED_METHOD:
        return PUS_LINK_FIELD_METHOD;
    case RTLINK_REFUSED_PORT:
        return PUS_LINK_FIELD_PORT;
    default:
        return PUS_LINK_FIELD_NONE;
    }
}

static void refuse(pus_link_answer_t* const answer, const rtlink_verdict_t verdict,
                   const rtlink_terms_t* const terms)
{
    answer->is_accepted   = false;
    answer->refuse.reason = (uint8_t)verdict;
    answer->refuse.field  = (uint8_t)field_of(verdict);
    write_properties(terms, &answer->refuse.supported);
}

/// Write the logical name of the endpoint. No packet contains a real address, so that packets do not depend
/// on where the program runs.
static void name_endpoint(const uint8_t methods, const uint16_t link, pus_endpoint_t* const out_endpoint)
{
    (void)memset(out_endpoint, 0, sizeof *out_endpoint);
    out_endpoint->kind = method_number(methods);
    out_endpoint->size = 7U;
    (void)memcpy(out_endpoint->octets, "link-", 5U);
    out_endpoint->octets[5] = (uint8_t)('0' + ((link / 10U) % 10U));
    out_endpoint->octets[6] = (uint8_t)('0' + (link % 10U));
}

static const descriptor_port_t* port_of_request(const subsystem_t* const subsystem,
                                                const pus_link_request_t* const request,
                                                bool* const out_is_producer)
{
    *out_is_producer    = (request->ends.producer_apid == subsystem->descriptor->apid);
    const bool is_ours  = *out_is_producer || (request->ends.consumer_apid == subsystem->descriptor->apid);
    const uint16_t port = *out_is_producer ? request->ends.producer_port : request->ends.consumer_port;
    if (!is_ours) {
        return NULL;
    }
    const descriptor_port_t* const found =
        descriptor_find_port(subsystem->descriptor, subsystem->configuration, port);
    return ((found != NULL) && (found->is_provided == *out_is_producer)) ? found : NULL;
}

/// Accept a request. `link` has been cleared except for the agreed terms.
static void accept_request(subsystem_t* const subsystem, subsystem_link_t* const link,
                           const pus_link_request_t* const request, pus_link_answer_t* const answer)
{
    link->is_used       = true;
    link->link          = request->link;
    link->ends          = request->ends;
    link->accepted_ns   = subsystem->now_ns;
    answer->is_accepted = true;
    answer->accept.link = request->link;
    write_properties(&link->terms, &answer->accept.properties);
    name_endpoint(link->terms.methods, request->link, &answer->accept.endpoint);
    change_state(subsystem, link, LINK_ACCEPTED, PUS_LINK_REASON_NONE);
}

static pus_reply_t request_link(void* const context, const pus_link_request_t* const request,
                                pus_link_answer_t* const out_answer, const pus_token_t* const token,
                                const uint64_t now_ns)
{
    (void)token;
    subsystem_t* const subsystem  = (subsystem_t*)context;
    subsystem->now_ns             = now_ns;
    bool is_producer              = false;
    const descriptor_port_t* port = NULL;
    subsystem_link_t* link        = NULL;
    rtlink_verdict_t verdict      = RTLINK_REFUSED_STATE;
    rtlink_terms_t own;
    rtlink_terms_t agreed = {.methods = 0U};
    rtlink_terms_t wanted;
    read_terms(&request->properties, &wanted);
    const rtlink_terms_t* supported = &wanted; // Terms in the answer if there is no such port.
    if ((subsystem->machine.phase == PHASE_CONFIGURED) && (subsystem->config.links != NULL)) {
        port    = port_of_request(subsystem, request, &is_producer);
        verdict = RTLINK_REFUSED_PORT;
    }
    if (port != NULL) {
        describe_port(subsystem, port, request->link, &own);
        supported = &own;
        verdict   = rtlink_negotiate(is_producer ? &own : &wanted, is_producer ? &wanted : &own, &agreed);
        link      = subsystem_link_slot(subsystem, port, request->link);
    }
    if ((verdict == RTLINK_ACCEPTED) && ((link == NULL) || (request->link == 0U))) {
        verdict = RTLINK_REFUSED_RESOURCE;
    }
    if (verdict != RTLINK_ACCEPTED) {
        refuse(out_answer, verdict, supported);
    } else {
        if (link->is_used) {
            close_link(subsystem, link, PUS_LINK_REASON_NONE);
        }
        (void)memset(link, 0, sizeof *link); // The state becomes LINK_CLOSED.
        link->is_producer = is_producer;
        link->port        = port;
        link->terms       = agreed;
        accept_request(subsystem, link, request, out_answer);
    }
    return pus_done();
}

/// Open this end of an accepted link, with the epoch that both ends get from the manager.
static pus_reply_t open_link(void* const context, const pus_link_open_t* const open,
                             const pus_token_t* const token, const uint64_t now_ns)
{
    (void)token;
    subsystem_t* const subsystem = (subsystem_t*)context;
    subsystem->now_ns            = now_ns;
    subsystem_link_t* const link = subsystem_link_numbered(subsystem, open->link);
    if (link == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, open->link);
    }
    if (link->state != LINK_ACCEPTED) {
        return pus_refused(PUS_FAILURE_STATE, open->link);
    }
    const rtlink_resolver_t* const resolver = subsystem->config.links;
    const status_t status =
        link->is_producer
            ? rtlink_producer_open(&link->producer, resolver, link->link, &link->terms, open->epoch)
            : rtlink_consumer_open(&link->consumer, resolver, link->link, &link->terms, open->epoch);
    if (status != STATUS_OK) {
        change_state(subsystem, link, LINK_FAILED, PUS_LINK_REASON_RESOURCE);
        link->is_used = false;
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    link->opened_ns = subsystem->now_ns;
    change_state(subsystem, link, LINK_OPEN, PUS_LINK_REASON_NONE);
    return pus_done();
}

/// Raise the event of a required link of a consumer that is closed or stale. In OPERATIONAL it is an error.
/// In lower states only a closed link raises an event, without a reaction (docs/states.md).
static void report_lost(subsystem_t* const subsystem, const bool is_closed)
{
    const state_t state = subsystem->machine.state;
    if (state == STATE_OPERATIONAL) {
        subsystem_raise_named(subsystem, "LINK_STALE");
    } else if (is_closed && ((state == STATE_SAFE_OPERATIONAL) || (state == STATE_PRE_OPERATIONAL))) {
        subsystem_raise_named(subsystem, "LINK_CLOSED");
    } else {
        // The link may become fresh again, or the subsystem is already in error or on the way down.
    }
}

static pus_reply_t close_requested(void* const context, const pus_link_close_t* const close,
                                   const pus_token_t* const token, const uint64_t now_ns)
{
    (void)token;
    subsystem_t* const subsystem = (subsystem_t*)context;
    subsystem->now_ns            = now_ns;
    subsystem_link_t* const link = subsystem_link_numbered(subsystem, close->link);
    if (link == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, close->link);
    }
    const bool was_needed = !link->is_producer && link->port->is_required;
    close_link(subsystem, link, close->reason);
    if (was_needed) {
        report_lost(subsystem, true);
    }
    return pus_done();
}

static bool link_status(void* const context, const uint16_t index, pus_link_status_t* const out_status)
{
    const subsystem_t* const subsystem = (const subsystem_t*)context;
    uint16_t used                      = 0U;
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        const subsystem_link_t* const link = &subsystem->links[i];
        used                               = (uint16_t)(used + (link->is_used ? 1U : 0U));
        if (used > index) {
            const bool is_producer = link->is_producer;
            const rtlink_counters_t* const counters =
                is_producer ? &link->producer.counters : &link->consumer.counters;
            out_status->link          = link->link;
            out_status->state         = (uint8_t)link->state;
            out_status->ends          = link->ends;
            out_status->sent          = is_producer ? counters->frames : 0U;
            out_status->received      = is_producer ? 0U : counters->frames;
            out_status->lost          = counters->lost;
            out_status->late          = counters->late;
            out_status->last_sequence = counters->last_sequence;
            write_properties(&link->terms, &out_status->properties);
            return true;
        }
    }
    return false;
}

pus_rtlink_port_t subsystem_link_port(subsystem_t* const subsystem)
{
    return (pus_rtlink_port_t){subsystem, offer_link, request_link, open_link, close_requested, link_status};
}

// ---- Monitoring ----

static void report_stale(subsystem_t* const subsystem, subsystem_link_t* const link)
{
    if (!link->is_stale_reported) {
        link->is_stale_reported = true;
        change_state(subsystem, link, LINK_STALE, PUS_LINK_REASON_STALE);
        if (link->port->is_required) {
            report_lost(subsystem, false);
        }
    }
}

/// True if an opened link has not delivered its first sample within the maximum age of samples.
static bool is_overdue(const subsystem_t* const subsystem, const subsystem_link_t* const link)
{
    return (subsystem->now_ns - link->opened_ns) > (rtlink_consumer_max_age_us(&link->consumer) * 1000U);
}

static void watch_consumer(subsystem_t* const subsystem, subsystem_link_t* const link)
{
    const status_t status = rtlink_consumer_read(&link->consumer, subsystem->now_ns);
    if ((status == STATUS_STALE) || ((status == STATUS_EMPTY) && is_overdue(subsystem, link))) {
        report_stale(subsystem, link);
    } else if ((status == STATUS_OK) && link->is_stale_reported) {
        link->is_stale_reported = false;
        change_state(subsystem, link, LINK_OPEN, PUS_LINK_REASON_NONE);
    } else {
        // The samples are fresh, or the first one is not overdue yet.
    }
    // States below PRE_OPERATIONAL have no links.
    const bool is_live      = (subsystem->machine.state <= STATE_OPERATIONAL);
    const bool peer_is_lost = (status == STATUS_OK) && (link->consumer.peer_state == STATE_ERROR_OPERATIONAL);
    if (is_live && peer_is_lost && link->port->is_required) {
        subsystem_machine_event(subsystem, EVENT_NETWORK_FAILED, CAUSE_NETWORK, 0U);
        subsystem_raise_named(subsystem, "NETWORK_FAILED");
    }
}

void subsystem_watch_links(subsystem_t* const subsystem)
{
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        subsystem_link_t* const link = &subsystem->links[i];
        if (!link->is_used) {
            continue;
        }
        if ((link->state == LINK_ACCEPTED) &&
            ((subsystem->now_ns - link->accepted_ns) > ACCEPT_DEADLINE_NS)) {
            close_link(subsystem, link, PUS_LINK_REASON_DEADLINE);
        } else if (!link->is_producer && ((link->state == LINK_OPEN) || (link->state == LINK_STALE))) {
            watch_consumer(subsystem, link);
        } else {
            // An accepted link may still be opened, and a producer receives no samples.
        }
    }
}

bool subsystem_has_required_links(subsystem_t* const subsystem, uint16_t* const out_missing_port)
{
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    if (configuration == NULL) {
        return true; // The state machine refuses the request, because no configuration is applied.
    }
    for (uint16_t i = 0U; i < configuration->port_count; i++) {
        const descriptor_port_t* const port = &subsystem->descriptor->ports[configuration->first_port + i];
        const subsystem_link_t* const link  = subsystem_link_of(subsystem, port->id);
        const bool is_fresh = (link != NULL) && (link->state == LINK_OPEN) && link->consumer.has_sample;
        if (port->is_required && !is_fresh) {
            *out_missing_port = port->id;
            return false;
        }
    }
    return true;
}

void subsystem_link_datagram(subsystem_t* const subsystem, const uint8_t* const frame, const size_t size)
{
    FSW_ASSERT((subsystem != NULL) && (frame != NULL));
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        subsystem_link_t* const link = &subsystem->links[i];
        // Octets 4 and 5 of a frame are its link id (link_frame.h).
        const bool is_addressee = link->is_used && !link->is_producer && (size >= 6U) &&
                                  (link->link == (uint16_t)(((uint16_t)frame[4] << 8U) | frame[5]));
        if (is_addressee) {
            (void)rtlink_consumer_deliver(&link->consumer, frame, size);
        }
    }
}

// ---- Called by specific subsystems (subsystem.h) ----

/// Convert a payload between host order and the byte order of the link, field by field.
static void swap_payload(const subsystem_t* const subsystem, const descriptor_port_t* const port,
                         uint8_t* const payload)
{
    size_t offset = 0U;
    for (uint16_t i = 0U; i < port->field_count; i++) {
        const descriptor_field_t* const field = &subsystem->descriptor->fields[port->first_field + i];
        const size_t size                     = value_size(field->type);
        for (uint16_t k = 0U; k < field->count; k++) {
            for (size_t low = 0U; low < (size / 2U); low++) {
                const uint8_t octet               = payload[offset + low];
                payload[offset + low]             = payload[offset + size - 1U - low];
                payload[offset + size - 1U - low] = octet;
            }
            offset += size;
        }
    }
}

static bool has_port(const subsystem_t* const subsystem, const uint16_t port)
{
    return (subsystem->configuration != NULL) &&
           (descriptor_find_port(subsystem->descriptor, subsystem->configuration, port) != NULL);
}

static bool is_open_end(const subsystem_link_t* const link, const bool is_producer)
{
    return (link->is_producer == is_producer) && ((link->state == LINK_OPEN) || (link->state == LINK_STALE));
}

status_t subsystem_link_read(subsystem_t* const subsystem, const uint16_t port, void* const payload,
                             const size_t size)
{
    FSW_ASSERT((subsystem != NULL) && (payload != NULL));
    subsystem_link_t* const link = subsystem_link_of(subsystem, port);
    if (!has_port(subsystem, port)) {
        return STATUS_NOT_FOUND;
    }
    if ((link == NULL) || !is_open_end(link, false)) {
        return STATUS_CLOSED;
    }
    FSW_ASSERT(size == link->terms.layout_octets);
    const status_t status = rtlink_consumer_read(&link->consumer, subsystem->now_ns);
    if ((status == STATUS_OK) || (status == STATUS_STALE)) {
        (void)memcpy(payload, link->consumer.payload, size);
        if (link->terms.order != (uint8_t)rtlink_native_order()) {
            swap_payload(subsystem, link->port, (uint8_t*)payload);
        }
    }
    return status;
}

state_t subsystem_link_peer_state(const subsystem_t* const subsystem, const uint16_t port)
{
    const subsystem_link_t* const link = subsystem_link_of((subsystem_t*)subsystem, port);
    return ((link != NULL) && link->consumer.has_sample) ? (state_t)link->consumer.peer_state : STATE_OFFLINE;
}

uint32_t subsystem_link_age_us(const subsystem_t* const subsystem, const uint16_t port)
{
    const subsystem_link_t* const link = subsystem_link_of((subsystem_t*)subsystem, port);
    if ((link == NULL) || !link->consumer.has_sample) {
        return UINT32_MAX;
    }
    const uint64_t sample_ns = link->consumer.sample_time_ns; // The producer's clock may be slightly ahead.
    const uint64_t age_us = (subsystem->now_ns > sample_ns) ? ((subsystem->now_ns - sample_ns) / 1000U) : 0U;
    return (age_us < UINT32_MAX) ? (uint32_t)age_us : UINT32_MAX;
}

status_t subsystem_link_write(subsystem_t* const subsystem, const uint16_t port, const void* const payload,
                              const size_t size)
{
    FSW_ASSERT((subsystem != NULL) && (payload != NULL));
    if (!has_port(subsystem, port)) {
        return STATUS_NOT_FOUND;
    }
    status_t status = STATUS_CLOSED;
    for (subsystem_link_t* link = subsystem_link_of(subsystem, port); link != NULL;
         link                   = subsystem_link_next(subsystem, link, port)) {
        if (is_open_end(link, true)) { // A link of a producer is never stale.
            FSW_ASSERT(size == link->terms.layout_octets);
            (void)rtlink_producer_write(&link->producer, (uint8_t)subsystem->machine.state, subsystem->now_ns,
                                        (const uint8_t*)payload);
            status = STATUS_OK;
        }
    }
    return status;
}

void subsystem_link_totals(const subsystem_t* const subsystem, subsystem_link_totals_t* const out_totals)
{
    FSW_ASSERT((subsystem != NULL) && (out_totals != NULL));
    *out_totals = subsystem->closed_links;
    for (size_t i = 0U; i < SUBSYSTEM_LINKS; i++) {
        add_counters(out_totals, &subsystem->links[i]);
    }
}
