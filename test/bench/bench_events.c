// SPDX-License-Identifier: Apache-2.0
// Time of an event: first of a reported event, compared with the same report without the table of events and
// their limits; then of an event that its limit suppresses during a storm, compared with a reported event.
#include "pus/st05/st05_events.h"
#include "pus/core/tailoring.h"
#include "test/bench/measure.h"

#include <stdlib.h>

#define WORK 1000U
#define EVENTS 48U
#define SEVERITIES 4U
#define AUX_OCTETS 4U
/// Index of the first event without a limit. There is one of each severity, INFORMATIVE first.
#define CALM (EVENTS - SEVERITIES)
#define STORM 1U ///< Event with a limit.
#define NOW_NS 1000000000ULL

static pus_app_process_t process;
static pus_report_queues_t report_queues;
static pus_events_t events;
static pus_event_definition_t definitions[EVENTS];
static pus_event_state_t states[EVENTS];
static const uint8_t aux[AUX_OCTETS] = {1U, 2U, 3U, 4U};
static volatile uint32_t sink;

static status_t swallow(void* context, const uint8_t* packet, size_t size)
{
    (void)context;
    sink = (uint32_t)(packet[0] + size);
    return STATUS_OK;
}

static void raise(uint16_t id)
{
    if (pus_event_raise(&events, id, aux, sizeof aux, NOW_NS) != STATUS_OK) {
        abort();
    }
}

static void by_event(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        raise(definitions[CALM + (i % SEVERITIES)].id);
    }
}

static void by_report(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        octet_writer_t writer =
            pus_tm_begin(&process, 5U, (uint8_t)(1U + (i % SEVERITIES)), PUS_USER_GROUND, NOW_NS);
        octet_write_u16(&writer, definitions[CALM + (i % SEVERITIES)].id);
        octet_write_octets(&writer, aux, sizeof aux);
        if (pus_tm_post(&process, &writer) != STATUS_OK) {
            abort();
        }
    }
}

static void by_storm(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        raise(STORM);
    }
}

int main(void)
{
    const pus_port_t port = {NULL, swallow};
    pus_app_process_init(&process, 16U, 0U, &port);
    pus_app_process_keep(&process, &report_queues);
    for (uint16_t i = 0U; i < EVENTS; i++) {
        definitions[i] = (pus_event_definition_t){.id          = (uint16_t)(i + STORM),
                                                  .severity    = PUS_SEVERITY_INFORMATIVE,
                                                  .burst       = PUS_EVENT_BURST,
                                                  .aux_size    = AUX_OCTETS,
                                                  .interval_ms = (i < CALM) ? PUS_EVENT_INTERVAL_MS : 0U};
        if (i >= CALM) {
            definitions[i].severity = (uint8_t)(1U + (i - CALM));
        }
    }
    pus_events_init(&events, &process, definitions, states, EVENTS);
    measure_compare("event_reported", by_event, by_report, WORK, "ns", 1.0);
    measure_compare("event_beyond_its_limit", by_storm, by_event, WORK, "ns", 1.0);
    return 0;
}
