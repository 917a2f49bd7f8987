// SPDX-License-Identifier: Apache-2.0
#include "pus/st05/st05_events.h"

#include "base/assertion.h"
#include "generated/pus/st05_request_formats.h"
#include "pus/private/st129_management.h"

#define NS_PER_MS 1000000ULL

enum {
    DISABLED_LIST = 8
};

void pus_events_init(pus_events_t* const events, pus_app_process_t* const process,
                     const pus_event_definition_t* const definitions, pus_event_state_t* const states,
                     const uint16_t count)
{
    FSW_ASSERT((events != NULL) && (process != NULL) &&
               (((definitions != NULL) && (states != NULL)) || (count == 0U)));
    *events =
        (pus_events_t){.process = process, .definitions = definitions, .states = states, .count = count};
    for (uint16_t i = 0U; i < count; i++) {
        FSW_ASSERT((definitions[i].severity >= PUS_SEVERITY_INFORMATIVE) &&
                   (definitions[i].severity <= PUS_SEVERITY_HIGH));
        states[i] = (pus_event_state_t){0};
    }
}

/// Returns the index of an event, or `count` if the id is unknown.
static uint16_t index_of(const pus_events_t* const events, const uint16_t event_id)
{
    uint16_t index = 0U;
    while ((index < events->count) && (events->definitions[index].id != event_id)) {
        index++;
    }
    return index;
}

static status_t report(const pus_events_t* const events, const pus_event_definition_t* const definition,
                       const uint8_t* const aux, const size_t aux_size, const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(events->process, PUS_SERVICE_EVENTS, definition->severity, PUS_USER_GROUND, now_ns);
    octet_write_u16(&writer, definition->id);
    if (aux_size > 0U) {
        octet_write_octets(&writer, aux, aux_size);
    }
    return pus_tm_post(events->process, &writer);
}

/// Send the notice of a disabled event. TC[5,6] disables only the report: recovery plans and ST[19] react to
/// the notice.
static status_t notice(const pus_events_t* const events, const pus_event_definition_t* const definition,
                       const uint64_t now_ns)
{
    const pus_event_notice_t content = {.event = definition->id, .severity = definition->severity};
    return pus_event_notice_report(events->process, &content, now_ns);
}

/// True if the event passes the limiter; due_ms then increases by an interval. Times are compared modulo 2^32
/// ms: a due_ms that seems to be further in the future than a whole burst is in the past.
static bool passes(const pus_events_t* const events, const pus_event_definition_t* const definition,
                   pus_event_state_t* const state, const uint64_t now_ns)
{
    if (definition->severity == (uint8_t)PUS_SEVERITY_HIGH) {
        return !pus_app_process_keeps_event(events->process, definition->id);
    }
    if (definition->interval_ms == 0U) {
        return true;
    }
    const uint32_t now_ms = (uint32_t)(now_ns / NS_PER_MS);
    const uint32_t most   = (uint32_t)definition->interval_ms * definition->burst;
    const uint32_t ahead  = state->due_ms - now_ms;
    const uint32_t used   = (ahead <= most) ? ahead : 0U;
    if ((used + definition->interval_ms) > most) {
        return false;
    }
    state->due_ms = now_ms + used + definition->interval_ms;
    return true;
}

void pus_events_report_suppressed_by(pus_events_t* const events, const uint16_t event_id)
{
    FSW_ASSERT(events != NULL);
    events->reporter_id = event_id;
}

/// Returns the index of the next event with suppressed occurrences, after the event that was reported last.
/// The caller has checked that there is such an event.
static uint16_t next_suppressed(const pus_events_t* const events)
{
    uint16_t index = (uint16_t)((events->last_reported + 1U) % events->count);
    while ((index != events->last_reported) && (events->states[index].suppressed == 0U)) {
        index = (uint16_t)((index + 1U) % events->count);
    }
    return index;
}

bool pus_events_step(pus_events_t* const events, const uint64_t now_ns)
{
    FSW_ASSERT(events != NULL);
    if ((events->reporter_id == 0U) || (events->unreported == 0U)) {
        return false;
    }
    if (now_ns < events->next_report_ns) {
        return true;
    }
    const uint16_t index           = next_suppressed(events);
    pus_event_state_t* const state = &events->states[index];
    uint8_t octets[PUS_SUPPRESSED_AUX];
    octets_put_u16(octets, events->definitions[index].id);
    octets_put_u32(&octets[sizeof(uint16_t)], state->suppressed);
    if (pus_event_raise(events, events->reporter_id, octets, sizeof octets, now_ns) == STATUS_OK) {
        state->suppressed     = 0U;
        events->last_reported = index;
        events->unreported--;
    }
    events->next_report_ns = now_ns + PUS_SUPPRESSED_REPORT_NS;
    return events->unreported > 0U;
}

status_t pus_event_raise(pus_events_t* const events, const uint16_t event_id, const uint8_t* const aux,
                         const size_t aux_size, const uint64_t now_ns)
{
    FSW_ASSERT((events != NULL) && ((aux != NULL) || (aux_size == 0U)));
    const uint16_t index = index_of(events, event_id);
    if (index >= events->count) {
        events->counters.refused++;
        return STATUS_NOT_FOUND;
    }
    const pus_event_definition_t* const definition = &events->definitions[index];
    if (definition->aux_size != aux_size) {
        events->counters.refused++;
        return STATUS_INVALID;
    }
    events->states[index].raised++;
    if (!passes(events, definition, &events->states[index], now_ns)) {
        events->unreported =
            (uint16_t)(events->unreported + ((events->states[index].suppressed == 0U) ? 1U : 0U));
        events->states[index].suppressed++;
        events->counters.suppressed++;
        return STATUS_OK;
    }
    const bool is_disabled = events->states[index].is_disabled;
    const status_t status =
        is_disabled ? notice(events, definition, now_ns) : report(events, definition, aux, aux_size, now_ns);
    if (status != STATUS_OK) {
        events->counters.refused++;
        return STATUS_EXHAUSTED;
    }
    events->counters.reported += is_disabled ? 0U : 1U;
    events->counters.disabled += is_disabled ? 1U : 0U;
    return STATUS_OK;
}

static pus_reply_t set_disabled(pus_events_t* const events, pus_request_t* const request,
                                const bool is_disabled)
{
    const uint8_t count = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint16_t event_id = octet_read_u16(&request->reader);
        const uint16_t index    = index_of(events, event_id);
        if (index >= events->count) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, event_id);
        } else {
            pus_request_perform(request);
            events->states[index].is_disabled = is_disabled;
        }
    }
    return pus_done();
}

static pus_reply_t enable(void* const self, pus_request_t* const request)
{
    return set_disabled(self, request, false);
}

static pus_reply_t disable(void* const self, pus_request_t* const request)
{
    return set_disabled(self, request, true);
}

static pus_reply_t report_disabled(void* const self, pus_request_t* const request)
{
    pus_events_t* const events = self;
    uint16_t count             = 0U;
    for (uint16_t i = 0U; i < events->count; i++) {
        count = (uint16_t)(count + (events->states[i].is_disabled ? 1U : 0U));
    }
    if (count > ((PUS_TM_DATA_MAX - sizeof(uint16_t)) / sizeof(uint16_t))) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, (PUS_TM_DATA_MAX - sizeof(uint16_t)) / sizeof(uint16_t));
    }
    pus_request_perform(request);
    octet_writer_t writer = pus_answer_begin(request, DISABLED_LIST);
    octet_write_u16(&writer, count);
    for (uint16_t i = 0U; i < events->count; i++) {
        if (events->states[i].is_disabled) {
            octet_write_u16(&writer, events->definitions[i].id);
        }
    }
    (void)pus_tm_post(events->process, &writer); // The process counts lost reports.
    return pus_done();
}

pus_service_t pus_events_service(pus_events_t* const events)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(5, 5, enable),
        PUS_REQUEST(5, 6, disable),
        PUS_REQUEST(5, 7, report_disabled),
    };
    return pus_service_of(PUS_SERVICE_EVENTS, subtypes, sizeof subtypes / sizeof subtypes[0], events);
}
