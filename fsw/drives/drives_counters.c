// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_counters.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

typedef struct { // All counters at one instant.
    canopen_master_counters_t master;
    canopen_network_bus_counters_t bus;
    subsystem_link_totals_t links;
    subsystem_health_t health;
    uint32_t cycles;
    uint32_t refused;
    uint32_t limited;
    uint32_t pool_peak;
    uint32_t channel;
} counts_t;

static const struct {
    const char* name; // Name in the descriptor.
    size_t offset;    // Offset of a uint32_t in counts_t.
} counters[DRIVES_COUNTERS] = {
    {"CYCLES", offsetof(counts_t, cycles)},
    {"FRAMES_RECEIVED", offsetof(counts_t, bus.received)},
    {"FRAMES_SENT", offsetof(counts_t, bus.sent)},
    {"FRAMES_REFUSED", offsetof(counts_t, refused)},
    {"EMERGENCIES", offsetof(counts_t, master.emergencies)},
    {"TRANSMIT_FULL", offsetof(counts_t, bus.full)},
    {"COMMAND_LIMITED", offsetof(counts_t, limited)},
    {"LINK_LOST", offsetof(counts_t, links.lost)},
    {"LINK_STALE", offsetof(counts_t, links.late)},
    {"LINK_REFUSED", offsetof(counts_t, links.refused)},
    {"TC_REFUSED", offsetof(counts_t, health.requests_refused)},
    {"PARAMETER_REFUSED", offsetof(counts_t, health.parameters_refused)},
    {"POOL_PEAK", offsetof(counts_t, pool_peak)},
    {"POOL_REFUSED", offsetof(counts_t, health.pool_refused)},
    {"EVENTS_SUPPRESSED", offsetof(counts_t, health.events_suppressed)},
    {"REPORTS_LOST", offsetof(counts_t, health.reports_lost)},
    {"CHANNEL", offsetof(counts_t, channel)},
    {"ERROR_FRAMES", offsetof(counts_t, bus.errors)},
    {"BUS_OFF", offsetof(counts_t, bus.bus_offs)},
    {"BUS_RESTARTS", offsetof(counts_t, bus.restarts)},
    {"NO_ACKNOWLEDGE", offsetof(counts_t, bus.missing_acknowledges)},
    {"TRANSMIT_TIMEOUTS", offsetof(counts_t, bus.transmit_timeouts)},
    {"ARBITRATIONS_LOST", offsetof(counts_t, bus.lost_arbitrations)},
    {"RECEIVE_OVERRUNS", offsetof(counts_t, bus.overruns)},
    {"BUS_LOST", offsetof(counts_t, bus.lost)},
    {"TRANSMIT_REFUSED", offsetof(counts_t, bus.refused)},
    {"CONFLICTING_SYNCS", offsetof(counts_t, master.conflicting_syncs)},
};

/// Returns the UINT32 field with this name; null if there is none.
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

void drives_counters_bind(drives_t* const drives, const parameter_definition_t* const definition,
                          void* const storage)
{
    FSW_ASSERT((drives != NULL) && (definition != NULL) && (storage != NULL));
    uint8_t* const octets = storage;
    for (unsigned i = 0U; i < DRIVES_COUNTERS; i++) {
        const parameter_field_t* const field = find(definition, counters[i].name);
        drives->counters.values[i]           = (field != NULL) ? &octets[field->offset] : NULL;
    }
    const parameter_field_t* const missed = find(definition, "PDO_MISSED");
    drives->counters.missed               = (missed != NULL) ? &octets[missed->offset] : NULL;
    drives->counters.missed_count         = (missed != NULL) ? missed->count : 0U;
}

static void add_master(const canopen_master_counters_t* const master, canopen_master_counters_t* const sum)
{
    sum->unknown += master->unknown;
    sum->malformed += master->malformed;
    sum->remote += master->remote;
    sum->conflicting_syncs += master->conflicting_syncs;
    sum->emergencies += master->emergencies;
}

void drives_counters_publish(drives_t* const drives, const uint32_t limited)
{
    FSW_ASSERT(drives != NULL);
    counts_t counts = {.cycles  = subsystem_cycle(drives->generic),
                       .limited = limited + drives_limited(drives),
                       .channel = drives->buses[0].network.channel}; // All buses use the same channel.
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        add_master(&drives->buses[i].network.master.counters, &counts.master);
        canopen_network_add_counters(&drives->buses[i].network, &counts.bus);
    }
    subsystem_link_totals(drives->generic, &counts.links);
    subsystem_health(drives->generic, &counts.health);
    counts.refused   = counts.master.unknown + counts.master.malformed + counts.master.remote;
    counts.pool_peak = counts.health.pool_peak;
    for (unsigned i = 0U; i < DRIVES_COUNTERS; i++) {
        if (drives->counters.values[i] != NULL) {
            const uint8_t* const count = &((const uint8_t*)&counts)[counters[i].offset];
            (void)memcpy(drives->counters.values[i], count, sizeof(uint32_t));
        }
    }
    for (uint16_t i = 0U; i < drives->counters.missed_count; i++) {
        const uint32_t missed = drives_missed(drives, i);
        (void)memcpy(&drives->counters.missed[i * sizeof missed], &missed, sizeof missed);
    }
}
