// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_counters.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

typedef struct {
    const char* name; // In the descriptor.
    uint32_t value;
} counter_t;

static void collect(const drives_t* const drives, const uint32_t limited,
                    counter_t out_counters[DRIVES_COUNTERS])
{
    const canopen_master_counters_t* const master = &drives->network.master.counters;
    canopen_network_bus_counters_t bus;
    canopen_network_bus_counters(&drives->network, &bus);
    subsystem_link_totals_t links;
    subsystem_link_totals(drives->generic, &links);
    subsystem_health_t health;
    subsystem_health(drives->generic, &health);
    const counter_t counters[DRIVES_COUNTERS] = {
        {"CYCLES", subsystem_cycle(drives->generic)},
        {"FRAMES_RECEIVED", bus.received},
        {"FRAMES_SENT", bus.sent},
        {"FRAMES_REFUSED", master->unknown + master->malformed + master->remote},
        {"EMERGENCIES", master->emergencies},
        {"TRANSMIT_FULL", bus.full},
        {"COMMAND_LIMITED", limited + drives_limited(drives)},
        {"LINK_LOST", links.lost},
        {"LINK_STALE", links.late},
        {"LINK_REFUSED", links.refused},
        {"TC_REFUSED", health.requests_refused},
        {"PARAMETER_REFUSED", health.parameters_refused},
        {"POOL_PEAK", health.pool_peak},
        {"POOL_REFUSED", health.pool_refused},
        {"EVENTS_SUPPRESSED", health.events_suppressed},
        {"REPORTS_LOST", health.reports_lost},
        {"CHANNEL", drives->network.channel},
        {"ERROR_FRAMES", bus.errors},
        {"BUS_OFF", bus.bus_offs},
        {"BUS_RESTARTS", bus.restarts},
        {"NO_ACKNOWLEDGE", bus.missing_acknowledges},
        {"TRANSMIT_TIMEOUTS", bus.transmit_timeouts},
        {"ARBITRATIONS_LOST", bus.lost_arbitrations},
        {"RECEIVE_OVERRUNS", bus.overruns},
        {"BUS_LOST", bus.lost},
        {"TRANSMIT_REFUSED", bus.refused},
        {"FOREIGN_SYNCS", master->foreign_syncs},
    };
    (void)memcpy(out_counters, counters, sizeof counters);
}

/// The field of a name, or null.
static const parameter_field_t* find(const parameter_definition_t* const definition, const char* const name)
{
    for (uint16_t i = 0U; i < definition->field_count; i++) {
        const parameter_field_t* const field = &definition->fields[i];
        if ((field->type == VALUE_UINT32) && (strcmp(field->name, name) == 0)) {
            return field;
        }
    }
    return NULL;
}

void drives_counters_place(drives_t* const drives, const parameter_definition_t* const definition,
                           void* const storage)
{
    FSW_ASSERT((drives != NULL) && (definition != NULL) && (storage != NULL));
    uint8_t* const octets = storage;
    counter_t counters[DRIVES_COUNTERS];
    collect(drives, 0U, counters);
    for (unsigned i = 0U; i < DRIVES_COUNTERS; i++) {
        const parameter_field_t* const field = find(definition, counters[i].name);
        drives->counters.places[i]           = (field != NULL) ? &octets[field->offset] : NULL;
    }
    const parameter_field_t* const missed = find(definition, "PDO_MISSED");
    drives->counters.missed               = (missed != NULL) ? &octets[missed->offset] : NULL;
    drives->counters.missed_count         = (missed != NULL) ? missed->count : 0U;
}

void drives_counters_publish(drives_t* const drives, const uint32_t limited)
{
    FSW_ASSERT(drives != NULL);
    counter_t counters[DRIVES_COUNTERS];
    collect(drives, limited, counters);
    for (unsigned i = 0U; i < DRIVES_COUNTERS; i++) {
        if (drives->counters.places[i] != NULL) {
            (void)memcpy(drives->counters.places[i], &counters[i].value, sizeof counters[i].value);
        }
    }
    for (uint16_t i = 0U; i < drives->counters.missed_count; i++) {
        const uint32_t missed = drives_missed(drives, i);
        (void)memcpy(&drives->counters.missed[i * sizeof missed], &missed, sizeof missed);
    }
}
